//! Towels that fold onto themselves: one that falls on its edge into a heap, one over a bench, whose corners come to lie on the
//! floor. Those in front are the same, but they do not collide with themselves.
//!
//! `cargo run --example heap --features demo`
//!
//! One component is the difference. What has passed through itself is red with `--features demo,gizmos` and `--gizmos crossings`.

use bevy::prelude::*;
use bevy_drape::{ClothSelfCollision, prelude::*};
use examples_common::{CORAL, Example, IVORY, Particles, SAND, TEAL, View, clay, ground, linen};

/// What is told of the example, and where its cloths are at the end.
pub const HEAP: Example = Example {
    name: "heap",
    about: "Towels in folds, two that collide with themselves and two that do not",
    scene,
    view: View { from: Vec3::new(0.0, 2.1, 3.6), at: Vec3::new(0.0, 0.05, -0.1) },
    bounds: [[-2.2, 0.0, -2.2], [2.2, 1.6, 2.2]],
};

fn main() -> AppExit {
    HEAP.show()
}

fn scene(app: &mut App) {
    app.add_systems(Startup, spawn);
}

/// Size of a towel \[m\].
const SIZE: f32 = 1.0;

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    for collides in [true, false] {
        let to_the_front = if collides { -0.75 } else { 0.55 };
        let towels = [
            spawn_heap(&mut commands, particles.0, Vec3::new(-0.7, 0.0, to_the_front)),
            spawn_bench(&mut commands, &mut meshes, particles.0, Vec3::new(0.7, 0.0, to_the_front)),
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

/// A towel that stands nearly on its edge, in the air.
fn spawn_heap(commands: &mut Commands, particles: u32, at: Vec3) -> Entity {
    let turned = Quat::from_rotation_y(0.5) * Quat::from_rotation_x(1.45);
    let place = Transform::from_translation(at + 0.6 * SIZE * Vec3::Y).with_rotation(turned);
    commands.spawn(towel(particles, place)).id()
}

/// A bench, and a towel above.
fn spawn_bench(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    particles: u32,
    at: Vec3,
) -> Entity {
    let seat = Capsule3d::new(0.07, 0.5);
    let leg = Cylinder::new(0.03, 0.2);
    for side in [-1.0, 1.0] {
        let lying = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
        commands.spawn((
            SdfCollider::from(seat),
            Mesh3d(meshes.add(seat)),
            Transform::from_translation(at + Vec3::new(0.0, 0.22, 0.07 * side))
                .with_rotation(lying),
            clay(IVORY),
        ));
        commands.spawn((
            SdfCollider::from(leg),
            Mesh3d(meshes.add(leg)),
            Transform::from_translation(at + Vec3::new(0.2 * side, 0.1, 0.0)),
            clay(SAND),
        ));
    }
    let place =
        Transform::from_translation(at + 0.4 * Vec3::Y).with_rotation(Quat::from_rotation_y(0.35));
    commands.spawn(towel(particles, place)).id()
}
