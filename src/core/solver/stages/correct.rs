//! Third stage: threads are solved whole, or springs are held to Provot's limit; then tethers.

use crate::solver::ClothSolver;
use crate::solver::constraints::shear::{Cells, CorrectShear, ShearRule};
use crate::solver::constraints::strain_check::ExceedsLimit;
use crate::solver::constraints::strain_limit::{CorrectSprings, Rule};
use crate::solver::constraints::tethers::PullTethers;
use crate::solver::constraints::threads::Lines;
use crate::solver::constraints::threads::tridiagonal::Reach;
use crate::solver::constraints::threads::warp::{PutBack, SolveWarp, SolveWarpApart};
use crate::solver::constraints::threads::weft::SolveWeft;
use crate::solver::contact::HoldOnto;
use crate::solver::settings::Stretching;
use crate::solver::simd::parallel::{self, Bands};
use crate::solver::simd::soa::ValuesMut;
use crate::solver::state::{State, Workspace};
use crate::solver::topology::Topology;

impl ClothSolver {
    /// Third stage: threads or Provot's limit, then tethers.
    pub fn correct(&mut self) {
        self.weigh_soft_pins();
        self.hold_onto_colliders();
        self.gather_particles(true);
        // Springs that carry the cloth, and what was asked of them, need no tethers.
        let mut tethered = self.plan.clamped.thread || self.plan.gives;
        match self.plan.stretching {
            Stretching::ImplicitThreads => {
                self.correct_shear();
                if self.solve_threads() {
                    self.limit_strain();
                }
                tethered = true;
            }
            Stretching::ExplicitSprings => self.limit_strain(),
        }
        self.scatter_particles();
        if tethered {
            self.pull_tethers();
        }
        self.note_unfollowed(true);
        self.unweigh_soft_pins();
    }

    /// Lets what lay on a collider go only where it can.
    pub(crate) fn hold_onto_colliders(&mut self) {
        let part = self.carried();
        self.state.contacts.impulses.carry_on(part);
        let State { d, pull, contacts, .. } = &mut self.state;
        if contacts.now.any {
            let carried = self.workspace.carries.then_some(&*pull);
            let (inverse_mass, step) = (&self.pins.inverse_mass, self.plan.step);
            self.isa.run(HoldOnto { set: contacts, inverse_mass, step, d, carried });
            contacts.give_left_out(inverse_mass, step);
        }
    }

    pub(crate) fn correct_shear(&mut self) {
        let stiffness = self.plan.shear_stiffness;
        if stiffness > 0.0 {
            let compliance = 1.0 / (stiffness * self.correction_response());
            let limit = self.limit();
            match &self.topology {
                Topology::Lattice(lattice) if self.state.carries => {
                    let Workspace { seams, row_pulls, .. } = &mut self.workspace;
                    if self.bands.rows.count() > 1 {
                        seams.copy(&self.state.d);
                    }
                    let State { x, d, contacts, .. } = &mut self.state;
                    let contacts = contacts.contacts();
                    let cells = Cells {
                        normals: contacts.as_ref().map(|contacts| contacts.normals),
                        lattice,
                        inverse_mass: &self.pins.inverse_mass,
                        rule: ShearRule { compliance, limit, crowd: lattice.crowd },
                        x,
                    };
                    let shear = CorrectShear {
                        band: self.bands.rows.clone(),
                        cells,
                        d: d.part_mut(),
                        contacts,
                        seams,
                        rooms: row_pulls,
                    };
                    parallel::run(self.isa, shear);
                }
                _ => self.correct_springs(Rule::Shear { compliance, limit }),
            }
        }
    }

    pub(crate) fn limit_strain(&mut self) {
        // The thread form holds shear springs to the limit where it corrects them.
        let shear = self.plan.stretching == Stretching::ExplicitSprings
            && self.material.shear_stiffness > 0.0;
        let limit = self.limit();
        for _ in 0..self.settings.provot_passes {
            if !self.exceeds_limit(limit, shear) {
                return;
            }
            self.pause_pulls();
            self.correct_springs(Rule::Limit { limit, shear });
            self.go_on_pulling();
        }
    }

    /// Whether there is anything to hold to the limit. A mesh's pass looks for itself, as it goes.
    pub(crate) fn exceeds_limit(&self, limit: f32, shear: bool) -> bool {
        let Topology::Lattice(lattice) = &self.topology else { return true };
        let State { x, d, .. } = &self.state;
        let band = self.bands.rows.clone();
        parallel::run(self.isa, ExceedsLimit { band, lattice, limit, shear, x, d })
    }

    /// Longest that a spring may be, in rest lengths.
    pub(crate) fn limit(&self) -> f32 {
        1.0 + self.material.max_strain
    }

    pub(crate) fn correct_springs(&mut self, rule: Rule) {
        if let (Topology::Graph(graph), Some(room)) = (&self.topology, &mut self.workspace.graph) {
            room.correct_springs(self.isa, graph, rule, self.state.contacts.now.any);
        }
        let Topology::Lattice(lattice) = &self.topology else { return };
        let State { x, d, contacts, .. } = &mut self.state;
        let springs = CorrectSprings {
            band: self.bands.rows.clone(),
            lattice,
            inverse_mass: &self.pins.inverse_mass,
            x,
            d,
            rule,
            contacts: contacts.contacts(),
        };
        springs.run(self.isa);
    }

    /// Weft threads, then warp threads. Tells whether any spring came to them beyond its limit: where
    /// none did, none has to be held to it.
    pub(crate) fn solve_threads(&mut self) -> bool {
        let stiffness = self.plan.thread_stiffness;
        if stiffness <= 0.0 {
            return true;
        }
        let isa = self.isa;
        let compliance = 1.0 / (stiffness * self.correction_response());
        let reach = Reach { compliance, limit: self.limit(), steady: self.steady };
        if let (Topology::Graph(graph), Some(room)) = (&self.topology, &mut self.workspace.graph) {
            return room.solve_chains(isa, graph, reach, self.state.contacts.now.any);
        }
        let weft_beyond = self.solve_weft(reach);
        let warp_beyond = self.solve_warp(reach);
        weft_beyond || warp_beyond
    }

    pub(crate) fn solve_weft(&mut self, reach: Reach) -> bool {
        let Topology::Lattice(lattice) = &self.topology else { return false };
        let State { x, d, contacts, .. } = &mut self.state;
        let weft = SolveWeft {
            band: self.bands.rows.clone(),
            lines: lattice.layout.transposed(),
            springs: &lattice.weft_transposed,
            inverse_mass: &self.pins.inverse_mass_transposed,
            reach,
            x,
            d: d.part_mut(),
            contacts: contacts.contacts(),
            rooms: &self.workspace.threads,
        };
        parallel::run(self.isa, weft)
    }

    pub(crate) fn solve_warp(&mut self, reach: Reach) -> bool {
        let Topology::Lattice(lattice) = &self.topology else { return false };
        let Bands { rows, columns, .. } = &self.bands;
        let State { x, d, contacts, .. } = &mut self.state;
        let Workspace { threads: rooms, apart, load_apart, .. } = &mut self.workspace;
        let (layout, springs) = (lattice.layout, &lattice.warp);
        let inverse_mass = &self.pins.inverse_mass;
        if columns.count() == 1 {
            let line = &mut rooms.take().line;
            let lines = Lines { layout, springs, reach, inverse_mass, line };
            let contacts = contacts.contacts();
            return self.isa.run(SolveWarp { layout, lines, x, d, contacts });
        }
        let touches = contacts.now.any;
        let warp = SolveWarpApart {
            band: columns.clone(),
            layout,
            springs,
            inverse_mass,
            reach,
            x,
            d,
            apart: apart.part_mut(),
            contacts: touches.then(|| (&contacts.now, &contacts.load, ValuesMut::all(load_apart))),
            rooms,
        };
        let beyond = parallel::run(self.isa, warp);
        let loads = contacts.contacts().map(|contacts| (&*load_apart, contacts.load));
        parallel::run(self.isa, PutBack { band: rows.clone(), apart, d: d.part_mut(), loads });
        beyond
    }

    pub(crate) fn pull_tethers(&mut self) {
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

    /// A graph's particles are gathered from places; on a lattice there is nothing to do.
    pub(crate) fn gather_particles(&mut self, corrects: bool) {
        if let Some(room) = &mut self.workspace.graph {
            room.fill(self.isa, &self.pins.inverse_mass, &self.state, corrects);
        }
    }

    pub(crate) fn scatter_particles(&mut self) {
        if let Some(room) = &self.workspace.graph {
            room.empty(self.isa, &mut self.state);
        }
    }
}
