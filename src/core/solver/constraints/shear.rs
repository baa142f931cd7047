//! Shear of threads while corrections are carried on (`integrate::houbolt`): all springs across the cells corrected at once,
//! each from where the particles were before any was (Jacobi's iteration).
//!
//! The order in which springs are corrected one after the other gives what moves a direction, and sheets
//! gain energy by it once corrections are carried on: a sweep to and fro does not, and costs
//! twice as much. All at once has no order, and passes over the rows but once.
//!
//! A spring alone bears no more than `k = 0.4 / (w h^2)`: what is stiffer is solved along whole diagonals (`threads::bias`).

use core::mem;

use crate::solver::constraints::strain_limit::{LEAST_DIVISOR, LEAST_LENGTH, mobility_without};
use crate::solver::contact::{Contacts, Normals, divide};
use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, Blocks3Mut, larger};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{Band, Seams, Workspaces, cut_between_rows};
use crate::solver::simd::slots::{CutAt, Slots};
use crate::solver::simd::soa::{PartMut, Soa};
use crate::solver::topology::lattice::Lattice;

/// Two springs lie in line at a particle, and each of all four may pull: a correction moves its ends by no
/// more than this part of what it would take alone.
const CROWD: f32 = 2.5;

/// Whether a pass over the cells bears shear springs whole whose frequencies are `omega^2` at most \[1/s2\], in a substep \[s\]. A spring of
/// constant k has `omega^2 = 8 k w`, and the half of its pull that is not carried on is corrected.
pub(crate) fn bears(rate: f32, step: f32, crowd: f32) -> bool {
    rate * step * step * CROWD * crowd <= 8.0
}

/// How far shear springs are corrected.
#[derive(Clone, Copy)]
pub(crate) struct ShearRule {
    /// `1 / (k h^2)` of a spring of shape factor one \[1/kg\].
    pub compliance: f32,
    /// Longest that a spring may be, in rest lengths.
    pub limit: f32,
    /// Factor of [`CROWD`] on this lattice: `1 + |cos g|` for the largest of the angles g between the diagonals of a cell.
    pub crowd: f32,
}

impl ShearRule {
    /// How strongly a spring pulls for each metre of its length, as the correction of an end of inverse mass
    /// one \[kg\]: to its rest length, or to its limit where that is more.
    #[inline(always)]
    pub fn pull(&self, length: f32, rest: f32, factor: f32, inverse_masses: f32) -> f32 {
        let stiffest = larger(inverse_masses, LEAST_DIVISOR) * (CROWD * self.crowd);
        let divisor = larger(factor * self.compliance, stiffest);
        let (elastic, limited) = (length - rest, length - rest * self.limit);
        // The larger of two fractions, and but one division.
        let is_limited = limited * divisor > elastic * stiffest;
        let (over, by) = if is_limited { (limited, stiffest) } else { (elastic, divisor) };
        if rest > 0.0 { over / (by * length) } else { 0.0 }
    }
}

/// The springs across the cells of a lattice.
#[derive(Clone, Copy)]
pub(crate) struct Cells<'a> {
    pub lattice: &'a Lattice,
    pub inverse_mass: &'a [f32],
    pub rule: ShearRule,
    pub x: &'a Soa,
    /// Normals of what particles lie on, where any do.
    pub normals: Option<&'a Normals>,
}

/// Corrects the shear springs of a lattice.
pub(crate) struct CorrectShear<'a> {
    pub band: Band,
    pub cells: Cells<'a>,
    pub d: PartMut<'a>,
    /// The contacts of particles, where any lies on a collider.
    pub contacts: Option<Contacts<'a>>,
    /// Displacements on both sides of the cuts, before any is corrected.
    pub seams: &'a Seams,
    pub rooms: &'a Workspaces<RowPulls>,
}

/// Pulls of the springs from one row to the next, and of those from the row before to it, by column from
/// [`LANES`] on.
#[derive(Clone, Debug)]
pub(crate) struct RowPulls {
    /// Pulls of the springs to the next column.
    right: Soa,
    right_before: Soa,
    /// Pulls of the springs to the column before.
    left: Soa,
    left_before: Soa,
}

impl RowPulls {
    /// Room for rows of so many columns.
    pub fn new(columns: usize) -> Self {
        let row = Soa::zeros(columns.next_multiple_of(LANES) + 2 * LANES);
        Self { right: row.clone(), right_before: row.clone(), left: row.clone(), left_before: row }
    }

    fn clear(&mut self) {
        for pulls in
            [&mut self.right, &mut self.right_before, &mut self.left, &mut self.left_before]
        {
            pulls.clear();
        }
    }

    /// Goes on to the next row: the pulls of this one become those of the row before.
    fn turn(&mut self) {
        mem::swap(&mut self.right, &mut self.right_before);
        mem::swap(&mut self.left, &mut self.left_before);
    }
}

impl Kernel for CorrectShear<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { band: Band { layout, rows, .. }, cells, mut d, mut contacts, seams, rooms } =
            self;
        let mut pulls = rooms.take();
        pulls.clear();
        if rows.start > 0 {
            cells.pull_from_above(rows.start, seams, &mut pulls);
        }
        for row in rows.clone() {
            pulls.turn();
            let (mut own, below) = d.reborrow().cut(layout.slot(row + 1, 0) - LANES);
            // What is below has been corrected by now, perhaps.
            if row + 1 == rows.end && rows.end < layout.rows {
                let below = seams.row(rows.end);
                cells.correct_row(row, &mut own, &below, &mut pulls, &mut contacts);
            } else {
                cells.correct_row(row, &mut own, &below, &mut pulls, &mut contacts);
            }
        }
    }
}

cut_between_rows!(CorrectShear, d, contacts);

impl<'a> Cells<'a> {
    /// Works out the pulls between the row before the band and its first.
    #[inline(always)]
    fn pull_from_above(&self, first: usize, seams: &Seams, pulls: &mut RowPulls) {
        let (above, below) = (seams.row(first - 1), seams.row(first));
        let springs = RowSprings::new(self, first - 1, &below);
        let touch = self.touch(first - 1);
        let d = Blocks3::new(&above, self.lattice.layout.slot(first - 1, 0), springs.blocks);
        let mut right = Blocks3Mut::new(&mut pulls.right, LANES, springs.blocks);
        let mut left = Blocks3Mut::new(&mut pulls.left, LANES, springs.blocks);
        for block in 0..springs.blocks {
            let d = d.at(block);
            let found = if touch {
                springs.pulls::<true>(block, &d)
            } else {
                springs.pulls::<false>(block, &d)
            };
            right.set(block, found[0]);
            left.set(block, found[1]);
        }
    }

    /// Whether any particle of a row and the next lies on a collider.
    #[inline(always)]
    fn touch(&self, row: usize) -> bool {
        let layout = self.lattice.layout;
        let of = |normals: &Normals, row| {
            normals.touch(layout.slot(row, 0) / LANES, layout.blocks_across(), 1)
        };
        match self.normals {
            Some(normals) => of(normals, row) || of(normals, row + 1),
            None => false,
        }
    }

    /// Corrects a row, at which nothing looks any more afterwards.
    #[inline(always)]
    fn correct_row(
        &self,
        row: usize,
        own: &mut PartMut<'_>,
        below: &impl Slots,
        pulls: &mut RowPulls,
        contacts: &mut Option<Contacts<'_>>,
    ) {
        match contacts {
            Some(contacts) if self.touch(row) => {
                self.correct::<true>(row, own, below, pulls, Some(contacts));
            }
            _ => self.correct::<false>(row, own, below, pulls, None),
        }
    }

    /// The same, where any of its particles or their neighbours lies on a collider, or none does.
    #[inline(always)]
    fn correct<const TOUCH: bool>(
        &self,
        row: usize,
        own: &mut PartMut<'_>,
        below: &impl Slots,
        pulls: &mut RowPulls,
        mut contacts: Option<&mut Contacts<'_>>,
    ) {
        let springs = RowSprings::new(self, row, below);
        let (blocks, slot) = (springs.blocks, self.lattice.layout.slot(row, 0));
        let mut d = Blocks3Mut::new(own, slot, blocks);
        let mut right = Blocks3Mut::new(&mut pulls.right, LANES, blocks);
        let mut left = Blocks3Mut::new(&mut pulls.left, LANES, blocks);
        let above_right = Blocks3::new(&pulls.right_before, LANES - 1, blocks);
        let above_left = Blocks3::new(&pulls.left_before, LANES + 1, blocks);
        for block in 0..blocks {
            let mut corrected = d.at(block);
            let [to_right, to_left] = springs.pulls::<TOUCH>(block, &corrected);
            let (from_right, from_left) = (above_right.at(block), above_left.at(block));
            let w = if TOUCH { springs.mobile(0, block) } else { springs.w[0].at(block) };
            let mut pull = Block3::ZERO;
            for i in 0..LANES {
                let both = to_right.at(i) + to_left.at(i) - from_right.at(i) - from_left.at(i);
                pull.set(i, both);
            }
            if TOUCH {
                let (along, load) = divide(&pull, &springs.normal(0, block));
                pull = along;
                if let Some(contacts) = &mut contacts {
                    contacts.add(slot + block * LANES, &load);
                }
            }
            for i in 0..LANES {
                corrected.set(i, corrected.at(i) + pull.at(i) * w.0[i]);
            }
            d.set(block, corrected);
            right.set(block, to_right);
            left.set(block, to_left);
        }
    }
}

/// The springs from the particles of a row to the next row: to the column after, and to the column before.
struct RowSprings<'a> {
    blocks: usize,
    rule: ShearRule,
    /// Where the substep began: the row, and both ends below it.
    x: [Blocks3<'a>; 3],
    /// Displacements of those ends.
    d: [Blocks3<'a>; 2],
    /// Inverse masses of the row and of those ends.
    w: [Blocks<'a>; 3],
    /// Normals of what they lie on, where any do.
    normals: Option<[(Blocks3<'a>, Blocks<'a>); 3]>,
    rest: [Blocks<'a>; 2],
    factor: [Blocks<'a>; 2],
}

impl<'a> RowSprings<'a> {
    #[expect(
        clippy::manual_map,
        reason = "a closure that is not inlined keeps the baseline's instructions"
    )]
    #[inline(always)]
    fn new(cells: &Cells<'a>, row: usize, below: &'a impl Slots) -> Self {
        let Cells { lattice, inverse_mass, rule, x, normals } = *cells;
        let blocks = lattice.layout.blocks_across();
        let (slot, next) = (lattice.layout.slot(row, 0), lattice.layout.slot(row + 1, 0));
        let (right, left) = (next + 1, next - 1);
        let at = |slot| Blocks3::new(x, slot, blocks);
        let masses = |slot| Blocks::new(inverse_mass, slot, blocks);
        let factors = |slot| Blocks::new(&lattice.diagonal.compliance, slot, blocks);
        // Not by `map`s over arrays, which would be calls.
        Self {
            blocks,
            rule,
            x: [at(slot), at(right), at(left)],
            d: [Blocks3::new(below, right, blocks), Blocks3::new(below, left, blocks)],
            w: [masses(slot), masses(right), masses(left)],
            normals: match normals {
                Some(Normals { normal, slip, .. }) => Some([
                    (Blocks3::new(normal, slot, blocks), Blocks::new(slip, slot, blocks)),
                    (Blocks3::new(normal, right, blocks), Blocks::new(slip, right, blocks)),
                    (Blocks3::new(normal, left, blocks), Blocks::new(slip, left, blocks)),
                ]),
                None => None,
            },
            // A cell's springs stand at its first corner, the one across it too.
            rest: [
                Blocks::new(&lattice.diagonal.rest, slot, blocks),
                Blocks::new(&lattice.antidiagonal_rest, slot - 1, blocks),
            ],
            factor: [factors(slot), factors(slot - 1)],
        }
    }

    /// Normals of what the ends of springs lie on: of the row, of those to the right, of those to the left.
    #[inline(always)]
    fn normal(&self, end: usize, block: usize) -> Block3 {
        match &self.normals {
            Some(normals) => normals[end].0.at(block),
            None => Block3::ZERO,
        }
    }

    /// Inverse masses of the same, as far as friction lets them go.
    #[inline(always)]
    fn mobile(&self, end: usize, block: usize) -> Block {
        let mut w = self.w[end].at(block);
        if let Some(normals) = &self.normals {
            let slip = normals[end].1.at(block);
            for i in 0..LANES {
                w.0[i] *= slip.0[i];
            }
        }
        w
    }

    /// Where a block of the row, of displacements `d`, and the springs' other ends are.
    #[inline(always)]
    fn ends(&self, block: usize, d: &Block3) -> [Block3; 3] {
        [
            self.x[0].at(block).plus(d),
            self.x[1].at(block).plus(&self.d[0].at(block)),
            self.x[2].at(block).plus(&self.d[1].at(block)),
        ]
    }

    /// Mobility that colliders take from the springs to the ends on one side, times the square of their lengths.
    #[inline(always)]
    fn taken(&self, block: usize, side: usize, ends: [&Block3; 2], w: [&Block; 2]) -> Block {
        let (n, n_side) = (self.normal(0, block), self.normal(side, block));
        let mut taken = Block::ZERO;
        for i in 0..LANES {
            let span = ends[1].at(i) - ends[0].at(i);
            let across = [n.at(i).dot(span), n_side.at(i).dot(span)];
            taken.0[i] = w[0].0[i] * (across[0] * across[0]) + w[1].0[i] * (across[1] * across[1]);
        }
        taken
    }

    /// Pulls on a block of the row, of displacements `d`: both springs in one loop, whose roots and quotients then
    /// follow each other without waiting. What contact adds has loops of its own, or too much would be at hand at once.
    #[inline(always)]
    fn pulls<const TOUCH: bool>(&self, block: usize, d: &Block3) -> [Block3; 2] {
        let [here, at_right, at_left] = self.ends(block, d);
        let [w, w_right, w_left] = if TOUCH {
            [self.mobile(0, block), self.mobile(1, block), self.mobile(2, block)]
        } else {
            [self.w[0].at(block), self.w[1].at(block), self.w[2].at(block)]
        };
        let (mut taken_right, mut taken_left) = (Block::ZERO, Block::ZERO);
        if TOUCH {
            taken_right = self.taken(block, 1, [&here, &at_right], [&w, &w_right]);
            taken_left = self.taken(block, 2, [&here, &at_left], [&w, &w_left]);
        }
        let [rest_right, rest_left] = [self.rest[0].at(block), self.rest[1].at(block)];
        let [factor_right, factor_left] = [self.factor[0].at(block), self.factor[1].at(block)];
        let (mut right, mut left) = (Block3::ZERO, Block3::ZERO);
        for i in 0..LANES {
            let (to_right, to_left) = (at_right.at(i) - here.at(i), at_left.at(i) - here.at(i));
            let length_right = larger(to_right.dot(to_right).sqrt(), LEAST_LENGTH);
            let length_left = larger(to_left.dot(to_left).sqrt(), LEAST_LENGTH);
            let (mut both_right, mut both_left) = (w.0[i] + w_right.0[i], w.0[i] + w_left.0[i]);
            if TOUCH {
                both_right = mobility_without(both_right, taken_right.0[i], length_right);
                both_left = mobility_without(both_left, taken_left.0[i], length_left);
            }
            let rule = &self.rule;
            let by_right = rule.pull(length_right, rest_right.0[i], factor_right.0[i], both_right);
            let by_left = rule.pull(length_left, rest_left.0[i], factor_left.0[i], both_left);
            right.set(i, to_right * by_right);
            left.set(i, to_left * by_left);
        }
        [right, left]
    }
}
