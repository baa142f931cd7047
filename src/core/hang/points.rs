//! The points that a cloth hangs from, and which are refused.

use bevy_math::Vec3;

use super::flatten::Flattened;
use crate::solver::Topology;

/// Hanging points nearer to each other than this part of the cloth between them are at one place.
const COINCIDENT: f64 = 1e-6;
/// Rounding of places in single precision, relative to the cloth between two of them.
const ROUNDING: f64 = 1e-5;

/// A particle that hangs at a given place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HangingPoint {
    /// The particle.
    pub particle: u32,
    /// Where it is, in world space \[m\].
    pub place: Vec3,
}

/// Why a cloth cannot hang from the points given.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum HangError {
    /// Fewer than two points.
    #[error("a cloth is hung from two points or more, not from {0}; hold another particle")]
    TooFewPoints(usize),
    /// A particle that is to hang does not exist.
    #[error("there is no particle {particle} to hang: the cloth has {count}")]
    NoSuchParticle {
        /// The particle asked for.
        particle: u32,
        /// Particles of the cloth.
        count: usize,
    },
    /// Two points are the same particle.
    #[error("particle {0} is to hang at two places; leave one of them")]
    Twice(u32),
    /// Two points are at the same place.
    #[error("particles {first} and {second} are to hang at the same place; move them apart")]
    Coincident {
        /// One particle.
        first: u32,
        /// The other.
        second: u32,
    },
    /// Two points are further apart than the cloth between them reaches.
    #[error(
        "particles {first} and {second} are to hang {distance} m apart, but the cloth between them reaches \
         no further than {reach} m; bring them together, or make the cloth larger"
    )]
    TooFar {
        /// One particle.
        first: u32,
        /// The other.
        second: u32,
        /// Distance of their places \[m\].
        distance: f64,
        /// Length of the cloth between them, stretched as far as it may be \[m\].
        reach: f64,
    },
    /// A place is not finite.
    #[error("the place at which particle {0} is to hang is not finite")]
    NonFinite(u32),
    /// There is no gravity, or it is not finite.
    #[error("without gravity nothing hangs; give the direction in which it pulls")]
    NoGravity,
}

/// Checks each point by itself, and their number.
pub(super) fn check_each(topology: &Topology, points: &[HangingPoint]) -> Result<(), HangError> {
    let count = topology.particle_count();
    let mut particles: Vec<u32> = points.iter().map(|point| point.particle).collect();
    particles.sort_unstable();
    if let Some(&particle) = particles.last().filter(|&&last| last as usize >= count) {
        return Err(HangError::NoSuchParticle { particle, count });
    }
    if let Some(pair) = particles.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(HangError::Twice(pair[0]));
    }
    if let Some(point) = points.iter().find(|point| !point.place.is_finite()) {
        return Err(HangError::NonFinite(point.particle));
    }
    if points.len() < 2 {
        return Err(HangError::TooFewPoints(points.len()));
    }
    Ok(())
}

/// Checks that any two points are apart, and within reach of the cloth spread out flat.
pub(super) fn check_pairs(
    topology: &Topology,
    cloth: &Flattened,
    points: &[HangingPoint],
    max_strain: f64,
) -> Result<(), HangError> {
    let rest = topology.rest_positions();
    for (i, one) in points.iter().enumerate() {
        for other in &points[..i] {
            let [a, b] = [other.particle as usize, one.particle as usize];
            let distance = one.place.as_dvec3().distance(other.place.as_dvec3());
            // No way along a cloth is shorter than the one through space.
            let flat = cloth.at[a].distance(cloth.at[b]);
            let length = flat.max(f64::from(rest[a].distance(rest[b])));
            let [first, second] = [other.particle, one.particle];
            if distance <= COINCIDENT * length {
                return Err(HangError::Coincident { first, second });
            }
            let reach = length * (1.0 + max_strain);
            if cloth.piece[a] == cloth.piece[b] && distance > reach + ROUNDING * length {
                return Err(HangError::TooFar { first, second, distance, reach });
            }
        }
    }
    Ok(())
}
