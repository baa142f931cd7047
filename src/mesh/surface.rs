//! The triangles of a mesh as a surface of particles: welded, and rid of what is no triangle.

use bevy::math::Vec3;
use bevy::platform::collections::HashSet;

use crate::error::problems::MeshProblem;
use crate::mesh::weld::{NONE, tolerance, weld};

/// Triangles of a mesh that are no part of its cloth. They are still drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SkippedTriangles {
    /// Two corners are the same vertex, or vertices at the same place.
    pub collapsed: usize,
    /// The corners are different, but lie on one line.
    pub zero_area: usize,
    /// Another triangle has the same three corners, whichever way it faces.
    pub duplicate: usize,
}

impl SkippedTriangles {
    /// All of them.
    pub fn total(&self) -> usize {
        self.collapsed + self.zero_area + self.duplicate
    }
}

/// A surface of at least two triangles.
#[derive(Debug)]
pub(crate) struct Surface {
    /// The particle of each vertex; [`NONE`] where no triangle uses its place.
    pub particle_of_vertex: Vec<u32>,
    /// The first vertex of each particle, ascending.
    pub vertex_of_particle: Vec<u32>,
    /// Triangles of particles, in the order of the mesh.
    pub triangles: Vec<[u32; 3]>,
    pub skipped: SkippedTriangles,
}

impl Surface {
    /// # Errors
    /// [`MeshProblem`] where fewer than two triangles are left.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self, MeshProblem> {
        if triangles.is_empty() {
            return Err(MeshProblem::Empty);
        }
        let vertices = positions.len();
        if let Some(&index) = triangles.iter().flatten().find(|&&i| i as usize >= vertices) {
            return Err(MeshProblem::BadIndex { index, vertices });
        }
        let used = used_by(triangles, vertices);
        let tolerance = tolerance(positions, &used);
        let first_of = weld(positions, &used, tolerance);
        let mut skipped = SkippedTriangles::default();
        let mut known = HashSet::with_capacity(triangles.len());
        let mut kept = Vec::with_capacity(triangles.len());
        for triangle in triangles {
            let corners = triangle.map(|vertex| first_of[vertex as usize]);
            let [a, b, c] = corners;
            let mut sorted = corners;
            sorted.sort_unstable();
            if a == b || b == c || c == a {
                skipped.collapsed += 1;
            } else if is_line(corners.map(|v| positions[v as usize]), tolerance) {
                skipped.zero_area += 1;
            } else if !known.insert(sorted) {
                skipped.duplicate += 1;
            } else {
                kept.push(corners);
            }
        }
        match kept.len() {
            0 => return Err(MeshProblem::AllDegenerate { triangles: triangles.len() }),
            1 => return Err(MeshProblem::OneTriangle { skipped: skipped.total() }),
            _ => {}
        }
        Ok(Self::of_vertices(&first_of, kept, skipped))
    }

    /// Numbers the places that triangles use, in the order of their first vertices.
    fn of_vertices(first_of: &[u32], mut kept: Vec<[u32; 3]>, skipped: SkippedTriangles) -> Self {
        let is_particle = used_by(&kept, first_of.len());
        let vertex_of_particle: Vec<u32> =
            (0..first_of.len() as u32).filter(|vertex| is_particle[*vertex as usize]).collect();
        let mut particle_of_vertex = vec![NONE; first_of.len()];
        for (particle, &vertex) in vertex_of_particle.iter().enumerate() {
            particle_of_vertex[vertex as usize] = particle as u32;
        }
        for (vertex, &first) in first_of.iter().enumerate().filter(|(_, first)| **first != NONE) {
            particle_of_vertex[vertex] = particle_of_vertex[first as usize];
        }
        for corner in kept.iter_mut().flatten() {
            *corner = particle_of_vertex[*corner as usize];
        }
        Self { particle_of_vertex, vertex_of_particle, triangles: kept, skipped }
    }

    /// Edges with more than two triangles.
    pub fn crowded_edge_count(&self) -> usize {
        let mut edges: Vec<_> = self
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect();
        edges.sort_unstable();
        edges.chunk_by(|a, b| a == b).filter(|same| same.len() > 2).count()
    }

    /// Parts that no triangle connects.
    pub fn piece_count(&self) -> usize {
        let mut parent: Vec<u32> = (0..self.vertex_of_particle.len() as u32).collect();
        let root = |parent: &mut Vec<u32>, mut at: u32| {
            while parent[at as usize] != at {
                parent[at as usize] = parent[parent[at as usize] as usize];
                at = parent[at as usize];
            }
            at
        };
        let mut pieces = parent.len();
        for &[a, b, c] in &self.triangles {
            for (from, to) in [(a, b), (b, c)] {
                let (from, to) = (root(&mut parent, from), root(&mut parent, to));
                if from != to {
                    parent[from.max(to) as usize] = from.min(to);
                    pieces -= 1;
                }
            }
        }
        pieces
    }
}

/// Which of the vertices are corners.
fn used_by(triangles: &[[u32; 3]], vertices: usize) -> Vec<bool> {
    let mut used = vec![false; vertices];
    for &corner in triangles.iter().flatten() {
        used[corner as usize] = true;
    }
    used
}

/// Whether a triangle is no higher than the tolerance above its longest side.
fn is_line([a, b, c]: [Vec3; 3], tolerance: f32) -> bool {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    (b - a).cross(c - a).length() <= tolerance * longest
}

/// Where the vertices that no triangle of the cloth uses are drawn: with the nearest corner of a
/// triangle that was skipped, which then stays without area, else with the first particle.
///
/// Fills the gaps of `particle_of_vertex`, and returns the vertices that were gaps.
pub(crate) fn follow(
    particle_of_vertex: &mut [u32],
    positions: &[Vec3],
    triangles: &[[u32; 3]],
) -> Box<[u32]> {
    let is_gap = |vertex: &usize| particle_of_vertex[*vertex] == NONE;
    let gaps: Vec<_> = (0..particle_of_vertex.len()).filter(is_gap).map(|v| v as u32).collect();
    if gaps.is_empty() {
        return Box::default();
    }
    let mut nearest = vec![(f32::INFINITY, 0); particle_of_vertex.len()];
    for triangle in triangles {
        for &vertex in triangle {
            for &other in triangle {
                let particle = particle_of_vertex[other as usize];
                let distance = positions[vertex as usize].distance(positions[other as usize]);
                if particle != NONE && distance < nearest[vertex as usize].0 {
                    nearest[vertex as usize] = (distance, particle);
                }
            }
        }
    }
    for &gap in &gaps {
        particle_of_vertex[gap as usize] = nearest[gap as usize].1;
    }
    gaps.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit square in the plane, then whatever else.
    fn square(more: &[[f32; 3]]) -> Vec<Vec3> {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        corners.iter().chain(more).map(|p| Vec3::from_array(*p)).collect()
    }

    #[test]
    fn what_is_no_triangle_is_counted_and_left_out() {
        let positions = square(&[[0.5, 0.0, 0.0], [1.0, 0.0, 1e-7], [7.0, 7.0, 7.0]]);
        let triangles = [
            [0, 1, 2],
            [2, 1, 3],
            [0, 0, 1],
            [1, 5, 2], // 5 is where 1 is
            [0, 4, 1], // on a line
            [2, 5, 0], // the first one again, from behind
            [1, 2, 0],
        ];
        let surface = Surface::new(&positions, &triangles).unwrap();
        let skipped = SkippedTriangles { collapsed: 2, zero_area: 1, duplicate: 2 };
        assert_eq!((surface.skipped, surface.skipped.total()), (skipped, 5));
        assert_eq!(surface.triangles, [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(surface.vertex_of_particle, [0, 1, 2, 3]);
        assert_eq!(surface.particle_of_vertex, [0, 1, 2, 3, NONE, 1, NONE]);
        let mut drawn = surface.particle_of_vertex;
        assert_eq!(*follow(&mut drawn, &positions, &triangles), [4, 6]);
        assert_eq!(drawn, [0, 1, 2, 3, 0, 1, 0]);
    }

    #[test]
    fn too_little_is_refused() {
        let positions = square(&[]);
        let problem = |triangles: &[[u32; 3]]| Surface::new(&positions, triangles).unwrap_err();
        assert_eq!(problem(&[]), MeshProblem::Empty);
        assert_eq!(problem(&[[0, 1, 2]]), MeshProblem::OneTriangle { skipped: 0 });
        assert_eq!(problem(&[[0, 1, 2], [1, 2, 0]]), MeshProblem::OneTriangle { skipped: 1 });
        assert_eq!(problem(&[[0, 0, 2]; 3]), MeshProblem::AllDegenerate { triangles: 3 });
        assert_eq!(problem(&[[0, 1, 4]]), MeshProblem::BadIndex { index: 4, vertices: 4 });
    }

    #[test]
    fn pieces_and_crowded_edges_are_counted() {
        let positions =
            square(&[[0.5, 0.5, 1.0], [5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 1.0, 0.0]]);
        let book = [[0, 1, 2], [2, 1, 3], [1, 2, 4], [5, 6, 7]];
        let surface = Surface::new(&positions, &book).unwrap();
        assert_eq!((surface.crowded_edge_count(), surface.piece_count()), (1, 2));
        let surface = Surface::new(&positions, &book[..2]).unwrap();
        assert_eq!((surface.crowded_edge_count(), surface.piece_count()), (0, 1));
    }
}
