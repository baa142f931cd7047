//! A band of particles meets one collider.

use bevy_math::Vec3;

use super::super::bands::{Band, Cut, CutAt, Merge, cut_between_rows};
use super::super::isa::{Isa, Kernel};
use super::super::lanes::{
    Block, Block3, Blocks, Blocks3, Blocks3Mut, LANES, PartMut, Soa, larger,
};
use super::collider::Motion;
use super::loads::Loads;
use super::room::Known;
use super::sweep::Sweep;
use super::{LEAST_SLIDING, Skin};
use crate::sdf::{PointBlock, SampleBlock};

/// What the particles that met a collider in a substep came to, a lane each.
pub(super) struct Tally {
    /// Momentum that they gave it, times the substep \[kg m\].
    pub given: Block3,
    /// Pulls that they will not follow in the next substep, times their masses \[kg m\].
    pub forgotten: Block3,
    /// How far they are still inside, as they may come out no faster \[m\].
    pub left: Block,
    /// How many touched it.
    pub touching: [u32; LANES],
}

impl Default for Tally {
    fn default() -> Self {
        let none = Block3::ZERO;
        Self { given: none, forgotten: none, left: Block::ZERO, touching: [0; LANES] }
    }
}

/// The square of how far any particle goes in a substep \[m2\].
pub(super) struct FurthestWay<'a> {
    pub band: Band,
    pub d: &'a Soa,
}

/// The larger of two is what both come to.
pub(super) struct Most(pub f32);

impl Merge for Most {
    fn merge(self, below: Self) -> Self {
        Self(larger(self.0, below.0))
    }
}

impl Kernel for FurthestWay<'_> {
    type Output = Most;

    #[inline(always)]
    fn run(self) -> Most {
        let Band { layout, rows, .. } = self.band;
        let mut most = Block::ZERO;
        let blocks = layout.blocks_across();
        for row in rows {
            let d = Blocks3::new(self.d, layout.slot(row, 0), blocks);
            for block in 0..blocks {
                let d = d.at(block);
                for i in 0..LANES {
                    most.0[i] = larger(d.at(i).dot(d.at(i)), most.0[i]);
                }
            }
        }
        Most(most.largest())
    }
}

cut_between_rows!(FurthestWay);

/// Holds the particles of a band out of one collider.
pub(super) struct MeetCollider<'a> {
    pub band: Band,
    pub motion: &'a Motion<'a>,
    pub skin: Skin,
    /// Whether any particle may pass the collider's surface by more than epsilon.
    pub is_fast: bool,
    /// The way that has been gone, as `until` counts it \[m\].
    pub gone: f32,
    pub inverse_mass: &'a [f32],
    pub x: PartMut<'a>,
    pub d: PartMut<'a>,
    /// See [`ResolveContacts`].
    pub pull: Option<PartMut<'a>>,
    pub until: Known<'a>,
    pub loads_before: &'a Loads,
    /// Particles pressed by as much as makes a load, for each band.
    pub pressed: &'a mut [Vec<usize>],
}

/// What a band comes to.
#[derive(Default)]
pub(super) struct Met {
    pub tally: Tally,
    /// How far any particle was pushed \[m\].
    pub deepest: f32,
    /// Whether what was fast was stopped.
    pub struck: bool,
}

impl Merge for Met {
    fn merge(self, below: Self) -> Self {
        Self {
            tally: self.tally.merge(below.tally),
            deepest: larger(self.deepest, below.deepest),
            struck: self.struck || below.struck,
        }
    }
}

impl Merge for Tally {
    fn merge(mut self, below: Self) -> Self {
        for i in 0..LANES {
            self.given.set(i, self.given.at(i) + below.given.at(i));
            self.forgotten.set(i, self.forgotten.at(i) + below.forgotten.at(i));
            self.left.0[i] = larger(self.left.0[i], below.left.0[i]);
            self.touching[i] += below.touching[i];
        }
        self
    }
}

impl Kernel for MeetCollider<'_> {
    type Output = Met;

    #[inline(always)]
    fn run(mut self) -> Met {
        let Band { layout, rows, .. } = self.band.clone();
        let (motion, skin, gone) = (self.motion, self.skin, self.gone);
        let meeting = Meeting { motion, skin };
        let sweep = Sweep { motion, epsilon: skin.epsilon };
        let least_load = Loads::least_of_all(skin.least_load);
        let blocks = layout.blocks_across();
        let mut met = Met::default();
        self.pressed[0].clear();
        for row in rows {
            let first = layout.slot(row, 0);
            let w = Blocks::new(self.inverse_mass, first, blocks);
            let mut xs = Blocks3Mut::new(&mut self.x, first, blocks);
            let mut ds = Blocks3Mut::new(&mut self.d, first, blocks);
            #[expect(
                clippy::manual_map,
                reason = "a closure that is not inlined keeps the baseline's instructions"
            )]
            let mut pulls = match &mut self.pull {
                Some(pull) => Some(Blocks3Mut::new(pull, first, blocks)),
                None => None,
            };
            for (block, until) in self.until.row(first, blocks).iter_mut().enumerate() {
                if *until > gone {
                    continue;
                }
                let (w, mut x, mut d) = (w.at(block), xs.at(block), ds.at(block));
                if self.is_fast {
                    // Of copies: what a call is shown has to be in memory, and would stay there.
                    let (mut swept, given) = (d, &mut met.tally.given);
                    if sweep.block(&{ w }, &{ x }, &mut swept, given) {
                        met.struck = true;
                        ds.set(block, swept);
                        d = swept;
                    }
                }
                let near = meeting.sample(&w, &x, &d);
                let nearest = near.least - motion.overestimate;
                *until = gone + larger(nearest, 0.0);
                met.deepest = larger(-nearest, met.deepest);
                if near.least >= 0.0 {
                    continue;
                }
                let before = d;
                let load = meeting.push_out(&near, &w, &mut x, &mut d, &mut met.tally);
                xs.set(block, x);
                ds.set(block, d);
                if let Some(pulls) = &mut pulls {
                    let noted = pulls.at(block);
                    pulls.set(block, near.kept(&noted, &d));
                    if motion.measured {
                        near.forget(&noted, &before, &w, &mut met.tally);
                    }
                }
                if load.largest() > least_load {
                    let slot = first + block * LANES;
                    let loads = (self.loads_before, skin.least_load);
                    note_pressed(slot, &load, loads, &mut self.pressed[0]);
                }
            }
        }
        met
    }
}

impl Cut for MeetCollider<'_> {
    type Output = Met;

    fn band(&self) -> &Band {
        &self.band
    }

    fn cut(self, row: usize) -> (Self, Self) {
        let slot = self.band.slot(row);
        let (above, below) = self.band.cut(row);
        let (x, x_below) = self.x.cut(slot);
        let (d, d_below) = self.d.cut(slot);
        let (pull, pull_below) = self.pull.cut(slot);
        let (until, until_below) = self.until.cut(slot);
        let (pressed, pressed_below) = self.pressed.split_at_mut(above.count());
        let below = Self {
            band: below,
            x: x_below,
            d: d_below,
            pull: pull_below,
            until: until_below,
            pressed: pressed_below,
            ..self
        };
        (Self { band: above, x, d, pull, until, pressed, ..self }, below)
    }

    fn run(self, isa: Isa) -> Met {
        isa.run(self)
    }
}

/// A collider and a cloth.
#[derive(Clone, Copy)]
struct Meeting<'a> {
    motion: &'a Motion<'a>,
    skin: Skin,
}

/// A block of particles seen from a collider.
struct Near {
    /// In the collider's frame.
    points: PointBlock,
    samples: SampleBlock,
    /// How far they are to be moved out \[m\]; 0 where they do not touch.
    depth: Block,
    /// Least gap above epsilon of any \[m\]; below zero where it touches.
    least: f32,
}

impl Meeting<'_> {
    /// Looks where particles are that began the substep at `x`.
    #[inline(always)]
    fn sample(&self, w: &Block, x: &Block3, d: &Block3) -> Near {
        let motion = self.motion;
        let mut points = PointBlock::default();
        for i in 0..LANES {
            let local = motion.after.to_local(x.at(i) + d.at(i));
            (points.x[i], points.y[i], points.z[i]) = (local.x, local.y, local.z);
        }
        let mut samples = SampleBlock::default();
        match motion.known {
            Some(shape) => shape.sample_block(&points, &mut samples),
            None => motion.shape.sample_block(&points, &mut samples),
        }
        let (mut depth, mut gap) = (Block::ZERO, Block::ZERO);
        for i in 0..LANES {
            let above = samples.distance[i] * motion.after.scale - self.skin.epsilon;
            gap.0[i] = if w.0[i] > 0.0 { above } else { f32::INFINITY };
            depth.0[i] = larger(-gap.0[i], 0.0);
        }
        Near { points, samples, depth, least: gap.smallest() }
    }

    /// Moves particles out by their depth, and takes approach and friction from their displacements.
    /// Returns the approach that was undone.
    #[inline(always)]
    fn push_out(
        &self,
        near: &Near,
        w: &Block,
        x: &mut Block3,
        d: &mut Block3,
        tally: &mut Tally,
    ) -> Block {
        let Self { motion, skin } = self;
        let Near { points, samples, depth, .. } = near;
        let surface = surface_displacements(points, x, d, motion);
        let mut load = Block::ZERO;
        for i in 0..LANES {
            let normal =
                motion.after.rotate(Vec3::new(samples.nx[i], samples.ny[i], samples.nz[i]));
            let relative = d.at(i) - surface.at(i);
            let approach = relative.dot(normal);
            // What the push undoes of the approach belongs to the substep. The rest is a displacement
            // without velocity: being pushed out gives no speed.
            let push = depth.0[i];
            let undone = larger(if push < -approach { push } else { -approach }, 0.0);
            let rest = push - undone;
            load.0[i] = undone;
            let tangential = relative - normal * approach;
            let sliding = larger(tangential.dot(tangential).sqrt(), LEAST_SLIDING);
            let part = motion.friction * undone / sliding;
            let braked = tangential * if part < 1.0 { part } else { 1.0 };
            let touching = push > 0.0;
            tally.touching[i] += u32::from(touching);
            // Deep inside that takes more than a substep, at the speed allowed.
            let allowed = larger(skin.most_push - larger(approach, 0.0), 0.0);
            let moved = if rest < allowed { rest } else { allowed };
            tally.left.0[i] = larger(rest - moved, tally.left.0[i]);
            let into_d = if touching { normal * undone - braked } else { Vec3::ZERO };
            let into_x = if touching { normal * moved } else { Vec3::ZERO };
            d.set(i, d.at(i) + into_d);
            x.set(i, x.at(i) + into_x);
            if motion.measured {
                // Beside the sheet and where held, w is zero and nothing touches.
                let mass = 1.0 / larger(w.0[i], f32::MIN_POSITIVE);
                let part = if touching { into_d * mass } else { Vec3::ZERO };
                tally.given.set(i, tally.given.at(i) - part);
            }
        }
        load
    }
}

impl Near {
    /// What is kept of the pulls noted: what is pressed onto a collider does not follow all of what pulls it, and the
    /// collider bears the rest. Neither is what it is to expect once more.
    #[inline(always)]
    fn kept(&self, noted: &Block3, d: &Block3) -> Block3 {
        let mut kept = *noted;
        for i in 0..LANES {
            // The substep's end adds the displacement.
            kept.set(i, if self.depth.0[i] > 0.0 { -d.at(i) } else { noted.at(i) });
        }
        kept
    }

    /// Tallies what is not. `before` are the displacements before contact.
    #[inline(always)]
    fn forget(&self, noted: &Block3, before: &Block3, w: &Block, tally: &mut Tally) {
        for i in 0..LANES {
            let mass = 1.0 / larger(w.0[i], f32::MIN_POSITIVE);
            let mass = if self.depth.0[i] > 0.0 { mass } else { 0.0 };
            let forgotten = (noted.at(i) + before.at(i)) * mass;
            tally.forgotten.set(i, tally.forgotten.at(i) + forgotten);
        }
    }
}

/// Notes the particles of a block that are pressed by as much as makes a load.
#[inline(never)]
fn note_pressed(
    slot: usize,
    load: &Block,
    (before, least): (&Loads, f32),
    pressed: &mut Vec<usize>,
) {
    for (slot, &load) in (slot..).zip(&load.0) {
        if load > before.least(slot, least) {
            pressed.push(slot);
        }
    }
}

/// How far the collider moves at the particles in the substep \[m\].
#[inline(always)]
fn surface_displacements(
    local: &PointBlock,
    x: &Block3,
    d: &Block3,
    motion: &Motion<'_>,
) -> Block3 {
    let mut surface = Block3::ZERO;
    if motion.moves {
        for i in 0..LANES {
            let at = x.at(i) + d.at(i);
            surface.set(i, at - motion.before.to_world(local.point(i)));
        }
    }
    surface
}
