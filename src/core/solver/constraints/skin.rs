//! Skin: particles are held near an animated pose, as clothes are near the body that wears them.
//!
//! Where a particle would be as a vertex of a skinned mesh is its *place on the skin*. Three things hold it there, as art tools have
//! them: a ball around the place that it does not leave (*max distance*), a ball behind the place that it does not enter
//! (*backstop*, so called in `NvCloth` and Chaos Cloth), and a critically damped spring to the place (*drive*).
//!
//! The two bounds mend, as contact does: what they correct is not carried on as a pull. They contradict each other nowhere, as the
//! place itself, or one before it, obeys both. Where a particle can obey both only on the circle in which the two balls meet, it is
//! put there.

mod limit;
mod take;

pub use limit::{Backstop, SkinLimit, SkinMotion};
pub(crate) use take::look_through;

use bevy_math::Vec3;

use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, Blocks3Mut, larger, smaller};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{Band, cut_between_rows};
use crate::solver::simd::soa::{Array, PartMut, Soa};
use crate::solver::topology::Topology;

/// Largest distance that bounds anything \[m\]; its square is a number still.
const FAR: f32 = 1e18;
/// Distance of a backstop that stops nothing \[m\].
const NOWHERE: f32 = 1e9;

/// The skin of a cloth.
#[derive(Clone, Debug)]
pub(crate) struct Skin {
    /// By particle.
    pub limits: Vec<SkinLimit>,
    /// By slot: largest distance \[m\], and rate of the drive \[1/s\].
    max_distance: Array,
    drive: Array,
    /// By slot: distance of the backstop \[m\], and one over its radius \[1/m\].
    behind: Array,
    curvature: Array,
    has_backstops: bool,
    has_drives: bool,
    /// The rate of all drives, where they are alike \[1/s\].
    all_drive: Option<f32>,
    /// Places at the tick's start, and how far they go in it \[m\]; normals, and how they change.
    place: Soa,
    way: Soa,
    normal: Soa,
    turn: Soa,
    /// Room for displacements at a tick's end \[m\].
    pub after_contact: Soa,
}

impl Skin {
    /// With limits that have been checked, one a particle.
    pub fn new(topology: &Topology, limits: &[SkinLimit]) -> Self {
        let len = topology.layout().len();
        let [mut max_distance, mut behind] = [Array::zeros(len), Array::zeros(len)];
        let [mut drive, mut curvature] = [Array::zeros(len), Array::zeros(len)];
        max_distance.fill(FAR);
        behind.fill(NOWHERE);
        for (particle, limit) in limits.iter().enumerate() {
            let slot = topology.slot(particle);
            max_distance[slot] = smaller(limit.max_distance, FAR);
            drive[slot] = limit.drive;
            if let Some(Backstop { distance, radius }) = limit.backstop {
                (behind[slot], curvature[slot]) = (distance, 1.0 / radius);
            }
        }
        let has_backstops = limits.iter().any(|limit| limit.backstop.is_some());
        let [normal, turn] = [(); 2].map(|()| Soa::zeros(if has_backstops { len } else { 0 }));
        Self {
            has_backstops,
            has_drives: limits.iter().any(|limit| limit.drive > 0.0),
            all_drive: limits
                .first()
                .map(|it| it.drive)
                .filter(|drive| limits.iter().all(|limit| limit.drive == *drive)),
            limits: limits.to_vec(),
            max_distance,
            drive,
            behind,
            curvature,
            place: Soa::zeros(len),
            way: Soa::zeros(len),
            normal,
            turn,
            after_contact: Soa::zeros(len),
        }
    }
}

/// Holds particles to the skin.
pub(crate) struct HoldToSkin<'a> {
    pub band: Band,
    pub skin: &'a Skin,
    /// The part of the tick that has passed at the substep's end, and the substep's own.
    pub passed: f32,
    pub part: f32,
    /// The substep's length \[s\], and the time for which drives draw; 0 where the bounds alone hold.
    pub step: f32,
    pub since: f32,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub d: PartMut<'a>,
    /// What is carried on; it takes no part in what the bounds do.
    pub pull: Option<PartMut<'a>>,
}

impl Kernel for HoldToSkin<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Band { layout, rows, .. } = self.band.clone();
        let skin = self.skin;
        let drives = skin.has_drives && self.step > 0.0;
        // Where all are alike, nothing is to be read nor worked out for each.
        let alike = match skin.all_drive {
            Some(drive) => Draw::new(drive, self.step, self.since),
            None => Draw::NONE,
        };
        let blocks = layout.blocks_across();
        for row in rows {
            let first = layout.slot(row, 0);
            let w = Blocks::new(self.inverse_mass, first, blocks);
            let x = Blocks3::new(self.x, first, blocks);
            let mut d = Blocks3Mut::new(&mut self.d, first, blocks);
            let mut pull = self.pull.as_mut().map(|pull| Blocks3Mut::new(pull, first, blocks));
            for block in 0..blocks {
                let slot = first + block * LANES;
                let (x, mut moved) = (x.at(block), d.at(block));
                let (place, way) = (Block3::load(&skin.place, slot), Block3::load(&skin.way, slot));
                // From the place at the substep's end.
                let mut off = Block3::ZERO;
                for i in 0..LANES {
                    let at = place.at(i) + way.at(i) * self.passed;
                    off.set(i, (x.at(i) - at) + moved.at(i));
                }
                let w = w.at(block);
                if drives {
                    let mut by = Block3::ZERO;
                    if skin.all_drive.is_some() {
                        for i in 0..LANES {
                            let relative = moved.at(i) - way.at(i) * self.part;
                            by.set(i, alike.of(off.at(i), relative));
                        }
                    } else {
                        let drive = Block::load(&skin.drive, slot);
                        for i in 0..LANES {
                            let relative = moved.at(i) - way.at(i) * self.part;
                            let draw = Draw::new(drive.0[i], self.step, self.since);
                            by.set(i, draw.of(off.at(i), relative));
                        }
                    }
                    for i in 0..LANES {
                        let by = if w.0[i] > 0.0 { by.at(i) } else { Vec3::ZERO };
                        off.set(i, off.at(i) + by);
                        moved.set(i, moved.at(i) + by);
                    }
                }
                let most = Block::load(&skin.max_distance, slot);
                let mut square = Block::ZERO;
                let mut beyond = Block::ZERO;
                for i in 0..LANES {
                    square.0[i] = off.at(i).dot(off.at(i));
                    beyond.0[i] = square.0[i] - most.0[i] * most.0[i];
                }
                let drawn = off;
                // Hardly any block has particles at their bounds.
                let is_beyond = beyond.is_any_above(0.0);
                if is_beyond {
                    for i in 0..LANES {
                        off.set(i, within(off.at(i), most.0[i]));
                        square.0[i] = off.at(i).dot(off.at(i));
                    }
                }
                let is_behind =
                    skin.has_backstops && may_be_behind(skin, self.passed, slot, &off, &square);
                if is_behind {
                    stop(skin, self.passed, slot, &most, &mut off);
                }
                if is_beyond || is_behind {
                    let mut mended = Block3::ZERO;
                    for i in 0..LANES {
                        let by = if w.0[i] > 0.0 { off.at(i) - drawn.at(i) } else { Vec3::ZERO };
                        moved.set(i, moved.at(i) + by);
                        mended.set(i, -by);
                    }
                    if let Some(pull) = &mut pull {
                        pull.add(block, &mended);
                    }
                } else if !drives {
                    continue;
                }
                d.set(block, moved);
            }
        }
    }
}

cut_between_rows!(HoldToSkin, d, pull);

/// Whether any of a block of particles is in its backstop, by their ways from their places; without roots and divisions, as hardly any
/// is.
#[inline(always)]
fn may_be_behind(skin: &Skin, passed: f32, slot: usize, off: &Block3, square: &Block) -> bool {
    let behind = Block::load(&skin.behind, slot);
    // No nearer to the place than this is any of it.
    let mut out = Block::ZERO;
    for i in 0..LANES {
        let behind = behind.0[i];
        out.0[i] = if behind > 0.0 { square.0[i] - behind * behind } else { 1.0 };
    }
    if !out.is_any_above(0.0) {
        return false;
    }
    let (normal, turn) = (Block3::load(&skin.normal, slot), Block3::load(&skin.turn, slot));
    let curvature = Block::load(&skin.curvature, slot);
    for i in 0..LANES {
        let (off, n) = (off.at(i), normal.at(i) + turn.at(i) * passed);
        let (behind, curvature) = (behind.0[i], curvature.0[i]);
        // What `Stop::before` calls the gap has the sign of `sideways + along`, when the normal is of length one.
        let sideways = curvature * (square.0[i] + behind * behind) + 2.0 * behind;
        let along = 2.0 * (1.0 + curvature * behind) * off.dot(n);
        let is_deep = along * along >= sideways * sideways * n.dot(n) * 0.999;
        let is_in = sideways < 0.0 || along < 0.0 && is_deep;
        out.0[i] = if is_in { 1.0 } else { 0.0 };
    }
    out.is_any_above(0.0)
}

/// Keeps a block of particles, by their ways from their places, out of their backstops, when a part of the tick has passed.
#[inline(always)]
fn stop(skin: &Skin, passed: f32, slot: usize, most: &Block, off: &mut Block3) {
    let (normal, turn) = (Block3::load(&skin.normal, slot), Block3::load(&skin.turn, slot));
    let behind = Block::load(&skin.behind, slot);
    let curvature = Block::load(&skin.curvature, slot);
    for i in 0..LANES {
        let n = normal.at(i) + turn.at(i) * passed;
        let n = n * (1.0 / larger(n.dot(n).sqrt(), f32::MIN_POSITIVE));
        let stop = Stop { n, behind: behind.0[i], curvature: curvature.0[i] };
        off.set(i, stop.before(off.at(i), most.0[i]));
    }
}

/// A critically damped spring that draws for a time, in the last part of which, a substep, a particle would have come on by itself.
/// Implicit Euler, so that no rate is too high.
#[derive(Clone, Copy)]
struct Draw {
    /// Of the way that it would have come on, and of where it is.
    way: f32,
    off: f32,
}

impl Draw {
    const NONE: Self = Self { way: 0.0, off: 0.0 };

    /// With a rate \[1/s\], after substeps of a length, in all of a time \[s\].
    #[inline(always)]
    fn new(drive: f32, step: f32, since: f32) -> Self {
        let [rate, all] = [step, since].map(|time| drive * time);
        let damped = 1.0 / (1.0 + 2.0 * all + all * all);
        Self { way: (rate * all - 2.0 * all - all * all) * damped, off: -rate * all * damped }
    }

    /// How far it draws a particle that is `off` its place, `relative` to which it has come so far.
    #[inline(always)]
    fn of(self, off: Vec3, relative: Vec3) -> Vec3 {
        relative * self.way + off * self.off
    }
}

/// A vector that is not longer than `most`.
#[inline(always)]
fn within(off: Vec3, most: f32) -> Vec3 {
    let length = off.dot(off).sqrt();
    let part = if length > most { most / length } else { 1.0 };
    off * part
}

/// A backstop: normal, distance, and one over the radius.
struct Stop {
    n: Vec3,
    behind: f32,
    curvature: f32,
}

impl Stop {
    /// Moves what is in the backstop to its surface; where that is further than `most` from the place, to where the surface is as
    /// near as that.
    #[inline(always)]
    fn before(&self, off: Vec3, most: f32) -> Vec3 {
        let Self { n, behind, curvature } = *self;
        // All of it in radii, so that a plane is as good as any other ball.
        let reach = 1.0 + curvature * behind;
        let along = off.dot(n);
        let from_centre = off * curvature + n * reach;
        let distance = from_centre.dot(from_centre).sqrt();
        let square = curvature * (off.dot(off) + behind * behind);
        let gap = (square + 2.0 * (along * reach + behind)) / (distance + 1.0);
        let out = smaller(gap, 0.0) / larger(distance, f32::MIN_POSITIVE);
        let moved = off - from_centre * out;
        let beyond = moved.dot(moved) > most * most;
        // The circle where both balls meet.
        let up = -(curvature * (most * most + behind * behind) + 2.0 * behind) / (2.0 * reach);
        let aside = off - n * along;
        let wide = larger(most * most - up * up, 0.0).sqrt();
        let part = wide / larger(aside.dot(aside).sqrt(), f32::MIN_POSITIVE);
        let on_circle = n * up + aside * part;
        if gap < 0.0 && beyond { on_circle } else { moved }
    }
}
