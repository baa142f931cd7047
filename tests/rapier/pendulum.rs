//! A sandbag that hangs by a strap swings against a curtain: the same with both engines.

use avian3d::prelude as avian;
use bevy::prelude::*;
use bevy_drape::{AvianClothPlugin, ClothCollider, RapierClothPlugin, prelude::*};
use bevy_rapier3d::prelude as rapier;

use crate::support::app::*;

const MASS: f32 = 2.0;
const RADIUS: f32 = 0.15;

/// Where the sandbag is in each tick. It is made by `bag` from its place, and hangs by a strap of cloth.
fn swings(mut app: App, bag: impl Fn(&mut App, Transform) -> Entity) -> Vec<Vec3> {
    let upright = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let at = Vec3::new(0.0, 1.0, 0.7);
    let bag = bag(&mut app, Transform::from_translation(at));
    // From above the middle, so that it begins to swing.
    let strap = Cloth::sheet(Vec2::new(0.1, 1.05), UVec2::new(4, 36));
    let hook = Vec3::new(0.0, 2.0, 0.0);
    let way = at - hook;
    let turn = Quat::from_rotation_arc(Vec3::Z, way.normalize());
    let strap_place =
        Transform::from_translation(hook + way.normalize() * 0.525).with_rotation(turn);
    let pins = ClothPins::vertices(0..4).and(ClothPins::vertices(140..144).anchored_to(bag));
    spawn(&mut app, (strap, ClothMaterial::CANVAS, pins, strap_place));
    let curtain = Cloth::sheet(Vec2::new(1.2, 1.6), UVec2::new(32, 42));
    let place = Transform::from_xyz(0.0, 1.2, -0.1).with_rotation(upright);
    spawn(&mut app, (curtain, ClothPins::vertices(0..32), place));
    (0..192)
        .map(|_| {
            app.update();
            app.world().get::<Transform>(bag).unwrap().translation
        })
        .collect()
}

#[test]
fn both_engines_swing_it_alike() {
    let app = app_with((
        avian::PhysicsPlugins::default(),
        ClothPlugin::default(),
        AvianClothPlugin::default(),
    ));
    let of_avian = swings(app, |app, place| {
        let bag = (avian::RigidBody::Dynamic, avian::Collider::sphere(RADIUS), avian::Mass(MASS));
        spawn(app, (bag, ClothCollider::default(), place))
    });
    let physics = rapier::RapierPhysicsPlugin::<rapier::NoUserData>::default().in_fixed_schedule();
    let app = app_with((physics, ClothPlugin::default(), RapierClothPlugin::default()));
    let of_rapier = swings(app, |app, place| {
        let mass = rapier::ColliderMassProperties::Mass(MASS);
        let bag = (rapier::RigidBody::Dynamic, rapier::Collider::ball(RADIUS), mass);
        spawn(app, (bag, ClothCollider::default(), place))
    });
    let far = |places: &[Vec3]| places.iter().fold(f32::MAX, |least, p| least.min(p.z));
    let (a, b) = (far(&of_avian), far(&of_rapier));
    let apart = of_avian.iter().zip(&of_rapier).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    let ends = (of_avian[191], of_rapier[191]);
    println!("furthest {a} and {b} m, apart by {apart} m at most; ends {ends:?}");
    // It pushes the curtain, which takes some of its swing.
    assert!((-0.65..-0.15).contains(&a), "{a}");
    assert!((a - b).abs() < 0.02 * (0.7 - a), "{a} and {b}");
    assert!(ends.0.distance(ends.1) < 0.02 * 1.4, "{ends:?}");
}
