//! The state of one cloth, positions and displacements, and the workspace of its stages.

pub(crate) mod carrying;
pub(crate) mod measure;
pub(crate) mod striking;

use bevy_math::Vec3;

use crate::solver::contact::{ActiveSet, BroadPhase, Edges};
use crate::solver::integrate::explicit::ExplicitWorkspace;
use crate::solver::integrate::houbolt::Filter;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::parallel::Band;
use crate::solver::simd::soa::Soa;
use crate::solver::state::carrying::Carrying;
use crate::solver::state::striking::Striking;
use crate::solver::topology::Topology;

/// Positions and displacements. Padding stays at zero.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// Where the cloth's own coordinates begin, in world space \[m\]: a multiple of 1/16 m, so that
    /// moving it by such multiples changes no bit of what the positions mean.
    pub origin: Vec3,
    /// Positions where the substep began, relative to the origin \[m\].
    pub x: Soa,
    /// Displacements of the substep \[m\]: velocity at its middle, times `unit`. Integration sets them
    /// and corrections add to them, at a precision of their own; the substep's end adds them to the
    /// positions. So a velocity changes by computed corrections, never by a difference of rounded
    /// positions.
    pub d: Soa,
    /// Displacements that corrections add in a substep \[m\], see `integrate::houbolt`; arbitrary for held particles.
    pub pull: Soa,
    /// Whether `pull` is that of the last substep.
    pub carries: bool,
    /// The time that makes velocities of displacements \[s\].
    pub unit: f32,
    /// Positions where the tick began \[m\], for blending between ticks.
    pub start: Soa,
    /// Length of the last substep \[s\]; 0 before the first. A velocity is half a substep behind its
    /// position, so that the next kick lasts half of both substeps.
    pub last_step: f32,
    /// Displacement in the substep that an acceleration of one makes \[s2\]: the square of the
    /// substep, less what drag takes. Corrections with a compliance answer forces through it.
    pub response: f32,
    pub carrying: Carrying,
    pub striking: Striking,
    /// Particles that lay on colliders in the last substep.
    pub contacts: ActiveSet,
}

impl State {
    /// The origin follows a cloth by multiples of this \[m\].
    const GRID: f32 = 16.0;
    /// The origin follows a cloth that has gone this far from it \[m\].
    const REACH: f32 = 64.0;

    pub fn new(topology: &Topology, positions: &[Vec3]) -> Self {
        let layout = topology.layout();
        let centre = positions.iter().copied().sum::<Vec3>() / positions.len() as f32;
        let origin = on_grid(centre);
        let mut x = Soa::zeros(layout.len());
        for (particle, &p) in positions.iter().enumerate() {
            x.set(topology.slot(particle), p - origin);
        }
        Self {
            origin,
            d: Soa::zeros(layout.len()),
            pull: Soa::zeros(layout.len()),
            carries: false,
            unit: 1.0,
            start: x.clone(),
            x,
            last_step: 0.0,
            response: 0.0,
            carrying: Carrying::NOTHING,
            striking: Striking::NONE,
            contacts: ActiveSet::new(layout.len()),
        }
    }

    /// Moves the origin to a cloth that has left it, and tells whether it did. The shift is exact in f32.
    pub fn follow(&mut self, layout: Layout, centre: Vec3) -> bool {
        if centre.abs().max_element() <= Self::REACH {
            return false;
        }
        let shift = on_grid(centre);
        self.origin += shift;
        for slot in layout.slots() {
            self.x.set(slot, self.x.get(slot) - shift);
            self.start.set(slot, self.start.get(slot) - shift);
        }
        true
    }
}

fn on_grid(p: Vec3) -> Vec3 {
    (p / State::GRID).round() * State::GRID
}

/// Room that the stages work in, of sheets and meshes alike; nothing in it outlives a tick.
#[derive(Clone, Debug)]
pub(crate) struct Workspace {
    /// Accelerations \[m/s2\], where they differ between particles.
    pub a: Soa,
    /// Memory of the integrators for study, where one is chosen.
    pub study: Option<ExplicitWorkspace>,
    /// How corrections are carried on in this tick, if they are.
    pub filter: Option<Filter>,
    /// The substep in which all springs were last looked at for the strain limit, if they were in this tick.
    pub looked: Option<u32>,
    /// Whether the heaviest body that the cloth carries sleeps in this tick.
    pub bears_sleeper: bool,
    /// The memory of contact within a tick.
    pub broad_phase: BroadPhase,
}

impl Workspace {
    /// For a cloth of these edges, where they are held.
    pub fn new(layout: Layout, edges: Option<&Edges>) -> Self {
        Self {
            a: Soa::zeros(layout.len()),
            study: None,
            filter: None,
            looked: None,
            bears_sleeper: false,
            broad_phase: BroadPhase::new(&Band::all(layout), edges),
        }
    }
}

impl State {
    /// Excludes a displacement that is not a correction from the recorded corrections.
    pub(crate) fn leave_out(&mut self, slot: usize, moved: Vec3) {
        self.pull.set(slot, self.pull.get(slot) - moved);
    }
}
