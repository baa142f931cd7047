//! Integrators beside Verlet, to be compared with it: Euler's explicit method, and the explicit midpoint
//! method, a Runge-Kutta method of second order (Runge 1895; Hairer, Nørsett and Wanner 1993, II.1).
//!
//! Both keep the velocity of the instant, not that of half a substep ago. The displacement of a substep is
//! made of the velocity at its start, and at its end the kick of the whole substep is added, so that
//! corrections and contact see displacements as they do with Verlet. Neither is stable without damping:
//! in each substep they multiply an oscillation of frequency omega by `sqrt(1 + (omega h)^2)` and by
//! `sqrt(1 + (omega h)^4 / 4)`.

use crate::solver::integrate::verlet::Add;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Soa;

/// Working memory of these integrators.
#[derive(Clone, Debug)]
pub(crate) struct ExplicitWorkspace {
    /// Accelerations where the substep begins \[m/s2\].
    pub first: Soa,
    /// Positions and displacements there, while those at its middle stand in for them \[m\].
    pub x: Soa,
    pub d: Soa,
}

impl ExplicitWorkspace {
    pub(crate) fn new(layout: Layout) -> Self {
        let [first, x, d] = core::array::from_fn(|_| Soa::zeros(layout.len()));
        Self { first, x, d }
    }
}

/// Adds a part of one vector a particle to another, for every particle that is not held.
#[derive(Clone, Copy)]
pub(crate) struct Adding {
    pub isa: Isa,
    pub layout: Layout,
}

impl Adding {
    pub(crate) fn run(self, part: f32, inverse_mass: &[f32], from: &Soa, to: &mut Soa) {
        self.isa.run(Add { layout: self.layout, part, inverse_mass, from, to });
    }
}
