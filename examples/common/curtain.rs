//! A curtain on a rail: rings that slide together, and folds between them.

use super::scene::{BRASS, INDIGO, linen, metal, spawn_thing};
use bevy::prelude::*;
use bevy_drape::{ClothInterpolation, prelude::*};

const RAIL_HEIGHT: f32 = 2.2;
/// Width and height of the cloth \[m\].
const SIZE: Vec2 = Vec2::new(2.2, 1.9);
/// Number of rings; there are as many stretches of cloth less one.
const RINGS: u32 = 13;
/// Parts of its width at which it is closed by itself, and within which it can be drawn.
const DRAWN: f32 = 0.64;
const RANGE: (f32, f32) = (0.2, 1.0);

/// How far the curtain is drawn, as a part of its width, and how far it is to be.
#[derive(Component)]
pub struct Rail {
    now: f32,
    wanted: f32,
}

impl Rail {
    /// Wants a ring at a place along the rail \[m\]. The first one is fixed.
    pub fn draw_to(&mut self, ring: &Ring, x: f32) {
        if ring.0 > 0.0 {
            self.wanted = ((x / SIZE.x + 0.5) / ring.0).clamp(RANGE.0, RANGE.1);
        }
    }
}

/// A ring, and its part of the way along the curtain.
#[derive(Component)]
pub struct Ring(pub f32);

/// Adds rail, rings and cloth.
pub fn add_curtain(world: &mut World, particles: u32) {
    // Rings are thin: what the mouse takes hold of is around them, and is not seen.
    let handle = Mesh3d(world.resource_mut::<Assets<Mesh>>().add(Sphere::new(0.045).mesh()));
    let rail = Cylinder::new(0.012, SIZE.x + 0.3).mesh().build();
    let rail = rail.rotated_by(Quat::from_rotation_z(90.0_f32.to_radians()));
    let rail = spawn_thing(world, rail, Vec3::Y * RAIL_HEIGHT, metal(BRASS));
    world.entity_mut(rail).insert(Rail { now: RANGE.1, wanted: DRAWN });
    let mut pins = ClothPins::none();
    for number in 0..RINGS {
        let along = number as f32 / (RINGS - 1) as f32;
        let ring = Torus { minor_radius: 0.005, major_radius: 0.028 }.mesh().build();
        let ring = ring.rotated_by(Quat::from_rotation_z(90.0_f32.to_radians()));
        // Every second hook is behind the rail, so that the cloth knows which way to fold.
        let z = if number % 2 == 0 { 0.012 } else { -0.012 };
        let at = Vec3::new(place(RANGE.1, along), RAIL_HEIGHT - 0.015, z);
        let ring = spawn_thing(world, ring, at, metal(BRASS));
        world.entity_mut(ring).insert(Ring(along)).with_child(handle.clone());
        let vertex = (along * (particles - 1) as f32).round() as u32;
        pins = pins.and(ClothPins::vertices([vertex]).anchored_to(ring));
    }
    world.spawn((
        Cloth::sheet(SIZE, UVec2::splat(particles)),
        ClothMaterial { drag: 1.0, damping: 0.002, ..default() },
        pins,
        // As the rings, which are drawn where the last tick took them.
        ClothInterpolation::LastTick,
        Transform::from_xyz(0.0, RAIL_HEIGHT - 0.04 - 0.5 * SIZE.y, 0.0)
            .with_rotation(Quat::from_rotation_x(90.0_f32.to_radians())),
        linen(INDIGO),
    ));
}

/// Where a ring is on the rail \[m\]: it is drawn towards its left end.
fn place(drawn: f32, along: f32) -> f32 {
    SIZE.x * (drawn * along - 0.5)
}

/// Draws the curtain towards where it is wanted, at half a metre a second.
pub fn draw_curtain(
    mut rails: Query<&mut Rail>,
    mut rings: Query<(&Ring, &mut Transform)>,
    time: Res<Time>,
) {
    for mut rail in &mut rails {
        let step = 0.5 * time.delta_secs() / SIZE.x;
        let to = rail.wanted.clamp(RANGE.0, RANGE.1);
        rail.now += (to - rail.now).clamp(-step, step);
        for (ring, mut transform) in &mut rings {
            transform.translation.x = place(rail.now, ring.0);
        }
    }
}
