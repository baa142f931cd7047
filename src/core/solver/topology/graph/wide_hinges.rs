//! Wide hinges of a mesh: a particle, and three others around it that are some edges away. Friction inside the fabric
//! acts on them (`forces::graph_bending_friction`).

use std::sync::OnceLock;

use bevy_math::Vec3;

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
        let mut wide_hinges = Vec::new();
        for width in widths(count.isqrt()) {
            wide_hinges.extend((0..count as u32).filter_map(|slot| neighbours.span(slot, width)));
        }
        Self(wide_hinges)
    }
}

/// The particles that each shares a spring with, and where they are at rest.
struct Neighbours {
    positions: Vec<Vec3>,
    /// Neighbours of slot i: from `first[i]` to `first[i + 1]`.
    first: Vec<usize>,
    slots: Vec<u32>,
}

impl Neighbours {
    fn new(graph: &Graph) -> Self {
        let count = graph.particle_count();
        let links = || graph.structural.iter().chain(&graph.shear).map(|link| link.ends);
        let mut both: Vec<[u32; 2]> = links().chain(links().map(|[a, b]| [b, a])).collect();
        both.sort_unstable();
        both.dedup();
        let first = |slot| both.partition_point(|&[from, _]| (from as usize) < slot);
        Self {
            positions: (0..count).map(|slot| graph.rest(slot)).collect(),
            first: (0..=count).map(first).collect(),
            slots: both.iter().map(|&[_, to]| to).collect(),
        }
    }

    fn of(&self, slot: u32) -> &[u32] {
        &self.slots[self.first[slot as usize]..self.first[slot as usize + 1]]
    }

    fn at(&self, slot: u32) -> Vec3 {
        self.positions[slot as usize]
    }

    /// The hinge around a particle whose others are so many edges away; `None` where the mesh does not go as far in
    /// three directions.
    fn span(&self, slot: u32, width: usize) -> Option<WideHinge> {
        let middle = self.at(slot);
        let ahead = self.of(slot).iter().map(|&to| self.at(to) - middle);
        let along = ahead.clone().next()?.normalize_or_zero();
        let beside = ahead.map(|way| way - along * along.dot(way));
        let beside = beside.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
        let beside = beside.normalize_or_zero();
        let third = |side: f32| along * -0.5 + beside * (side * 0.75_f32.sqrt());
        let mut around = [slot; 3];
        for (end, way) in around.iter_mut().zip([along, third(1.0), third(-1.0)]) {
            *end = self.walk(slot, way, width)?;
        }
        weights(around.map(|slot| self.at(slot) - middle))?;
        let [end_a, end_b, end_c] = around;
        Some(WideHinge {
            slots: [slot, end_a, end_b, end_c],
            // In a cloth that bends about one axis, what the friction of its hinges does in all.
            most: 4.0 / (width * width) as f32,
        })
    }

    /// Where a way leads that begins at a particle and goes along so many edges, as straight as there are any.
    fn walk(&self, from: u32, way: Vec3, edges: usize) -> Option<u32> {
        let start = self.at(from);
        let mut here = from;
        for _ in 0..edges {
            let gone = self.at(here) - start;
            // Back to the straight line.
            let beside = gone - way * way.dot(gone);
            let toward = |to: u32| {
                let edge = self.at(to) - self.at(here);
                (edge + beside * 0.5).normalize_or_zero().dot(way)
            };
            let next = self.of(here).iter().copied();
            here = next.max_by(|&a, &b| toward(a).total_cmp(&toward(b)))?;
            let edge = self.at(here) - start - gone;
            if edge.normalize_or_zero().dot(way) < AHEAD {
                return None;
            }
        }
        Some(here)
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
