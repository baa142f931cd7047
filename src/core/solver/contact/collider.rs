//! The solids that a cloth collides with, and where they are in each substep.

use bevy_math::bounding::Aabb3d;
use bevy_math::{Mat3, Vec3};

use crate::sdf::{KnownShape, NearestBlock, PointBlock, SampleBlock, SegmentBlock, SignedDistance};
use crate::solver::contact::mobility::{Deviation, Mobility};
use crate::solver::contact::pose::Pose;

/// A collider's way through a tick: from pose to pose, evenly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColliderMotion {
    start: Pose,
    end: Pose,
    /// A box around all places that the surface takes, in world space; `None` if unbounded.
    bounds: Option<Aabb3d>,
    valid: bool,
}

impl ColliderMotion {
    /// The way of a shape between two poses in world space.
    pub fn new(shape: &dyn SignedDistance, start: Pose, end: Pose) -> Self {
        let bounds = shape.bounds().map(|shape| swept_box(&shape, &start, &end));
        Self { start, end, bounds, valid: start.is_valid() && end.is_valid() }
    }

    /// Pose where the tick begins.
    pub fn start(&self) -> Pose {
        self.start
    }

    /// Pose where it ends.
    pub fn end(&self) -> Pose {
        self.end
    }

    /// A box around all places that the surface takes in the tick, in world space; `None` if it is
    /// unbounded.
    pub fn bounds(&self) -> Option<Aabb3d> {
        self.bounds
    }
}

/// A rigid shape that a cloth collides with, and its motion through a tick.
#[derive(Clone, Copy, Debug)]
pub struct Collider<'a> {
    /// The shape, in its own frame.
    pub shape: &'a dyn SignedDistance,
    /// The collider's motion.
    pub motion: ColliderMotion,
    /// Coulomb's coefficient; the pair's is the geometric mean with the cloth's.
    pub friction: f32,
    /// The layers that it is in, a bit each. A cloth that shares none passes through.
    pub layers: u32,
    /// Tells it from the others from tick to tick, as an entity's bits do: what a cloth remembers of its contact is found
    /// again by it, wherever the collider is in the list. Zero: by its place in the list.
    pub key: u64,
    /// Whether the impulse that the cloth gives it is asked for, see
    /// [`ClothSolver::impulse`](crate::solver::ClothSolver::impulse).
    pub measured: bool,
    /// The place in its own frame that angular impulses are about: its centre of mass, where it is a body \[m\].
    pub centre: Vec3,
    /// Tells the body that it is a part of from others, as an entity's bits do: colliders of one body move as one, and pins may pull at
    /// it ([`StepInput::pulls`](crate::solver::StepInput::pulls)). Zero: it is a body by itself.
    pub body: u64,
    /// What the cloth moves it by within the tick, where it is a body that is moved. Its impulse is asked for then.
    pub mobility: Option<Mobility>,
}

impl<'a> Collider<'a> {
    /// A collider that stays at a pose in world space, with a friction of 0.5, in all layers.
    pub fn new(shape: &'a dyn SignedDistance, pose: Pose) -> Self {
        let motion = ColliderMotion::new(shape, pose, pose);
        Self {
            shape,
            motion,
            friction: 0.5,
            layers: u32::MAX,
            key: 0,
            measured: false,
            centre: Vec3::ZERO,
            body: 0,
            mobility: None,
        }
    }

    /// The collider between other poses.
    pub fn between(self, start: Pose, end: Pose) -> Self {
        Self { motion: ColliderMotion::new(self.shape, start, end), ..self }
    }

    /// Where it is at the tick's end.
    pub fn moving_to(self, end: Pose) -> Self {
        self.between(self.motion.start, end)
    }

    /// With another coefficient of friction.
    pub fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    /// In these layers, a bit each.
    pub fn in_layers(self, layers: u32) -> Self {
        Self { layers, ..self }
    }

    /// Asks for the impulse that the cloth gives it.
    pub fn measured(self) -> Self {
        Self { measured: true, ..self }
    }

    /// A body that the cloth moves, with its centre of mass there in its own frame \[m\].
    pub fn moved_by(self, mobility: Mobility, centre: Vec3) -> Self {
        Self { centre, mobility: Some(mobility), ..self }
    }

    /// Distance of a place in world space from the surface as the tick begins \[m\]; negative inside.
    pub(crate) fn distance_at_start(&self, place: Vec3) -> f32 {
        let Pose { scale, .. } = self.motion.start;
        self.shape.distance(Frame::new(&self.motion.start).to_local(place)) * scale
    }

    /// Where its centre of mass is planned to be after a part of the tick, in world space \[m\].
    pub(super) fn centre_at(&self, part: f32) -> Vec3 {
        self.motion.start.interpolate(&self.motion.end, part).apply(self.centre)
    }

    /// How far its centre of mass is planned to go in the tick \[m\].
    pub(crate) fn way(&self) -> Vec3 {
        self.centre_at(1.0) - self.centre_at(0.0)
    }

    /// Whether every number can be used.
    pub(crate) fn is_usable(&self) -> bool {
        self.motion.valid
            && self.friction >= 0.0
            && self.friction <= 1e3
            && self.centre.is_finite()
            && self.mobility.is_none_or(|mobility| mobility.is_valid())
    }
}

/// A box around all places of a shape on its way between two poses.
fn swept_box(shape: &Aabb3d, start: &Pose, end: &Pose) -> Aabb3d {
    let (min, max) = (Vec3::from(shape.min), Vec3::from(shape.max));
    let ends = [start, end].into_iter();
    if start.rotation == end.rotation {
        // Every point goes straight.
        let places = ends.flat_map(|pose| corners(min, max).map(|p| pose.apply(p)));
        return around(places);
    }
    // What turns stays within the distance of its farthest corner.
    let farthest = min.abs().max(max.abs()).length();
    around(ends.flat_map(|pose| {
        let far = Vec3::splat(farthest * pose.scale);
        [pose.translation - far, pose.translation + far]
    }))
}

fn around(points: impl Iterator<Item = Vec3>) -> Aabb3d {
    let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (min, max) = points.fold(none, |(min, max), p| (min.min(p), max.max(p)));
    Aabb3d { min: min.into(), max: max.into() }
}

fn corners(min: Vec3, max: Vec3) -> impl Iterator<Item = Vec3> {
    (0..8).map(move |i| {
        let pick = |bit: usize, low: f32, high: f32| if i & bit == 0 { low } else { high };
        Vec3::new(pick(1, min.x, max.x), pick(2, min.y, max.y), pick(4, min.z, max.z))
    })
}

/// A pose in the cloth's frame as the kernel needs it: columns of the rotation, and translation.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    rotation: Mat3,
    translation: Vec3,
    pub scale: f32,
}

impl Frame {
    fn new(pose: &Pose) -> Self {
        Self {
            rotation: Mat3::from_quat(pose.rotation),
            translation: pose.translation,
            scale: pose.scale,
        }
    }

    #[inline(always)]
    pub fn to_local(self, x: Vec3) -> Vec3 {
        let d = x - self.translation;
        let r = &self.rotation;
        Vec3::new(d.dot(r.x_axis), d.dot(r.y_axis), d.dot(r.z_axis)) * (1.0 / self.scale)
    }

    #[inline(always)]
    pub fn rotate(self, p: Vec3) -> Vec3 {
        let r = &self.rotation;
        r.x_axis * p.x + r.y_axis * p.y + r.z_axis * p.z
    }

    #[inline(always)]
    pub fn to_world(self, p: Vec3) -> Vec3 {
        self.rotate(p) * self.scale + self.translation
    }
}

/// A collider's motion through one substep.
pub(super) struct Motion<'a> {
    pub shape: &'a dyn SignedDistance,
    pub known: Option<KnownShape<'a>>,
    pub before: Frame,
    pub after: Frame,
    pub moves: bool,
    /// How far any point of the surface moves at most \[m\].
    pub reach: f32,
    /// The pair's coefficient.
    pub friction: f32,
    /// How far the shape may overstate a distance \[m\].
    pub overestimate: f32,
    /// Displacement beyond epsilon from which on the whole path of a particle is looked at \[m\].
    pub fast: f32,
    /// Least radius of curvature of the surface where it is convex \[m\].
    pub least_radius: f32,
    pub measured: bool,
    /// Whether it is a body that the cloth moves.
    pub yields: bool,
    /// The place that angular impulses are about, when the substep begins and when it ends \[m\].
    pub centre: [Vec3; 2],
}

impl Motion<'_> {
    /// Samples the shape at a block of points of its frame; in the instructions around it where it is known.
    #[inline(always)]
    pub fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        match self.known {
            Some(known) => known.sample_block(points, out),
            None => self.shape.sample_block(points, out),
        }
    }

    /// The places of segments of the shape's frame that are nearest to it; in the instructions around it where it is known.
    #[inline(always)]
    pub fn nearest_on_segments(&self, segments: &SegmentBlock, out: &mut NearestBlock) {
        match self.known {
            Some(known) => known.nearest_on_segments(segments, out),
            None => self.shape.nearest_on_segments(segments, out),
        }
    }
}

impl<'a> Motion<'a> {
    /// From part `from` of the tick to part `to`, with how far the collider has `deviated` from its planned way at both.
    pub fn new(
        collider: &Collider<'a>,
        origin: Vec3,
        friction: f32,
        [from, to]: [f32; 2],
        deviated: [Deviation; 2],
    ) -> Self {
        // Seen from the cloth: far from the world's origin, poses on the way would be rounded, and so the
        // collider's speed.
        let seen = |pose: Pose| Pose { translation: pose.translation - origin, ..pose };
        let (start, end) = (seen(collider.motion.start), seen(collider.motion.end));
        let planned = [from, to].map(|part| start.interpolate(&end, part));
        let centres = planned.map(|pose| pose.apply(collider.centre));
        let at = |i: usize| deviated[i].apply(&planned[i], centres[i]);
        let (before, after) = (at(0), at(1));
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
            known: collider.shape.known(),
            before: Frame::new(&before),
            after: Frame::new(&after),
            moves,
            reach,
            friction: (collider.friction * friction).sqrt(),
            overestimate: collider.shape.overestimate() * after.scale,
            // The rest is for what is not met head on: a way may cut off a part of a curved side.
            fast: 0.125 * collider.shape.core_depth() * after.scale,
            least_radius: collider.shape.least_radius() * after.scale,
            measured: collider.measured || collider.mobility.is_some(),
            yields: collider.mobility.is_some(),
            centre: [centres[0] + deviated[0].shift, centres[1] + deviated[1].shift],
        }
    }
}
