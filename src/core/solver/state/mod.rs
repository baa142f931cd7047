//! The state of one cloth, positions and displacements, and the workspace of its stages.

pub(crate) mod measure;
pub(crate) mod mesh;

use bevy_math::Vec3;

use crate::solver::constraints::shear::RowPulls;
use crate::solver::constraints::threads;
use crate::solver::contact::{ActiveSet, BroadPhase};
use crate::solver::forces::bending::Moments;
use crate::solver::forces::bending_friction::Brakes;
use crate::solver::forces::spring_rows::SpringRows;
use crate::solver::integrate::explicit::ExplicitWorkspace;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::parallel::{Band, Bands, Seams, Workspaces};
use crate::solver::simd::soa::{Array, Soa};
use crate::solver::state::mesh::MeshWorkspace;
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
    /// What corrections add to displacements in a substep \[m\], see `integrate::houbolt`; of those that are held,
    /// anything.
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
    /// What lay on colliders in the last substep.
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
            contacts: ActiveSet::new(layout.len()),
        }
    }

    /// Moves the origin to a cloth that has left it. The shift is exact in f32.
    pub fn follow(&mut self, layout: Layout, centre: Vec3) {
        if centre.abs().max_element() <= Self::REACH {
            return;
        }
        let shift = on_grid(centre);
        self.origin += shift;
        for slot in layout.slots() {
            self.x.set(slot, self.x.get(slot) - shift);
            self.start.set(slot, self.start.get(slot) - shift);
        }
    }
}

fn on_grid(p: Vec3) -> Vec3 {
    (p / State::GRID).round() * State::GRID
}

/// Room that the stages work in; nothing in it outlives a tick.
#[derive(Clone, Debug)]
pub(crate) struct Workspace {
    /// Accelerations \[m/s2\], where they differ between particles.
    pub a: Soa,
    /// Forces of a lattice's springs, while a row is worked on.
    pub rows: Workspaces<SpringRows>,
    /// Moments of the hinges.
    pub moments: Workspaces<Moments>,
    /// Pulls of a lattice's shear springs.
    pub row_pulls: Workspaces<RowPulls>,
    /// What a lattice's threads are solved in.
    pub threads: Workspaces<threads::ThreadWorkspace>,
    /// Displacements of the rows on both sides of each cut.
    pub seams: Seams,
    /// Displacements of columns, where they are solved apart from each other.
    pub apart: Soa,
    /// What is borne by what particles of such columns lie on.
    pub load_apart: Array,
    /// Displacements predicted for the damping.
    pub b: Soa,
    /// Room for braking a lattice's bending.
    pub brakes: Brakes,
    /// What only a graph's stages work in.
    pub graph: Option<MeshWorkspace>,
    /// What the integrators for study work in, where one is chosen.
    pub study: Option<ExplicitWorkspace>,
    /// Whether corrections are carried on in this tick.
    pub carries: bool,
    /// What contact remembers within a tick.
    pub broad_phase: BroadPhase,
}

impl Workspace {
    /// For a cloth of so many edges, where these are held.
    pub fn new(topology: &Topology, edges: Option<usize>) -> Self {
        let layout = topology.layout();
        let len = layout.len();
        // What only a lattice's threads and hinges work in.
        let woven = topology.as_lattice().map_or(Layout::one_row(0), |lattice| lattice.layout);
        let bands = Bands::new(woven, true);
        let count = bands.rows.count();
        let is_apart = bands.columns.count() > 1;
        let apart = if is_apart { woven.columns.next_multiple_of(LANES) * woven.rows } else { 0 };
        Self {
            a: Soa::zeros(len),
            b: Soa::zeros(len),
            brakes: Brakes::new(topology.as_lattice().map_or(0, |_| len)),
            rows: Workspaces::new(count, || SpringRows::new(woven)),
            moments: Workspaces::new(count, || Moments::new(woven)),
            row_pulls: Workspaces::new(count, || RowPulls::new(woven.columns)),
            threads: Workspaces::new(bands.most(), || threads::ThreadWorkspace::new(woven)),
            apart: Soa::zeros(apart),
            load_apart: Array::zeros(apart),
            graph: topology.as_graph().map(|graph| MeshWorkspace::new(graph)),
            study: None,
            carries: false,
            broad_phase: BroadPhase::new(&Band::all(layout), edges),
            seams: Seams::new(bands.rows),
        }
    }
}

impl State {
    /// Something moves a particle while pulls are noted that is none of them.
    pub(crate) fn leave_out(&mut self, slot: usize, moved: Vec3) {
        self.pull.set(slot, self.pull.get(slot) - moved);
    }
}
