//! Cloths that no view sees stand still, and go on where their leader is as they turn up.
//!
//! While one is culled nothing of it is followed: its anchors' poses and its skin are those of its last tick, and anchors that are new are
//! taken back to that. As it comes back a teleport takes it from there to where they are.

use bevy::camera::primitives::Aabb;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy::time::Virtual;

use crate::cloth::culling::ClothCulling;
use crate::error::ClothComponent;
use crate::error::failures::Failures;
use crate::pose::pose_now;
use crate::simulation::ClothSimulation;
use crate::solver::{Pose, RigidMotion};

/// How much larger the bounds of a worn cloth are taken: limbs have moved since.
const ROOM: f32 = 1.25;

/// Whether Bevy tells what is seen. Set as the app is built.
#[derive(Resource)]
pub(crate) struct Seeing;

/// Whether a cloth is seen.
#[derive(Clone, Default)]
pub(crate) struct Culling {
    in_force: ClothCulling,
    /// How long it has not been seen \[s\].
    unseen: f32,
    /// It stands still.
    pub culled: bool,
    /// It was culled, and has not taken a tick since.
    pub returns: bool,
}

impl Culling {
    /// Whether the cloth stands still, or goes on from there in its next tick.
    pub fn has_culled(&self) -> bool {
        self.culled || self.returns
    }
}

/// Culls cloths, once a frame and before its ticks, and lets them come back.
pub(crate) fn cull_cloths(
    mut cloths: Query<(
        Entity,
        &mut ClothSimulation,
        Option<&ClothCulling>,
        Option<&ViewVisibility>,
    )>,
    seeing: Option<Res<Seeing>>,
    time: Option<Res<Time<Virtual>>>,
    mut failures: Failures,
) {
    let passed = time.map_or(0.0, |time| time.delta_secs());
    for (entity, mut cloth, asked, view) in &mut cloths {
        let Some(asked) = asked else {
            if cloth.culling.culled {
                cloth.come_back();
            }
            continue;
        };
        let outcome = asked.validate().map(|()| cloth.culling.in_force = *asked);
        failures.tell_numbers(entity, ClothComponent::ClothCulling, outcome);
        if seeing.is_none() || view.is_none_or(|view| view.get()) {
            cloth.culling.unseen = 0.0;
            if cloth.culling.culled {
                cloth.come_back();
            }
        } else if !cloth.culling.culled && !cloth.is_hanging() {
            cloth.culling.unseen += passed;
            cloth.culling.culled = cloth.culling.unseen >= cloth.culling.in_force.after;
        }
    }
}

impl ClothSimulation {
    fn come_back(&mut self) {
        self.culling = Culling { in_force: self.culling.in_force, returns: true, ..default() };
        self.frame.teleport_asked = true;
    }

    /// In the first tick after it was culled, a worn cloth has gone along with each place of its skin.
    pub(crate) fn settle_in(&mut self) {
        if !core::mem::take(&mut self.culling.returns) {
            return;
        }
        let Some(skin) = &mut self.skin else { return };
        let places = skin.arrive(&self.solver);
        // Where that is nowhere, the tick says so.
        let _ = self.solver.place(&places);
    }

    /// The way of a culled cloth's leader from its last tick on to where it is now.
    pub(crate) fn carried_to(&self, now: &Pose) -> Option<RigidMotion> {
        let attachments = &self.held.attachments;
        let leader = &attachments.anchors[attachments.reference()?];
        Some(RigidMotion::between(&leader.pose.end(), now))
    }

    /// Where something that is at `now` would be if the leader of a culled cloth were where it was in the cloth's last tick: it goes
    /// along with the leader from there.
    pub(crate) fn before_it_was_culled(&self, now: Pose, transforms: &TransformHelper) -> Pose {
        let leader = self.leader_now(transforms).filter(|_| self.culling.has_culled());
        match leader.and_then(|leader| self.carried_to(&leader)) {
            Some(way) => way.inverse().apply_to_pose(&now),
            None => now,
        }
    }

    /// Where what leads the cloth is now.
    pub(crate) fn leader_now(&self, transforms: &TransformHelper) -> Option<Pose> {
        let attachments = &self.held.attachments;
        pose_now(transforms, attachments.anchors[attachments.reference()?].entity).ok()
    }

    /// Where a culled cloth is about, in the frame of its entity, from where its leader is now.
    pub(crate) fn culled_bounds(
        &self,
        transforms: &TransformHelper,
        frame: &Affine3A,
    ) -> Option<Aabb> {
        let motion = self.carried_to(&self.leader_now(transforms)?)?;
        let (min, max) = self.solver.bounds();
        let into_frame = frame.inverse();
        let corners = (0..8).map(|corner| {
            let far = |axis: usize| if corner >> axis & 1 == 0 { min[axis] } else { max[axis] };
            let corner = motion.apply(Vec3::new(far(0), far(1), far(2)));
            into_frame.transform_point3(corner)
        });
        let mut bounds = Aabb::enclosing(corners)?;
        if self.skin.is_some() {
            bounds.half_extents *= ROOM;
        }
        (bounds.center.is_finite() && bounds.half_extents.is_finite()).then_some(bounds)
    }
}
