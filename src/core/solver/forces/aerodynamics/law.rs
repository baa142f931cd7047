//! The force of moving air on one face.

use bevy_math::Vec3;

use crate::solver::simd::block::larger;

/// Least area of a face that has a normal \[m2\].
const LEAST_AREA: f32 = 1e-20;
/// Least speed that has a direction \[m/s\].
const LEAST_SPEED: f32 = 1e-20;

/// The aerodynamic law of a substep, the same for all faces of a cloth.
///
/// With `u` the velocity of the air relative to the face, `n` its unit normal and `A` its area, the
/// force is drag along `u` and lift across it, both in proportion to the area that the wind sees:
/// `F = 1/2 rho A |u . n| (C_d |u| u^ + C_l (|u| sign(u . n) n - |u . n| u^))`. As a matrix on `u`,
/// that is one number along the normal and another across it; both are taken at the velocity of
/// the last kick, and what they act on is the velocity after this one:
/// `k u' = k (u - kick a) / (1 + kick k / m)`. So the wind never carries a face past itself, however
/// strong it is and however long the substep, a steady speed is exact, and a fall under drag is of
/// second order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law {
    /// Half the air's density times the coefficient of drag \[kg/m3\].
    pub drag: f32,
    /// Coefficient of lift, alike.
    pub lift: f32,
    /// The time that the force acts \[s\].
    pub kick: f32,
}

impl Law {
    /// Force on a face \[N\]: its vector area \[m2\], the air's velocity relative to it \[m/s\] now and
    /// as other forces will have changed it, and the inverse of the mass that takes the force \[1/kg\].
    #[inline(always)]
    pub fn force(&self, area: Vec3, now: Vec3, then: Vec3, inverse_mass: f32) -> Vec3 {
        let size = area.dot(area).sqrt();
        let n = area * (1.0 / larger(size, LEAST_AREA));
        let through = now.dot(n);
        let drag = self.drag * size * through.abs();
        let answer = self.kick * inverse_mass;
        if self.lift > 0.0 {
            let speed = larger(now.dot(now).sqrt(), LEAST_SPEED);
            let along = self.lift * size * speed;
            let back = self.lift * size * (through * through / speed);
            // Rounding alone could make the first negative.
            let parts = [larger(drag + (along - back), 0.0), drag - back];
            self.push(parts, n, then, answer)
        } else {
            then * (drag / (1.0 + answer * drag))
        }
    }

    /// The matrix of `[normal, tangential]` on the velocity that it leads to itself.
    #[inline(always)]
    fn push(&self, [normal, tangential]: [f32; 2], n: Vec3, then: Vec3, answer: f32) -> Vec3 {
        let kept = 1.0 / (1.0 + answer * normal);
        let normal = normal * kept;
        let through = then.dot(n);
        let mut damped = tangential / (1.0 + answer * larger(tangential, 0.0));
        if self.lift > self.drag {
            // Lift that turns the wind along the face may give that part no more energy than it
            // takes from the other.
            let across = larger(then.dot(then) - through * through, LEAST_SPEED);
            let ratio = through * through / across;
            let free = ratio * normal * (1.0 + kept);
            let most = free / (1.0 + (1.0 + answer * free).sqrt());
            damped = larger(damped, -most);
        }
        then * damped + n * ((normal - damped) * through)
    }
}
