//! The stages of a substep that are different on a mesh. They work on places, particles one after the
//! other, which are filled before and emptied after.

use bevy_math::Vec3;

use crate::solver::constraints::graph_strain_limit::{CorrectPairs, LargestStrain};
use crate::solver::constraints::strain_limit::Rule;
use crate::solver::constraints::threads::chains::SolveChains;
use crate::solver::constraints::threads::tridiagonal::Reach;
use crate::solver::forces::graph_bending::{Coupled, Turn, Turned};
use crate::solver::forces::graph_springs::{Damped, GatherDamping, GatherForces, Pulls, Target};
use crate::solver::integrate::verlet::Kick;
use crate::solver::plan::Plan;
use crate::solver::plan::graph_stiffness::GraphStiffness;
use crate::solver::settings::DampingForm;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::soa::Soa;
use crate::solver::state::State;
use crate::solver::state::mesh::MeshWorkspace;
use crate::solver::topology::graph::Graph;

impl MeshWorkspace {
    /// Accelerations of springs, hinges and gravity, from places as they are.
    pub fn accumulate_forces(
        &mut self,
        isa: Isa,
        graph: &Graph,
        strengths: &GraphStiffness,
        plan: &Plan,
        gravity: Vec3,
        a: &mut Soa,
    ) {
        let bends = plan.hinge_rigidity > 0.0;
        let hinges = &graph.hinges;
        if bends {
            let (constants, places) = (&strengths.hinges, &self.places);
            let moments = &mut self.moments;
            isa.run_transposing(Turn { hinges: &hinges.curved, constants, places, moments });
        }
        let flat = Coupled { couplings: &hinges.flat, constants: &strengths.couplings };
        let curved = Turned { hinges: &hinges.curved, moments: &self.moments };
        let explicit = plan.explicit;
        let springs =
            Pulls { table: &graph.springs, rest: &graph.spring_rest, constant: &strengths.springs };
        let flexion =
            strengths.flexion.as_ref().filter(|_| explicit.flexion > 0.0).map(|flexion| Pulls {
                table: &flexion.table,
                rest: &flexion.rest,
                constant: &flexion.constants,
            });
        let pulls = explicit.thread > 0.0 || explicit.shear > 0.0;
        isa.run_transposing(GatherForces {
            springs: [pulls.then_some(springs), flexion],
            bent: bends.then_some((flat, curved)),
            gravity,
            places: &self.places,
            a,
        });
    }

    /// Damping, in the two steps that it takes on a lattice.
    pub fn add_damping(
        &mut self,
        isa: Isa,
        graph: &Graph,
        strengths: &GraphStiffness,
        form: DampingForm,
        half: Kick,
        state: &State,
        a: &mut Soa,
    ) {
        let springs = Damped {
            table: &graph.springs,
            constant: &strengths.damping,
            rate: 1.0 / state.unit,
            form,
        };
        let Self { places, predicted, .. } = self;
        let gain = half.gain * state.unit;
        let target = Target::Predict { keep: half.decay, gain, a, predicted };
        isa.run_transposing(GatherDamping { springs, places, target });
        let target = Target::Accelerations { predicted, a };
        isa.run_transposing(GatherDamping { springs, places, target });
    }

    /// Corrects springs one batch after the other. `touches` tells whether any particle lies on a collider.
    pub fn correct_springs(&mut self, isa: Isa, graph: &Graph, rule: Rule, touches: bool) {
        let (structural, shear) = match rule {
            Rule::Shear { .. } => (false, true),
            Rule::Limit { shear, .. } => (true, shear),
        };
        let families = [(structural, &graph.structural_pairs), (shear, &graph.shear_pairs)];
        for (_, pairs) in families.into_iter().filter(|&(wanted, _)| wanted) {
            isa.run_transposing(CorrectPairs { pairs, rule, touches, places: &mut self.places });
        }
    }

    /// Solves the chains. Tells whether any spring came to them beyond its limit.
    pub fn solve_chains(&mut self, isa: Isa, graph: &Graph, reach: Reach, touches: bool) -> bool {
        isa.run_transposing(SolveChains {
            touches,
            chains: &graph.chains,
            reach,
            places: &mut self.places,
            line: &mut self.line,
            inverse_mass: &mut self.inverse_mass,
        })
    }
}

/// The largest strain of a structural spring.
pub(crate) fn largest_strain(isa: Isa, graph: &Graph, x: &Soa) -> f32 {
    isa.run(LargestStrain { pairs: &graph.structural_pairs, x })
}
