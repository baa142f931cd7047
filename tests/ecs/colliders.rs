//! Colliders are met, moved, baked, and left out when they cannot be used.

use crate::support::app::*;
use bevy::{
    ecs::entity_disabling::Disabled, math::bounding::Aabb3d, prelude::*, time::TimeUpdateStrategy,
};
use bevy_drape::{
    ClothComponent, ClothError, ClothErrorKind, ColliderImpulse, MeshProblem, SdfColliderDisabled,
    prelude::*,
    sdf::{BakeError, SdfSample, SignedDistance, shapes::ShellError},
};

fn lowest(app: &App, cloth: Entity) -> f32 {
    positions(app, cloth).iter().map(|p| p.y).fold(f32::INFINITY, f32::min)
}

/// A sheet a little above the origin.
fn above(app: &mut App, height: f32) -> Entity {
    spawn(app, (sheet(), Transform::from_xyz(0.0, height, 0.0)))
}

#[test]
fn a_cloth_drapes_over_a_sphere_and_stays_outside() {
    let mut app = app();
    spawn(&mut app, SdfCollider::from(Sphere::new(0.3)));
    let cloth = above(&mut app, 0.35);
    updates(&mut app, 64);
    for p in positions(&app, cloth) {
        assert!(p.length() > 0.3 + 0.005 - 1e-4, "{p}");
    }
    let middle = position(&app, cloth, 27);
    assert!(middle.y > 0.2 && lowest(&app, cloth) < 0.1, "{middle}");
    assert!(simulation(&app, cloth).last_tick().unwrap().contact_count > 0);
}

#[test]
fn every_kind_of_solid_carries_a_cloth() {
    for shape in [
        SdfShape::from(Cuboid::new(2.0, 2.0, 2.0)),
        Cylinder::new(1.0, 2.0).into(),
        InfinitePlane3d::default().into(),
        Capsule3d::new(1.0, 0.1).into(),
        Sphere::new(1.0).into(),
        Cone { radius: 1.0, height: 2.0 }.into(),
        Torus { minor_radius: 1.0, major_radius: 1.2 }.into(),
    ] {
        let mut app = app();
        let top = match shape {
            SdfShape::InfinitePlane3d(_) => 0.0,
            SdfShape::Capsule3d(_) => 1.05,
            _ => 1.0,
        };
        spawn(&mut app, SdfCollider::new(shape.clone()));
        let cloth = above(&mut app, top + 0.05);
        let free = spawn(&mut app, (sheet(), Transform::from_xyz(100.0, -1e3, 0.0)));
        updates(&mut app, 20);
        let highest = positions(&app, cloth).iter().map(|p| p.y).fold(f32::MIN, f32::max);
        // Twenty ticks of free fall are half a metre. The torus carries beside its middle.
        assert!(highest > top - 0.3, "{shape:?} {highest}");
        let _ = free;
    }
}

#[derive(Component)]
struct Rises(f32);

fn rise(mut rising: Query<(&mut Transform, &Rises)>) {
    for (mut transform, speed) in &mut rising {
        transform.translation.y += speed.0;
    }
}

/// How far a plane that rises by a metre in 48 ticks has pushed a cloth up.
fn pushed(fixed: bool, ticks_a_frame: u32) -> (f32, f32) {
    let mut app = app();
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(ticks_a_frame));
    let plane = (SdfCollider::from(InfinitePlane3d::default()), Rises(1.0 / 48.0));
    let plane = spawn(&mut app, plane);
    let cloth = above(&mut app, 0.006);
    if fixed {
        app.add_systems(FixedUpdate, rise);
    } else {
        app.world_mut().get_mut::<Rises>(plane).unwrap().0 *= ticks_a_frame as f32;
        app.add_systems(Update, rise);
    }
    updates(&mut app, 48 / ticks_a_frame as usize);
    let plane = transform(&mut app, plane).translation.y;
    (lowest(&app, cloth), plane)
}

#[test]
fn a_moving_collider_pushes_however_it_is_moved() {
    for ticks_a_frame in [1, 4] {
        let (cloth, plane) = pushed(true, ticks_a_frame);
        assert!((plane - 1.0).abs() < 1e-4);
        assert!((cloth - plane - 0.005).abs() < 1e-3, "{cloth} {plane}");
        let (cloth, plane) = pushed(false, ticks_a_frame);
        // The last frame's move is not yet simulated.
        let seen = plane - ticks_a_frame as f32 / 48.0;
        assert!((cloth - seen - 0.005).abs() < 1e-3, "{cloth} {seen}");
    }
}

#[test]
fn a_moving_collider_drags_by_friction() {
    let mut app = app();
    let rough = ClothMaterial { friction: 2.0, ..default() };
    let plane = SdfCollider::from(InfinitePlane3d::default()).with_friction(2.0);
    let plane = spawn(&mut app, plane);
    let cloth = spawn(&mut app, (sheet(), rough, Transform::from_xyz(0.0, 0.0051, 0.0)));
    app.add_systems(
        FixedUpdate,
        move |mut transforms: Query<&mut Transform, With<SdfCollider>>| {
            for mut transform in &mut transforms {
                transform.translation.x += 0.005;
            }
        },
    );
    updates(&mut app, 60);
    let moved = transform(&mut app, plane).translation.x;
    let dragged = position(&app, cloth, 0).x + 0.5;
    assert!((moved - 0.3).abs() < 1e-4 && dragged > 0.25 && dragged < 0.31, "{dragged}");
}

#[test]
fn colliders_are_switched_and_despawned() {
    let mut app = app();
    let floor = spawn(&mut app, SdfCollider::from(InfinitePlane3d::default()));
    let cloth = above(&mut app, 0.01);
    updates(&mut app, 20);
    assert!(lowest(&app, cloth) > 0.004);
    app.world_mut().entity_mut(floor).insert(SdfColliderDisabled);
    updates(&mut app, 10);
    assert!(lowest(&app, cloth) < -0.05);
    app.world_mut().entity_mut(floor).remove::<SdfColliderDisabled>();
    updates(&mut app, 20);
    assert!(lowest(&app, cloth) > 0.004);
    app.world_mut().despawn(floor);
    updates(&mut app, 10);
    assert!(lowest(&app, cloth) < -0.05);
}

#[test]
fn colliders_that_cannot_be_used_are_told_so_and_left_out() {
    let mut app = app();
    let uneven = Transform::from_scale(Vec3::new(1.0, 2.0, 1.0));
    let uneven = spawn(&mut app, (SdfCollider::from(Sphere::new(0.3)), uneven));
    let sticky = SdfCollider::from(Sphere::new(0.3)).with_friction(-1.0);
    let sticky = spawn(&mut app, sticky);
    let floor = Transform::from_xyz(0.0, -0.2, 0.0);
    spawn(&mut app, (SdfCollider::from(InfinitePlane3d::default()), floor));
    let cloth = above(&mut app, 0.35);
    updates(&mut app, 40);
    let error = failure(&app, uneven).unwrap();
    assert!(matches!(error, ClothError { kind: ClothErrorKind::Scale(_), .. }), "{error}");
    let error = failure(&app, sticky).unwrap();
    assert!(
        matches!(
            error,
            ClothError {
                kind: ClothErrorKind::Parameter { component: ClothComponent::SdfCollider, .. },
                ..
            }
        ),
        "{error}"
    );
    // Through the spheres, onto the floor.
    assert!(position(&app, cloth, 27).y < -0.15);
    assert_eq!(failure(&app, cloth), None);
    transform(&mut app, uneven).scale = Vec3::ONE;
    app.world_mut().get_mut::<SdfCollider>(sticky).unwrap().friction = 0.5;
    updates(&mut app, 2);
    assert_eq!(failure(&app, uneven), None);
    assert_eq!(failure(&app, sticky), None);
}

#[test]
fn a_uniform_scale_of_a_collider_is_honoured() {
    let mut app = app();
    let large = Transform::from_scale(Vec3::splat(0.3));
    spawn(&mut app, (SdfCollider::from(Sphere::new(1.0)), large));
    let cloth = above(&mut app, 0.35);
    updates(&mut app, 40);
    assert!(positions(&app, cloth).iter().all(|p| p.length() > 0.3049));
    assert!(position(&app, cloth, 27).y > 0.2);
}

/// A half-space below y = 0.1.
#[derive(Debug)]
struct Step;

impl SignedDistance for Step {
    fn sample(&self, point: Vec3) -> SdfSample {
        SdfSample { distance: point.y - 0.1, normal: Vec3::Y }
    }

    fn bounds(&self) -> Option<Aabb3d> {
        None
    }
}

#[test]
fn a_solid_may_be_ones_own() {
    let mut app = app();
    spawn(&mut app, SdfCollider::custom(Step));
    let cloth = above(&mut app, 0.15);
    updates(&mut app, 30);
    assert!((lowest(&app, cloth) - 0.105).abs() < 1e-3);
}

#[test]
fn a_closed_mesh_is_baked_and_carries() {
    let mut app = app();
    let handle = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let solid = (BakeSdf::with_cells(16), Mesh3d(handle.clone()));
    let solid = spawn(&mut app, solid);
    updates(&mut app, 3);
    assert!(app.world().get::<SdfCollider>(solid).is_none());
    let error = failure(&app, solid).expect("nothing loads it").to_string();
    assert!(error.contains("nothing loads it"), "{error}");
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(&handle, box_mesh(0.5)).unwrap();
    wait(&mut app, |app| app.world().get::<SdfCollider>(solid).is_some());
    let cloth = above(&mut app, 0.55);
    updates(&mut app, 30);
    assert!((position(&app, cloth, 27).y - 0.505).abs() < 5e-3);
    assert_eq!(failure(&app, solid), None);
    // Another mesh gives another field, and the friction stays.
    app.world_mut().get_mut::<SdfCollider>(solid).unwrap().friction = 0.9;
    let other = Mesh3d(add_mesh(&mut app, box_mesh(0.7)));
    let field = |app: &App| match &app.world().get::<SdfCollider>(solid).unwrap().shape {
        SdfShape::Field(field) => field.clone(),
        other => panic!("{other:?}"),
    };
    let old = field(&app);
    app.world_mut().entity_mut(solid).insert(other);
    wait(&mut app, |app| field(app) != old);
    assert_eq!(app.world().get::<SdfCollider>(solid).unwrap().friction, 0.9);
}

#[test]
fn meshes_that_are_no_solid_are_told_so() {
    let mut app = app();
    let open = grid_mesh(3, 3, |v| v, |r, c| Vec3::new(c as f32, 0.0, r as f32));
    let open = Mesh3d(add_mesh(&mut app, open));
    let open = spawn(&mut app, (BakeSdf::default(), open));
    let mut taken = box_mesh(1.0);
    taken.take_gpu_data().unwrap();
    let taken = Mesh3d(add_mesh(&mut app, taken));
    let taken = spawn(&mut app, (BakeSdf::default(), taken));
    wait(&mut app, |app| failure(app, open).is_some() && failure(app, taken).is_some());
    let error = failure(&app, open).unwrap();
    let not_closed = |error: &ClothError| {
        matches!(error, ClothError { kind: ClothErrorKind::Bake(BakeError::NotClosed { .. }), .. })
    };
    assert!(not_closed(&error), "{error}");
    let error = failure(&app, taken).unwrap();
    let gone = MeshProblem::TakenToGpu;
    assert_eq!(error, ClothError { entity: taken, kind: ClothErrorKind::ColliderMesh(gone) });
    let mended = Mesh3d(add_mesh(&mut app, box_mesh(1.0)));
    app.world_mut().entity_mut(open).insert(mended);
    wait(&mut app, |app| app.world().get::<SdfCollider>(open).is_some());
    assert_eq!(failure(&app, open), None);
}

/// The ground of a level: an open mesh, told of before it has a thickness.
#[test]
fn an_open_mesh_with_a_thickness_carries() {
    let mut app = app();
    let ground = grid_mesh(3, 3, |v| v, |r, c| Vec3::new(c as f32 - 1.0, 0.0, r as f32 - 1.0));
    let ground = Mesh3d(add_mesh(&mut app, ground));
    let solid = spawn(&mut app, (BakeSdf::default(), ground));
    wait(&mut app, |app| failure(app, solid).is_some());
    app.world_mut().entity_mut(solid).insert(BakeSdf::with_thickness(0.04));
    wait(&mut app, |app| app.world().get::<SdfCollider>(solid).is_some());
    assert_eq!(failure(&app, solid), None);
    let cloth = above(&mut app, 0.1);
    updates(&mut app, 60);
    assert!((lowest(&app, cloth) - 0.025).abs() < 1e-3, "{}", lowest(&app, cloth));
    for thickness in [-0.1, f32::NAN, f32::INFINITY] {
        app.world_mut().entity_mut(solid).insert(BakeSdf::with_thickness(thickness));
        wait(&mut app, |app| failure(app, solid).is_some());
        let error = failure(&app, solid).unwrap();
        let ClothErrorKind::Shell(ShellError::Radius { .. }) = error.kind else {
            panic!("{error}");
        };
        app.world_mut().entity_mut(solid).insert(BakeSdf::with_thickness(0.04));
        wait(&mut app, |app| failure(app, solid).is_none());
    }
}

#[test]
fn layers_choose_who_meets_whom() {
    let mut app = app();
    spawn(&mut app, SdfCollider::from(Sphere::new(0.3)).in_layers(0b10));
    let held = above(&mut app, 0.35);
    let falls = above(&mut app, 0.35);
    let settings = ClothSettings { layers: 0b101.into(), ..default() };
    app.world_mut().entity_mut(falls).insert(settings);
    updates(&mut app, 40);
    assert!(positions(&app, held).iter().any(|p| p.y > 0.25));
    assert!(positions(&app, falls).iter().all(|p| p.y < -0.5));
}

#[test]
fn a_collider_is_given_the_weight_that_rests_on_it() {
    let mut app = app();
    let plane = spawn(&mut app, SdfCollider::from(InfinitePlane3d::default()));
    let cloth = above(&mut app, 0.006);
    updates(&mut app, 32);
    // Asked for after it stands still.
    app.world_mut().entity_mut(plane).insert(ColliderImpulse::default());
    updates(&mut app, 2);
    let given = app.world().get::<ColliderImpulse>(plane).unwrap().linear;
    let solver_mass: f32 = {
        let material = *app.world().get::<ClothMaterial>(cloth).unwrap();
        material.area_density * 1.0
    };
    let expected = -9.81 * solver_mass / 64.0;
    assert!((given.y - expected).abs() < 0.01 * -expected, "{given} for {expected}");
    assert!(given.xz().length() < 0.01 * -expected, "{given}");
}

#[test]
fn bones_push_with_one_component_each() {
    let mut app = app();
    // An upper arm and a forearm, the elbow bent by a right angle.
    let shoulder = spawn(
        &mut app,
        (
            SdfCollider::capsule_between(Vec3::ZERO, Vec3::X * 0.4, 0.08),
            Transform::from_xyz(-0.2, 0.0, 0.0),
        ),
    );
    let bend = Transform::from_xyz(0.4, 0.0, 0.0)
        .with_rotation(Quat::from_rotation_y(core::f32::consts::FRAC_PI_2));
    let forearm =
        (SdfCollider::capsule_between(Vec3::ZERO, Vec3::X * 0.4, 0.06), bend, ChildOf(shoulder));
    spawn(&mut app, forearm);
    let cloth = above(&mut app, 0.2);
    updates(&mut app, 40);
    let to_segment = |p: Vec3, a: Vec3, b: Vec3| {
        p.distance(a + (b - a) * ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0))
    };
    let elbow = Vec3::new(0.2, 0.0, 0.0);
    for p in positions(&app, cloth) {
        assert!(to_segment(p, Vec3::X * -0.2, elbow) > 0.085 - 1e-4, "{p} in the upper arm");
        assert!(to_segment(p, elbow, elbow - Vec3::Z * 0.4) > 0.065 - 1e-4, "{p} in the forearm");
    }
    let held = positions(&app, cloth).iter().filter(|p| p.y > 0.0).count();
    assert!(held > 0, "fell past both");
}

#[test]
fn a_parent_that_moves_or_goes_moves_its_still_collider() {
    for unparent in [false, true] {
        let mut app = app();
        let parent = spawn(&mut app, Transform::from_xyz(0.0, -10.0, 0.0));
        let plane = (SdfCollider::from(InfinitePlane3d::default()), ChildOf(parent));
        let plane = spawn(&mut app, plane);
        let cloth = above(&mut app, 0.5);
        updates(&mut app, 8);
        if unparent {
            app.world_mut().entity_mut(plane).remove::<ChildOf>();
        } else {
            app.world_mut().get_mut::<Transform>(parent).unwrap().translation.y = 0.0;
        }
        updates(&mut app, 64);
        assert!(lowest(&app, cloth) > 0.0, "unparent {unparent}: {}", lowest(&app, cloth));
    }
}

#[test]
fn a_collider_that_is_taken_away_lets_go() {
    let ways: [fn(&mut App, Entity); 3] = [
        |app, it| app.world_mut().despawn(it).then_some(()).unwrap(),
        |app, it| {
            app.world_mut().entity_mut(it).remove::<SdfCollider>();
        },
        |app, it| _ = app.world_mut().entity_mut(it).insert(SdfColliderDisabled),
    ];
    for way in ways {
        let mut app = app();
        let plane = spawn(&mut app, SdfCollider::from(InfinitePlane3d::default()));
        let cloth = above(&mut app, 0.02);
        updates(&mut app, 32);
        assert!(lowest(&app, cloth) > 0.0);
        way(&mut app, plane);
        updates(&mut app, 32);
        assert!(lowest(&app, cloth) < -0.5);
    }
}

#[test]
fn a_collider_that_is_not_met_is_given_nothing() {
    let acts: [fn(&mut App, Entity); 4] = [
        |app: &mut App, ball: Entity| {
            app.world_mut().entity_mut(ball).insert(SdfColliderDisabled);
        },
        |app: &mut App, ball: Entity| transform(app, ball).scale.y = 2.0,
        |app: &mut App, ball: Entity| {
            app.world_mut().entity_mut(ball).remove::<SdfCollider>();
        },
        |app: &mut App, ball: Entity| {
            app.world_mut().entity_mut(ball).insert(Disabled);
        },
    ];
    for act in acts {
        let mut app = app();
        let ball =
            spawn(&mut app, (SdfCollider::from(Sphere::new(0.3)), ColliderImpulse::default()));
        above(&mut app, 0.32);
        updates(&mut app, 30);
        let given = |app: &App| app.world().get::<ColliderImpulse>(ball).unwrap().linear.y;
        assert!(given(&app) < 0.0);
        act(&mut app, ball);
        updates(&mut app, 2);
        if app.world().entity(ball).contains::<Disabled>() {
            // Nobody tells what is disabled; it comes back elsewhere.
            *transform(&mut app, ball) = Transform::from_xyz(9.0, 0.0, 0.0);
            app.world_mut().entity_mut(ball).remove::<Disabled>();
            updates(&mut app, 2);
        }
        assert_eq!(given(&app), 0.0);
    }
}

/// As objects are that a game keeps for later.
#[test]
fn a_collider_of_a_disabled_entity_is_not_there() {
    let mut app = app();
    let ball = spawn(&mut app, SdfCollider::from(Sphere::new(0.3)));
    updates(&mut app, 3);
    app.world_mut().entity_mut(ball).insert(Disabled);
    let cloth = above(&mut app, 0.32);
    updates(&mut app, 60);
    assert!(lowest(&app, cloth) < -2.0);
    app.world_mut().entity_mut(ball).remove::<Disabled>();
    let cloth = above(&mut app, 0.32);
    updates(&mut app, 30);
    let nearest = positions(&app, cloth).iter().map(|p| p.length()).fold(f32::INFINITY, f32::min);
    assert!((0.3..0.32).contains(&nearest), "{nearest}");
}
