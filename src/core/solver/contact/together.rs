//! The motion of a body and of what lies on it, as one.
//!
//! An impulse j makes the velocity v of `(1/K + A) v = j`, with the body's mobility K and the tensor of inertia A of what goes
//! with it. Conjugate gradients solve it, preconditioned by K (Hestenes and Stiefel 1952, *Methods of Conjugate Gradients for Solving
//! Linear Systems*): neither A nor `1/K` is needed as a matrix, and K may be none along some axes. What is light beside its body
//! takes one step or two. In exact arithmetic six are enough for anything, one for each way to go.

use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::mobility::{Mobility, Twist};
use crate::solver::contact::touching::{Touching, momentum};

/// Steps at most: with rounding a few more than six may be needed.
const STEPS: usize = 9;
/// Part of the energy that the impulse would give the body alone that may be left over.
const LEFT: f32 = 1e-6;

/// The velocity that an impulse makes of a body and of the particles that go with it.
#[inline(always)]
pub(super) fn together(body: &Mobility, carried: &[Touching], impulse: Impulse) -> Twist {
    let mut moves = Twist::default();
    // What is left of the impulse; the way of a step, and the impulse that the body itself needs for that.
    let mut left = impulse;
    let (mut way, mut needs) = (body.motion(left), left);
    let mut power = power_of(&left, &way);
    let least = LEFT * power;
    let mut steps = 0;
    // What is no number ends it.
    while power > least && steps < STEPS {
        steps += 1;
        let takes = needs + momentum(carried, &way);
        let all = power_of(&takes, &way);
        // No body has a mobility by which it would be so.
        let part = if all > 0.0 { power / all } else { break };
        moves.add(&way.times(part));
        left = left - takes * part;
        let next = body.motion(left);
        let before = core::mem::replace(&mut power, power_of(&left, &next));
        let again = power / before;
        way = way.times(again);
        way.add(&next);
        needs = left + needs * again;
    }
    moves
}

/// Twice the energy that an impulse gives to what goes with a velocity.
#[inline(always)]
fn power_of(impulse: &Impulse, velocity: &Twist) -> f32 {
    impulse.linear.dot(velocity.linear) + impulse.angular.dot(velocity.angular)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::contact::touching::tests::one;
    use bevy_math::{Mat3, Vec3};

    #[test]
    fn a_body_that_carries_its_own_mass_is_half_as_fast() {
        let body = Mobility {
            inverse_mass: 0.5,
            inverse_inertia: Mat3::from_diagonal(Vec3::new(1.0, 2.0, 0.0)),
            informed: true,
        };
        // Two kilograms at its centre.
        let carried = [one(2.0, Vec3::ZERO, Vec3::Y, 1.0)];
        let impulse = Impulse { linear: Vec3::new(4.0, 0.0, -8.0), angular: Vec3::ONE };
        let moves = together(&body, &carried, impulse);
        assert!(moves.linear.distance(Vec3::new(1.0, 0.0, -2.0)) < 1e-5, "{moves:?}");
        assert!(moves.angular.distance(Vec3::new(1.0, 2.0, 0.0)) < 1e-5, "{moves:?}");
    }

    /// A light body goes freely along the surface of heavy particles that slide on it.
    #[test]
    fn a_light_body_slides_along_what_it_carries() {
        let inverse_inertia = Mat3::from_diagonal(Vec3::splat(1e8));
        let body = Mobility { inverse_mass: 1e3, inverse_inertia, informed: true };
        let corners = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let carried = corners.map(|[x, z]| one(0.05, Vec3::new(x, 0.0, z) * 0.05, Vec3::Y, 0.0));
        let impulse = Impulse { linear: Vec3::new(0.003, -1.0, 0.0), angular: Vec3::ZERO };
        let moves = together(&body, &carried, impulse);
        assert!((moves.linear.x - 3.0).abs() < 0.03, "{moves:?}");
        assert!((moves.linear.y + 1.0 / 0.201).abs() < 0.01, "{moves:?}");
    }

    /// Whatever it weighs beside what lies on it, at any places, and whatever may turn it.
    #[test]
    fn body_and_what_it_carries_share_the_impulse() {
        let corner = |i: usize| {
            let side = |bit| if i & bit == 0 { -0.2 } else { 0.3 };
            Vec3::new(side(1), side(2), 0.5 * side(4))
        };
        let normal = |i: usize| Vec3::new(i as f32 - 2.0, 3.0, 1.5).normalize();
        let carried: Vec<_> =
            (0..8).map(|i| one(0.01, corner(i), normal(i), 0.2 * (i % 5) as f32)).collect();
        let impulse =
            Impulse { linear: Vec3::new(0.4, -0.9, 0.1), angular: Vec3::new(0.1, 0.3, -0.2) };
        for mass in [1e-4, 1e-2, 1.0, 100.0] {
            let inertia = Vec3::new(0.01, 0.03, 0.02) * mass;
            for inverse_inertia in
                [Vec3::ZERO, Vec3::new(1.0 / inertia.x, 0.0, 0.0), inertia.recip()]
            {
                let inverse_inertia = Mat3::from_diagonal(inverse_inertia);
                let body = Mobility { inverse_mass: 1.0 / mass, inverse_inertia, informed: true };
                let moves = together(&body, &carried, impulse);
                // The body goes as what is left for it makes it.
                let own = body.motion(impulse - momentum(&carried, &moves));
                let alone = body.motion(impulse);
                for (own, goes, alone) in [
                    (own.linear, moves.linear, alone.linear),
                    (own.angular, moves.angular, alone.angular),
                ] {
                    let off = own.distance(goes) / (alone.length() + 1e-6);
                    assert!(off < 2.0 * LEFT.sqrt(), "{mass} kg, {inverse_inertia}: {off:e}");
                }
            }
        }
    }
}
