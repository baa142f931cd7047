//! Pairs of particles that may touch before the cloth has moved by the margin.

use bevy_math::Vec3;

use crate::solver::cloth_contact::grid::{Grid, ROWS};
use crate::solver::simd::block::larger;
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::soa::Soa;

/// Distance at rest, in distances at which two particles touch, up to which they are neighbours that are left alone.
pub(super) const NEIGHBOURS: f32 = 1.2;
/// Particles that are looked at together. Runs are short, so that wider blocks would be half empty.
pub(super) const WIDE: usize = 8;

/// Two particles that may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pair {
    pub slots: [u32; 2],
    /// Distance at which they touch \[m\].
    pub reach: f32,
    /// How much further apart they were when they were found \[m\].
    pub gap: f32,
}

impl Pair {
    /// It, as it is now, if its gap is within a margin.
    pub fn now(&self, at: &Soa, margin: f32) -> Option<Self> {
        let [a, b] = self.slots.map(|slot| at.get(slot as usize));
        let gap = a.distance(b) - self.reach;
        (gap < margin).then_some(Self { gap, ..*self })
    }
}

/// Radii of the larger of two balls that their centres are apart at least where they touch: the smaller ones of a finer cloth are
/// to find no way between those of a coarser one.
const UNEVEN: f32 = 1.7;

/// The particles that may be pairs, and where pairs go.
pub(super) trait Company {
    /// Of the particles of a group that begins at `at`, a bit each, those that may meet the one at a place.
    fn among(&self, lanes: u32, at: usize, place: usize) -> u32;
    /// Takes in a pair of particles, by their places in the grid.
    fn take(&mut self, places: [usize; 2], pair: Pair);
}

/// Finds pairs: of each particle with those that come after it in its cell, in the next one, and in the rows of three cells after
/// these.
pub(super) struct FindPairs<'a, C> {
    pub grid: &'a Grid,
    pub margin: f32,
    pub company: C,
}

impl<C: Company> Kernel for FindPairs<'_, C> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let cells = &self.grid.cells;
        let (mut lows, mut highs) = ([0; ROWS.len()], [0; ROWS.len()]);
        for here in 0..cells.len() - 2 {
            let [cell, next, second] = [cells[here], cells[here + 1], cells[here + 2]];
            let places = [cell.first as usize, next.first as usize];
            let own = if next.key == cell.key + 1 { second.first } else { next.first };
            self.look(places, places[0], own as usize, true);
            for (row, step) in ROWS.into_iter().enumerate() {
                let middle = cell.key + step;
                while cells[lows[row]].key < middle - 1 {
                    lows[row] += 1;
                }
                highs[row] = highs[row].max(lows[row]);
                while cells[highs[row]].key <= middle + 1 {
                    highs[row] += 1;
                }
                let [first, end] = [lows[row], highs[row]].map(|at| cells[at].first as usize);
                self.look(places, first, end, false);
            }
        }
    }
}

/// A group of particles whose places follow each other.
pub(super) struct Group<const N: usize> {
    x: [[f32; N]; 3],
    radius: [f32; N],
}

impl<const N: usize> Group<N> {
    #[inline(always)]
    pub fn load(x: &Soa, radius: &[f32], at: usize) -> Self {
        Self { x: [take(&x.x, at), take(&x.y, at), take(&x.z, at)], radius: take(radius, at) }
    }

    /// The particles that are nearer to a point than `factor` times the distance at which they touch, and something more: a bit each.
    #[inline(always)]
    pub fn near(&self, point: Vec3, radius: f32, factor: f32, more: f32) -> u32 {
        let [x, y, z] = &self.x;
        let mut bits = [0_u32; N];
        for i in 0..N {
            let apart = Vec3::new(x[i], y[i], z[i]) - point;
            let most = reach(self.radius[i], radius) * factor + more;
            bits[i] = if apart.dot(apart) < most * most { 1 << i } else { 0 };
        }
        bits.into_iter().fold(0, |all, bit| all | bit)
    }

    /// The pair of one of the particles, in a lane, with one at a point.
    #[inline(always)]
    pub fn pair(&self, lane: usize, point: Vec3, radius: f32, slots: [u32; 2]) -> Pair {
        let apart = Vec3::from(self.x.map(|along| along[lane])) - point;
        let reach = reach(self.radius[lane], radius);
        Pair { slots, reach, gap: apart.dot(apart).sqrt() - reach }
    }
}

/// Distance at which two balls touch \[m\].
#[inline(always)]
pub(super) fn reach(a: f32, b: f32) -> f32 {
    larger(a + b, UNEVEN * larger(a, b))
}

#[inline(always)]
fn take<const N: usize>(values: &[f32], at: usize) -> [f32; N] {
    let mut out = [0.0; N];
    out.copy_from_slice(&values[at..at + N]);
    out
}

impl<C: Company> FindPairs<'_, C> {
    /// Looks at the particles of a cell and some others, by their places: at all of them, or at those that come after.
    #[inline(always)]
    fn look(&mut self, cell: [usize; 2], first: usize, end: usize, after: bool) {
        let grid = self.grid;
        for at in (first..end).step_by(WIDE) {
            let others = Group::<WIDE>::load(&grid.x, &grid.radius, at);
            // Lanes before the end.
            let inside = if end - at < WIDE { (1 << (end - at)) - 1 } else { (1 << WIDE) - 1 };
            for place in cell[0]..cell[1] {
                let (p, r) = (grid.x.get(place), grid.radius[place]);
                let mut lanes = others.near(p, r, 1.0, self.margin) & inside;
                if after {
                    let passed = (place + 1).saturating_sub(at).min(WIDE);
                    lanes &= !((1 << passed) - 1);
                }
                if lanes == 0 {
                    continue;
                }
                lanes = self.company.among(lanes, at, place);
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize;
                    lanes &= lanes - 1;
                    let slots = [grid.slots[place], grid.slots[at + lane]];
                    self.company.take([place, at + lane], others.pair(lane, p, r, slots));
                }
            }
        }
    }
}
