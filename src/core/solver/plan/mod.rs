//! The stability bound, and what follows from it: substeps, springs or threads, clamped constants.
//!
//! An explicit step h is stable while `h < 2 / omega_max`. The flat sheet's `omega_max` is not safe:
//! a folded sheet blows up below it. The bound used here holds in every configuration, as the Hessian
//! of a spring never exceeds its constant: the largest eigenvalue of the weighted graph Laplacian.

pub(crate) mod graph_stiffness;

use core::fmt;

use crate::solver::constraints::pins::Held;
use crate::solver::forces::bending::Hinges;
use crate::solver::forces::springs::SpringConstants;
use crate::solver::settings::{Bending, FormChoice, Material, Settings, Substeps};
use crate::solver::topology::Topology;
use crate::solver::topology::graph::Demand;
use crate::solver::topology::lattice::{Lattice, MassLumping};

/// Part of the stable range of `h^2 omega^2 / 4` that is used.
const SAFETY: f32 = 0.9;
/// Part of that range which bending may take, and shear springs may take, before they are clamped.
const SHARE: f32 = 0.25;
/// Fewest substeps in 1/60 s that the automatic choice takes: contact and pins want some.
const FEWEST: f32 = 4.0;
/// Gravity that a cloth is expected to hang under, before any is given \[m/s2\].
const USUAL_GRAVITY: f32 = 9.81;
/// Curvature at which flexion springs resist as much as the flexural rigidity says \[1/m\].
const FLEXION_CURVATURE: f32 = 20.0;

/// How threads are held together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Form {
    /// Explicit springs, then Provot's correction.
    Springs,
    /// Each thread solved whole.
    Threads,
}

/// Why a form was taken.
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

/// What the solver makes of a material, settings and a tick's length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Springs or threads.
    pub form: Form,
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
    /// Constant of the threads in use \[N/m\].
    pub thread_stiffness: f32,
    /// Constant of the shear springs in use \[N/m\].
    pub shear_stiffness: f32,
    /// Flexural rigidity in use \[N m\].
    pub flexural_rigidity: f32,
    /// Spring damping in use \[N s/m\].
    pub damping: f32,
    /// Whether the limit of strain carries the cloth, as its springs stretch beyond it.
    pub(super) gives: bool,
    /// The tick it was made for \[s\].
    pub(super) tick: f32,
    /// Constants of the explicit springs.
    pub(super) explicit: SpringConstants,
    /// Rigidity of the second-difference hinges \[N m\]; 0 where flexion springs stand in.
    pub(super) hinge_rigidity: f32,
    /// What a graph makes the constants of its springs of.
    pub(super) demand: Demand,
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let form = match self.form {
            Form::Springs => "springs",
            Form::Threads => "threads",
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
    /// Plans ticks of `tick` seconds, for a cloth that weighs as much as `hung` kilograms for each metre
    /// of its width.
    pub(super) fn new(
        bound: &Bound,
        material: &Material,
        settings: &Settings,
        hung: f32,
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
        let budget = match settings.substeps {
            Substeps::Automatic { budget } => in_proportion(budget as f32, tick),
            Substeps::Fixed(count) => count,
        };
        let needed = substeps_for(bound.rate(&asked), tick);
        let gives = material.thread_stiffness * material.max_strain < hung * USUAL_GRAVITY;
        let (form, reason) = match settings.form {
            FormChoice::Springs => (Form::Springs, PlanReason::Asked),
            FormChoice::Threads => (Form::Threads, PlanReason::Asked),
            FormChoice::Automatic if gives => (Form::Threads, PlanReason::SpringsGive),
            FormChoice::Automatic if needed <= budget => {
                (Form::Springs, PlanReason::SpringsSuffice)
            }
            FormChoice::Automatic => (Form::Threads, PlanReason::SpringsNeed(needed)),
        };
        let substeps = match (settings.substeps, form) {
            // What Provot's correction leaves of the excess goes by the square of the substep.
            (Substeps::Automatic { .. }, Form::Springs) if !gives => {
                needed.max(in_proportion(FEWEST, tick)).min(budget)
            }
            _ => budget,
        };
        Self { gives, ..Self::with(bound, material, asked, form, reason, substeps, tick) }
    }

    fn with(
        bound: &Bound,
        material: &Material,
        asked: Constants,
        form: Form,
        reason: PlanReason,
        substeps: u32,
        tick: f32,
    ) -> Self {
        let step = tick / substeps as f32;
        let stable = 4.0 * SAFETY / (step * step);
        let explicit = match form {
            Form::Springs => asked,
            // Threads and their shear are corrected, not pulled.
            Form::Threads => Constants { thread: 0.0, shear: 0.0, ..asked },
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
        let (thread_stiffness, shear_stiffness) = match form {
            Form::Springs => (used.thread, used.shear),
            Form::Threads => (asked.thread, asked.shear),
        };
        Self {
            form,
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
            tick,
            explicit: SpringConstants {
                thread: used.thread,
                shear: used.shear,
                flexion: used.flexion,
            },
            hinge_rigidity: used.bend,
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

/// Constants of explicit forces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Constants {
    pub thread: f32,
    pub shear: f32,
    pub bend: f32,
    pub flexion: f32,
}

/// Squared frequencies that a lattice's explicit forces reach at most, for constants of one.
#[derive(Clone, Debug)]
pub(super) enum Bound {
    /// A sheet of equal rectangles: the corners of the Brillouin zone, where the symbol of the graph
    /// Laplacian and of second-difference bending are largest.
    Uniform {
        /// 1 / mass of an inner particle \[1/kg\].
        inverse_mass: f32,
        /// Shape factors of weft and warp springs, of shear springs, and of hinges.
        weft: f32,
        warp: f32,
        shear: f32,
        bend: [f32; 2],
        flexion: [f32; 2],
    },
    /// Any other lattice: Gershgorin's circles, an entry a particle.
    Circles(Vec<Circle>),
    /// A graph: the same, and each particle's springs are lowered by themselves.
    Graph(Vec<Circle>),
}

/// Row sums of one particle, over its mass.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Circle {
    pub thread: f32,
    pub shear: f32,
    pub bend: f32,
    pub flexion: f32,
}

/// Parts of a particle's constants that the substeps carry.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shares {
    pub thread: f32,
    pub shear: f32,
    pub bending: f32,
    pub damping: f32,
}

impl Shares {
    pub const WHOLE: Self = Self { thread: 1.0, shear: 1.0, bending: 1.0, damping: 1.0 };
}

impl Circle {
    fn rate(&self, k: &Constants) -> f32 {
        k.thread * self.thread
            + k.shear * self.shear
            + k.bend * self.bend
            + k.flexion * self.flexion
    }

    /// Lowers the constants of one particle as [`Bound::clamp`] does those of all.
    pub fn shares(&self, asked: &Constants, stable: f32) -> Shares {
        if self.rate(asked) <= stable {
            return Shares::WHOLE;
        }
        let part = if asked.thread + asked.shear > 0.0 { SHARE } else { 1.0 };
        let bending = asked.bend * self.bend + asked.flexion * self.flexion;
        let (shear, thread) = (asked.shear * self.shear, asked.thread * self.thread);
        // A quotient by zero is infinite: the whole.
        let lowered = |rate: f32, to: f32| (to / rate).min(1.0);
        let shares = (lowered(bending, part * stable), lowered(shear, part * stable));
        let left = (stable - bending * shares.0 - shear * shares.1).max(0.0);
        Shares { thread: lowered(thread, left), shear: shares.1, bending: shares.0, damping: 1.0 }
    }
}

impl Bound {
    pub fn new(topology: &Topology, held: &Held) -> Self {
        let (hinges, inverse_mass) = (&held.hinges, &held.inverse_mass);
        match topology {
            Topology::Lattice(lattice) if lattice.uniform => {
                Self::uniform(lattice, hinges, inverse_mass)
            }
            Topology::Lattice(lattice) => Self::circles(lattice, hinges, inverse_mass),
            Topology::Graph(graph) => {
                let strengths = held.strengths.as_ref();
                Self::Graph(strengths.map_or(Vec::new(), |s| s.circles(graph, inverse_mass)))
            }
        }
    }

    fn uniform(lattice: &Lattice, hinges: &[Hinges; 2], inverse_mass: &[f32]) -> Self {
        let largest = |values: &[f32]| values.iter().copied().fold(0.0, f32::max);
        let (a, b) = (largest(&lattice.weft.rest), largest(&lattice.warp.rest));
        let free = lattice.layout.slots().find(|&slot| inverse_mass[slot] > 0.0);
        let inverse_mass = free.map_or(0.0, |slot| match lattice.lumping {
            // Half masses go with half springs, so that the inner particle is the measure.
            MassLumping::Lumped => inverse_mass[slot] * lattice.area[slot] / (a * b),
            MassLumping::Equal => inverse_mass[slot],
        });
        let bend = [(0, a), (1, b)].map(|(i, l)| {
            // Clamped hinges count double, but only towards their one free end.
            let shape = if i == 0 { b / a } else { a / b };
            if largest(&hinges[i].shape) > 0.0 { shape / (l * l) } else { 0.0 }
        });
        Self::Uniform {
            inverse_mass,
            // Of an inner spring: in a sheet of two rows all are on the border.
            weft: b / a,
            warp: a / b,
            shear: largest(&lattice.diagonal.shape),
            bend,
            flexion: [b / (a * a * a * a * a), a / (b * b * b * b * b)],
        }
    }

    fn circles(lattice: &Lattice, hinges: &[Hinges; 2], inverse_mass: &[f32]) -> Self {
        let s = lattice.layout.stride;
        let circle = |slot: usize| {
            let w = inverse_mass[slot];
            let (weft, warp, shear) =
                (&lattice.weft.shape, &lattice.warp.shape, &lattice.diagonal.shape);
            let thread = weft[slot] + weft[slot - 1] + warp[slot] + warp[slot - s];
            let flex = |family: &crate::solver::topology::lattice::Family, step: usize| {
                let spring = |first: usize| {
                    let cell = family.rest[first] * family.rest[first + step];
                    if cell > 0.0 { family.shape[first] / (cell * cell) } else { 0.0 }
                };
                spring(slot) + spring(slot - 2 * step)
            };
            Circle {
                thread: 2.0 * w * thread,
                shear: 2.0
                    * w
                    * (shear[slot] + shear[slot - s - 1] + shear[slot - 1] + shear[slot - s]),
                bend: w * (hinges[0].row_sum(slot) + hinges[1].row_sum(slot)),
                flexion: 2.0 * w * (flex(&lattice.weft, 1) + flex(&lattice.warp, s)),
            }
        };
        Self::Circles(lattice.layout.slots().map(circle).collect())
    }

    /// The bound on `omega^2` \[1/s2\].
    pub fn rate(&self, k: &Constants) -> f32 {
        match self {
            Self::Uniform { inverse_mass, weft, warp, shear, bend, flexion } => {
                let along_weft = 4.0 * k.thread * weft + 16.0 * k.bend * bend[0];
                let along_warp = 4.0 * k.thread * warp + 16.0 * k.bend * bend[1];
                let diagonal = 8.0 * k.shear * shear;
                let highest =
                    (along_weft + along_warp).max(along_weft + diagonal).max(along_warp + diagonal);
                (highest + 4.0 * k.flexion * (flexion[0] + flexion[1])) * inverse_mass
            }
            Self::Circles(circles) | Self::Graph(circles) => {
                circles.iter().map(|circle| circle.rate(k)).fold(0.0, f32::max)
            }
        }
    }

    /// Lowers the constants until the bound is at most `stable`: bending and shear to their share,
    /// each by itself, and the threads to what is left. Bending alone may take all.
    fn clamp(&self, asked: Constants, stable: f32) -> Constants {
        if self.rate(&asked) <= stable {
            return asked;
        }
        let none = Constants::default();
        if let Self::Graph(circles) = self {
            return mean(circles, asked, stable);
        }
        let part = if asked.thread + asked.shear > 0.0 { SHARE } else { 1.0 };
        let share = |only: Constants| (part * stable / self.rate(&only)).min(1.0);
        let bending = share(Constants { bend: asked.bend, flexion: asked.flexion, ..none });
        let shear = share(Constants { shear: asked.shear, ..none });
        let mut used = Constants {
            thread: 0.0,
            shear: asked.shear * shear,
            bend: asked.bend * bending,
            flexion: asked.flexion * bending,
        };
        // What is left of it may be less than nothing by rounding.
        let left = (stable - self.rate(&used)).max(0.0);
        let thread = (left / self.rate(&Constants { thread: asked.thread, ..none })).min(1.0);
        used.thread = asked.thread * thread;
        used
    }
}

/// The constants that particles have in the mean, where each has what the substeps carry.
fn mean(circles: &[Circle], asked: Constants, stable: f32) -> Constants {
    let mut sums = [0.0_f64; 3];
    // Neither what is held nor what stands beside the cloth has springs to lower.
    let moving = || circles.iter().filter(|circle| circle.rate(&asked) > 0.0);
    for shares in moving().map(|circle| circle.shares(&asked, stable)) {
        for (sum, share) in sums.iter_mut().zip([shares.thread, shares.shear, shares.bending]) {
            *sum += f64::from(1.0 - share);
        }
    }
    let [thread, shear, bending] = sums.map(|sum| {
        let lost = (sum / moving().count().max(1) as f64) as f32;
        // That of a few in many particles shows all the same.
        if sum > 0.0 { (1.0 - lost).min(1.0 - f32::EPSILON) } else { 1.0 }
    });
    Constants {
        thread: asked.thread * thread,
        shear: asked.shear * shear,
        bend: asked.bend * bending,
        flexion: asked.flexion * bending,
    }
}
