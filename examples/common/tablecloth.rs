//! A tablecloth that comes down on a table, and is pulled away.

use super::scene::{CORAL, IVORY, clay, spawn_sheet, spawn_solid};
use bevy::prelude::*;
use bevy_drape::prelude::*;

/// Height of the table, radius and thickness of its top \[m\].
const HEIGHT: f32 = 0.75;
const RADIUS: f32 = 0.55;
const THICKNESS: f32 = 0.04;
/// When the cloth is pulled \[s\], and how fast the hand goes \[m/s\] for how long \[s\].
const PULLED: f32 = 3.5;
const SPEED: f32 = 1.6;
const DURATION: f32 = 1.5;

/// What pulls the cloth.
#[derive(Component)]
pub struct Hand {
    holds: bool,
}

/// Adds the table, the cloth and the hand.
pub fn add_tablecloth(world: &mut World, particles: u32) {
    let top = Cylinder::new(RADIUS, THICKNESS);
    let middle = Vec3::Y * (HEIGHT - 0.5 * THICKNESS);
    spawn_solid(world, top.mesh().resolution(128).build(), middle, clay(IVORY), top);
    for (radius, height) in [(0.05, HEIGHT - THICKNESS), (0.28, 0.03)] {
        let foot = Cylinder::new(radius, height);
        let mesh = foot.mesh().resolution(64).build();
        spawn_solid(world, mesh, Vec3::Y * foot.half_height, clay(IVORY), foot);
    }
    world.spawn((Hand { holds: false }, Transform::default()));
    // Cotton on polished wood. As thick as that, it goes round the edge, on which its particles would catch.
    let material = ClothMaterial { friction: 0.05, thickness: 0.012, ..ClothMaterial::COTTON };
    let place = Vec3::Y * (HEIGHT + 0.15);
    spawn_sheet(world, particles, 1.7, place, CORAL, material);
}

/// The hand takes the hem where it is by then, goes, and lets go.
pub fn pull(
    mut hands: Query<(Entity, &mut Hand, &mut Transform)>,
    mut cloths: Query<&mut ClothPins>,
    time: Res<Time>,
) {
    let since = time.elapsed_secs() - PULLED;
    for (entity, mut hand, mut place) in &mut hands {
        let holds = (0.0..DURATION).contains(&since);
        if holds {
            place.translation += SPEED * time.delta_secs() * Vec3::new(0.0, 0.15, 1.0);
        }
        if hand.holds != holds {
            hand.holds = holds;
            for mut pins in &mut cloths {
                let hem = ClothPins::from(PinSelection::LastRow).anchored_to(entity);
                *pins = if holds { hem } else { ClothPins::none() };
            }
        }
    }
}
