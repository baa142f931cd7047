//! The beginning of corrections: particles of the active set go only where their surface lets them.

use bevy_math::Vec3;

use crate::solver::contact::active_set::{ActiveSet, slipped};
use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, Blocks3Mut, BlocksMut};
use crate::solver::simd::flags::raised;
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

/// Begins the corrections of a substep: lets the particles of the active set go only where they can, with their
/// surface.
pub(crate) struct HoldOnto<'a> {
    pub set: &'a mut ActiveSet,
    pub inverse_mass: &'a [f32],
    /// Length of the substep \[s\].
    pub step: f32,
    pub d: &'a mut Soa,
    /// What is kept of the last substeps' pulls, less the displacements, and the part of it that moves the particles
    /// (`integrate::houbolt`); `None` where nothing is carried on.
    pub carried: Option<(&'a Soa, f32)>,
}

impl Kernel for HoldOnto<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { set, inverse_mass, step, d, carried } = self;
        let measures = set.impulses.are_measured();
        let ActiveSet { now, before, velocity, unpulled, dropped, mended, lost, load, .. } = set;
        let count = now.blocks.len();
        let (normals, slips) =
            (Blocks3::new(&now.normal, 0, count), Blocks::new(&now.slip, 0, count));
        let (normals_before, slips_before) =
            (Blocks3::new(&before.normal, 0, count), Blocks::new(&before.slip, 0, count));
        let velocities = Blocks3::new(velocity, 0, count);
        let masses = Blocks::new(inverse_mass, 0, count);
        let mut ds = Blocks3Mut::new(d, 0, count);
        let mut unpulleds = Blocks3Mut::new(unpulled, 0, count);
        let mut losts = BlocksMut::new(lost, 0, count);
        let mut loads = BlocksMut::new(load, 0, count);
        #[expect(
            clippy::manual_map,
            reason = "a closure that is not inlined keeps the baseline's instructions"
        )]
        let carried = match carried {
            Some((kept, moves)) => Some((Blocks3::new(kept, 0, count), moves)),
            None => None,
        };
        for block in raised(&now.blocks) {
            let (n, before) = (normals.at(block), normals_before.at(block));
            let (w, velocity) = (masses.at(block), velocities.at(block));
            let (slip, slip_before) = (slips.at(block), slips_before.at(block));
            let mut moved = ds.at(block);
            let carried = match &carried {
                Some((kept, moves)) => kept.at(block).plus(&moved).times(*moves),
                None => Block3::ZERO,
            };
            let (mut lost, mut load) = (Block::ZERO, Block::ZERO);
            let (mut goes, mut unpulled) = (Block3::ZERO, Block3::ZERO);
            for i in 0..LANES {
                // What did not follow a pull in the substep before is not moved by what is carried on of it. That is
                // a load all the same.
                let (before, carried) = (before.at(i), carried.at(i));
                let borne = before.dot(carried);
                let held = slip_before.0[i] / slip.0[i];
                let held = if held < 1.0 { held } else { 1.0 };
                load.0[i] = borne / w.0[i];
                goes.set(i, (carried - before * borne) * held);
            }
            if measures {
                let mut left_out = Block3::ZERO;
                for i in 0..LANES {
                    let borne = before.at(i).dot(carried.at(i));
                    left_out.set(i, carried.at(i) - goes.at(i) - n.at(i) * borne);
                }
                left_out.store(dropped, block * LANES);
                Block3::ZERO.store(mended, block * LANES);
            }
            for i in 0..LANES {
                let (n, along) = (n.at(i), goes.at(i));
                let is_free = n.dot(n) == 0.0 || w.0[i] == 0.0;
                let own = moved.at(i) - carried.at(i);
                let surface = velocity.at(i) * step;
                lost.0[i] = if is_free { 0.0 } else { n.dot(own + along - surface) };
                load.0[i] = if is_free { 0.0 } else { load.0[i] };
                let along = along - n * n.dot(along);
                let own = own + n * n.dot(surface - own);
                unpulled.set(i, own);
                moved.set(i, if is_free { moved.at(i) } else { own + along * slip.0[i] });
            }
            ds.set(block, moved);
            losts.set(block, lost);
            loads.set(block, load);
            unpulleds.set(block, unpulled);
        }
    }
}

/// Adds what pulled at the particles of the active set without moving them to the pulls, or takes it away. Between the two they are
/// mended, and pulled by nothing.
pub(crate) struct NoteUnfollowed<'a> {
    pub set: &'a mut ActiveSet,
    pub inverse_mass: &'a [f32],
    pub d: &'a Soa,
    /// One or minus one.
    pub part: f32,
    pub pull: &'a mut Soa,
}

impl Kernel for NoteUnfollowed<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { set, inverse_mass, d, part, pull } = self;
        let measures = set.impulses.are_measured();
        let ActiveSet { now, load: loads, unpulled, mended, .. } = set;
        for block in raised(&now.blocks) {
            let slot = block * LANES;
            let (n, w) = (Block3::load(&now.normal, slot), Block::load(inverse_mass, slot));
            let (load, slip) = (Block::load(loads, slot), Block::load(&now.slip, slot));
            let (d, unpulled) = (Block3::load(d, slot), Block3::load(&*unpulled, slot));
            let mut noted = Block3::load(&*pull, slot);
            for i in 0..LANES {
                let n = n.at(i);
                let pulled = d.at(i) - unpulled.at(i);
                let slid = slipped(pulled, n);
                let unfollowed = n * (load.0[i] * w.0[i]) + slid * (1.0 / slip.0[i] - 1.0);
                let unfollowed = if n.dot(n) > 0.0 { unfollowed } else { Vec3::ZERO };
                noted.set(i, noted.at(i) + unfollowed * part);
            }
            noted.store(pull, slot);
            if measures {
                let mut by = Block3::load(&*mended, slot);
                for i in 0..LANES {
                    by.set(i, by.at(i) - d.at(i) * part);
                }
                by.store(mended, slot);
            }
        }
    }
}
