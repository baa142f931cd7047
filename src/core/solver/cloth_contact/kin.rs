//! Pairs of particles that are near each other at rest.
//!
//! Some that share no edge are nearer at rest than other pairs may come, so that they are kept apart by a part of their distance at
//! rest instead. Left alone, the small triangles of an irregular mesh would pass through each other in a tight fold.
//!
//! Others of a mesh are so near that they may touch as soon as the cloth has moved by the margin, though it was flat.

use crate::solver::cloth_contact::faces::FacesAt;
use crate::solver::cloth_contact::find::{Company, FindPairs, NEIGHBOURS, Pair};
use crate::solver::cloth_contact::grid::Grid;
use crate::solver::cloth_contact::patch::NARROW;
use crate::solver::simd::block::smaller;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::soa::Soa;

/// Distance at which they touch, in their distance at rest, at most.
const PART: f32 = 0.8;

/// Particles at rest.
pub(super) struct AtRest<'a> {
    pub faces: &'a FacesAt,
    /// Positions and radii by slot, and the largest distance at which two touch \[m\].
    pub at: &'a Soa,
    pub radius: &'a [f32],
    pub widest: f32,
}

/// Finds those that are nearer at rest than other pairs may come, and share no edge: pairs that have no gap yet.
pub(super) fn find_kin(
    isa: Isa,
    rest: &AtRest<'_>,
    slots: impl Iterator<Item = usize>,
) -> Vec<Pair> {
    let margin = (NEIGHBOURS - 1.0) * rest.widest;
    let is_kin = |pair: &Pair| {
        pair.gap + pair.reach < NEIGHBOURS * pair.reach && !rest.faces.share_an_edge(pair.slots)
    };
    let mut pairs = find_near(isa, rest, margin, slots, is_kin);
    for Pair { reach, gap, .. } in &mut pairs {
        *reach = smaller(*reach, PART * (*gap + *reach));
    }
    pairs
}

/// Finds those that may touch as soon as the cloth has moved by the margin, though it was flat. The corners of two triangles that
/// share an edge are not among them, as those of a cell are not on a sheet.
pub(super) fn find_beside(
    isa: Isa,
    rest: &AtRest<'_>,
    margin: f32,
    slots: impl Iterator<Item = usize>,
) -> Vec<Pair> {
    let most = |reach: f32| (reach + margin) / NARROW;
    let is_beside = |pair: &Pair| {
        let distance = pair.gap + pair.reach;
        (NEIGHBOURS * pair.reach..most(pair.reach)).contains(&distance)
            && !rest.faces.share_an_edge(pair.slots)
            && !rest.faces.face_each_other(pair.slots)
    };
    find_near(isa, rest, most(rest.widest) - rest.widest, slots, is_beside)
}

/// Finds the wanted ones of all pairs up to a gap.
fn find_near(
    isa: Isa,
    rest: &AtRest<'_>,
    margin: f32,
    slots: impl Iterator<Item = usize>,
    is_wanted: impl Fn(&Pair) -> bool,
) -> Vec<Pair> {
    let mut grid = Grid::default();
    let slots: Vec<_> = slots.collect();
    grid.make_room(slots.len());
    grid.begin(rest.widest + margin);
    grid.take(rest.at, slots.into_iter());
    grid.sort(isa, rest.at, rest.radius);
    let mut company = Wanted { is_wanted, pairs: Vec::new() };
    isa.run(FindPairs { grid: &grid, margin, company: &mut company });
    company.pairs
}

struct Wanted<F> {
    is_wanted: F,
    pairs: Vec<Pair>,
}

impl<F: Fn(&Pair) -> bool> Company for &mut Wanted<F> {
    fn among(&self, lanes: u32, _: usize, _: usize) -> u32 {
        lanes
    }

    fn take(&mut self, _: [usize; 2], pair: Pair) {
        if (self.is_wanted)(&pair) {
            self.pairs.push(pair);
        }
    }
}
