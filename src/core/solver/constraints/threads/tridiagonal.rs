//! The tridiagonal systems of threads: elimination from the first spring to the last, and back substitution.

use bevy_math::Vec3;

use crate::solver::contact::{LEAST_MOBILITY, divide};
use crate::solver::simd::block::{Block, Block3, larger, smaller};
use crate::solver::simd::lanes::LANES;

/// Least compliance of a constraint, relative to the inverse masses of its ends. A straight line
/// held at both ends has one constraint too many; this keeps its matrix far enough from singular
/// for f32, at a strain of the same size.
const LEAST_COMPLIANCE: f32 = 1e-5;
/// Least pivot \[m2/kg\]: between two held particles nothing can move, whatever the residual, and a
/// collapsed spring has no direction and is left alone.
const LEAST_PIVOT: f32 = 1e-30;

/// Where the particles of [`LANES`] threads are, and where their corrections go.
pub(crate) trait Ends {
    /// Whether any of them lies on a collider.
    const TOUCH: bool;
    /// Whether there may be no spring between two places: one of no rest length.
    const HAS_GAPS: bool = false;
    /// Normals of what the particles at a place lie on.
    fn normals(&self, place: usize) -> Block3;
    /// Parts of their inverse masses that move them.
    fn slip(&self, place: usize) -> Block;
    /// Takes what pulls them along those.
    fn load(&mut self, place: usize, load: &Block);
    /// Positions of the particles at a place along the threads.
    fn positions(&self, place: usize) -> Block3;
    /// Takes their corrections.
    fn correct(&mut self, place: usize, correction: Block3);
    /// Takes more of them.
    fn correct_more(&mut self, place: usize, correction: Block3);
}

/// How soft the springs are, and how long they may be.
#[derive(Clone, Copy)]
pub(crate) struct Reach {
    /// `1 / (k h^2)` of a spring of shape factor one \[1/kg\].
    pub compliance: f32,
    /// Longest that a spring may be, in rest lengths.
    pub limit: f32,
    /// Largest correction by one spring at which a taut thread does not tremble \[m\].
    pub steady: f32,
}

/// A law that springs are held to.
pub(crate) trait Law {
    /// How soft the springs are, and how long they may be.
    fn reach(&self) -> &Reach;
    /// The compliance of a spring \[1/kg\], and how much longer it is than it is to be \[m\]; of shape factor `1 / factor`, between ends
    /// whose inverse masses sum up to `both`.
    fn hold(&self, length: f32, rest: f32, factor: f32, both: f32) -> (f32, f32);
}

impl Law for Reach {
    #[inline(always)]
    fn reach(&self) -> &Reach {
        self
    }

    #[inline(always)]
    fn hold(&self, length: f32, rest: f32, factor: f32, both: f32) -> (f32, f32) {
        // In this order the larger of the two is a number even where the first is NaN.
        (larger(factor * self.compliance, both * LEAST_COMPLIANCE), length - rest)
    }
}

/// The ends of springs: positions, inverse masses, and normals of the surfaces that they lie on; and how much shorter than they are to be
/// the springs are asked to be \[m\].
pub(crate) struct Between<'a> {
    pub x: [&'a Block3; 2],
    pub w: [&'a Block; 2],
    pub normals: [&'a Block3; 2],
    pub shift: &'a Block,
}

/// One step of the elimination.
#[derive(Clone, Copy)]
pub(crate) struct Pivot {
    pub springs: Eliminated,
    /// 1 / pivot \[kg/m2\].
    inverse: Block,
    /// Length times excess length, and what the springs before add to it \[m2\].
    residual: Block,
}

/// Springs as elimination leaves them: their tensions are their own ones and what they take over of those of the springs after.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Eliminated {
    /// From one end of the springs to the other, and how long that is \[m\].
    pub span: Block3,
    pub length: Block,
    /// Their own tensions over their lengths \[kg\].
    pub own: Block,
    /// Part of their tensions that the springs before take over.
    pub handed_on: Block,
    /// How far the springs go along the normals at their second ends \[m\].
    across: Block,
}

impl Default for Eliminated {
    fn default() -> Self {
        let none = Block::ZERO;
        Self { span: Block3::ZERO, length: none, own: none, handed_on: none, across: none }
    }
}

impl Default for Pivot {
    fn default() -> Self {
        let springs = Eliminated::default();
        Self { springs, inverse: Block::ZERO, residual: Block::ZERO }
    }
}

impl Eliminated {
    /// Takes the place of others.
    #[inline(always)]
    pub fn put<E: Ends>(&self, to: &mut Self) {
        // One by one: what is put as a whole is made elsewhere, and copied.
        to.span = self.span;
        to.length = self.length;
        to.own = self.own;
        to.handed_on = self.handed_on;
        if E::TOUCH {
            to.across = self.across;
        }
    }
}

impl Pivot {
    /// The step after this one, for the springs between two places. Notes by how much they exceed their limit; those
    /// without a rest length are none.
    #[inline(always)]
    pub fn next<E: Ends>(
        &self,
        law: &impl Law,
        between: &Between<'_>,
        rest: &Block,
        factor: &Block,
        excess: &mut Block,
    ) -> Self {
        let Between { x, w, normals, shift } = between;
        let mut next = Self::default();
        for i in 0..LANES {
            let is_there = !E::HAS_GAPS || rest.0[i] > 0.0;
            let span = x[1].at(i) - x[0].at(i);
            let span = if is_there { span } else { Vec3::ZERO };
            let square = span.dot(span);
            // Not `Vec3::length`, whose square root may be a call.
            let length = square.sqrt();
            let beyond = length - rest.0[i] * law.reach().limit;
            let beyond = if rest.0[i] > 0.0 { beyond } else { 0.0 };
            excess.0[i] = larger(beyond, excess.0[i]);
            let diagonal = w[0].0[i] + w[1].0[i];
            let factor = if is_there { factor.0[i] } else { 0.0 };
            let (soft, over) = law.hold(length + shift.0[i], rest.0[i], factor, diagonal);
            let mut whole = square * (diagonal + soft);
            let mut along = span.dot(self.springs.span.at(i));
            if E::TOUCH {
                let (n0, n1) = (normals[0].at(i), normals[1].at(i));
                let (across0, across1) = (n0.dot(span), n1.dot(span));
                let still = w[0].0[i] * (across0 * across0) + w[1].0[i] * (across1 * across1);
                let all = square * diagonal;
                whole = larger(all - still, all * LEAST_MOBILITY) + square * soft;
                along -= across0 * self.springs.across.0[i];
                next.springs.across.0[i] = across1;
            }
            let beside = w[0].0[i] * along;
            let handed_on = beside * self.inverse.0[i];
            // The square does not wait for the step before. One that overflows would be infinite; as the largest number it makes the springs
            // softer.
            let taken = smaller(beside * beside, f32::MAX) * self.inverse.0[i];
            let inverse = 1.0 / larger(whole - taken, LEAST_PIVOT);
            let residual = length * over + handed_on * self.residual.0[i];
            next.springs.span.set(i, span);
            next.springs.length.0[i] = length;
            next.springs.own.0[i] = residual * inverse;
            next.springs.handed_on.0[i] = handed_on;
            next.inverse.0[i] = inverse;
            next.residual.0[i] = residual;
        }
        next
    }
}

/// The pull of the springs that come after a place.
#[derive(Clone, Copy)]
pub(crate) struct Tension {
    pull: Block3,
    /// The part of their tensions over their lengths that the springs before take over \[kg\].
    handed_on: Block,
    /// Multipliers of the springs before the last place \[kg m\].
    pub multipliers: Block,
    /// Largest correction by one spring so far \[m\].
    pub most: Block,
}

impl Default for Tension {
    fn default() -> Self {
        let none = Block::ZERO;
        Self { pull: Block3::ZERO, handed_on: none, multipliers: none, most: none }
    }
}

impl Tension {
    /// Goes on to the springs before the particles of a place, of inverse masses `w`, and gives these their corrections.
    /// What the particles lie on takes the rest.
    #[inline(always)]
    pub fn next<E: Ends>(
        &mut self,
        springs: &Eliminated,
        w: &Block,
        ends: &mut E,
        place: usize,
    ) -> Block3 {
        let normals = ends.normals(place);
        let (mut pull, mut correction, mut load) = (Block3::ZERO, Block3::ZERO, Block::ZERO);
        for i in 0..LANES {
            let (span, after) = (springs.span.at(i), self.pull.at(i));
            let tension = springs.own.0[i] + self.handed_on.0[i];
            self.handed_on.0[i] = springs.handed_on.0[i] * tension;
            let multiplier = tension * springs.length.0[i];
            self.multipliers.0[i] = multiplier;
            self.most.0[i] = larger(multiplier * w.0[i], self.most.0[i]);
            pull.set(i, span * tension);
            let mut moves = after - pull.at(i);
            if E::TOUCH {
                let n = normals.at(i);
                load.0[i] = n.dot(after) - springs.across.0[i] * tension;
                moves -= n * load.0[i];
            }
            correction.set(i, moves * w.0[i]);
        }
        if E::TOUCH {
            ends.load(place, &load);
        }
        self.pull = pull;
        correction
    }

    /// Corrections of the first particles.
    #[inline(always)]
    pub fn last<E: Ends>(&self, w: &Block, ends: &mut E) -> Block3 {
        let mut moves = self.pull;
        if E::TOUCH {
            let (along, load) = divide(&self.pull, &ends.normals(0));
            ends.load(0, &load);
            moves = along;
        }
        let mut correction = Block3::ZERO;
        for i in 0..LANES {
            correction.set(i, moves.at(i) * w.0[i]);
        }
        correction
    }
}
