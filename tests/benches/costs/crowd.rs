//! A crowd of which few are seen: what culling spares.

use crate::{
    app::{app_with, compare},
    turns::{Bound, Wrong, heading, line},
};
use bevy::{camera::CameraPlugin, prelude::*};
use bevy_drape::{ClothCulling, ClothSleepThreshold, prelude::*};

/// Cloths, and how many of them are before the camera.
const CROWD: usize = 100;
const SEEN: usize = 10;

/// Whose hand a cloth hangs from.
#[derive(Component)]
struct Walker;

fn walk(mut walkers: Query<&mut Transform, With<Walker>>, time: Res<Time>) {
    for mut place in &mut walkers {
        place.translation.y = 2.0 + 0.1 * ops::sin(8.0 * time.elapsed_secs());
    }
}

/// All of them in a row, a metre apart, a few before the camera and the others behind it.
fn crowd(culled: bool) -> App {
    let mut app = app_with(true, CameraPlugin);
    app.add_systems(FixedUpdate, walk);
    let world = app.world_mut();
    world.spawn((Camera3d::default(), Transform::from_xyz(0.0, 1.5, 0.0)));
    for i in 0..CROWD {
        let z = if i < SEEN { -12.0 } else { 12.0 };
        let place = Transform::from_xyz((i % SEEN) as f32 - 4.5, 2.0, z + (i / SEEN) as f32);
        let hand = world.spawn((Walker, place)).id();
        let cloth = (
            Cloth::sheet(Vec2::splat(0.8), UVec2::splat(32)),
            ClothPins::from(PinSelection::FirstRow).anchored_to(hand),
            ClothSleepThreshold::NEVER,
            place,
        );
        let mut cloth = world.spawn(cloth);
        if culled {
            cloth.insert(ClothCulling { after: 0.0 });
        }
    }
    app
}

/// Not many updates: each moves a hundred thousand particles.
pub fn crowd_of_few_seen(rounds: usize, wrong: &mut Wrong) {
    heading("a whole update, 100 cloths of 1024, 10 seen, us", "all awake", "culled");
    let name = "ClothCulling";
    let turns = compare(name, rounds.div_ceil(4), || [crowd(false), crowd(true)], false, wrong);
    line(name, &turns, Bound::Times(0.1));
    let mut app = crowd(true);
    (0..10).for_each(|_| app.update());
    let world = app.world_mut();
    let mut cloths = world.query::<&ClothSimulation>();
    let culled = cloths.iter(world).filter(|cloth| cloth.is_culled()).count();
    wrong.unless(
        culled == CROWD - SEEN,
        name,
        "not all that are unseen are culled, or some that are seen",
    );
}
