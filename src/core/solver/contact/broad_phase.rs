//! The broad phase: contact looks only at blocks of particles that may touch a collider.
//!
//! Twice the same thought: something at a known distance cannot touch before that much way has been
//! gone. A collider sleeps until the cloth has gone as far as there was between their boxes when the
//! tick began; a block of particles is passed over until it can have gone the distance that it was last
//! found to have. The way is that of the fastest particle: one number for all.

use bevy_math::Vec3;
use bevy_math::bounding::Aabb3d;

use crate::solver::contact::Collider;
use crate::solver::contact::edges::{Edges, Nearby};
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::parallel::Band;
use crate::solver::simd::soa::Soa;

/// Colliders awake at once that there is room for from the start.
const FEW: usize = 8;
/// Colliders awake at once whose edges are held that there is room for from the start.
const FEW_WITH_EDGES: usize = 2;

/// The broad phase: which blocks of particles may touch which colliders, and the memory of it within a tick.
#[derive(Clone, Debug)]
pub(crate) struct BroadPhase {
    blocks: usize,
    /// The colliders that the cloth may have come to, in their order.
    pub awake: Vec<Awake>,
    /// The way at which the particles of a block may touch a collider \[m\]: for each awake collider,
    /// all blocks.
    pub until: Vec<f32>,
    /// The way at which an edge may touch a collider \[m\]: for each place in `awake`, all edges; shorter where the last have
    /// none to hold.
    pub edge_until: Vec<f32>,
    /// Likewise of faces.
    pub face_until: Vec<f32>,
    /// How particles lie to a collider, while edges are held out of it.
    pub nearby: Option<Nearby>,
    /// How far any particle has gone since the tick began, at most \[m\].
    pub gone: f32,
    /// How far contact has pushed any particle in this substep, at most \[m\].
    pub pushed: f32,
    /// Whether contact has changed in this substep what it did not touch, or what was fast.
    pub struck: bool,
    /// The way at which another collider wakes \[m\].
    until_next: f32,
    /// The cloth's box when the tick began, in world space.
    low: Vec3,
    high: Vec3,
    /// Largest rounding error of a distance in world space \[m\].
    slack: f32,
}

/// A collider that the cloth may have come to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Awake {
    /// The collider's index.
    pub collider: usize,
    /// Where what is known of the blocks begins.
    pub first: usize,
    /// How far any point of it has gone since it woke \[m\].
    pub gone: f32,
    /// Depth of the deepest particle in it, where any needs more than this substep to come out; else 0 \[m\].
    pub left: f32,
}

impl BroadPhase {
    /// For a cloth of these edges, where they are held.
    pub fn new(band: &Band, edges: Option<&Edges>) -> Self {
        let layout = band.layout;
        let blocks = layout.len() / LANES;
        Self {
            blocks,
            awake: Vec::with_capacity(FEW),
            until: Vec::with_capacity(FEW * blocks),
            edge_until: Vec::with_capacity(FEW_WITH_EDGES * edges.map_or(0, Edges::count)),
            face_until: Vec::new(),
            nearby: edges.map(|edges| Nearby::new(layout.len(), edges)),
            gone: 0.0,
            pushed: 0.0,
            struck: false,
            until_next: 0.0,
            low: Vec3::ZERO,
            high: Vec3::ZERO,
            slack: 0.0,
        }
    }

    /// Forgets what is known: colliders may have come, or been put elsewhere, since the last tick.
    /// `low` and `high` are the corners of a box around the cloth in world space; `epsilon` is the
    /// distance at which it is held.
    pub fn begin_tick(
        &mut self,
        low: Vec3,
        high: Vec3,
        epsilon: f32,
        layers: u32,
        colliders: &[Collider<'_>],
    ) {
        self.awake.clear();
        self.until.clear();
        self.edge_until.clear();
        self.face_until.clear();
        (self.gone, self.pushed) = (0.0, 0.0);
        (self.low, self.high) = (low, high);
        self.slack = 1e-6 * low.abs().max(high.abs()).max_element();
        self.until_next = f32::INFINITY;
        for collider in colliders {
            if collider.layers & layers != 0 {
                self.until_next = self.until_next.min(self.gap(collider, epsilon));
            }
        }
    }

    /// How far the cloth may go from where the tick began before it can touch a collider; zero where that
    /// is not known \[m\].
    fn gap(&self, collider: &Collider<'_>, epsilon: f32) -> f32 {
        let gap = |bounds: Aabb3d| box_gap(self.low, self.high, &bounds) - epsilon - self.slack;
        larger(collider.motion.bounds().map_or(0.0, gap), 0.0)
    }

    /// Forgets what has been struck.
    pub fn begin_substep(&mut self) {
        self.struck = false;
    }

    /// Adds the way of a substep, and wakes the colliders that the cloth may have come to. `epsilon`
    /// is the distance at which it is held. Allocates where more of them are awake than ever before,
    /// and more than a few.
    pub fn wake(
        &mut self,
        isa: Isa,
        way: f32,
        epsilon: f32,
        layers: u32,
        x: &Soa,
        layout: Layout,
        origin: Vec3,
        colliders: &[Collider<'_>],
    ) {
        let before = self.gone + self.pushed;
        self.gone = before + way;
        self.pushed = 0.0;
        if self.gone < self.until_next {
            return;
        }
        self.until_next = f32::INFINITY;
        let mut place = 0;
        for (index, collider) in colliders.iter().enumerate() {
            if self.awake.get(place).is_some_and(|awake| awake.collider == index) {
                place += 1;
                continue;
            }
            if collider.layers & layers == 0 {
                continue;
            }
            let gap = self.gap(collider, epsilon);
            if gap > self.gone {
                self.until_next = self.until_next.min(gap);
                continue;
            }
            let first = self.until.len();
            self.until.resize(first + self.blocks, 0.0);
            if let Some(bounds) = &collider.motion.bounds() {
                let held = epsilon + self.slack;
                let until = &mut self.until[first..];
                isa.run(BlockGaps { layout, x, origin, bounds, held, before, until });
            }
            // Places shift.
            self.edge_until.clear();
            self.face_until.clear();
            self.awake.insert(place, Awake { collider: index, first, gone: 0.0, left: 0.0 });
            place += 1;
        }
    }
}

/// What is known of `each` edge or face of a cloth and the collider at a `place` in [`BroadPhase::awake`]. It goes only as far as a
/// collider has any.
pub(super) fn of_place(until: &mut Vec<f32>, place: usize, each: usize) -> &mut [f32] {
    let [from, to] = [place, place + 1].map(|place| place * each);
    if until.len() < to {
        until.resize(to, 0.0);
    }
    &mut until[from..to]
}

/// Distance between two boxes along the axis where they are furthest apart: not more than their
/// distance.
pub(crate) fn box_gap(low: Vec3, high: Vec3, other: &Aabb3d) -> f32 {
    let (min, max) = (Vec3::from(other.min), Vec3::from(other.max));
    (min - high).max(low - max).max_element()
}

/// The ways at which blocks may come to a collider's box.
struct BlockGaps<'a> {
    layout: Layout,
    x: &'a Soa,
    origin: Vec3,
    bounds: &'a Aabb3d,
    /// Distance that the cloth is held at, and the slack \[m\].
    held: f32,
    /// The way that the cloth has gone up to now \[m\].
    before: f32,
    until: &'a mut [f32],
}

impl Kernel for BlockGaps<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (min, max) =
            (Vec3::from(self.bounds.min) - self.origin, Vec3::from(self.bounds.max) - self.origin);
        for row in 0..self.layout.rows {
            for column in (0..self.layout.columns).step_by(LANES) {
                let slot = self.layout.slot(row, column);
                let inside = self.layout.inside(row, column);
                let x = Block3::load(self.x, slot);
                let mut gap = Block::ZERO;
                for i in 0..LANES {
                    let p = x.at(i);
                    let along = |p: f32, min: f32, max: f32| larger(min - p, p - max);
                    let (x, y, z) = (
                        along(p.x, min.x, max.x),
                        along(p.y, min.y, max.y),
                        along(p.z, min.z, max.z),
                    );
                    // Padding is far from everything.
                    let far = larger(larger(x, y), z) - self.held;
                    gap.0[i] = if i < inside { far } else { f32::INFINITY };
                }
                self.until[slot / LANES] = self.before + larger(gap.smallest(), 0.0);
            }
        }
    }
}
