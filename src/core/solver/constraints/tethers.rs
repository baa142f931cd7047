//! Tethers: no particle is further from a pin than the cloth between them reaches.
//!
//! Long-range attachments (Kim, Chentanez and Mueller 2012): what a chain of corrections takes many
//! passes to carry from a pin to the hem is carried at once. The bound is a consequence of the
//! cloth's own constraints, so that a cloth which obeys those is not touched.
//!
//! Pins that are further apart than the cloth between them reaches contradict each other: no place is
//! near enough to both, and a particle tied to both would be thrown from one to the other. All bounds are
//! then eased by one factor, `1 + 1.25 e`, where `e` is the largest relative excess of a distance of pins over its bound. A flat sheet whose pins are at
//! most so many times further apart than at rest can be where all its particles are at most so many times
//! further apart (Kirszbraun 1934), so that eased bounds contradict each other nowhere.

use bevy_math::{Vec3, ops};

use crate::solver::constraints::pin_motion::PinMotion;
use crate::solver::settings::Material;
use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, Blocks3Mut, larger};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::parallel::{Band, cut_between_rows};
use crate::solver::simd::soa::{Array, PartMut, Soa};
use crate::solver::topology::Topology;
use crate::solver::topology::geodesic::Ways;
use crate::solver::topology::graph::Graph;
use crate::solver::topology::lattice::Lattice;

/// Tethers of a particle at most.
const MOST: usize = 4;
/// Load on the cloth above its own weight that the bound leaves room for.
const LOAD_FACTOR: f32 = 4.0;
/// Least distance from a pin that has a direction \[m\].
const LEAST_DISTANCE: f32 = 1e-12;
/// Pins of other groups that a pin is measured against at most, the nearest along the cloth.
const MOST_OTHERS: usize = 8;
/// Bounds are eased by so much more than pins are too far apart: just enough would leave one place alone to each
/// particle, where gravity may not want it.
const SLACK: f32 = 1.25;
/// Bounds are eased by this factor at most: then there are none.
const MOST_EASE: f32 = 1e6;

/// The tethers of one group of neighbouring pins, or to the n-th nearest group where there are many.
#[derive(Clone, Debug)]
pub(crate) struct TetherSet {
    /// Which of the cloth's pins each particle is tied to; one entry where all share a pin.
    pins: Vec<u32>,
    /// Distance to the pin along the cloth, however it shears less \[m\]; 0 for held particles.
    straight: Vec<f32>,
    /// Distance to the pin along the threads alone \[m\].
    along_threads: Vec<f32>,
    /// The bound in force \[m\].
    limit: Array,
    /// Pins of other groups, and what ties them to this one's.
    between: Vec<Between>,
}

/// Two pins of different groups, and how far apart the cloth lets them be.
#[derive(Clone, Copy, Debug)]
struct Between {
    /// The tethers' places among the pins.
    pins: [usize; 2],
    straight: f32,
    along_threads: f32,
    limit: f32,
}

impl TetherSet {
    /// The tethers that a cloth needs for its pins (slots).
    pub fn build(topology: &Topology, pins: &[usize]) -> Vec<Self> {
        if pins.is_empty() {
            return Vec::new();
        }
        let ways = Ways::new(topology);
        let groups = neighbour_groups(&ways, pins);
        if groups.len() == topology.particle_count() {
            return Vec::new();
        }
        let mut place_of = vec![0; topology.layout().len()];
        for (place, &pin) in pins.iter().enumerate() {
            place_of[pin] = place;
        }
        let mut sets: Vec<Self> = Vec::new();
        for group in &groups {
            let reach = Reach::from_pins(topology, &ways, group);
            sets.push(reach.into_set(topology.layout(), group, pins, &place_of));
        }
        keep_nearest(topology.layout(), sets)
    }

    /// Sets the bounds for a material under gravity \[m/s2\].
    ///
    /// The cloth may stretch by what its threads give under [`LOAD_FACTOR`] times its weight, spread
    /// over a width that grows with the distance from the pin (a logarithm), and it may be longer by
    /// what it shears, up to the way along the threads.
    pub fn set_limits(&mut self, topology: &Topology, material: &Material, gravity: Vec3) {
        let weight = topology.total_area() * material.area_density * gravity.length();
        let load = LOAD_FACTOR * weight;
        let cell = (topology.total_area() / topology.particle_count() as f32).sqrt();
        let shear_stiffness = topology.shear_stiffness(material);
        let limit = |straight: f32, threads: f32| {
            if straight == f32::INFINITY {
                // A part of the cloth that no way leads to.
                return f32::INFINITY;
            }
            let spread = 1.0 + ops::ln((straight / cell).max(1.0));
            // Without gravity nothing tells the load: the limit and the threads alone bound it.
            let give = |stiffness: f32| {
                if load == 0.0 { f32::INFINITY } else { (load / stiffness) * spread }
            };
            let stretch = give(material.thread_stiffness).min(material.max_strain * straight);
            let shear = give(shear_stiffness).min(threads - straight);
            straight + stretch + shear
        };
        for slot in topology.layout().slots() {
            self.limit[slot] = limit(self.straight[slot], self.along_threads[slot]);
        }
        for between in &mut self.between {
            between.limit = limit(between.straight, between.along_threads);
        }
    }

    /// Factor for the bounds, at least 1, where the pins are too far apart for them on their way through a
    /// tick.
    ///
    /// Between the ends of straight ways nothing is further apart than at one of the ends.
    pub fn ease(&self, pins: &[PinMotion]) -> f32 {
        self.between.iter().fold(1.0, |ease, Between { pins: [a, b], limit, .. }| {
            let (a, b) = (&pins[*a], &pins[*b]);
            let apart = a.start.distance(b.start).max(a.end.distance(b.end));
            let too_far = apart / larger(*limit, LEAST_DISTANCE) - 1.0;
            larger(1.0 + SLACK * too_far, ease).min(MOST_EASE)
        })
    }
}

/// Distances along the cloth from a group of pins.
struct Reach {
    nearest: Vec<u32>,
    straight: Vec<f32>,
    along_threads: Vec<f32>,
}

impl Reach {
    fn from_pins(topology: &Topology, ways: &Ways<'_>, group: &[usize]) -> Self {
        match topology {
            Topology::Lattice(lattice) if lattice.flat => Self::through_space(lattice, group),
            Topology::Graph(graph) if graph.flat => Self::across_a_plane(graph, ways, group),
            _ => Self::along_edges(ways, group),
        }
    }

    /// In a flat, convex sheet the way along the cloth is the straight one.
    fn through_space(lattice: &Lattice, group: &[usize]) -> Self {
        let layout = lattice.layout;
        let rest = |slot: usize| rest_position(lattice, slot);
        let (across, along) = (
            (rest(layout.slot(0, 1)) - rest(layout.slot(0, 0))).normalize_or_zero(),
            (rest(layout.slot(1, 0)) - rest(layout.slot(0, 0))).normalize_or_zero(),
        );
        let mut reach = Self::unreached(layout.len());
        for slot in layout.slots() {
            let mut best = f32::INFINITY;
            for &pin in group {
                let d = rest(slot) - rest(pin);
                if d.length() < best {
                    best = d.length();
                    reach.nearest[slot] = pin as u32;
                    reach.straight[slot] = best;
                    reach.along_threads[slot] = d.dot(across).abs() + d.dot(along).abs();
                }
            }
        }
        reach
    }

    /// Elsewhere it is the shortest way over threads and diagonals, which is never too short.
    fn along_edges(ways: &Ways<'_>, group: &[usize]) -> Self {
        let (straight, nearest) = ways.shortest(group, true);
        let (along_threads, _) = ways.shortest(group, false);
        Self { nearest, straight, along_threads }
    }

    /// So it is in any flat, convex mesh; the way along its edges is longer by what it may shear.
    fn across_a_plane(graph: &Graph, ways: &Ways<'_>, group: &[usize]) -> Self {
        let mut reach = Self::unreached(graph.layout.len());
        let (along_threads, _) = ways.shortest(group, false);
        for slot in graph.layout.slots() {
            let mut best = f32::INFINITY;
            for &pin in group {
                let distance = graph.rest(slot).distance(graph.rest(pin));
                if distance < best {
                    best = distance;
                    reach.nearest[slot] = pin as u32;
                    reach.straight[slot] = distance;
                }
            }
        }
        reach.along_threads = along_threads;
        reach
    }

    fn unreached(len: usize) -> Self {
        Self { nearest: vec![0; len], straight: vec![0.0; len], along_threads: vec![0.0; len] }
    }

    /// The ways to the pins of other groups, where there are any.
    fn to_others(&self, group: &[usize], pins: &[usize], place_of: &[usize]) -> Vec<Between> {
        let others = pins.iter().enumerate().filter(|(_, pin)| group.binary_search(pin).is_err());
        let between = others.map(|(place, &pin)| Between {
            pins: [place_of[self.nearest[pin] as usize], place],
            straight: self.straight[pin],
            along_threads: self.along_threads[pin],
            limit: f32::INFINITY,
        });
        between.filter(|between| between.straight < f32::INFINITY).collect()
    }

    /// `place_of` gives each slot of a pin its place among the pins.
    fn into_set(
        mut self,
        layout: Layout,
        group: &[usize],
        pins: &[usize],
        place_of: &[usize],
    ) -> TetherSet {
        let between = self.to_others(group, pins, place_of);
        for &pin in pins {
            self.straight[pin] = 0.0;
            self.along_threads[pin] = 0.0;
        }
        let mut nearest = if let [only] = group { vec![*only as u32] } else { self.nearest };
        for pin in &mut nearest {
            *pin = place_of[*pin as usize] as u32;
        }
        TetherSet {
            pins: nearest,
            straight: self.straight,
            along_threads: self.along_threads,
            limit: Array::zeros(layout.len()),
            between,
        }
    }
}

fn rest_position(lattice: &Lattice, slot: usize) -> Vec3 {
    let (row, column) = row_and_column(lattice.layout, slot);
    lattice.rest_positions[row * lattice.layout.columns + column]
}

fn row_and_column(layout: Layout, slot: usize) -> (usize, usize) {
    let from_first = slot - layout.slot(0, 0);
    (from_first / layout.stride, from_first % layout.stride)
}

/// Pins that are neighbours, diagonals included, make one group; groups in the order of their first.
fn neighbour_groups(ways: &Ways<'_>, pins: &[usize]) -> Vec<Vec<usize>> {
    let mut waiting: std::collections::BTreeSet<usize> = pins.iter().copied().collect();
    let mut groups = Vec::new();
    while let Some(seed) = waiting.pop_first() {
        let mut group = vec![seed];
        let mut at = 0;
        while at < group.len() {
            ways.visit(group[at], true, |slot, _| {
                if waiting.remove(&slot) {
                    group.push(slot);
                }
            });
            at += 1;
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

/// Where there are more groups than tethers, each particle keeps its nearest.
fn keep_nearest(layout: Layout, sets: Vec<TetherSet>) -> Vec<TetherSet> {
    if sets.len() <= MOST {
        return sets;
    }
    let empty = || TetherSet {
        pins: vec![0; layout.len()],
        straight: vec![0.0; layout.len()],
        along_threads: vec![0.0; layout.len()],
        limit: Array::zeros(layout.len()),
        between: Vec::new(),
    };
    let mut kept: Vec<TetherSet> = (0..MOST).map(|_| empty()).collect();
    for slot in layout.slots() {
        let mut order: Vec<usize> = (0..sets.len()).collect();
        order.sort_by(|&a, &b| sets[a].straight[slot].total_cmp(&sets[b].straight[slot]));
        for (to, &from) in kept.iter_mut().zip(&order) {
            to.pins[slot] =
                if let [only] = sets[from].pins[..] { only } else { sets[from].pins[slot] };
            to.straight[slot] = sets[from].straight[slot];
            to.along_threads[slot] = sets[from].along_threads[slot];
        }
    }
    kept[0].between = nearest_others(sets);
    kept
}

/// For each pin its nearest pins of other groups.
fn nearest_others(sets: Vec<TetherSet>) -> Vec<Between> {
    let mut all: Vec<_> = sets.into_iter().flat_map(|set| set.between).collect();
    all.sort_by(|a, b| a.pins[1].cmp(&b.pins[1]).then(a.straight.total_cmp(&b.straight)));
    let of_a_pin = all.chunk_by(|a, b| a.pins[1] == b.pins[1]);
    of_a_pin.flat_map(|others| others.iter().take(MOST_OTHERS).copied()).collect()
}

/// Brings back what is further from its pins than its tethers allow, one after the other.
pub(crate) struct PullTethers<'a> {
    pub band: Band,
    pub sets: &'a [TetherSet],
    /// Where the cloth's pins are at the substep's end, relative to the origin \[m\].
    pub pins: &'a [Vec3],
    /// Factor of the bounds, at least 1.
    pub ease: f32,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub d: PartMut<'a>,
}

impl Kernel for PullTethers<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { band: Band { layout, rows, .. }, sets, pins, ease, inverse_mass, x, mut d } =
            self;
        let blocks = layout.blocks_across();
        for row in rows {
            let first = layout.slot(row, 0);
            let w = Blocks::new(inverse_mass, first, blocks);
            let x = Blocks3::new(x, first, blocks);
            let mut d = Blocks3Mut::new(&mut d, first, blocks);
            for block in 0..blocks {
                let slot = first + block * LANES;
                let (w, x, mut moved) = (w.at(block), x.at(block), d.at(block));
                let mut is_pulled = false;
                for set in sets {
                    let mut limit = Block::load(&set.limit, slot);
                    for lane in &mut limit.0 {
                        *lane *= ease;
                    }
                    is_pulled |= match set.pins[..] {
                        [only] => {
                            let pin = pins[only as usize];
                            pull(&mut moved, &x, &w, &limit, |_| pin)
                        }
                        _ => {
                            let pins = gather(pins, &set.pins[slot..slot + LANES]);
                            pull(&mut moved, &x, &w, &limit, |i| pins.at(i))
                        }
                    };
                }
                if is_pulled {
                    d.set(block, moved);
                }
            }
        }
    }
}

cut_between_rows!(PullTethers, d);

/// Pulls a block to its pins where it is further away than its limits, and tells whether it was.
#[inline(always)]
fn pull(d: &mut Block3, x: &Block3, w: &Block, limit: &Block, pin: impl Fn(usize) -> Vec3) -> bool {
    let mut ways = Block3::ZERO;
    let mut beyond = Block::ZERO;
    for i in 0..LANES {
        let way = (x.at(i) + d.at(i)) - pin(i);
        let by = way.dot(way) - limit.0[i] * limit.0[i];
        ways.set(i, way);
        beyond.0[i] = if w.0[i] > 0.0 { by } else { 0.0 };
    }
    // Few are.
    if !beyond.is_any_above(0.0) {
        return false;
    }
    for i in 0..LANES {
        let way = ways.at(i);
        let distance = way.dot(way).sqrt();
        let excess = if w.0[i] > 0.0 { larger(distance - limit.0[i], 0.0) } else { 0.0 };
        d.set(i, d.at(i) - way * (excess / larger(distance, LEAST_DISTANCE)));
    }
    true
}

#[inline(always)]
fn gather(from: &[Vec3], pins: &[u32]) -> Block3 {
    let mut out = Block3::ZERO;
    for (lane, &pin) in pins.iter().enumerate() {
        out.set(lane, from[pin as usize]);
    }
    out
}
