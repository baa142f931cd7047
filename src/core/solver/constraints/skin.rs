//! Skin: particles are held near an animated pose, as clothes are near the body that wears them.
//!
//! Where a particle would be as a vertex of a skinned mesh is its *place on the skin*. Three things hold it there, as art tools have
//! them: a ball around the place that it does not leave (*max distance*), a ball behind the place that it does not enter
//! (*backstop*, so called in `NvCloth` and Chaos Cloth), and a critically damped spring to the place (*drive*).
//!
//! The two bounds mend, as contact does: what they correct is not carried on as a pull. They contradict each other nowhere, as the
//! place itself, or one before it, obeys both. Where a particle can obey both only on the circle in which the two balls meet, it is
//! put there.

use bevy_math::Vec3;

use crate::solver::settings::{ParameterError, check};
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

/// How a particle is held to its place on the skin. The default lets it go where it may.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct SkinLimit {
    /// How far it goes from there at most \[m\]; infinite where it may go anywhere, 0 where it stays there.
    pub max_distance: f32,
    /// What it does not enter, if there is anything.
    pub backstop: Option<Backstop>,
    /// Rate of the critically damped spring that draws it there \[1/s\]: a tenth of the way is left after a time of about
    /// `4 / drive`. 0 draws nothing.
    pub drive: f32,
}

/// A ball behind a particle's place on the skin, along the skin's normal there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct Backstop {
    /// How far behind the place its surface is \[m\]; negative is before it, at most by the max distance.
    pub distance: f32,
    /// Its radius \[m\]; infinite is all that is behind. Larger than the triangles around, so that none of it comes between them.
    pub radius: f32,
}

impl Default for SkinLimit {
    fn default() -> Self {
        Self { max_distance: f32::INFINITY, backstop: None, drive: 0.0 }
    }
}

impl Default for Backstop {
    fn default() -> Self {
        Self { distance: 0.0, radius: f32::INFINITY }
    }
}

impl SkinLimit {
    /// The limit of a cloth that is larger by a factor.
    pub fn scaled(&self, factor: f32) -> Self {
        let stop = |stop: &Backstop| Backstop {
            distance: stop.distance * factor,
            radius: stop.radius * factor,
        };
        Self {
            max_distance: self.max_distance * factor,
            backstop: self.backstop.as_ref().map(stop),
            drive: self.drive,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`ParameterError`] for the first number that is NaN or out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let Self { max_distance, backstop, drive } = *self;
        if max_distance.is_nan() || max_distance < 0.0 {
            let range = "0 or more, or infinite";
            return Err(ParameterError { name: "max distance", value: max_distance, range });
        }
        check("drive", drive, 0.0, 1e4, "from 0 to 10000 /s")?;
        let Some(Backstop { distance, radius }) = backstop else { return Ok(()) };
        let range = "from minus the max distance to 1000 m";
        check("backstop distance", distance, -smaller(max_distance, 1e3), 1e3, range)?;
        if !(radius > 0.0 && radius > -distance) {
            let range = "above 0 and above minus its distance, or infinite";
            return Err(ParameterError { name: "backstop radius", value: radius, range });
        }
        Ok(())
    }
}

/// The place of a particle on the skin, in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SkinMotion {
    /// Where it is at the tick's start and at its end \[m\]. On the way it goes straight, and evenly.
    pub place: [Vec3; 2],
    /// Normal of the skin there, at the same times; outwards, of any length. What has no backstop needs none.
    pub normal: [Vec3; 2],
}

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
    /// Places at the tick's start, and how far they go in it \[m\]; normals, and how they change.
    place: Soa,
    way: Soa,
    normal: Soa,
    turn: Soa,
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
            limits: limits.to_vec(),
            max_distance,
            drive,
            behind,
            curvature,
            place: Soa::zeros(len),
            way: Soa::zeros(len),
            normal,
            turn,
        }
    }

    /// Begins a tick, with motions that have been checked, relative to an origin.
    pub fn begin_tick(&mut self, topology: &Topology, motions: &[SkinMotion], origin: Vec3) {
        for (particle, motion) in motions.iter().enumerate() {
            let slot = topology.slot(particle);
            let [start, end] = motion.place.map(|place| place - origin);
            self.place.set(slot, start);
            self.way.set(slot, end - start);
            if self.has_backstops {
                let [start, end] = motion.normal.map(about_unit);
                self.normal.set(slot, start);
                self.turn.set(slot, end - start);
            }
        }
    }

    /// The first particle that has a backstop and whose skin has no normal.
    pub fn without_normal(&self, motions: &[SkinMotion]) -> Option<usize> {
        let lacks = |motion: &SkinMotion| {
            motion.normal.iter().any(|n| !is_about_unit(*n) && n.try_normalize().is_none())
        };
        let mut all = self.limits.iter().zip(motions);
        all.position(|(limit, motion)| limit.backstop.is_some() && lacks(motion))
    }
}

/// Whether a normal is as good as of length one: roots are dear where there are thousands.
fn is_about_unit(normal: Vec3) -> bool {
    (0.999..1.001).contains(&normal.length_squared())
}

/// A normal of about length one, or none.
fn about_unit(normal: Vec3) -> Vec3 {
    if is_about_unit(normal) { normal } else { normal.normalize_or_zero() }
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
                let was = off;
                if drives {
                    let drive = Block::load(&skin.drive, slot);
                    for i in 0..LANES {
                        let relative = moved.at(i) - way.at(i) * self.part;
                        let [rate, all] = [self.step, self.since].map(|time| drive.0[i] * time);
                        off.set(i, draw(off.at(i), relative, rate, all));
                    }
                }
                let drawn = off;
                let most = Block::load(&skin.max_distance, slot);
                let mut beyond = Block::ZERO;
                for i in 0..LANES {
                    let off = off.at(i);
                    beyond.0[i] = off.dot(off) - most.0[i] * most.0[i];
                }
                // Hardly any block has particles at their bounds.
                let is_beyond = beyond.is_any_above(0.0);
                if is_beyond {
                    for i in 0..LANES {
                        off.set(i, within(off.at(i), most.0[i]));
                    }
                }
                let is_behind = skin.has_backstops && may_be_behind(skin, self.passed, slot, &off);
                if is_behind {
                    stop(skin, self.passed, slot, &most, &mut off);
                }
                if !(drives || is_beyond || is_behind) {
                    continue;
                }
                let (mut mended, mut all) = (Block3::ZERO, Block3::ZERO);
                let (w, mut changes) = (w.at(block), Block::ZERO);
                for i in 0..LANES {
                    let free = if w.0[i] > 0.0 { 1.0 } else { 0.0 };
                    let change = (off.at(i) - was.at(i)) * free;
                    all.set(i, change);
                    mended.set(i, (off.at(i) - drawn.at(i)) * -free);
                    changes.0[i] = change.dot(change);
                }
                if changes.is_any() {
                    moved = moved.plus(&all);
                    d.set(block, moved);
                    if let Some(pull) = &mut pull {
                        pull.add(block, &mended);
                    }
                }
            }
        }
    }
}

cut_between_rows!(HoldToSkin, d, pull);

/// Whether any of a block of particles is in its backstop, by their ways from their places; without roots and divisions, as hardly any
/// is.
#[inline(always)]
fn may_be_behind(skin: &Skin, passed: f32, slot: usize, off: &Block3) -> bool {
    let behind = Block::load(&skin.behind, slot);
    // No nearer to the place than this is any of it.
    let mut out = Block::ZERO;
    for i in 0..LANES {
        let (off, behind) = (off.at(i), behind.0[i]);
        out.0[i] = if behind > 0.0 { off.dot(off) - behind * behind } else { 1.0 };
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
        let sideways = curvature * (off.dot(off) + behind * behind) + 2.0 * behind;
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

/// Where a particle is from its place when a critically damped spring has drawn it for a time of `all`, in the last part of which, `rate`,
/// it would have come so far by itself. Implicit Euler, so that no rate is too high.
#[inline(always)]
fn draw(off: Vec3, relative: Vec3, rate: f32, all: f32) -> Vec3 {
    let before = off - relative;
    before + (relative - before * (rate * all)) * (1.0 / (1.0 + 2.0 * all + all * all))
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
