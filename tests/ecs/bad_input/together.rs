//! What is asked of a running cloth, and several errors on one entity.

use super::{Act, HUGE, INF, NAN, alone, bundle, is_finite, pins, world};
use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{ClothError, ClothSleepThreshold, ColliderImpulse, prelude::*};

#[test]
fn what_is_asked_of_a_running_cloth() {
    let (mut app, good) = world();
    let cloth = spawn(&mut app, bundle());
    updates(&mut app, 20);
    let running = simulation(&app, cloth);
    for particle in [64, usize::MAX] {
        assert_eq!(running.position(particle), None);
        assert_eq!(running.velocity(particle), None);
        assert_eq!(running.mass(particle), None);
    }
    assert_eq!(
        (running.particle_of_vertex(64), running.particle_of_vertex(u32::MAX)),
        (None, None)
    );
    // Velocities that are none are not taken, by the particle.
    let mut running = app.world_mut().get_mut::<ClothSimulation>(cloth).unwrap();
    for bad in [Vec3::NAN, Vec3::X * INF, Vec3::splat(-HUGE)] {
        running.set_velocities(|_| bad);
    }
    updates(&mut app, 4);
    assert!(bits(&app, cloth) == bits(&app, good));
    let mut running = app.world_mut().get_mut::<ClothSimulation>(cloth).unwrap();
    running.set_velocities(|p| if p.x > 0.0 { Vec3::NAN } else { Vec3::ZERO });
    // What a machine lacks is done by what it has.
    bevy_drape::solver::Isa::ALL.into_iter().for_each(|isa| running.set_isa(isa));
    updates(&mut app, 4);
    assert_eq!(failure(&app, cloth), None);
    assert!(is_finite(&app, cloth));
    assert!(bits(&app, good) == alone(28));
}

/// Impulses are written, not read.
#[test]
fn impulses_that_are_no_numbers() {
    let (mut app, good) = world();
    let floor = SdfCollider::from(InfinitePlane3d::default());
    let floor = (
        floor,
        ColliderImpulse { linear: Vec3::NAN, angular: Vec3::NAN },
        Transform::from_xyz(0.0, -9.0, 0.0),
    );
    let floor = spawn(&mut app, floor);
    let none = spawn(&mut app, ColliderImpulse { linear: Vec3::splat(INF), ..default() });
    updates(&mut app, 20);
    assert_eq!(app.world().get::<ColliderImpulse>(floor), Some(&ColliderImpulse::default()));
    assert_eq!((failure(&app, floor), failure(&app, none)), (None, None));
    assert!(bits(&app, good) == alone(20));
}

fn errors(app: &App, entity: Entity) -> Vec<String> {
    let Some(failure) = app.world().get::<ClothFailure>(entity) else { return Vec::new() };
    failure.errors().map(ClothError::to_string).collect()
}

/// Of several things that are wrong each is told, and goes when it is mended.
#[test]
fn several_things_at_once() {
    let (mut app, good) = world();
    let cloth = spawn(&mut app, bundle());
    updates(&mut app, 8);
    let bad_pin = pins().and(ClothPins::vertices([99]));
    let material = ClothMaterial { drag: NAN, ..default() };
    let settings = ClothSettings { max_speed: -1.0, ..default() };
    let sleep = ClothSleepThreshold { time: INF, ..default() };
    app.world_mut().entity_mut(cloth).insert((bad_pin, material, settings, sleep));
    updates(&mut app, 6);
    let names = ["drag", "max_speed", "99", "time"];
    let all = errors(&app, cloth);
    assert_eq!(all.len(), names.len(), "{all:?}");
    for name in names {
        assert!(all.iter().any(|error| error.contains(name)), "{name}: {all:?}");
    }
    assert_eq!(failure(&app, cloth).map(|error| error.to_string()), all.first().cloned());
    assert!(bits(&app, cloth) == bits(&app, good));
    let mend: [(&str, Act); 4] = [
        ("drag", Box::new(|e| _ = e.insert(ClothMaterial::default()))),
        ("99", Box::new(|e| _ = e.insert(pins()))),
        ("time", Box::new(|e| _ = e.remove::<ClothSleepThreshold>())),
        ("max_speed", Box::new(|e| _ = e.insert(ClothSettings::default()))),
    ];
    for (i, (name, mend)) in mend.iter().enumerate() {
        mend(&mut app.world_mut().entity_mut(cloth));
        updates(&mut app, 2);
        let left = errors(&app, cloth);
        assert_eq!(left.len(), 3 - i, "{left:?}");
        assert!(!left.iter().any(|error| error.contains(name)), "{name}: {left:?}");
    }
    assert!(bits(&app, good) == alone(22));
    assert!(bits(&app, cloth) == bits(&app, good));
}

/// A cloth and a collider on one entity have nothing to do with each other's errors.
#[test]
fn a_cloth_that_is_also_a_bad_collider() {
    let (mut app, good) = world();
    let collider = SdfCollider::from(Sphere::new(NAN));
    let both = spawn(&mut app, (collider, Cloth::of_mesh3d()));
    updates(&mut app, 4);
    assert_eq!(errors(&app, both).len(), 2);
    // Its mesh comes, and it is a cloth; the collider is as bad as ever.
    let mesh = grid_mesh(3, 4, |v| v, |r, c| Vec3::new(c as f32, 0.0, r as f32));
    let mesh = Mesh3d(add_mesh(&mut app, mesh));
    app.world_mut().entity_mut(both).insert(mesh);
    updates(&mut app, 4);
    assert_eq!(simulation(&app, both).particle_count(), 12);
    let left = errors(&app, both);
    assert!(left.len() == 1 && left[0].contains("radius"), "{left:?}");
    app.world_mut().entity_mut(both).remove::<Cloth>();
    app.update();
    assert_eq!(errors(&app, both), left);
    app.world_mut().entity_mut(both).remove::<SdfCollider>();
    updates(&mut app, 11);
    assert_eq!(errors(&app, both), [""; 0]);
    assert!(bits(&app, good) == alone(20));
}
