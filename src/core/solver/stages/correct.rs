//! Third stage: threads are solved whole, or springs are held to Provot's limit; then tethers; then the skin.

use crate::solver::ClothSolver;
use crate::solver::constraints::strain_check::{Limit, Since};
use crate::solver::constraints::strain_limit::Rule;
use crate::solver::constraints::tethers::PullTethers;
use crate::solver::constraints::threads::shifts::{DRAG_OF_AIR, LEAST_SHARE, Shifting, Touches};
use crate::solver::constraints::threads::tridiagonal::Reach;
use crate::solver::contact::HoldOnto;
use crate::solver::model::{Particles, Shearing, Stages};
use crate::solver::plan::Plan;
use crate::solver::settings::Stretching;
use crate::solver::simd::parallel;
use crate::solver::state::State;

/// Substeps after which all springs of a mesh are held to their limit, not only those that were near it.
const LOOK_EVERY: u32 = 4;
/// Passes of the strain limit at a tick's end at most, for each one of a substep.
pub(crate) const PASSES_AT_END: u32 = 20;

impl ClothSolver {
    /// Third stage: threads or Provot's limit, then tethers, then the skin.
    pub fn correct(&mut self) {
        let exceeds = self.pull_threads();
        self.hold_threads(exceeds);
        self.keep_layers_apart();
        self.hold_to_skin();
    }

    /// First part of the third stage: threads are solved, layers of the cloth that touch are moved apart. Tells whether any spring may
    /// be beyond its limit.
    pub(crate) fn pull_threads(&mut self) -> bool {
        self.weigh_soft_pins();
        self.weigh_pulling();
        self.hold_onto_colliders();
        self.begin_corrections();
        let exceeds = match self.plan.stretching {
            Stretching::ImplicitThreads => {
                self.correct_shear();
                self.solve_threads()
            }
            Stretching::ExplicitSprings => true,
        };
        self.note_pulling();
        // What the cloth's layers push apart may be beyond the limit as well.
        self.meet_itself() || exceeds
    }

    /// Second part of the third stage: springs are held to their limit, then tethers pull.
    pub(crate) fn hold_threads(&mut self, exceeds: bool) {
        // Of threads that cross, the later ones may stretch the earlier.
        let leaves_much = self.model.stages().leaves_much();
        if exceeds || leaves_much && self.goes_on() {
            self.limit_strain();
        }
        self.end_corrections();
        // Tethers hold to pins, and pull at none.
        self.give_pulls();
        // Springs that carry the cloth, and what was asked of them, need no tethers.
        let is_woven = self.plan.stretching == Stretching::ImplicitThreads;
        if is_woven || self.plan.clamped.thread || self.plan.gives {
            self.pull_tethers();
        }
        self.give_soft_pulls();
        self.note_unfollowed(true);
        self.unweigh_soft_pins();
    }

    /// The model's stages, and what they work on.
    pub(crate) fn model_and_particles(&mut self) -> (&mut dyn Stages, Particles<'_>) {
        let Self { model, isa, bands, pins, state, .. } = self;
        (model.stages_mut(), Particles { isa: *isa, bands, pins, state })
    }

    /// Lets what lay on a collider go only where it can.
    fn hold_onto_colliders(&mut self) {
        let (keeps, moves) =
            self.carried().map_or((0.0, 0.0), |filter| (filter.keeps, filter.moves));
        self.state.contacts.impulses.carry_on(keeps, moves);
        let State { x, d, pull, contacts, .. } = &mut self.state;
        if contacts.now.any {
            let carried = self.workspace.filter.map(|filter| (&*pull, filter.moves));
            let (inverse_mass, step) = (&self.pins.inverse_mass, self.plan.step);
            self.isa.run(HoldOnto { set: contacts, inverse_mass, step, d, carried });
            contacts.give_left_out(self.isa, inverse_mass, x, step);
        }
    }

    fn correct_shear(&mut self) {
        let stiffness = self.plan.shear_stiffness;
        if stiffness > 0.0 {
            let compliance = 1.0 / (stiffness * self.correction_response());
            let reach = Reach { compliance, limit: self.limit(), steady: self.steady };
            let ends_tick = self.ends_tick();
            let whole = self.state.carrying.share.is_some_and(|share| share >= LEAST_SHARE);
            let (model, on) = self.model_and_particles();
            model.correct_shear(on, reach, Shearing { ends_tick, whole });
        }
    }

    /// Solves the threads. Tells whether any spring came to them beyond its limit.
    fn solve_threads(&mut self) -> bool {
        let stiffness = self.plan.thread_stiffness;
        if stiffness <= 0.0 {
            return true;
        }
        let compliance = 1.0 / (stiffness * self.correction_response());
        let reach = Reach { compliance, limit: self.limit(), steady: self.steady };
        let ends_tick = self.ends_tick();
        let (model, on) = self.model_and_particles();
        model.solve_threads(on, reach, ends_tick)
    }

    /// Whether this substep is the last of a tick.
    fn ends_tick(&self) -> bool {
        self.done + 1 == self.plan.substeps
    }

    /// Ends a tick: shifts springs by what threads leave them too long (`constraints::threads::shifts`). None grows where threads do not
    /// come near enough to their solution to be carried on.
    pub(crate) fn shift_springs(&mut self) {
        let is_woven =
            self.plan.stretching == Stretching::ImplicitThreads && self.plan.thread_stiffness > 0.0;
        let is_overloaded =
            self.state.carrying.share.is_some_and(|share| share > 0.0 && share < LEAST_SHARE);
        if !is_woven || is_overloaded {
            self.model.stages_mut().set_shifts(&[]);
            return;
        }
        if self.workspace.bears_sleeper {
            // A body that sleeps is nothing that springs could lift.
            return;
        }
        let leaves_much = self.model.stages().leaves_much();
        let drag = match &self.air {
            _ if self.workspace.filter.is_none() => 0.0,
            // Pins further apart than a sheet reaches would have it tremble.
            _ if !leaves_much && !self.can_end_within_limit() => 0.0,
            // Air brakes the cloth as it weighs, whatever it moves as if it did.
            Some(surface) if surface.air.density > 0.0 => DRAG_OF_AIR / self.pins.mass_scale,
            Some(_) => 0.0,
            None => self.material.drag,
        };
        let touches = self.touches();
        let Plan { tick, step, .. } = self.plan;
        let limit = self.material.max_strain;
        let shifting = Shifting::new([tick, step], drag, touches, leaves_much, limit);
        // Threads that leave little have come near enough on colliders, and what lies there is to lie still.
        let shifting = match touches {
            Touches::Colliders if !leaves_much => shifting.without_growth(),
            _ => shifting,
        };
        let (model, on) = self.model_and_particles();
        model.shift_springs(on, shifting);
    }

    /// Tells shifts what the cloth touches.
    fn touches(&self) -> Touches {
        if let Some(share) = self.state.carrying.share {
            Touches::Carried { share }
        } else if self.state.contacts.now.any || self.rests_on_layers() {
            Touches::Colliders
        } else {
            Touches::Nothing
        }
    }

    /// Whether the cloth is a sheet that touches layers of cloth, where it would not come to rest if more were asked of it.
    fn rests_on_layers(&self) -> bool {
        (self.touching_itself > 0 || self.touching_others > 0) && !self.model.stages().leaves_much()
    }

    fn limit_strain(&mut self) {
        let mut left = self.passes();
        if left == 0 || !self.may_exceed_limit(Since::Never) {
            return;
        }
        self.end_corrections();
        self.pause_pulls();
        self.begin_corrections();
        while self.pass_over_springs() {
            left -= 1;
            if left == 0 || !self.may_exceed_limit(Since::Pass) {
                break;
            }
        }
        self.end_corrections();
        self.go_on_pulling();
        self.begin_corrections();
    }

    /// Whether any spring may be beyond the strain limit.
    pub(crate) fn may_exceed_limit(&mut self, since: Since) -> bool {
        let limit = self.strain_limit();
        let (model, on) = self.model_and_particles();
        model.exceeds_limit(on, limit, since)
    }

    /// Holds all springs to the strain limit once. Tells whether any was beyond it.
    pub(crate) fn hold_springs(&mut self) -> bool {
        self.begin_corrections();
        let is_beyond = self.pass_over_springs();
        self.end_corrections();
        is_beyond
    }

    /// The same, of corrections that have begun.
    fn pass_over_springs(&mut self) -> bool {
        let limit = self.strain_limit();
        if limit.all {
            self.workspace.looked = Some(self.done);
        }
        let (model, on) = self.model_and_particles();
        model.correct_springs(on, Rule::Limit(limit))
    }

    /// The limit of strain, for the next pass. Not every pass looks at all springs of a mesh: what is far within its limit is not beyond
    /// it a few substeps later, and is held to it then. All are looked at where a tick ends, and where the cloth is struck or far out of
    /// shape.
    fn strain_limit(&self) -> Limit {
        let is_calm = self.state.carries && self.done + 1 < self.plan.substeps;
        let is_recent = |at: u32| self.done - at < LOOK_EVERY;
        let all = !(is_calm && self.workspace.looked.is_some_and(is_recent));
        Limit { longest: self.limit(), shear: self.limits_shear(), all }
    }

    /// Whether the strain limit is one for shear springs. The thread form holds them to it where it corrects them.
    fn limits_shear(&self) -> bool {
        self.plan.stretching == Stretching::ExplicitSprings && self.material.shear_stiffness > 0.0
    }

    /// How many passes of the strain limit this substep makes at most.
    fn passes(&self) -> u32 {
        let more = if self.goes_on() { PASSES_AT_END } else { 1 };
        more * self.settings.provot_passes
    }

    /// Whether this substep's passes of the strain limit go on until all springs are within it, but for next to nothing: in the last of a
    /// tick. Within a tick the next substep goes on where one ended; what is drawn is to be within the limit.
    ///
    /// Not on colliders, nor a sheet on layers of cloth, where it would not come to rest; what is worn ends in a way of its own
    /// (`stages/worn`).
    fn goes_on(&self) -> bool {
        self.ends_tick()
            && self.skin.is_none()
            && !self.state.contacts.now.any
            && !self.rests_on_layers()
            && self.can_end_within_limit()
    }

    /// Whether passes of the strain limit can succeed; others would shake the cloth. They cannot where pins are further apart than the cloth
    /// between them reaches, nor with explicit springs, which are softer than asked for.
    pub(crate) fn can_end_within_limit(&self) -> bool {
        self.plan.stretching == Stretching::ImplicitThreads && self.tether_ease == 1.0
    }

    pub(crate) fn begin_corrections(&mut self) {
        let (model, on) = self.model_and_particles();
        model.begin_corrections(on);
    }

    pub(crate) fn end_corrections(&mut self) {
        let (model, on) = self.model_and_particles();
        model.end_corrections(on);
    }

    /// Longest that a spring may be, in rest lengths.
    fn limit(&self) -> f32 {
        1.0 + self.material.max_strain
    }

    fn pull_tethers(&mut self) {
        if !self.settings.tethers || self.pins.tethers.is_empty() {
            return;
        }
        let State { x, d, .. } = &mut self.state;
        for (place, &slot) in self.pins.places.iter_mut().zip(&self.pins.slots) {
            *place = x.get(slot) + d.get(slot);
        }
        let pull = PullTethers {
            band: self.bands.rows.clone(),
            sets: &self.pins.tethers,
            pins: &self.pins.places,
            ease: self.tether_ease,
            inverse_mass: &self.pins.inverse_mass,
            x,
            d: d.part_mut(),
        };
        parallel::run(self.isa, pull);
    }
}
