//! How a cloth takes part in what its entity does: carried along by a teleport, left behind by its
//! inertia, or riding along.
//!
//! A cloth is simulated in world space, and its *reference* is what leads it: its own entity, or, where
//! only anchors hold it, the first of them. A jump of the reference carries the cloth rigidly, with no
//! velocity made. Where it rides along, a tick is taken in a frame that moves with it: pins, colliders
//! and gravity are seen from there, and the result is carried along at the tick's end.

use super::{ClothSimulation, attachment::Anchor};
use crate::{
    collider::ColliderRoom,
    solver::{ClothSolver, Collider, ParameterError, Pose, RigidMotion, SolverError, TickReport},
};
use bevy::{math::ops, prelude::*};
use core::f32::consts::{FRAC_PI_3, PI};

/// From what motion in one tick on an entity counts as teleported, so that its cloth is carried along.
/// A cloth without this component has the default.
///
/// What jumps is the cloth's entity, or the anchors that alone hold it, all of them together. The cloth
/// keeps its shape and its motion, turned with the entity, and goes on from there. Colliders that jump
/// in the same tick do not sweep through it. See [`TeleportCloth`] for shorter jumps.
///
/// What is moved once a frame is judged by the frame's whole way, with as much room for each of its
/// ticks, four at most.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothTeleport {
    /// Way in a tick that is a jump \[m\]. Higher lets faster things drag their cloth; infinite is
    /// never. The default of 2 m is 128 m/s at 64 ticks a second.
    pub distance: f32,
    /// Turn in a tick that is a jump \[rad\]. Higher lets faster turns swing their cloth; infinite is
    /// never. The default is 60 degrees.
    pub angle: f32,
}

impl Default for ClothTeleport {
    fn default() -> Self {
        Self { distance: 2.0, angle: FRAC_PI_3 }
    }
}

impl ClothTeleport {
    /// No motion is a jump.
    pub const NEVER: Self = Self { distance: f32::INFINITY, angle: f32::INFINITY };

    fn validate(&self) -> Result<(), ParameterError> {
        if self.distance.is_nan() || self.distance <= 0.0 {
            let range = "above 0 m";
            return Err(ParameterError { name: "distance", value: self.distance, range });
        }
        if self.angle.is_nan() || self.angle < 0.01 {
            let range = "at least 0.01 rad";
            return Err(ParameterError { name: "angle", value: self.angle, range });
        }
        Ok(())
    }
}

/// How much of its entity's motion a cloth feels. Without this component it feels all of it.
///
/// At 1 the cloth is a thing of the world: an entity that moves drags it by its pins, or leaves it
/// behind. At 0 it rides along, as in a closed car, and only motion relative to the entity (pins that
/// follow an animation, colliders, gravity, wind) moves it. Between, that part of the motion is felt: a
/// cape on a fast runner wants some 0.3. Where anchors alone hold the cloth, the motion is that of the
/// first.
///
/// The wind that it feels is that in the world, less the part of the motion that it does not feel.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothInertia {
    /// Part of the entity's shifts that is felt, from 0 to 1 \[1\]. Higher lags behind more.
    pub linear: f32,
    /// Part of its turns that is felt, from 0 to 1 \[1\]. Higher lags behind more.
    pub angular: f32,
}

impl Default for ClothInertia {
    fn default() -> Self {
        Self { linear: 1.0, angular: 1.0 }
    }
}

impl ClothInertia {
    /// The same part of shifts and turns.
    pub fn new(part: f32) -> Self {
        Self { linear: part, angular: part }
    }

    fn validate(&self) -> Result<(), ParameterError> {
        for (name, value) in [("linear", self.linear), ("angular", self.angular)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(ParameterError { name, value, range: "from 0 to 1" });
            }
        }
        Ok(())
    }
}

/// Lets the cloth be carried along, however short the way, to where its entity and anchors are at the
/// next tick: the explicit form of [`ClothTeleport`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// fn step_aside(mut commands: Commands, mut cloth: Single<(Entity, &mut Transform), With<Cloth>>) {
///     cloth.1.translation.x += 1.0;
///     commands.trigger(TeleportCloth { entity: cloth.0 });
/// }
/// # bevy::ecs::system::assert_is_system(step_aside);
/// ```
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct TeleportCloth {
    /// The cloth.
    pub entity: Entity,
}

/// Puts the cloth back to its rest shape, where its entity (or the anchor that leads it) is at the next
/// tick, at rest. One that had diverged goes on.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResetCloth {
    /// The cloth.
    pub entity: Entity,
}

/// What a cloth was asked to do at its next tick, and what its reference did in this one.
#[derive(Default)]
pub(crate) struct Following {
    pub(super) teleport: ClothTeleport,
    pub(super) inertia: ClothInertia,
    /// A teleport is asked for.
    pub teleport_asked: bool,
    /// A reset is asked for.
    pub reset_asked: bool,
    /// It has been carried in this tick: colliders that jumped as well came along.
    pub(super) jumped: bool,
    /// What it rides along with in this tick.
    pub ride: Option<RigidMotion>,
    pub(super) room: ColliderRoom,
}

impl Following {
    /// Takes over the components, or their defaults. What cannot be used is refused, and the last good
    /// numbers stay.
    pub fn set_teleport(&mut self, teleport: Option<&ClothTeleport>) -> Result<(), ParameterError> {
        let teleport = teleport.copied().unwrap_or_default();
        teleport.validate().map(|()| self.teleport = teleport)
    }

    /// See [`Following::set_teleport`].
    pub fn set_inertia(&mut self, inertia: Option<&ClothInertia>) -> Result<(), ParameterError> {
        let inertia = inertia.copied().unwrap_or_default();
        inertia.validate().map(|()| self.inertia = inertia)
    }

    /// Whether what is moved once a frame has jumped in a frame of so many ticks.
    pub fn is_jump_of_frame(&self, from: &Pose, to: &Pose, ticks: u32) -> bool {
        let room = ticks.clamp(1, 4) as f32;
        self.is_further(from, to, self.teleport.distance * room)
    }

    /// Whether what moves so in a tick has jumped.
    pub fn is_jump(&self, from: &Pose, to: &Pose) -> bool {
        self.is_further(from, to, self.teleport.distance)
    }

    fn is_further(&self, from: &Pose, to: &Pose, distance: f32) -> bool {
        if from == to {
            return false;
        }
        let far = from.translation.distance_squared(to.translation) > distance * distance;
        let angle = self.teleport.angle;
        far || angle < PI && from.rotation.dot(to.rotation).abs() < ops::cos(0.5 * angle)
    }

    /// What the cloth does as its reference moves: the motion that carries it at once, if any. Begins a
    /// tick.
    pub fn follow(
        &mut self,
        anchors: &[Anchor],
        reference: usize,
        stands: bool,
    ) -> Option<RigidMotion> {
        let asked = core::mem::take(&mut self.teleport_asked);
        (self.jumped, self.ride) = (false, None);
        let (from, to) = anchors[reference].tick;
        if from == to {
            return None;
        }
        let motion = RigidMotion::between(&from, &to);
        if stands || asked || self.all_jump(anchors, reference, &motion) {
            self.jumped = true;
            return Some(motion);
        }
        let ridden = motion.part(1.0 - self.inertia.linear, 1.0 - self.inertia.angular);
        self.ride = (!ridden.is_none()).then_some(ridden);
        None
    }

    /// Whether the reference jumps, and whatever else holds the cloth jumps with it. Where anything
    /// holds it hard, what pulls it softly has no say.
    fn all_jump(&self, anchors: &[Anchor], reference: usize, motion: &RigidMotion) -> bool {
        let (from, to) = anchors[reference].tick;
        let hard = anchors[reference].holds > 0;
        let holds = |anchor: &&Anchor| if hard { anchor.holds > 0 } else { anchor.pulls > 0 };
        self.is_jump(&from, &to)
            && anchors.iter().filter(holds).all(|anchor| {
                let (from, to) = &anchor.tick;
                !self.is_jump(&motion.apply_to_pose(from), to)
            })
    }

    /// A direction of the world (gravity, the wind) as it is seen in the ride, at the middle of the
    /// tick.
    pub fn seen(&self, vector: Vec3) -> Vec3 {
        self.turn_of_ride().map_or(vector, |turn| turn.inverse() * vector)
    }

    /// What [`Following::seen`] makes of a vector, in the world again.
    pub fn in_world(&self, seen: Vec3) -> Vec3 {
        self.turn_of_ride().map_or(seen, |turn| turn * seen)
    }

    /// How far the ride has turned at the middle of the tick.
    fn turn_of_ride(&self) -> Option<Quat> {
        let ride = self.ride.filter(|ride| ride.rotation != Quat::IDENTITY)?;
        Some(ride.part(0.0, 0.5).rotation)
    }

    /// Calls `act` with the colliders as the cloth meets them.
    pub fn with_colliders<T>(
        &mut self,
        colliders: &[Collider],
        act: impl FnOnce(&[Collider]) -> T,
    ) -> T {
        if self.ride.is_none() && !self.jumped {
            return act(colliders);
        }
        let back = self.ride.map(|ride| ride.inverse());
        let mut seen = core::mem::take(&mut self.room).reuse();
        seen.extend(colliders.iter().map(|collider| {
            let (start, end) = (collider.motion.start(), collider.motion.end());
            let start = if self.jumped && self.is_jump(&start, &end) { end } else { start };
            let end = back.map_or(end, |back| back.apply_to_pose(&end));
            collider.between(start, end)
        }));
        let result = act(&seen);
        self.room = ColliderRoom::keep(seen);
        result
    }

    /// Ends a tick: carries the cloth along with its ride, if the tick was taken.
    pub fn end_ride(
        &self,
        solver: &mut ClothSolver,
        outcome: &Option<Result<TickReport, SolverError>>,
    ) {
        if let (Some(ride), Some(Ok(_))) = (self.ride, outcome) {
            // Where the world ends the cloth stays behind; its pins' targets are refused there.
            let _ = solver.ride(&ride);
        }
    }
}

/// Passes a teleport on to the running cloth.
pub(crate) fn ask_for_teleport(event: On<TeleportCloth>, cloths: Query<&mut ClothSimulation>) {
    ask(event.entity, cloths, ClothSimulation::teleport);
}

/// Passes a reset on to the running cloth.
pub(crate) fn ask_for_reset(event: On<ResetCloth>, cloths: Query<&mut ClothSimulation>) {
    ask(event.entity, cloths, ClothSimulation::reset);
}

fn ask(
    entity: Entity,
    mut cloths: Query<&mut ClothSimulation>,
    what: impl FnOnce(&mut ClothSimulation),
) {
    match cloths.get_mut(entity) {
        Ok(mut cloth) => what(&mut cloth),
        Err(_) => tracing::warn!(
            "{entity} is no running cloth, so that nothing was teleported or reset; one that is still \
             loading starts where its entity is"
        ),
    }
}
