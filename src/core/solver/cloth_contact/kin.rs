//! Particles that are near each other at rest, and share no edge.
//!
//! They are nearer at rest than other pairs may come, so that they are kept apart by a part of their distance at rest instead. Left
//! alone, the small triangles of an irregular mesh would pass through each other in a tight fold.

use crate::solver::cloth_contact::faces::FacesAt;
use crate::solver::cloth_contact::find::{Company, FindPairs, NEIGHBOURS, Pair};
use crate::solver::cloth_contact::grid::Grid;
use crate::solver::simd::block::smaller;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::soa::Soa;

/// Distance at which they touch, in their distance at rest, at most.
const PART: f32 = 0.8;

/// Finds them among particles that are at rest: pairs that have no gap yet.
pub(super) fn find_kin(
    isa: Isa,
    grid: &mut Grid,
    (rest, radius): (&Soa, &[f32]),
    widest: f32,
    faces: &FacesAt,
    slots: impl Iterator<Item = usize>,
) -> Vec<Pair> {
    let margin = (NEIGHBOURS - 1.0) * widest;
    grid.begin(widest + margin);
    grid.take(rest, slots);
    grid.sort(isa, rest, radius);
    let mut company = Kin { faces, pairs: Vec::new() };
    isa.run(FindPairs { grid, margin, company: &mut company });
    company.pairs
}

struct Kin<'a> {
    faces: &'a FacesAt,
    pairs: Vec<Pair>,
}

impl Company for &mut Kin<'_> {
    fn among(&self, lanes: u32, _: usize, _: usize) -> u32 {
        lanes
    }

    fn take(&mut self, _: [usize; 2], pair: Pair) {
        let rest = pair.gap + pair.reach;
        let [a, b] = pair.slots;
        let share_an_edge = self.faces.of(a as usize).flatten().any(|corner| corner == b);
        if rest < NEIGHBOURS * pair.reach && !share_an_edge {
            self.pairs.push(Pair { reach: smaller(pair.reach, PART * rest), ..pair });
        }
    }
}
