//! Friction inside the fabric: yarns that rub on each other resist a change of curvature with the same moment,
//! however slow it is.
//!
//! Measured on fabrics, the moment at a curvature differs by 2HB between bending and unbending (Kawabata 1980, *The
//! Standardization and Analysis of Hand Evaluation*; as a model of cloth: Miguel et al. 2013, *Modeling and
//! Estimation of Internal Friction in Cloth*). It is what brings a cloth to rest: air and elastic forces let small
//! movements go on for minutes, and a constant moment ends them in a few swings.
//!
//! A hinge is a particle and two others, one before and one after it on its thread. Its bend goes from the particle to the
//! line between these, at right angles. Friction reduces the rate of its length, at the most to none. What acts along the
//! bend has neither a resultant nor a moment, so that a free cloth keeps its momentum and its spin, and nothing resists
//! stretching. Wide folds bend each short hinge by next to nothing in a substep, and friction between neighbours
//! alone would be too slow to stop them. So there are hinges of several widths ([`widths`]), each a multigrid level of
//! the same friction.
//!
//! All hinges of a width are braked at once, by a part of what would stop each alone. A hinge shares particles with four
//! others of its thread: whatever the masses, no velocity is turned round as long as the part is at most 1/5. Beside explicit
//! springs it is less: they are stable up to `h^2 omega^2 / 4 < 1 - c / 2` for what loses the part c of its velocity.

use bevy_math::Vec3;

use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, Blocks3Mut, larger};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::parallel::{Band, cut_between_rows};
use crate::solver::simd::soa::{Array, PartMut, Soa, ValuesMut};

/// Time from one braking to the next \[s\].
pub(crate) const EVERY: f32 = 1.0 / 120.0;
/// Part of its rate that a hinge is braked by at the most, together with all that it shares particles with: beside
/// threads, and beside springs.
pub(crate) const MOST_OF_THREADS: f32 = 1.0;
pub(crate) const MOST_OF_SPRINGS: f32 = 0.2;
/// Share of one hinge in that part.
pub(crate) const PART: f32 = 0.2;
/// Least square of a length that has a direction \[m2\].
const LEAST_SQUARE: f32 = 1e-20;

/// Room to work in, by the slots of middles.
#[derive(Clone, Debug)]
pub(crate) struct Brakes {
    pub impulses: Soa,
    pub parts: Array,
}

impl Brakes {
    pub fn new(slots: usize) -> Self {
        Self { impulses: Soa::zeros(slots), parts: Array::zeros(slots) }
    }
}

/// Which way a thread runs.
#[derive(Clone, Copy)]
pub(crate) enum Thread {
    /// Along a row.
    Weft,
    /// Along a column.
    Warp,
}

impl Thread {
    pub(crate) fn particles(self, layout: Layout) -> usize {
        match self {
            Self::Weft => layout.columns,
            Self::Warp => layout.rows,
        }
    }
}

/// Hinges along one family of threads, between particles that are `width` from each other.
#[derive(Clone, Copy)]
pub(crate) struct WideHinges {
    pub thread: Thread,
    pub width: usize,
    pub layout: Layout,
}

impl WideHinges {
    /// Slots from the middle of a hinge to its ends.
    #[inline(always)]
    fn hop(&self) -> usize {
        match self.thread {
            Thread::Weft => self.width,
            Thread::Warp => self.width * self.layout.stride,
        }
    }

    /// Whether the particle at a place of its thread is the middle of a hinge.
    #[inline(always)]
    fn is_middle(&self, place: usize) -> bool {
        place >= self.width && place + self.width < self.thread.particles(self.layout)
    }

    /// Whether the particles of a row are middles of hinges, or may be.
    #[inline(always)]
    fn is_middle_row(&self, row: usize) -> bool {
        match self.thread {
            Thread::Weft => true,
            Thread::Warp => self.is_middle(row),
        }
    }

    /// One where a particle of a block is the middle of a hinge, else zero; `ahead` of them, by their columns.
    #[inline(always)]
    fn middles(&self, block: usize, ahead: isize) -> Block {
        let Thread::Weft = self.thread else { return Block::splat(1.0) };
        let (first, count) = (self.width as i32, (self.layout.columns - 2 * self.width) as i32);
        let start = (block * LANES) as i32 + ahead as i32 - first;
        let mut middles = Block::ZERO;
        for i in 0..LANES {
            let place = start + i as i32;
            middles.0[i] = if place >= 0 && place < count { 1.0 } else { 0.0 };
        }
        middles
    }
}

/// Works out the impulses that resist the bending of hinges, at the slots of their middles.
pub(crate) struct Resist<'a> {
    pub band: Band,
    pub hinges: WideHinges,
    /// Width of cloth over the length of a spring, by slot.
    pub shape: &'a [f32],
    /// Part of its rate that a hinge is braked by at the most.
    pub part: f32,
    /// The largest impulse of a hinge of shape one, times the time that makes velocities of displacements \[kg m\].
    pub most: f32,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub d: &'a Soa,
    /// Impulses by the slots of middles, times the time that makes velocities of displacements \[kg m\].
    pub to: PartMut<'a>,
    /// Where the bends end on the lines, as parts of these.
    pub parts: ValuesMut<'a>,
}

impl Kernel for Resist<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Band { layout, rows, .. } = self.band.clone();
        let (blocks, hop) = (layout.blocks_across(), self.hinges.hop());
        for row in rows.filter(|&row| self.hinges.is_middle_row(row)) {
            let slot = layout.slot(row, 0);
            let (before, after) = (slot - hop, slot + hop);
            let x = |slot| Blocks3::new(self.x, slot, blocks);
            let d = |slot| Blocks3::new(self.d, slot, blocks);
            let w = |slot| Blocks::new(self.inverse_mass, slot, blocks);
            let (x0, x1, x2) = (x(before), x(slot), x(after));
            let (d0, d1, d2) = (d(before), d(slot), d(after));
            let (w0, w1, w2) = (w(before), w(slot), w(after));
            let shape = Blocks::new(self.shape, slot, blocks);
            let mut to = Blocks3Mut::new(&mut self.to, slot, blocks);
            let mut all_parts = self.parts.blocks(slot, blocks);
            for block in 0..blocks {
                let (x0, x1, x2) = (x0.at(block), x1.at(block), x2.at(block));
                let (d0, d1, d2) = (d0.at(block), d1.at(block), d2.at(block));
                let (w0, w1, w2) = (w0.at(block), w1.at(block), w2.at(block));
                let (shape, middles) = (shape.at(block), self.hinges.middles(block, 0));
                let (mut impulse, mut parts) = (Block3::ZERO, Block::ZERO);
                for i in 0..LANES {
                    let (line, to_middle) = (x2.at(i) - x0.at(i), x1.at(i) - x0.at(i));
                    let s = part_of(line, to_middle);
                    let bend = line * s - to_middle;
                    let rate = (d2.at(i) - d0.at(i)) * s - (d1.at(i) - d0.at(i));
                    let length = larger(bend.dot(bend), LEAST_SQUARE).sqrt();
                    let (r, w) = (1.0 - s, [w0.0[i], w1.0[i], w2.0[i]]);
                    let inverse_mass = r * r * w[0] + w[1] + s * s * w[2];
                    let divisor = length * larger(inverse_mass, f32::MIN_POSITIVE);
                    let stopping = self.part * bend.dot(rate) / divisor;
                    let most = self.most * shape.0[i] * middles.0[i];
                    let limited = if stopping < most { stopping } else { most };
                    let limited = larger(limited, -most);
                    impulse.set(i, bend * (limited / length));
                    parts.0[i] = s;
                }
                to.set(block, impulse);
                all_parts.set(block, parts);
            }
        }
    }
}

cut_between_rows!(Resist, to, parts);

/// The part of a line that ends beside a point; both from where it begins.
#[inline(always)]
fn part_of(line: Vec3, point: Vec3) -> f32 {
    let part = line.dot(point) / larger(line.dot(line), LEAST_SQUARE);
    let part = if part < 1.0 { part } else { 1.0 };
    larger(part, 0.0)
}

/// Gives particles the impulses of the hinges that they are in.
pub(crate) struct Brake<'a> {
    pub band: Band,
    pub hinges: WideHinges,
    pub inverse_mass: &'a [f32],
    pub impulses: &'a Soa,
    pub parts: &'a [f32],
    pub d: PartMut<'a>,
}

impl Kernel for Brake<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Band { layout, rows, .. } = self.band.clone();
        let (blocks, hop, width) =
            (layout.blocks_across(), self.hinges.hop() as isize, self.hinges.width as isize);
        for row in rows {
            let slot = layout.slot(row, 0);
            let w = Blocks::new(self.inverse_mass, slot, blocks);
            let mut d = Blocks3Mut::new(&mut self.d, slot, blocks);
            let is_row = |ahead: isize| match self.hinges.thread {
                Thread::Weft => true,
                Thread::Warp => {
                    row.checked_add_signed(ahead).is_some_and(|row| self.hinges.is_middle(row))
                }
            };
            // As an end of the hinges on both sides, and as the middle of its own.
            for side in [-1, 0, 1] {
                let ahead = side * width;
                if !is_row(ahead) {
                    continue;
                }
                let at = slot.strict_add_signed(side * hop);
                let impulses = Blocks3::new(self.impulses, at, blocks);
                let parts = Blocks::new(self.parts, at, blocks);
                for block in 0..blocks {
                    let (w, impulses, parts) = (w.at(block), impulses.at(block), parts.at(block));
                    let middles = self.hinges.middles(block, ahead);
                    let mut braked = Block3::ZERO;
                    for i in 0..LANES {
                        let part = match side {
                            -1 => -parts.0[i],
                            0 => 1.0,
                            _ => parts.0[i] - 1.0,
                        };
                        let impulse = impulses.at(i) * (part * w.0[i]);
                        let is_middle = middles.0[i] > 0.0;
                        braked.set(i, if is_middle { impulse } else { Vec3::ZERO });
                    }
                    d.add(block, &braked);
                }
            }
        }
    }
}

cut_between_rows!(Brake, d);
