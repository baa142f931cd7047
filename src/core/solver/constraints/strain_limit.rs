//! Springs corrected one batch at a time: shear in the thread form, and Provot's strain limit.
//!
//! Springs of a batch share no particle, so that the order within it does not matter. Corrections in
//! this coloured order are stable where the order of the particles explodes.

use crate::solver::constraints::strain_check::{Beyond, Limit};
use crate::solver::contact::{Contacts, LEAST_MOBILITY, divide};
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{self, Band, Cut};
use crate::solver::simd::slots::CutAt;
use crate::solver::simd::soa::{PartMut, Soa};
use crate::solver::topology::lattice::Lattice;

/// Least length of a spring \[m\]: a collapsed one has no direction and is left alone.
pub(crate) const LEAST_LENGTH: f32 = 1e-12;
/// Least divisor \[1/kg\]: between two held particles nothing can move.
pub(crate) const LEAST_DIVISOR: f32 = 1e-12;

/// Moves the ends of springs towards their target lengths.
pub(crate) struct CorrectSprings<'a> {
    pub band: Band,
    pub lattice: &'a Lattice,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub d: &'a mut Soa,
    pub rule: Rule,
    /// Where a pass of the limit looks at springs.
    pub beyond: &'a Beyond,
    /// The contacts of particles, where any lies on a collider.
    pub contacts: Option<Contacts<'a>>,
}

impl CorrectSprings<'_> {
    /// Corrects all of the rule's springs, batch by batch.
    pub fn run(self, isa: Isa) {
        let Self { band, lattice, inverse_mass, x, d, rule, beyond, mut contacts } = self;
        let mut correct = |batch| {
            let (band, d) = (band.clone(), d.part_mut());
            let contacts = contacts.as_mut().map(Contacts::reborrow);
            let batch =
                CorrectBatch { band, lattice, inverse_mass, x, d, rule, batch, beyond, contacts };
            parallel::run(isa, batch);
        };
        let shear = match rule {
            Rule::Shear { .. } => true,
            Rule::Limit(Limit { shear, .. }) => {
                correct(Batch::WithinPairs);
                correct(Batch::BetweenPairs);
                shear
            }
        };
        if shear {
            correct(Batch::AcrossPairs);
            correct(Batch::AcrossBetween);
        }
    }
}

/// Springs that no spring of another band shares a particle with.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Batch {
    /// Weft springs, then the warp springs of pairs of rows.
    WithinPairs,
    /// The warp springs from each pair of rows to the next.
    BetweenPairs,
    /// The shear springs of pairs of rows.
    AcrossPairs,
    /// Springs from each pair of columns to the next.
    AcrossBetween,
}

impl Batch {
    /// Where its first pair of rows begins, after an even row.
    fn offset(self) -> usize {
        usize::from(matches!(self, Self::BetweenPairs | Self::AcrossBetween))
    }
}

/// Corrects the springs of a batch.
pub(super) struct CorrectBatch<'a> {
    pub band: Band,
    pub lattice: &'a Lattice,
    inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub d: PartMut<'a>,
    rule: Rule,
    batch: Batch,
    beyond: &'a Beyond,
    pub contacts: Option<Contacts<'a>>,
}

/// How far springs are corrected.
#[derive(Clone, Copy)]
pub(crate) enum Rule {
    /// Shear springs of the thread form: to their rest length with the compliance `1 / (k h^2)`
    /// \[1/kg\], or to `limit` rest lengths where that is shorter.
    Shear {
        /// Compliance of a spring of shape factor one.
        compliance: f32,
        /// 1 + max strain.
        limit: f32,
    },
    /// Structural springs, then shear springs if they have a stiffness: those longer than `limit`
    /// rest lengths are brought back to it, others are left alone (Provot 1995, section 4).
    Limit(Limit),
}

impl Kernel for CorrectBatch<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        match (self.rule, self.batch) {
            (Rule::Limit(Limit { longest, .. }), Batch::WithinPairs) => {
                self.weft(longest);
                self.warp(longest);
            }
            (Rule::Limit(Limit { longest, .. }), Batch::BetweenPairs) => self.warp(longest),
            (Rule::Limit(Limit { longest, .. }), _) => {
                self.diagonals(|spring| larger(spring.pull_to(longest), 0.0));
            }
            (Rule::Shear { compliance, limit }, _) => self.diagonals(|spring| {
                let elastic = (spring.length - spring.rest)
                    / (spring.inverse_masses + spring.factor * compliance);
                larger(elastic, spring.pull_to(limit))
            }),
        }
    }
}

impl Cut for CorrectBatch<'_> {
    type Output = ();

    fn middle(&self) -> Option<usize> {
        self.band.middle()
    }

    fn is_shared(&self) -> bool {
        self.band.shared
    }

    fn cut(self, row: usize) -> (Self, Self) {
        let slot = self.band.slot(row + self.batch.offset());
        let (d, d_below) = self.d.cut(slot);
        let (contacts, contacts_below) = self.contacts.cut(slot);
        let (above, below) = self.band.cut(row);
        let below = Self { band: below, d: d_below, contacts: contacts_below, ..self };
        (Self { band: above, d, contacts, ..self }, below)
    }

    fn run(self, isa: Isa) {
        isa.run(self);
    }
}

/// One spring as it is now.
pub(crate) struct Spring {
    pub length: f32,
    /// Rest length \[m\]; 0 where there is no spring.
    pub rest: f32,
    /// Compliance factor; infinite where there is no spring.
    pub factor: f32,
    /// Sum of the inverse masses of both ends \[1/kg\], not zero.
    pub inverse_masses: f32,
}

impl Spring {
    /// Multiplier that brings the spring to `limit` rest lengths \[m kg\]; an end of inverse mass `w` moves by `w` times
    /// it. Negative where the spring is shorter.
    #[inline(always)]
    pub fn pull_to(&self, limit: f32) -> f32 {
        let excess = (self.length - self.rest * limit) / self.inverse_masses;
        if self.rest > 0.0 { excess } else { -1.0 }
    }
}

/// Part of the sum `all` of both ends' inverse masses `w` that moves them along a spring \[1/kg\]. `across` is how far the
/// spring reaches along the normal of the surface that each end lies on.
#[inline(always)]
pub(crate) fn mobility(all: f32, across: [f32; 2], length: f32, w: [f32; 2]) -> f32 {
    let taken = w[0] * (across[0] * across[0]) + w[1] * (across[1] * across[1]);
    mobility_without(all, taken, length)
}

/// Sum of the inverse masses of a spring's ends as far as they move along it, from the sum `all` without contact: colliders
/// take `taken`, over the square of the spring's length \[1/kg\].
#[inline(always)]
pub(crate) fn mobility_without(all: f32, taken: f32, length: f32) -> f32 {
    larger(all - taken / (length * length), all * LEAST_MOBILITY)
}

impl CorrectBatch<'_> {
    /// Inverse masses of a block of particles, as far as friction lets them go.
    #[inline(always)]
    pub(super) fn mobile(&self, slot: usize) -> Block {
        let mut w = Block::load(self.inverse_mass, slot);
        if let Some(contacts) = &self.contacts {
            let slip = Block::load(&contacts.normals.slip, slot);
            for i in 0..LANES {
                w.0[i] *= slip.0[i];
            }
        }
        w
    }

    /// Whether the springs that begin in a block are looked at.
    #[inline(always)]
    pub(super) fn looks_at(&self, slot: usize) -> bool {
        matches!(self.rule, Rule::Shear { .. }) || self.beyond.reaches(slot)
    }

    /// The first rows of the batch's pairs.
    #[inline(always)]
    fn pairs(&self) -> impl Iterator<Item = usize> + use<> {
        let Band { layout, rows, .. } = &self.band;
        (rows.start + self.batch.offset()..rows.end.min(layout.rows - 1)).step_by(2)
    }

    /// Shear springs: of each pair of rows, both diagonals.
    #[inline(always)]
    fn diagonals(&mut self, law: impl Fn(Spring) -> f32 + Copy) {
        let lattice = self.lattice;
        let layout = lattice.layout;
        for row in self.pairs() {
            for column in (0..layout.columns - 1).step_by(LANES) {
                let (a, b) = (layout.slot(row, column), layout.slot(row + 1, column));
                if !self.looks_at(a) {
                    continue;
                }
                let factor = Block::load(&lattice.diagonal.compliance, a);
                let rest = Block::load(&lattice.diagonal.rest, a);
                self.pair(a, b + 1, rest, factor, law);
            }
            for column in (0..layout.columns - 1).step_by(LANES) {
                let (a, b) = (layout.slot(row, column), layout.slot(row + 1, column));
                if !self.looks_at(a) {
                    continue;
                }
                let factor = Block::load(&lattice.diagonal.compliance, a);
                let rest = Block::load(&lattice.antidiagonal_rest, a);
                self.pair(a + 1, b, rest, factor, law);
            }
        }
    }

    /// Warp springs of each pair of rows.
    #[inline(always)]
    fn warp(&mut self, limit: f32) {
        let layout = self.lattice.layout;
        for row in self.pairs() {
            for column in (0..layout.columns).step_by(LANES) {
                let (a, b) = (layout.slot(row, column), layout.slot(row + 1, column));
                if !self.looks_at(a) {
                    continue;
                }
                let rest = Block::load(&self.lattice.warp.rest, a);
                self.pair(a, b, rest, Block::ZERO, |spring| larger(spring.pull_to(limit), 0.0));
            }
        }
    }

    /// One block of springs between particles from `p` and from `q`; `law` gives how strongly one
    /// pulls, as the correction of an end of inverse mass one.
    #[inline(always)]
    fn pair(
        &mut self,
        p: usize,
        q: usize,
        rest: Block,
        factor: Block,
        law: impl Fn(Spring) -> f32,
    ) {
        let (xp, xq) = (Block3::load(self.x, p), Block3::load(self.x, q));
        let (mut dp, mut dq) = (Block3::load(&self.d, p), Block3::load(&self.d, q));
        let (wp, wq) = (self.mobile(p), self.mobile(q));
        let (mut span, mut length, mut both) = (Block3::ZERO, Block::ZERO, Block::ZERO);
        for i in 0..LANES {
            let apart = (xq.at(i) + dq.at(i)) - (xp.at(i) + dp.at(i));
            span.set(i, apart);
            length.0[i] = larger(apart.dot(apart).sqrt(), LEAST_LENGTH);
            both.0[i] = wp.0[i] + wq.0[i];
        }
        let (mut np, mut nq) = (Block3::ZERO, Block3::ZERO);
        if let Some(contacts) = &self.contacts {
            let normals = &contacts.normals.normal;
            (np, nq) = (Block3::load(normals, p), Block3::load(normals, q));
            for i in 0..LANES {
                let across = [np.at(i).dot(span.at(i)), nq.at(i).dot(span.at(i))];
                both.0[i] = mobility(both.0[i], across, length.0[i], [wp.0[i], wq.0[i]]);
            }
        }
        let (mut pulls, mut pull) = (Block3::ZERO, Block::ZERO);
        for i in 0..LANES {
            let (length, inverse_masses) = (length.0[i], larger(both.0[i], LEAST_DIVISOR));
            let spring = Spring { length, rest: rest.0[i], factor: factor.0[i], inverse_masses };
            pull.0[i] = law(spring);
            pulls.set(i, span.at(i) * (pull.0[i] / length));
        }
        if !pull.is_any() {
            return;
        }
        let (mut pull_p, mut pull_q) = (pulls, pulls);
        if let Some(contacts) = &mut self.contacts {
            let ((along_p, load_p), (along_q, load_q)) = (divide(&pulls, &np), divide(&pulls, &nq));
            contacts.add(p, &load_p);
            contacts.add(q, &load_q.negated());
            (pull_p, pull_q) = (along_p, along_q);
        }
        for i in 0..LANES {
            dp.set(i, dp.at(i) + pull_p.at(i) * wp.0[i]);
            dq.set(i, dq.at(i) - pull_q.at(i) * wq.0[i]);
        }
        dp.store(&mut self.d, p);
        dq.store(&mut self.d, q);
    }
}

#[cfg(test)]
mod tests;
