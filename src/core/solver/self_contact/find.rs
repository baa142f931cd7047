//! Pairs of particles that may touch before the cloth has moved by the margin.

use crate::solver::self_contact::grid::{Grid, ROWS};
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;

/// Distance at rest, in distances at which two particles touch, up to which they are neighbours that are left alone.
const NEIGHBOURS: f32 = 2.0;

/// Two particles that may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pair {
    pub slots: [u32; 2],
    /// Distance at which they touch \[m\].
    pub reach: f32,
    /// How much further apart they were when they were found \[m\].
    pub gap: f32,
}

/// Finds pairs: of each particle with those that come after it in its cell, in the next one, and in the rows of three cells after
/// these.
pub(super) struct FindPairs<'a> {
    pub grid: &'a Grid,
    pub margin: f32,
    pub pairs: &'a mut Vec<Pair>,
}

impl Kernel for FindPairs<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let cells = &self.grid.cells;
        let (mut lows, mut highs) = ([0; ROWS.len()], [0; ROWS.len()]);
        for here in 0..cells.len() - 2 {
            let [cell, next, second] = [cells[here], cells[here + 1], cells[here + 2]];
            let own = if next.key == cell.key + 1 { second.first } else { next.first };
            let mut runs = [[0; 2]; ROWS.len()];
            for (row, step) in ROWS.into_iter().enumerate() {
                let middle = cell.key + step;
                while cells[lows[row]].key < middle - 1 {
                    lows[row] += 1;
                }
                highs[row] = highs[row].max(lows[row]);
                while cells[highs[row]].key <= middle + 1 {
                    highs[row] += 1;
                }
                runs[row] = [cells[lows[row]].first, cells[highs[row]].first];
            }
            for place in cell.first as usize..next.first as usize {
                self.look(place, place + 1, own as usize);
                for [first, end] in runs {
                    self.look(place, first as usize, end as usize);
                }
            }
        }
    }
}

impl FindPairs<'_> {
    /// Looks at a particle and some others, by their places.
    #[inline(always)]
    fn look(&mut self, place: usize, first: usize, end: usize) {
        let grid = self.grid;
        let (p, q, r) = (grid.x.get(place), grid.rest.get(place), grid.radius[place]);
        for at in (first..end).step_by(LANES) {
            let (x, rest) = (Block3::load(&grid.x, at), Block3::load(&grid.rest, at));
            let radius = Block::load(&grid.radius, at);
            let left = (end - at) as f32;
            let mut near = Block::ZERO;
            for i in 0..LANES {
                let (apart, at_rest) = (x.at(i) - p, rest.at(i) - q);
                let reach = radius.0[i] + r;
                let (most, least) = (reach + self.margin, reach * NEIGHBOURS);
                let is_near = apart.dot(apart) < most * most && at_rest.dot(at_rest) > least * least;
                near.0[i] = if is_near && (i as f32) < left { 1.0 } else { 0.0 };
            }
            if !near.is_any() {
                continue;
            }
            for i in 0..LANES {
                if near.0[i] != 0.0 {
                    let reach = radius.0[i] + r;
                    let gap = (x.at(i) - p).length() - reach;
                    let slots = [grid.slots[place], grid.slots[at + i]];
                    self.pairs.push(Pair { slots, reach, gap });
                }
            }
        }
    }
}
