//! Bending along the threads of rectangular cells: the lattice's own second differences.
//!
//! Each side between two cells is the width of half a hinge at both of its ends: the particle there
//! and its neighbours across, `D = (x2 - x1) / L2 - (x1 - x0) / L1` with a constant of the rigidity
//! times the width over the mean of both lengths.

use crate::solver::settings::MassLumping;
use crate::solver::topology::graph::edges::{Edge, Mesh};

/// A particle and its neighbours on both sides.
pub(crate) struct Bend {
    /// The particle in the middle, then its neighbours.
    pub slots: [u32; 3],
    /// Distances to both \[m\].
    pub lengths: [f64; 2],
    /// Width of cloth \[m\].
    pub width: f64,
}

/// The cells of a mesh.
pub(crate) struct Cells {
    /// Corners in their order around the cell, by triangle.
    of_triangle: Vec<Option<[u32; 4]>>,
}

impl Cells {
    pub fn new(mesh: &Mesh<'_>, edges: &[Edge]) -> Self {
        let mut of_triangle = vec![None; mesh.triangles.len()];
        for edge in edges.iter().filter(|edge| edge.diagonal) {
            let ([a, b], [p, q]) = (edge.ends, edge.opposite);
            for triangle in edge.triangles {
                of_triangle[triangle as usize] = Some([a, p, b, q]);
            }
        }
        Self { of_triangle }
    }

    /// Whether an edge is a side between two cells.
    pub fn are_beside(&self, edge: &Edge) -> bool {
        edge.sides == 2
            && !edge.diagonal
            && edge.triangles.iter().all(|&triangle| self.of_triangle[triangle as usize].is_some())
    }

    /// The neighbour of `corner` in a triangle's cell that is not `other`.
    fn across(&self, triangle: u32, corner: u32, other: u32) -> Option<u32> {
        let corners = self.of_triangle[triangle as usize]?;
        let at = corners.iter().position(|&slot| slot == corner)?;
        let beside = [corners[(at + 1) % 4], corners[(at + 3) % 4]];
        beside.into_iter().find(|&slot| slot != other)
    }

    /// All bends, those of one particle and the same neighbours as one.
    pub fn bends(&self, mesh: &Mesh<'_>, edges: &[Edge], lumping: MassLumping) -> Vec<Bend> {
        let mut halves: Vec<([u32; 3], f64)> = Vec::new();
        for edge in edges.iter().filter(|edge| self.are_beside(edge)) {
            let [a, b] = edge.ends;
            for (corner, other) in [(a, b), (b, a)] {
                let near = |side: usize| self.across(edge.triangles[side], corner, other);
                if let (Some(p), Some(q)) = (near(0), near(1)) {
                    halves.push(([corner, p.min(q), p.max(q)], 0.5 * edge.length));
                }
            }
        }
        halves.sort_by_key(|&(slots, _)| slots);
        let bend = |halves: &[([u32; 3], f64)]| {
            let slots = halves[0].0;
            let [centre, p, q] = slots;
            let width: f64 = halves.iter().map(|&(_, width)| width).sum();
            // Half of a whole hinge comes of the one side of a border particle by itself.
            let whole = halves.len() == 1 && lumping == MassLumping::Equal;
            Bend {
                slots,
                lengths: [mesh.distance(centre, p), mesh.distance(centre, q)],
                width: if whole { 2.0 * width } else { width },
            }
        };
        halves.chunk_by(|a, b| a.0 == b.0).map(bend).filter(|b| b.slots[1] != b.slots[2]).collect()
    }
}
