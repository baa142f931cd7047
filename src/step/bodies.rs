//! Bodies that cloths move: shared out between the cloths near them, and given what came of it.

use bevy::prelude::*;

use crate::collider::mass::{BodyImpulse, BodyMemory, ColliderMass, Held};
use crate::collider::tick_body::LoneBody;
use crate::collider::tick_colliders::TickColliders;
use crate::pose::{to_local, to_world};
use crate::sdf::DistanceField;
use crate::simulation::ClothSimulation;
use crate::solver::{Impulse, Pose};

/// How far from a body a cloth may be to count as near it \[m\].
const NEAR: f32 = 0.05;
/// Part by which what cloths do to a body that sleeps may change: of what they did, and of its weight.
const UNCHANGED: f32 = 0.1;
/// Acceleration that stands for its weight \[m/s2\].
const GRAVITY: f32 = 9.81;

/// Counts the cloths near each body: each meets an equal part of it. Together they would else stop it several times.
pub(crate) fn share_bodies(cloths: Query<&ClothSimulation>, mut snapshot: ResMut<TickColliders>) {
    let TickColliders { colliders, lone_bodies, .. } = snapshot.bypass_change_detection();
    let pulls = |cloth: &ClothSimulation, body: Entity| {
        let mut pulls = cloth.tick.motions.pulls.iter();
        cloth.tick.step.runs && pulls.any(|pull| pull.body == body.to_bits())
    };
    for gathered in colliders {
        let (Some(body), Some(motion)) = (&mut gathered.body, gathered.motion) else { continue };
        let entity = body.entity;
        let is_near = |cloth: &&ClothSimulation| {
            let (low, high) = cloth.solver.bounds();
            let bounds = motion.bounds().filter(|_| cloth.tick.step.runs);
            let touches = bounds.is_some_and(|bounds| {
                let (min, max) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
                (low - max).max(min - high).max_element() < NEAR
            });
            touches || pulls(cloth, entity)
        };
        body.cloths = cloths.iter().filter(is_near).count() as u32;
    }
    for LoneBody { body, .. } in lone_bodies {
        body.cloths = cloths.iter().filter(|cloth| pulls(cloth, body.entity)).count() as u32;
    }
}

/// Part of its momentum that a body loses in a tick as it is held by a cloth that does not go on, and by which what it is given
/// changes for good. What is left of a motion shrinks by a third in a tick.
const STOPPED: f32 = 0.5;
const TRIMMED: f32 = 0.25;

/// What cloths have done to a body in a tick.
#[derive(Clone, Copy, Default)]
struct Done {
    /// What they gave it.
    given: Impulse,
    /// What they are expected to give it in the next tick.
    expected: Impulse,
    /// How many took the tick.
    ran: u32,
}

/// Tells bodies what they are to be given in the tick.
pub(crate) fn tell_bodies(
    cloths: Query<(Entity, &ClothSimulation)>,
    mut bodies: Query<(&ColliderMass, &mut BodyImpulse, &mut BodyMemory)>,
    snapshot: Res<TickColliders>,
    fields: Option<Res<Assets<DistanceField>>>,
    time: Res<Time>,
    transforms: TransformHelper,
    mut order: Local<Vec<Entity>>,
) {
    if bodies.is_empty() {
        return;
    }
    order.clear();
    order.extend(cloths.iter().map(|(entity, _)| entity));
    // Floating point sums depend on their order, which must not on that of archetypes.
    order.sort_unstable();
    for (_, mut impulse, mut memory) in &mut bodies {
        // What they were expected to give and do not is taken back.
        let ahead = core::mem::take(&mut memory.ahead);
        let taken = if memory.informed { Impulse::ZERO - ahead } else { Impulse::ZERO };
        impulse.set_if_neq(BodyImpulse { wakes: false, ..taken.into() });
        memory.informed = true;
    }
    for (place, body, centre, key) in snapshot.bodies(fields.as_deref()) {
        let Ok((mass, mut impulse, mut memory)) = bodies.get_mut(body.entity) else {
            continue;
        };
        let dt = time.delta_secs();
        memory.held_by.retain(|held| cloths.contains(held.cloth));
        let memory = &mut *memory;
        let body_now = BodyNow { memory, centre, mass: mass.mass, dt };
        let done = done(cloths.iter_many(order.iter()), place, key, body_now, &transforms);
        if body.mobility.is_some() {
            memory.at_rest = None;
            memory.ahead += done.expected;
            let all = impulse.sum() + done.given + done.expected;
            impulse.set_if_neq(all.into());
        } else {
            memory.informed = false;
            let weight = mass.mass * GRAVITY * dt;
            let wakes = memory.has_changed(done.given, done.ran, weight);
            impulse.set_if_neq(BodyImpulse { wakes, ..default() });
        }
    }
}

/// A body where it is in a tick, and what is remembered of it.
struct BodyNow<'a> {
    memory: &'a mut BodyMemory,
    /// Its centre of mass \[m\].
    centre: Vec3,
    /// \[kg\]
    mass: f32,
    /// Length of the tick \[s\].
    dt: f32,
}

/// Sums up what cloths have done to a collider of a body, by its place and its key.
fn done<'a>(
    cloths: impl Iterator<Item = (Entity, &'a ClothSimulation)>,
    place: usize,
    key: u64,
    mut body: BodyNow<'_>,
    transforms: &TransformHelper,
) -> Done {
    let mut done = Done::default();
    for (entity, cloth) in cloths {
        let turn = |impulse| cloth.frame.impulse_in_world(impulse);
        let expected = cloth.solver.expected_impulse(key);
        if cloth.tick.ran() {
            done.given += turn(cloth.solver.impulse_taken(place));
            done.expected += turn(expected);
            done.ran += 1;
            body.memory.held_by.retain(|held| held.cloth != entity);
        } else if expected == Impulse::ZERO {
            // It does not carry the body, or does so by another collider.
        } else if cloth.is_asleep() {
            // It carries it as before, and wakes as it moves.
            done.given += expected;
            done.expected += expected;
        } else if let Some([given, expected]) =
            body.hold(entity, expected, leads(cloth, transforms))
        {
            done.given += given;
            done.expected += expected;
        }
    }
    body.memory.at = Some(body.centre);
    done
}

/// Where what leads a cloth was before, and is now. A culled one has not followed it since its last tick.
fn leads(cloth: &ClothSimulation, transforms: &TransformHelper) -> [Pose; 2] {
    let attachments = &cloth.held.attachments;
    let pose = attachments.reference().map(|leader| &attachments.anchors[leader].pose);
    let Some((pose, now)) = pose.zip(cloth.leader_now(transforms)) else {
        return [Pose::IDENTITY; 2];
    };
    [if cloth.is_culled() { pose.end() } else { pose.start() }, now]
}

impl BodyNow<'_> {
    /// The impulses in this tick and in the next by a cloth that does not go on, from the one that it gave the body at last. The body is
    /// stopped where it is, seen from what leads the cloth, for as long as it is there: it may have swung. A body that leaves, is thrown
    /// out or is put elsewhere is free. No torque goes on.
    fn hold(&mut self, cloth: Entity, expected: Impulse, leads: [Pose; 2]) -> Option<[Impulse; 2]> {
        let Self { centre, mass, dt, .. } = *self;
        let [before, leader] = leads;
        let held_by = &mut self.memory.held_by;
        let at = held_by.iter().position(|held| held.cloth == cloth).unwrap_or_else(|| {
            let began = to_local(&before, self.memory.at.unwrap_or(centre));
            let at = to_local(&leader, centre);
            held_by.push(Held { cloth, began: Some(began), at, given: expected, trim: Vec3::ZERO });
            held_by.len() - 1
        });
        // One of several cloths stops it: each would else do so.
        let stops = held_by[..at].iter().all(|other| other.began.is_none());
        let held = &mut held_by[at];
        if to_world(&leader, held.began?).distance(centre) > NEAR {
            held.began = None;
            return None;
        }
        let way = centre - to_world(&leader, held.at);
        held.at = to_local(&leader, centre);
        let momentum = if stops { way * (mass / dt) } else { Vec3::ZERO };
        held.trim -= momentum * TRIMMED;
        let linear = expected.linear + held.trim - momentum * STOPPED;
        let given = Impulse { linear, angular: Vec3::ZERO };
        Some([core::mem::replace(&mut held.given, given), given])
    }
}

impl BodyMemory {
    /// Whether cloths do anything else to a body that sleeps than they did when it fell asleep, beside its weight in a tick
    /// \[kg m/s\].
    fn has_changed(&mut self, given: Impulse, ran: u32, weight: f32) -> bool {
        match self.at_rest {
            Some((before, then)) if then == ran => {
                let change = (given.linear - before.linear).length();
                change > UNCHANGED * (before.linear.length() + weight)
            }
            // Another cloth fell asleep, or woke.
            _ => {
                self.at_rest = Some((given, ran));
                false
            }
        }
    }
}
