//! Sheets: lattices, and meshes that are none.

use std::sync::Arc;

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{Graph, Lattice, MassLumping, Topology};

use super::dice::Dice;

/// A flat sheet in the xz plane.
pub fn sheet(size: Vec2, rows: usize, columns: usize, lumping: MassLumping) -> Arc<Lattice> {
    Arc::new(Lattice::sheet(size, rows, columns, lumping).unwrap())
}

/// A flat sheet in the xy plane, its first row on top at y = 0.
pub fn curtain(size: Vec2, rows: usize, columns: usize, lumping: MassLumping) -> Arc<Lattice> {
    let positions: Vec<_> = (0..rows)
        .flat_map(|r| (0..columns).map(move |c| (r, c)))
        .map(|(r, c)| {
            let (x, y) = (c as f32 / (columns - 1) as f32, r as f32 / (rows - 1) as f32);
            Vec3::new((x - 0.5) * size.x, -y * size.y, 0.0)
        })
        .collect();
    Arc::new(Lattice::new(rows, columns, &positions, lumping).unwrap())
}

/// The triangles of the cell whose first particle is `at`, in rows of `columns`: cut from there across,
/// or along the other diagonal.
pub fn halves(at: u32, columns: usize, across_from_first: bool) -> [[u32; 3]; 2] {
    let (right, below, across) = (at + 1, at + columns as u32, at + columns as u32 + 1);
    if across_from_first {
        [[at, below, across], [at, across, right]]
    } else {
        [[at, below, right], [right, below, across]]
    }
}

/// A sheet of `rows` x `columns` particles in the xz plane, `cell` apart, triangulated with diagonals
/// at random; inner particles are off by up to `jitter` cells. Rows along z, columns along x, the
/// first particle at the origin.
pub fn jittered(
    rows: usize,
    columns: usize,
    cell: f32,
    jitter: f32,
    seed: u64,
) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut dice = Dice(seed);
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for r in 0..rows {
        for c in 0..columns {
            let inner = r > 0 && r + 1 < rows && c > 0 && c + 1 < columns;
            let (x, z) = (dice.roll() * jitter, dice.roll() * jitter);
            let off = if inner { Vec3::new(x, 0.0, z) } else { Vec3::ZERO };
            positions.push((Vec3::new(c as f32, 0.0, r as f32) + off) * cell);
            if r + 1 == rows || c + 1 == columns {
                continue;
            }
            let at = (r * columns + c) as u32;
            triangles.extend(halves(at, columns, dice.roll() > 0.0));
        }
    }
    (positions, triangles)
}

/// The ground of a level: hills of five by five metres that end at a border, in 20,000 triangles.
pub fn ground_of_a_level() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut positions, triangles) = jittered(101, 101, 0.05, 0.3, 81);
    for p in &mut positions {
        p.y = 0.2 * (2.0 * p.x).sin() * (3.0 * p.z).cos();
    }
    (positions, triangles)
}

/// A graph of a [`jittered`] sheet, lumped.
pub fn mesh(rows: usize, columns: usize, cell: f32, jitter: f32) -> Arc<Graph> {
    let (positions, triangles) = jittered(rows, columns, cell, jitter, 7);
    Arc::new(Graph::new(&positions, &triangles, MassLumping::Lumped).unwrap())
}

/// A sheet of nearly equilateral triangles of side `side` in the xz plane, rows along x; odd rows
/// begin half a side later, with the same number of particles, and the borders across are cut
/// straight.
pub fn hexagonal(rows: usize, columns: usize, side: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let height = side * 0.75_f32.sqrt();
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for r in 0..rows {
        for c in 0..columns {
            let shift = if r % 2 == 1 { 0.5 } else { 0.0 };
            let last = columns as f32 - 1.0;
            let x = if c == 0 { 0.0 } else { (c as f32 + shift).min(last) };
            let x = if c + 2 == columns && r % 2 == 1 { last - 0.5 } else { x };
            positions.push(Vec3::new(x * side, 0.0, r as f32 * height));
            if r + 1 == rows || c + 1 == columns {
                continue;
            }
            let at = (r * columns + c) as u32;
            triangles.extend(halves(at, columns, r % 2 == 1));
        }
    }
    (positions, triangles)
}

/// A square of a side of `side` metres and `n` x `n` particles in the xz plane, as a lattice around the origin
/// and as a [`mesh`] from the origin on.
pub fn lattice_and_mesh(side: f32, n: usize) -> [(&'static str, Topology); 2] {
    let lattice = sheet(Vec2::splat(side), n, n, MassLumping::Lumped);
    [("lattice", lattice.into()), ("mesh", mesh(n, n, side / (n - 1) as f32, 0.25).into())]
}
