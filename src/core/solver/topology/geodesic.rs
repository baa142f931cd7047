//! Ways along a cloth at rest, from particle to particle.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::solver::simd::layout::Layout;
use crate::solver::topology::Topology;
use crate::solver::topology::buckets::Buckets;
use crate::solver::topology::lattice::Lattice;

/// The springs that lead from each particle.
pub(crate) struct Ways<'a> {
    layout: Layout,
    springs: Springs<'a>,
}

enum Springs<'a> {
    /// Told by the index.
    Lattice(&'a Lattice),
    /// By slot: the other end, the rest length \[m\], and whether it is a shear spring.
    Graph(Buckets<(u32, f32, bool)>),
}

impl<'a> Ways<'a> {
    pub fn new(topology: &'a Topology) -> Self {
        let springs = match topology {
            Topology::Lattice(lattice) => Springs::Lattice(lattice),
            Topology::Graph(graph) => {
                let structural = graph.structural.iter().map(|link| (link, false));
                let shear = graph.shear.iter().map(|link| (link, true));
                let ways: Vec<(u32, (u32, f32, bool))> = structural
                    .chain(shear)
                    .flat_map(|(link, shear)| {
                        let [a, b] = link.ends;
                        [(a, (b, link.rest, shear)), (b, (a, link.rest, shear))]
                    })
                    .collect();
                let ways = Buckets::new(graph.particle_count(), &ways);
                Springs::Graph(ways.sorted_by_key(|&(to, ..)| to))
            }
        };
        Self { layout: topology.layout(), springs }
    }

    /// Calls `visit` with the slot and the rest length of each neighbour; those over shear springs
    /// where asked.
    pub fn visit(&self, slot: usize, shear: bool, mut visit: impl FnMut(usize, f32)) {
        match &self.springs {
            Springs::Lattice(lattice) => visit_lattice(lattice, slot, shear, visit),
            Springs::Graph(ways) => {
                for &(to, rest, over_shear) in ways.of(slot as u32) {
                    if shear || !over_shear {
                        visit(to as usize, rest);
                    }
                }
            }
        }
    }

    /// Dijkstra's algorithm: by slot, the length of the shortest way from a group of slots \[m\],
    /// infinite where none leads, and which of the group it comes from.
    pub fn shortest(&self, group: &[usize], shear: bool) -> (Vec<f32>, Vec<u32>) {
        let mut way = vec![f32::INFINITY; self.layout.len()];
        let mut nearest = vec![0_u32; self.layout.len()];
        // Lengths are positive, so that their bits are ordered as they are.
        let mut queue = BinaryHeap::new();
        for &pin in group {
            way[pin] = 0.0;
            nearest[pin] = pin as u32;
            queue.push(Reverse((0_u32, pin)));
        }
        while let Some(Reverse((bits, slot))) = queue.pop() {
            let so_far = f32::from_bits(bits);
            if so_far > way[slot] {
                continue;
            }
            self.visit(slot, shear, |to, length| {
                if so_far + length < way[to] {
                    way[to] = so_far + length;
                    nearest[to] = nearest[slot];
                    queue.push(Reverse((way[to].to_bits(), to)));
                }
            });
        }
        (way, nearest)
    }
}

impl Topology {
    /// Lengths of the shortest ways along the cloth at rest from a particle to all, over threads and
    /// diagonals \[m\]; infinite where none leads.
    pub(crate) fn ways_from(&self, particle: usize) -> Vec<f32> {
        let (way, _) = Ways::new(self).shortest(&[self.slot(particle)], true);
        (0..self.particle_count()).map(|to| way[self.slot(to)]).collect()
    }
}

fn visit_lattice(lattice: &Lattice, slot: usize, shear: bool, mut visit: impl FnMut(usize, f32)) {
    let mut visit = |to: usize, length: f32| {
        if length > 0.0 {
            visit(to, length);
        }
    };
    let s = lattice.layout.stride;
    visit(slot + 1, lattice.weft.rest[slot]);
    visit(slot - 1, lattice.weft.rest[slot - 1]);
    visit(slot + s, lattice.warp.rest[slot]);
    visit(slot - s, lattice.warp.rest[slot - s]);
    if shear {
        visit(slot + s + 1, lattice.diagonal.rest[slot]);
        visit(slot - s - 1, lattice.diagonal.rest[slot - s - 1]);
        visit(slot + s - 1, lattice.antidiagonal_rest[slot - 1]);
        visit(slot - s + 1, lattice.antidiagonal_rest[slot - s]);
    }
}
