//! Particles sorted by the cells of a grid that they are in.

use bevy_math::Vec3;

use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::{Array, Soa};

/// Bits of a cell's coordinate along an axis. Coordinates are from 1 to 1022, so that each cell has neighbours.
const BITS: u32 = 10;
const MOST_CELLS: f32 = 1022.0;
/// The key after all cells.
const END: u32 = u32::MAX;
/// Coordinates of the padding, from which everything is far \[m\].
pub(super) const NOWHERE: f32 = 1e18;

/// Particles in the order of their cells, row by row along x.
#[derive(Clone, Debug, Default)]
pub(super) struct Grid {
    /// Least width of a cell \[m\].
    wide: f32,
    /// Keys of cells, and below them slots.
    keys: Vec<u64>,
    spare: Vec<u64>,
    /// The cells that hold any, ascending, then two ends.
    pub cells: Vec<Cell>,
    /// Slots, positions and radii, in order.
    pub slots: Vec<u32>,
    pub x: Soa,
    pub radius: Array,
}

/// A cell that holds particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cell {
    pub key: u32,
    /// Place of the first of them.
    pub first: u32,
}

/// Steps from a cell's key to those of the middles of the rows around it that come after it.
pub(super) const ROWS: [u32; 4] = {
    let (row, layer) = (1 << BITS, 1 << (2 * BITS));
    [row, layer - row, layer, layer + row]
};

impl Grid {
    /// Makes room for so many particles, where there is less.
    pub fn make_room(&mut self, count: usize) {
        if self.spare.len() < count {
            self.spare.resize(count, 0);
            self.keys.reserve(count - self.keys.len());
            let room = room_for(count);
            (self.x, self.radius) = (Soa::zeros(room), Array::zeros(room));
        }
    }

    /// Begins anew, with cells that are `reach` wide, or more where there would be too many of them.
    pub fn begin(&mut self, reach: f32) {
        self.wide = reach;
        self.keys.clear();
    }

    /// Takes in particles, by their slots and positions.
    pub fn take(&mut self, at: &Soa, slots: impl Iterator<Item = usize>) {
        self.keys.extend(slots.map(|slot| slot as u64));
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &slot in &self.keys {
            let p = at.get(slot as usize);
            (low, high) = (low.min(p), high.max(p));
        }
        let wide = self.wide.max((high - low).max_element() / (MOST_CELLS - 1.0));
        for key in &mut self.keys {
            let cell = (at.get(*key as usize) - low) / wide + 1.0;
            let [x, y, z] = cell.to_array().map(|along| along.min(MOST_CELLS) as u64);
            *key |= ((z << (2 * BITS)) | (y << BITS) | x) << 32;
        }
    }

    /// Sorts the particles that were taken in, of these positions and radii by slot.
    pub fn sort(&mut self, isa: Isa, at: &Soa, radius: &[f32]) {
        self.order_keys();
        isa.run(Place { grid: self, at, radius });
    }

    /// Sorts keys by the digits of their cells; what is in one cell keeps its order.
    fn order_keys(&mut self) {
        const DIGITS: usize = 1 << BITS;
        for digit in 0..3 {
            let shift = 32 + digit * BITS;
            let value = |key: u64| (key >> shift) as usize & (DIGITS - 1);
            let mut places = [0_u32; DIGITS];
            for &key in &self.keys {
                places[value(key)] += 1;
            }
            let mut before = 0;
            for place in &mut places {
                (*place, before) = (before, before + *place);
            }
            for &key in &self.keys {
                let place = &mut places[value(key)];
                self.spare[*place as usize] = key;
                *place += 1;
            }
            let count = self.keys.len();
            self.keys.copy_from_slice(&self.spare[..count]);
        }
    }
}

/// Places of so many particles, with a block to look beyond the last.
pub(super) fn room_for(count: usize) -> usize {
    count.next_multiple_of(LANES) + LANES
}

/// Lists cells, and writes what pairs are found by, in the order of the keys.
struct Place<'a> {
    grid: &'a mut Grid,
    at: &'a Soa,
    radius: &'a [f32],
}

impl Kernel for Place<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Grid { keys, cells, slots, x, radius, .. } = self.grid;
        cells.clear();
        slots.clear();
        let mut last = END;
        for (place, &entry) in keys.iter().enumerate() {
            let (key, slot) = ((entry >> 32) as u32, entry as u32);
            if key != last {
                cells.push(Cell { key, first: place as u32 });
                last = key;
            }
            slots.push(slot);
            let slot = slot as usize;
            x.set(place, self.at.get(slot));
            radius[place] = self.radius[slot];
        }
        let count = keys.len();
        for place in count..(count + LANES).min(radius.len()) {
            x.set(place, Vec3::splat(NOWHERE));
        }
        let end = Cell { key: END, first: count as u32 };
        cells.extend([end, end]);
    }
}
