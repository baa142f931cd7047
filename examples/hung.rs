//! Two curtains on rings that are nearer to each other than their corners: one starts hung, at rest, by
//! Weil's geometric model; the other starts flat, and swings down.
//!
//! `cargo run --example hung --features demo`

use bevy::prelude::*;
use bevy_drape::{prelude::*, solver::Substeps};
use examples_common::{BRASS, Example, INDIGO, Particles, TEAL, View, ground, linen, metal};

/// What is told of the example, and where its cloths are at the end.
pub const HUNG: Example = Example {
    name: "hung",
    about: "A curtain that starts hung, beside one that starts flat",
    scene,
    view: View { from: Vec3::new(0.0, 1.7, 5.4), at: Vec3::new(0.0, 1.2, 0.0) },
    bounds: [[-2.5, 0.0, -2.4], [2.5, 2.6, 2.4]],
};

fn main() -> AppExit {
    HUNG.show()
}

fn scene(app: &mut App) {
    app.add_systems(Startup, spawn).add_systems(FixedUpdate, slide);
}

/// Height of the rings, side of both cloths \[m\].
const RINGS: f32 = 2.3;
const SIDE: f32 = 1.6;
/// Distance of a ring from the middle of its curtain \[m\], where that hangs.
const HALF_SPAN: f32 = 0.68;

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    let rings = spawn_rings(&mut commands, &mut meshes, -1.0, HALF_SPAN);
    let mut hung = commands.spawn((curtain(rings, particles.0, -1.0), linen(TEAL)));
    // Where it hangs is worked out in the background, from its pins. It starts there.
    hung.insert(HangOnStart::default());

    let rings = spawn_rings(&mut commands, &mut meshes, 1.0, 0.5 * SIDE);
    commands.spawn((curtain(rings, particles.0, 1.0), linen(INDIGO)));
}

/// A cloth that lies flat, its first two corners held by rings.
fn curtain([left, right]: [Entity; 2], particles: u32, middle: f32) -> impl Bundle {
    (
        Cloth::sheet(Vec2::splat(SIDE), UVec2::splat(particles)),
        // All of its weight pulls at two threads: more substeps than usual hold the strain there.
        ClothSettings { substeps: Substeps::Automatic { budget: 30 }, ..default() },
        ClothPins::vertices([0])
            .anchored_to(left)
            .and(ClothPins::vertices([particles - 1]).anchored_to(right)),
        Transform::from_xyz(middle, RINGS, 0.5 * SIDE),
    )
}

/// Two rings that slide from `half_span` to where the curtain hangs.
fn spawn_rings(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    middle: f32,
    half_span: f32,
) -> [Entity; 2] {
    [-1.0, 1.0].map(|side| {
        let place = |half: f32| Vec3::new(middle + side * half, RINGS, 0.0);
        let ring = commands.spawn((
            Slide { from: place(half_span), to: place(HALF_SPAN) },
            Mesh3d(meshes.add(Sphere::new(0.03))),
            Transform::from_translation(place(half_span)),
            metal(BRASS),
        ));
        ring.id()
    })
}

/// Slides from one place to another \[m\] in the first second.
#[derive(Component)]
struct Slide {
    from: Vec3,
    to: Vec3,
}

/// Slides all, gently. Pins follow what they are anchored to.
fn slide(mut sliding: Query<(&Slide, &mut Transform)>, time: Res<Time>) {
    let way = time.elapsed_secs().clamp(0.0, 1.0);
    for (slide, mut transform) in &mut sliding {
        transform.translation = slide.from.lerp(slide.to, way * way * (3.0 - 2.0 * way));
    }
}
