//! The load that a cloth is found to have in a tick, and what follows for its inertia (`state::carrying`).

use bevy_math::Vec3;

use crate::solver::ClothSolver;
use crate::solver::contact::Collider;
use crate::solver::input::StepInput;
use crate::solver::state::State;
use crate::solver::state::carrying::{Burden, Carrying, Load};

/// Least upward acceleration that a cloth gives a body which it carries \[m/s2\]. What it gives less to is as a collider that it does not
/// move.
const LEAST_ACCELERATION: f32 = 0.1;
/// Strain beyond its limit at which a cloth is not given more mass to move with. It would contract, and throw up what it carries.
const MOST_BEYOND: f32 = 0.1;

impl ClothSolver {
    /// Finds what the cloth carries in a tick that begins, and has it move as if it had the mass for that.
    pub(crate) fn begin_carrying(&mut self, input: &StepInput<'_>) {
        let (load, [hangs, pulls]) = (self.load(input), self.pinned(input));
        let is_stretched = self.is_overstretched();
        self.workspace.bears_sleeper = load == Load::AsBefore;
        self.state.carrying.follow(load, hangs && !pulls, is_stretched, input.dt);
        self.state.contacts.impulses.falls = (!hangs).then_some(input.gravity * input.dt);
        let scale = self.state.carrying.mass_scale;
        if scale > self.pins.mass_scale {
            self.slow_down(self.pins.mass_scale / scale, input);
        }
        self.scale_mass();
    }

    /// Has the cloth take up mass for bodies that it bears in this tick, in the substep that ends. One that falls onto it at some metres a second
    /// stretches it far before the tick ends.
    pub(crate) fn go_on_carrying(&mut self, input: &StepInput<'_>) {
        if !self.state.contacts.impulses.meet_bodies() || self.is_overstretched() {
            return;
        }
        let [hangs, pulls] = self.pinned(input);
        if !hangs || pulls {
            return;
        }
        let up = -input.gravity.normalize_or_zero();
        let rest = self.mean_way_of_pins(input);
        let own = f64::from(self.topology.total_area() * self.material.area_density);
        let pushed = self.state.contacts.impulses.pushed(up, LEAST_ACCELERATION * input.dt);
        let mass = pushed.map(|body| {
            let falls = (rest - input.colliders[body.collider].way()).dot(up) / input.dt;
            body.mass * Carrying::part_of(falls)
        });
        let mass = mass.sum::<f64>() / own;
        let part = self.state.carrying.take_up(mass);
        if part < 1.0 {
            self.slow_down(part, input);
            self.scale_mass();
        }
    }

    /// Whether its threads are stretched far beyond their limit.
    fn is_overstretched(&self) -> bool {
        self.survey.max_strain > self.material.max_strain + MOST_BEYOND
    }

    /// How far the pins go in the tick, in the mean \[m\].
    pub(crate) fn mean_way_of_pins(&self, input: &StepInput<'_>) -> Vec3 {
        let way: Vec3 = input.pins.iter().map(|pin| pin.end - pin.start).sum();
        way / (input.pins.len() as f32).max(1.0)
    }

    /// Has particles move as if they had the mass that what the cloth carries asks for.
    pub(crate) fn scale_mass(&mut self) {
        let scale = self.state.carrying.mass_scale;
        if scale != self.pins.mass_scale {
            self.pins.scale_mass(&self.topology, self.material.area_density, scale);
        }
    }

    /// Slows the cloth, which keeps `part` of its velocity as it takes up mass that was at rest between its pins, and of the ways that pulls which
    /// are carried on would move it. So its momentum stays, and its energy does not grow.
    fn slow_down(&mut self, part: f32, input: &StepInput<'_>) {
        let rest = self.mean_way_of_pins(input) * (self.state.unit / input.dt);
        let State { d, pull, carries, .. } = &mut self.state;
        for slot in self.topology.layout().slots() {
            d.set(slot, rest + (d.get(slot) - rest) * part);
            if *carries {
                pull.set(slot, pull.get(slot) * part);
            }
        }
    }

    /// Finds the load of the cloth. A sheet that is pinned carries what presses on it as well, even if that is no body.
    fn load(&self, input: &StepInput<'_>) -> Load {
        let contacts = &self.state.contacts;
        let is_held = !self.pins.slots.is_empty() && !self.model.stages().leaves_much();
        match self.burden(input) {
            _ if self.bears_one_that_sleeps(input) => Load::AsBefore,
            Some(burden) => Load::Bodies(burden),
            None if contacts.impulses.meet_bodies() => Load::Met,
            None if is_held && contacts.now.any => Load::Pressed,
            None => Load::None,
        }
    }

    /// Finds the bodies that the cloth carries, if there are any: lying on it, or hung from it.
    fn burden(&self, input: &StepInput<'_>) -> Option<Burden> {
        let contacts = &self.state.contacts;
        if contacts.is_empty() && input.pulls.is_empty() {
            return None;
        }
        let own = f64::from(self.topology.total_area() * self.material.area_density);
        let up = -input.gravity.normalize_or_zero();
        let bodies = || contacts.impulses.carried(up, LEAST_ACCELERATION * input.dt);
        let heaviest = bodies().max_by(|a, b| a.mass.total_cmp(&b.mass))?;
        let mass = bodies().map(|body| body.mass).sum::<f64>() / own;
        Some(Burden { mass, heaviest: input.colliders[heaviest.collider].body })
    }

    /// Whether the heaviest body that it carried in the last tick lies on it still, and sleeps.
    fn bears_one_that_sleeps(&self, input: &StepInput<'_>) -> bool {
        let Carrying { share, heaviest, .. } = self.state.carrying;
        let sleeps =
            |it: &Collider<'_>| it.body == heaviest && it.measured && it.mobility.is_none();
        let lies = |collider: usize| input.colliders.get(collider).is_some_and(sleeps);
        let carried = heaviest != 0 && share.is_some_and(|share| share > 0.0);
        carried
            && input.colliders.iter().any(sleeps)
            && self.state.contacts.touches(self.topology.layout(), lies)
    }

    /// Whether pins hold the cloth to what it does not move, and whether any of them pulls at a body.
    fn pinned(&self, input: &StepInput<'_>) -> [bool; 2] {
        let impulses = &self.state.contacts.impulses;
        let pulls = input.pulls.iter().filter(|pull| impulses.of_body(pull.body).is_some());
        let (pins, pulls) = (self.pins.slots.len() + self.soft.len(), pulls.count());
        [pins > pulls, pulls > 0]
    }

    /// Mass that a square metre of the cloth moves as if it had \[kg/m2\].
    pub(crate) fn inertia(&self) -> f32 {
        self.material.area_density * self.pins.mass_scale
    }

    /// Acceleration of the cloth by its weight, which is its own, whatever it moves as if it had \[m/s2\].
    pub(crate) fn gravity(&self, input: &StepInput<'_>) -> Vec3 {
        input.gravity / self.pins.mass_scale
    }
}
