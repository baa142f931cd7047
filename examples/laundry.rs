//! A shirt that falls over a towel on a rail: on the left they collide, on the right they do not.
//!
//! `cargo run --example laundry --features demo`
//!
//! The shirt is an irregular mesh, the towel a sheet of another spacing; they need no more than `ClothInterCollision`.

use bevy::prelude::*;
use bevy_drape::{ClothInterCollision, prelude::*};
use examples_common::{
    BRASS, CORAL, Example, IVORY, Particles, TEAL, View, ground, linen, metal, shirt,
};
use std::f32::consts::FRAC_PI_2;

/// What is told of the example, and where its cloths are at the end.
pub const LAUNDRY: Example = Example {
    name: "laundry",
    about: "A shirt over a towel on a rail, which collide with each other, and which do not",
    scene,
    view: View { from: Vec3::new(0.0, 1.7, 2.7), at: Vec3::new(0.0, 0.85, 0.0) },
    bounds: [[-2.2, 0.0, -1.5], [2.2, 2.0, 1.5]],
};

fn main() -> AppExit {
    LAUNDRY.show()
}

fn scene(app: &mut App) {
    app.add_systems(Startup, spawn);
}

/// Height of the rail \[m\].
const RAIL: f32 = 1.2;

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    for collide in [true, false] {
        let at = Vec3::new(if collide { -0.8 } else { 0.8 }, RAIL, 0.0);
        let rail = Capsule3d::new(0.04, 1.2);
        commands.spawn((
            SdfCollider::from(rail).with_friction(0.9),
            Mesh3d(meshes.add(rail)),
            Transform::from_translation(at).with_rotation(Quat::from_rotation_z(FRAC_PI_2)),
            metal(BRASS),
        ));
        let cotton = ClothMaterial { friction: 0.9, ..ClothMaterial::COTTON };
        let towel = (
            Cloth::sheet(Vec2::new(0.9, 1.1), UVec2::new(particles.0 * 9 / 11, particles.0)),
            cotton,
            Transform::from_translation(at + 0.08 * Vec3::Y),
            linen(if collide { TEAL } else { CORAL }),
        );
        let shirt = (
            Cloth::of_mesh3d(),
            Mesh3d(meshes.add(shirt(particles.0))),
            cotton,
            // It lies on its back, its middle over the rail.
            Transform::from_translation(at + Vec3::new(0.0, 0.35, -0.3))
                .with_rotation(Quat::from_rotation_x(-FRAC_PI_2)),
            linen(IVORY),
        );
        let cloths = [commands.spawn(towel).id(), commands.spawn(shirt).id()];
        if collide {
            for cloth in cloths {
                commands.entity(cloth).insert(ClothInterCollision { friction: 0.9, ..default() });
            }
        }
    }
}
