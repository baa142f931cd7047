//! Threads under so much tension that they would overshoot sideways.
//!
//! A thread under tension is pulled straight. Its tensions are solved for as its springs lie, and where a
//! particle is off the straight way between its neighbours by `y`, they move it back by `2 w t y / l`. Beyond
//! `w t / l = 1/3` on a whole thread, each substep carries its particles further to the other side than they
//! were on this one, and the thread trembles. So stiff threads are where their pins want them longer than
//! they can be, or where a load is more than the substep allows for.
//!
//! There what straightens a thread is taken at the substep's end, not at its start (Tournier, Nesme, Gilles
//! and Faure 2015, *Stable Constrained Dynamics*): the corrections `c` of its particles become the `z` of
//! `(1 + G) z = c`, where `G` is the Laplacian of the thread weighted by what `w t / l` has too much.
//! Momentum is kept, and what moves the thread as a whole.

use crate::solver::constraints::threads::line::Line;
use crate::solver::constraints::threads::tridiagonal::Eliminated;
use crate::solver::contact::divide;
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::lanes::LANES;

/// `w t / l` from which a tension is too much.
const STEADY: f32 = 0.33;

/// Largest correction by one spring at which a thread does not tremble, for the shortest rest length of any \[m\].
pub(crate) fn steady(rests: impl Iterator<Item = f32>) -> f32 {
    STEADY * rests.filter(|&rest| rest > 0.0).fold(f32::INFINITY, f32::min)
}

/// [`LANES`] threads as [`ease`] reads and corrects them.
pub(crate) trait Threads {
    /// Particles of a thread.
    fn places(&self) -> usize;
    /// Inverse masses at a place \[1/kg\].
    fn inverse_mass(&self, place: usize) -> Block;
    /// Rest lengths of the springs after a place \[m\]; 0 where there are none.
    fn rest(&self, place: usize) -> Block;
    /// Normals of what the particles at a place lie on, where any do.
    fn normals(&self, place: usize) -> Option<Block3>;
    /// Takes what pulls the particles at a place along those.
    fn load(&mut self, place: usize, load: &Block);
    /// Takes what the particles at a place are to be corrected by more than they were.
    fn correct_more(&mut self, place: usize, more: Block3);
}

/// Corrects the particles of threads that have been solved and corrected, from what their solution left in
/// `line`.
#[inline(always)]
pub(crate) fn ease(line: &mut Line, threads: &mut impl Threads) {
    eliminate(line, threads);
    substitute(line, threads);
}

/// Works out tensions and corrections `c` anew, from the last place to the first, and eliminates
/// `(1 + G) z = c` on the way: the factors take the place of what is handed on, the right-hand sides that of the
/// spans, each once it has served.
#[inline(always)]
fn eliminate(line: &mut Line, threads: &impl Threads) {
    let (mut pull, mut handed_on) = (Block3::ZERO, Block::ZERO);
    let (mut after, mut factor, mut right) = (Block::ZERO, Block::ZERO, Block3::ZERO);
    for place in (0..threads.places()).rev() {
        let w = threads.inverse_mass(place);
        let normals = threads.normals(place);
        let (mut pull_before, mut before) = (Block3::ZERO, Block::ZERO);
        if place > 0 {
            let Eliminated { span, length, own, handed_on: part, .. } = &line.springs[place - 1];
            let (next, rest) = (threads.inverse_mass(place - 1), threads.rest(place - 1));
            for i in 0..LANES {
                let tension = own.0[i] + handed_on.0[i];
                handed_on.0[i] = part.0[i] * tension;
                pull_before.set(i, span.at(i) * tension);
                let pulled = tension * length.0[i] / rest.0[i];
                let over = pulled - STEADY / larger(w.0[i], next.0[i]);
                before.0[i] = if rest.0[i] > 0.0 { larger(over, 0.0) } else { 0.0 };
            }
        }
        let (mut both, mut correction) = (Block3::ZERO, Block3::ZERO);
        for i in 0..LANES {
            both.set(i, pull.at(i) - pull_before.at(i));
        }
        let both = moving(&both, &normals);
        for i in 0..LANES {
            let c = both.at(i) * w.0[i];
            let (a, b) = (w.0[i] * after.0[i], w.0[i] * before.0[i]);
            let inverse = 1.0 / (1.0 + b + a * (1.0 - factor.0[i]));
            right.set(i, (c + right.at(i) * a) * inverse);
            factor.0[i] = b * inverse;
            correction.set(i, c);
        }
        let served = &mut line.springs[place];
        (served.handed_on, served.span) = (factor, right);
        line.corrections[place] = correction;
        (pull, after) = (pull_before, before);
    }
}

/// Back substitution, and what it comes to beyond the corrections that were made.
#[inline(always)]
fn substitute(line: &Line, threads: &mut impl Threads) {
    let mut z = Block3::ZERO;
    for place in 0..threads.places() {
        let Eliminated { span: right, handed_on: factor, .. } = &line.springs[place];
        let c = &line.corrections[place];
        let mut more = Block3::ZERO;
        for i in 0..LANES {
            z.set(i, right.at(i) + z.at(i) * factor.0[i]);
            more.set(i, z.at(i) - c.at(i));
        }
        if let Some(normals) = threads.normals(place) {
            // What a particle lies on keeps it where it is, and bears that.
            let (along, mut load) = divide(&more, &normals);
            let w = threads.inverse_mass(place);
            for i in 0..LANES {
                load.0[i] /= larger(w.0[i], f32::MIN_POSITIVE);
            }
            threads.load(place, &load);
            more = along;
        }
        threads.correct_more(place, more);
    }
}

/// The part of pulls that moves particles, where they lie on surfaces of these normals.
#[inline(always)]
fn moving(pull: &Block3, normals: &Option<Block3>) -> Block3 {
    match normals {
        Some(normals) => divide(pull, normals).0,
        None => *pull,
    }
}
