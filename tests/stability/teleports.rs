//! Colliders of an app that are put elsewhere, shrink to nothing or go. Truth: no particle is faster than
//! it may be pushed out, the error names the collider, and cloths elsewhere keep every bit.

use bevy::prelude::*;
use bevy_drape::prelude::*;

use crate::app::*;

/// What is done to the ball in a frame.
type Deed = fn(&mut World, Entity, usize);

/// Faster than any particle that a ball meets which is put into the cloth [m/s].
const MOST_SPEED: f32 = 10.0;

/// Cloths over which a ball is, and one of each kind that it never comes to: the bits of the latter after
/// every tick.
fn scene(deed: Deed) -> (App, [Entity; 4], Entity, Vec<Vec<u64>>) {
    let mut app = app();
    let corners = || ClothPins::vertices([0, 15, 15 * 16, 16 * 16 - 1]);
    let near = spawn_variants(&mut app, 16, |i| {
        (corners(), Transform::from_xyz(i as f32 * 2.0, 0.0, 0.0))
    });
    app.world_mut().resource_mut::<Track>().cloths.clear();
    spawn_variants(&mut app, 16, |i| (corners(), Transform::from_xyz(i as f32 * 2.0, 0.0, 50.0)));
    let ball = (SdfCollider::from(Sphere::new(0.3)), Transform::from_xyz(0.0, -9.0, 0.0));
    let ball = spawn(&mut app, ball);
    let mut fastest = 0.0;
    for tick in 0..640 {
        deed(app.world_mut(), ball, tick);
        frame(&mut app, TICK);
        for cloth in near {
            assert_eq!(failure(&app, cloth), None);
            let cloth = simulation(&app, cloth);
            assert!(cloth.positions().all(Vec3::is_finite));
            assert!(!cloth.is_quarantined());
            fastest = cloth
                .positions()
                .enumerate()
                .map(|(i, _)| cloth.velocity(i).unwrap().length())
                .fold(fastest, f32::max);
        }
    }
    assert!(fastest < MOST_SPEED, "{fastest} m/s");
    let ticks = app.world().resource::<Track>().ticks.clone();
    (app, near, ball, ticks)
}

fn put(world: &mut World, ball: Entity, at: Vec3) {
    if let Some(mut place) = world.get_mut::<Transform>(ball) {
        place.translation = at;
    }
}

#[test]
fn h11_what_happens_to_a_ball_is_no_matter_to_cloths_elsewhere() {
    let (_, _, _, alone) = scene(|world, ball, tick| {
        if tick == 0 {
            world.despawn(ball);
        }
    });
    let deeds: [(&str, Deed); 4] = [
        ("teleports", |world, ball, tick| {
            // Through and into one cloth after the other, a few ticks at each place.
            let (i, y) = (tick / 32 % 4, [12.0, -0.25, -12.0, 0.25][tick / 8 % 4]);
            put(world, ball, Vec3::new(i as f32 * 2.0, y, 0.0));
        }),
        ("is scaled to nothing", |world, ball, tick| {
            put(world, ball, Vec3::new((tick / 160) as f32 * 2.0, -0.25, 0.0));
            let scale = 1.0 - (tick % 160) as f32 / 80.0;
            world.get_mut::<Transform>(ball).unwrap().scale = Vec3::splat(scale.max(0.0));
        }),
        ("is taken away and comes again", |world, ball, tick| {
            put(world, ball, Vec3::new((tick / 160) as f32 * 2.0, -0.25, 0.0));
            if tick % 40 == 20 {
                world.entity_mut(ball).remove::<SdfCollider>();
            } else if tick % 40 == 0 {
                world.entity_mut(ball).insert(SdfCollider::from(Sphere::new(0.3)));
            }
        }),
        ("is despawned", |world, ball, tick| {
            if tick < 100 {
                put(world, ball, Vec3::new(0.0, -0.25, 0.0));
            } else if tick == 100 {
                world.despawn(ball);
            }
        }),
    ];
    for (what, deed) in deeds {
        let (app, near, _, ticks) = scene(deed);
        let same = alone.iter().zip(&ticks).position(|(a, b)| a != b);
        assert_eq!(
            same, None,
            "the first tick in which a ball that {what} changes a cloth far off"
        );
        for cloth in near {
            let strain = simulation(&app, cloth).strain().max;
            assert!(strain < 0.2, "a strain of {strain} is left by a ball that {what}");
        }
    }
}

#[test]
fn h11_a_ball_scaled_to_nothing_is_named() {
    let mut app = app();
    let cloth =
        spawn_cloth(&mut app, (Cloth::sheet(Vec2::ONE, UVec2::splat(8)), Transform::default()));
    let ball =
        spawn(&mut app, (SdfCollider::from(Sphere::new(0.3)), Transform::from_xyz(0.0, -0.3, 0.0)));
    frame(&mut app, TICK);
    app.world_mut().get_mut::<Transform>(ball).unwrap().scale = Vec3::ZERO;
    frame(&mut app, TICK);
    let error = failure(&app, ball).expect("a scale of zero is refused").to_string();
    assert!(error.contains(&format!("{ball}")), "{error}");
    assert!(failure(&app, cloth).is_none());
}
