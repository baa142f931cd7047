//! How particles lie to a collider, and which edges and faces between them are to be looked at closely.

use crate::solver::contact::edges::Rule;
use crate::solver::contact::edges::contact_point::Place;
use crate::solver::contact::edges::list::{Edges, FAN, FAN_FACES, Joined, Pairs, rests_of_fans};
use crate::solver::contact::edges::solve::System;
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::gather::store;
use crate::solver::simd::isa::TransposingKernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::slots::{ByBlock, CutAt};
use crate::solver::simd::soa::{Array, PartMut, Soa, ValuesMut};
use crate::solver::simd::transpose::{Four, Transpose};
use crate::solver::topology::lattice::Lattice;

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
    /// Slots of the corners of faces that are looked at closely.
    pub(super) faces: Vec<[u32; 3]>,
    /// Places that are to be moved out.
    pub(super) places: Vec<Place>,
    /// The pressed edges, as they are solved for.
    pub(super) system: System,
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
        for (block, _) in self.blocks.iter().enumerate().filter(|&(_, &known)| known) {
            let at = block * LANES;
            let (normal, gap) = (Block3::load(&self.normal, at), Block::load(&self.gap, at));
            store(t, &mut self.around, at, normal, gap);
        }
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        for (block, known) in self.blocks.iter_mut().enumerate() {
            if core::mem::take(known) {
                let at = block * LANES;
                Block::splat(f32::INFINITY).store(&mut self.gap, at);
                if let Some(around) = self.around.get_mut(at..at + LANES) {
                    around.fill(UNKNOWN);
                }
            }
        }
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
    pub until: &'a [f32],
    pub gone: f32,
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
        for block in 0..self.nearby.blocks.len() {
            if !self.nearby.blocks[block] {
                continue;
            }
            match &self.edges.joined {
                Joined::Neighbours { lattice, hops } => {
                    self.look_at_fans(lattice, block, *hops);
                }
                Joined::Pairs(pairs) => {
                    let [from, to] = [0, 1].map(|next| pairs.first[block + next] as usize);
                    for at in (from..to).step_by(LANES) {
                        self.look_at_pairs(t, pairs, at, to);
                    }
                }
            }
        }
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
        if !found.is_any_above(0.0) {
            return;
        }
        for edge in (at..to).take(LANES).filter(|edge| found.0[edge - at] > 0.0) {
            self.take(edge as u32);
            if !self.rule.has_faces {
                continue;
            }
            for face in pairs.faces_of(edge as u32) {
                let [a, b, c] = face.map(|slot| slot as usize);
                if self.is_close(b, c) && self.is_close(a, c) {
                    self.nearby.faces.push(*face);
                }
            }
        }
    }

    #[inline(always)]
    fn look_at_fans(&mut self, lattice: &Lattice, block: usize, hops: [usize; FAN]) {
        let slot = block * LANES;
        let Nearby { gap, normal, .. } = &*self.nearby;
        let (gap0, normal0) = (Block::load(gap, slot), Block3::load(normal, slot));
        let rests = rests_of_fans(lattice, slot);
        let mut found = [Block::ZERO; FAN];
        for ((found, hop), rest) in found.iter_mut().zip(hops).zip(&rests) {
            let (gap1, normal1) = (Block::load(gap, slot + hop), Block3::load(normal, slot + hop));
            for i in 0..LANES {
                let cosine = normal0.at(i).dot(normal1.at(i));
                let least = if gap0.0[i] < gap1.0[i] { gap0.0[i] } else { gap1.0[i] };
                let reaches = gap0.0[i] + gap1.0[i] < self.rule.reach;
                let reaches = reaches && least > self.rule.inside && rest.0[i] > 0.0;
                let differs = if cosine < self.rule.alike { 1.0 } else { 0.0 };
                found.0[i] = if reaches { differs } else { 0.0 };
            }
        }
        // Not on the way, where it would be stored and loaded again by each hop.
        let mut any = Block::ZERO;
        for i in 0..LANES {
            any.0[i] = found[0].0[i] + found[1].0[i] + found[2].0[i] + found[3].0[i];
        }
        if !any.is_any_above(0.0) {
            return;
        }
        for lane in (0..LANES).filter(|&lane| any.0[lane] > 0.0) {
            for (i, found) in found.iter().enumerate() {
                if found.0[lane] > 0.0 {
                    self.take(((slot + lane) * FAN + i) as u32);
                }
            }
            if !self.rule.has_faces {
                continue;
            }
            for [i, j] in FAN_FACES {
                let corners = [slot + lane, slot + lane + hops[i], slot + lane + hops[j]];
                let [_, b, c] = corners;
                if found[i].0[lane] > 0.0 && found[j].0[lane] > 0.0 && self.is_close(b, c) {
                    self.nearby.faces.push([corners[0] as u32, b as u32, c as u32]);
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
