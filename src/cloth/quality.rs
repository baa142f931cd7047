//! Settings by what they are for, read off the report of speed against error.

use bevy::prelude::*;

use crate::cloth::settings::ClothSettings;
use crate::solver::{StretchMethod, Substeps};

/// How much time an error is worth: three settings beside the default, read off the report of speed against
/// error (`assets/report/report.md`).
///
/// The default, `ClothSettings::default()`, takes up to 20 substeps in 1/60 s.
///
/// ```
/// # use bevy_drape::prelude::*;
/// let settings = ClothSettings { tethers: false, ..ClothQuality::Accurate.into() };
/// ```
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[reflect(Debug, PartialEq, Hash, Clone)]
pub enum ClothQuality {
    /// Eight substeps in 1/60 s and never more: the least time. 99 % of the threads of 128 x 128 particles stay
    /// within 1 % in the report's HANG and DRAPE; what hangs from single points, or is struck, may stretch beyond
    /// its limit for some frames.
    Game,
    /// 32 substeps in a tick: some four times the time of `Game`, a third of its error in motion, a third of its
    /// strain or less.
    Accurate,
    /// Explicit springs by Verlet's method, with as many substeps as the material needs: of second order, and
    /// keeps the energy of what swings. A square metre of 0.2 kg/m2 and 1000 N/m takes 111 in 1/60 s at 64 x 64
    /// particles, twice as many at twice as many a side.
    Reference,
}

impl From<ClothQuality> for ClothSettings {
    fn from(quality: ClothQuality) -> Self {
        match quality {
            ClothQuality::Game => {
                Self { substeps: Substeps::Automatic { budget: 8 }, ..Self::default() }
            }
            ClothQuality::Accurate => Self { substeps: Substeps::Fixed(32), ..Self::default() },
            ClothQuality::Reference => Self {
                stretch_method: StretchMethod::ExplicitSprings,
                substeps: Substeps::Automatic { budget: crate::solver::Settings::MAX_SUBSTEPS },
                ..Self::default()
            },
        }
    }
}
