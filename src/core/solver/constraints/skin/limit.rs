//! Limits of the particles of a skinned cloth, and the motion of the skin in a tick.

use bevy_math::Vec3;

use crate::solver::settings::{ParameterError, check};
use crate::solver::simd::block::smaller;

/// How a particle is held to its place on the skin. The default lets it go where it may.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct SkinLimit {
    /// How far it goes from there at most \[m\]; infinite where it may go anywhere, 0 where it stays there.
    pub max_distance: f32,
    /// What it does not enter, if there is anything.
    pub backstop: Option<Backstop>,
    /// Rate of the critically damped spring that draws it there \[1/s\]: a tenth of the way is left after a time of about
    /// `4 / drive`. 0 draws nothing.
    pub drive: f32,
}

/// A ball behind a particle's place on the skin, along the skin's normal there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct Backstop {
    /// How far behind the place its surface is \[m\]; negative is before it, at most by the max distance.
    pub distance: f32,
    /// Its radius \[m\]; infinite is all that is behind. Larger than the triangles around, so that none of it comes between them.
    pub radius: f32,
}

impl Default for SkinLimit {
    fn default() -> Self {
        Self { max_distance: f32::INFINITY, backstop: None, drive: 0.0 }
    }
}

impl Default for Backstop {
    fn default() -> Self {
        Self { distance: 0.0, radius: f32::INFINITY }
    }
}

impl SkinLimit {
    /// The limit of a cloth that is larger by a factor.
    pub fn scaled(&self, factor: f32) -> Self {
        let stop = |stop: &Backstop| Backstop {
            distance: stop.distance * factor,
            radius: stop.radius * factor,
        };
        Self {
            max_distance: self.max_distance * factor,
            backstop: self.backstop.as_ref().map(stop),
            drive: self.drive,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`ParameterError`] for the first number that is NaN or out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let Self { max_distance, backstop, drive } = *self;
        if max_distance.is_nan() || max_distance < 0.0 {
            let range = "0 or more, or infinite";
            return Err(ParameterError { name: "max distance", value: max_distance, range });
        }
        check("drive", drive, 0.0, 1e4, "from 0 to 10000 /s")?;
        let Some(Backstop { distance, radius }) = backstop else { return Ok(()) };
        let range = "from minus the max distance to 1000 m";
        check("backstop distance", distance, -smaller(max_distance, 1e3), 1e3, range)?;
        if !(radius > 0.0 && radius > -distance) {
            let range = "above 0 and above minus its distance, or infinite";
            return Err(ParameterError { name: "backstop radius", value: radius, range });
        }
        Ok(())
    }
}

/// The place of a particle on the skin, in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SkinMotion {
    /// Where it is at the tick's start and at its end \[m\]. On the way it goes straight, and evenly.
    pub place: [Vec3; 2],
    /// Normal of the skin there, at the same times; outwards, of any length. What has no backstop needs none.
    pub normal: [Vec3; 2],
}
