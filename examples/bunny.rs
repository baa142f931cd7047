//! The Stanford bunny, baked to a distance field at the start, hops through a curtain.
//!
//! `cargo run --example bunny --features demo`
//!
//! A mesh that cloth is to meet takes one component, `BakeSdf`, and may move at will once it is baked.
//! `bake.rs` bakes ahead of time, to a file.

use bevy::prelude::*;
use bevy_drape::{ClothInterpolation, prelude::*};
use examples_common::{
    BRASS, CORAL, Example, IVORY, Particles, View, clay, ground, linen, load_bunny, metal,
};
use std::f32::consts::FRAC_PI_2;

/// What is told of the example, and where its cloths are at the end.
pub const BUNNY: Example = Example {
    name: "bunny",
    about: "The Stanford bunny hops through a curtain",
    scene,
    view: View { from: Vec3::new(1.9, 1.6, 4.3), at: Vec3::new(0.05, 0.75, 0.3) },
    bounds: [[-1.3, 0.0, -1.8], [1.3, 1.8, 1.8]],
};

fn main() -> AppExit {
    BUNNY.show()
}

fn scene(app: &mut App) {
    // What moves in the fixed schedule moves in the same way at every frame rate.
    app.add_systems(Startup, spawn).add_systems(FixedUpdate, hop);
}

/// Where the bunny starts \[m\].
const START: Vec3 = Vec3::new(0.0, 0.0, -1.25);

/// Height of the rod, width and height of the curtain \[m\].
const ROD: f32 = 1.75;
const SIZE: Vec2 = Vec2::new(2.0, 1.65);

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    let place = Transform::from_translation(START).with_rotation(ahead(0.0));
    commands.spawn((
        Hopping,
        // Beside a closed mesh: it is baked in the background, and then collides.
        BakeSdf::with_cells(96),
        Mesh3d(meshes.add(load_bunny())),
        place.with_scale(Vec3::splat(1.3)),
        clay(IVORY),
    ));

    let across = Quat::from_rotation_z(FRAC_PI_2);
    commands.spawn((
        Mesh3d(meshes.add(Cylinder::new(0.02, SIZE.x + 0.2).mesh().build().rotated_by(across))),
        Transform::from_translation(Vec3::Y * ROD),
        metal(BRASS),
    ));
    commands.spawn((
        Cloth::sheet(SIZE, UVec2::splat(particles.0)),
        ClothPins::from(PinSelection::FirstRow),
        // The ears are hardly thicker than the spacing of the particles: the cloth keeps off a little.
        ClothMaterial { thickness: 0.02, friction: 0.2, drag: 0.5, ..default() },
        // As the bunny, which is drawn where the last tick took it.
        ClothInterpolation::LastTick,
        // A sheet lies flat; now it hangs, its first row up.
        Transform::from_xyz(0.0, ROD - 0.5 * SIZE.y, 0.0)
            .with_rotation(Quat::from_rotation_x(FRAC_PI_2)),
        linen(CORAL),
    ));
}

/// What hops towards +z.
#[derive(Component)]
struct Hopping;

/// Length of a hop \[m\], its height \[m\], and how many there are.
const HOP: (f32, f32, f32) = (0.45, 0.22, 5.0);

/// Seconds that a hop takes, and before the first.
const HOP_TIME: f32 = 0.6;
const PAUSE: f32 = 0.5;

/// Lets it hop, along parabolas. The collider follows its transform.
fn hop(mut bunny: Single<&mut Transform, With<Hopping>>, time: Res<Time>) {
    let (length, height, count) = HOP;
    let hops = ((time.elapsed_secs() - PAUSE) / HOP_TIME).clamp(0.0, count);
    let part = hops.fract();
    let up = 4.0 * height * part * (1.0 - part);
    bunny.translation = START + Vec3::new(0.0, up, length * hops);
    // Its nose up, then down.
    bunny.rotation = ahead(0.25 * (part - 0.5) * up / height);
}

/// The bunny turned to look towards +z, its nose down by an angle \[rad\].
fn ahead(down: f32) -> Quat {
    Quat::from_rotation_x(down) * Quat::from_rotation_y(FRAC_PI_2)
}
