//! What depends on which particles are held: inverse masses, tethers, clamped hinges.

use super::bending::Hinges;
use super::lanes::Array;
use super::lattice::Lattice;
use super::tethers::TetherSet;

/// The pins of a cloth and what follows from them. Made anew when the set of pins changes.
#[derive(Clone, Debug)]
pub(super) struct Held {
    /// Held particles, row by row, ascending.
    pub particles: Vec<u32>,
    /// Their slots.
    pub slots: Vec<usize>,
    /// 1 / mass \[1/kg\]; 0 where held and beside the sheet.
    pub inverse_mass: Array,
    /// The same in the transposed layout.
    pub inverse_mass_transposed: Array,
    /// Tethers to the pins.
    pub tethers: Vec<TetherSet>,
    /// Hinges of weft and warp.
    pub hinges: [Hinges; 2],
}

impl Held {
    /// For particles that are in range, ascending and different from each other.
    pub fn new(lattice: &Lattice, particles: Vec<u32>) -> Self {
        let layout = lattice.layout;
        let slots: Vec<usize> = particles
            .iter()
            .map(|&p| layout.slot(p as usize / layout.columns, p as usize % layout.columns))
            .collect();
        let mut held = vec![false; layout.len()];
        for &slot in &slots {
            held[slot] = true;
        }
        Self {
            tethers: TetherSet::build(lattice, &slots),
            hinges: Hinges::build(lattice, &held),
            particles,
            slots,
            inverse_mass: Array::zeros(layout.len()),
            inverse_mass_transposed: Array::zeros(layout.transposed().len()),
        }
    }

    /// Sets the masses for an area density \[kg/m2\].
    pub fn set_density(&mut self, lattice: &Lattice, density: f32) {
        let layout = lattice.layout;
        let transposed = layout.transposed();
        let mut held = self.slots.iter().copied().peekable();
        for row in 0..layout.rows {
            for column in 0..layout.columns {
                let slot = layout.slot(row, column);
                let is_held = held.next_if_eq(&slot).is_some();
                let w = if is_held { 0.0 } else { 1.0 / (lattice.mass_area[slot] * density) };
                self.inverse_mass[slot] = w;
                self.inverse_mass_transposed[transposed.slot(column, row)] = w;
            }
        }
    }
}
