//! Towels that fold onto themselves: one that falls on a corner into a heap, one over a bench, whose corners come to lie on the
//! floor. Those in front are the same, but they do not collide with themselves.
//!
//! `cargo run --example heap --features demo`
//!
//! One component is the difference. What has passed through itself is red with `--features demo,gizmos` and `--gizmos crossings`.

use bevy::prelude::*;
use bevy_drape::{ClothSelfCollision, prelude::*};
use examples_common::{CORAL, Example, IVORY, Particles, TEAL, View, clay, ground, linen};

/// What is told of the example, and where its cloths are at the end.
pub const HEAP: Example = Example {
    name: "heap",
    about: "Towels in folds, two that collide with themselves and two that do not",
    scene,
    view: View { from: Vec3::new(0.0, 1.75, 2.75), at: Vec3::new(0.0, 0.06, 0.0) },
    bounds: [[-2.2, 0.0, -2.2], [2.2, 1.6, 2.2]],
};

fn main() -> AppExit {
    HEAP.show()
}

fn scene(app: &mut App) {
    app.add_systems(Startup, spawn);
}

/// Size of a towel, height of a bench \[m\].
const SIZE: f32 = 1.0;
const HEIGHT: f32 = 0.2;

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    for collides in [true, false] {
        let to_the_front = if collides { -0.5 } else { 0.45 };
        let towels = [
            spawn_heap(&mut commands, particles.0, Vec3::new(-0.6, 0.0, to_the_front)),
            spawn_bench(&mut commands, &mut meshes, particles.0, Vec3::new(0.6, 0.0, to_the_front)),
        ];
        for towel in towels {
            let mut towel = commands.entity(towel);
            if collides {
                towel.insert((ClothSelfCollision::default(), linen(TEAL)));
            } else {
                towel.insert(linen(CORAL));
            }
        }
    }
}

/// A towel, still without its colour.
fn towel(particles: u32, place: Transform) -> impl Bundle {
    // Terry is thick and soft, and its loops hold on to each other and to the floor.
    let terry = ClothMaterial { area_density: 0.4, friction: 0.9, ..ClothMaterial::COTTON };
    (Cloth::sheet(Vec2::splat(SIZE), UVec2::splat(particles)), terry, place)
}

/// A towel that stands on a corner, in the air.
fn spawn_heap(commands: &mut Commands, particles: u32, at: Vec3) -> Entity {
    let turned = Quat::from_euler(EulerRot::YXZ, 0.4, 1.45, 0.0) * Quat::from_rotation_y(0.7);
    let place = Transform::from_translation(at + 0.8 * SIZE * Vec3::Y).with_rotation(turned);
    commands.spawn(towel(particles, place)).id()
}

/// A bench, and a towel above.
fn spawn_bench(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    particles: u32,
    at: Vec3,
) -> Entity {
    let seat = Cuboid::new(0.46, 0.04, 0.3);
    let leg = Cuboid::new(0.04, HEIGHT, 0.26);
    let legs = [-0.18, 0.18].map(|side| (leg, Vec3::new(side, 0.5 * HEIGHT, 0.0)));
    for (part, place) in [(seat, HEIGHT * Vec3::Y)].into_iter().chain(legs) {
        commands.spawn((
            SdfCollider::from(part),
            Mesh3d(meshes.add(part)),
            Transform::from_translation(at + place),
            clay(IVORY),
        ));
    }
    let place =
        Transform::from_translation(at + 0.4 * Vec3::Y).with_rotation(Quat::from_rotation_y(0.35));
    commands.spawn(towel(particles, place)).id()
}
