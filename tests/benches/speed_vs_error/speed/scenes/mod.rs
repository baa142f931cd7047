//! The scenes, P1 to P14, HANG and DRAPE, and what they are made of.

mod ball;
mod cantilever;
mod contact;
mod falls;
mod incline;
mod irregular;
mod layers;
mod parts;
mod piles;
pub mod scaling;
mod statics;
mod survival;
mod swing;

use std::sync::Arc;

use bevy::math::{DVec2, Vec3};
use bevy_drape::solver::{Graph, Lattice, MassLumping, Topology};

use super::{Extent, Outcome, Scene};

/// A scene by the name that it is asked for with.
pub const ALL: [(&str, fn(Extent) -> Outcome<Scene<'static>>); 19] = [
    ("hang", falls::hang),
    ("drape", falls::drape),
    ("p1", statics::strip),
    ("p2", statics::curtain),
    ("p3", statics::corners),
    ("p4", swing::scene),
    ("p5", ball::scene),
    ("p6", incline::scene),
    ("p7", cantilever::scene),
    ("p8", survival::scene),
    ("p9", contact::rest::scene),
    ("p10", contact::fast::scene),
    ("p11", contact::poke::scene),
    ("p12", contact::capstan::scene),
    ("p13", irregular::hang),
    ("p13_swing", irregular::swing),
    ("p14", layers::scene),
    ("parts", parts::scene),
    ("scaling", scaling::scene),
];

/// A rectangular sheet of `rows` x `columns` particles.
#[derive(Clone, Copy)]
pub struct Sheet {
    pub rows: usize,
    pub columns: usize,
    /// Spacing along the columns and along the rows \[m\].
    pub cell: DVec2,
    /// Which way its rows follow each other: its columns are along x.
    pub down: Vec3,
    /// Where its first particle starts.
    pub corner: Vec3,
}

impl Sheet {
    /// A square of `n` x `n` particles in the xz plane, about the y axis.
    pub fn flat(n: usize, side: f64, height: f32) -> Self {
        let half = 0.5 * side as f32;
        Self {
            rows: n,
            columns: n,
            cell: DVec2::splat(side / (n - 1) as f64),
            down: Vec3::Z,
            corner: Vec3::new(-half, height, -half),
        }
    }

    /// A square that hangs in the xy plane from its first row, at height 0.
    pub fn upright(n: usize, side: f64) -> Self {
        let corner = Vec3::new(-0.5 * side as f32, 0.0, 0.0);
        Self { down: Vec3::NEG_Y, corner, ..Self::flat(n, side, 0.0) }
    }

    pub fn at(&self, row: usize, column: usize) -> usize {
        row * self.columns + column
    }

    fn rest(&self) -> Vec<Vec3> {
        let place = |i: usize| {
            let (row, column) = ((i / self.columns) as f64, (i % self.columns) as f64);
            Vec3::X * (column * self.cell.x) as f32 + self.down * (row * self.cell.y) as f32
        };
        (0..self.rows * self.columns).map(place).collect()
    }

    /// Where its particles start \[m\].
    pub fn start(&self) -> Vec<Vec3> {
        self.rest().iter().map(|&p| p + self.corner).collect()
    }

    /// As a lattice, or as a mesh of triangles whose diagonals go either way in turns.
    pub fn topology(&self, graph: bool, lumping: MassLumping) -> Outcome<Topology> {
        let rest = self.rest();
        if !graph {
            return Ok(Arc::new(Lattice::new(self.rows, self.columns, &rest, lumping)?).into());
        }
        let mut triangles = Vec::new();
        for row in 0..self.rows - 1 {
            for column in 0..self.columns - 1 {
                let [a, b] = [self.at(row, column), self.at(row, column + 1)].map(|i| i as u32);
                let (c, d) = (a + self.columns as u32, b + self.columns as u32);
                let even = (row + column) % 2 == 0;
                triangles.extend(if even {
                    [[a, c, d], [a, d, b]]
                } else {
                    [[a, c, b], [b, c, d]]
                });
            }
        }
        Ok(Arc::new(Graph::new(&rest, &triangles, lumping)?).into())
    }
}
