//! The triangles of a cloth, by its particles.

use bevy_math::Vec3;

use crate::solver::simd::block::larger;
use crate::solver::simd::layout::Layout;
use crate::solver::topology::Topology;
use crate::solver::topology::buckets::Buckets;

/// The triangles of a mesh, or two for each cell of a lattice.
pub(super) fn faces(topology: &Topology) -> Vec<[usize; 3]> {
    match topology {
        Topology::Graph(graph) => {
            graph.triangles().iter().map(|corners| corners.map(|corner| corner as usize)).collect()
        }
        Topology::Lattice(lattice) => {
            let (rows, columns) = (lattice.rows(), lattice.columns());
            let cells = (0..rows - 1).flat_map(|r| (0..columns - 1).map(move |c| r * columns + c));
            cells
                .flat_map(|a| {
                    let [b, c, d] = [a + 1, a + columns, a + columns + 1];
                    [[a, c, d], [a, d, b]]
                })
                .collect()
        }
    }
}

/// The faces at each particle, by slots.
#[derive(Clone, Debug)]
pub(in crate::solver) struct FacesAt {
    /// The rows and columns of a lattice.
    grid: Option<Layout>,
    /// Corners of faces.
    faces: Vec<[u32; 3]>,
    /// The faces at each slot.
    at: Buckets<u32>,
}

impl FacesAt {
    pub fn new(topology: &Topology) -> Self {
        let slots = topology.layout().len();
        let faces: Vec<_> = faces(topology)
            .into_iter()
            .map(|corners| corners.map(|corner| topology.slot(corner) as u32))
            .collect();
        let corners = |(face, corners): (u32, &[u32; 3])| corners.map(|corner| (corner, face));
        let at: Vec<_> = (0..).zip(&faces).flat_map(corners).collect();
        let at = Buckets::new(slots, &at);
        let grid = topology.as_lattice().map(|lattice| lattice.layout);
        Self { grid, faces, at }
    }

    /// How many slots there are.
    pub fn slots(&self) -> usize {
        self.at.slots() as usize
    }

    /// The corners of the faces at a slot.
    pub fn of(&self, slot: usize) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.at.of(slot as u32).iter().map(|&face| self.faces[face as usize])
    }

    /// Whether two slots are corners of one face.
    pub fn share_an_edge(&self, [a, b]: [u32; 2]) -> bool {
        self.of(a as usize).flatten().any(|corner| corner == b)
    }

    /// Whether two slots are the corners of two faces that lie across an edge from each other.
    pub fn face_each_other(&self, [a, b]: [u32; 2]) -> bool {
        let edge =
            |corners: [u32; 3], own: u32| corners.map(|it| if it == own { u32::MAX } else { it });
        self.of(a as usize).any(|here| {
            let here = edge(here, a);
            let across =
                |there: [u32; 3]| edge(there, b).iter().filter(|it| here.contains(it)).count();
            self.of(b as usize).any(|there| across(there) == 3)
        })
    }

    /// The normal of the surface at a slot, of length one; either of both. `at` says where particles are.
    pub fn normal(&self, slot: usize, at: impl Fn(u32) -> Vec3) -> Vec3 {
        let sum = match self.grid {
            Some(layout) => {
                let [above, below, before, after] = layout.around(slot).map(|slot| at(slot as u32));
                (below - above).cross(after - before)
            }
            None => self.of(slot).fold(Vec3::ZERO, |sum, corners| {
                let [a, b, c] = corners.map(&at);
                let normal = (b - a).cross(c - a);
                // Which way each goes round does not matter.
                sum + if normal.dot(sum) < 0.0 { -normal } else { normal }
            }),
        };
        sum * (1.0 / larger(sum.dot(sum).sqrt(), f32::MIN_POSITIVE))
    }
}
