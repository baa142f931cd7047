//! Settings by what they are for, read off the report of speed against error (`assets/report/report.md`).

use crate::cloth::settings::ClothSettings;
use crate::solver::{Settings, StretchMethod, Substeps};

/// Presets, beside [`ClothSettings::USUAL`].
///
/// ```
/// # use bevy_drape::prelude::*;
/// let settings = ClothSettings { tethers: false, ..ClothSettings::ACCURATE };
/// ```
impl ClothSettings {
    /// The least time: eight substeps in 1/60 s, and more only for layers of cloth and for bodies that strike it.
    ///
    /// 99 % of the threads of 128 x 128 particles stay within 1 % in the report's HANG and DRAPE; a cloth that hangs from
    /// single points, or is struck, may stretch beyond its limit for some frames.
    pub const GAME: Self = Self { substeps: Substeps::Automatic { budget: 8 }, ..Self::USUAL };
    /// Films and close-ups: 32 substeps in a tick. Some four times the time of [`ClothSettings::GAME`], a third of its
    /// error in motion, a third of its strain or less.
    pub const ACCURATE: Self = Self { substeps: Substeps::Fixed(32), ..Self::USUAL };
    /// To compare with: explicit springs by Verlet's method, with as many substeps as the material needs. It is of second
    /// order, and keeps the energy of what swings. A square metre of 0.2 kg/m2 and 1000 N/m takes 111 in 1/60 s at 64 x 64
    /// particles, twice as many at twice as many a side.
    pub const REFERENCE: Self = Self {
        stretch_method: StretchMethod::ExplicitSprings,
        substeps: Substeps::Automatic { budget: Settings::MAX_SUBSTEPS },
        ..Self::USUAL
    };
}
