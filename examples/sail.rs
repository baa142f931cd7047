//! A square cloth held at its corners fills in a steady wind.
//!
//! `cargo run --example sail --features demo`
//!
//! Each corner is a patch of pinned particles, anchored to an entity that moves. How wind is added is told in
//! `flag.rs`.

use bevy::prelude::*;
use bevy_drape::{prelude::*, solver::Substeps};
use examples_common::{BRASS, Example, IVORY, Particles, TEAL, View, clay, ground, linen, metal};
use std::f32::consts::FRAC_PI_2;

/// What is told of the example, and where its cloths are at the end.
pub const SAIL: Example = Example {
    name: "sail",
    about: "A square sail fills in a steady wind",
    scene,
    view: View { from: Vec3::new(2.9, 1.6, 4.1), at: Vec3::new(0.15, 1.2, 0.2) },
    bounds: [[-1.0, 0.3, -0.1], [1.0, 2.4, 1.2]],
};

fn main() -> AppExit {
    SAIL.show()
}

fn scene(app: &mut App) {
    app.insert_resource(ClothWind::steady(Vec3::new(0.0, 0.0, 6.0)))
        .add_systems(Startup, spawn)
        .add_systems(FixedUpdate, slide);
}

/// Side of the sail, height of its middle \[m\].
const SIDE: f32 = 1.8;
const MIDDLE: f32 = 1.35;

/// Half the side of the patch at a corner \[m\].
const PATCH: f32 = 0.08;

/// Distance of the corners from the middle, across and up: at the start, and then \[m\]. They come together,
/// so that the wind has cloth to fill.
const FAR: f32 = 0.5 * SIDE;
const NEAR: f32 = 0.42 * SIDE;

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    let mast = Cylinder::new(0.035, 2.5);
    commands.spawn((
        SdfCollider::from(mast),
        Mesh3d(meshes.add(mast)),
        Transform::from_xyz(0.0, mast.half_height, -0.08),
        clay(IVORY),
    ));
    let across = Quat::from_rotation_z(FRAC_PI_2);
    let yard = meshes.add(Cylinder::new(0.025, 1.1 * SIDE).mesh().build().rotated_by(across));
    for y in [1.0, -1.0] {
        commands.spawn((Mesh3d(yard.clone()), Slide::inwards(0.0, y), clay(IVORY)));
    }

    let ring = meshes.add(Sphere::new(0.04));
    let mut pins = ClothPins::none();
    for (x, y) in [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
        let ring = commands.spawn((Mesh3d(ring.clone()), Slide::inwards(x, y), metal(BRASS))).id();
        // A patch at the corner, as a sailmaker sews on: one thread could not carry the wind. The sheet
        // lies in its own xz plane, with its first row up.
        let corner = FAR * Vec3::new(x, 0.0, -y);
        let patch = ClothPins::within(corner - PATCH, corner + PATCH);
        pins = pins.and(patch.anchored_to(ring));
    }
    commands.spawn((
        Cloth::sheet(Vec2::splat(SIDE), UVec2::splat(particles.0)),
        // Canvas.
        ClothMaterial {
            area_density: 0.4,
            thread_stiffness: 20_000.0,
            shear_stiffness: 500.0,
            flexural_rigidity: 1e-4,
            ..default()
        },
        // The wind pulls at four corners alone: twice the usual substeps hold the strain there.
        ClothSettings { substeps: Substeps::Automatic { budget: 40 }, ..default() },
        pins,
        ClothAir::default(),
        Transform::from_xyz(0.0, MIDDLE, 0.0).with_rotation(Quat::from_rotation_x(FRAC_PI_2)),
        linen(TEAL),
    ));
}

/// Slides from one place to another \[m\] as the sail is set.
#[derive(Component)]
struct Slide {
    from: Vec3,
    to: Vec3,
}

impl Slide {
    /// Towards the middle, from a side `x` across and `y` up.
    fn inwards(x: f32, y: f32) -> (Self, Transform) {
        let [from, to] = [FAR, NEAR].map(|by| Vec3::new(x * by, MIDDLE + y * by, 0.0));
        (Self { from, to }, Transform::from_translation(from))
    }
}

/// Slides all, gently. Pins follow what they are anchored to.
fn slide(mut sliding: Query<(&Slide, &mut Transform)>, time: Res<Time>) {
    let way = (time.elapsed_secs() / 1.5).clamp(0.0, 1.0);
    for (slide, mut transform) in &mut sliding {
        transform.translation = slide.from.lerp(slide.to, way * way * (3.0 - 2.0 * way));
    }
}
