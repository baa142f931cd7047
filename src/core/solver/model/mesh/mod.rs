//! The mesh: particles that are gathered by index. Its stages work on *places*, particles one after the other, which are
//! filled before and emptied after.

mod workspace;

use std::sync::Arc;

use crate::solver::constraints::graph_strain_limit::{CorrectPairs, LargestStrain};
use crate::solver::constraints::strain_check::{Limit, Since};
use crate::solver::constraints::strain_limit::Rule;
use crate::solver::constraints::threads::chains::SolveChains;
use crate::solver::constraints::threads::shifts::{ShiftSprings, Shifting, Shifts};
use crate::solver::constraints::threads::tridiagonal::Reach;
use crate::solver::forces::graph_bending::{Coupled, Turn, Turned};
use crate::solver::forces::graph_springs::{Damped, GatherDamping, GatherForces, Pulls, Target};
use crate::solver::integrate::houbolt::Filter;
use crate::solver::model::mesh::workspace::MeshWorkspace;
use crate::solver::model::{Acting, Particles, Shearing, Stages};
use crate::solver::plan::Plan;
use crate::solver::plan::graph_stiffness::GraphStiffness;
use crate::solver::plan::stability::Bound;
use crate::solver::settings::Bending;
use crate::solver::simd::block::larger;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::parallel::{self, Bands};
use crate::solver::simd::slots::SlotsOf;
use crate::solver::simd::soa::Soa;
use crate::solver::state::State;
use crate::solver::state::measure::{Survey, TakeSurvey};
use crate::solver::topology::graph::Graph;
use crate::solver::topology::graph::domains::DomainBand;

/// A mesh's rest shape, the constants of its springs and hinges, and what its stages work in.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    graph: Arc<Graph>,
    stiffness: GraphStiffness,
    workspace: MeshWorkspace,
    /// Shifts of the springs of chains, round by round and domain by domain.
    shifts: Vec<Vec<Shifts>>,
    /// Whether any may be other than zero.
    is_shifted: bool,
    /// Compliance at which threads were last solved, of a spring of shape factor one \[1/kg\].
    compliance: f32,
    /// Whether one pass over the chains comes near enough to their solution that its pulls are forces, not noise.
    is_solved_enough: bool,
}

/// `h^2 k` times the row sums over the masses, in the mean of the particles, up to which pulls of chains are carried on.
/// Beyond, rounding is more than what a pass leaves to do.
const STIFFEST_CARRIED: f32 = 1e9;

impl Mesh {
    /// Nothing held.
    pub fn new(graph: Arc<Graph>) -> Self {
        let stiffness = GraphStiffness::new(&graph, &vec![false; graph.layout.len()]);
        let workspace = MeshWorkspace::new(&graph);
        let shifts = Shifts::none_of_chains(&graph.chains);
        Self {
            graph,
            stiffness,
            workspace,
            shifts,
            is_shifted: false,
            compliance: 0.0,
            is_solved_enough: false,
        }
    }

    /// Springs, hinges and gravity, from places as they are.
    fn accumulate_forces(&mut self, on: &Particles<'_>, acting: &Acting<'_>, a: &mut Soa) {
        let Self { graph, stiffness, workspace, .. } = self;
        let Acting { plan, gravity, .. } = *acting;
        let MeshWorkspace { places, moments, .. } = workspace;
        let places = &*places;
        let hinges = &graph.hinges;
        let bends = plan.explicit.bend > 0.0;
        if bends {
            let (hinges, constants) = (&hinges.curved, &stiffness.hinges);
            let moments = SlotsOf::all(moments);
            let band = hinges.band(on.bands.are_shared());
            parallel::run(on.isa, Turn { band, hinges, constants, places, moments });
        }
        let flat = Coupled { couplings: &hinges.flat, constants: &stiffness.couplings };
        let curved = Turned { hinges: &hinges.curved, moments };
        let explicit = plan.explicit;
        let springs =
            Pulls { table: &graph.springs, rest: &graph.spring_rest, constant: &stiffness.springs };
        let flexion =
            stiffness.flexion.as_ref().filter(|_| explicit.flexion > 0.0).map(|flexion| Pulls {
                table: &flexion.table,
                rest: &flexion.rest,
                constant: &flexion.constants,
            });
        let pulls = explicit.thread > 0.0 || explicit.shear > 0.0;
        let forces = GatherForces {
            band: on.bands.rows.clone(),
            springs: [pulls.then_some(springs), flexion],
            bent: bends.then_some((flat, curved)),
            gravity,
            places,
            a: a.part_mut(),
        };
        parallel::run(on.isa, forces);
    }

    /// Damping, in the two steps that it takes on a sheet.
    fn add_damping(&mut self, on: &Particles<'_>, acting: &Acting<'_>, a: &mut Soa) {
        let (half, unit) = (acting.half_kick, on.state.unit);
        let springs = Damped {
            table: &self.graph.springs,
            constant: &self.stiffness.damping,
            rate: 1.0 / unit,
            form: acting.damping_form,
        };
        let MeshWorkspace { places, predicted, .. } = &mut self.workspace;
        let target = Target::Predict {
            keep: half.decay,
            gain: half.gain * unit,
            a,
            predicted: SlotsOf::all(predicted),
        };
        let band = || on.bands.rows.clone();
        parallel::run(on.isa, GatherDamping { band: band(), springs, places, target });
        let target = Target::Accelerations { predicted, a: a.part_mut() };
        parallel::run(on.isa, GatherDamping { band: band(), springs, places, target });
    }
}

impl Stages for Mesh {
    fn hold(&mut self, held: &[bool]) {
        self.stiffness = GraphStiffness::new(&self.graph, held);
    }

    fn bound(&self, inverse_mass: &[f32]) -> Bound {
        Bound::Graph(self.stiffness.circles(&self.graph, inverse_mass))
    }

    fn bend(&mut self, bending: Bending, rubs: bool) {
        self.stiffness.set_bending(&self.graph, bending);
        if rubs {
            self.graph.wide_hinges();
        }
    }

    fn follow(&mut self, plan: &Plan, bound: &Bound) {
        self.stiffness.set(&self.graph, bound, &plan.demand);
        let moving = bound.circles().iter().map(|circle| circle.thread).filter(|&sum| sum > 0.0);
        let (sum, count) = moving.fold((0.0, 0), |(all, count), one| (all + one, count + 1));
        let ratio = plan.thread_stiffness * plan.step * plan.step * (sum / count as f32);
        // None where nothing moves.
        self.is_solved_enough = ratio <= STIFFEST_CARRIED;
    }

    fn filter(&self, touches: bool) -> Option<Filter> {
        let filter = if touches { Filter::OF_FIRST_ORDER } else { Filter::OF_CHAINS };
        self.is_solved_enough.then_some(filter)
    }

    fn brake_bending(&mut self, on: Particles<'_>, part: f32, most: f32) {
        let State { x, d, .. } = on.state;
        self.graph.wide_hinges().brake(part, most, &on.pins.inverse_mass, x, d);
    }

    fn accelerate(&mut self, on: Particles<'_>, acting: &Acting<'_>, a: &mut Soa) {
        self.workspace.fill(&on, false);
        self.accumulate_forces(&on, acting, a);
        if let Some(pushes) = acting.pushes {
            pushes.add(on.isa, self.graph.layout, &on.pins.inverse_mass, a);
        }
        if acting.plan.damping > 0.0 {
            self.add_damping(&on, acting, a);
        }
    }

    fn begin_corrections(&mut self, on: Particles<'_>) {
        self.workspace.fill(&on, true);
    }

    fn correct_shear(&mut self, on: Particles<'_>, reach: Reach, _: Shearing) {
        let Reach { compliance, limit, .. } = reach;
        self.correct_springs(on, Rule::Shear { compliance, limit });
    }

    fn solve_threads(&mut self, on: Particles<'_>, reach: Reach, _: bool) -> bool {
        let MeshWorkspace { places, chains: workspaces, .. } = &mut self.workspace;
        let (touches, shared) = (on.state.contacts.now.any, on.bands.are_shared());
        let mut exceeds = false;
        self.compliance = reach.compliance;
        for (domains, shifts) in self.graph.chains.0.iter().zip(&mut self.shifts) {
            let band = DomainBand::all(domains, shared);
            let places = places.part_mut();
            let solve = SolveChains { band, domains, reach, touches, places, workspaces, shifts };
            exceeds |= parallel::run(on.isa, solve);
        }
        exceeds
    }

    fn leaves_much(&self) -> bool {
        true
    }

    fn shift_springs(&mut self, on: Particles<'_>, shifting: Shifting) {
        if !(self.is_shifted || shifting.grows()) {
            return;
        }
        let (compliance, x) = (self.compliance, &on.state.x);
        for (domains, shifts) in self.graph.chains.0.iter().zip(&mut self.shifts) {
            let band = DomainBand::all(domains, on.bands.are_shared());
            let shift = ShiftSprings { band, domains, shifting, compliance, x, shifts };
            parallel::run(on.isa, shift);
        }
        self.is_shifted = true;
    }

    fn shifts(&self) -> Vec<f32> {
        let all = self.shifts.iter().flatten().filter(|_| self.is_shifted);
        all.flat_map(|shifts| shifts.by.iter().copied()).collect()
    }

    fn set_shifts(&mut self, by: &[f32]) {
        let were_shifted = self.is_shifted;
        self.is_shifted = Shifts::can_be(&self.graph.chains, by);
        if !(self.is_shifted || were_shifted) {
            return;
        }
        let mut by = by.iter().copied().filter(|_| self.is_shifted);
        for shift in self.shifts.iter_mut().flatten().flat_map(|shifts| shifts.by.iter_mut()) {
            *shift = by.next().unwrap_or(0.0);
        }
    }

    /// The pass looks for itself, as it goes.
    fn exceeds_limit(&mut self, _: Particles<'_>, _: Limit, _: Since) -> bool {
        true
    }

    /// One batch of springs after the other.
    fn correct_springs(&mut self, on: Particles<'_>, rule: Rule) -> bool {
        let (touches, shared) = (on.state.contacts.now.any, on.bands.are_shared());
        let Graph { structural_pairs, shear_pairs, .. } = &*self.graph;
        let MeshWorkspace { places, near_limit, .. } = &mut self.workspace;
        let mut correct = |domains, near| {
            let (band, places) = (DomainBand::all(domains, shared), places.part_mut());
            parallel::run(on.isa, CorrectPairs { band, domains, rule, touches, places, near })
        };
        let mut is_beyond = false;
        if let Rule::Limit(_) = rule {
            for (domains, near) in structural_pairs.0.iter().zip(near_limit) {
                is_beyond |= correct(domains, Some(near));
            }
        }
        if let Rule::Shear { .. } | Rule::Limit(Limit { shear: true, .. }) = rule {
            for domains in &shear_pairs.0 {
                is_beyond |= correct(domains, None);
            }
        }
        is_beyond
    }

    fn end_corrections(&mut self, on: Particles<'_>) {
        self.workspace.empty(on);
    }

    fn survey(&self, isa: Isa, bands: &Bands, state: &State) -> Survey {
        let survey = parallel::run(isa, TakeSurvey::new(bands.rows.clone(), None, state));
        let largest = |domains: &Vec<_>| {
            let band = DomainBand::all(domains, bands.are_shared());
            parallel::run(isa, LargestStrain { band, domains, x: &state.x }).0
        };
        let strains = self.graph.structural_pairs.0.iter().map(largest);
        Survey { max_strain: strains.fold(survey.max_strain, larger), ..survey }
    }
}
