//! Making a solver, and changing what its cloth is made of.

use std::sync::Arc;

use bevy_math::Vec3;

use crate::solver::ClothSolver;
use crate::solver::cloth_contact::{
    FacesAt, InterCollision, OthersContact, SelfCollision, SelfContact,
};
use crate::solver::constraints::pins::Pins;
use crate::solver::constraints::skin::{Skin, SkinLimit};
use crate::solver::constraints::threads::geometric_stiffness::steady;
use crate::solver::contact::Edges;
use crate::solver::error::SolverError;
use crate::solver::forces::aerodynamics::{Air, Surface};
use crate::solver::model::Model;
use crate::solver::plan::{Plan, PlannedCloth};
use crate::solver::rest_detection::Mark;
use crate::solver::settings::{Material, ParameterError, Settings, Substeps, is_near};
use crate::solver::simd::isa::Isa;
use crate::solver::simd::parallel::Bands;
use crate::solver::state::measure::Survey;
use crate::solver::state::{State, Workspace};
use crate::solver::topology::Topology;

/// The tick that a solver plans for until it is given one \[s\].
const USUAL_TICK: f32 = 1.0 / 64.0;

impl ClothSolver {
    /// A cloth at rest at the given start positions in world space \[m\], one a particle, nothing pinned.
    ///
    /// # Errors
    /// [`SolverError`] for positions, a material or settings that cannot be used.
    pub fn new(
        topology: impl Into<Topology>,
        positions: &[Vec3],
        material: Material,
        settings: Settings,
    ) -> Result<Self, SolverError> {
        let topology = topology.into();
        material.validate()?;
        check_settings(&topology, &settings)?;
        if positions.len() != topology.particle_count() {
            return Err(SolverError::WrongPositionCount {
                expected: topology.particle_count(),
                got: positions.len(),
            });
        }
        if let Some(particle) = positions.iter().position(|&p| !is_near(p)) {
            return Err(SolverError::NonFinite { what: "position", particle });
        }
        let mut pins = Pins::new(&topology, Vec::new());
        pins.set_density(&topology, material.area_density);
        let model = Model::new(&topology);
        let bound = model.stages().bound(&pins.inverse_mass);
        let state = State::new(&topology, positions);
        let edges = Edges::new(&topology);
        let mut solver = Self {
            plan: {
                let cloth = PlannedCloth { hung: pins.hung, layers: 0, bodies: 0, at_least: 0 };
                Plan::new(&bound, &material, &settings, cloth, USUAL_TICK)
            },
            workspace: Workspace::new(topology.layout(), settings.edges.then_some(&edges)),
            isa: Isa::detect(),
            bands: Bands::new(topology.layout(), false),
            shares: true,
            tethered_under: None,
            tether_ease: 1.0,
            braking: 0.0,
            edges,
            self_contact: None,
            touching_itself: 0,
            others_contact: None,
            touching_others: 0,
            lockstep: 0,
            drift: Vec3::ZERO,
            steady: steady(topology.structural_springs().map(|(_, _, rest)| rest)),
            air: None,
            done: 0,
            contact_count: 0,
            survey: Survey::default(),
            surveyed_before: false,
            mark: Mark::new(topology.layout()),
            soft: Vec::new(),
            pulling: Vec::new(),
            skin: None,
            pushes: None,
            topology,
            model,
            material,
            settings,
            pins,
            bound,
            state,
        };
        solver.replan();
        solver.survey = solver.take_survey();
        Ok(solver)
    }

    /// The same cloth, in the same place and motion, pinned alike and in the same air, over a rest shape
    /// of the same particles, joined alike, whose masses, stiffness or size are others. It does not collide with itself or others where
    /// a distance that was asked for is larger than the new size allows.
    ///
    /// # Errors
    /// [`SolverError::OtherParticles`], and as [`ClothSolver::new`].
    pub fn remade(&self, topology: Topology, settings: Settings) -> Result<Self, SolverError> {
        let count = |topology: &Topology| topology.particle_count();
        if count(&topology) != count(&self.topology) || topology.layout() != self.topology.layout()
        {
            return Err(SolverError::OtherParticles);
        }
        let positions: Vec<_> = (0..topology.particle_count()).map(|i| self.position(i)).collect();
        let mut solver = Self::new(topology, &positions, self.material, settings)?;
        solver.isa = self.isa;
        solver.shares = self.shares;
        // Particles lie in memory as they did. To the bit: far from the world's origin, positions in
        // the world would be rounded.
        solver.state = self.state.clone();
        solver.mark = self.mark.clone();
        let graphs = [&solver.topology, &self.topology].map(Topology::as_graph);
        let [own, others] = graphs.map(|graph| graph.map(|graph| graph.chain_slots()));
        if own == others {
            solver.model.stages_mut().set_shifts(&self.model.stages().shifts());
        }
        solver.set_pins(self.pins())?;
        let soft: Vec<_> = self.soft_pins().copied().collect();
        solver.set_soft_pins(&soft)?;
        solver.limit_soft_pins_as(self);
        solver.set_skin(self.skin())?;
        solver.set_air(self.air().copied())?;
        let _ = solver.set_self_collision(self.self_collision());
        let _ = solver.set_inter_collision(self.inter_collision());
        solver.plan_ticks(self.plan.tick);
        solver.scale_mass();
        solver.survey_anew();
        Ok(solver)
    }

    /// Changes the material.
    ///
    /// # Errors
    /// [`SolverError::Parameter`]; the old material then stays.
    pub fn set_material(&mut self, material: Material) -> Result<(), SolverError> {
        material.validate()?;
        self.material = material;
        self.replan();
        Ok(())
    }

    /// Puts the cloth into air, or into none. Air takes the place of the material's linear drag.
    ///
    /// # Errors
    /// [`ParameterError`]; the old air then stays.
    pub fn set_air(&mut self, air: Option<Air>) -> Result<(), ParameterError> {
        if let Some(air) = &air {
            air.validate()?;
        }
        match (&mut self.air, air) {
            (Some(surface), Some(air)) => surface.air = air,
            (surface, air) => *surface = air.map(|air| Surface::new(air, &self.topology)),
        }
        // Air loads the tethers.
        self.tethered_under = None;
        Ok(())
    }

    /// Holds particles near places that each tick is given ([`StepInput::skin`](crate::solver::StepInput::skin)), as clothes are held
    /// near a skinned body: limits, one a particle; or lets them go. Pinned particles are held by their pins alone.
    ///
    /// # Errors
    /// [`SolverError::WrongSkinCount`], [`SolverError::SkinLimit`]; what was in force then stays.
    pub fn set_skin(&mut self, limits: Option<&[SkinLimit]>) -> Result<(), SolverError> {
        let Some(limits) = limits else {
            self.skin = None;
            return Ok(());
        };
        let (particles, motions) = (self.topology.particle_count(), limits.len());
        if particles != motions {
            return Err(SolverError::WrongSkinCount { particles, motions });
        }
        for (particle, limit) in limits.iter().enumerate() {
            limit.validate().map_err(|problem| SolverError::SkinLimit { particle, problem })?;
        }
        self.skin = Some(Box::new(Skin::new(&self.topology, limits)));
        Ok(())
    }

    /// What holds particles near their places on the skin, one a particle; `None` where nothing does.
    pub fn skin(&self) -> Option<&[SkinLimit]> {
        self.skin.as_ref().map(|skin| &*skin.limits)
    }

    /// The air around the cloth, `None` where it feels none.
    pub fn air(&self) -> Option<&Air> {
        self.air.as_ref().map(|surface| &surface.air)
    }

    /// Lets the cloth collide with itself, or not. The plan then has the substeps that layers need, where it is automatic.
    ///
    /// # Errors
    /// [`SolverError::Parameter`]; what was in force then stays.
    pub fn set_self_collision(&mut self, asked: Option<SelfCollision>) -> Result<(), SolverError> {
        if asked == self.self_collision() {
            return Ok(());
        }
        if let Some(asked) = &asked {
            asked.validate(&self.topology)?;
        }
        let faces = asked.map(|_| self.faces());
        self.self_contact = asked
            .zip(faces)
            .map(|(asked, faces)| Box::new(SelfContact::new(&self.topology, faces, asked)));
        self.touching_itself = 0;
        self.plan_ticks(self.plan.tick);
        Ok(())
    }

    /// How the cloth collides with itself, `None` where it does not.
    pub fn self_collision(&self) -> Option<SelfCollision> {
        self.self_contact.as_ref().map(|own| own.settings)
    }

    /// Lets the cloth collide with others that collide with it, or not. They do where they are stepped together, see
    /// [`Island`](crate::solver::Island).
    ///
    /// # Errors
    /// [`SolverError::Parameter`]; what was in force then stays.
    pub fn set_inter_collision(
        &mut self,
        asked: Option<InterCollision>,
    ) -> Result<(), SolverError> {
        if asked == self.inter_collision() {
            return Ok(());
        }
        if let Some(asked) = &asked {
            asked.validate(&self.topology)?;
        }
        let faces = asked.map(|_| self.faces());
        self.others_contact = asked
            .zip(faces)
            .map(|(asked, faces)| Box::new(OthersContact::new(&self.topology, faces, asked)));
        self.touching_others = 0;
        Ok(())
    }

    /// How the cloth collides with others, `None` where it does not.
    pub fn inter_collision(&self) -> Option<InterCollision> {
        self.others_contact.as_ref().map(|others| others.settings)
    }

    /// The faces at its particles, which contact with itself and with others share.
    fn faces(&self) -> Arc<FacesAt> {
        let own = self.self_contact.as_ref().map(|own| own.faces());
        own.or_else(|| self.others_contact.as_ref().map(|others| others.faces()))
            .unwrap_or_else(|| Arc::new(FacesAt::new(&self.topology)))
    }

    /// Changes the settings.
    ///
    /// # Errors
    /// [`SolverError::Parameter`] or [`SolverError::OtherLumping`]; the old settings then stay.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), SolverError> {
        check_settings(&self.topology, &settings)?;
        self.settings = settings;
        self.replan();
        Ok(())
    }

    /// Holds these particles and no others, in any order. A particle that was held and is no more goes on with
    /// the velocity it had.
    ///
    /// # Errors
    /// [`SolverError::NoSuchParticle`]; the old pins then stay.
    pub fn set_pins(&mut self, particles: &[u32]) -> Result<(), SolverError> {
        let count = self.topology.particle_count();
        if let Some(&out) = particles.iter().find(|&&p| p as usize >= count) {
            return Err(SolverError::NoSuchParticle { particle: out as usize, count });
        }
        let mut sorted = particles.to_vec();
        sorted.sort_unstable();
        sorted.dedup();
        if sorted != self.pins.particles {
            self.pins = Pins::new(&self.topology, sorted);
            let held = self.pins.mask(self.topology.layout());
            self.model.stages_mut().hold(&held);
            self.stop_filtering();
            self.replan();
        }
        Ok(())
    }

    /// The held particles, ascending.
    pub fn pins(&self) -> &[u32] {
        &self.pins.particles
    }

    /// Forces an instruction set: same bits, other speed. The widest is taken by default.
    pub fn set_isa(&mut self, isa: Isa) {
        self.isa = isa;
    }

    /// Says whether all threads of rayon's pool share the work on a large cloth, as they do by default: same
    /// bits, other speed.
    pub fn set_shared(&mut self, shares: bool) {
        self.shares = shares;
    }

    /// In how many bands of rows the last tick was shared out; 1 where it was taken in one piece.
    pub fn band_count(&self) -> usize {
        self.bands.rows.count()
    }

    /// Whether this is a large cloth that is to be shared.
    pub(crate) fn is_to_share(&self) -> bool {
        self.shares
            && Bands::pays(
                self.topology.layout(),
                self.plan.stretching,
                self.topology.as_lattice().is_some(),
            )
    }

    /// Cuts it where there is more than one thread to share it.
    pub(crate) fn share_out(&mut self) {
        let shared = self.is_to_share() && rayon::current_num_threads() > 1;
        self.bands = Bands::new(self.topology.layout(), shared);
    }

    /// Works out again what follows from rest shape, pins, material and settings.
    fn replan(&mut self) {
        self.pins.set_density(&self.topology, self.material.area_density);
        let model = self.model.stages_mut();
        self.bound = model.bound(&self.pins.inverse_mass);
        model.bend(self.settings.bending, self.material.bending_friction > 0.0);
        self.make_room_for_study();
        self.plan_ticks(self.plan.tick);
        self.tethered_under = None;
        self.scale_mass();
    }

    /// Sets the tethers' bounds for a load \[m/s2\], or leaves that to the next tick.
    pub(crate) fn tether_under(&mut self, load: Option<Vec3>) {
        if let Some(load) = load {
            for set in &mut self.pins.tethers {
                set.set_limits(&self.topology, &self.material, load);
            }
        }
        self.tethered_under = load;
    }

    /// Makes the plan for ticks of another length \[s\].
    pub(crate) fn plan_ticks(&mut self, tick: f32) {
        let cloth = self.planned_cloth();
        self.plan = Plan::new(&self.bound, &self.material, &self.settings, cloth, tick);
        self.model.stages_mut().follow(&self.plan, &self.bound);
    }

    /// What a plan is to be made for.
    pub(crate) fn planned_cloth(&self) -> PlannedCloth {
        let own = self.self_contact.as_ref().map_or(0, |own| own.substeps());
        let others = self.others_contact.as_ref().map_or(0, |others| others.substeps());
        let layers = own.max(others);
        let asked = self.state.striking.substeps;
        let bodies = match self.settings.substeps {
            Substeps::Automatic { budget } if asked > budget.max(layers) => asked,
            Substeps::Automatic { .. } | Substeps::Fixed(_) => 0,
        };
        PlannedCloth { hung: self.pins.hung, layers, bodies, at_least: self.lockstep }
    }
}

fn check_settings(topology: &Topology, settings: &Settings) -> Result<(), SolverError> {
    settings.validate()?;
    let made = topology.lumping();
    if settings.lumping != made {
        return Err(SolverError::OtherLumping { made, asked: settings.lumping });
    }
    Ok(())
}
