//! A flag held at its mast streams and flutters in a gusty wind.
//!
//! `cargo run --example flag --features demo`
//!
//! Wind takes two things: a resource that says how it blows, and `ClothAir` on each cloth that is to feel
//! it. The rest is a cloth with its first column pinned. Wind in places (a fan, a blast) is a `WindZone`; wind
//! for one cloth alone is a `ClothWindOverride`.

use bevy::prelude::*;
use bevy_drape::{
    prelude::*,
    solver::{Gusts, Substeps},
};
use examples_common::{BRASS, CORAL, Example, Particles, View, ground, linen, metal};
use std::f32::consts::FRAC_PI_2;

/// What is told of the example, and where its cloths are at the end.
pub const FLAG: Example = Example {
    name: "flag",
    about: "A flag flutters in a gusty wind",
    scene,
    view: View { from: Vec3::new(0.6, 1.45, 4.2), at: Vec3::new(0.15, 1.25, 0.0) },
    bounds: [[-1.0, 0.5, -1.2], [1.0, 2.6, 1.2]],
};

fn main() -> AppExit {
    FLAG.show()
}

fn scene(app: &mut App) {
    // 6 m/s from the mast. Gusts about as large as the flag throw it into folds.
    let gusts = Gusts { strength: 7.0, scale: 1.2, period: 0.5, ..default() };
    app.insert_resource(ClothWind::steady(Vec3::new(6.0, 0.0, 0.6)).with_gusts(gusts))
        .add_systems(Startup, spawn);
}

/// Length and height of the flag, height of its upper edge \[m\].
const SIZE: Vec2 = Vec2::new(1.5, 1.0);
const TOP: f32 = 2.25;

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    let mast = Cylinder::new(0.018, TOP + 0.05);
    let luff = -0.5 * SIZE.x - mast.radius;
    commands.spawn((
        Mesh3d(meshes.add(mast)),
        Transform::from_xyz(luff, mast.half_height, 0.0),
        metal(BRASS),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Sphere::new(0.035))),
        Transform::from_xyz(luff, 2.0 * mast.half_height, 0.0),
        metal(BRASS),
    ));

    let (columns, rows) = (particles.0, (2 * particles.0 / 3).max(2));
    commands.spawn((
        Cloth::sheet(SIZE, UVec2::new(columns, rows)),
        ClothPins::from(PinSelection::FirstColumn),
        // Thin polyester, that feels the air.
        ClothMaterial { area_density: 0.15, ..default() },
        ClothAir::default(),
        // It cracks like a whip at its end: twice the usual substeps hold the strain there.
        ClothSettings { substeps: Substeps::Automatic { budget: 40 }, ..default() },
        // A sheet lies flat; now it stands, its first column along the mast.
        Transform::from_xyz(0.0, TOP - 0.5 * SIZE.y, 0.0)
            .with_rotation(Quat::from_rotation_x(FRAC_PI_2)),
        linen(CORAL),
    ));
}
