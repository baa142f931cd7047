//! Two cloths to tune: one that hangs in a breeze, one that lies on a ball.

use super::scene::{
    BRASS, CORAL, INDIGO, IVORY, clay, linen, metal, spawn_sheet, spawn_solid, spawn_thing,
};
use bevy::prelude::*;
use bevy_drape::{prelude::*, solver::Gusts};

/// Adds both.
pub fn add_tuned(world: &mut World, particles: u32) {
    world.insert_resource(
        ClothWind::steady(Vec3::new(0.0, 0.0, 2.0))
            .with_gusts(Gusts { strength: 1.5, ..default() }),
    );
    let ball = Sphere::new(0.35);
    let at = Vec3::new(0.7, 0.35, 1.0);
    spawn_solid(world, ball.mesh().uv(96, 48), at, clay(IVORY), ball);
    let above = at + Vec3::Y * 0.5;
    spawn_sheet(world, particles, 1.2, above, CORAL, ClothMaterial::default())
        .insert(Name::new("on the ball"));

    let rod = Cylinder::new(0.015, 1.2).mesh().build();
    let rod = rod.rotated_by(Quat::from_rotation_z(90.0_f32.to_radians()));
    spawn_thing(world, rod, Vec3::new(-0.45, 1.75, 0.0), metal(BRASS));
    world.spawn((
        Cloth::sheet(Vec2::new(1.0, 1.4), UVec2::splat(particles)),
        ClothMaterial { drag: 0.5, ..default() },
        ClothPins::from(PinSelection::FirstRow),
        ClothAir::default(),
        Transform::from_xyz(-0.45, 1.05, 0.0)
            .with_rotation(Quat::from_rotation_x(90.0_f32.to_radians())),
        Name::new("in the breeze"),
        linen(INDIGO),
    ));
}
