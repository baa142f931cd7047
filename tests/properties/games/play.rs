//! Does what a script says.

use bevy::{
    ecs::world::EntityWorldMut, mesh::VertexAttributeValues, prelude::*, time::TimeUpdateStrategy,
};
use bevy_drape::{
    ClothAir, ClothBody, ClothComponent, ClothCulling, ClothErrorKind, ClothExecution, ClothForces,
    ClothGrab, ClothGravityOverride, ClothInterpolation, ClothLod, ClothProxy, ClothSkin,
    ClothSleepThreshold, ClothWeights, ClothWindOverride, ColliderBody, ColliderImpulse,
    ColliderMass, SdfColliderDisabled, prelude::*,
};
use proptest::{prelude::*, test_runner::TestCaseResult};

use super::script::{Deed, MeshKind, Part, SLOTS, Slot};
use crate::support::app::{self, add_mesh, bits, grid_mesh};

/// An app, the entities that a script knows of, and a cloth far away.
pub struct Game {
    app: App,
    entities: [Option<Entity>; SLOTS],
    witness: Entity,
    /// Frames for which an entity was a cloth that neither runs nor says why.
    silent: [u32; SLOTS],
}

/// Whether a cloth is told why it does not run.
fn is_about_set_up(failure: &ClothFailure) -> bool {
    failure.errors().any(|error| match &error.kind {
        ClothErrorKind::Parameter { component, .. } => {
            matches!(component, ClothComponent::ClothMaterial | ClothComponent::ClothSettings)
        }
        kind => matches!(
            kind,
            ClothErrorKind::Mesh(_)
                | ClothErrorKind::Shape(_)
                | ClothErrorKind::Graph(_)
                | ClothErrorKind::Proxy(_)
                | ClothErrorKind::Weights(_)
                | ClothErrorKind::Skin(_)
                | ClothErrorKind::Scale(_)
                | ClothErrorKind::NoTransform
                | ClothErrorKind::Solver(_)
                | ClothErrorKind::Draw(_)
        ),
    })
}

fn take<T: Component>(entity: &mut EntityWorldMut<'_>) {
    entity.remove::<T>();
}

impl MeshKind {
    fn mesh(self) -> Mesh {
        match self {
            Self::Grid(rows, columns) => {
                grid_mesh(rows, columns, |v| v, |r, c| Vec3::new(c as f32, 0.0, r as f32) * 0.15)
            }
            Self::Holed => app::holed_mesh(),
            Self::Box => app::box_mesh(0.4),
            Self::Looped => app::looped_mesh(),
            Self::Nothing => app::triangle_mesh(Vec::new(), Vec::new()),
        }
    }
}

impl Game {
    pub fn new() -> Self {
        let mut app = app::app();
        let place = Vec3::new(0.0, 2000.0, 0.0);
        let ball = (SdfCollider::new(Sphere::new(0.3)), Transform::from_translation(place));
        app.world_mut().spawn(ball);
        let cloth = (app::sheet(), Transform::from_translation(place + Vec3::new(0.1, 0.4, 0.0)));
        let witness = app.world_mut().spawn(cloth).id();
        Self { app, entities: [None; SLOTS], witness, silent: [0; SLOTS] }
    }

    pub fn frame(&mut self, ticks: u32) {
        self.app.insert_resource(TimeUpdateStrategy::FixedTimesteps(ticks));
        self.app.update();
    }

    pub fn witness_bits(&self) -> Vec<[u32; 3]> {
        match self.app.world().get::<ClothSimulation>(self.witness) {
            Some(_) => bits(&self.app, self.witness),
            None => Vec::new(),
        }
    }

    pub fn stage(&mut self) {
        self.app.insert_resource(ClothExecution::Staged);
    }

    /// Where all cloths of the script are.
    pub fn all_bits(&self) -> Vec<Option<Vec<[u32; 3]>>> {
        let runs = |entity: &Entity| self.app.world().get::<ClothSimulation>(*entity).is_some();
        let bits = |entity: &Option<Entity>| entity.filter(runs).map(|it| bits(&self.app, it));
        self.entities.iter().map(bits).collect()
    }

    pub fn do_all(&mut self, deeds: &[Deed]) {
        for deed in deeds {
            self.act(deed);
        }
    }

    fn entity(&mut self, slot: Slot) -> Option<EntityWorldMut<'_>> {
        let entity = self.entities[slot]?;
        self.app.world_mut().get_entity_mut(entity).ok()
    }

    fn act(&mut self, deed: &Deed) {
        match deed {
            Deed::Spawn(slot, at, parts) => {
                self.act(&Deed::Despawn(*slot));
                let place = Transform::from_translation(*at);
                self.entities[*slot] = Some(self.app.world_mut().spawn(place).id());
                for part in parts {
                    self.insert(*slot, part);
                }
            }
            Deed::Despawn(slot) => {
                if let Some(entity) = self.entity(*slot) {
                    entity.despawn();
                }
            }
            Deed::Insert(slot, part) => self.insert(*slot, part),
            Deed::Remove(slot, which) => drop(self.remove(*slot, *which)),
            Deed::Move(slot, by, turn) => {
                if let Some(mut transform) = self.transform(*slot) {
                    transform.translation += *by;
                    transform.rotation = *turn;
                }
            }
            Deed::Scale(slot, scale) => {
                if let Some(mut transform) = self.transform(*slot) {
                    transform.scale = *scale;
                }
            }
            Deed::Child(child, parent) => {
                // No circles.
                if parent < child
                    && let Some(parent) = self.entity(*parent).map(|it| it.id())
                    && let Some(mut child) = self.entity(*child)
                {
                    child.insert(ChildOf(parent));
                }
            }
            Deed::Orphan(slot) => {
                if let Some(mut entity) = self.entity(*slot) {
                    entity.remove::<ChildOf>();
                }
            }
            Deed::Push(slot, on, with) => {
                self.trigger(*slot, |entity| PushCloth { entity, on: *on, with: *with });
            }
            Deed::Teleport(slot) => self.trigger(*slot, |entity| TeleportCloth { entity }),
            Deed::Reset(slot) => self.trigger(*slot, |entity| ResetCloth { entity }),
            Deed::Wake(slot) => {
                if let Some(mut entity) = self.entity(*slot)
                    && let Some(mut cloth) = entity.get_mut::<ClothSimulation>()
                {
                    cloth.wake();
                }
            }
            Deed::Restore(from, to) => {
                let saved = self
                    .entity(*from)
                    .and_then(|it| it.get::<ClothSimulation>().map(ClothSimulation::save));
                if let (Some(saved), Some(mut entity)) = (saved, self.entity(*to)) {
                    entity.insert(saved);
                }
            }
            Deed::Remake(slot, kind) => {
                if let Some(handle) = self.handle(*slot) {
                    let mut meshes = self.app.world_mut().resource_mut::<Assets<Mesh>>();
                    if meshes.contains(&handle) {
                        let _ = meshes.insert(&handle, kind.mesh());
                    }
                }
            }
            Deed::DropMesh(slot) => {
                if let Some(handle) = self.handle(*slot) {
                    self.app.world_mut().resource_mut::<Assets<Mesh>>().remove(&handle);
                }
            }
        }
        // Nothing of a script stands in for what is gone.
        let world = self.app.world();
        for entity in &mut self.entities {
            *entity = entity.filter(|it| world.get_entity(*it).is_ok());
        }
    }

    fn trigger<E>(&mut self, slot: Slot, event: impl FnOnce(Entity) -> E)
    where
        for<'a> E: Event<Trigger<'a>: Default>,
    {
        if let Some(entity) = self.entities[slot] {
            self.app.world_mut().trigger(event(entity));
        }
    }

    fn transform(&mut self, slot: Slot) -> Option<Mut<'_, Transform>> {
        let entity = self.entities[slot]?;
        self.app.world_mut().get_mut(entity)
    }

    fn handle(&mut self, slot: Slot) -> Option<Handle<Mesh>> {
        self.entity(slot)?.get::<Mesh3d>().map(|mesh| mesh.0.clone())
    }

    fn insert(&mut self, slot: Slot, part: &Part) {
        let other = |slot: &Slot| self.entities[*slot];
        let anchor = match part {
            Part::Pins(_, Some(anchor)) | Part::BodyOf(anchor) => other(anchor),
            _ => None,
        };
        let mesh = match part {
            Part::Mesh(kind) => Some(add_mesh(&mut self.app, kind.mesh())),
            _ => None,
        };
        let Some(mut entity) = self.entity(slot) else { return };
        macro_rules! insert {
            ($($as_it_is:ident)*) => {
                match part {
                    $(Part::$as_it_is(it) => entity.insert(it.clone()),)*
                    Part::Mesh(_) => entity.insert(Mesh3d(mesh.unwrap_or_default())),
                    Part::Pins(pins, _) => entity.insert(match anchor {
                        Some(anchor) => pins.clone().anchored_to(anchor),
                        None => pins.clone(),
                    }),
                    Part::BodyOf(_) => match anchor {
                        Some(body) => entity.insert(ColliderBody(body)),
                        None => &mut entity,
                    },
                }
            };
        }
        insert!(
            Cloth Material Settings Weights Air SelfCollision InterCollision Lod Proxy Paused Sleep Forces Grab Inertia Teleport
            Culling Interpolation Skin Body Gravity Wind Zone Collider Disabled Mass Impulse Hang
        );
    }

    /// Takes what runs off all entities. It runs again, or says why not.
    pub fn start_anew(&mut self) -> TestCaseResult {
        for slot in 0..SLOTS {
            if let Some(mut entity) = self.entity(slot) {
                entity.remove::<ClothSimulation>();
            }
        }
        (0..4).try_for_each(|_| {
            self.frame(1);
            self.check()
        })
    }

    /// Takes everything of a script off its entities, and makes each a sheet at the origin. All run within some frames, and nothing is
    /// wrong with them any more.
    pub fn heal(&mut self) -> TestCaseResult {
        for slot in 0..SLOTS {
            while self.remove(slot, 0) {}
            if let Some(mut entity) = self.entity(slot) {
                entity.insert((app::sheet(), Transform::default()));
            }
        }
        (0..3).for_each(|_| self.frame(1));
        for slot in 0..SLOTS {
            let Some(entity) = self.entities[slot] else { continue };
            let failure = app::failure(&self.app, entity);
            prop_assert!(failure.is_none(), "{slot} is told of {failure:?}");
            let cloth = self.app.world().get::<ClothSimulation>(entity);
            let falls = cloth.is_some_and(|it| it.positions().all(|place| place.y < 0.0));
            prop_assert!(falls, "{slot} does not run");
        }
        Ok(())
    }

    /// Takes the component of this number off an entity, of those that it has. Returns whether there was one.
    fn remove(&mut self, slot: Slot, which: usize) -> bool {
        let Some(mut entity) = self.entity(slot) else { return false };
        macro_rules! parts {
            ($($part:ty),*) => {
                [$((entity.contains::<$part>(), take::<$part> as fn(&mut EntityWorldMut<'_>))),*]
            };
        }
        let parts = parts!(
            Cloth,
            ClothSimulation,
            ClothMaterial,
            ClothSettings,
            ClothPins,
            ClothWeights,
            ClothAir,
            ClothSelfCollision,
            ClothInterCollision,
            ClothLod,
            ClothProxy,
            ClothPaused,
            ClothSleepThreshold,
            ClothForces,
            ClothGrab,
            ClothInertia,
            ClothTeleport,
            ClothCulling,
            ClothInterpolation,
            ClothSkin,
            ClothBody,
            ClothGravityOverride,
            ClothWindOverride,
            WindZone,
            SdfCollider,
            SdfColliderDisabled,
            ColliderMass,
            ColliderBody,
            ColliderImpulse,
            HangOnStart,
            Mesh3d,
            Transform,
            ChildOf,
            ClothSnapshot
        );
        let Some((_, take)) = parts.into_iter().filter(|(is_there, _)| *is_there).nth(which) else {
            return false;
        };
        take(&mut entity);
        true
    }

    /// Looks that what runs and what is drawn is a number, and that what does not run says why.
    pub fn check(&mut self) -> TestCaseResult {
        for slot in 0..SLOTS {
            let Some(entity) = self.entities[slot] else {
                self.silent[slot] = 0;
                continue;
            };
            let entity = self.app.world().entity(entity);
            let has_mesh = entity
                .get::<Mesh3d>()
                .is_some_and(|it| self.app.world().resource::<Assets<Mesh>>().contains(&it.0));
            if let Some(cloth) = entity.get::<ClothSimulation>() {
                let count = cloth.particle_count();
                for i in 0..count {
                    let (place, velocity) = (cloth.position(i), cloth.velocity(i));
                    prop_assert!(place.is_some_and(Vec3::is_finite), "place {i} of {slot}");
                    prop_assert!(velocity.is_some_and(Vec3::is_finite), "velocity {i} of {slot}");
                }
            }
            let waits = matches!(entity.get::<Cloth>(), Some(it) if it.shape == Cloth::of_mesh3d().shape && !has_mesh);
            let is_silent = entity.contains::<Cloth>()
                && !waits
                && !entity.contains::<ClothSimulation>()
                && !entity.get::<ClothFailure>().is_some_and(is_about_set_up);
            self.silent[slot] = if is_silent { self.silent[slot] + 1 } else { 0 };
            prop_assert!(self.silent[slot] < 3, "{slot} neither runs nor says why");
            if let Some(impulse) = entity.get::<ColliderImpulse>() {
                prop_assert!(impulse.linear.is_finite() && impulse.angular.is_finite());
            }
            let mesh = entity.get::<Mesh3d>().filter(|_| entity.contains::<ClothSimulation>());
            let mesh = mesh.and_then(|it| self.app.world().resource::<Assets<Mesh>>().get(&it.0));
            if let Some(VertexAttributeValues::Float32x3(places)) =
                mesh.and_then(|it| it.attribute(Mesh::ATTRIBUTE_POSITION))
            {
                let is_finite = places.iter().flatten().all(|it| it.is_finite());
                prop_assert!(is_finite, "the drawn mesh of {slot}");
            }
        }
        Ok(())
    }
}
