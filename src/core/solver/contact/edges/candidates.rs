//! How particles lie to a collider, and which edges and faces between them are to be looked at closely.

use crate::solver::contact::edges::Rule;
use crate::solver::contact::edges::list::{Edges, FACES_BETWEEN, FAN, FAN_FACES, Joined, Pairs};
use crate::solver::contact::edges::look::Look;
use crate::solver::contact::edges::place::Place;
use crate::solver::contact::edges::solve::System;
use crate::solver::simd::block::{Block, Block3, larger, ones};
use crate::solver::simd::flags::raised;
use crate::solver::simd::gather::store;
use crate::solver::simd::isa::TransposingKernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::slots::{ByBlock, CutAt};
use crate::solver::simd::soa::{Array, PartMut, Soa, ValuesMut};
use crate::solver::simd::transpose::{Four, Transpose};

/// Edges that are looked at closely in a substep that there is room for from the start.
const FEW_CLOSE: usize = 4096;
/// Pressed edges that there is room for from the start.
const FEW_PRESSED: usize = 512;
/// Faces that are looked at closely.
const FEW_FACES: usize = 64;
/// A particle of which nothing is known: it is far away.
const UNKNOWN: Four = Four([0.0, 0.0, 0.0, f32::INFINITY]);

/// How particles lie to a collider: what is known of those that are near to it.
#[derive(Clone, Debug)]
pub(crate) struct Nearby {
    /// Whether anything is known of a block.
    pub(super) blocks: Vec<bool>,
    /// Gap beyond epsilon, by slot \[m\]; infinite where nothing is known.
    pub(super) gap: Array,
    /// Outward normals by slot.
    pub(super) normal: Soa,
    /// Normals and gaps of a mesh's particles, one after the other, to be gathered by index; empty for a lattice.
    around: Vec<Four>,
    /// Edges that are looked at closely, by their places in the list.
    pub(super) close: Vec<u32>,
    /// Faces that are looked at closely.
    pub(super) faces: Vec<CloseFace>,
    /// Places that are to be moved out.
    pub(super) places: Vec<Place>,
    /// Those, and where something was expected, as they are looked at.
    pub(super) looks: Vec<Look>,
    /// The pressed edges, as they are solved for.
    pub(super) system: System,
}

/// A face that is looked at closely.
#[derive(Clone, Copy, Debug)]
pub(super) struct CloseFace {
    /// Its place in the list.
    pub face: u32,
    /// Slots of its corners.
    pub corners: [u32; 3],
}

/// The ways at which edges and faces may touch a collider, and the way that has been gone, as `BroadPhase` counts them \[m\].
pub(crate) struct Until<'a> {
    pub edges: &'a mut [f32],
    /// Empty where it is not known of faces.
    pub faces: &'a mut [f32],
    pub gone: f32,
}

impl Until<'_> {
    /// Whether an edge may touch by now.
    #[inline(always)]
    fn reaches_edge(&self, edge: u32) -> bool {
        self.edges[edge as usize] <= self.gone
    }

    /// Whether a face may.
    #[inline(always)]
    fn reaches_face(&self, face: u32) -> bool {
        self.faces.get(face as usize).is_none_or(|&until| until <= self.gone)
    }

    /// Notes how far an edge is away at least \[m\].
    #[inline(always)]
    pub(super) fn set_edge(&mut self, edge: u32, away: f32) {
        self.edges[edge as usize] = self.gone + larger(away, 0.0);
    }

    /// Notes how far a face is away at least \[m\].
    #[inline(always)]
    pub(super) fn set_face(&mut self, face: u32, away: f32) {
        if let Some(until) = self.faces.get_mut(face as usize) {
            *until = self.gone + larger(away, 0.0);
        }
    }
}

impl Nearby {
    /// Nothing known yet, of so many slots that these edges join.
    pub fn new(slots: usize, edges: &Edges) -> Self {
        let mut gap = Array::zeros(slots);
        gap.fill(f32::INFINITY);
        let gathered = match edges.joined {
            Joined::Neighbours { .. } => 0,
            Joined::Pairs(_) => slots,
        };
        Self {
            blocks: vec![false; slots / LANES],
            gap,
            normal: Soa::zeros(slots),
            around: vec![UNKNOWN; gathered],
            close: Vec::with_capacity(FEW_CLOSE),
            faces: Vec::with_capacity(FEW_FACES),
            places: Vec::with_capacity(FEW_PRESSED),
            looks: Vec::with_capacity(FEW_PRESSED),
            system: System::new(slots, FEW_PRESSED),
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

    /// Puts what is known one after the other, to be gathered by index.
    #[inline(always)]
    fn line_up(&mut self, t: impl Transpose) {
        for block in raised(&self.blocks) {
            let at = block * LANES;
            let (normal, gap) = (Block3::load(&self.normal, at), Block::load(&self.gap, at));
            store(t, &mut self.around, at, normal, gap);
        }
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        for block in raised(&self.blocks) {
            let at = block * LANES;
            Block::splat(f32::INFINITY).store(&mut self.gap, at);
            if let Some(around) = self.around.get_mut(at..at + LANES) {
                around.fill(UNKNOWN);
            }
        }
        self.blocks.fill(false);
    }
}

/// Gaps and normals that a band of rows finds out.
pub(crate) struct NearbyMut<'a> {
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

/// Finds the edges that may be held, and do not lie along a side that is gently curved: which of each block's do.
pub(super) struct FindClose<'a> {
    pub edges: &'a Edges,
    pub nearby: &'a mut Nearby,
    pub rule: Rule,
    pub until: &'a Until<'a>,
}

impl TransposingKernel for FindClose<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self, t: impl Transpose) {
        self.nearby.close.clear();
        self.nearby.faces.clear();
        if let Joined::Pairs(_) = &self.edges.joined {
            self.nearby.line_up(t);
        }
        let blocks = core::mem::take(&mut self.nearby.blocks);
        for block in raised(&blocks) {
            match &self.edges.joined {
                Joined::Neighbours { hops, within, .. } => {
                    self.look_at_fans(block, *hops, &within[block]);
                }
                Joined::Pairs(pairs) => {
                    let [from, to] = [0, 1].map(|next| pairs.first[block + next] as usize);
                    for at in (from..to).step_by(LANES) {
                        self.look_at_pairs(t, pairs, at, to);
                    }
                }
            }
        }
        self.nearby.blocks = blocks;
    }
}

impl FindClose<'_> {
    /// Whether the edge between two slots is to be looked at. A face is where all three are: their corners see three sides of
    /// a solid, whose vertex may be in their midst.
    #[inline(always)]
    fn is_close(&self, a: usize, b: usize) -> bool {
        let (Nearby { gap, normal, .. }, rule) = (&*self.nearby, self.rule);
        let cosine = normal.get(a).dot(normal.get(b));
        let is_out = gap[a] > rule.inside && gap[b] > rule.inside;
        is_out && gap[a] + gap[b] < rule.reach && cosine < rule.alike
    }

    /// Looks at [`LANES`] edges of a mesh from one on, of those before `to`, and at the faces of those that are found.
    #[inline(always)]
    fn look_at_pairs(&mut self, t: impl Transpose, pairs: &Pairs, at: usize, to: usize) {
        let Self { nearby, rule, .. } = self;
        let (around, ends) = (&*nearby.around, &pairs.ends[at..at + LANES]);
        let [x0, y0, z0, gap0] = t.apart(|i| around[ends[i][0] as usize]);
        let [x1, y1, z1, gap1] = t.apart(|i| around[ends[i][1] as usize]);
        let mut found = Block::ZERO;
        for i in 0..LANES {
            let cosine = x0.0[i] * x1.0[i] + y0.0[i] * y1.0[i] + z0.0[i] * z1.0[i];
            let least = if gap0.0[i] < gap1.0[i] { gap0.0[i] } else { gap1.0[i] };
            let reaches = gap0.0[i] + gap1.0[i] < rule.reach && least > rule.inside;
            let differs = if cosine < rule.alike { 1.0 } else { 0.0 };
            found.0[i] = if reaches { differs } else { 0.0 };
        }
        // Those that follow are of another block.
        let within = u32::MAX >> (u32::BITS as usize - (to - at).min(LANES));
        for edge in ones(found.bits_above(0.0) & within).map(|i| at + i) {
            self.take(edge as u32);
            if !self.rule.has_faces {
                continue;
            }
            for (face, corners) in pairs.faces_of(edge as u32) {
                let [a, b, c] = corners.map(|slot| slot as usize);
                if self.is_close(b, c) && self.is_close(a, c) {
                    self.take_face(face, corners);
                }
            }
        }
    }

    #[inline(always)]
    fn look_at_fans(&mut self, block: usize, hops: [usize; FAN], within: &[u32; LANES]) {
        let slot = block * LANES;
        let Nearby { gap, normal, .. } = &*self.nearby;
        let (gap0, normal0) = (Block::load(gap, slot), Block3::load(normal, slot));
        let mut gaps = [Block::ZERO; FAN];
        let mut normals = [Block3::ZERO; FAN];
        for (i, hop) in hops.into_iter().enumerate() {
            gaps[i] = Block::load(gap, slot + hop);
            normals[i] = Block3::load(normal, slot + hop);
        }
        let Rule { reach, inside, alike, .. } = self.rule;
        // Which edges of a particle's fan are close, a bit each.
        let mut fans = [0; LANES];
        for (lane, fan) in fans.iter_mut().enumerate() {
            let (one, outward) = (gap0.0[lane], normal0.at(lane));
            for i in 0..FAN {
                let (other, cosine) = (gaps[i].0[lane], outward.dot(normals[i].at(lane)));
                let least = if one < other { one } else { other };
                let is_close = (one + other < reach) & (least > inside) & (cosine < alike);
                *fan |= if is_close { 1 << i } else { 0 };
            }
        }
        let mut any = 0;
        for lane in 0..LANES {
            fans[lane] &= within[lane];
            any |= fans[lane];
        }
        if any == 0 {
            return;
        }
        for (lane, fan) in fans.into_iter().enumerate() {
            if fan == 0 {
                continue;
            }
            let a = slot + lane;
            for i in ones(fan) {
                self.take((a * FAN + i) as u32);
            }
            if !self.rule.has_faces {
                continue;
            }
            for face in ones(FACES_BETWEEN[fan as usize]) {
                let [i, j] = FAN_FACES[face];
                let (b, c) = (a + hops[i], a + hops[j]);
                if self.is_close(b, c) {
                    let face = (a * FAN_FACES.len() + face) as u32;
                    self.take_face(face, [a, b, c].map(|slot| slot as u32));
                }
            }
        }
    }

    /// Takes an edge, unless it has been found to be further away.
    #[inline(always)]
    fn take(&mut self, edge: u32) {
        if self.until.reaches_edge(edge) {
            self.nearby.close.push(edge);
        }
    }

    /// Takes a face, unless it has been found to be further away.
    #[inline(always)]
    fn take_face(&mut self, face: u32, corners: [u32; 3]) {
        if self.until.reaches_face(face) {
            self.nearby.faces.push(CloseFace { face, corners });
        }
    }
}
