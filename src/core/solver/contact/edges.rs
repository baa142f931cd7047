//! Edges of the cloth are held out of colliders that are thin or sharp at the scale of its particles.
//!
//! The distance to a solid changes by at most a metre in a metre. So an edge of length l, whose ends have the gaps g0 and g1
//! to what is held, is held itself as long as g0 + g1 >= l. Of the others, those are left out whose ends see the surface face
//! nearly the same way: a flat or gently curved side. What is left lies around a rim, a tip, a rod. There the place
//! of an edge that is nearest to the solid is found by golden-section search (Kiefer 1953; for contact with distance
//! fields: Macklin et al. 2020, *Local Optimization for Robust Signed Distance Field Collision*), and moved out with both
//! ends, each by its share and its inverse mass. Friction acts there as it does on particles.
//!
//! An edge is held at half the distance of the particles, so that on a smooth solid these touch first, and edges cost nothing.

use bevy_math::Vec3;

use super::super::bands::CutAt;
use super::super::isa::{Isa, Kernel};
use super::super::lanes::{Array, Block, Block3, LANES, PartMut, Soa, ValuesMut, larger};
use super::super::lattice::Layout;
use super::super::topology::Topology;
use super::active_set::ActiveSet;
use super::collider::{Frame, Motion};
use super::impulses::Share;
use super::room::ByBlock;
use super::{LEAST_SLIDING, Skin};
use crate::sdf::PointBlock;

/// Part of the particles' distance at which edges are held.
const HELD: f32 = 0.5;
/// Part of its length by which an edge may sink into a curved side, where that is more.
const SAGITTA: f32 = 1.0 / 64.0;
/// An edge that is so many times as long as at rest, and so many times epsilon inside a collider, is hooked in it.
const HOOKED_STRETCH: f32 = 2.0;
const HOOKED_DEPTH: f32 = 2.0;
/// So long it stays, as long as it is inside at all, until it is free.
const UNHOOKED_STRETCH: f32 = 1.25;
/// Multiple of epsilon by which an end is nearer than that where it is inside, and did not only begin to touch.
const INSIDE: f32 = 2.0;
/// Cosine between the normal of an end and the way in, from which on it lies beyond the solid.
const BEYOND: f32 = 0.25;
/// An end goes at most this many times as far as the place of its edge that is moved.
const MOST_SHARE: f32 = 2.0;
/// Places that are looked at on a way of an end that is pushed by what is fast.
const LOOKS: u32 = 8;
/// Part of an edge by which a collider may go in a substep and count as slow.
const SLOW: f32 = 0.125;
/// Part of an edge from which on a collider passes edges within a substep, and only particles are held.
const FAST: f32 = 0.75;
/// Part of Coulomb's limit up to which an edge is braked that turns about where it is held.
const TURNING: f32 = 0.6;
/// Steps of the search: each leaves 0.618 of the edge. Two ends of a bracket come before them.
const STEPS: usize = 6;
/// Part of an edge by which the place that the search finds may be off.
const UNSURE: f32 = 0.06;
/// The smaller part of a golden section.
const GOLDEN: f32 = 0.381_966_02;

/// Edges that are looked at closely in a substep that there is room for from the start.
const FEW_CLOSE: usize = 4096;
/// Edges that go from each particle of a lattice: to the next column, and to three of the next row.
const FAN: usize = 4;

/// The edges of a cloth.
#[derive(Clone, Debug)]
pub(in crate::solver) struct Edges {
    /// Length of the longest at rest \[m\].
    longest: f32,
    joined: Joined,
}

/// The particles that edges join.
#[derive(Clone, Debug)]
enum Joined {
    /// Neighbours of a lattice: slots from one to the other. Edge `FAN s + i` goes from slot s on by the i-th of them.
    Neighbours { hops: [usize; FAN], slots: usize },
    /// Any particles, in the order of the first; edges from block i are from `first[i]` to `first[i + 1]`.
    Pairs { ends: Vec<[u32; 2]>, first: Vec<u32> },
}

impl Edges {
    /// Lists the edges of a cloth.
    pub fn new(topology: &Topology) -> Self {
        let mut longest = topology.structural_springs().map(|(.., rest)| rest).fold(0.0, f32::max);
        let slots = topology.layout().len();
        if let Some(lattice) = topology.as_lattice() {
            let stride = lattice.layout.stride;
            let across = lattice.diagonal.rest.iter().chain(&*lattice.antidiagonal_rest);
            longest = across.fold(longest, |longest, &rest| longest.max(rest));
            let hops = [1, stride - 1, stride, stride + 1];
            return Self { longest, joined: Joined::Neighbours { hops, slots } };
        }
        let slot = |particle| topology.slot(particle) as u32;
        let springs = topology.structural_springs().map(|(a, b, _)| [slot(a), slot(b)]);
        let mut ends: Vec<_> = springs.map(|[a, b]| [a.min(b), a.max(b)]).collect();
        ends.sort_unstable();
        let before = |block| ends.partition_point(|&[a, _]| (a as usize) < block * LANES) as u32;
        let first = (0..=slots / LANES).map(before).collect();
        Self { longest, joined: Joined::Pairs { ends, first } }
    }

    /// How many there are, with those that lead beside the sheet.
    pub fn count(&self) -> usize {
        match &self.joined {
            Joined::Neighbours { slots, .. } => FAN * slots,
            Joined::Pairs { ends, .. } => ends.len(),
        }
    }

    /// The slots that one joins.
    fn ends(&self, edge: u32) -> [usize; 2] {
        let edge = edge as usize;
        match &self.joined {
            Joined::Neighbours { hops, .. } => [edge / FAN, edge / FAN + hops[edge % FAN]],
            Joined::Pairs { ends, .. } => ends[edge].map(|slot| slot as usize),
        }
    }
}

/// How particles lie to a collider: what is known of those that are near to it.
#[derive(Clone, Debug)]
pub(in crate::solver) struct Nearby {
    /// Whether anything is known of a block.
    blocks: Vec<bool>,
    /// Gap beyond epsilon, by slot \[m\]; infinite where nothing is known.
    gap: Array,
    /// Outward normals by slot.
    normal: Soa,
    /// Edges that are looked at closely, by their places in the list.
    close: Vec<u32>,
    /// Close edges that are to be moved out, and the parts of them where.
    places: Vec<(u32, f32)>,
}

impl Nearby {
    /// Nothing known yet, of so many slots.
    pub fn new(slots: usize) -> Self {
        let mut gap = Array::zeros(slots);
        gap.fill(f32::INFINITY);
        Self {
            blocks: vec![false; slots / LANES],
            gap,
            normal: Soa::zeros(slots),
            close: Vec::with_capacity(FEW_CLOSE),
            places: Vec::with_capacity(FEW_CLOSE),
        }
    }

    /// For what finds out about it.
    pub fn part_mut(&mut self) -> NearbyMut<'_> {
        NearbyMut {
            blocks: ByBlock::all(&mut self.blocks),
            gap: ValuesMut::all(&mut self.gap),
            normal: self.normal.part_mut(),
        }
    }

    /// Forgets all.
    fn clear(&mut self) {
        for (block, known) in self.blocks.iter_mut().enumerate() {
            if core::mem::take(known) {
                Block::splat(f32::INFINITY).store(&mut self.gap, block * LANES);
            }
        }
    }
}

/// Finds the edges that may be held, and do not lie along a side that is gently curved: which of each block's do.
struct FindClose<'a> {
    edges: &'a Edges,
    nearby: &'a mut Nearby,
    rule: Rule,
    inside: Inside,
    until: &'a [f32],
    gone: f32,
}

impl Kernel for FindClose<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        self.nearby.close.clear();
        for block in 0..self.nearby.blocks.len() {
            if !self.nearby.blocks[block] {
                continue;
            }
            match &self.edges.joined {
                &Joined::Neighbours { hops, .. } => self.look_at_fans(block, hops),
                Joined::Pairs { ends, first } => {
                    for edge in first[block]..first[block + 1] {
                        let [a, b] = ends[edge as usize].map(|slot| slot as usize);
                        let Nearby { gap, normal, .. } = &*self.nearby;
                        let cosine = normal.get(a).dot(normal.get(b));
                        let is_out = gap[a] > self.rule.inside && gap[b] > self.rule.inside;
                        let reaches = gap[a] + gap[b] < self.rule.reach;
                        if is_out && reaches && cosine < self.rule.alike {
                            self.take(edge);
                        }
                    }
                }
            }
        }
    }
}

impl FindClose<'_> {
    #[inline(always)]
    fn look_at_fans(&mut self, block: usize, hops: [usize; FAN]) {
        let slot = block * LANES;
        let Nearby { gap, normal, .. } = &*self.nearby;
        let (gap0, normal0) = (Block::load(gap, slot), Block3::load(normal, slot));
        let mut found = [Block::ZERO; FAN];
        let mut any = Block::ZERO;
        for (found, hop) in found.iter_mut().zip(hops) {
            let (gap1, normal1) = (Block::load(gap, slot + hop), Block3::load(normal, slot + hop));
            for i in 0..LANES {
                let cosine = normal0.at(i).dot(normal1.at(i));
                let least = if gap0.0[i] < gap1.0[i] { gap0.0[i] } else { gap1.0[i] };
                let reaches = gap0.0[i] + gap1.0[i] < self.rule.reach;
                let reaches = reaches && least > self.rule.inside;
                let differs = if cosine < self.rule.alike { 1.0 } else { 0.0 };
                found.0[i] = if reaches { differs } else { 0.0 };
                any.0[i] = larger(found.0[i], any.0[i]);
            }
        }
        if any.largest() == 0.0 {
            return;
        }
        for lane in (0..LANES).filter(|&lane| any.0[lane] > 0.0) {
            for (i, (found, hop)) in found.iter().zip(hops).enumerate() {
                let from = slot + lane;
                if found.0[lane] > 0.0 && self.inside.has(from) && self.inside.has(from + hop) {
                    self.take((from * FAN + i) as u32);
                }
            }
        }
    }

    /// Takes an edge, unless it has been found to be further away.
    #[inline(always)]
    fn take(&mut self, edge: u32) {
        if self.until[edge as usize] <= self.gone {
            self.nearby.close.push(edge);
        }
    }
}

/// Which slots are of particles.
#[derive(Clone, Copy)]
struct Inside(Layout);

impl Inside {
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        let from = slot.wrapping_sub(self.0.slot(0, 0));
        from / self.0.stride < self.0.rows && from % self.0.stride < self.0.columns
    }
}

/// Gaps and normals that a band of rows finds out.
pub(in crate::solver) struct NearbyMut<'a> {
    blocks: ByBlock<'a, bool>,
    gap: ValuesMut<'a>,
    normal: PartMut<'a>,
}

impl CutAt for NearbyMut<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        let (blocks, blocks_below) = self.blocks.cut(slot);
        let (gap, gap_below) = self.gap.cut(slot);
        let (normal, normal_below) = self.normal.cut(slot);
        let below = Self { blocks: blocks_below, gap: gap_below, normal: normal_below };
        (Self { blocks, gap, normal }, below)
    }
}

impl NearbyMut<'_> {
    /// Notes gaps and normals of a block.
    #[inline(always)]
    pub fn set(&mut self, slot: usize, gap: &Block, normal: &Block3) {
        self.blocks.row(slot, 1)[0] = true;
        self.gap.blocks(slot, 1).set(0, *gap);
        normal.store(&mut self.normal, slot);
    }
}

/// Which edges are looked at closely.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rule {
    /// Sum of the gaps of both ends from which on an edge is held anyway \[m\].
    pub reach: f32,
    /// Gap below which an end is inside: it comes out by itself, before its edges are held.
    inside: f32,
    /// Least cosine between normals of a side that is gently curved.
    alike: f32,
}

impl Rule {
    /// For edges of a cloth and a collider; `None` where none is ever to be looked at, as the whole solid is gently
    /// curved. Edges may be longer than at rest by `stretch`.
    pub fn new(edges: &Edges, motion: &Motion<'_>, skin: &Skin, stretch: f32) -> Option<Self> {
        let length = edges.longest * stretch;
        // An arc over a chord, and the angle between its normals: the sagitta is an eighth of their product.
        let sagitta = larger(HELD * skin.epsilon, SAGITTA * length);
        // What is fast stretches edges, and then passes between particles whatever its curvature.
        if motion.reach > FAST * length {
            return None;
        }
        let is_slow = motion.reach <= SLOW * length;
        if is_slow && length * length <= 8.0 * sagitta * motion.least_radius {
            return None;
        }
        let angle = 8.0 * sagitta / length;
        let less = 2.0 * (HELD - 1.0) * skin.epsilon + motion.reach;
        let reach = length + less;
        (reach > 0.0).then_some(Self {
            reach,
            inside: -INSIDE * skin.epsilon - motion.reach,
            alike: 1.0 - 0.5 * angle * angle,
        })
    }
}

/// Holds the edges of a cloth out of one collider.
pub(super) struct HoldEdges<'a> {
    pub edges: &'a Edges,
    pub layout: Layout,
    pub nearby: &'a mut Nearby,
    pub rule: Rule,
    /// The ways at which edges may touch, and the way that has been gone, as `ContactRoom` counts it \[m\].
    pub until: &'a mut [f32],
    pub gone: f32,
    pub motion: &'a Motion<'a>,
    pub skin: &'a Skin,
    pub inverse_mass: &'a [f32],
    pub x: &'a mut Soa,
    pub d: &'a mut Soa,
    /// Pulls noted from before the corrections on (`carry`), of which contact is none.
    pub pull: Option<&'a mut Soa>,
    pub set: &'a mut ActiveSet,
    /// Which one it is.
    pub collider: usize,
}

/// Edges of a collider, once they are held.
#[derive(Default)]
pub(super) struct EdgesHeld {
    /// How far any particle was moved at most \[m\].
    pub pushed: f32,
    /// Momentum that the collider is given, times the substep \[kg m\].
    pub given: Vec3,
}

impl HoldEdges<'_> {
    pub fn run(mut self, isa: Isa) -> EdgesHeld {
        // What passes through may be inside.
        for &[slot, collider] in &self.set.freed {
            if collider as usize == self.collider && self.nearby.blocks[slot as usize / LANES] {
                self.nearby.gap[slot as usize] = 0.0;
            }
        }
        isa.run(FindClose {
            edges: self.edges,
            nearby: self.nearby,
            rule: self.rule,
            inside: Inside(self.layout),
            until: self.until,
            gone: self.gone,
        });
        // All are searched before any is moved: what is passed over as it is too far changes no bit of the others.
        let close = core::mem::take(&mut self.nearby.close);
        let mut places = core::mem::take(&mut self.nearby.places);
        for close in close.chunks(LANES) {
            self.search(close, &mut places);
        }
        let mut held = EdgesHeld::default();
        for (edge, t) in places.drain(..) {
            self.push_out(self.edges.ends(edge), t, &mut held);
        }
        (self.nearby.close, self.nearby.places) = (close, places);
        self.nearby.clear();
        held
    }

    /// Searches so many edges at once, and notes the places of those that are to be moved out.
    fn search(&mut self, close: &[u32], places: &mut Vec<(u32, f32)>) {
        let mut ends = [[0; 2]; LANES];
        for (lane, ends) in ends.iter_mut().enumerate() {
            // Unused lanes look for what the last one does.
            *ends = self.edges.ends(close[lane.min(close.len() - 1)]);
        }
        let search = Search::new(&ends, self.x, self.d, &self.motion.after);
        let (at, distance) = search.nearest(self.motion);
        for (lane, &edge) in close.iter().enumerate() {
            let gap = distance[lane] * self.motion.after.scale - HELD * self.skin.epsilon;
            if gap < 0.0 {
                places.push((edge, at[lane]));
            } else {
                let unsure = self.motion.overestimate + UNSURE * self.edges.longest;
                self.until[edge as usize] = self.gone + larger(gap - unsure, 0.0);
            }
        }
    }

    /// Moves an edge out at a place of it, and brakes it there.
    fn push_out(&mut self, [a, b]: [usize; 2], t: f32, held: &mut EdgesHeld) {
        let Self { motion, skin, .. } = self;
        let parts = [1.0 - t, t];
        let w = [self.inverse_mass[a], self.inverse_mass[b]];
        let mobility = parts[0] * parts[0] * w[0] + parts[1] * parts[1] * w[1];
        if mobility <= 0.0 {
            return;
        }
        let between = |of: &Soa| of.get(a) * parts[0] + of.get(b) * parts[1];
        let moved = between(self.d);
        let place = between(self.x) + moved;
        let local = motion.after.to_local(place);
        let sample = motion.shape.sample(local);
        let depth = HELD * skin.epsilon - sample.distance * motion.after.scale;
        if depth <= 0.0 || depth.is_nan() {
            return;
        }
        // At the nearest place exactly the normal is across the edge. What the search is off by would drive it along.
        let outward = motion.after.rotate(sample.normal);
        let along = (self.x.get(b) + self.d.get(b)) - (self.x.get(a) + self.d.get(a));
        let across =
            outward - along * (outward.dot(along) / larger(along.dot(along), LEAST_SLIDING));
        let normal = across.normalize_or(outward);
        let is_freed = |slot| self.set.is_freed(slot, self.collider);
        let passes = is_freed(a) || is_freed(b);
        let (stretch, deep) = if passes {
            (UNHOOKED_STRETCH, 0.0)
        } else {
            (HOOKED_STRETCH, HOOKED_DEPTH * skin.epsilon)
        };
        let hooked = stretch * self.edges.longest;
        // An end beyond the solid would be moved into it.
        let faces = |slot| self.nearby.normal.get(slot).dot(normal);
        let is_beyond = larger(-faces(a), -faces(b)) > BEYOND;
        // What is fast still pushes what it hooks.
        let is_slow = motion.reach <= SLOW * self.edges.longest;
        if is_slow && depth > deep && along.dot(along) > hooked * hooked {
            for slot in [a, b] {
                self.set.next_freed.push([slot as u32, self.collider as u32]);
            }
            return;
        }
        if passes || is_beyond {
            return;
        }
        let surface = if motion.moves { place - motion.before.to_world(local) } else { Vec3::ZERO };
        let relative = moved - surface;
        let approach = larger(-relative.dot(normal), 0.0);
        let undone = if depth < approach { depth } else { approach };
        let allowed = larger(skin.most_push - larger(relative.dot(normal), 0.0), 0.0);
        let rest = if depth - undone < allowed { depth - undone } else { allowed };
        let tangential = relative - normal * relative.dot(normal);
        let sliding = larger(tangential.dot(tangential).sqrt(), LEAST_SLIDING);
        // With what the ends do not follow, and the collider bears already.
        let borne = between(&self.set.borne);
        let pressed = larger(-borne.dot(normal), 0.0);
        let stuck = borne + normal * pressed;
        let left = motion.friction * (undone + pressed) - stuck.dot(stuck).sqrt();
        let part = larger(left, 0.0) / sliding;
        let braked = tangential * if part < 1.0 { part } else { 1.0 };
        let (into_d, into_x) = (normal * undone - braked, normal * rest);
        // What is fast would push an end through itself, on a way that nothing looks at any more.
        let goes_through = |slot: usize, share: f32| {
            let (from, way) = (self.x.get(slot), self.d.get(slot) + (into_d + into_x) * share);
            let (from, to) = (motion.before.to_local(from), motion.after.to_local(from + way));
            let looks = (1..=LOOKS).map(|i| from.lerp(to, i as f32 / LOOKS as f32));
            looks.fold(f32::INFINITY, |least, at| least.min(motion.shape.distance(at))) < 0.0
        };
        let shares = [parts[0] * w[0] / mobility, parts[1] * w[1] / mobility];
        // Next to an end that is held, the other would be thrown about.
        let most = larger(shares[0], shares[1]);
        let part = if most > MOST_SHARE { MOST_SHARE / most } else { 1.0 };
        let shares = shares.map(|share| share * part);
        if !is_slow && (goes_through(a, shares[0]) || goes_through(b, shares[1])) {
            return;
        }
        for (slot, share) in [a, b].into_iter().zip(shares) {
            self.d.set(slot, self.d.get(slot) + into_d * share);
            self.x.set(slot, self.x.get(slot) + into_x * share);
            if let Some(pull) = &mut self.pull {
                pull.set(slot, pull.get(slot) - into_d * share);
            }
            let by = normal * ((undone + pressed) * share);
            let velocity = surface * (1.0 / skin.step);
            self.set.press_end(slot, self.collider, by, velocity, motion.friction);
            held.pushed = larger((into_d + into_x).length() * share, held.pushed);
        }
        held.given -= into_d * (part / mobility);
        if is_slow {
            self.brake_turning([a, b], normal, (undone + pressed) / mobility, held);
        }
    }

    /// Brakes the turning of an edge about where it is held, which nothing else stops: it is pressed by `load` there \[kg m\].
    fn brake_turning(&mut self, [a, b]: [usize; 2], normal: Vec3, load: f32, held: &mut EdgesHeld) {
        let w = [self.inverse_mass[a], self.inverse_mass[b]];
        let most = TURNING * self.motion.friction * load;
        let turning = normal.dot(self.d.get(b) - self.d.get(a));
        let braked = (0.5 * turning / (w[0] + w[1])).clamp(-most, most);
        for (slot, by) in [(a, braked * w[0]), (b, -braked * w[1])] {
            self.d.set(slot, self.d.get(slot) + normal * by);
            if let Some(pull) = &mut self.pull {
                pull.set(slot, pull.get(slot) - normal * by);
            }
            held.pushed = larger(by.abs(), held.pushed);
        }
    }
}

impl EdgesHeld {
    /// The share of a collider in the momentum.
    pub fn share(&self, collider: usize) -> Share {
        Share { collider, given: self.given, owed: Vec3::ZERO }
    }
}

/// Edges in a collider's frame, of which the places nearest to it are searched.
struct Search {
    from: PointBlock,
    way: PointBlock,
}

impl Search {
    fn new(ends: &[[usize; 2]; LANES], x: &Soa, d: &Soa, frame: &Frame) -> Self {
        let mut search = Self { from: PointBlock::default(), way: PointBlock::default() };
        for (lane, &[a, b]) in ends.iter().enumerate() {
            let (from, to) = (x.get(a) + d.get(a), x.get(b) + d.get(b));
            let (from, to) = (frame.to_local(from), frame.to_local(to));
            search.from.set(lane, from);
            search.way.set(lane, to - from);
        }
        search
    }

    /// The nearest places, as parts of the ways, and their distances.
    fn nearest(&self, motion: &Motion<'_>) -> ([f32; LANES], [f32; LANES]) {
        let (mut low, mut high) = ([0.0; LANES], [1.0; LANES]);
        let mut inner = [[GOLDEN; LANES], [1.0 - GOLDEN; LANES]];
        let mut found = [self.distances(&inner[0], motion), self.distances(&inner[1], motion)];
        for _ in 0..STEPS {
            let mut probe = [0.0; LANES];
            for i in 0..LANES {
                let is_low = found[0][i] < found[1][i];
                low[i] = if is_low { low[i] } else { inner[0][i] };
                high[i] = if is_low { inner[1][i] } else { high[i] };
                let width = (high[i] - low[i]) * GOLDEN;
                probe[i] = if is_low { low[i] + width } else { high[i] - width };
            }
            let new = self.distances(&probe, motion);
            for i in 0..LANES {
                let is_low = found[0][i] < found[1][i];
                let kept =
                    if is_low { (inner[0][i], found[0][i]) } else { (inner[1][i], found[1][i]) };
                let new = (probe[i], new[i]);
                let (first, second) = if is_low { (new, kept) } else { (kept, new) };
                (inner[0][i], found[0][i]) = first;
                (inner[1][i], found[1][i]) = second;
            }
        }
        let (mut at, mut distance) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let is_first = found[0][i] < found[1][i];
            at[i] = if is_first { inner[0][i] } else { inner[1][i] };
            distance[i] = if is_first { found[0][i] } else { found[1][i] };
        }
        (at, distance)
    }

    fn distances(&self, at: &[f32; LANES], motion: &Motion<'_>) -> [f32; LANES] {
        let mut points = PointBlock::default();
        for (i, at) in at.iter().enumerate() {
            points.x[i] = self.from.x[i] + self.way.x[i] * at;
            points.y[i] = self.from.y[i] + self.way.y[i] * at;
            points.z[i] = self.from.z[i] + self.way.z[i] * at;
        }
        let mut distances = [0.0; LANES];
        motion.shape.distance_block(&points, &mut distances);
        distances
    }
}
