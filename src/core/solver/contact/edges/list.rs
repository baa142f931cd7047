//! The edges and faces of a cloth: what they join, how long edges are at rest, and which meet at a particle.

use std::sync::Arc;

use crate::solver::simd::lanes::LANES;
use crate::solver::topology::Topology;
use crate::solver::topology::buckets::Buckets;
use crate::solver::topology::lattice::Lattice;

/// Edges that go from each particle of a lattice: to the next column, and to three of the next row.
pub(super) const FAN: usize = 4;
/// The faces of a lattice whose first corner is a particle, by the edges of its fan that lead to the others: with both
/// diagonals of each cell.
pub(super) const FAN_FACES: [[usize; 2]; 4] = [[0, 2], [0, 3], [2, 3], [1, 2]];

/// The faces of a fan both of whose edges are among some, a bit each, by the bits of these.
pub(super) const FACES_BETWEEN: [u32; 1 << FAN] = {
    let mut faces = [0; 1 << FAN];
    let mut fan = 0;
    while fan < faces.len() {
        let mut face = 0;
        while face < FAN_FACES.len() {
            let [i, j] = FAN_FACES[face];
            if fan >> i & fan >> j & 1 == 1 {
                faces[fan] |= 1 << face;
            }
            face += 1;
        }
        fan += 1;
    }
    faces
};

/// The edges of a cloth: all springs between neighbours of a lattice, both diagonals too, and the edges of a mesh.
#[derive(Clone, Debug)]
pub(crate) struct Edges {
    /// Length of the longest at rest \[m\].
    pub longest: f32,
    pub(super) joined: Joined,
}

/// The particles that edges join.
#[derive(Clone, Debug)]
pub(super) enum Joined {
    /// Neighbours of a lattice. Edge `FAN s + i` goes from slot s on by the i-th of `hops`. Which of a
    /// slot's lead to a neighbour, and not beside the sheet, is in `within`, a bit each.
    Neighbours { lattice: Arc<Lattice>, hops: [usize; FAN], within: Vec<[u32; LANES]> },
    /// Any particles.
    Pairs(Pairs),
}

/// Edges of a mesh.
#[derive(Clone, Debug)]
pub(super) struct Pairs {
    /// Slots of the ends, ascending; behind the last, [`LANES`] of no edges, so that as many can be read from each one on.
    pub ends: Vec<[u32; 2]>,
    /// Lengths at rest \[m\].
    rest: Vec<f32>,
    /// Edges from block i are from `first[i]` to `first[i + 1]`.
    pub first: Vec<u32>,
    /// Slots of the corners of faces, each ascending, in the order of the first.
    faces: Vec<[u32; 3]>,
    /// Faces whose first two corners are the ends of edge i are from `first_face[i]` to `first_face[i + 1]`.
    first_face: Vec<u32>,
    /// The edges that meet at each slot.
    at: Buckets<u32>,
}

/// Which edges of a fan have a length at rest, a bit each; beside the sheet there are none.
fn within(lattice: &Lattice, slot: usize) -> u32 {
    let Lattice { weft, warp, diagonal, antidiagonal_rest, .. } = lattice;
    // A cell's diagonals stand at its first corner.
    let antidiagonal = slot.checked_sub(1).map_or(0.0, |corner| antidiagonal_rest[corner]);
    let rests = [weft.rest[slot], antidiagonal, warp.rest[slot], diagonal.rest[slot]];
    (0..FAN).map(|i| u32::from(rests[i] > 0.0) << i).sum()
}

impl Joined {
    /// Diameter of the largest circle in a face whose longest side is one: in half a rectangle, at most that of half a square; in any
    /// other triangle, at most that of an equilateral one.
    pub fn widest_inscribed(&self) -> f32 {
        match self {
            Self::Neighbours { lattice, .. } if lattice.flat => 0.4143,
            Self::Neighbours { .. } | Self::Pairs(_) => 0.5774,
        }
    }
}

impl Edges {
    /// Lists the edges of a cloth.
    pub fn new(topology: &Topology) -> Self {
        let longest = topology.structural_springs().map(|(.., rest)| rest).fold(0.0, f32::max);
        let lattice = match topology {
            Topology::Lattice(lattice) => lattice,
            Topology::Graph(graph) => {
                let joined = Joined::Pairs(Pairs::new(topology, graph.triangles()));
                return Self { longest, joined };
            }
        };
        let stride = lattice.layout.stride;
        let across = lattice.diagonal.rest.iter().chain(&*lattice.antidiagonal_rest);
        let longest = across.fold(longest, |longest, &rest| longest.max(rest));
        let hops = [1, stride - 1, stride, stride + 1];
        let within = |block| core::array::from_fn(|lane| within(lattice, block * LANES + lane));
        let within = (0..lattice.layout.len() / LANES).map(within).collect();
        Self { longest, joined: Joined::Neighbours { lattice: lattice.clone(), hops, within } }
    }

    /// How many there are, with those that lead beside the sheet.
    pub fn count(&self) -> usize {
        match &self.joined {
            Joined::Neighbours { lattice, .. } => FAN * lattice.layout.len(),
            Joined::Pairs(pairs) => pairs.rest.len(),
        }
    }

    /// How many faces there are, with those that lead beside the sheet.
    pub fn face_count(&self) -> usize {
        match &self.joined {
            Joined::Neighbours { lattice, .. } => FAN_FACES.len() * lattice.layout.len(),
            Joined::Pairs(pairs) => pairs.faces.len(),
        }
    }

    /// The slots that one joins.
    #[inline(always)]
    pub fn ends(&self, edge: u32) -> [usize; 2] {
        match &self.joined {
            Joined::Neighbours { hops, .. } => {
                let edge = edge as usize;
                [edge / FAN, edge / FAN + hops[edge % FAN]]
            }
            Joined::Pairs(pairs) => pairs.ends[edge as usize].map(|slot| slot as usize),
        }
    }

    /// Length of one at rest \[m\].
    pub fn rest(&self, edge: u32) -> f32 {
        let (edge, slot) = (edge as usize, edge as usize / FAN);
        match &self.joined {
            Joined::Neighbours { lattice, .. } => match edge % FAN {
                0 => lattice.weft.rest[slot],
                1 => lattice.antidiagonal_rest[slot - 1],
                2 => lattice.warp.rest[slot],
                _ => lattice.diagonal.rest[slot],
            },
            Joined::Pairs(pairs) => pairs.rest[edge],
        }
    }

    /// Whether one is a thread, and no diagonal of a lattice: those get long by shear alone.
    pub fn is_thread(&self, edge: u32) -> bool {
        match &self.joined {
            Joined::Neighbours { .. } => (edge as usize % FAN).is_multiple_of(2),
            Joined::Pairs(_) => true,
        }
    }

    /// Visits the threads that meet at a slot: the slots of their other ends, and their lengths at rest \[m\]. Diagonals of a
    /// lattice are none.
    pub fn visit_threads(&self, slot: usize, mut visit: impl FnMut(usize, f32)) {
        match &self.joined {
            Joined::Pairs(pairs) => {
                for &edge in pairs.at.of(slot as u32) {
                    let [a, b] = pairs.ends[edge as usize].map(|slot| slot as usize);
                    visit(if a == slot { b } else { a }, pairs.rest[edge as usize]);
                }
            }
            Joined::Neighbours { lattice, .. } => {
                let Lattice { layout, weft, warp, .. } = &**lattice;
                let threads = [
                    (slot - 1, weft.rest[slot - 1]),
                    (slot + 1, weft.rest[slot]),
                    (slot - layout.stride, warp.rest[slot - layout.stride]),
                    (slot + layout.stride, warp.rest[slot]),
                ];
                for (other, rest) in threads {
                    // Beside the sheet there are none.
                    if rest > 0.0 {
                        visit(other, rest);
                    }
                }
            }
        }
    }
}

impl Pairs {
    /// The faces whose first two corners an edge joins, by their places in the list, with their corners.
    #[inline(always)]
    pub fn faces_of(&self, edge: u32) -> impl Iterator<Item = (u32, [u32; 3])> {
        let [from, to] = [0, 1].map(|next| self.first_face[edge as usize + next]);
        (from..to).map(|face| (face, self.faces[face as usize]))
    }

    fn new(topology: &Topology, triangles: &[[u32; 3]]) -> Self {
        let slots = topology.layout().len();
        let slot = |particle| topology.slot(particle) as u32;
        let ascending = |(a, b, rest)| {
            let [a, b]: [u32; 2] = [slot(a), slot(b)];
            ([a.min(b), a.max(b)], rest)
        };
        let mut springs: Vec<_> = topology.structural_springs().map(ascending).collect();
        springs.sort_unstable_by_key(|&(ends, _)| ends);
        let (mut ends, rest): (Vec<_>, Vec<_>) = springs.into_iter().unzip();
        let before = |block| ends.partition_point(|&[a, _]| (a as usize) < block * LANES) as u32;
        let first = (0..=slots / LANES).map(before).collect();
        let both = |(edge, ends): (u32, &[u32; 2])| ends.map(|slot| (slot, edge));
        let at: Vec<_> = (0..).zip(&ends).flat_map(both).collect();
        let at = Buckets::new(slots, &at);
        let mut faces: Vec<_> =
            triangles.iter().map(|corners| corners.map(|corner| slot(corner as usize))).collect();
        for corners in &mut faces {
            corners.sort_unstable();
        }
        faces.sort_unstable();
        let before = |ends| faces.partition_point(|&[a, b, _]| [a, b] < ends) as u32;
        let first_face = ends.iter().copied().chain([[u32::MAX; 2]]).map(before).collect();
        ends.resize(ends.len() + LANES, [0; 2]);
        Self { ends, rest, first, faces, first_face, at }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::settings::MassLumping;
    use crate::solver::topology::graph::Graph;
    use bevy_math::Vec3;

    /// Triangles around a corner, and one that lies beside them: three of them share an edge, and their corners are in any order.
    const TRIANGLES: [[u32; 3]; 5] = [[0, 1, 2], [2, 3, 0], [2, 0, 4], [4, 3, 0], [7, 5, 6]];

    #[test]
    fn each_face_of_a_mesh_is_of_the_edge_between_its_first_two_corners() {
        let turned =
            |i: usize| Vec3::new(i as f32, (i * i) as f32, (i % 3) as f32 + 0.1 * i as f32);
        let positions: Vec<_> = (0..8).map(turned).collect();
        let graph = Graph::new(&positions, &TRIANGLES, MassLumping::Lumped).unwrap();
        let topology = Topology::from(Arc::new(graph));
        let edges = Edges::new(&topology);
        let Joined::Pairs(pairs) = &edges.joined else { panic!("a mesh's edges are pairs") };
        let mut found = Vec::new();
        for edge in 0..edges.count() as u32 {
            for (_, face) in pairs.faces_of(edge) {
                assert_eq!([face[0], face[1]], pairs.ends[edge as usize]);
                found.push(face);
            }
        }
        assert_eq!(found.len(), TRIANGLES.len());
        assert!(found.is_sorted(), "as edges are: {found:?}");
        assert!(found.iter().all(|face| face.is_sorted()));
        let slots = |corners: [u32; 3]| {
            let mut slots = corners.map(|corner| topology.slot(corner as usize) as u32);
            slots.sort_unstable();
            slots
        };
        for corners in TRIANGLES {
            assert!(found.contains(&slots(corners)), "{corners:?}");
        }
    }
}
