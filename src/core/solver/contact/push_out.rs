//! How a block of particles lies to a collider, and what pushes it out.

use bevy_math::Vec3;

use crate::sdf::{PointBlock, SampleBlock};
use crate::solver::contact::collider::Motion;
use crate::solver::contact::friction::Sliding;
use crate::solver::contact::hold::Hold;
use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::{BLOW, ContactSettings, HEAVY, LEAST_SLIDING, LEAST_SLIP, LIGHT};
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::Merge;

/// Momentum, remaining depth and count of the particles that met a collider in a substep, a lane each.
pub(super) struct Tally {
    /// Momentum that they gave it, times the substep \[kg m\].
    pub given: Block3,
    /// And will yet, as pulls are carried on \[kg m\].
    pub owed: Block3,
    /// Angular momentum of both about its centre, times the substep \[kg m2\].
    pub given_turn: Block3,
    pub owed_turn: Block3,
    /// How far they are still inside, as they may come out no faster \[m\].
    pub left: Block,
    /// How many touched it.
    pub touching: [u32; LANES],
}

impl Default for Tally {
    fn default() -> Self {
        let none = Block3::ZERO;
        Self {
            given: none,
            owed: none,
            given_turn: none,
            owed_turn: none,
            left: Block::ZERO,
            touching: [0; LANES],
        }
    }
}

impl Merge for Tally {
    fn merge(mut self, below: Self) -> Self {
        for i in 0..LANES {
            self.given.set(i, self.given.at(i) + below.given.at(i));
            self.owed.set(i, self.owed.at(i) + below.owed.at(i));
            self.given_turn.set(i, self.given_turn.at(i) + below.given_turn.at(i));
            self.owed_turn.set(i, self.owed_turn.at(i) + below.owed_turn.at(i));
            self.left.0[i] = larger(self.left.0[i], below.left.0[i]);
            self.touching[i] += below.touching[i];
        }
        self
    }
}

impl Tally {
    /// Adds what a particle at an arm from the collider's centre gives and owes it.
    #[inline(always)]
    pub fn give(&mut self, lane: usize, arm: Vec3, given: Vec3, owed: Vec3) {
        self.given.set(lane, self.given.at(lane) + given);
        self.owed.set(lane, self.owed.at(lane) + owed);
        self.given_turn.set(lane, self.given_turn.at(lane) + arm.cross(given));
        self.owed_turn.set(lane, self.owed_turn.at(lane) + arm.cross(owed));
    }

    /// The sum over the particles of what they gave.
    pub fn given(&self) -> Impulse {
        Impulse { linear: self.given.sum(), angular: self.given_turn.sum() }
    }

    /// The sum over the particles of what they owe.
    pub fn owed(&self) -> Impulse {
        Impulse { linear: self.owed.sum(), angular: self.owed_turn.sum() }
    }
}

/// The response of contact to a block of particles.
pub(super) struct Pushed {
    /// How far the collider moves at each \[m\].
    pub surface: Block3,
    /// Approach that was undone \[m\].
    pub undone: Block,
    /// How far they went along the surface before friction \[m\].
    went: Block,
    /// Displacements that contact has held back \[m\].
    unfollowed: Block3,
}

impl Pushed {
    /// Part of its inverse mass that is to move a particle along the surface in the next substep.
    ///
    /// Friction `f` is a force against the way `u` that the particle went, taken as `f u' / u` for the next way `u'`: what
    /// slides steadily is braked by `f`, and what sticks goes ever less.
    #[inline(always)]
    pub fn slip(&self, lane: usize, friction: f32, hold: &Hold, settings: &ContactSettings) -> f32 {
        let (went, pressed) = (self.went.0[lane], self.undone.0[lane]);
        let slips = larger(went / (went + friction * pressed), LEAST_SLIP);
        let light = (HEAVY - pressed * settings.per_weight) * (1.0 / (HEAVY - LIGHT));
        let slips = larger(slips, if light < 1.0 { light } else { 1.0 });
        // What is struck sticks at once.
        let rate = if hold.was.0[lane] > 0.0 { settings.following } else { 1.0 };
        let before = 1.0 / hold.unslipped.0[lane];
        before + (slips - before) * rate
    }

    /// Part of its way along the surface that friction left it: none where it sticks.
    #[inline(always)]
    pub fn loose(&self, lane: usize, friction: f32) -> f32 {
        let went = self.went.0[lane];
        larger(went - friction * self.undone.0[lane], 0.0) / went
    }

    /// Part of the pulls at a particle that is expected again. A particle that begins to touch by a blow expects ever less,
    /// the harder the blow.
    #[inline(always)]
    fn lasts(&self, lane: usize, hold: &Hold, settings: &ContactSettings) -> f32 {
        let blow = self.undone.0[lane] * settings.per_weight * (1.0 / BLOW);
        let struck = if hold.was.0[lane] > 0.0 { 0.0 } else { blow * blow };
        1.0 / (1.0 + struck)
    }
}

/// A collider and a cloth.
#[derive(Clone, Copy)]
pub(super) struct ParticleContact<'a> {
    pub motion: &'a Motion<'a>,
    pub settings: ContactSettings,
}

/// A block of particles seen from a collider.
pub(super) struct Near {
    /// In the collider's frame.
    points: PointBlock,
    /// Outward, in the cloth's frame, of length one.
    pub normals: Block3,
    /// How far they are to be moved out, had nothing held them \[m\]; 0 where they do not touch.
    pub depth: Block,
    /// Least of the gaps above epsilon that any would have \[m\]; below zero where it touches.
    pub least: f32,
    /// Gaps of the particles above epsilon \[m\].
    pub gap: Block,
    /// Least of those that are not held \[m\].
    pub deepest: f32,
}

impl ParticleContact<'_> {
    /// Looks where particles are that began the substep at `x`.
    #[inline(always)]
    pub fn sample(&self, w: &Block, x: &Block3, d: &Block3, held: Option<&Hold>) -> Near {
        let motion = self.motion;
        let mut points = PointBlock::default();
        for i in 0..LANES {
            let local = motion.after.to_local(x.at(i) + d.at(i));
            (points.x[i], points.y[i], points.z[i]) = (local.x, local.y, local.z);
        }
        let mut samples = SampleBlock::default();
        motion.sample_block(&points, &mut samples);
        let mut normals = Block3::ZERO;
        let (mut depth, mut gap, mut gaps) = (Block::ZERO, Block::ZERO, Block::ZERO);
        for i in 0..LANES {
            let outward = Vec3::new(samples.nx[i], samples.ny[i], samples.nz[i]);
            normals.set(i, motion.after.rotate(outward));
            let above = samples.distance[i] * motion.after.scale - self.settings.epsilon;
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
    pub fn push_out(
        &self,
        near: &Near,
        w: &Block,
        x: &mut Block3,
        d: &mut Block3,
        hold: &Hold,
        tally: &mut Tally,
    ) -> Pushed {
        let Self { motion, settings } = self;
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
            let allowed = larger(settings.most_push - larger(approach.0[i], 0.0), 0.0);
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
            let notes = if settings.notes { 1.0 } else { 0.0 };
            for i in 0..LANES {
                // Beside the sheet and where held, w is zero and nothing touches.
                let mass = 1.0 / larger(w.0[i], f32::MIN_POSITIVE);
                let turned = hold.unfollowed.at(i) - pressed.at(i);
                let given = (into_d.at(i) - pushed.unfollowed.at(i) - turned) * mass;
                let touching = depth.0[i] > 0.0;
                let owed = if touching { turned * (mass * notes) } else { Vec3::ZERO };
                let given = if touching { given } else { Vec3::ZERO };
                tally.give(i, x.at(i) - motion.centre[0], -given, owed);
            }
        }
        pushed
    }
}

impl Near {
    /// Pulls as they are noted, after contact: what contact does is no pull, and what it bore of one is. What begins to
    /// touch is struck, and expects nothing of that once more.
    #[inline(always)]
    pub fn kept(
        &self,
        noted: &Block3,
        before: &Block3,
        after: &Block3,
        pushed: &Pushed,
        hold: &Hold,
        settings: &ContactSettings,
    ) -> Block3 {
        let mut kept = *noted;
        for i in 0..LANES {
            // The substep's end adds the displacement.
            let all = noted.at(i) + before.at(i) + pushed.unfollowed.at(i);
            let lasts = all * pushed.lasts(i, hold, settings);
            let touches = self.depth.0[i] > 0.0;
            kept.set(i, if touches { lasts - after.at(i) } else { noted.at(i) });
        }
        kept
    }

    /// Tallies what is not: it would have gone on to move the particles, and their neighbours it does.
    #[inline(always)]
    pub fn forget(
        &self,
        noted: &Block3,
        before: &Block3,
        (w, arms): (&Block, &Block3),
        pushed: &Pushed,
        hold: &Hold,
        settings: &ContactSettings,
        tally: &mut Tally,
    ) {
        let mut masses = Block::ZERO;
        for i in 0..LANES {
            let part = (1.0 - pushed.lasts(i, hold, settings)) / larger(w.0[i], f32::MIN_POSITIVE);
            masses.0[i] = if self.depth.0[i] > 0.0 { part } else { 0.0 };
        }
        // A particle that was held before is not struck.
        if !masses.is_any() {
            return;
        }
        for i in 0..LANES {
            let forgotten = (noted.at(i) + before.at(i)) * masses.0[i];
            let forgotten = if self.depth.0[i] > 0.0 { forgotten } else { Vec3::ZERO };
            tally.give(i, arms.at(i), Vec3::ZERO, forgotten);
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
