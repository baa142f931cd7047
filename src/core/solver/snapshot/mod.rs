//! All that a solver's later ticks depend on, besides rest shape, material and settings: taken out and put back, to the bit.
//!
//! Each structure is taken apart here field by field, so that one that is added cannot be forgotten: it does
//! not compile.

mod contacts;
mod layers;

use bevy_math::Vec3;

use crate::solver::ClothSolver;
use crate::solver::constraints::soft_pins::SoftPin;
use crate::solver::constraints::threads::shifts::{SheetShifts, Shifts};
use crate::solver::contact::ActiveSet;
use crate::solver::error::SolverError;
use crate::solver::forces::aerodynamics::Air;
use crate::solver::forces::external::Pushes;
use crate::solver::rest_detection::Mark;
use crate::solver::settings::is_near;
use crate::solver::simd::soa::Soa;
use crate::solver::snapshot::contacts::SavedContacts;
use crate::solver::snapshot::layers::SavedLayers;
use crate::solver::state::State;
use crate::solver::state::carrying::Carrying;
use crate::solver::state::striking::Striking;
use crate::solver::topology::Topology;

/// The state of a solver between two ticks: places, velocities, pins, and whatever else its later bits depend
/// on. See [`ClothSolver::save`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct SolverState {
    /// Rows and columns, where the rest shape has any.
    grid: Option<[u32; 2]>,
    /// See [`State`], whose arrays are by particle here.
    origin: Vec3,
    x: Vec<Vec3>,
    d: Vec<Vec3>,
    unit: f32,
    start: Vec<Vec3>,
    last_step: f32,
    response: f32,
    carrying: Carrying,
    striking: Striking,
    /// Pulls that are carried on, where any are.
    pull: Option<Vec<Vec3>>,
    /// Shifts of springs \[m\], where any are shifted.
    shifts: Vec<f32>,
    /// The active set of contact, where any particle lay on a collider.
    contacts: Option<SavedContacts>,
    /// The tick that was planned for \[s\].
    tick: f32,
    pins: Vec<u32>,
    /// Soft pins, and the force that each does not exceed \[N\].
    soft: Vec<(SoftPin, f32)>,
    air: Option<Air>,
    tethered_under: Option<Vec3>,
    mark_origin: Vec3,
    mark: Vec<Vec3>,
    /// Contact with itself, where the cloth collides with itself.
    layers: Option<SavedLayers>,
    /// Contact with other cloths, where the cloth collides with others.
    others: Option<SavedLayers>,
    /// Forces that wait for the next tick, and their strength \[N\].
    pushes: Option<(Vec<Vec3>, f32)>,
}

/// Why a state cannot be put back. Nothing has changed then.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StateError {
    /// The state is of a cloth with another number of particles.
    #[error("the state is of {got} particles, but the cloth has {expected}: it is another cloth's")]
    WrongParticleCount {
        /// Particles of the cloth.
        expected: usize,
        /// Particles of the state.
        got: usize,
    },
    /// The state is of a cloth with other rows and columns.
    #[error("the state is of a cloth of other rows and columns: it is another cloth's")]
    OtherGrid,
    /// Something in it is not finite, or contradicts the rest: no cloth was ever in that state.
    #[error("the state is damaged: its {0} cannot be")]
    Damaged(&'static str),
    /// The solver refuses what it is to hold or feel.
    #[error("the state is damaged: {0}")]
    Refused(#[from] SolverError),
}

impl SolverState {
    /// Particles of the cloth that it was taken from.
    pub fn particle_count(&self) -> usize {
        self.x.len()
    }

    /// Particles that are held, then those that are held softly; both ascending.
    pub fn held(&self) -> (&[u32], impl Iterator<Item = u32> + '_) {
        (&self.pins, self.soft.iter().map(|(pin, _)| pin.particle))
    }

    /// Checks it for a cloth.
    fn check(&self, topology: &Topology) -> Result<(), StateError> {
        let expected = topology.particle_count();
        if self.x.len() != expected {
            return Err(StateError::WrongParticleCount { expected, got: self.x.len() });
        }
        if self.grid != grid(topology) {
            return Err(StateError::OtherGrid);
        }
        let is_good = |vectors: &[Vec3]| {
            vectors.len() == expected && vectors.iter().all(|&vector| is_near(vector))
        };
        let good = |ok: bool, what| if ok { Ok(()) } else { Err(StateError::Damaged(what)) };
        good(is_near(self.origin) && is_near(self.mark_origin), "origin")?;
        good(is_good(&self.x) && is_good(&self.start), "positions")?;
        good(self.x.iter().all(|&x| is_near(self.origin + x)), "positions")?;
        good(is_good(&self.d), "displacements")?;
        good(self.pull.as_deref().is_none_or(is_good), "pulls")?;
        let shifts = match topology {
            _ if self.shifts.is_empty() => true,
            Topology::Lattice(lattice) => {
                SheetShifts::none(lattice.layout).can_be(lattice, &self.shifts)
            }
            Topology::Graph(graph) => Shifts::can_be(&graph.chains, &self.shifts),
        };
        good(shifts, "shifts")?;
        good(self.contacts.as_ref().is_none_or(|contacts| contacts.is_good(expected)), "contacts")?;
        good(is_good(&self.mark), "marked positions")?;
        let layers = [&self.layers, &self.others].into_iter().flatten();
        good(layers.into_iter().all(|layers| layers.is_good(expected)), "layers")?;
        good(self.unit > 0.0 && self.unit <= 1.0, "unit of time")?;
        good((0.0..=1.0).contains(&self.last_step), "last substep")?;
        good((0.0..=1.0).contains(&self.response), "response")?;
        good(self.carrying.is_good(), "mass that it carries")?;
        good(self.striking.is_good(), "bodies that strike it")?;
        good(self.tick > 0.0 && self.tick <= 1.0, "tick")?;
        good(self.pins.is_sorted_by(|a, b| a < b), "pins")?;
        good(self.soft.is_sorted_by(|(a, _), (b, _)| a.particle < b.particle), "soft pins")?;
        good(self.soft.iter().all(|&(_, most)| most >= 0.0), "soft pins")?;
        good(self.tethered_under.is_none_or(Vec3::is_finite), "load")?;
        let forces = self.pushes.as_ref();
        let is_force = |(forces, strength): &(Vec<Vec3>, f32)| {
            forces.len() == expected
                && forces.iter().all(|force| force.is_finite())
                && (0.0..f32::INFINITY).contains(strength)
        };
        good(forces.is_none_or(is_force), "forces")
    }
}

impl ClothSolver {
    /// Takes the state out, between two ticks. A solver of the same rest shape, material and settings that it
    /// is put back into goes on with the same bits, given the same input.
    pub fn save(&self) -> SolverState {
        let Self {
            // What the state is put back into has these.
            topology,
            pulling: _,
            bands: _,
            edges: _,
            self_contact,
            others_contact,
            shares: _,
            material: _,
            settings: _,
            isa: _,
            // These follow from what is kept of them.
            pins: held,
            soft,
            model,
            bound: _,
            steady: _,
            skin: _,
            plan,
            air,
            survey: _,
            surveyed_before: _,
            // These do not outlive a tick.
            workspace: _,
            done: _,
            tether_ease: _,
            braking: _,
            contact_count: _,
            touching_itself: _,
            touching_others: _,
            lockstep: _,
            drift: _,
            pushes,
            tethered_under,
            state,
            mark,
        } = self;
        let State {
            origin,
            x,
            d,
            pull,
            carries,
            unit,
            start,
            last_step,
            response,
            carrying,
            striking,
            contacts,
        } = state;
        let Mark { origin: mark_origin, x: mark } = mark;
        let by_particle = |soa: &Soa| by_particle(topology, soa);
        SolverState {
            grid: grid(topology),
            origin: *origin,
            x: by_particle(x),
            d: by_particle(d),
            unit: *unit,
            start: by_particle(start),
            last_step: *last_step,
            response: *response,
            carrying: *carrying,
            striking: *striking,
            pull: carries.then(|| by_particle(pull)),
            shifts: model.stages().shifts(),
            contacts: SavedContacts::of(topology, contacts),
            tick: plan.tick,
            pins: held.particles.clone(),
            soft: soft.iter().map(|spring| (spring.pin, spring.most_force)).collect(),
            air: air.as_ref().map(|surface| surface.air),
            tethered_under: *tethered_under,
            mark_origin: *mark_origin,
            mark: by_particle(mark),
            layers: self_contact.as_ref().map(|own| SavedLayers::of(topology, own.memory())),
            others: others_contact
                .as_ref()
                .map(|others| SavedLayers::of(topology, others.memory())),
            pushes: pushes.as_ref().filter(|pushes| pushes.strength > 0.0).map(|pushes| {
                let Pushes { forces, strength } = &**pushes;
                (by_particle(forces), *strength)
            }),
        }
    }

    /// Puts a state back.
    ///
    /// # Errors
    /// [`StateError`] for one that is another cloth's, or damaged; nothing has changed then.
    pub fn restore(&mut self, saved: &SolverState) -> Result<(), StateError> {
        saved.check(&self.topology)?;
        let mut next = self.clone();
        next.put_back(saved)?;
        *self = next;
        Ok(())
    }

    fn put_back(&mut self, saved: &SolverState) -> Result<(), SolverError> {
        let SolverState {
            grid: _,
            origin,
            x,
            d,
            unit,
            start,
            last_step,
            response,
            carrying,
            striking,
            pull,
            shifts,
            contacts,
            tick,
            pins,
            soft,
            air,
            tethered_under,
            mark_origin,
            mark,
            layers,
            others,
            pushes,
        } = saved;
        self.set_pins(pins)?;
        let springs: Vec<_> = soft.iter().map(|(pin, _)| *pin).collect();
        self.set_soft_pins(&springs)?;
        for &(SoftPin { particle, .. }, most_force) in soft {
            self.limit_soft_pin(particle, most_force);
        }
        self.set_air(*air)?;
        match (&mut self.self_contact, layers) {
            (Some(own), Some(layers)) => own.remember(self.isa, layers.memory(&self.topology)),
            _ => self.forget_pairs(),
        }
        if let (Some(own), Some(others)) = (&mut self.others_contact, others) {
            own.remember(&others.memory(&self.topology));
        }
        self.model.stages_mut().set_shifts(shifts);
        self.state.striking = *striking;
        self.plan_ticks(*tick);
        // After all that makes the tethers forget it.
        self.tether_under(*tethered_under);
        let topology = &self.topology;
        let by_slot = |vectors: &[Vec3]| by_slot(topology, vectors);
        self.state = State {
            origin: *origin,
            x: by_slot(x),
            d: by_slot(d),
            pull: by_slot(pull.as_deref().unwrap_or_default()),
            carries: pull.is_some(),
            unit: *unit,
            start: by_slot(start),
            last_step: *last_step,
            response: *response,
            carrying: *carrying,
            striking: *striking,
            contacts: ActiveSet::new(topology.layout().len()),
        };
        if let Some(contacts) = contacts {
            contacts.put_back(topology, &mut self.state.contacts);
        }
        self.mark = Mark { origin: *mark_origin, x: by_slot(mark) };
        self.pushes = pushes.as_ref().map(|(forces, strength)| {
            Box::new(Pushes { forces: by_slot(forces), strength: *strength })
        });
        self.scale_mass();
        self.survey_anew();
        Ok(())
    }
}

/// Rows and columns, where there are any.
fn grid(topology: &Topology) -> Option<[u32; 2]> {
    topology.as_lattice().map(|lattice| [lattice.rows() as u32, lattice.columns() as u32])
}

fn by_particle(topology: &Topology, soa: &Soa) -> Vec<Vec3> {
    (0..topology.particle_count()).map(|particle| soa.get(topology.slot(particle))).collect()
}

fn by_slot(topology: &Topology, vectors: &[Vec3]) -> Soa {
    let mut soa = Soa::zeros(topology.layout().len());
    for (particle, &vector) in vectors.iter().enumerate() {
        soa.set(topology.slot(particle), vector);
    }
    soa
}
