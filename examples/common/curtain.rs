//! A cloth held by two rings that slide together.

use super::scene::{BRASS, INDIGO, Look, linen};
use bevy::prelude::*;
use bevy_drape::prelude::*;

/// A ring on the rod, and the way it slides [m].
#[derive(Component)]
pub struct Ring {
    from: f32,
    to: f32,
}

const ROD_HEIGHT: f32 = 2.2;

/// Adds the rings and the cloth.
pub fn add_curtain(world: &mut World, particles: u32) {
    let mut ring = |from: f32, to: f32| {
        let mesh =
            Mesh3d(world.resource_mut::<Assets<Mesh>>().add(Sphere::new(0.03).mesh().build()));
        let brass = Look { color: BRASS.into(), roughness: 0.3, metallic: 0.9 };
        world
            .spawn((Ring { from, to }, mesh, Transform::from_xyz(from, ROD_HEIGHT, 0.0), brass))
            .id()
    };
    let (left, right) = (ring(-0.9, -0.62), ring(0.9, 0.62));
    // It starts flat, behind its rings, and swings down.
    let side = Vec2::new(1.8, 1.8);
    world.spawn((
        Cloth::sheet(side, UVec2::splat(particles)),
        ClothMaterial { drag: 1.0, damping: 0.002, ..default() },
        // All of its weight pulls at two threads: more substeps than usual hold the strain there.
        ClothSettings { substeps: Substeps::Automatic { budget: 30 }, ..default() },
        ClothPins::vertices([0])
            .anchored_to(left)
            .and(ClothPins::vertices([particles - 1]).anchored_to(right)),
        Transform::from_xyz(0.0, ROD_HEIGHT, 0.5 * side.y),
        linen(INDIGO),
    ));
}

/// Slides the rings to their places in two seconds.
pub fn slide_rings(mut rings: Query<(&Ring, &mut Transform)>, time: Res<Time>) {
    let way = (0.5 * time.elapsed_secs()).clamp(0.0, 1.0);
    for (ring, mut transform) in &mut rings {
        transform.translation.x = ring.from.lerp(ring.to, way * way * (3.0 - 2.0 * way));
    }
}
