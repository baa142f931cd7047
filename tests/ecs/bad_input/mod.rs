//! Bad input for every public item of the plugin: NaN, infinite, negative, zero, empty, huge, missing. It is
//! told to its own entity, by name and with what to do; nothing panics, nothing becomes NaN; the rest of the
//! world goes on in the same bits as without it; and what is mended works.
//!
//! What is in the files here, and what stands in a table elsewhere:
//!
//! | items | where |
//! | --- | --- |
//! | `ClothMaterial`, `ClothSettings`, `ClothCulling`, `ClothSleepThreshold`, `ClothTeleport`, `ClothInertia`, `ClothAir`, `ClothSelfCollision`, `ClothInterCollision`, `ClothGravityOverride`, `ClothWindOverride`, `ClothPins`, `Cloth::sheet`, the entity's place, one row each | `rows` |
//! | `HangOnStart`, which a running cloth does not look at | `hanging` |
//! | `WindZone`, `ClothGravity`, `ClothWind`, `ClothExecution`, `Time<Fixed>`, components and resources taken away, methods of `ClothSimulation`, `ColliderImpulse`, `ClothFailure` | `surroundings`, `missing`, `together` |
//! | `Cloth::of_mesh3d`, `ClothWeights`, colours | `intake`; meshes mended in place: `missing` |
//! | `ClothLod`, `ClothProxy` | `lod`, `proxy` |
//! | anchors that go, soft and hard | `anchors`, `pins` |
//! | `SdfCollider`, `SdfShape`, `CustomSdf`, `BakeSdf`, `SdfCells` | `bad_colliders` |
//! | `.sdf` files and their loader | `fields`; byte by byte: `tests/sdf/saved` |
//! | `TeleportCloth`, `ResetCloth`, entities that leave the world | `teleport` |
//! | `ClothPlugin` in a schedule of variable step, `MinimalPlugins` | `app` |
//! | `DistanceField::bake`; shapes asked at no point | `tests/sdf/baking`, `tests/sdf/shapes` |
//! | `ClothSolver`, `Lattice`, `Graph`, `Air`, `Wind`, `SoftPin`, `RigidMotion` | `tests/solver`: `refusals`, `graph_refusals`, `weights`, `air`, `soft`, `motion` |
//!
//! `ClothInterpolation`, `ClothPaused`, `Integrator`, `ColorChannel` and `ClothShape::Mesh` hold nothing that can be bad.

mod hanging;
mod missing;
mod rows;
mod surroundings;
mod together;

use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{
    ClothCulling, ClothError, ClothInertia, ClothInterCollision, ClothSelfCollision,
    ClothSleepThreshold, ClothTeleport, HangOnStart, prelude::*,
};
use rows::{
    Fate::{GoesOn, Runs, Stands},
    Row, rows_of_numbers, rows_of_pins, rows_of_places, rows_of_sheets, rows_of_surroundings,
};

const NAN: f32 = f32::NAN;
const INF: f32 = f32::INFINITY;
/// No length, no stiffness, no part of anything.
const HUGE: f32 = 1e30;

type Act = Box<dyn Fn(&mut EntityWorldMut)>;

fn pins() -> ClothPins {
    ClothPins::vertices((0..64).step_by(8))
}

/// What the good cloth is of. It feels everything: pins, a collider, gravity and the wind.
fn bundle() -> impl Bundle {
    (sheet(), pins(), ClothAir::default())
}

/// The same, or of a mesh that is no grid.
fn spawn_cloth(app: &mut App, graph: bool) -> Entity {
    let cloth = spawn(app, bundle());
    if graph {
        let mesh = Mesh3d(add_mesh(app, holed_mesh()));
        app.world_mut().entity_mut(cloth).insert((Cloth::of_mesh3d(), mesh));
    }
    cloth
}

/// A world with a good cloth in it.
fn world() -> (App, Entity) {
    world_of(false)
}

fn world_of(graph: bool) -> (App, Entity) {
    let mut app = app();
    app.insert_resource(ClothWind::steady(Vec3::new(1.0, 0.0, 2.0)));
    spawn(&mut app, (SdfCollider::from(Sphere::new(0.2)), Transform::from_xyz(0.1, -0.25, 0.0)));
    let good = spawn_cloth(&mut app, graph);
    (app, good)
}

/// Where the good cloth is after some ticks, alone in the world.
fn alone(ticks: usize) -> Vec<[u32; 3]> {
    alone_in(world(), ticks)
}

fn alone_in((mut app, good): (App, Entity), ticks: usize) -> Vec<[u32; 3]> {
    let mut meets = false;
    for _ in 0..ticks {
        updates(&mut app, 1);
        let report = simulation(&app, good).last_tick();
        meets |= report.is_some_and(|report| report.contact_count > 0);
    }
    assert_eq!(failure(&app, good), None);
    assert!(meets, "it meets the ball");
    bits(&app, good)
}

/// What the entity is told; everything by its name and with something to do.
#[track_caller]
fn told(app: &App, entity: Entity, what: &str) -> ClothError {
    let Some(failure) = app.world().get::<ClothFailure>(entity) else {
        panic!("{what}: not told");
    };
    for error in failure.errors() {
        let message = error.to_string();
        assert!(message.contains(&entity.to_string()), "{what}: {message}");
        let ways = [
            "change", "choose", "compare", "must", "insert", "paint", "until", "released", "mend",
            "add",
        ];
        let mut words = message.split(|c: char| !c.is_alphabetic());
        assert!(words.any(|word| ways.contains(&word)), "{what}: what to do? {message}");
    }
    failure.error.clone()
}

fn is_finite(app: &App, entity: Entity) -> bool {
    let drawn = attribute(drawn(app, entity), Mesh::ATTRIBUTE_POSITION);
    drawn.iter().all(|p| p.is_finite())
        && simulation(app, entity).positions().all(|p| p.is_finite() && p.length() < 10.0)
}

/// Ticks before a running cloth is spoiled, before what is told is looked at, and after all is mended.
const TICKS: [usize; 3] = [16, 6, 6];

/// Runs all rows in one world.
fn check_rows(rows: &[Row], graph: bool) {
    let (mut app, good) = world_of(graph);
    let cloths: Vec<_> = rows
        .iter()
        .map(|row| {
            let early = spawn_cloth(&mut app, graph);
            (row.spoil)(&mut app.world_mut().entity_mut(early));
            [early, spawn_cloth(&mut app, graph)]
        })
        .collect();
    updates(&mut app, TICKS[0]);
    let standing: Vec<_> = cloths.iter().map(|[_, late]| bits(&app, *late)).collect();
    for (row, [_, late]) in rows.iter().zip(&cloths) {
        assert_eq!(failure(&app, *late), None);
        (row.spoil)(&mut app.world_mut().entity_mut(*late));
    }
    updates(&mut app, TICKS[1]);
    let count = |app: &App, entity| app.world().get(entity).map_or(0, ClothSimulation::tick_count);
    for ((row, pair), standing) in rows.iter().zip(&cloths).zip(&standing) {
        for (i, (&entity, &fate)) in pair.iter().zip(&row.fates).enumerate() {
            let what = format!("{}, {}", row.what, ["from the start", "later"][i]);
            let error = told(&app, entity, &what);
            assert!((row.is)(&error), "{what}: {error:?}");
            let since = if i == 0 { count(&app, good) } else { TICKS[1] as u64 };
            let ran = count(&app, entity) - (count(&app, good) - since);
            assert_eq!(ran, if fate == Stands { 0 } else { since }, "{what}: ticks");
            match fate {
                GoesOn => assert!(bits(&app, entity) == bits(&app, good), "{what}: {error}"),
                Runs => assert!(is_finite(&app, entity), "{what}"),
                Stands if i == 1 => assert!(bits(&app, entity) == *standing, "{what}"),
                Stands => {}
            }
        }
        pair.iter().for_each(|&entity| (row.mend)(&mut app.world_mut().entity_mut(entity)));
    }
    updates(&mut app, TICKS[2]);
    for (row, pair) in rows.iter().zip(&cloths) {
        for (&entity, &fate) in pair.iter().zip(&row.fates) {
            let what = &row.what;
            assert_eq!(failure(&app, entity), None, "{what}: mended");
            assert!(count(&app, entity) >= TICKS[2] as u64, "{what}: mended, it runs");
            assert!(is_finite(&app, entity), "{what}");
            if fate == GoesOn {
                assert!(bits(&app, entity) == bits(&app, good), "{what}: mended");
            }
        }
    }
    assert_eq!(failure(&app, good), None);
    assert!(
        bits(&app, good) == alone_in(world_of(graph), TICKS.iter().sum()),
        "the good cloth has noticed"
    );
}

#[test]
fn numbers_of_cloths() {
    for graph in [false, true] {
        check_rows(&rows_of_numbers(), graph);
    }
}

/// What a component's fields of numbers are called, as its reflection has them.
fn numbers_of<T: bevy::reflect::Typed>() -> Vec<String> {
    let info = T::type_info();
    let fields = info.as_struct().expect("it has fields").iter();
    let numbers = ["f32", "f64", "u32", "usize", "Substeps", "Vec3", "Option<f32>"];
    fields
        .filter(|field| numbers.contains(&field.type_path_table().short_path()))
        .map(|field| format!("{}.{} = ", info.type_path_table().short_path(), field.name()))
        .collect()
}

#[test]
fn every_number_of_a_cloth_has_its_rows() {
    let rows = rows_of_numbers();
    let rows: Vec<_> =
        rows.into_iter().map(|row| row.what).chain(hanging::bad().map(|(what, _)| what)).collect();
    let numbers = [
        numbers_of::<ClothMaterial>(),
        numbers_of::<ClothSettings>(),
        numbers_of::<ClothAir>(),
        numbers_of::<ClothSelfCollision>(),
        numbers_of::<ClothInterCollision>(),
        numbers_of::<ClothSleepThreshold>(),
        numbers_of::<ClothCulling>(),
        numbers_of::<ClothTeleport>(),
        numbers_of::<ClothInertia>(),
        numbers_of::<HangOnStart>(),
    ];
    assert!(numbers.iter().flatten().count() >= 25, "{numbers:?}");
    for number in numbers.iter().flatten() {
        assert!(rows.iter().any(|row| row.starts_with(number)), "no row has {number}");
    }
}

#[test]
fn gravity_and_wind_of_cloths() {
    for graph in [false, true] {
        check_rows(&rows_of_surroundings(), graph);
    }
}

#[test]
fn pins_of_cloths() {
    for graph in [false, true] {
        check_rows(&rows_of_pins(), graph);
    }
}

#[test]
fn sizes_of_sheets() {
    check_rows(&rows_of_sheets(), false);
}

#[test]
fn places_of_cloths() {
    for graph in [false, true] {
        check_rows(&rows_of_places(), graph);
    }
}
