//! Forces of springs and hinges, and damping, on the particles of a mesh. Each gathers those of its own
//! springs.

use bevy::math::Vec3;

use super::hinges::Bent;
use super::places::{Place, gather_positions, gather_soa};
use super::table::Table;
use crate::solver::forces::{DampingTarget, pull};
use crate::solver::isa::Kernel;
use crate::solver::lanes::{Array, Block, Block3, LANES, Soa, larger};
use crate::solver::parameters::DampingForm;

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
    /// Structural and shear springs, and flexion springs, where they have any constant.
    pub springs: [Option<Pulls<'a>>; 2],
    pub bent: Option<Bent<'a>>,
    pub gravity: Vec3,
    pub places: &'a [Place],
    pub a: &'a mut Soa,
}

impl Kernel for GatherForces<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (block, places) in self.places.chunks_exact(LANES).enumerate() {
            let mut force = Block3::ZERO;
            for springs in self.springs.iter().flatten() {
                springs.add(block, places, self.places, &mut force);
            }
            if let Some(bent) = &self.bent {
                bent.add(block, &mut force);
            }
            let mut a = Block3::ZERO;
            for (i, place) in places.iter().enumerate() {
                let w = place.inverse_mass();
                let g = if w > 0.0 { self.gravity } else { Vec3::ZERO };
                a.set(i, force.at(i) * w + g);
            }
            a.store(self.a, block * LANES);
        }
    }
}

impl Pulls<'_> {
    #[inline(always)]
    fn add(&self, block: usize, here: &[Place], all: &[Place], force: &mut Block3) {
        let (from, to) = self.table.rows(block);
        let here = positions(here);
        for at in (from..to).step_by(LANES) {
            let (rest, constant) = (Block::load(self.rest, at), Block::load(self.constant, at));
            let there = gather_positions(all, &self.table.to, at);
            for i in 0..LANES {
                let d = there.at(i) - here.at(i);
                force.set(i, force.at(i) + pull(d, rest.0[i], constant.0[i]));
            }
        }
    }
}

#[inline(always)]
fn positions(places: &[Place]) -> Block3 {
    let mut out = Block3::ZERO;
    for (i, place) in places.iter().enumerate() {
        let [x, y, z, _] = place.x;
        out.set(i, Vec3::new(x, y, z));
    }
    out
}

/// Works out the damping force `D`, as `AddDamping` does on a lattice.
pub(crate) struct GatherDamping<'a> {
    pub springs: Damped<'a>,
    pub d: &'a Soa,
    pub target: DampingTarget<'a>,
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
    pub places: &'a [Place],
}

impl Kernel for GatherDamping<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        for (block, places) in self.springs.places.chunks_exact(LANES).enumerate() {
            let slot = block * LANES;
            let d = Block3::load(self.d, slot);
            let force = self.springs.force(block, &positions(places), self.d, &d);
            let mut out = Block3::ZERO;
            match &mut self.target {
                DampingTarget::Predict { gain, a, predicted } => {
                    let a = Block3::load(a, slot);
                    for (i, place) in places.iter().enumerate() {
                        let damped = a.at(i) + force.at(i) * place.inverse_mass();
                        out.set(i, d.at(i) + damped * *gain);
                    }
                    out.store(predicted, slot);
                }
                DampingTarget::Accelerations(to) => {
                    let a = Block3::load(to, slot);
                    for (i, place) in places.iter().enumerate() {
                        out.set(i, a.at(i) + force.at(i) * place.inverse_mass());
                    }
                    out.store(to, slot);
                }
            }
        }
    }
}

impl Damped<'_> {
    #[inline(always)]
    fn force(&self, block: usize, here: &Block3, d: &Soa, here_d: &Block3) -> Block3 {
        let mut force = Block3::ZERO;
        let (from, to) = self.table.rows(block);
        for at in (from..to).step_by(LANES) {
            let constant = Block::load(self.constant, at);
            let there_d = gather_soa(d, &self.table.to, at);
            match self.form {
                DampingForm::Relative => {
                    for i in 0..LANES {
                        let relative = there_d.at(i) - here_d.at(i);
                        force.set(i, force.at(i) + relative * (constant.0[i] * self.rate));
                    }
                }
                DampingForm::Axial => {
                    let there = gather_positions(self.places, &self.table.to, at);
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
        force
    }
}
