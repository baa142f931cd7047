//! Contact with signed distance fields: particles are held `epsilon` outside, with friction.
//!
//! A particle nearer than epsilon is moved out along the gradient. Its displacement, and so its
//! velocity, loses the approach that this undoes and no more: being moved out of a collider gives no
//! speed. Coulomb's friction acts on the displacement relative to the collider's surface, with the
//! impulse of that same undoing.

use bevy::math::{Mat3, Quat, Vec3};

use super::isa::Kernel;
use super::lanes::{Block, Block3, LANES, Soa, larger};
use super::lattice::Layout;
use crate::sdf::{PointBlock, SampleBlock, SignedDistance};

/// Colliders that there is room for from the start.
const FEW: usize = 8;
/// Least way of sliding that has a direction \[m\].
const LEAST_SLIDING: f32 = 1e-20;

/// Where a collider is: uniform scale, then rotation, then translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Place of the shape's origin \[m\].
    pub translation: Vec3,
    /// Rotation, of length one.
    pub rotation: Quat,
    /// Uniform scale, above zero.
    pub scale: f32,
}

impl Pose {
    /// No translation, no rotation, scale one.
    pub const IDENTITY: Self =
        Self { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: 1.0 };

    /// A pose without rotation or scale.
    pub fn from_translation(translation: Vec3) -> Self {
        Self { translation, ..Self::IDENTITY }
    }

    /// Whether every number can be used.
    pub fn is_valid(&self) -> bool {
        self.translation.is_finite()
            && self.rotation.is_finite()
            && (self.rotation.length_squared() - 1.0).abs() < 1e-3
            && self.scale.is_finite()
            && self.scale > 0.0
    }

    /// The pose at part `t` of the way to `end`; rotations the shorter way, without transcendental
    /// functions, so that it gives the same bits everywhere.
    pub fn interpolate(&self, end: &Self, t: f32) -> Self {
        if self == end || t <= 0.0 {
            return *self;
        }
        if t >= 1.0 {
            return *end;
        }
        let side = if self.rotation.dot(end.rotation) < 0.0 { -1.0 } else { 1.0 };
        Self {
            translation: self.translation + (end.translation - self.translation) * t,
            rotation: (self.rotation * (1.0 - t) + end.rotation * (side * t)).normalize(),
            scale: self.scale + (end.scale - self.scale) * t,
        }
    }

    fn apply(&self, point: Vec3) -> Vec3 {
        self.rotation * (point * self.scale) + self.translation
    }
}

/// A rigid shape that a cloth collides with, and its motion through a tick.
#[derive(Clone, Copy, Debug)]
pub struct Collider<'a> {
    /// The shape, in its own frame.
    pub shape: &'a dyn SignedDistance,
    /// Pose where the tick begins, in world space.
    pub start: Pose,
    /// Pose where it ends.
    pub end: Pose,
    /// Coulomb's coefficient; the pair's is the geometric mean with the cloth's.
    pub friction: f32,
}

/// A pose as the kernel needs it: columns of the rotation, and translation in the cloth's frame.
#[derive(Clone, Copy)]
struct Frame {
    rotation: Mat3,
    translation: Vec3,
    scale: f32,
}

impl Frame {
    fn new(pose: &Pose, origin: Vec3) -> Self {
        Self {
            rotation: Mat3::from_quat(pose.rotation),
            translation: pose.translation - origin,
            scale: pose.scale,
        }
    }

    #[inline(always)]
    fn to_local(self, x: Vec3) -> Vec3 {
        let d = x - self.translation;
        let r = &self.rotation;
        Vec3::new(d.dot(r.x_axis), d.dot(r.y_axis), d.dot(r.z_axis)) * (1.0 / self.scale)
    }

    #[inline(always)]
    fn rotate(self, p: Vec3) -> Vec3 {
        let r = &self.rotation;
        r.x_axis * p.x + r.y_axis * p.y + r.z_axis * p.z
    }

    #[inline(always)]
    fn to_world(self, p: Vec3) -> Vec3 {
        self.rotate(p) * self.scale + self.translation
    }
}

/// A collider's motion through one substep.
struct Motion<'a> {
    shape: &'a dyn SignedDistance,
    before: Frame,
    after: Frame,
    moves: bool,
    /// How far any point of the surface moves at most \[m\].
    reach: f32,
    friction: f32,
}

impl<'a> Motion<'a> {
    fn new(collider: &Collider<'a>, origin: Vec3, friction: f32, from: f32, to: f32) -> Self {
        let before = collider.start.interpolate(&collider.end, from);
        let after = collider.start.interpolate(&collider.end, to);
        let moves = before != after;
        let reach = match collider.shape.bounds() {
            _ if !moves => 0.0,
            Some(bounds) => corners(bounds.min.into(), bounds.max.into())
                .map(|p| before.apply(p).distance(after.apply(p)))
                .fold(0.0, f32::max),
            // Turning an unbounded shape moves its far parts without bound.
            None if before.rotation != after.rotation || before.scale != after.scale => {
                f32::INFINITY
            }
            None => before.translation.distance(after.translation),
        };
        Self {
            shape: collider.shape,
            before: Frame::new(&before, origin),
            after: Frame::new(&after, origin),
            moves,
            reach,
            friction: (collider.friction * friction).sqrt(),
        }
    }
}

fn corners(min: Vec3, max: Vec3) -> impl Iterator<Item = Vec3> {
    (0..8).map(move |i| {
        let pick = |bit: usize, low: f32, high: f32| if i & bit == 0 { low } else { high };
        Vec3::new(pick(1, min.x, max.x), pick(2, min.y, max.y), pick(4, min.z, max.z))
    })
}

/// The part of a tick that a substep covers, from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub from: f32,
    pub to: f32,
}

/// Moves particles out of all colliders, in their order, and returns how many touched one.
pub(super) struct ResolveContacts<'a> {
    pub layout: Layout,
    pub colliders: &'a [Collider<'a>],
    pub origin: Vec3,
    pub span: Span,
    /// Distance at which particles are held \[m\].
    pub epsilon: f32,
    /// The cloth's coefficient of friction.
    pub friction: f32,
    pub inverse_mass: &'a [f32],
    pub x: &'a mut Soa,
    pub d: &'a mut Soa,
    pub room: &'a mut ContactRoom,
}

/// What contact remembers from substep to substep of a tick, by blocks of particles.
#[derive(Clone, Debug)]
pub(super) struct ContactRoom {
    blocks: usize,
    /// How far the particles of a block may yet move before any can touch a collider \[m\]: for
    /// each collider, all blocks.
    clearance: Vec<f32>,
    /// How far the particles of a block have moved in the substep at most \[m\].
    moved: Vec<f32>,
    /// How far contact has pushed them \[m\], since `moved` was taken.
    pushed: Vec<f32>,
}

impl ContactRoom {
    pub fn new(layout: Layout) -> Self {
        let blocks = layout.len() / LANES;
        Self {
            blocks,
            clearance: Vec::with_capacity(FEW * blocks),
            moved: vec![0.0; blocks],
            pushed: vec![0.0; blocks],
        }
    }

    /// Forgets what is known: colliders may have come, or been put elsewhere, since the last tick.
    /// Allocates where there are more of them than ever before, and more than a few.
    pub fn begin_tick(&mut self, colliders: usize) {
        self.clearance.clear();
        self.clearance.resize(colliders * self.blocks, 0.0);
        self.pushed.fill(0.0);
    }
}

impl Kernel for ResolveContacts<'_> {
    type Output = u32;

    #[inline(always)]
    fn run(mut self) -> u32 {
        // The field of a collider may have been loaded since the tick began.
        if self.room.clearance.len() != self.colliders.len() * self.room.blocks {
            self.room.begin_tick(self.colliders.len());
        }
        self.look_at_moves();
        let mut touching = 0;
        for (k, collider) in self.colliders.iter().enumerate() {
            let motion = self.motion(collider);
            for row in 0..self.layout.rows {
                for column in (0..self.layout.columns).step_by(LANES) {
                    let slot = self.layout.slot(row, column);
                    let block = slot / LANES;
                    let known = k * self.room.blocks + block;
                    let spent = self.room.moved[block] + self.room.pushed[block] + motion.reach;
                    let left = self.room.clearance[known] - spent;
                    self.room.clearance[known] = left;
                    if left > 0.0 {
                        continue;
                    }
                    let (gap, count) = self.resolve(slot, &motion);
                    touching += count;
                    self.room.clearance[known] = larger(gap, 0.0);
                    self.room.pushed[block] += larger(-gap, 0.0);
                }
            }
        }
        touching
    }
}

impl<'a> ResolveContacts<'a> {
    fn motion(&self, collider: &Collider<'a>) -> Motion<'a> {
        Motion::new(collider, self.origin, self.friction, self.span.from, self.span.to)
    }

    /// Takes how far the particles of each block have moved since contact last looked at them: by
    /// their displacements, and by what it pushed them itself.
    #[inline(always)]
    fn look_at_moves(&mut self) {
        for row in 0..self.layout.rows {
            for column in (0..self.layout.columns).step_by(LANES) {
                let slot = self.layout.slot(row, column);
                let d = Block3::load(self.d, slot);
                let mut square = Block::ZERO;
                for i in 0..LANES {
                    square.0[i] = d.at(i).dot(d.at(i));
                }
                let block = slot / LANES;
                self.room.moved[block] = square.largest().sqrt() + self.room.pushed[block];
                self.room.pushed[block] = 0.0;
            }
        }
    }

    /// Holds one block out of one collider; returns the least gap above epsilon (below zero where a
    /// particle was pushed) and the contacts.
    #[inline(always)]
    fn resolve(&mut self, slot: usize, motion: &Motion<'_>) -> (f32, u32) {
        let w = Block::load(self.inverse_mass, slot);
        let x = Block3::load_sum(self.x, self.d, slot);
        let mut points = PointBlock::default();
        for i in 0..LANES {
            let local = motion.after.to_local(x.at(i));
            (points.x[i], points.y[i], points.z[i]) = (local.x, local.y, local.z);
        }
        let mut samples = SampleBlock::default();
        motion.shape.sample_block(&points, &mut samples);
        let mut depth = Block::ZERO;
        let mut gap = Block::ZERO;
        for i in 0..LANES {
            let above = samples.distance[i] * motion.after.scale - self.epsilon;
            gap.0[i] = if w.0[i] > 0.0 { above } else { f32::INFINITY };
            depth.0[i] = larger(-gap.0[i], 0.0);
        }
        let margin = motion.shape.overestimate() * motion.after.scale;
        let least = gap.smallest();
        let nearest = least - margin;
        if least >= 0.0 {
            return (nearest, 0);
        }
        let surface = surface_displacements(&points, &x, motion);
        self.push_out(slot, &depth, &samples, &surface, motion);
        (nearest, depth.0.iter().filter(|&&d| d > 0.0).count() as u32)
    }

    /// Moves particles out by their depth, and takes approach and friction from their displacements.
    #[inline(always)]
    fn push_out(
        &mut self,
        slot: usize,
        depth: &Block,
        samples: &SampleBlock,
        surface: &Block3,
        motion: &Motion<'_>,
    ) {
        let (mut x, mut d) = (Block3::load(self.x, slot), Block3::load(self.d, slot));
        for i in 0..LANES {
            let normal =
                motion.after.rotate(Vec3::new(samples.nx[i], samples.ny[i], samples.nz[i]));
            let relative = d.at(i) - surface.at(i);
            let approach = relative.dot(normal);
            // What the push undoes of the approach belongs to the substep. The rest is a displacement
            // without velocity: being pushed out gives no speed.
            let push = depth.0[i];
            let undone = larger(if push < -approach { push } else { -approach }, 0.0);
            let tangential = relative - normal * approach;
            let sliding = larger(tangential.dot(tangential).sqrt(), LEAST_SLIDING);
            let part = motion.friction * undone / sliding;
            let braked = tangential * if part < 1.0 { part } else { 1.0 };
            let touching = push > 0.0;
            let into_d = if touching { normal * undone - braked } else { Vec3::ZERO };
            let into_x = if touching { normal * (push - undone) } else { Vec3::ZERO };
            d.set(i, d.at(i) + into_d);
            x.set(i, x.at(i) + into_x);
        }
        d.store(self.d, slot);
        x.store(self.x, slot);
    }
}

/// How far the collider moves at the particles in the substep \[m\].
#[inline(always)]
fn surface_displacements(local: &PointBlock, x: &Block3, motion: &Motion<'_>) -> Block3 {
    let mut surface = Block3::ZERO;
    if motion.moves {
        for i in 0..LANES {
            surface.set(i, x.at(i) - motion.before.to_world(local.point(i)));
        }
    }
    surface
}
