//! A crowd of which few are seen, and fewer are near: what culling and levels of detail spare.

use crate::{
    app::{app_with, compare_by, second_update},
    turns::{Bound, Wrong, heading, line},
};
use bevy::{camera::CameraPlugin, prelude::*};
use bevy_drape::{ClothCulling, ClothLod, ClothSleepThreshold, prelude::*};

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

/// Where the rows are \[m\]: half of those that are seen are near.
const NEAR: f32 = -6.0;
const FAR: f32 = -14.0;

/// All of them in rows, a metre apart, a few before the camera and the others behind it.
fn crowd(culled: bool, levels: bool) -> App {
    let mut app = app_with(true, CameraPlugin);
    app.add_systems(FixedUpdate, walk);
    let world = app.world_mut();
    world.spawn((Camera3d::default(), Transform::from_xyz(0.0, 1.5, 0.0)));
    for i in 0..CROWD {
        let z = match i {
            _ if i < SEEN / 2 => NEAR,
            _ if i < SEEN => FAR,
            _ => 12.0 + (i / SEEN) as f32,
        };
        let place = Transform::from_xyz((i % 5) as f32 - 2.0, 2.0, z);
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
        if levels {
            cloth.insert(ClothLod::default());
        }
    }
    app
}

/// Not many updates: each moves a hundred thousand particles.
pub fn crowd_of_few_seen(rounds: usize, wrong: &mut Wrong) {
    heading("a whole update, 100 cloths of 1024, 10 seen, us", "all awake", "culled");
    let rounds = rounds.div_ceil(4);
    let culling = || [crowd(false, false), crowd(true, false)];
    let name = "ClothCulling";
    line(name, &compare_by(second_update, name, rounds, culling, false, wrong), Bound::None);
    let both = || [crowd(false, false), crowd(true, true)];
    let name = "ClothCulling and ClothLod, 5 near";
    line(name, &compare_by(second_update, name, rounds, both, false, wrong), Bound::Times(0.1));
    let mut app = crowd(true, true);
    (0..10).for_each(|_| app.update());
    let world = app.world_mut();
    let mut cloths = world.query::<&ClothSimulation>();
    let mut number = |is: &dyn Fn(&ClothSimulation) -> bool| {
        cloths.iter(world).filter(|cloth| is(cloth)).count()
    };
    let culled = number(&|cloth| cloth.is_culled());
    let far = number(&|cloth| !cloth.is_culled() && cloth.level() == 1);
    let is_right = (culled, far) == (CROWD - SEEN, SEEN / 2);
    wrong.unless(
        is_right,
        name,
        "not all that are unseen are culled, or not all that are far do less",
    );
}
