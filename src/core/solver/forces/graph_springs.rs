//! Forces of springs and hinges, and damping, on the particles of a mesh. Each gathers those of its own
//! springs.

use bevy_math::Vec3;

use crate::solver::forces::graph_bending::{Coupled, Turned};
use crate::solver::forces::springs::pull;
use crate::solver::settings::DampingForm;
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::gather::{Places, gather, load, store};
use crate::solver::simd::isa::TransposingKernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{Band, cut_between_rows};
use crate::solver::simd::slots::{CutAt, SlotsOf};
use crate::solver::simd::soa::{Array, PartMut, Soa};
use crate::solver::simd::transpose::{Four, Transpose};
use crate::solver::topology::graph::adjacency::Table;

/// Least square of a spring's length \[m2\]: a collapsed one has no direction.
const LEAST_SQUARE: f32 = 1e-24;

/// Springs by particle, with their constants in use.
#[derive(Clone, Copy)]
pub(crate) struct Pulls<'a> {
    pub table: &'a Table,
    pub rest: &'a Array,
    pub constant: &'a Array,
}

/// Sets every acceleration to gravity plus what springs and hinges pull.
pub(crate) struct GatherForces<'a> {
    pub band: Band,
    /// Structural and shear springs, and flexion springs, where they have any constant.
    pub springs: [Option<Pulls<'a>>; 2],
    /// Hinges that are flat at rest, and those that are curved, where they have any rigidity.
    pub bent: Option<(Coupled<'a>, Turned<'a>)>,
    pub gravity: Vec3,
    pub places: &'a Places,
    pub a: PartMut<'a>,
}

cut_between_rows!(transposing GatherForces, a);

impl TransposingKernel for GatherForces<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self, t: impl Transpose) {
        let all = &self.places.x;
        for slot in self.band.slots().step_by(LANES) {
            let block = slot / LANES;
            let (here, w) = load(t, all, slot);
            let mut force = Block3::ZERO;
            for springs in self.springs.iter().flatten() {
                springs.add(t, block, &here, all, &mut force);
            }
            if let Some((flat, curved)) = &self.bent {
                flat.add(t, block, &here, all, &mut force);
                curved.add(t, block, &mut force);
            }
            let mut a = Block3::ZERO;
            for i in 0..LANES {
                let w = w.0[i];
                let g = if w > 0.0 { self.gravity } else { Vec3::ZERO };
                a.set(i, force.at(i) * w + g);
            }
            a.store(&mut self.a, slot);
        }
    }
}

impl Pulls<'_> {
    #[inline(always)]
    fn add(
        &self,
        t: impl Transpose,
        block: usize,
        here: &Block3,
        all: &[Four],
        force: &mut Block3,
    ) {
        let (from, to) = self.table.rows(block);
        for at in (from..to).step_by(LANES) {
            let (rest, constant) = (Block::load(self.rest, at), Block::load(self.constant, at));
            let there = gather(t, all, &self.table.to, at);
            for i in 0..LANES {
                let d = there.at(i) - here.at(i);
                force.set(i, force.at(i) + pull(d, rest.0[i], constant.0[i]));
            }
        }
    }
}

/// Works out the damping force `D` of displacements, as `AddDamping` does on a lattice.
pub(crate) struct GatherDamping<'a> {
    pub band: Band,
    pub springs: Damped<'a>,
    pub places: &'a Places,
    pub target: Target<'a>,
}

/// The springs that are damped.
#[derive(Clone, Copy)]
pub(crate) struct Damped<'a> {
    pub table: &'a Table,
    /// Force of an entry's spring for a displacement of one, times `unit` \[N s/m\].
    pub constant: &'a Array,
    /// 1 / the time that makes velocities of displacements \[1/s\].
    pub rate: f32,
    pub form: DampingForm,
}

/// Where the damping goes.
pub(crate) enum Target<'a> {
    /// Displacements half a substep on: `keep d + gain (a + D w)`.
    Predict {
        /// Part of them that still air leaves.
        keep: f32,
        /// Half a substep, times the time that makes velocities of displacements \[s2\].
        gain: f32,
        /// Accelerations without damping.
        a: &'a Soa,
        predicted: SlotsOf<'a, Four>,
    },
    /// Accelerations: `a + D w`, of predicted displacements.
    Accelerations { predicted: &'a [Four], a: PartMut<'a> },
}

impl CutAt for Target<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        match self {
            Self::Predict { keep, gain, a, predicted } => {
                let (predicted, below) = predicted.cut(slot);
                let below = Self::Predict { keep, gain, a, predicted: below };
                (Self::Predict { keep, gain, a, predicted }, below)
            }
            Self::Accelerations { predicted, a } => {
                let (a, below) = a.cut(slot);
                let below = Self::Accelerations { predicted, a: below };
                (Self::Accelerations { predicted, a }, below)
            }
        }
    }
}

cut_between_rows!(transposing GatherDamping, target);

impl TransposingKernel for GatherDamping<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, t: impl Transpose) {
        let Self { band, springs, places, target } = self;
        match target {
            Target::Predict { keep, gain, a, mut predicted } => {
                for slot in band.slots().step_by(LANES) {
                    let (force, d, w) = springs.force(t, slot, places, &places.d);
                    let a = Block3::load(a, slot);
                    let mut out = Block3::ZERO;
                    for i in 0..LANES {
                        let damped = a.at(i) + force.at(i) * w.0[i];
                        out.set(i, d.at(i) * keep + damped * gain);
                    }
                    store(t, predicted.from(slot), 0, out, Block::ZERO);
                }
            }
            Target::Accelerations { predicted, mut a } => {
                for slot in band.slots().step_by(LANES) {
                    let (force, _, w) = springs.force(t, slot, places, predicted);
                    let mut out = Block3::load(&a, slot);
                    for i in 0..LANES {
                        out.set(i, out.at(i) + force.at(i) * w.0[i]);
                    }
                    out.store(&mut a, slot);
                }
            }
        }
    }
}

impl Damped<'_> {
    /// The forces on a block of particles, their displacements and inverse masses.
    #[inline(always)]
    fn force(
        &self,
        t: impl Transpose,
        slot: usize,
        places: &Places,
        d: &[Four],
    ) -> (Block3, Block3, Block) {
        let (here, w) = load(t, &places.x, slot);
        let here_d = load(t, d, slot).0;
        let mut force = Block3::ZERO;
        let (from, to) = self.table.rows(slot / LANES);
        for at in (from..to).step_by(LANES) {
            let constant = Block::load(self.constant, at);
            let there_d = gather(t, d, &self.table.to, at);
            match self.form {
                DampingForm::Relative => {
                    for i in 0..LANES {
                        let relative = there_d.at(i) - here_d.at(i);
                        force.set(i, force.at(i) + relative * (constant.0[i] * self.rate));
                    }
                }
                DampingForm::Axial => {
                    let there = gather(t, &places.x, &self.table.to, at);
                    for i in 0..LANES {
                        let relative = there_d.at(i) - here_d.at(i);
                        let span = there.at(i) - here.at(i);
                        let square = larger(span.dot(span), LEAST_SQUARE);
                        let pull = constant.0[i] * self.rate * relative.dot(span) / square;
                        force.set(i, force.at(i) + span * pull);
                    }
                }
            }
        }
        (force, here_d, w)
    }
}
