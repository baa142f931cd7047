//! The pins of a cloth, and all that depends on which particles are held: inverse masses, tethers.

use bevy_math::Vec3;

use crate::solver::constraints::tethers::TetherSet;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Array;
use crate::solver::topology::Topology;

/// The pins of a cloth and what follows from them. Made anew when the set of pins changes.
#[derive(Clone, Debug)]
pub(crate) struct Pins {
    /// Held particles, ascending.
    pub particles: Vec<u32>,
    /// Slots of the held particles.
    pub slots: Vec<usize>,
    /// Where they are at the substep's end, relative to the origin \[m\].
    pub places: Vec<Vec3>,
    /// 1 / mass \[1/kg\]; 0 where held and beside the sheet.
    pub inverse_mass: Array,
    /// Inverse masses in the transposed layout of a lattice.
    pub inverse_mass_transposed: Array,
    /// Mass that particles move as if they had, over their own (`state::carrying`).
    pub mass_scale: f32,
    /// Mass of the cloth, for each metre of its width \[kg/m\].
    pub hung: f32,
    /// Tethers to the pins.
    pub tethers: Vec<TetherSet>,
}

impl Pins {
    /// For particles that are in range, ascending and different from each other.
    pub fn new(topology: &Topology, particles: Vec<u32>) -> Self {
        let layout = topology.layout();
        let slots: Vec<usize> = particles.iter().map(|&p| topology.slot(p as usize)).collect();
        let transposed = topology.as_lattice().map_or(0, |_| layout.transposed().len());
        Self {
            tethers: TetherSet::build(topology, &slots),
            mass_scale: 1.0,
            hung: 0.0,
            particles,
            places: vec![Vec3::ZERO; slots.len()],
            slots,
            inverse_mass: Array::zeros(layout.len()),
            inverse_mass_transposed: Array::zeros(transposed),
        }
    }

    /// Sets 1 / mass of a slot's particle, as the stages see it \[1/kg\]; returns what it was.
    pub fn set_inverse_mass(&mut self, topology: &Topology, slot: usize, to: f32) -> f32 {
        if let Some(lattice) = topology.as_lattice() {
            self.inverse_mass_transposed[lattice.transposed_slot(slot)] = to;
        }
        core::mem::replace(&mut self.inverse_mass[slot], to)
    }

    /// Sets the masses for an area density \[kg/m2\].
    pub fn set_density(&mut self, topology: &Topology, density: f32) {
        let layout = topology.layout();
        let mass = layout.slots().map(|slot| topology.area(slot) * density).sum::<f32>();
        self.hung = mass / topology.total_area().sqrt();
        for slot in layout.slots() {
            self.inverse_mass[slot] = 1.0;
        }
        for &slot in &self.slots {
            self.inverse_mass[slot] = 0.0;
        }
        self.scale_mass(topology, density, 1.0);
    }

    /// Sets the masses that particles move as if they had for an area density \[kg/m2\]: `scale` times their own.
    pub fn scale_mass(&mut self, topology: &Topology, density: f32, scale: f32) {
        self.mass_scale = scale;
        let layout = topology.layout();
        for slot in layout.slots() {
            if self.inverse_mass[slot] > 0.0 {
                self.inverse_mass[slot] = 1.0 / (topology.area(slot) * density * scale);
            }
        }
        if topology.as_lattice().is_some() {
            let transposed = layout.transposed();
            for row in 0..layout.rows {
                for column in 0..layout.columns {
                    self.inverse_mass_transposed[transposed.slot(column, row)] =
                        self.inverse_mass[layout.slot(row, column)];
                }
            }
        }
    }

    /// Which slots are held.
    pub fn mask(&self, layout: Layout) -> Vec<bool> {
        let mut held = vec![false; layout.len()];
        for &slot in &self.slots {
            held[slot] = true;
        }
        held
    }
}
