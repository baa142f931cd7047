//! The differences of sheets and meshes: the constants of their springs and hinges, and what the stages of a substep
//! do with them. All else is the same for both, and in `stages`.
//!
//! | | rest shape | its particles | its threads |
//! | --- | --- | --- | --- |
//! | [`Sheet`] | [`Lattice`](crate::solver::Lattice) | rows of blocks | weft and warp |
//! | [`Mesh`] | [`Graph`](crate::solver::Graph) | gathered by index | chains of edges |

pub(crate) mod mesh;
pub(crate) mod sheet;

use bevy_math::Vec3;

use crate::solver::constraints::pins::Pins;
use crate::solver::constraints::strain_check::{Limit, Since};
use crate::solver::constraints::strain_limit::Rule;
use crate::solver::constraints::threads::shifts::Shifting;
use crate::solver::constraints::threads::tridiagonal::Reach;
use crate::solver::forces::external::Pushes;
use crate::solver::integrate::houbolt::Filter;
use crate::solver::integrate::verlet::Kick;
use crate::solver::model::mesh::Mesh;
use crate::solver::model::sheet::Sheet;
use crate::solver::plan::Plan;
use crate::solver::plan::stability::Bound;
use crate::solver::settings::{Bending, DampingForm};
use crate::solver::simd::isa::Isa;
use crate::solver::simd::parallel::Bands;
use crate::solver::simd::soa::Soa;
use crate::solver::state::State;
use crate::solver::state::measure::Survey;
use crate::solver::topology::Topology;

/// The model of a cloth: which of the two it is, with its constants and its workspace.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "a cloth has one, and it is not moved")]
pub(crate) enum Model {
    Sheet(Sheet),
    Mesh(Mesh),
}

impl Model {
    /// For a rest shape, nothing held.
    pub fn new(topology: &Topology) -> Self {
        match topology {
            Topology::Lattice(lattice) => Self::Sheet(Sheet::new(lattice.clone())),
            Topology::Graph(graph) => Self::Mesh(Mesh::new(graph.clone())),
        }
    }

    pub fn stages(&self) -> &dyn Stages {
        match self {
            Self::Sheet(sheet) => sheet,
            Self::Mesh(mesh) => mesh,
        }
    }

    pub fn stages_mut(&mut self) -> &mut dyn Stages {
        match self {
            Self::Sheet(sheet) => sheet,
            Self::Mesh(mesh) => mesh,
        }
    }
}

/// The particles that a stage works on, beside the model.
pub(crate) struct Particles<'a> {
    pub isa: Isa,
    pub bands: &'a Bands,
    pub pins: &'a Pins,
    pub state: &'a mut State,
}

/// Forces, plan and settings that act on the particles in a substep.
pub(crate) struct Acting<'a> {
    pub plan: &'a Plan,
    pub damping_form: DampingForm,
    /// From the middle of the last substep to its end: what predicts the velocity of this instant, for the damping.
    pub half_kick: Kick,
    /// \[m/s2\]
    pub gravity: Vec3,
    pub pushes: Option<&'a Pushes>,
}

/// How shear springs are corrected in a substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shearing {
    /// Whether the substep ends a tick: then the multipliers are noted that shifts are made of.
    pub ends_tick: bool,
    /// Whether those of a sheet are solved along whole diagonals, even where a pass over the cells would bear them: it stands for
    /// too little where the cloth carries anything.
    pub whole: bool,
}

/// The stages of a substep that are different on a sheet and on a mesh, and what they need beforehand.
pub(crate) trait Stages {
    /// Makes what depends on which slots are held.
    fn hold(&mut self, held: &[bool]);
    /// The bound on the frequencies of its explicit forces.
    fn bound(&self, inverse_mass: &[f32]) -> Bound;
    /// Makes what a form of bending needs, and what friction of bending does where there is any.
    fn bend(&mut self, bending: Bending, rubs: bool);
    /// Takes over the constants that a plan chose.
    fn follow(&mut self, plan: &Plan, bound: &Bound);
    /// How a substep's corrections are carried on to the next ones (`integrate::houbolt`), of a cloth that touches colliders or does
    /// not; `None` where they are not.
    fn filter(&self, touches: bool) -> Option<Filter>;

    /// First stage: slows what bends by friction. Takes no more than `part` of a motion, nor more than `most`
    /// of displacement of a mass of one \[kg m\].
    fn brake_bending(&mut self, on: Particles<'_>, part: f32, most: f32);
    /// First stage: accelerations by springs, bending, damping, gravity and loads from outside.
    fn accelerate(&mut self, on: Particles<'_>, acting: &Acting<'_>, a: &mut Soa);

    /// Begins the third stage.
    fn begin_corrections(&mut self, on: Particles<'_>);
    /// Third stage: shear springs of a finite compliance.
    fn correct_shear(&mut self, on: Particles<'_>, reach: Reach, how: Shearing);
    /// Third stage: solves the threads. Tells whether any spring came to them beyond its limit: where none did, none
    /// has to be held to it. Notes the multipliers that shifts are made of, where the substep ends a tick.
    fn solve_threads(&mut self, on: Particles<'_>, reach: Reach, ends_tick: bool) -> bool;
    /// Whether threads leave so much to do that springs may be beyond their limit where none came to them so.
    fn leaves_much(&self) -> bool;
    /// Ends a tick: shifts springs that threads leave too long (`constraints::threads::shifts`).
    fn shift_springs(&mut self, on: Particles<'_>, shifting: Shifting);
    /// Shifts \[m\]; none where no spring is shifted.
    fn shifts(&self) -> Vec<f32>;
    /// Puts shifts back, or takes all away where there are none, or those of other springs.
    fn set_shifts(&mut self, by: &[f32]);
    /// Whether any spring may be beyond the limit. `since` says what has moved particles since the last look, which found some.
    fn exceeds_limit(&mut self, on: Particles<'_>, limit: Limit, since: Since) -> bool;
    /// Third stage: one pass over the springs. Tells whether any may have come beyond its limit.
    fn correct_springs(&mut self, on: Particles<'_>, rule: Rule) -> bool;
    /// Ends the third stage's part that differs.
    fn end_corrections(&mut self, on: Particles<'_>);

    /// Bounds, strain and motion.
    fn survey(&self, isa: Isa, bands: &Bands, state: &State) -> Survey;
}
