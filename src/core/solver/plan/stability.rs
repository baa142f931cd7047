//! Bounds on the frequencies of explicit forces, and constants that keep below what a substep carries.

use crate::solver::forces::bending::Hinges;
use crate::solver::forces::families::Constants;
use crate::solver::settings::MassLumping;
use crate::solver::topology::lattice::{Family, Lattice};

/// Part of the stable range of `h^2 omega^2 / 4` that is used.
pub(crate) const SAFETY: f32 = 0.9;
/// Part of that range which bending may take, and shear springs may take, before they are clamped.
const SHARE: f32 = 0.25;

/// Squared frequencies that a lattice's explicit forces reach at most, for constants of one.
#[derive(Clone, Debug)]
pub(crate) enum Bound {
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
    Circles(Vec<Constants>),
    /// A graph: the same, and each particle's springs are lowered by themselves.
    Graph(Vec<Constants>),
}

/// Parts of a particle's constants that the substeps carry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shares {
    pub thread: f32,
    pub shear: f32,
    pub bending: f32,
    pub damping: f32,
}

impl Shares {
    pub const WHOLE: Self = Self { thread: 1.0, shear: 1.0, bending: 1.0, damping: 1.0 };

    /// Lowers the constants of one particle as [`Bound::clamp`] does those of all.
    pub fn of(circle: &Constants, asked: &Constants, stable: f32) -> Self {
        if circle.dot(asked) <= stable {
            return Self::WHOLE;
        }
        let part = if asked.thread + asked.shear > 0.0 { SHARE } else { 1.0 };
        let bending = asked.bend * circle.bend + asked.flexion * circle.flexion;
        let (shear, thread) = (asked.shear * circle.shear, asked.thread * circle.thread);
        // A quotient by zero is infinite: the whole.
        let lowered = |rate: f32, to: f32| (to / rate).min(1.0);
        let shares = (lowered(bending, part * stable), lowered(shear, part * stable));
        let left = (stable - bending * shares.0 - shear * shares.1).max(0.0);
        Self { thread: lowered(thread, left), shear: shares.1, bending: shares.0, damping: 1.0 }
    }
}

impl Bound {
    /// Row sums by particle, where they are kept.
    pub fn circles(&self) -> &[Constants] {
        match self {
            Self::Uniform { .. } => &[],
            Self::Circles(circles) | Self::Graph(circles) => circles,
        }
    }

    /// The bound of a sheet with these hinges and inverse masses.
    pub fn of_lattice(lattice: &Lattice, hinges: &[Hinges; 2], inverse_mass: &[f32]) -> Self {
        if lattice.uniform {
            Self::uniform(lattice, hinges, inverse_mass)
        } else {
            Self::of_cells(lattice, hinges, inverse_mass)
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

    fn of_cells(lattice: &Lattice, hinges: &[Hinges; 2], inverse_mass: &[f32]) -> Self {
        let s = lattice.layout.stride;
        let circle = |slot: usize| {
            let w = inverse_mass[slot];
            let (weft, warp, shear) =
                (&lattice.weft.shape, &lattice.warp.shape, &lattice.diagonal.shape);
            let thread = weft[slot] + weft[slot - 1] + warp[slot] + warp[slot - s];
            let flex = |family: &Family, step: usize| {
                let spring = |first: usize| {
                    let cell = family.rest[first] * family.rest[first + step];
                    if cell > 0.0 { family.shape[first] / (cell * cell) } else { 0.0 }
                };
                spring(slot) + spring(slot - 2 * step)
            };
            Constants {
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
                circles.iter().map(|circle| circle.dot(k)).fold(0.0, f32::max)
            }
        }
    }

    /// Lowers the constants until the bound is at most `stable`: bending and shear to their share,
    /// each by itself, and the threads to what is left. Bending alone may take all.
    pub fn clamp(&self, asked: Constants, stable: f32) -> Constants {
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
fn mean(circles: &[Constants], asked: Constants, stable: f32) -> Constants {
    let mut sums = [0.0_f64; 3];
    // Neither what is held nor what stands beside the cloth has springs to lower.
    let moving = || circles.iter().filter(|circle| circle.dot(&asked) > 0.0);
    for shares in moving().map(|circle| Shares::of(circle, &asked, stable)) {
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
