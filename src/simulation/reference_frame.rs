//! How a cloth takes part in what its entity does: carried along by a teleport, left behind by its
//! inertia, or riding along.
//!
//! A cloth is simulated in world space, and its *reference* is what leads it: its own entity, or, where
//! only anchors hold it, the first of them. A jump of the reference carries the cloth rigidly, with no
//! velocity made. Where it rides along, a tick is taken in a frame that moves with it: pins, colliders
//! and gravity are seen from there, and the result is carried along at the tick's end.

use core::f32::consts::PI;

use bevy::math::ops;
use bevy::prelude::*;

use crate::cloth::teleport::{ClothInertia, ClothTeleport, ResetCloth, TeleportCloth};
use crate::collider::tick_colliders::ColliderRoom;
use crate::pose::comes_along;
use crate::simulation::ClothSimulation;
use crate::simulation::attachments::Anchor;
use crate::solver::{
    ClothSolver, Collider, Impulse, ParameterError, Pose, RigidMotion, SolverError, TickReport,
};

/// Requests for a cloth's next tick, and the motion of its reference frame in this one.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct ReferenceFrame {
    pub(crate) teleport: ClothTeleport,
    pub(crate) inertia: ClothInertia,
    /// A teleport is asked for.
    pub teleport_asked: bool,
    /// A reset is asked for.
    pub reset_asked: bool,
    /// How the cloth has been carried in this tick, if it has: colliders that went the same way came along.
    pub(crate) jump: Option<RigidMotion>,
    /// The motion that the cloth rides along with in this tick.
    pub ride: Option<RigidMotion>,
}

impl ReferenceFrame {
    /// Takes over the components, or their defaults. What cannot be used is refused, and the last good
    /// numbers stay.
    pub fn set_teleport(&mut self, teleport: Option<&ClothTeleport>) -> Result<(), ParameterError> {
        let teleport = teleport.copied().unwrap_or_default();
        teleport.validate().map(|()| self.teleport = teleport)
    }

    /// See [`ReferenceFrame::set_teleport`].
    pub fn set_inertia(&mut self, inertia: Option<&ClothInertia>) -> Result<(), ParameterError> {
        let inertia = inertia.copied().unwrap_or_default();
        inertia.validate().map(|()| self.inertia = inertia)
    }

    /// Whether the cloth is asked to be where what leads it is, and not on its way there.
    pub fn is_put_elsewhere(&self) -> bool {
        self.teleport_asked || self.reset_asked
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

    /// Begins a tick: follows the motion of the reference. Returns the motion that carries the cloth at once, if any;
    /// else sets the ride.
    pub fn follow(
        &mut self,
        anchors: &[Anchor],
        reference: usize,
        stands: bool,
    ) -> Option<RigidMotion> {
        let asked = core::mem::take(&mut self.teleport_asked);
        (self.jump, self.ride) = (None, None);
        let (from, to) = (anchors[reference].pose.start(), anchors[reference].pose.end());
        if from == to {
            return None;
        }
        let motion = RigidMotion::between(&from, &to);
        if stands || asked || self.all_jump(anchors, reference, &motion) {
            self.jump = Some(motion);
            return Some(motion);
        }
        let ridden = motion.part(1.0 - self.inertia.linear, 1.0 - self.inertia.angular);
        self.ride = (!ridden.is_none()).then_some(ridden);
        None
    }

    /// Whether the reference jumps, and whatever else holds the cloth jumps with it. Where anything
    /// holds it hard, what pulls it softly has no say.
    fn all_jump(&self, anchors: &[Anchor], reference: usize, motion: &RigidMotion) -> bool {
        let leads = &anchors[reference].pose;
        let hard = anchors[reference].holds > 0;
        let holds = |anchor: &&Anchor| if hard { anchor.holds > 0 } else { anchor.pulls > 0 };
        self.is_jump(&leads.start(), &leads.end())
            && anchors.iter().filter(holds).all(|anchor| {
                let carried = motion.apply_to_pose(&anchor.pose.start());
                !self.is_jump(&carried, &anchor.pose.end())
            })
    }

    /// A direction of the world (gravity, the wind) as it is seen in the ride, at the middle of the
    /// tick.
    pub fn seen(&self, vector: Vec3) -> Vec3 {
        self.turn_of_ride().map_or(vector, |turn| turn.inverse() * vector)
    }

    /// A vector that [`ReferenceFrame::seen`] gave, in the world again.
    pub fn in_world(&self, seen: Vec3) -> Vec3 {
        self.turn_of_ride().map_or(seen, |turn| turn * seen)
    }

    /// An impulse that was seen in the ride, in the world.
    pub fn impulse_in_world(&self, Impulse { linear, angular }: Impulse) -> Impulse {
        Impulse { linear: self.in_world(linear), angular: self.in_world(angular) }
    }

    /// How far the ride has turned at the middle of the tick.
    fn turn_of_ride(&self) -> Option<Quat> {
        let ride = self.ride.filter(|ride| ride.rotation != Quat::IDENTITY)?;
        Some(ride.part(0.0, 0.5).rotation)
    }

    /// Calls `act` with the colliders as the cloth meets them, which are put in `room`.
    pub fn with_colliders<T>(
        &self,
        room: &mut ColliderRoom,
        colliders: &[Collider],
        act: impl FnOnce(&[Collider]) -> T,
    ) -> T {
        let Some(seen) = self.colliders(room, colliders) else { return act(colliders) };
        let result = act(&seen);
        *room = ColliderRoom::keep(seen);
        result
    }

    /// The colliders as the cloth meets them, in the memory of `room`, which may be given back; `None` where it meets them as they are.
    pub fn colliders<'a>(
        &self,
        room: &mut ColliderRoom,
        colliders: &[Collider<'a>],
    ) -> Option<Vec<Collider<'a>>> {
        if self.ride.is_none() && self.jump.is_none() {
            return None;
        }
        let back = self.ride.map(|ride| ride.inverse());
        let mut seen = core::mem::take(room).reuse();
        seen.extend(colliders.iter().map(|collider| {
            let (start, end) = (collider.motion.start(), collider.motion.end());
            let start = self.jump.map_or(start, |jump| self.carried(&jump, start, &end));
            let end = back.map_or(end, |back| back.apply_to_pose(&end));
            collider.between(start, end)
        }));
        Some(seen)
    }

    /// Where a collider came from, as a cloth sees it that was carried by a jump: along with the cloth, from where it is now if it has jumped
    /// by itself, or from where it was.
    fn carried(&self, jump: &RigidMotion, start: Pose, end: &Pose) -> Pose {
        if comes_along(jump, &start, end) {
            jump.apply_to_pose(&start)
        } else if self.is_jump(&start, end) {
            *end
        } else {
            start
        }
    }

    /// How far the ride takes a place in the tick \[m\].
    pub fn drift(&self, place: Vec3) -> Vec3 {
        self.ride.map_or(Vec3::ZERO, |ride| ride.apply(place) - place)
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
            "entity {entity} has no running cloth, so nothing was teleported or reset; a cloth that is still \
             loading starts where its entity is"
        ),
    }
}
