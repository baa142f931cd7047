//! Measures of a tick: whether all is finite, how far anything moved, how far threads stretched.

use bevy_math::Vec3;

use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, larger, smaller};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{Band, Merge, cut_between_rows};
use crate::solver::simd::soa::Soa;
use crate::solver::state::State;
use crate::solver::topology::Topology;
use crate::solver::topology::lattice::Lattice;

/// Lengths of structural springs against their rest lengths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrainReport {
    /// Largest strain.
    pub max: f32,
    /// Strain that 99 % of the springs stay below.
    pub p99: f32,
    /// Mean strain.
    pub mean: f32,
}

impl StrainReport {
    /// The strains of all structural springs of positions `x`. Sorts them: for reports, not for
    /// every frame.
    pub(crate) fn new(topology: &Topology, x: &Soa) -> Self {
        let mut strains: Vec<f32> = strains(topology, x).collect();
        strains.sort_by(f32::total_cmp);
        let count = strains.len();
        let Some(&max) = strains.last() else { return Self::default() };
        let mean = strains.iter().map(|&s| f64::from(s)).sum::<f64>() / count as f64;
        Self { max, p99: strains[count * 99 / 100], mean: mean as f32 }
    }
}

/// Strains of all structural springs of positions `x`.
pub(crate) fn strains<'a>(topology: &'a Topology, x: &'a Soa) -> impl Iterator<Item = f32> + 'a {
    topology
        .structural_springs()
        .map(|(a, b, rest)| x.get(topology.slot(a)).distance(x.get(topology.slot(b))) / rest - 1.0)
}

/// One look at the positions at a tick's end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Survey {
    /// Whether all positions and velocities are finite.
    pub finite: bool,
    /// Largest change of a coordinate in the tick \[m\].
    pub moved: f32,
    /// Largest strain of a structural spring.
    pub max_strain: f32,
    /// Bounds of the positions, relative to the origin \[m\].
    pub min: Vec3,
    /// See `min`.
    pub max: Vec3,
}

/// Takes a [`Survey`].
pub(crate) struct TakeSurvey<'a> {
    pub band: Band,
    /// The lattice whose springs are looked at.
    pub lattice: Option<&'a Lattice>,
    pub x: &'a Soa,
    pub d: &'a Soa,
    pub start: &'a Soa,
}

impl<'a> TakeSurvey<'a> {
    pub fn new(band: Band, lattice: Option<&'a Lattice>, state: &'a State) -> Self {
        let State { x, d, start, .. } = state;
        Self { band, lattice, x, d, start }
    }
}

impl Kernel for TakeSurvey<'_> {
    type Output = Survey;

    #[inline(always)]
    fn run(self) -> Survey {
        let layout = self.band.layout;
        let mut totals = Totals::at(self.x.get(layout.slot(0, 0)));
        let blocks = layout.blocks_across();
        for row in self.band.rows.clone() {
            let slot = layout.slot(row, 0);
            let x = Blocks3::new(self.x, slot, blocks);
            let d = Blocks3::new(self.d, slot, blocks);
            let start = Blocks3::new(self.start, slot, blocks);
            // By no closure, which may be a call.
            let springs = match self.lattice {
                Some(lattice) => Some([
                    (
                        Blocks3::new(self.x, slot + 1, blocks),
                        Blocks::new(&lattice.weft.rest, slot, blocks),
                    ),
                    (
                        Blocks3::new(self.x, slot + layout.stride, blocks),
                        Blocks::new(&lattice.warp.rest, slot, blocks),
                    ),
                ]),
                None => None,
            };
            for block in 0..blocks {
                let here = x.at(block);
                let inside = layout.inside(row, block * LANES);
                totals.look_at_particles(&here, &d.at(block), &start.at(block), inside);
                for (there, rest) in springs.iter().flatten() {
                    totals.look_at_springs(&here, &there.at(block), &rest.at(block));
                }
            }
        }
        totals.survey()
    }
}

cut_between_rows!(TakeSurvey);

impl Merge for Survey {
    fn merge(self, below: Self) -> Self {
        Self {
            finite: self.finite && below.finite,
            moved: larger(self.moved, below.moved),
            max_strain: larger(self.max_strain, below.max_strain),
            min: self.min.min(below.min),
            max: self.max.max(below.max),
        }
    }
}

/// Measures of the particles seen so far, a lane each.
struct Totals {
    moved: Block,
    /// Squares of lengths over rest lengths.
    stretch: Block,
    spoiled: Block,
    low: Block3,
    high: Block3,
}

impl Totals {
    fn at(first: Vec3) -> Self {
        Self {
            moved: Block::ZERO,
            stretch: Block::ZERO,
            spoiled: Block::ZERO,
            low: Block3::splat(first),
            high: Block3::splat(first),
        }
    }

    fn survey(&self) -> Survey {
        let (least, most) = (Block::smallest, Block::largest);
        Survey {
            finite: self.spoiled.0.iter().all(|&lane| lane == 0.0),
            moved: self.moved.largest(),
            max_strain: self.stretch.largest().sqrt() - 1.0,
            min: Vec3::new(least(&self.low.x), least(&self.low.y), least(&self.low.z)),
            max: Vec3::new(most(&self.high.x), most(&self.high.y), most(&self.high.z)),
        }
    }
}

impl Totals {
    /// Looks at a block of which this many are of the cloth.
    #[inline(always)]
    fn look_at_particles(&mut self, x: &Block3, d: &Block3, start: &Block3, inside: usize) {
        for i in 0..LANES {
            let (p, u) = (x.at(i), d.at(i));
            // Anything times zero is zero, unless it is not finite.
            self.spoiled.0[i] += (p.x + p.y + p.z + u.x + u.y + u.z) * 0.0;
            let way = p - start.at(i);
            let most = larger(larger(way.x.abs(), way.y.abs()), way.z.abs());
            self.moved.0[i] = larger(most, self.moved.0[i]);
            let p = if i < inside { p } else { self.low.at(i) };
            let (low, high) = (self.low.at(i), self.high.at(i));
            self.low
                .set(i, Vec3::new(smaller(p.x, low.x), smaller(p.y, low.y), smaller(p.z, low.z)));
            self.high
                .set(i, Vec3::new(larger(p.x, high.x), larger(p.y, high.y), larger(p.z, high.z)));
        }
    }

    /// Looks at the springs between two blocks.
    #[inline(always)]
    fn look_at_springs(&mut self, here: &Block3, there: &Block3, rest: &Block) {
        for i in 0..LANES {
            let d = there.at(i) - here.at(i);
            let rest = rest.0[i];
            let stretch = d.dot(d) / larger(rest * rest, f32::MIN_POSITIVE);
            let stretch = if rest > 0.0 { stretch } else { 0.0 };
            self.stretch.0[i] = larger(stretch, self.stretch.0[i]);
        }
    }
}
