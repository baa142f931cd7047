//! The skirt: a closed tube from the waist to below the knees, with painted weights.

use super::WAIST;
use crate::figure::HIPS;
use bevy::{
    asset::RenderAssetUsages,
    math::ops,
    mesh::{Indices, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
};
use std::f32::consts::TAU;

/// Vertices around, and from the waist to the hem.
const AROUND: usize = 64;
const ROWS: usize = 30;
/// Height of the hem \[m\].
const HEM: f32 = 0.6;
/// Half widths along x and z: at the waist, at the hips, at the hem \[m\].
const WIDTHS: [(f32, Vec2); 3] = [
    (WAIST, Vec2::new(0.135, 0.135)),
    (HIPS, Vec2::new(0.215, 0.15)),
    (HEM, Vec2::new(0.34, 0.32)),
];

/// The skirt as a mesh. Red is painted where it is free: none in the waistband, more and more below the hips.
pub fn skirt() -> Mesh {
    let vertices = || (0..ROWS).flat_map(|row| (0..AROUND).map(move |step| (row, step)));
    let places: Vec<Vec3> = vertices().map(|(row, step)| place(row, step)).collect();
    let free = |at: &Vec3| ((HIPS + 0.06 - at.y) / 0.25).clamp(0.0, 1.0);
    let colors: Vec<[f32; 4]> = places.iter().map(|at| [free(at), 0.0, 0.0, 1.0]).collect();
    let (joints, weights): (Vec<_>, Vec<_>) = places.iter().map(|at| bind(*at)).unzip();
    let mut indices = Vec::new();
    for (row, step) in vertices().filter(|(row, _)| row + 1 < ROWS) {
        let at = |row: usize, step: usize| (row * AROUND + step % AROUND) as u32;
        let [a, b] = [at(row, step), at(row, step + 1)];
        let [c, d] = [at(row + 1, step), at(row + 1, step + 1)];
        // Diagonals to both sides in turn, as they would be in no direction.
        let cells = if (row + step) % 2 == 0 { [a, c, b, b, c, d] } else { [a, d, b, a, c, d] };
        indices.extend(cells);
    }
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, places)
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colors)
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_JOINT_INDEX,
            VertexAttributeValues::Uint16x4(joints),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights)
        .with_inserted_indices(Indices::U32(indices))
        // Weights by angles are 0 in cells as small as these.
        .with_computed_area_weighted_normals()
}

/// A point of the skirt in the pose that it is bound in.
fn place(row: usize, step: usize) -> Vec3 {
    let height = WAIST + (HEM - WAIST) * row as f32 / (ROWS - 1) as f32;
    let [upper, middle, lower] = WIDTHS;
    let (above, below) = if height > middle.0 { (upper, middle) } else { (middle, lower) };
    let widths = below.1.lerp(above.1, (height - below.0) / (above.0 - below.0));
    // From the front, over the left.
    let angle = -TAU * step as f32 / AROUND as f32;
    Vec3::new(widths.x * ops::sin(angle), height, -widths.y * ops::cos(angle))
}

/// The joints that move a point: the hips, and each thigh a part of its own side.
fn bind(at: Vec3) -> ([u16; 4], [f32; 4]) {
    let smooth = |t: f32| t.clamp(0.0, 1.0).powi(2) * (3.0 - 2.0 * t.clamp(0.0, 1.0));
    let thighs = 0.5 * smooth((HIPS - at.y) / 0.25);
    let right = smooth(0.5 + at.x / 0.2);
    ([0, 9, 12, 0], [1.0 - thighs, thighs * (1.0 - right), thighs * right, 0.0])
}
