//! What is taken away, and what comes late.

use super::{
    Act, NAN, alone, bundle, pins,
    rows::Fate::{self, GoesOn, Runs},
    told, world,
};
use crate::support::app::*;
use bevy::{mesh::VertexAttributeValues, prelude::*};
use bevy_drape::{
    ClothError, ClothErrorKind, ClothExecution, ClothInterpolation, ClothWindOverride, MeshProblem,
    PinProblem, prelude::*,
};

/// What is taken away is as if the component had never been given: its default.
#[test]
fn components_that_are_taken_away() {
    let table: [(&str, Act, Fate); 7] = [
        ("ClothMaterial", Box::new(|e| _ = e.remove::<ClothMaterial>()), GoesOn),
        ("ClothSettings", Box::new(|e| _ = e.remove::<ClothSettings>()), GoesOn),
        ("ClothInterpolation", Box::new(|e| _ = e.remove::<ClothInterpolation>()), GoesOn),
        ("Visibility", Box::new(|e| _ = e.remove::<Visibility>()), GoesOn),
        ("Mesh3d", Box::new(|e| _ = e.remove::<Mesh3d>()), GoesOn),
        ("ClothAir", Box::new(|e| _ = e.remove::<ClothAir>()), Runs),
        ("ClothPins", Box::new(|e| _ = e.remove::<ClothPins>()), Runs),
    ];
    let (mut app, good) = world();
    let cloths: Vec<_> = table
        .iter()
        .map(|(_, take, _)| {
            let early = spawn(&mut app, bundle());
            take(&mut app.world_mut().entity_mut(early));
            [early, spawn(&mut app, bundle())]
        })
        .collect();
    updates(&mut app, 12);
    for ((_, take, _), [_, late]) in table.iter().zip(&cloths) {
        take(&mut app.world_mut().entity_mut(*late));
    }
    updates(&mut app, 12);
    for ((what, _, fate), pair) in table.iter().zip(&cloths) {
        for &entity in pair {
            assert_eq!(failure(&app, entity), None, "{what}");
            let running = app.world().get::<ClothSimulation>(entity);
            let running = running.unwrap_or_else(|| panic!("{what}: it never started"));
            assert_eq!(running.tick_count(), 24, "{what}");
            assert_eq!(running.pinned().is_empty(), *what == "ClothPins", "{what}");
            assert_eq!(bits(&app, entity) == bits(&app, good), *fate == GoesOn, "{what}");
        }
    }
    // What was there is not what stays.
    let stiff = ClothMaterial { area_density: 3.0, ..default() };
    let material = spawn(&mut app, (bundle(), stiff));
    updates(&mut app, 2);
    let mass = simulation(&app, material).mass(9).unwrap();
    app.world_mut().entity_mut(material).remove::<ClothMaterial>();
    updates(&mut app, 2);
    let now = simulation(&app, material).mass(9).unwrap();
    assert!((now / mass - 0.2 / 3.0).abs() < 1e-3, "{mass} kg, then {now} kg");
    assert!(
        bits(&app, good) == {
            let (mut app, good) = world();
            updates(&mut app, 28);
            bits(&app, good)
        }
    );
}

#[test]
fn a_place_that_is_lost_is_told_and_lets_go() {
    let lose: [fn(&mut App, Entity); 2] = [
        |app, cloth| _ = app.world_mut().entity_mut(cloth).remove::<Transform>(),
        |app, cloth| {
            let parent = spawn(app, ());
            app.world_mut().entity_mut(cloth).insert(ChildOf(parent));
        },
    ];
    let (mut app, good) = world();
    let early = lose.map(|lose| {
        let cloth = spawn(&mut app, bundle());
        lose(&mut app, cloth);
        cloth
    });
    let late = lose.map(|_| spawn(&mut app, bundle()));
    updates(&mut app, 8);
    for (lose, cloth) in lose.iter().zip(late) {
        lose(&mut app, cloth);
    }
    updates(&mut app, 8);
    for cloth in early {
        assert_eq!(
            told(&app, cloth, "early"),
            ClothError { entity: cloth, kind: ClothErrorKind::NoTransform }
        );
        assert!(app.world().get::<ClothSimulation>(cloth).is_none());
    }
    for cloth in late {
        let error = told(&app, cloth, "late");
        let lost = PinProblem::NoAnchor(cloth);
        assert!(
            matches!(error, ClothError { kind: ClothErrorKind::Pin { problem, .. }, .. } if problem == lost),
            "{error}"
        );
        assert!(simulation(&app, cloth).pinned().is_empty());
        assert_eq!(simulation(&app, cloth).tick_count(), 16);
    }
    for cloth in early.into_iter().chain(late) {
        let mut entity = app.world_mut().entity_mut(cloth);
        entity.remove::<ChildOf>().insert((Transform::default(), pins()));
    }
    updates(&mut app, 8);
    for cloth in early.into_iter().chain(late) {
        assert_eq!(failure(&app, cloth), None);
        assert_eq!(simulation(&app, cloth).pinned().len(), 8);
    }
    assert!(bits(&app, good) == alone(24));
}

#[test]
fn resources_that_are_taken_away_are_as_by_default() {
    let (mut app, good) = world();
    let wind = *app.world().resource::<ClothWind>();
    app.world_mut().entity_mut(good).insert(ClothWindOverride(wind));
    updates(&mut app, 8);
    app.world_mut().remove_resource::<ClothGravity>();
    app.world_mut().remove_resource::<ClothWind>();
    app.world_mut().remove_resource::<ClothExecution>();
    let still = spawn(&mut app, bundle());
    updates(&mut app, 12);
    assert_eq!((failure(&app, good), failure(&app, still)), (None, None));
    assert!(bits(&app, good) == alone(20));
    assert_eq!(simulation(&app, still).tick_count(), 12);
}

fn set_positions(app: &mut App, mesh: &Handle<Mesh>, to: impl Fn(&mut [[f32; 3]])) {
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let mut mesh = meshes.get_mut(mesh).expect("it is there");
    match mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION) {
        Some(VertexAttributeValues::Float32x3(positions)) => to(positions),
        _ => panic!("it has positions"),
    }
}

/// Meshes that come late, or are mended where they are: nothing on the entity changes.
#[test]
fn meshes_mended_in_place() {
    let (mut app, good) = world();
    let sound = grid_mesh(3, 4, |v| v, |r, c| Vec3::new(c as f32, 0.0, r as f32));
    let bent = add_mesh(&mut app, sound.clone());
    set_positions(&mut app, &bent, |p| p[5][1] = NAN);
    let hollow = add_mesh(&mut app, box_mesh(0.3));
    set_positions(&mut app, &hollow, |p| p[2][0] = NAN);
    let late = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let cloths = [&bent, &late].map(|mesh| {
        let mesh = Mesh3d(mesh.clone());
        spawn(&mut app, (Cloth::of_mesh3d(), mesh, Transform::from_xyz(30.0, 0.0, 0.0)))
    });
    let bake = BakeSdf::with_cells(4);
    let place = Transform::from_xyz(0.0, -40.0, 0.0);
    let colliders = [&hollow, &late].map(|mesh| {
        let bake = BakeSdf { mesh: Some(mesh.clone()), ..bake.clone() };
        spawn(&mut app, (bake, place))
    });
    updates(&mut app, 5);
    let problem = |app: &App, entity| match told(app, entity, "mesh") {
        ClothError { kind: ClothErrorKind::Mesh(problem), .. }
        | ClothError { kind: ClothErrorKind::ColliderMesh(problem), .. } => problem,
        other => panic!("{other}"),
    };
    assert_eq!(cloths.map(|c| problem(&app, c)), [MeshProblem::NonFinite(5), MeshProblem::Missing]);
    let found = colliders.map(|c| problem(&app, c));
    assert_eq!(found, [MeshProblem::NonFinite(2), MeshProblem::Missing]);
    assert!(cloths.iter().all(|&c| app.world().get::<ClothSimulation>(c).is_none()));
    set_positions(&mut app, &bent, |p| p[5][1] = 0.0);
    set_positions(&mut app, &hollow, |p| p[2][0] = -0.3);
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(&late, box_mesh(0.2)).unwrap();
    updates(&mut app, 5);
    assert_eq!(cloths.map(|c| failure(&app, c)), [None, None]);
    assert_eq!(cloths.map(|c| simulation(&app, c).particle_count()), [12, 8]);
    wait(&mut app, |app| colliders.iter().all(|&c| app.world().get::<SdfCollider>(c).is_some()));
    assert_eq!(colliders.map(|c| failure(&app, c)), [None, None]);
    let ticks = simulation(&app, good).tick_count();
    let mut same = world();
    updates(&mut same.0, ticks as usize);
    assert!(bits(&app, good) == bits(&same.0, same.1));
}
