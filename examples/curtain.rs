//! A curtain on a rail: thirteen rings, each an anchor for a thread of its top hem, slide together, and it falls
//! into folds. Drag a ring along the rail to draw it, or pull at the cloth.
//!
//! `cargo run --example curtain --features demo`

use bevy::prelude::*;
use bevy_drape::{ClothInterpolation, prelude::*};
use examples_common::{BRASS, Example, INDIGO, Particles, View, ground, linen, metal};
use std::f32::consts::FRAC_PI_2;

/// What is told of the example, and where its cloths are at the end.
pub const CURTAIN: Example = Example {
    name: "curtain",
    about: "A curtain on a rail, that the mouse draws",
    scene,
    view: View { from: Vec3::new(0.6, 1.5, 4.2), at: Vec3::new(-0.15, 1.2, 0.0) },
    bounds: [[-1.3, 0.1, -0.8], [1.3, 2.3, 0.8]],
};

// `headless` runs the scene without a mouse.
#[cfg(feature = "picking")]
fn main() -> AppExit {
    CURTAIN.show_with(|app| {
        app.add_observer(draw_by_mouse);
    })
}

fn scene(app: &mut App) {
    app.add_systems(Startup, spawn).add_systems(FixedUpdate, draw);
}

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

/// A ring, and its part of the way along the curtain.
#[derive(Component)]
pub struct Ring(pub f32);

/// Spawns rail, rings and cloth.
pub fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    let across = Quat::from_rotation_z(FRAC_PI_2);
    let rail = Cylinder::new(0.012, SIZE.x + 0.3).mesh().build().rotated_by(across);
    commands.spawn((
        Rail { now: RANGE.1, wanted: DRAWN },
        Mesh3d(meshes.add(rail)),
        Transform::from_translation(Vec3::Y * RAIL_HEIGHT),
        metal(BRASS),
    ));

    let torus = Torus { minor_radius: 0.005, major_radius: 0.028 };
    let torus = meshes.add(torus.mesh().build().rotated_by(across));
    // Rings are thin: what the mouse takes hold of is around them, and is not seen.
    let handle = Mesh3d(meshes.add(Sphere::new(0.045)));
    let mut pins = ClothPins::none();
    for number in 0..RINGS {
        let along = number as f32 / (RINGS - 1) as f32;
        // Every second hook is behind the rail, so that the cloth knows which way to fold.
        let z = if number % 2 == 0 { 0.012 } else { -0.012 };
        let mut ring = commands.spawn((
            Ring(along),
            Mesh3d(torus.clone()),
            Transform::from_xyz(place(RANGE.1, along), RAIL_HEIGHT - 0.015, z),
            metal(BRASS),
        ));
        let ring = ring.with_child(handle.clone()).id();
        // The ring holds one particle of the first row, and takes it along.
        let vertex = (along * (particles.0 - 1) as f32).round() as u32;
        pins = pins.and(ClothPins::vertices([vertex]).anchored_to(ring));
    }
    commands.spawn((
        Cloth::sheet(SIZE, UVec2::splat(particles.0)),
        ClothMaterial { drag: 1.0, damping: 0.002, ..default() },
        pins,
        // As the rings, which are drawn where the last tick took them.
        ClothInterpolation::LastTick,
        // A sheet lies flat; now it hangs, its first row up.
        Transform::from_xyz(0.0, RAIL_HEIGHT - 0.04 - 0.5 * SIZE.y, 0.0)
            .with_rotation(Quat::from_rotation_x(FRAC_PI_2)),
        linen(INDIGO),
    ));
}

/// Where a ring is on the rail \[m\]: it is drawn towards its left end.
fn place(drawn: f32, along: f32) -> f32 {
    SIZE.x * (drawn * along - 0.5)
}

/// Draws the curtain towards where it is wanted, at half a metre a second. Pins follow their rings.
pub fn draw(
    mut rail: Single<&mut Rail>,
    mut rings: Query<(&Ring, &mut Transform)>,
    time: Res<Time>,
) {
    let step = 0.5 * time.delta_secs() / SIZE.x;
    let to = rail.wanted.clamp(RANGE.0, RANGE.1);
    rail.now += (to - rail.now).clamp(-step, step);
    for (ring, mut transform) in &mut rings {
        transform.translation.x = place(rail.now, ring.0);
    }
}

/// A ring that is dragged follows the pointer along the rail, and takes the others along.
#[cfg(feature = "picking")]
pub fn draw_by_mouse(
    drag: On<Pointer<Drag>>,
    rings: Query<&Ring>,
    handles: Query<&ChildOf>,
    camera: Single<(&Camera, &GlobalTransform)>,
    mut rail: Single<&mut Rail>,
) {
    // The ring itself, or the handle around it.
    let dragged = handles.get(drag.entity).map_or(drag.entity, ChildOf::parent);
    let (Ok(ring), (camera, eye)) = (rings.get(dragged), *camera) else { return };
    // Where the pointer's ray crosses the upright plane of the rail. The first ring is fixed.
    if ring.0 > 0.0
        && let Ok(ray) = camera.viewport_to_world(eye, drag.pointer_location.position)
        && let Some(at) = ray.plane_intersection_point(Vec3::ZERO, InfinitePlane3d::new(Vec3::Z))
    {
        rail.wanted = ((at.x / SIZE.x + 0.5) / ring.0).clamp(RANGE.0, RANGE.1);
    }
}
