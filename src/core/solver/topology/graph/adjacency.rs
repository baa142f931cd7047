//! What each particle gathers, as rows of [`LANES`] entries: a block of particles has as many rows as
//! the particle of most entries in it.

use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Array;
use crate::solver::topology::buckets::Buckets;

/// Entries by particle. The constants of the entries are kept apart, in arrays of the same order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Table {
    /// Rows of block i: from `first[i]` to `first[i + 1]`.
    pub first: Vec<u32>,
    /// The slot that an entry refers to: the particle's own where there is none.
    pub to: Vec<u32>,
    /// The index that an entry was made from; `u32::MAX` where there is none.
    pub source: Vec<u32>,
}

impl Table {
    /// Sorts entries `(slot, (to, source))` by slot; they keep their order there.
    pub fn new(slots: usize, entries: &[(u32, (u32, u32))], empty: impl Fn(u32) -> u32) -> Self {
        let entries = Buckets::new(slots, entries);
        let mut table = Self { first: vec![0], to: Vec::new(), source: Vec::new() };
        for block in 0..slots / LANES {
            let lanes: [_; LANES] =
                core::array::from_fn(|lane| entries.of((block * LANES + lane) as u32));
            let rows = lanes.iter().map(|own| own.len()).max().unwrap_or(0);
            for row in 0..rows {
                for (lane, own) in lanes.iter().enumerate() {
                    let (to, source) = match own.get(row) {
                        Some(&entry) => entry,
                        None => (empty((block * LANES + lane) as u32), u32::MAX),
                    };
                    table.to.push(to);
                    table.source.push(source);
                }
            }
            table.first.push((table.to.len() / LANES) as u32);
        }
        table
    }

    /// An entry for each entry, from what it was made of; zero where there is none.
    pub fn fill(&self, values: &mut Array, value: impl Fn(usize) -> f32) {
        for (to, &source) in values.iter_mut().zip(&self.source) {
            *to = if source == u32::MAX { 0.0 } else { value(source as usize) };
        }
    }

    /// Room for a number an entry.
    pub fn room(&self) -> Array {
        Array::zeros(self.to.len())
    }

    /// Where the rows of a block begin and end, in entries.
    #[inline(always)]
    pub fn rows(&self, block: usize) -> (usize, usize) {
        (self.first[block] as usize * LANES, self.first[block + 1] as usize * LANES)
    }
}
