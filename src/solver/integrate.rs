//! Verlet integration in its leapfrog form: `v += a h; x += v h`, with v at the middle of a substep,
//! kept as the displacement `d = v h`.
//!
//! The same method as `x' = 2x - x_prev + a h^2` (Verlet 1967), which in f32 loses the step in its
//! rounding once substeps are many.

use bevy::math::{Vec3, ops};

use super::bands::{Band, cut_between_rows};
use super::carry::Carry;
use super::isa::Kernel;
use super::lanes::{Block, Block3, LANES, PartMut, Soa};
use super::lattice::Layout;

/// Where the accelerations of a substep come from.
#[derive(Clone, Copy)]
pub(super) enum Acceleration<'a> {
    /// The same for every particle that is not held \[m/s2\].
    Uniform(Vec3),
    /// A particle's own \[m/s2\].
    Each(&'a Soa),
}

/// Sets the displacements of a substep, for every particle that is not held.
pub(super) struct Integrate<'a> {
    pub band: Band,
    pub acceleration: Acceleration<'a>,
    /// Part of the last displacement that goes on.
    pub keep: f32,
    /// Displacement that an acceleration of one adds \[s2\].
    pub gain: f32,
    /// Displacement that no particle exceeds \[m\].
    pub longest: f32,
    pub inverse_mass: &'a [f32],
    pub d: PartMut<'a>,
    pub carry: Carry<'a>,
}

/// What still air and acceleration do to a velocity over a time: `v' = decay v + gain a`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kick {
    pub decay: f32,
    /// \[s\]
    pub gain: f32,
}

impl Kick {
    /// The exact solution of `v' = a - drag v` over `time` \[s\].
    pub fn new(drag: f32, time: f32) -> Self {
        let lost = drag * time;
        if lost < 1e-4 {
            // The quotient below would cancel; its series is exact to rounding here.
            let gain = time * (1.0 - 0.5 * lost);
            return Self { decay: 1.0 - lost * (1.0 - 0.5 * lost), gain };
        }
        let decay = ops::exp(-lost);
        Self { decay, gain: (1.0 - decay) / drag }
    }
}

impl Kernel for Integrate<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Band { layout, rows, .. } = self.band.clone();
        for row in rows {
            for column in (0..layout.columns).step_by(LANES) {
                let slot = layout.slot(row, column);
                let carried = self.carried(slot);
                match self.acceleration {
                    Acceleration::Uniform(a) => {
                        let gained = a * self.gain;
                        self.advance(slot, &carried, |_| gained);
                    }
                    Acceleration::Each(a) => {
                        let (a, gain) = (Block3::load(a, slot), self.gain);
                        self.advance(slot, &carried, |i| a.at(i) * gain);
                    }
                }
            }
        }
    }
}

cut_between_rows!(Integrate, d, carry);

impl Integrate<'_> {
    /// What goes on of the last substep's pulls.
    #[inline(always)]
    fn carried(&self, slot: usize) -> Block3 {
        let mut carried = Block3::ZERO;
        if let Carry::GoOn(pull, part) = &self.carry {
            let pull = Block3::load(pull, slot);
            for i in 0..LANES {
                carried.set(i, pull.at(i) * *part);
            }
        }
        carried
    }

    #[inline(always)]
    fn advance(&mut self, slot: usize, carried: &Block3, gained: impl Fn(usize) -> Vec3) {
        let longest = self.longest * self.longest;
        let w = Block::load(self.inverse_mass, slot);
        let mut d = Block3::load(&self.d, slot);
        for i in 0..LANES {
            let new = d.at(i) * self.keep + gained(i) + carried.at(i);
            let square = new.dot(new);
            let scale = if square > longest { (longest / square).sqrt() } else { 1.0 };
            let scale = if w.0[i] > 0.0 { scale } else { 0.0 };
            d.set(i, new * scale);
        }
        d.store(&mut self.d, slot);
        if let Carry::Begin(pull) | Carry::GoOn(pull, _) = &mut self.carry {
            let mut before = Block3::ZERO;
            for i in 0..LANES {
                before.set(i, carried.at(i) - d.at(i));
            }
            before.store(pull, slot);
        }
    }
}

/// Ends a substep: adds the displacements to the positions.
pub(super) struct Displace<'a> {
    pub band: Band,
    pub x: PartMut<'a>,
    pub d: &'a Soa,
    /// Pulls that have been noted from before the corrections on.
    pub pull: Option<PartMut<'a>>,
}

impl Kernel for Displace<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Band { layout, rows, .. } = self.band;
        for row in rows {
            for column in (0..layout.columns).step_by(LANES) {
                let slot = layout.slot(row, column);
                Block3::load_sum(&self.x, self.d, slot).store(&mut self.x, slot);
                if let Some(pull) = &mut self.pull {
                    Block3::load_sum(pull, self.d, slot).store(pull, slot);
                }
            }
        }
    }
}

cut_between_rows!(Displace, x, pull);

/// Adds a part of one vector of each free particle to another.
pub(super) struct Add<'a> {
    pub layout: Layout,
    pub part: f32,
    pub inverse_mass: &'a [f32],
    pub from: &'a Soa,
    pub to: &'a mut Soa,
}

impl Kernel for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for row in 0..self.layout.rows {
            for column in (0..self.layout.columns).step_by(LANES) {
                let slot = self.layout.slot(row, column);
                let w = Block::load(self.inverse_mass, slot);
                let (from, mut to) = (Block3::load(self.from, slot), Block3::load(self.to, slot));
                for i in 0..LANES {
                    let part = if w.0[i] > 0.0 { self.part } else { 0.0 };
                    to.set(i, to.at(i) + from.at(i) * part);
                }
                to.store(self.to, slot);
            }
        }
    }
}
