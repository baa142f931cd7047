//! A lattice whose mass and stiffness vary from particle to particle.

use crate::solver::simd::layout::Layout;
use crate::solver::topology::lattice::{Family, Lattice, LatticeError};

impl Lattice {
    /// The same lattice with masses and stiffness multiplied particle by particle, row by row. A
    /// spring has the mean of its ends' factors, a shear spring that of its cell's corners.
    ///
    /// # Errors
    /// [`LatticeError::WrongFactorCount`], or [`LatticeError::BadFactor`] where a factor is not
    /// positive and finite.
    pub fn with_weights(mut self, mass: &[f32], stiffness: &[f32]) -> Result<Self, LatticeError> {
        let layout = self.layout;
        for factors in [mass, stiffness] {
            check(factors, self.particle_count())?;
        }
        for (slot, factor) in layout.slots().zip(mass) {
            self.mass_area[slot] *= factor;
        }
        let at = |r: usize, c: usize| stiffness[r * layout.columns + c];
        scale(&mut self.warp, layout, (1, 0), |r, c| 0.5 * (at(r, c) + at(r + 1, c)));
        scale(&mut self.weft, layout, (0, 1), |r, c| 0.5 * (at(r, c) + at(r, c + 1)));
        scale(&mut self.diagonal, layout, (1, 1), |r, c| {
            0.25 * ((at(r, c) + at(r + 1, c + 1)) + (at(r, c + 1) + at(r + 1, c)))
        });
        self.weft_transposed = self.weft.transposed(layout);
        // Cells are no longer alike.
        self.uniform = false;
        Ok(self)
    }
}

fn check(factors: &[f32], expected: usize) -> Result<(), LatticeError> {
    if factors.len() != expected {
        return Err(LatticeError::WrongFactorCount { expected, got: factors.len() });
    }
    match factors.iter().position(|f| !(*f >= f32::MIN_POSITIVE && f.is_finite())) {
        Some(particle) => Err(LatticeError::BadFactor { particle, value: factors[particle] }),
        None => Ok(()),
    }
}

/// Multiplies the shapes of springs that reach so many rows and columns further.
fn scale(
    family: &mut Family,
    layout: Layout,
    (rows, columns): (usize, usize),
    factor: impl Fn(usize, usize) -> f32,
) {
    for r in 0..layout.rows - rows {
        for c in 0..layout.columns - columns {
            let slot = layout.slot(r, c);
            let shape = family.shape[slot] * factor(r, c);
            family.set(slot, family.rest[slot], shape);
        }
    }
}
