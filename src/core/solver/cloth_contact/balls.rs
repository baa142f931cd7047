//! The balls of a cloth's particles.

use bevy_math::Vec3;

use crate::solver::cloth_contact::faces::faces;
use crate::solver::simd::soa::Array;
use crate::solver::topology::Topology;

/// Radius of a ball over the largest distance that a point of the triangles around it has from their nearest corner. A half would
/// be the floor for two layers that lie flat on each other; sheared cells and what moves in a substep need more.
const RESERVE: f32 = 0.65;

/// Radii of the particles' balls.
#[derive(Clone, Debug)]
pub(super) struct Balls {
    /// By slot \[m\].
    pub radius: Array,
}

impl Balls {
    /// With this distance between their centres where they touch \[m\], or as small as holds.
    pub fn of(topology: &Topology, distance: Option<f32>) -> Self {
        distance
            .map_or_else(|| Self::automatic(topology), |distance| Self::uniform(topology, distance))
    }

    /// As small as holds: of each particle by the largest of its triangles.
    pub fn automatic(topology: &Topology) -> Self {
        let rest = topology.rest_positions();
        let mut radius = Array::zeros(topology.layout().len());
        for corners in faces(topology) {
            let needed = RESERVE * covering_radius(corners.map(|corner| rest[corner]));
            for corner in corners {
                let radius = &mut radius[topology.slot(corner)];
                *radius = radius.max(needed);
            }
        }
        Self { radius }
    }

    /// All alike, with that distance between their centres where they touch \[m\].
    fn uniform(topology: &Topology, distance: f32) -> Self {
        let mut radius = Array::zeros(topology.layout().len());
        for particle in 0..topology.particle_count() {
            radius[topology.slot(particle)] = 0.5 * distance;
        }
        Self { radius }
    }

    /// Largest distance at which two particles touch \[m\].
    pub fn widest(&self) -> f32 {
        2.0 * self.largest()
    }

    /// The largest radius \[m\].
    fn largest(&self) -> f32 {
        self.radius.iter().copied().fold(0.0, f32::max)
    }
}

/// Largest distance that a point of a triangle has from the nearest of its corners: the radius of its circumcircle, or half of its
/// longest side where it is obtuse.
fn covering_radius([a, b, c]: [Vec3; 3]) -> f32 {
    let mut sides = [b.distance(c), c.distance(a), a.distance(b)];
    sides.sort_by(f32::total_cmp);
    let [p, q, longest] = sides;
    let half = 0.5 * longest;
    if p * p + q * q <= longest * longest {
        return half;
    }
    p * q * half / (b - a).cross(c - a).length()
}
