//! Two engines in one app.

use crate::falls::physics;
use crate::support::app::*;
use avian3d::prelude as avian;
use bevy::prelude::*;
use bevy_drape::{
    AvianClothPlugin, ClothCollider, ClothErrorKind, EngineProblem, RapierClothPlugin, prelude::*,
};
use bevy_rapier3d::prelude::Collider;

fn both_engines() -> App {
    app_with((
        (avian::PhysicsPlugins::default(), physics()),
        ClothPlugin::default(),
        (AvianClothPlugin::default(), RapierClothPlugin::default()),
    ))
}

#[test]
fn each_engine_has_its_own_colliders() {
    let mut app = both_engines();
    let at = Transform::from_xyz;
    let ball = avian::Collider::sphere(0.3);
    spawn(&mut app, (ball, at(0.0, 0.0, 0.0), ClothCollider::default()));
    spawn(&mut app, (Collider::ball(0.3), at(2.0, 0.0, 0.0), ClothCollider::default()));
    let cloths = [0.0, 2.0].map(|x| spawn(&mut app, (sheet(), at(x, 0.4, 0.0))));
    updates(&mut app, 64);
    for (cloth, x) in cloths.into_iter().zip([0.0, 2.0]) {
        let distances = positions(&app, cloth).into_iter().map(|p| p.distance(Vec3::X * x));
        let least = distances.fold(f32::MAX, f32::min);
        assert!((0.2999..0.33).contains(&least), "{least}");
    }
}

#[test]
fn two_colliders_on_one_entity_are_told() {
    let mut app = both_engines();
    let entity =
        spawn(&mut app, (Collider::ball(0.3), Transform::default(), ClothCollider::default()));
    updates(&mut app, 2);
    assert_eq!(failure(&app, entity), None);
    app.world_mut().entity_mut(entity).insert(avian::Collider::sphere(0.2));
    updates(&mut app, 2);
    let told = failure(&app, entity).expect("it is told");
    let expected = EngineProblem::TwoEngines { kept: "Rapier" };
    assert_eq!(told.kind, ClothErrorKind::Engine(expected));
    assert!(app.world().get::<SdfCollider>(entity).is_some());
    app.world_mut().entity_mut(entity).remove::<Collider>();
    updates(&mut app, 2);
    assert_eq!(failure(&app, entity), None);
    assert!(app.world().get::<SdfCollider>(entity).is_some());
}

#[test]
fn no_order_is_left_to_chance() {
    let ambiguities = |mut app: App| {
        updates(&mut app, 2);
        let schedules = app.world().resource::<Schedules>();
        schedules.get(FixedPostUpdate).map_or(0, |it| it.graph().conflicting_systems().len())
    };
    // Avian has one of its own.
    let alone = app_with(avian::PhysicsPlugins::default());
    assert_eq!(ambiguities(both_engines()), ambiguities(alone));
}
