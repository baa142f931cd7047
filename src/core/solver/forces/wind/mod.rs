//! The wind in one tick: uniform, in gusts, and in zones.
//!
//! It is taken once a tick, at the middle of each face of a cloth. Where it is the same for a whole
//! cloth (no gusts, and no zone near) it is one vector and costs nothing a particle.

mod noise;
mod zone;

use bevy_math::Vec3;

pub use crate::solver::forces::wind::zone::{WindFlow, WindShape, Zone};

use crate::solver::error::SolverError;
use crate::solver::forces::wind::noise::Field;
use crate::solver::forces::wind::zone::AddZone;
use crate::solver::settings::{ParameterError, check};
use crate::solver::simd::block::Block3;
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

/// The wind in one tick. The default is still air.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wind<'a> {
    /// The wind that blows everywhere \[m/s\].
    pub velocity: Vec3,
    /// Gusts on top of it.
    pub gusts: Gusts,
    /// The time that the gusts are of \[s\].
    pub time: f64,
    /// Places with wind of their own, on top of both; in an order that does not change from run to
    /// run.
    pub zones: &'a [Zone],
}

/// Wind that comes and goes: smooth noise in space and time. The same seed at the same time gives the
/// same bits.
///
/// ```
/// # use bevy_math::Vec3;
/// # use bevy_drape_core::solver::{Gusts, Wind};
/// let gusts = Gusts { strength: 3.0, ..Gusts::default() };
/// let wind = Wind { velocity: Vec3::X * 5.0, gusts, time: 7.0, ..Wind::default() };
/// assert!(wind.at(Vec3::ZERO).x >= 2.0 && wind.at(Vec3::ZERO).x <= 8.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, bevy_reflect::Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct Gusts {
    /// Most that a gust adds to each coordinate of the wind, or takes off it \[m/s\]. Higher is wilder, 0 is
    /// none. Over time a gust's root mean square is some 0.3 of it.
    pub strength: f32,
    /// Size of a gust \[m\]. Larger moves the cloth more as a whole, smaller ruffles it.
    pub scale: f32,
    /// Time in which a gust comes and another takes its place \[s\]. Longer is calmer.
    pub period: f32,
    /// Which of all gusts. Another seed is other weather.
    pub seed: u64,
}

impl Default for Gusts {
    fn default() -> Self {
        Self { strength: 0.0, scale: 2.0, period: 1.0, seed: 0 }
    }
}

impl Gusts {
    /// Checks every number.
    ///
    /// # Errors
    /// [`ParameterError`] for the first number that is not finite or out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check("strength", self.strength, 0.0, Zone::FASTEST, "from 0 to 1e5 m/s")?;
        check("scale", self.scale, 1e-2, 1e6, "from 0.01 to 1e6 m")?;
        check("period", self.period, 1e-3, 1e6, "from 0.001 to 1e6 s")
    }
}

/// Where a cloth is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Where its coordinates begin, in world space \[m\].
    pub origin: Vec3,
    /// Bounds relative to it \[m\].
    pub min: Vec3,
    /// See `min`.
    pub max: Vec3,
}

impl Wind<'_> {
    /// The wind at a place in world space \[m/s\]: for whatever else it blows on, too.
    pub fn at(&self, place: Vec3) -> Vec3 {
        let mut wind = self.velocity;
        if self.gusts.strength > 0.0 {
            wind += Field::new(&self.gusts, self.time, place).here();
        }
        for zone in self.zones {
            wind += zone.seen_from(place).at(Vec3::ZERO);
        }
        wind
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`SolverError::Wind`] or [`SolverError::Zone`].
    pub fn validate(&self) -> Result<(), SolverError> {
        for speed in self.velocity.to_array() {
            check("velocity", speed, -Zone::FASTEST, Zone::FASTEST, "at most 1e5 m/s")
                .map_err(SolverError::Wind)?;
        }
        self.gusts.validate().map_err(SolverError::Wind)?;
        if !(-1e12..=1e12).contains(&self.time) {
            let problem = ParameterError {
                name: "time",
                value: self.time as f32,
                range: "finite and at most 1e12 s",
            };
            return Err(SolverError::Wind(problem));
        }
        match self.zones.iter().position(|zone| !zone.is_valid()) {
            Some(zone) => Err(SolverError::Zone(zone)),
            None => Ok(()),
        }
    }

    /// The wind of a whole place, where it is the same.
    pub(crate) fn uniform_in(&self, place: &Place) -> Option<Vec3> {
        let steady = self.gusts.strength == 0.0;
        let same = steady && !self.zones.iter().any(|zone| zone.meets(place));
        same.then_some(self.velocity)
    }

    /// A speed that the wind does not exceed there \[m/s\].
    pub(crate) fn most_in(&self, place: &Place) -> f32 {
        let gust = self.gusts.strength * Vec3::ONE.length();
        let zones = self.zones.iter().filter(|zone| zone.meets(place));
        zones.map(|zone| zone.flow.speed()).fold(self.velocity.length() + gust, |a, b| a + b)
    }

    /// The wind at places relative to the origin.
    pub(crate) fn sample(&self, isa: Isa, place: &Place, places: &Soa, wind: &mut Soa) {
        isa.run(Fill {
            velocity: self.velocity,
            gusts: (self.gusts.strength > 0.0)
                .then(|| Field::new(&self.gusts, self.time, place.origin)),
            places,
            wind,
        });
        for zone in self.zones.iter().filter(|zone| zone.meets(place)) {
            isa.run(AddZone { zone: zone.seen_from(place.origin), places, wind });
        }
    }
}

/// Sets the wind to what blows everywhere, and its gusts.
struct Fill<'a> {
    velocity: Vec3,
    gusts: Option<Field>,
    places: &'a Soa,
    wind: &'a mut Soa,
}

impl Kernel for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for at in (0..self.wind.x.len()).step_by(LANES) {
            let mut wind = Block3::splat(self.velocity);
            if let Some(gusts) = &self.gusts {
                let gusts = gusts.block(&Block3::load(self.places, at));
                for i in 0..LANES {
                    wind.set(i, self.velocity + gusts.at(i));
                }
            }
            wind.store(self.wind, at);
        }
    }
}
