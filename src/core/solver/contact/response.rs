//! A band of particles meets one collider.

use crate::solver::contact::ContactSettings;
use crate::solver::contact::collider::Motion;
use crate::solver::contact::edges::NearbyMut;
use crate::solver::contact::found::Found;
use crate::solver::contact::hold::{Held, Hold};
use crate::solver::contact::push_out::{ParticleContact, Tally};
use crate::solver::contact::swept::Sweep;
use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, Blocks3Mut, larger};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{Band, Cut, Largest, Merge, cut_between_rows};
use crate::solver::simd::slots::{ByBlock, CutAt};
use crate::solver::simd::soa::{PartMut, Soa};

/// The square of how far any particle goes in a substep \[m2\], all the way or since it was displaced by `from`.
pub(in crate::solver) struct FurthestWay<'a> {
    pub band: Band,
    pub d: &'a Soa,
    pub from: Option<&'a Soa>,
}

impl Kernel for FurthestWay<'_> {
    type Output = Largest;

    #[inline(always)]
    fn run(self) -> Largest {
        let Band { layout, rows, .. } = self.band;
        let mut most = Block::ZERO;
        let blocks = layout.blocks_across();
        for row in rows {
            let first = layout.slot(row, 0);
            let d = Blocks3::new(self.d, first, blocks);
            for block in 0..blocks {
                let mut d = d.at(block);
                if let Some(from) = self.from {
                    let from = Block3::load(from, first + block * LANES);
                    for i in 0..LANES {
                        d.set(i, d.at(i) - from.at(i));
                    }
                }
                for i in 0..LANES {
                    most.0[i] = larger(d.at(i).dot(d.at(i)), most.0[i]);
                }
            }
        }
        Largest(most.largest())
    }
}

cut_between_rows!(FurthestWay);

/// Holds the particles of a band out of one collider.
pub(super) struct MeetCollider<'a> {
    pub band: Band,
    pub motion: &'a Motion<'a>,
    pub settings: ContactSettings,
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
    /// Particles that lie on a collider now.
    pub found: Found<'a>,
}

/// The outcome of a band.
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

impl Kernel for MeetCollider<'_> {
    type Output = Met;

    #[inline(always)]
    fn run(mut self) -> Met {
        let Band { layout, rows, .. } = self.band.clone();
        let (motion, settings, gone) = (self.motion, self.settings, self.gone);
        let meeting = ParticleContact { motion, settings };
        let sweep = Sweep { motion, epsilon: settings.epsilon };
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
                let mut stopped = Block3::ZERO;
                if self.is_fast {
                    self.held.free(first + block * LANES, &mut d, sweep.slow());
                    ds.set(block, d);
                    // Of copies: what a call is shown has to be in memory, and would stay there.
                    let (mut swept, tally) = (d, &mut met.tally);
                    if sweep.block(&{ w }, &{ x }, &mut swept, tally) {
                        met.struck = true;
                        ds.set(block, swept);
                        for i in 0..LANES {
                            stopped.set(i, swept.at(i) - d.at(i));
                        }
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
                let (starts, before) = (x, d);
                let tally = &mut met.tally;
                let pushed = meeting.push_out(&near, &w, &mut x, &mut d, &hold, tally);
                xs.set(block, x);
                ds.set(block, d);
                if let Some(pulls) = &mut pulls {
                    let noted = pulls.at(block);
                    pulls.set(block, near.kept(&noted, &before, &d, &pushed, &hold, &settings));
                    if motion.measured {
                        let arms = arms(&starts, motion);
                        near.forget(&noted, &before, (&w, &arms), &pushed, &hold, &settings, tally);
                    }
                }
                if held.is_some() {
                    self.held.let_go(slot, &near.depth);
                }
                let collider = self.collider;
                self.found.take(slot, &near, &pushed, &stopped, &hold, motion, collider, &settings);
            }
        }
        met
    }
}

/// How far a block's particles are from the collider's centre, as the substep begins.
#[inline(always)]
fn arms(x: &Block3, motion: &Motion<'_>) -> Block3 {
    let mut arms = Block3::ZERO;
    for i in 0..LANES {
        arms.set(i, x.at(i) - motion.centre[0]);
    }
    arms
}

impl Cut for MeetCollider<'_> {
    type Output = Met;

    fn middle(&self) -> Option<usize> {
        self.band.middle()
    }

    fn is_shared(&self) -> bool {
        self.band.shared
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
