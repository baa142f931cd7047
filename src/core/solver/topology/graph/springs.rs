//! Masses and spring constants of a mesh.
//!
//! An edge stands for the cloth of the triangles beside it: `k = ks (A1 + A2) / L^2`. On a grid of
//! rectangles a x b this is the lattice's `ks b / a`, half on the border; the diagonal of a rectangle
//! and the line across it are its two shear springs. On other meshes every edge is structural, and
//! the network is van Gelder's (1998) with Young's modulus ks: isotropic, Poisson's ratio 1/3, and so
//! a shear modulus of 3/8 ks whatever the shear stiffness asked for.

use crate::solver::settings::MassLumping;
use crate::solver::topology::graph::Weights;
use crate::solver::topology::graph::edges::{Edge, Mesh};

/// A spring between two particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Link {
    /// Slots of both ends.
    pub ends: [u32; 2],
    /// Rest length \[m\].
    pub rest: f32,
    /// Shape factor: the spring's constant is this times the material's stiffness.
    pub shape: f32,
}

/// Structural springs, in the order of the edges.
pub(crate) fn structural(edges: &[Edge], lumping: MassLumping, stiffness: &[f32]) -> Vec<Link> {
    let link = |edge: &Edge| {
        // Half of a whole spring comes of the one triangle of a border edge by itself.
        let whole = if edge.sides == 1 && lumping == MassLumping::Equal { 2.0 } else { 1.0 };
        let shape = whole * edge.area / (edge.length * edge.length);
        let shape = shape as f32 * between(stiffness, edge.ends);
        Link { ends: edge.ends, rest: edge.length as f32, shape }
    };
    edges.iter().filter(|edge| !edge.diagonal).map(link).collect()
}

/// Shear springs: of each rectangle its diagonal, then the line across it.
pub(crate) fn shear(mesh: &Mesh<'_>, edges: &[Edge], stiffness: &[f32]) -> Vec<Link> {
    let cell = |edge: &Edge| {
        let across = mesh.distance(edge.opposite[0], edge.opposite[1]);
        let shape = (edge.length * across / (2.0 * edge.area)) as f32;
        let link = |ends: [u32; 2], rest: f64| Link {
            ends,
            rest: rest as f32,
            shape: shape * between(stiffness, ends),
        };
        [link(edge.ends, edge.length), link(edge.opposite, across)]
    };
    edges.iter().filter(|edge| edge.diagonal).flat_map(cell).collect()
}

/// Flexion springs between the corners opposite of an edge (Provot 1995). A hinge of an edge l between
/// triangles of mean height h stores what the lattice's does in cells of side h and width l; where the
/// corners are not across from each other their spring lengthens less, and is stiffer for it.
pub(crate) fn flexion(mesh: &Mesh<'_>, edges: &[Edge], stiffness: &[f32]) -> Vec<Link> {
    let link = |edge: &Edge| {
        let height = edge.area / edge.length;
        let rest = mesh.distance(edge.opposite[0], edge.opposite[1]);
        let slant = rest / (2.0 * height);
        let shape = edge.length / height.powi(5) * slant * slant;
        let shape = shape as f32 * between(stiffness, edge.ends);
        Link { ends: edge.opposite, rest: rest as f32, shape }
    };
    // Of two sheets sewn together along all edges the corners may be one particle.
    let is_hinge =
        |edge: &&Edge| edge.sides == 2 && !edge.diagonal && edge.opposite[0] != edge.opposite[1];
    edges.iter().filter(is_hinge).map(link).collect()
}

/// A factor of both ends.
pub(crate) fn between(stiffness: &[f32], [a, b]: [u32; 2]) -> f32 {
    if stiffness.is_empty() { 1.0 } else { 0.5 * (stiffness[a as usize] + stiffness[b as usize]) }
}

/// Area by slot whose mass a particle carries \[m2\]: a third of each triangle, and a quarter of each
/// rectangle, whichever of its diagonals is there.
pub(crate) fn areas(
    mesh: &Mesh<'_>,
    edges: &[Edge],
    lumping: MassLumping,
    weights: Weights<'_>,
) -> Vec<f32> {
    let particles = mesh.positions.len();
    let mut area = vec![0.0_f64; particles];
    let mut in_cell = vec![false; mesh.triangles.len()];
    for edge in edges.iter().filter(|edge| edge.diagonal) {
        for triangle in edge.triangles {
            in_cell[triangle as usize] = true;
        }
        for slot in edge.ends.into_iter().chain(edge.opposite) {
            area[slot as usize] += edge.area / 4.0;
        }
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if !in_cell[triangle] {
            for &slot in corners {
                area[slot as usize] += mesh.area(triangle) / 3.0;
            }
        }
    }
    if lumping == MassLumping::Equal {
        let each = area.iter().sum::<f64>() / particles as f64;
        area.fill(each);
    }
    let factor = |slot: usize| weights.mass.get(slot).copied().unwrap_or(1.0);
    area.iter().enumerate().map(|(slot, &area)| area as f32 * factor(slot)).collect()
}
