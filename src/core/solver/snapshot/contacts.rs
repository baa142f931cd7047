//! Contact with colliders, as it is saved: by particle in place of by slot.

use bevy_math::Vec3;

use crate::solver::contact::{ActiveSet, Coupling, EdgeMemory, Freed, Impulse, WarmStart};
use crate::solver::settings::is_near;
use crate::solver::simd::soa::Soa;
use crate::solver::snapshot::{by_particle, by_slot};
use crate::solver::topology::Topology;

/// The normals of the surfaces that particles lay on in the last substep and in the one before, and the velocities of those
/// \[m/s\]; see `contact`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct SavedContacts {
    normals: Vec<Vec3>,
    before: Vec<Vec3>,
    slips: Vec<[f32; 2]>,
    loose: Vec<f32>,
    velocities: Vec<Vec3>,
    holders: Vec<u32>,
    /// Impulses that are expected to press on edges.
    warm: Vec<SavedWarmStart>,
    /// Particles that pass through a collider, which one, and how long yet \[s\].
    freed: Vec<([u32; 2], f32)>,
    /// What measured colliders are owed, of pulls that are carried on, and what is remembered of those that are bodies.
    owed: Vec<Option<(Impulse, Coupling)>>,
}

/// The impulse that a collider is expected to press on an edge with.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct SavedWarmStart {
    collider: u32,
    /// The particles that it acts on, and their parts.
    corners: [u32; 3],
    parts: [f32; 3],
    impulse: Vec3,
}

impl SavedWarmStart {
    fn of(warm: &WarmStart, particle: impl Fn(u32) -> u32) -> Self {
        let WarmStart { collider, corners, parts, impulse } = *warm;
        Self { collider, corners: corners.map(particle), parts, impulse }
    }

    fn with_slots(&self, slot: impl Fn(u32) -> u32) -> WarmStart {
        let Self { collider, corners, parts, impulse } = *self;
        WarmStart { collider, corners: corners.map(slot), parts, impulse }
    }
}

impl SavedContacts {
    /// Takes an active set out, `None` where nothing touches.
    pub fn of(topology: &Topology, contacts: &ActiveSet) -> Option<Self> {
        // What else it has is of one substep.
        let ActiveSet {
            now,
            before,
            next: _,
            // Another world has other colliders; they are told by their places.
            keys: _,
            edges,
            velocity,
            holder,
            pressed: _,
            answering: _,
            unpulled: _,
            dropped: _,
            mended: _,
            impulses,
            lost: _,
            load: _,
        } = contacts;
        let EdgeMemory { warm, next_warm: _, freed, next_freed: _ } = edges;
        let touches = now.any || impulses.are_measured() || !warm.is_empty() || !freed.is_empty();
        if !touches {
            return None;
        }
        let particle = |slot: u32| topology.particle(slot as usize) as u32;
        let values = |values: &[f32]| -> Vec<f32> {
            (0..topology.particle_count()).map(|p| values[topology.slot(p)]).collect()
        };
        let by_particle = |soa: &Soa| by_particle(topology, soa);
        Some(Self {
            normals: by_particle(&now.normal),
            before: by_particle(&before.normal),
            slips: values(&now.slip)
                .into_iter()
                .zip(values(&before.slip))
                .map(Into::into)
                .collect(),
            loose: values(&now.loose),
            velocities: by_particle(velocity),
            holders: values(holder).into_iter().map(|holder| holder as u32).collect(),
            warm: warm.iter().map(|warm| SavedWarmStart::of(warm, particle)).collect(),
            freed: freed.iter().map(|it| ([particle(it.slot), it.collider], it.left)).collect(),
            owed: impulses.kept(),
        })
    }

    /// Puts it back into an active set that is empty.
    pub fn put_back(&self, topology: &Topology, set: &mut ActiveSet) {
        let Self { normals, before, slips, loose, velocities, holders, warm, freed, owed } = self;
        let by_slot = |vectors: &[Vec3]| by_slot(topology, vectors);
        set.impulses.put_back(owed);
        (set.now.normal, set.before.normal) = (by_slot(normals), by_slot(before));
        set.velocity = by_slot(velocities);
        for particle in 0..topology.particle_count() {
            let slot = topology.slot(particle);
            set.holder[slot] = holders[particle] as f32;
            [set.now.slip[slot], set.before.slip[slot]] = slips[particle];
            set.now.loose[slot] = loose[particle];
        }
        let slot = |particle: u32| topology.slot(particle as usize) as u32;
        let edges = &mut set.edges;
        edges.warm = warm.iter().map(|warm| warm.with_slots(slot)).collect();
        edges.warm.sort_unstable_by_key(WarmStart::key);
        let freed_at = |&([particle, collider], left): &([u32; 2], f32)| {
            let slot = slot(particle);
            Freed { slot, collider, left }
        };
        edges.freed = freed.iter().map(freed_at).collect();
        edges.freed.sort_unstable_by_key(Freed::key);
        set.now.find();
        set.before.find();
    }

    /// Whether a cloth of so many particles may have been in such contact.
    pub fn is_good(&self, particles: usize) -> bool {
        let Self { normals, before, slips, loose, velocities, holders, warm, freed, owed } = self;
        let is_normal = |n: &Vec3| *n == Vec3::ZERO || (n.is_finite() && n.length() < 1.001);
        [normals, before]
            .iter()
            .all(|normals| normals.len() == particles && normals.iter().all(is_normal))
            && [slips.len(), loose.len(), velocities.len(), holders.len()] == [particles; 4]
            && loose.iter().all(|loose| (0.0..=1.0).contains(loose))
            && slips.iter().flatten().all(|slip| *slip > 0.0 && *slip <= 1.0)
            && velocities.iter().all(|velocity| is_near(*velocity))
            && warm.iter().all(|warm| {
                warm.corners.iter().all(|&corner| (corner as usize) < particles)
                    && warm.parts.iter().all(|part| (0.0..=1.0).contains(part))
                    && is_near(warm.impulse)
            })
            && freed
                .iter()
                .all(|&([particle, _], left)| (particle as usize) < particles && left.is_finite())
            && owed.iter().flatten().all(|(owed, coupling)| {
                let Coupling { expected, ahead } = coupling;
                let all = [owed.linear, owed.angular, expected.linear, expected.angular];
                all.into_iter().all(is_near) && ahead.is_valid()
            })
    }
}
