//! Towels that are dropped on a bench, one after the other: those on the left lie on each other, those on the right do not collide.
//!
//! `cargo run --example pile --features demo`
//!
//! Two components are the difference: `ClothInterCollision` for the others, `ClothSelfCollision` for each towel's own folds.

use bevy::prelude::*;
use bevy_drape::{ClothInterCollision, ClothSelfCollision, prelude::*};
use examples_common::{BRASS, CORAL, Example, IVORY, Particles, TEAL, View, clay, ground, linen};

/// What is told of the example, and where its cloths are at the end.
pub const PILE: Example = Example {
    name: "pile",
    about: "Towels dropped on a bench, which collide with each other, and which do not",
    scene,
    view: View { from: Vec3::new(0.0, 1.15, 2.3), at: Vec3::new(0.0, 0.22, 0.0) },
    bounds: [[-1.6, 0.0, -1.2], [1.6, 1.6, 1.2]],
};

fn main() -> AppExit {
    PILE.show()
}

fn scene(app: &mut App) {
    app.add_systems(Startup, spawn);
}

/// Size of a towel, height of a bench \[m\].
const SIZE: f32 = 0.7;
const HEIGHT: f32 = 0.3;
/// Colours of the towels, from below.
const COLOURS: [Srgba; 4] = [TEAL, IVORY, CORAL, BRASS];

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    for collide in [true, false] {
        let at = Vec3::X * if collide { -0.65 } else { 0.65 };
        spawn_bench(&mut commands, &mut meshes, at);
        for (layer, colour) in COLOURS.into_iter().enumerate() {
            let layer = layer as f32;
            let turned = Quat::from_rotation_y(0.25 + 0.45 * layer);
            let above = Vec3::new(0.02 * layer, HEIGHT + 0.08 + 0.13 * layer, 0.015 * layer);
            // Terry is thick and soft, and its loops hold on to each other and to the floor.
            let terry = ClothMaterial { area_density: 0.4, friction: 0.9, ..ClothMaterial::COTTON };
            let mut towel = commands.spawn((
                Cloth::sheet(Vec2::splat(SIZE), UVec2::splat(particles.0)),
                terry,
                Transform::from_translation(at + above).with_rotation(turned),
                linen(colour),
            ));
            if collide {
                towel.insert((
                    ClothInterCollision { friction: 0.9, ..default() },
                    ClothSelfCollision { friction: 0.9, ..default() },
                ));
            }
        }
    }
}

/// A seat on two legs.
fn spawn_bench(commands: &mut Commands, meshes: &mut Assets<Mesh>, at: Vec3) {
    let seat = Cuboid::new(0.6, 0.04, 0.34);
    let leg = Cuboid::new(0.04, HEIGHT, 0.28);
    let legs = [-0.24, 0.24].map(|side| (leg, Vec3::new(side, 0.5 * HEIGHT, 0.0)));
    for (part, place) in [(seat, HEIGHT * Vec3::Y)].into_iter().chain(legs) {
        commands.spawn((
            SdfCollider::from(part),
            Mesh3d(meshes.add(part)),
            Transform::from_translation(at + place),
            clay(IVORY),
        ));
    }
}
