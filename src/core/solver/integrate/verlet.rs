//! Verlet integration in its leapfrog form: `v += a h; x += v h`, with v at the middle of a substep,
//! kept as the displacement `d = v h`.
//!
//! The same method as `x' = 2x - x_prev + a h^2` (Verlet 1967), which in f32 loses the step in its
//! rounding once substeps are many.

use bevy_math::{Vec3, ops};

use crate::solver::integrate::houbolt::PullFilter;
use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, Blocks3Mut};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::parallel::{Band, cut_between_rows};
use crate::solver::simd::soa::{PartMut, Soa};

/// Where the accelerations of a substep come from.
#[derive(Clone, Copy)]
pub(crate) enum Acceleration<'a> {
    /// One acceleration for every particle that is not held \[m/s2\].
    Uniform(Vec3),
    /// A particle's own \[m/s2\].
    Each(&'a Soa),
}

/// Sets the displacements of a substep, for every particle that is not held.
pub(crate) struct Integrate<'a> {
    pub band: Band,
    pub acceleration: Acceleration<'a>,
    pub advance: Advance,
    pub inverse_mass: &'a [f32],
    pub d: PartMut<'a>,
    pub carry: PullFilter<'a>,
}

/// The law by which the displacements of one substep give those of the next.
#[derive(Clone, Copy)]
pub(crate) struct Advance {
    /// Part of the last displacement that goes on.
    pub keep: f32,
    /// Displacement that an acceleration of one adds \[s2\].
    pub gain: f32,
    /// Displacement that no particle exceeds \[m\].
    pub longest: f32,
}

/// The change of a velocity by drag and acceleration over a time: `v' = decay v + gain a`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kick {
    pub decay: f32,
    /// \[s\]
    pub gain: f32,
}

impl Kick {
    /// The exact solution of `v' = a - drag v` over `time` \[s\].
    pub fn new(drag: f32, time: f32) -> Self {
        let lost = drag * time;
        if lost < 1e-4 {
            // The quotient below would cancel; its series is exact to rounding here.
            let gain = time * (1.0 - 0.5 * lost);
            return Self { decay: 1.0 - lost * (1.0 - 0.5 * lost), gain };
        }
        let decay = ops::exp(-lost);
        Self { decay, gain: (1.0 - decay) / drag }
    }
}

impl Kernel for Integrate<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Band { layout, rows, .. } = self.band.clone();
        let blocks = layout.blocks_across();
        let shared = match self.acceleration {
            Acceleration::Uniform(a) => Block3::splat(a),
            Acceleration::Each(_) => Block3::ZERO,
        };
        for row in rows {
            let slot = layout.slot(row, 0);
            let w = Blocks::new(self.inverse_mass, slot, blocks);
            let mut d = Blocks3Mut::new(&mut self.d, slot, blocks);
            let (mut pull, parts) = match &mut self.carry {
                PullFilter::No => (None, None),
                PullFilter::Begin(pull) => (Some(Blocks3Mut::new(pull, slot, blocks)), None),
                PullFilter::GoOn(pull, parts) => {
                    (Some(Blocks3Mut::new(pull, slot, blocks)), Some(*parts))
                }
            };
            let own = match self.acceleration {
                Acceleration::Uniform(_) => None,
                Acceleration::Each(a) => Some(Blocks3::new(a, slot, blocks)),
            };
            for block in 0..blocks {
                let a = own.as_ref().map_or(shared, |own| own.at(block));
                let [kept, carried] = carried(pull.as_ref().zip(parts), block);
                let new = self.advance.of(&d.at(block), &a, &carried, &w.at(block));
                d.set(block, new);
                if let Some(pull) = &mut pull {
                    let mut before = kept;
                    for i in 0..LANES {
                        before.set(i, before.at(i) - new.at(i));
                    }
                    pull.set(block, before);
                }
            }
        }
    }
}

cut_between_rows!(Integrate, d, carry);

/// What is kept of the pulls, and what moves the particles.
#[inline(always)]
fn carried(pull: Option<(&Blocks3Mut<'_>, [f32; 2])>, block: usize) -> [Block3; 2] {
    let Some((pull, [keeps, moves])) = pull else { return [Block3::ZERO; 2] };
    let kept = pull.at(block).times(keeps);
    [kept, kept.times(moves)]
}

impl Advance {
    /// Displacements after `d`.
    #[inline(always)]
    fn of(&self, d: &Block3, a: &Block3, carried: &Block3, w: &Block) -> Block3 {
        let mut out = Block3::ZERO;
        let mut squares = Block::ZERO;
        for i in 0..LANES {
            let new = d.at(i) * self.keep + a.at(i) * self.gain + carried.at(i);
            let new = if w.0[i] > 0.0 { new } else { Vec3::ZERO };
            squares.0[i] = new.dot(new);
            out.set(i, new);
        }
        // Few are as fast as that.
        let longest = self.longest * self.longest;
        if squares.is_any_above(longest) {
            for i in 0..LANES {
                let square = squares.0[i];
                let scale = if square > longest { (longest / square).sqrt() } else { 1.0 };
                out.set(i, out.at(i) * scale);
            }
        }
        out
    }
}

/// Ends a substep: adds the displacements to the positions.
pub(crate) struct Displace<'a> {
    pub band: Band,
    pub x: PartMut<'a>,
    pub d: &'a Soa,
    /// Pulls that have been noted from before the corrections on.
    pub pull: Option<PartMut<'a>>,
}

impl Kernel for Displace<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Band { layout, rows, .. } = self.band;
        let blocks = layout.blocks_across();
        for row in rows {
            let slot = layout.slot(row, 0);
            let d = Blocks3::new(self.d, slot, blocks);
            let mut x = Blocks3Mut::new(&mut self.x, slot, blocks);
            let mut pull = self.pull.as_mut().map(|pull| Blocks3Mut::new(pull, slot, blocks));
            for block in 0..blocks {
                let d = d.at(block);
                x.add(block, &d);
                if let Some(pull) = &mut pull {
                    pull.add(block, &d);
                }
            }
        }
    }
}

cut_between_rows!(Displace, x, pull);

/// Adds a part of one vector of each free particle to another.
pub(crate) struct Add<'a> {
    pub layout: Layout,
    pub part: f32,
    pub inverse_mass: &'a [f32],
    pub from: &'a Soa,
    pub to: &'a mut Soa,
}

impl Kernel for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for row in 0..self.layout.rows {
            for column in (0..self.layout.columns).step_by(LANES) {
                let slot = self.layout.slot(row, column);
                let w = Block::load(self.inverse_mass, slot);
                let (from, mut to) = (Block3::load(self.from, slot), Block3::load(self.to, slot));
                for i in 0..LANES {
                    let part = if w.0[i] > 0.0 { self.part } else { 0.0 };
                    to.set(i, to.at(i) + from.at(i) * part);
                }
                to.store(self.to, slot);
            }
        }
    }
}
