//! Bodies that turn easily about an axis: light rods, thin plates.
//!
//! Engine and cloth exchange a body's momentum once a tick (`coupling`). What the cloth strikes turns by an angle within the tick that the
//! engine does not know of. The angular momentum, which both agree on, then lies along other axes of the engine's body than of the
//! cloth's. Of a rod that turns 35 times as easily about its length as across it, that makes up to 35 times the energy: it is thrown off,
//! spinning at hundreds of turns a second. So a cloth takes a body to turn about no axis more easily than what has a least radius of
//! gyration, or than it turns about its hardest axis. The engine is given the velocity that this makes, not the
//! momentum: a thin rod rolls on a cloth as one that is heavier inside.

use bevy_math::{Mat3, Vec3};

use crate::solver::contact::mobility::Mobility;

/// Speed at which what is struck turns by a radian or less within a tick \[m/s\].
const STRUCK: f32 = 1.25;
/// Ratio of values that rounding may make of equal ones.
const ALIKE: f32 = 1.0 + 1e-4;
/// Sweeps of Jacobi's rotations: the third leaves nothing beside the diagonal that a number of 32 bits holds.
const SWEEPS: usize = 4;

/// A body as a cloth takes it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tempered {
    pub mobility: Mobility,
    /// Part of an angular impulse that the engine is given; `None` where that is all of it.
    pub told_part: Option<Mat3>,
}

impl Tempered {
    /// For a tick of `dt` \[s\].
    pub fn new(mobility: Mobility, dt: f32) -> Self {
        let as_it_is = Self { mobility, told_part: None };
        let gyration = STRUCK * dt;
        let most = mobility.inverse_mass / (gyration * gyration);
        let inverse = mobility.inverse_inertia;
        // No value is more than the sum of all. Of what nothing shifts, the mass is not known.
        let sum = mobility.trace();
        if sum <= most || mobility.inverse_mass == 0.0 || !(most.is_finite() && sum.is_finite()) {
            return as_it_is;
        }
        let (values, axes) = eigen(inverse);
        let most = most.max(values.min_element());
        if values.max_element() <= most * ALIKE {
            return as_it_is;
        }
        let part = Vec3::from(values.to_array().map(|it| if it > most { most / it } else { 1.0 }));
        let along = |values| axes * Mat3::from_diagonal(values) * axes.transpose();
        let mobility = Mobility { inverse_inertia: along(values * part), ..mobility };
        Self { mobility, told_part: Some(along(part)) }
    }
}

/// Eigenvalues and eigenvectors, as columns, of a symmetric matrix, by rotations that each clear one number beside the diagonal (Jacobi 1846,
/// *Über ein leichtes Verfahren, die in der Theorie der Säcularstörungen vorkommenden Gleichungen numerisch aufzulösen*).
fn eigen(mut matrix: Mat3) -> (Vec3, Mat3) {
    let mut axes = Mat3::IDENTITY;
    for (p, q) in [(0, 1), (0, 2), (1, 2)].into_iter().cycle().take(3 * SWEEPS) {
        let beside = matrix.col(q)[p];
        if beside == 0.0 {
            continue;
        }
        let cotangent = (matrix.col(q)[q] - matrix.col(p)[p]) / (2.0 * beside);
        // The smaller root of `t^2 + 2 cotangent t = 1`.
        let t =
            1.0_f32.copysign(cotangent) / (cotangent.abs() + (cotangent * cotangent + 1.0).sqrt());
        let cosine = 1.0 / (t * t + 1.0).sqrt();
        let sine = t * cosine;
        let mut rotation = Mat3::IDENTITY;
        rotation.col_mut(p)[p] = cosine;
        rotation.col_mut(p)[q] = -sine;
        rotation.col_mut(q)[p] = sine;
        rotation.col_mut(q)[q] = cosine;
        matrix = rotation.transpose() * matrix * rotation;
        axes *= rotation;
    }
    (Vec3::new(matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z), axes)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f32 = 1.0 / 64.0;

    fn turned(principal: Vec3, turn: Vec3) -> Mat3 {
        let axes = Mat3::from_quat(bevy_math::Quat::from_scaled_axis(turn));
        axes * Mat3::from_diagonal(principal) * axes.transpose()
    }

    fn body(inverse_mass: f32, inverse_inertia: Mat3) -> Mobility {
        Mobility { inverse_mass, inverse_inertia, informed: true }
    }

    fn apart(a: Mat3, b: Mat3) -> f32 {
        (a - b).to_cols_array().into_iter().map(f32::abs).fold(0.0, f32::max)
    }

    #[test]
    fn eigenvalues_and_vectors_make_the_matrix() {
        for principal in [Vec3::new(1.0, 2.0, 70.0), Vec3::new(3.0, 3.0, 0.0), Vec3::splat(5.0)] {
            for turn in [Vec3::ZERO, Vec3::new(0.3, -1.2, 2.0), Vec3::X, Vec3::new(1e-4, 0.0, 0.7)]
            {
                let matrix = turned(principal, turn);
                let (values, axes) = eigen(matrix);
                let back = axes * Mat3::from_diagonal(values) * axes.transpose();
                assert!(apart(back, matrix) < 1e-5 * principal.max_element(), "{principal} {turn}");
                let mut sorted = values.to_array();
                sorted.sort_by(f32::total_cmp);
                let mut expected = principal.to_array();
                expected.sort_by(f32::total_cmp);
                for (value, expected) in sorted.into_iter().zip(expected) {
                    assert!((value - expected).abs() < 1e-5 * principal.max_element());
                }
            }
        }
    }

    #[test]
    fn a_thin_rod_turns_less_easily_about_its_length_alone() {
        // 12 g, 9 mm by 77 mm: across, the radius of gyration is 22 mm; about its length 3.8 mm.
        let inertia = 0.012 * Vec3::new(1.4e-5, 4.9e-4, 4.9e-4);
        let rod = body(1.0 / 0.012, turned(inertia.recip(), Vec3::new(0.5, 0.2, -0.9)));
        let Tempered { mobility, told_part } = Tempered::new(rod, DT);
        let (values, axes) = eigen(mobility.inverse_inertia);
        let gyration = STRUCK * DT;
        let most = 1.0 / (0.012 * gyration * gyration);
        assert!((values.max_element() / most - 1.0).abs() < 1e-4);
        assert!((values.min_element() * inertia.y - 1.0).abs() < 1e-4);
        // What the engine makes of what it is told is what the cloth saw.
        let told = told_part.unwrap();
        let largest = values.max_element();
        assert!(
            apart(rod.inverse_inertia * told, mobility.inverse_inertia) < 1e-4 * largest,
            "{axes}"
        );
    }

    #[test]
    fn others_are_as_they_are() {
        // A marble turns about every axis alike; a plank is large enough; what nothing turns is not turned.
        let marble = body(1.0 / 0.005, turned(Vec3::splat(1.0 / (0.4 * 0.005 * 6.4e-5)), Vec3::X));
        let plank = body(0.5, turned((2.0 * Vec3::new(1e-3, 0.1, 0.1)).recip(), Vec3::Y));
        let held = body(2.0, Mat3::ZERO);
        let door = body(0.0, Mat3::from_diagonal(Vec3::new(0.0, 1e6, 0.0)));
        for it in [marble, plank, held, door] {
            let Tempered { mobility, told_part } = Tempered::new(it, DT);
            assert!(mobility == it && told_part.is_none());
        }
    }
}
