//! Passes of the strain limit after contact, at the end of a worn cloth's tick (`stages/worn`): particles that they have moved into
//! colliders are moved out again.
//!
//! No more is undone than passes did: a particle that contact left deep in a collider, to come out by and by, stays as deep.

use bevy_math::Vec3;

use crate::solver::contact::collider::Motion;
use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::push_out::{ParticleContact, Tally};
use crate::solver::contact::response::FurthestWay;
use crate::solver::contact::{ContactSettings, ROUNDED_UP, ResolveContacts};
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{self, Band, cut_between_rows};
use crate::solver::simd::soa::{PartMut, Soa};

impl ResolveContacts<'_> {
    /// Begins a pass after contact, which sees particles where they are.
    pub fn begin_pass(&mut self) {
        if self.set.now.any {
            self.set.unpulled.copy_from(self.d);
            self.set.lost.fill(0.0);
            self.set.load.fill(0.0);
        }
    }

    /// Ends the pass: colliders are given what they bore of it.
    pub fn end_pass(&mut self, isa: Isa) {
        if self.set.now.any {
            let places = [&*self.x, &*self.d];
            self.set.give_taken(isa, self.inverse_mass, places, false, self.settings.step);
        }
    }

    /// Moves particles out of the colliders that they have gone into since contact displaced them by `from`. Bodies that yield are met
    /// again in the next substep.
    pub fn hold_out(&mut self, isa: Isa, from: &Soa) {
        let way = FurthestWay { band: self.bands.rows.clone(), d: self.d, from: Some(from) };
        let way = parallel::run(isa, way).0.sqrt();
        for k in 0..self.broad_phase.awake.len() {
            let awake = self.broad_phase.awake[k];
            let motion = self.motion(awake.collider);
            if motion.yields {
                continue;
            }
            let gone = self.broad_phase.gone + self.broad_phase.pushed + awake.gone;
            let held = HoldOut {
                band: self.bands.sums.clone(),
                motion: &motion,
                settings: self.settings,
                inverse_mass: self.inverse_mass,
                from,
                until: &self.broad_phase.until[awake.first..],
                gone: (gone + way) * ROUNDED_UP,
                x: self.x,
                d: self.d.part_mut(),
                pull: self.pull.as_deref_mut().map(Soa::part_mut),
            };
            let given = parallel::run(isa, held).given();
            if motion.measured {
                let step = self.settings.step;
                self.set.impulses.give_sum(awake.collider, given, Impulse::ZERO, step);
            }
        }
    }
}

/// Moves the particles of a band out of one collider.
struct HoldOut<'a> {
    band: Band,
    motion: &'a Motion<'a>,
    settings: ContactSettings,
    inverse_mass: &'a [f32],
    /// Displacements by contact \[m\].
    from: &'a Soa,
    /// The way at which a block may touch the collider, and the way that has been gone \[m\].
    until: &'a [f32],
    gone: f32,
    x: &'a Soa,
    d: PartMut<'a>,
    /// What is carried on; it takes no part in this.
    pull: Option<PartMut<'a>>,
}

impl Kernel for HoldOut<'_> {
    type Output = Tally;

    #[inline(always)]
    fn run(mut self) -> Tally {
        let Band { layout, rows, .. } = self.band.clone();
        let contact = ParticleContact { motion: self.motion, settings: self.settings };
        let mut tally = Tally::default();
        for row in rows {
            for block in 0..layout.blocks_across() {
                let slot = layout.slot(row, 0) + block * LANES;
                if self.until[slot / LANES] > self.gone {
                    continue;
                }
                let w = Block::load(self.inverse_mass, slot);
                let (x, mut d) = (Block3::load(self.x, slot), Block3::load(&self.d, slot));
                let near = contact.sample(&w, &x, &d, None);
                if near.least >= 0.0 {
                    continue;
                }
                let from = Block3::load(self.from, slot);
                let mut mended = Block3::ZERO;
                for i in 0..LANES {
                    let (n, depth) = (near.normals.at(i), near.depth.0[i]);
                    let into = larger(-n.dot(d.at(i) - from.at(i)), 0.0);
                    let by = n * if depth < into { depth } else { into };
                    d.set(i, d.at(i) + by);
                    mended.set(i, -by);
                }
                d.store(&mut self.d, slot);
                if let Some(pull) = &mut self.pull {
                    Block3::load(pull, slot).plus(&mended).store(pull, slot);
                }
                if self.motion.measured {
                    for i in 0..LANES {
                        // Where held, and beside the sheet, nothing is moved.
                        let mass = 1.0 / larger(w.0[i], f32::MIN_POSITIVE);
                        let arm = x.at(i) - self.motion.centre[0];
                        tally.give(i, arm, mended.at(i) * mass, Vec3::ZERO);
                    }
                }
            }
        }
        tally
    }
}

cut_between_rows!(HoldOut, d, pull);
