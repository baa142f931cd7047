//! A cape on the shoulders of a skinned character that walks in a circle. The cape is a mesh without rows
//! and columns.
//!
//! `cargo run --example cape --features demo`
//!
//! Two things join a cape to a character. Its collar is anchored to a joint, and the joints have
//! colliders, so that it lies on the body. The character itself is in `common/figure.rs`, its skin in
//! `common/body.rs`.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology, skinning::SkinnedMeshInverseBindposes},
    prelude::*,
};
use bevy_drape::{ClothInterpolation, prelude::*};
use examples_common::{
    BRASS, Example, INDIGO, Particles, View,
    figure::{CHEST, CHEST_HEIGHT, place, spawn_figure, walk},
    ground, linen, metal,
};

/// What is told of the example, and where its cloths are at the end.
pub const CAPE: Example = Example {
    name: "cape",
    about: "A cape on the shoulders of a figure that walks",
    scene,
    view: View { from: Vec3::new(0.0, 1.4, 4.1), at: Vec3::new(0.0, 0.88, 0.0) },
    bounds: [[-2.2, 0.1, -2.2], [2.2, 1.6, 2.2]],
};

fn main() -> AppExit {
    CAPE.show()
}

fn scene(app: &mut App) {
    app.add_systems(Startup, spawn).add_systems(FixedUpdate, walk);
}

/// Spawns the figure and its cape.
fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut bindposes: ResMut<Assets<SkinnedMeshInverseBindposes>>,
    particles: Res<Particles>,
) {
    commands.spawn(ground(&mut meshes));
    let limbs = spawn_figure(&mut commands, &mut meshes, &mut bindposes);
    // A capsule on each bone, which goes where its joint goes.
    for limb in &limbs {
        let capsule = SdfCollider::capsule_between(limb.from, limb.to, limb.radius);
        commands.entity(limb.joint).insert(capsule.with_friction(0.2));
    }
    let chest = limbs[CHEST].joint;
    // Two clasps where the collar ends, on the shoulders.
    for across in [-1.0, 1.0] {
        commands.spawn((
            ChildOf(chest),
            Mesh3d(meshes.add(Sphere::new(0.018))),
            Transform::from_translation(shape(across, 0.0) - Vec3::Y * CHEST_HEIGHT),
            metal(BRASS),
        ));
    }
    let (mesh, collar) = cape(particles.0 as usize);
    commands.spawn((
        // The mesh beside it is the cloth.
        Cloth::of_mesh3d(),
        Mesh3d(meshes.add(mesh)),
        // Wool, heavy enough to stay near the back.
        ClothMaterial { area_density: 0.3, thickness: 0.01, friction: 0.2, ..default() },
        // From where the chest is now, the collar goes where it goes.
        ClothPins::vertices(0..collar as u32).anchored_to(chest),
        ClothAir::default(),
        // As the figure, which is drawn where the last tick took it.
        ClothInterpolation::LastTick,
        place(0.0),
        linen(INDIGO),
    ));
}

/// A cape around the back of the figure, `columns` vertices wide at the hem and half as many at the
/// collar: no grid. Tells how many vertices the collar has; they are the first.
fn cape(columns: usize) -> (Mesh, usize) {
    let rows = (3 * columns / 4).max(2);
    let wide = |row: usize| (columns / 2 + row * (columns - columns / 2) / (rows - 1)).max(2);
    let (mut positions, mut uvs, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..rows {
        let down = row as f32 / (rows - 1) as f32;
        let (above, count) = (positions.len(), wide(row));
        for column in 0..count {
            let across = column as f32 / (count - 1) as f32;
            positions.push(shape(2.0 * across - 1.0, down));
            uvs.push([across, down]);
        }
        if row + 1 < rows {
            join(&mut indices, above..above + count, wide(row + 1));
        }
    }
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
        .with_inserted_indices(Indices::U32(indices))
        .with_computed_smooth_normals();
    (mesh, wide(0))
}

/// A point of the cape in the frame of the figure's ground \[m\], `across` from -1 to 1: it starts on the
/// shoulders and around the neck, keeps clear of the arms, and falls as part of a cone.
fn shape(across: f32, down: f32) -> Vec3 {
    let (sin, cos) = (80.0_f32.to_radians() * across).sin_cos();
    let (side, back) = (0.17 + 0.36 * down, 0.065 + 0.4 * down);
    let clear = 0.1 * (down / 0.15).min(1.0);
    Vec3::new(side * sin, 1.47 - 0.025 * across * across - 1.1 * down, back * cos + clear)
}

/// Triangles between a row of vertices and the next one, which has `count`.
fn join(indices: &mut Vec<u32>, row: std::ops::Range<usize>, count: usize) {
    let (mut a, mut b) = (0, 0);
    while a + 1 < row.len() || b + 1 < count {
        let (upper, lower) = ((row.start + a) as u32, (row.end + b) as u32);
        // Whichever is behind goes on.
        if b + 1 < count && (b + 1) * (row.len() - 1) <= (a + 1) * (count - 1) {
            indices.extend([upper, lower, lower + 1]);
            b += 1;
        } else {
            indices.extend([upper, lower, upper + 1]);
            a += 1;
        }
    }
}
