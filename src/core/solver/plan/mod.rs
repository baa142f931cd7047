//! The stability bound, and what follows from it: substeps, springs or threads, clamped constants.
//!
//! An explicit step h is stable while `h < 2 / omega_max`. The flat sheet's `omega_max` is not safe:
//! a folded sheet blows up below it. The bound used here holds in every configuration, as the Hessian
//! of a spring never exceeds its constant: the largest eigenvalue of the weighted graph Laplacian.

pub(crate) mod graph_stiffness;
pub(crate) mod stability;

use core::fmt;

use crate::solver::forces::families::Constants;
use crate::solver::plan::graph_stiffness::Demand;
use crate::solver::plan::stability::{Bound, SAFETY};
use crate::solver::settings::{Bending, Material, Settings, StretchMethod, Stretching, Substeps};

/// Fewest substeps in 1/60 s that the automatic choice takes: contact and pins want some.
const FEWEST: u32 = 4;
/// Gravity that a cloth is expected to hang under, before any is given \[m/s2\].
const USUAL_GRAVITY: f32 = 9.81;
/// Curvature at which flexion springs resist as much as the flexural rigidity says \[1/m\].
const FLEXION_CURVATURE: f32 = 20.0;

/// Why a method was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanReason {
    /// The settings ask for it.
    Asked,
    /// Explicit springs carry the stiffness within the budget.
    SpringsSuffice,
    /// Explicit springs would need this many substeps.
    SpringsNeed(u32),
    /// Hung from a side, explicit springs would stretch beyond the limit of strain: it is not they that
    /// carry the cloth.
    SpringsGive,
}

/// Which constants are lower than asked for, as the substeps carry no more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clamped {
    /// Structural springs.
    pub thread: bool,
    /// Shear springs.
    pub shear: bool,
    /// Bending.
    pub bending: bool,
    /// Spring damping.
    pub damping: bool,
}

/// The method, substeps and constants that follow from a material, settings and a tick's length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Springs or threads.
    pub stretching: Stretching,
    /// Why.
    pub reason: PlanReason,
    /// Substeps in a tick.
    pub substeps: u32,
    /// Substep \[s\].
    pub step: f32,
    /// `h^2 omega_max^2 / 4` of the explicit forces: stable below 1, kept at or below 0.9.
    pub margin: f32,
    /// Which constants are lower than asked for.
    pub clamped: Clamped,
    /// Substeps that the layers of a cloth need which collides with itself or others; more where they touch. An automatic number of substeps
    /// is not below it.
    pub layers: u32,
    /// Substeps that bodies need which come to a pinned cloth fast, until it has caught them; 0 where the budget has as many. An automatic number of
    /// substeps is not below it.
    pub bodies: u32,
    /// Constant of the threads in use \[N/m\].
    pub thread_stiffness: f32,
    /// Constant of the shear springs in use \[N/m\].
    pub shear_stiffness: f32,
    /// Flexural rigidity in use \[N m\].
    pub flexural_rigidity: f32,
    /// Spring damping in use \[N s/m\].
    pub damping: f32,
    /// Whether the limit of strain carries the cloth, as its springs stretch beyond it.
    pub(crate) gives: bool,
    /// Substeps that it would have if the cloth were not stepped together with others.
    pub(crate) alone: u32,
    /// The tick and the cloth that it was made for \[s\].
    pub(crate) tick: f32,
    pub(crate) cloth: PlannedCloth,
    /// Constants of the explicit forces. Either of hinges and flexion springs stands in for the other.
    pub(crate) explicit: Constants,
    /// The demand that a graph makes the constants of its springs from.
    pub(crate) demand: Demand,
}

/// Facts of a cloth that a plan depends on, besides its material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlannedCloth {
    /// Mass for each metre of its width \[kg/m\].
    pub hung: f32,
    /// Substeps in 1/60 s that its layers need, where it touches itself or others.
    pub layers: u32,
    /// Substeps in 1/60 s that bodies need which come to it fast.
    pub bodies: u32,
    /// Substeps of the tick at least, where it is stepped together with others.
    pub at_least: u32,
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let form = match self.stretching {
            Stretching::ExplicitSprings => "springs",
            Stretching::ImplicitThreads => "threads",
        };
        write!(f, "{form}, {} substeps of {:.3} ms", self.substeps, self.step * 1e3)?;
        match self.reason {
            PlanReason::Asked => write!(f, " (as set)")?,
            PlanReason::SpringsSuffice => write!(f, " (explicit springs carry the stiffness)")?,
            PlanReason::SpringsNeed(n) => write!(f, " (explicit springs would need {n})")?,
            PlanReason::SpringsGive => {
                write!(f, " (explicit springs would stretch beyond the limit)")?;
            }
        }
        write!(f, ", stability {:.2} of 1", self.margin)?;
        if self.layers > 0 {
            write!(f, ", layers need {}", self.layers)?;
        }
        if self.bodies > 0 {
            write!(f, ", bodies need {}", self.bodies)?;
        }
        let Clamped { thread, shear, bending, damping } = self.clamped;
        for (clamped, name) in
            [(thread, "threads"), (shear, "shear"), (bending, "bending"), (damping, "damping")]
        {
            if clamped {
                write!(f, ", {name} clamped")?;
            }
        }
        Ok(())
    }
}

impl Plan {
    /// Plans ticks of `tick` seconds.
    pub(crate) fn new(
        bound: &Bound,
        material: &Material,
        settings: &Settings,
        cloth: PlannedCloth,
        tick: f32,
    ) -> Self {
        let (bend, flexion) = match settings.bending {
            Bending::SecondDifference => (material.flexural_rigidity, 0.0),
            Bending::Flexion => (0.0, flexion_constant(material.flexural_rigidity)),
        };
        let asked = Constants {
            thread: material.thread_stiffness,
            shear: material.shear_stiffness,
            bend,
            flexion,
        };
        // Bodies come and go, and decide nothing but how many substeps there are.
        let contact = cloth.layers.max(cloth.bodies);
        let [own, budget] = match settings.substeps {
            Substeps::Automatic { budget } => [cloth.layers, contact]
                .map(|contact| in_proportion(budget.max(contact) as f32, tick)),
            Substeps::Fixed(count) => [count; 2],
        };
        let needed = substeps_for(bound.rate(&asked), tick);
        let gives = material.thread_stiffness * material.max_strain < cloth.hung * USUAL_GRAVITY;
        let (stretching, reason) = match settings.stretch_method {
            StretchMethod::ExplicitSprings => (Stretching::ExplicitSprings, PlanReason::Asked),
            StretchMethod::ImplicitThreads => (Stretching::ImplicitThreads, PlanReason::Asked),
            StretchMethod::Automatic if gives => {
                (Stretching::ImplicitThreads, PlanReason::SpringsGive)
            }
            StretchMethod::Automatic if needed <= own => {
                (Stretching::ExplicitSprings, PlanReason::SpringsSuffice)
            }
            StretchMethod::Automatic => {
                (Stretching::ImplicitThreads, PlanReason::SpringsNeed(needed))
            }
        };
        let substeps = match (settings.substeps, stretching) {
            // What Provot's correction leaves of the excess goes by the square of the substep.
            (Substeps::Automatic { .. }, Stretching::ExplicitSprings) if !gives => {
                needed.max(in_proportion(FEWEST.max(contact) as f32, tick)).min(budget)
            }
            _ => budget,
        };
        let alone = substeps;
        let substeps = substeps.max(cloth.at_least);
        let of_tick = |needed: u32| if needed > 0 { in_proportion(needed as f32, tick) } else { 0 };
        Self {
            gives,
            layers: of_tick(cloth.layers),
            bodies: of_tick(cloth.bodies),
            alone,
            cloth,
            ..Self::with(bound, material, asked, stretching, reason, substeps, tick)
        }
    }

    fn with(
        bound: &Bound,
        material: &Material,
        asked: Constants,
        stretching: Stretching,
        reason: PlanReason,
        substeps: u32,
        tick: f32,
    ) -> Self {
        let step = tick / substeps as f32;
        let stable = 4.0 * SAFETY / (step * step);
        let explicit = match stretching {
            Stretching::ExplicitSprings => asked,
            // Threads and their shear are corrected, not pulled.
            Stretching::ImplicitThreads => Constants { thread: 0.0, shear: 0.0, ..asked },
        };
        let used = bound.clamp(explicit, stable);
        let highest = match bound {
            Bound::Graph(_) => bound.rate(&explicit).min(stable),
            _ => bound.rate(&used),
        };
        let rate = bound.rate(&Constants {
            thread: material.damping,
            shear: if asked.shear > 0.0 { material.damping } else { 0.0 },
            ..Constants::default()
        });
        let damping = match bound {
            Bound::Graph(_) => material.damping,
            _ => material.damping * (1.0 / (rate * step)).min(1.0),
        };
        // Threads are solved with the stiffness asked for.
        let (thread_stiffness, shear_stiffness) = match stretching {
            Stretching::ExplicitSprings => (used.thread, used.shear),
            Stretching::ImplicitThreads => (asked.thread, asked.shear),
        };
        Self {
            stretching,
            reason,
            substeps,
            step,
            margin: highest * step * step / 4.0,
            clamped: Clamped {
                thread: used.thread < explicit.thread,
                shear: used.shear < explicit.shear,
                bending: used.bend < explicit.bend || used.flexion < explicit.flexion,
                damping: material.damping > 0.0 && rate * step > 1.0,
            },
            thread_stiffness,
            shear_stiffness,
            flexural_rigidity: if used.bend + used.flexion > 0.0 {
                material.flexural_rigidity * (used.bend + used.flexion)
                    / (explicit.bend + explicit.flexion)
            } else {
                0.0
            },
            damping,
            gives: false,
            layers: 0,
            bodies: 0,
            alone: substeps,
            tick,
            cloth: PlannedCloth { hung: 0.0, layers: 0, bodies: 0, at_least: 0 },
            explicit: used,
            demand: Demand {
                asked: explicit,
                stable,
                damping: [material.damping, if asked.shear > 0.0 { material.damping } else { 0.0 }],
                stable_damping: 1.0 / step,
            },
        }
    }
}

/// Substeps of a tick, from a number in 1/60 s.
fn in_proportion(in_a_frame: f32, tick: f32) -> u32 {
    (in_a_frame * tick * 60.0 - 1e-3).ceil().clamp(1.0, Settings::MAX_SUBSTEPS as f32) as u32
}

fn substeps_for(rate: f32, tick: f32) -> u32 {
    let steps = (tick * (rate / (4.0 * SAFETY)).sqrt()).ceil();
    // A float too large for u32 becomes the largest.
    (steps as u32).max(1)
}

/// The flexion springs of a chain of cells of side a store `k a^2 phi^4 / 32` in a hinge of angle phi, as they are
/// shorter than two cells by `a phi^2 / 4`: for a curvature kappa a moment `k a^5 kappa^3 / 8`. They give the moment `B kappa` of the
/// rigidity at one curvature: `k a^5 = 8 B / kappa^2` for each unit of width.
fn flexion_constant(rigidity: f32) -> f32 {
    8.0 * rigidity / (FLEXION_CURVATURE * FLEXION_CURVATURE)
}
