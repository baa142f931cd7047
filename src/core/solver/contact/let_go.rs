//! The end of contact in a substep: particles of the active set that touch nothing any more are let go.

use crate::solver::contact::active_set::ActiveSet;
use crate::solver::simd::block::{Block, Block3, Blocks, larger};
use crate::solver::simd::flags::raised;
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

/// How far what is let go follows what pulled it onto its surface, where it leaves that by itself: no further than back \[m\].
#[inline(always)]
pub(crate) fn followed(lost: f32, pulled: f32) -> f32 {
    let back = -larger(lost, 0.0);
    let onto = if pulled < 0.0 { pulled } else { 0.0 };
    larger(onto, back)
}

/// Ends contact: lets go what lay on a collider and was found to touch none any more. It goes on without what pulled at
/// it while it was held.
pub(crate) struct LetGo<'a> {
    pub set: &'a ActiveSet,
    pub inverse_mass: &'a [f32],
    pub d: &'a mut Soa,
    /// Pulls noted in the substep, where any are.
    pub pull: Option<&'a mut Soa>,
}

impl Kernel for LetGo<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { set, inverse_mass, d, mut pull } = self;
        let count = set.now.blocks.len();
        let (losts, loads) = (Blocks::new(&set.lost, 0, count), Blocks::new(&set.load, 0, count));
        for block in raised(&set.now.blocks) {
            let (lost, load) = (losts.at(block), loads.at(block));
            // What goes on touching has been let go by what met it.
            if !lost.is_any() && !load.is_any() {
                continue;
            }
            let slot = block * LANES;
            let (n, w) = (Block3::load(&set.now.normal, slot), Block::load(inverse_mass, slot));
            let mut moved = Block3::load(d, slot);
            for i in 0..LANES {
                // What is pulled off does not fall back.
                let leaves = larger(lost.0[i], 0.0);
                let followed = followed(lost.0[i], load.0[i] * w.0[i]);
                moved.set(i, moved.at(i) + n.at(i) * (leaves + followed));
            }
            moved.store(d, slot);
            if let Some(pull) = &mut pull {
                // That it did not fall through its surface was no pull.
                let mut noted = Block3::load(&**pull, slot);
                for i in 0..LANES {
                    let fallen = if lost.0[i] < 0.0 { lost.0[i] } else { 0.0 };
                    noted.set(i, noted.at(i) + n.at(i) * fallen);
                }
                noted.store(&mut **pull, slot);
            }
        }
    }
}
