//! Wide hinges of a mesh: a particle, and three others around it that are some edges away. Friction inside the fabric
//! acts on them (`forces::graph_bending_friction`).

use std::sync::OnceLock;

use bevy_math::Vec3;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use crate::solver::topology::buckets::Buckets;
use crate::solver::topology::graph::Graph;
use crate::solver::topology::wide_hinges::widths;

/// Wide hinges, in the order in which they are braked: the widest last.
#[derive(Clone, Debug, Default)]
pub(crate) struct WideHinges(pub Vec<WideHinge>);

/// The wide hinges of a mesh, made when they are asked for: a cloth without friction has none.
#[derive(Clone, Debug, Default)]
pub(crate) struct LazyWideHinges(OnceLock<WideHinges>);

/// Wide hinges follow from the rest of the mesh.
impl PartialEq for LazyWideHinges {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Graph {
    /// Makes what a cloth with friction of bending asks of its rest shape, once for all of them. Else the first such cloth
    /// does when it is made; of 100,000 particles that takes longer than all else.
    pub fn prepare_bending_friction(&self) {
        self.wide_hinges();
    }

    /// The wide hinges of the mesh.
    pub(crate) fn wide_hinges(&self) -> &WideHinges {
        self.wide_hinges.0.get_or_init(|| WideHinges::new(self))
    }
}

/// A wide hinge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WideHinge {
    /// Slots of the particle in the middle and of those around it.
    pub slots: [u32; 4],
    /// The largest force for a bending friction of one.
    pub most: f32,
}

/// Cosine between the way to go and an edge from which on that leads there.
const AHEAD: f32 = 0.5;
/// Least weight of a particle around another: with less, that is not in their midst.
const LEAST_WEIGHT: f32 = 0.1;

impl WideHinges {
    /// Finds those of a mesh.
    fn new(graph: &Graph) -> Self {
        let neighbours = Neighbours::new(graph);
        let count = graph.particle_count();
        let widths: Vec<_> = widths(count.isqrt()).collect();
        let mut all: Vec<_> = (0..count as u32)
            .into_par_iter()
            .flat_map_iter(|slot| neighbours.spans(slot, &widths))
            .collect();
        // Stable: those of a width in the order of their slots.
        all.sort_by_key(|&(width, _)| width);
        Self(all.into_iter().map(|(_, hinge)| hinge).collect())
    }
}

/// The particles that each shares a spring with, and where they are at rest.
struct Neighbours {
    positions: Vec<Vec3>,
    near: Buckets<u32>,
}

impl Neighbours {
    fn new(graph: &Graph) -> Self {
        let count = graph.particle_count();
        let links = graph.structural.iter().chain(&graph.shear).map(|link| link.ends);
        let both: Vec<_> = links.flat_map(|[a, b]| [(a, b), (b, a)]).collect();
        Self {
            positions: (0..count).map(|slot| graph.rest(slot)).collect(),
            near: Buckets::neighbours(count, &both),
        }
    }

    fn of(&self, slot: u32) -> &[u32] {
        self.near.of(slot)
    }

    fn at(&self, slot: u32) -> Vec3 {
        self.positions[slot as usize]
    }

    /// The hinges around a particle whose others are so many edges away, and how many; none where the mesh does not go
    /// as far in three directions. The widths ascend.
    fn spans<'a>(
        &'a self,
        slot: u32,
        widths: &'a [usize],
    ) -> impl Iterator<Item = (usize, WideHinge)> + use<'a> {
        let middle = self.at(slot);
        let mut walkers = self.directions(slot).map(|ways| ways.map(|way| self.walker(slot, way)));
        let ends = widths.iter().copied().map_while(move |width| {
            let [a, b, c] = walkers.as_mut()?;
            // Where one of them is at an end, the others need not go on.
            let ends = [a.go_to(width)?, b.go_to(width)?, c.go_to(width)?];
            Some((width, ends))
        });
        ends.filter_map(move |(width, ends)| {
            weights(ends.map(|slot| self.at(slot) - middle))?;
            let [end_a, end_b, end_c] = ends;
            // In a cloth that bends about one axis, what the friction of its hinges does in all.
            let most = 4.0 / (width * width) as f32;
            Some((width, WideHinge { slots: [slot, end_a, end_b, end_c], most }))
        })
    }

    /// Three directions along the mesh, a third of a turn apart; `None` for a particle without neighbours.
    fn directions(&self, slot: u32) -> Option<[Vec3; 3]> {
        let middle = self.at(slot);
        let ahead = self.of(slot).iter().map(|&to| self.at(to) - middle);
        let along = ahead.clone().next()?.normalize_or_zero();
        let beside = ahead.map(|way| way - along * along.dot(way));
        let beside = beside.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
        let beside = beside.normalize_or_zero();
        let third = |side: f32| along * -0.5 + beside * (side * 0.75_f32.sqrt());
        Some([along, third(1.0), third(-1.0)])
    }

    /// Goes from a particle in a direction.
    fn walker(&self, from: u32, way: Vec3) -> Walker<'_> {
        let start = self.at(from);
        Walker { neighbours: self, way, start, here: from, at: start, gone: 0 }
    }
}

/// Goes along edges, as straight as there are any.
struct Walker<'a> {
    neighbours: &'a Neighbours,
    way: Vec3,
    start: Vec3,
    here: u32,
    at: Vec3,
    /// Edges up to here.
    gone: usize,
}

impl Walker<'_> {
    /// The particle that is so many edges from the start; `None` where the mesh does not go as far.
    fn go_to(&mut self, edges: usize) -> Option<u32> {
        while self.gone < edges {
            self.step()?;
        }
        Some(self.here)
    }

    fn step(&mut self) -> Option<()> {
        let gone = self.at - self.start;
        // Back to the straight line.
        let back = (gone - self.way * self.way.dot(gone)) * 0.5;
        let (mut best, mut most) = (None, f32::NEG_INFINITY);
        for &to in self.neighbours.of(self.here) {
            let toward = self.neighbours.at(to) - self.at + back;
            let along = toward.dot(self.way);
            // The square of the cosine, with its sign.
            let straight = along * along.abs() / toward.length_squared().max(f32::MIN_POSITIVE);
            if straight > most {
                (best, most) = (Some(to), straight);
            }
        }
        let next = best?;
        let edge = self.neighbours.at(next) - self.at;
        if edge.normalize_or_zero().dot(self.way) < AHEAD {
            return None;
        }
        (self.here, self.at, self.gone) = (next, self.neighbours.at(next), self.gone + 1);
        Some(())
    }
}

/// Weights of three points whose mean is as near to the origin as it can be; `None` where that is not in their midst.
pub(crate) fn weights([a, b, c]: [Vec3; 3]) -> Option<[f32; 3]> {
    let (to_a, to_b) = (a - c, b - c);
    let (aa, ab, bb) = (to_a.dot(to_a), to_a.dot(to_b), to_b.dot(to_b));
    let (ca, cb) = (-c.dot(to_a), -c.dot(to_b));
    let area = aa * bb - ab * ab;
    let (of_a, of_b) = ((ca * bb - cb * ab) / area, (cb * aa - ca * ab) / area);
    let weights = [of_a, of_b, 1.0 - of_a - of_b];
    weights.iter().all(|&weight| weight >= LEAST_WEIGHT).then_some(weights)
}
