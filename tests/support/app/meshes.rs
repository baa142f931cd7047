//! Meshes that become cloths, or colliders.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};

/// A grid of quads with its vertices renamed by `name`, in the places that `place` gives to its rows and
/// columns.
pub fn grid_mesh(
    rows: u32,
    columns: u32,
    name: impl Fn(u32) -> u32,
    place: impl Fn(u32, u32) -> Vec3,
) -> Mesh {
    let mut positions = vec![[0.0; 3]; (rows * columns) as usize];
    for r in 0..rows {
        for c in 0..columns {
            positions[name(r * columns + c) as usize] = place(r, c).to_array();
        }
    }
    let mut indices = Vec::new();
    for r in 0..rows - 1 {
        for c in 0..columns - 1 {
            let a = r * columns + c;
            let (b, below, d) = (a + 1, a + columns, a + columns + 1);
            indices.extend([a, below, b, b, below, d].map(&name));
        }
    }
    triangle_mesh(positions, indices)
}

/// Cells of a metre, in rows along z.
pub fn flat_mesh(rows: u32, columns: u32) -> Mesh {
    grid_mesh(rows, columns, |v| v, |r, c| Vec3::new(c as f32, 0.0, r as f32))
}

/// A metre of cloth, `n` x `n`, with the cell of this row and column cut out: no grid.
pub fn mesh_without(n: u32, [row, column]: [u32; 2]) -> Mesh {
    let place = |i: u32| i as f32 / (n - 1) as f32 - 0.5;
    let mut mesh = grid_mesh(n, n, |v| v, |r, c| Vec3::new(place(c), 0.0, place(r)));
    let Some(Indices::U32(indices)) = mesh.indices_mut() else { panic!("it has indices") };
    let hole = 6 * (row * (n - 1) + column) as usize;
    indices.drain(hole..hole + 6);
    mesh
}

/// A metre of cloth, 8 x 8 as the sheet, with one cell cut out.
pub fn holed_mesh() -> Mesh {
    mesh_without(8, [3, 3])
}

/// A strip that goes through itself once, in a loop of a trochoid.
pub fn looped_mesh() -> Mesh {
    grid_mesh(
        5,
        24,
        |v| v,
        |r, c| {
            let along = 6.0 * c as f32 / 23.0 - 3.0;
            let (sin, cos) = along.sin_cos();
            // Askew, so that no thread goes through another.
            let across = 0.03 * r as f32 + 0.01 * along;
            Vec3::new(0.05 * along - 0.1 * sin, -0.1 * cos, across)
        },
    )
}

pub fn triangle_mesh(positions: Vec<[f32; 3]>, indices: Vec<u32>) -> Mesh {
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(indices))
}

/// A closed box around the origin.
pub fn box_mesh(half: f32) -> Mesh {
    let corner = |i: u32| [1, 2, 4].map(|bit| if i & bit == 0 { -half } else { half });
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    triangle_mesh((0..8).map(corner).collect(), indices)
}
