//! A band of particles meets one collider.

use bevy_math::Vec3;

use crate::sdf::{PointBlock, SampleBlock};
use crate::solver::contact::active_set::Normals;
use crate::solver::contact::broad_phase::ByBlock;
use crate::solver::contact::collider::Motion;
use crate::solver::contact::edges::NearbyMut;
use crate::solver::contact::friction::Sliding;
use crate::solver::contact::swept::Sweep;
use crate::solver::contact::{BLOW, HEAVY, LEAST_SLIDING, LEAST_SLIP, LIGHT, Skin};
use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, Blocks3Mut, LANES, larger};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::parallel::{Band, Cut, Merge, cut_between_rows};
use crate::solver::simd::slots::CutAt;
use crate::solver::simd::soa::{PartMut, Soa, ValuesMut};

/// What the particles that met a collider in a substep came to, a lane each.
pub(super) struct Tally {
    /// Momentum that they gave it, times the substep \[kg m\].
    pub given: Block3,
    /// And will yet, as pulls are carried on \[kg m\].
    pub owed: Block3,
    /// How far they are still inside, as they may come out no faster \[m\].
    pub left: Block,
    /// How many touched it.
    pub touching: [u32; LANES],
}

impl Default for Tally {
    fn default() -> Self {
        let none = Block3::ZERO;
        Self { given: none, owed: none, left: Block::ZERO, touching: [0; LANES] }
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
    /// Which one it is.
    pub collider: usize,
    /// Whether any particle may pass the collider's surface by more than epsilon.
    pub is_fast: bool,
    /// The way that has been gone, as `until` counts it \[m\].
    pub gone: f32,
    pub inverse_mass: &'a [f32],
    pub x: PartMut<'a>,
    pub d: PartMut<'a>,
    /// See [`ResolveContacts`].
    pub pull: Option<PartMut<'a>>,
    pub until: ByBlock<'a, f32>,
    /// Gap within which particles are looked at for the sake of their edges \[m\].
    pub edge_reach: f32,
    /// Where their gaps and normals are noted, if they are.
    pub nearby: Option<NearbyMut<'a>>,
    /// The active set as the corrections saw it.
    pub held: Held<'a>,
    /// What lies on a collider now.
    pub found: Found<'a>,
}

/// Particles that have been held by what they lay on. What has met a collider is held no longer.
pub(super) struct Held<'a> {
    pub set: &'a Normals,
    /// Their displacements before anything pulled at them.
    pub unpulled: &'a Soa,
    pub lost: ValuesMut<'a>,
    pub load: ValuesMut<'a>,
}

impl CutAt for Held<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        let (lost, lost_below) = self.lost.cut(slot);
        let (load, load_below) = self.load.cut(slot);
        let below = Self { lost: lost_below, load: load_below, ..self };
        (Self { lost, load, ..self }, below)
    }
}

/// Where a band puts the active set of the next substep.
pub(super) struct Found<'a> {
    pub blocks: ByBlock<'a, bool>,
    pub normal: PartMut<'a>,
    pub slip: ValuesMut<'a>,
    pub velocity: PartMut<'a>,
    pub holder: ValuesMut<'a>,
}

impl CutAt for Found<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        let (blocks, blocks_below) = self.blocks.cut(slot);
        let (normal, normal_below) = self.normal.cut(slot);
        let (slip, slip_below) = self.slip.cut(slot);
        let (velocity, velocity_below) = self.velocity.cut(slot);
        let (holder, holder_below) = self.holder.cut(slot);
        let below = Self {
            blocks: blocks_below,
            normal: normal_below,
            slip: slip_below,
            velocity: velocity_below,
            holder: holder_below,
        };
        (Self { blocks, normal, slip, velocity, holder }, below)
    }
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
            self.owed.set(i, self.owed.at(i) + below.owed.at(i));
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
        let blocks = layout.blocks_across();
        let mut met = Met::default();
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
                if *until > gone + self.edge_reach {
                    continue;
                }
                let (w, mut x, mut d) = (w.at(block), xs.at(block), ds.at(block));
                let pulled = d;
                if self.is_fast {
                    self.held.free(first + block * LANES, &mut d, sweep.slow());
                    ds.set(block, d);
                    // Of copies: what a call is shown has to be in memory, and would stay there.
                    let (mut swept, given) = (d, &mut met.tally.given);
                    if sweep.block(&{ w }, &{ x }, &mut swept, given) {
                        met.struck = true;
                        ds.set(block, swept);
                        d = swept;
                    }
                }
                let slot = first + block * LANES;
                let mut held = self.held.of(slot, &w);
                if let Some(hold) = &mut held {
                    // What the collider stopped was no pull.
                    for i in 0..LANES {
                        hold.unpulled.set(i, hold.unpulled.at(i) + d.at(i) - pulled.at(i));
                    }
                }
                let near = meeting.sample(&w, &x, &d, held.as_ref());
                let nearest = near.least - motion.overestimate;
                *until = gone + larger(nearest, 0.0);
                met.deepest = larger(motion.overestimate - near.deepest, met.deepest);
                if let Some(nearby) = &mut self.nearby {
                    nearby.set(first + block * LANES, &near.gap, &near.normals);
                }
                if near.least >= 0.0 {
                    continue;
                }
                let hold = match held {
                    Some(hold) => hold,
                    None => Hold::NONE,
                };
                let before = d;
                let tally = &mut met.tally;
                let pushed = meeting.push_out(&near, &w, &mut x, &mut d, &hold, tally);
                xs.set(block, x);
                ds.set(block, d);
                if let Some(pulls) = &mut pulls {
                    let noted = pulls.at(block);
                    pulls.set(block, near.kept(&noted, &before, &d, &pushed, &hold, &skin));
                    if motion.measured {
                        near.forget(&noted, &before, &w, &pushed, &hold, &skin, tally);
                    }
                }
                if held.is_some() {
                    self.held.let_go(slot, &near);
                }
                self.found.take(
                    slot,
                    &near,
                    &pushed,
                    &hold,
                    (motion.friction, self.collider),
                    &skin,
                );
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
        let (held, held_below) = self.held.cut(slot);
        let (found, found_below) = self.found.cut(slot);
        let (nearby, nearby_below) = self.nearby.cut(slot);
        let below = Self {
            band: below,
            x: x_below,
            d: d_below,
            pull: pull_below,
            until: until_below,
            held: held_below,
            found: found_below,
            nearby: nearby_below,
            ..self
        };
        (Self { band: above, x, d, pull, until, held, found, nearby, ..self }, below)
    }

    fn run(self, isa: Isa) -> Met {
        isa.run(self)
    }
}

/// How a block of particles was held.
#[derive(Clone, Copy)]
struct Hold {
    /// What they would have gone by along the normals beyond what they went, had nothing held them \[m\].
    unfollowed: Block3,
    /// Their displacements before anything pulled at them \[m\].
    unpulled: Block3,
    /// What pulls would have moved them by along the surface, to what they did.
    unslipped: Block,
    /// One where a particle was held.
    was: Block,
}

impl Hold {
    const NONE: Self = Self {
        unfollowed: Block3::ZERO,
        unpulled: Block3::ZERO,
        unslipped: Block([1.0; LANES]),
        was: Block::ZERO,
    };
}

impl Held<'_> {
    /// How a block's particles were held; `None` where none was.
    #[inline(always)]
    fn of(&mut self, slot: usize, w: &Block) -> Option<Hold> {
        if !self.set.any || !self.set.blocks[slot / LANES] {
            return None;
        }
        let mut hold = Hold { unfollowed: Block3::load(&self.set.normal, slot), ..Hold::NONE };
        hold.unpulled = Block3::load(self.unpulled, slot);
        let slip = Block::load(&self.set.slip, slot);
        let (lost, load) = (self.lost.blocks(slot, 1).at(0), self.load.blocks(slot, 1).at(0));
        for i in 0..LANES {
            let n = hold.unfollowed.at(i);
            let all = lost.0[i] + load.0[i] * w.0[i];
            // What another collider has met is held no more.
            let was = n.dot(n) > 0.0 && all != 0.0;
            hold.was.0[i] = if was { 1.0 } else { 0.0 };
            hold.unslipped.0[i] = if was { 1.0 / slip.0[i] } else { 1.0 };
            hold.unfollowed.set(i, n * all);
        }
        Some(hold)
    }

    /// Lets those of a block's particles go that would go further than `slow`: the whole way of what is fast is looked
    /// at.
    #[inline(always)]
    fn free(&mut self, slot: usize, d: &mut Block3, slow: f32) {
        if !self.set.any || !self.set.blocks[slot / LANES] {
            return;
        }
        let n = Block3::load(&self.set.normal, slot);
        let mut values = self.lost.blocks(slot, 1);
        let mut lost = values.at(0);
        for i in 0..LANES {
            let own = d.at(i) + n.at(i) * lost.0[i];
            let is_fast = own.dot(own) > slow * slow && lost.0[i] != 0.0;
            d.set(i, if is_fast { own } else { d.at(i) });
            lost.0[i] = if is_fast { 0.0 } else { lost.0[i] };
        }
        values.set(0, lost);
    }

    /// Forgets what held those of a block's particles that touch.
    #[inline(always)]
    fn let_go(&mut self, slot: usize, near: &Near) {
        for values in [&mut self.lost, &mut self.load] {
            let mut values = values.blocks(slot, 1);
            let mut left = values.at(0);
            for i in 0..LANES {
                left.0[i] = if near.depth.0[i] > 0.0 { 0.0 } else { left.0[i] };
            }
            values.set(0, left);
        }
    }
}

/// What contact did to a block of particles.
struct Pushed {
    /// How far the collider moves at each \[m\].
    surface: Block3,
    /// Approach that was undone \[m\].
    undone: Block,
    /// How far they went along the surface before friction \[m\].
    went: Block,
    /// What they would have gone by beyond what they went, had nothing held them \[m\].
    unfollowed: Block3,
}

impl Pushed {
    /// Part of its inverse mass that is to move a particle along the surface in the next substep.
    ///
    /// Friction `f` is a force against the way `u` that the particle went, taken as `f u' / u` for the next way `u'`: what
    /// slides steadily is braked by `f`, and what sticks goes ever less.
    #[inline(always)]
    fn slip(&self, lane: usize, friction: f32, hold: &Hold, skin: &Skin) -> f32 {
        let (went, pressed) = (self.went.0[lane], self.undone.0[lane]);
        let slips = larger(went / (went + friction * pressed), LEAST_SLIP);
        let light = (HEAVY - pressed * skin.per_weight) * (1.0 / (HEAVY - LIGHT));
        let slips = larger(slips, if light < 1.0 { light } else { 1.0 });
        // What is struck sticks at once.
        let rate = if hold.was.0[lane] > 0.0 { skin.following } else { 1.0 };
        let before = 1.0 / hold.unslipped.0[lane];
        before + (slips - before) * rate
    }

    /// What part of the pulls at a particle is expected again. What begins to touch by a blow expects nothing.
    #[inline(always)]
    fn lasts(&self, lane: usize, hold: &Hold, skin: &Skin) -> f32 {
        let blow = self.undone.0[lane] * skin.per_weight * (1.0 / BLOW);
        let struck = if hold.was.0[lane] > 0.0 { 0.0 } else { blow * blow };
        1.0 / (1.0 + struck)
    }
}

impl Found<'_> {
    /// Takes a block's particles that touch into the active set.
    #[inline(always)]
    fn take(
        &mut self,
        slot: usize,
        near: &Near,
        pushed: &Pushed,
        hold: &Hold,
        (friction, collider): (f32, usize),
        skin: &Skin,
    ) {
        self.blocks.row(slot, 1)[0] = true;
        let mut normals = Block3::load(&self.normal, slot);
        let mut velocity = Block3::load(&self.velocity, slot);
        let mut slips = self.slip.blocks(slot, 1);
        let mut holders = self.holder.blocks(slot, 1);
        let mut holder = holders.at(0);
        let mut slip = slips.at(0);
        let rate = 1.0 / skin.step;
        for i in 0..LANES {
            let touches = near.depth.0[i] > 0.0;
            let n = near.normals.at(i);
            let (goes, surface) = (n.dot(pushed.surface.at(i)), pushed.surface.at(i) * rate);
            // What is fast may be gone in the next substep.
            let lies = if goes.abs() > skin.epsilon { Vec3::ZERO } else { n };
            normals.set(i, if touches { lies } else { normals.at(i) });
            velocity.set(i, if touches { surface } else { velocity.at(i) });
            holder.0[i] = if touches { collider as f32 } else { holder.0[i] };
            let free = pushed.slip(i, friction, hold, skin);
            let free = if goes.abs() > skin.epsilon { 1.0 } else { free };
            slip.0[i] = if touches { free } else { slip.0[i] };
        }
        velocity.store(&mut self.velocity, slot);
        slips.set(0, slip);
        holders.set(0, holder);
        normals.store(&mut self.normal, slot);
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
    /// Outward, in the cloth's frame, of length one.
    normals: Block3,
    /// How far they are to be moved out, had nothing held them \[m\]; 0 where they do not touch.
    depth: Block,
    /// Least of the gaps above epsilon that any would have \[m\]; below zero where it touches.
    least: f32,
    /// Their gaps above epsilon where they are \[m\].
    gap: Block,
    /// Least of those that are not held \[m\].
    deepest: f32,
}

impl Meeting<'_> {
    /// Looks where particles are that began the substep at `x`.
    #[inline(always)]
    fn sample(&self, w: &Block, x: &Block3, d: &Block3, held: Option<&Hold>) -> Near {
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
        let mut normals = Block3::ZERO;
        let (mut depth, mut gap, mut gaps) = (Block::ZERO, Block::ZERO, Block::ZERO);
        for i in 0..LANES {
            let outward = Vec3::new(samples.nx[i], samples.ny[i], samples.nz[i]);
            normals.set(i, motion.after.rotate(outward));
            let above = samples.distance[i] * motion.after.scale - self.skin.epsilon;
            gaps.0[i] = above;
            gap.0[i] = if w.0[i] > 0.0 { above } else { f32::INFINITY };
            depth.0[i] = larger(-gap.0[i], 0.0);
        }
        let deepest = gap.smallest();
        let mut least = deepest;
        if let Some(Hold { unfollowed, .. }) = held {
            for i in 0..LANES {
                gap.0[i] += unfollowed.at(i).dot(normals.at(i));
                depth.0[i] = larger(-gap.0[i], 0.0);
            }
            least = gap.smallest();
        }
        Near { points, normals, depth, least, gap: gaps, deepest }
    }

    /// Moves particles out by their depth, and takes approach and friction from their displacements, with all that
    /// they are pressed by. Returns how far the collider moves at each \[m\].
    #[inline(always)]
    fn push_out(
        &self,
        near: &Near,
        w: &Block,
        x: &mut Block3,
        d: &mut Block3,
        hold: &Hold,
        tally: &mut Tally,
    ) -> Pushed {
        let Self { motion, skin } = self;
        let Near { points, normals, depth, .. } = near;
        let surface = surface_displacements(points, x, d, motion);
        let none = Block::ZERO;
        let mut pushed = Pushed { surface, undone: none, went: none, unfollowed: Block3::ZERO };
        // In loops that do little each: what does all at once is not vectorized.
        let (mut along, mut approach) = (Block::ZERO, Block::ZERO);
        let (mut tangential, mut pressed) = (Block3::ZERO, Block3::ZERO);
        for i in 0..LANES {
            let normal = normals.at(i);
            let relative = d.at(i) - pushed.surface.at(i);
            along.0[i] = relative.dot(normal);
            let load = hold.unfollowed.at(i).dot(normal);
            pressed.set(i, normal * load);
            approach.0[i] = along.0[i] + load;
            // What the push undoes of the approach belongs to the substep. The rest is a displacement
            // without velocity: being pushed out gives no speed.
            let push = depth.0[i];
            let undone = if push < -approach.0[i] { push } else { -approach.0[i] };
            pushed.undone.0[i] = larger(undone, 0.0);
            tangential.set(i, relative - normal * along.0[i]);
        }
        let mut part = Block::ZERO;
        for i in 0..LANES {
            let sliding = Sliding {
                way: tangential.at(i),
                pulled: d.at(i) - hold.unpulled.at(i),
                unslipped: hold.unslipped.0[i],
            };
            pushed.unfollowed.set(i, pressed.at(i) + sliding.held());
            pushed.went.0[i] = larger(sliding.way.dot(sliding.way).sqrt(), LEAST_SLIDING);
            part.0[i] = sliding.braked(motion.friction * pushed.undone.0[i], normals.at(i));
        }
        let mut into_d = Block3::ZERO;
        for i in 0..LANES {
            let (normal, push, undone) = (normals.at(i), depth.0[i], pushed.undone.0[i]);
            let touching = push > 0.0;
            // Deep inside that takes more than a substep, at the speed allowed.
            let rest = push - undone;
            let allowed = larger(skin.most_push - larger(approach.0[i], 0.0), 0.0);
            let moved = if rest < allowed { rest } else { allowed };
            tally.left.0[i] = larger(rest - moved, tally.left.0[i]);
            let change = approach.0[i] + undone - along.0[i];
            let by = normal * change - tangential.at(i) * part.0[i];
            into_d.set(i, if touching { by } else { Vec3::ZERO });
            d.set(i, d.at(i) + into_d.at(i));
            x.set(i, x.at(i) + if touching { normal * moved } else { Vec3::ZERO });
        }
        for i in 0..LANES {
            tally.touching[i] += u32::from(depth.0[i] > 0.0);
        }
        if motion.measured {
            // What was borne along another normal is not noted.
            let notes = if skin.notes { 1.0 } else { 0.0 };
            for i in 0..LANES {
                // Beside the sheet and where held, w is zero and nothing touches.
                let mass = 1.0 / larger(w.0[i], f32::MIN_POSITIVE);
                let turned = hold.unfollowed.at(i) - pressed.at(i);
                let given = (into_d.at(i) - pushed.unfollowed.at(i) - turned) * mass;
                let touching = depth.0[i] > 0.0;
                let owed = if touching { turned * (mass * notes) } else { Vec3::ZERO };
                tally.owed.set(i, tally.owed.at(i) + owed);
                let given = if touching { given } else { Vec3::ZERO };
                tally.given.set(i, tally.given.at(i) - given);
            }
        }
        pushed
    }
}

impl Near {
    /// Pulls as they are noted, after contact: what contact does is no pull, and what it bore of one is. What begins to
    /// touch is struck, and expects nothing of that once more.
    #[inline(always)]
    fn kept(
        &self,
        noted: &Block3,
        before: &Block3,
        after: &Block3,
        pushed: &Pushed,
        hold: &Hold,
        skin: &Skin,
    ) -> Block3 {
        let mut kept = *noted;
        for i in 0..LANES {
            // The substep's end adds the displacement.
            let all = noted.at(i) + before.at(i) + pushed.unfollowed.at(i);
            let lasts = all * pushed.lasts(i, hold, skin);
            let touches = self.depth.0[i] > 0.0;
            kept.set(i, if touches { lasts - after.at(i) } else { noted.at(i) });
        }
        kept
    }

    /// Tallies what is not: it would have moved the particles by as much again, and their neighbours it does.
    #[inline(always)]
    fn forget(
        &self,
        noted: &Block3,
        before: &Block3,
        w: &Block,
        pushed: &Pushed,
        hold: &Hold,
        skin: &Skin,
        tally: &mut Tally,
    ) {
        for i in 0..LANES {
            let mass = 1.0 / larger(w.0[i], f32::MIN_POSITIVE);
            let forgotten = noted.at(i) + before.at(i);
            let forgotten = forgotten * ((1.0 - pushed.lasts(i, hold, skin)) * mass);
            let forgotten = if self.depth.0[i] > 0.0 { forgotten } else { Vec3::ZERO };
            tally.owed.set(i, tally.owed.at(i) + forgotten);
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
