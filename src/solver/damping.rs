//! Damping of a lattice's springs.

use super::bands::{Band, CutAt, Rooms, cut_between_rows};
use super::forces::LEAST_LENGTH;
use super::isa::Kernel;
use super::lanes::{Block, Block3, LANES, PartMut, Soa, larger};
use super::lattice::Lattice;
use super::parameters::DampingForm;
use super::rows::{SpringForce, SpringRows, Springs};

/// Works out the damping force `D`, `F_i = C (v_j - v_i)` for each spring or its part along the spring,
/// of velocities given as displacements.
pub(super) struct AddDamping<'a> {
    pub band: Band,
    pub springs: DampedSprings<'a>,
    pub d: &'a Soa,
    pub rows: &'a Rooms<SpringRows>,
    pub target: DampingTarget<'a>,
}

/// The springs that are damped.
#[derive(Clone, Copy)]
pub(super) struct DampedSprings<'a> {
    pub lattice: &'a Lattice,
    /// Force of a spring of shape factor one for a displacement of one \[N/m\].
    pub damping: f32,
    pub form: DampingForm,
    /// Whether shear springs are damped.
    pub shear: bool,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
}

/// Where the damping goes.
pub(super) enum DampingTarget<'a> {
    /// Displacements half a substep on: `keep d + gain (a + D w)`.
    Predict {
        /// Part of them that still air leaves.
        keep: f32,
        /// Half a substep, times the time that makes velocities of displacements \[s2\].
        gain: f32,
        /// Accelerations without damping.
        a: &'a Soa,
        /// The predicted displacements.
        predicted: PartMut<'a>,
    },
    /// Accelerations: `a + D w`.
    Accelerations(PartMut<'a>),
}

impl Kernel for AddDamping<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Band { layout, rows, .. } = self.band.clone();
        let springs = self.springs;
        let mut room = self.rows.take();
        springs.begin(&mut room, rows.start, self.d);
        for row in rows {
            for column in (0..layout.columns).step_by(LANES) {
                let slot = layout.slot(row, column);
                let w = Block::load(self.springs.inverse_mass, slot);
                let d = Block3::load(self.d, slot);
                let force = springs.force(&mut room, row, column, self.d);
                let mut out = Block3::ZERO;
                match &mut self.target {
                    DampingTarget::Predict { keep, gain, a, predicted } => {
                        let a = Block3::load(*a, slot);
                        for i in 0..LANES {
                            let damped = a.at(i) + force.at(i) * w.0[i];
                            out.set(i, d.at(i) * *keep + damped * *gain);
                        }
                        out.store(predicted, slot);
                    }
                    DampingTarget::Accelerations(to) => {
                        let a = Block3::load(to, slot);
                        for i in 0..LANES {
                            out.set(i, a.at(i) + force.at(i) * w.0[i]);
                        }
                        out.store(to, slot);
                    }
                }
            }
        }
    }
}

cut_between_rows!(AddDamping, target);

impl CutAt for DampingTarget<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        match self {
            Self::Predict { keep, gain, a, predicted } => {
                let (predicted, below) = predicted.cut(slot);
                let below = Self::Predict { keep, gain, a, predicted: below };
                (Self::Predict { keep, gain, a, predicted }, below)
            }
            Self::Accelerations(a) => {
                let (a, below) = a.cut(slot);
                (Self::Accelerations(a), Self::Accelerations(below))
            }
        }
    }
}

impl DampedSprings<'_> {
    /// Damping of a block, of displacements `d`.
    #[inline(always)]
    fn force(&self, rows: &mut SpringRows, row: usize, column: usize, d: &Soa) -> Block3 {
        match self.form {
            DampingForm::Relative => rows.gather(&self.springs(), row, column, &Relative { d }),
            DampingForm::Axial => {
                rows.gather(&self.springs(), row, column, &Axial { x: self.x, d })
            }
        }
    }

    /// Begins with a row.
    #[inline(always)]
    fn begin(&self, rows: &mut SpringRows, row: usize, d: &Soa) {
        match self.form {
            DampingForm::Relative => rows.begin(&self.springs(), row, &Relative { d }),
            DampingForm::Axial => rows.begin(&self.springs(), row, &Axial { x: self.x, d }),
        }
    }

    #[inline(always)]
    fn springs(&self) -> Springs<'_> {
        let shear = if self.shear { self.damping } else { 0.0 };
        Springs { lattice: self.lattice, thread: self.damping, shear }
    }
}

/// All of the relative velocity of a spring's ends.
struct Relative<'a> {
    d: &'a Soa,
}

impl SpringForce for Relative<'_> {
    #[inline(always)]
    fn force(&self, here: usize, there: usize, _: Block, constant: Block) -> Block3 {
        let (a, b) = (Block3::load(self.d, here), Block3::load(self.d, there));
        let mut force = Block3::ZERO;
        for i in 0..LANES {
            force.set(i, (b.at(i) - a.at(i)) * constant.0[i]);
        }
        force
    }
}

/// The part of it along the spring.
struct Axial<'a> {
    x: &'a Soa,
    d: &'a Soa,
}

impl SpringForce for Axial<'_> {
    #[inline(always)]
    fn force(&self, here: usize, there: usize, _: Block, constant: Block) -> Block3 {
        let (a, b) = (Block3::load(self.x, here), Block3::load(self.x, there));
        let (from, to) = (Block3::load(self.d, here), Block3::load(self.d, there));
        let mut force = Block3::ZERO;
        for i in 0..LANES {
            let span = b.at(i) - a.at(i);
            let relative = to.at(i) - from.at(i);
            let square = larger(span.dot(span), LEAST_LENGTH * LEAST_LENGTH);
            force.set(i, span * (constant.0[i] * relative.dot(span) / square));
        }
        force
    }
}
