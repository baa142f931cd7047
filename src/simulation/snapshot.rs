//! The full state of a running cloth, taken out and put back: for saved games, checkpoints and rewinding.

use bevy::ecs::entity::{EntityMapper, MapEntities};
use bevy::prelude::*;

use crate::cloth::pins::ClothPins;
use crate::cloth::teleport::{ClothInertia, ClothTeleport};
use crate::error::ClothError;
use crate::error::failures::{Blame, Failures};
use crate::mesh::rest_cache::RestCache;
use crate::simulation::ClothSimulation;
use crate::simulation::attachments::Attachments;
use crate::simulation::grabbing::Grabbed;
use crate::simulation::pushing::Pushing;
use crate::simulation::reference_frame::Following;
use crate::simulation::setup::topology;
use crate::simulation::sleeping::Rest;
use crate::solver::{ClothSolver, Pose, RigidMotion, SolverState, StateError, TickReport};

/// All that a running cloth's later ticks depend on, besides the components beside it: with these and this, a
/// scene saved in mid-fall goes on with the same bits.
///
/// It is taken by [`ClothSnapshot::of`] or [`ClothSimulation::save`], between ticks. Put on an entity with a
/// [`Cloth`](crate::Cloth), it is taken over as soon as the cloth is set up, or at once by one that runs, and
/// is gone then. One that is another cloth's, or damaged, is told as a [`ClothError::Snapshot`], and the cloth
/// stays as it was.
///
/// Colliders that move have a state as well, [`SdfColliderSnapshot`](crate::SdfColliderSnapshot), without which the first
/// tick does not know where they came from, and wakes what sleeps near them. Colliders are met in the order of
/// their entities, so that those of a loaded scene are to be spawned in that order. Time, wind and gravity are
/// the game's. Anchors are entities: in another world, map them ([`MapEntities`]; Bevy's scenes do).
///
/// A cloth that is still being hung in the background is hung anew where its state is put back.
///
/// With the feature `serialize` it is read and written by serde, in a form that has a version.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # use bevy_drape::ClothSnapshot;
/// fn rewind(cloth: Single<(Entity, &ClothSimulation)>, mut commands: Commands, mut saved: Local<Option<ClothSnapshot>>) {
///     match saved.take() {
///         None => *saved = Some(cloth.1.save()),
///         Some(state) => {
///             commands.entity(cloth.0).insert(state);
///         }
///     }
/// }
/// # bevy::ecs::system::assert_is_system(rewind);
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(opaque, Component, Debug, PartialEq, Clone)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
#[component(map_entities)]
pub struct ClothSnapshot {
    content: Box<Content>,
}

#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct Content {
    solver: SolverState,
    attachments: Attachments,
    following: Followed,
    rest: Rest,
    grab: Option<Grabbed>,
    pushing: Pushing,
    pins: ClothPins,
    placed: Pose,
    /// Length of the last tick, and whether the cloth took it.
    tick: (f32, bool),
    last_tick: Option<TickReport>,
    tick_count: u64,
    quarantined: bool,
}

/// The part of [`Following`] that lasts from tick to tick.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct Followed {
    teleport: ClothTeleport,
    inertia: ClothInertia,
    teleport_asked: bool,
    reset_asked: bool,
    jumped: bool,
    ride: Option<RigidMotion>,
}

impl ClothSnapshot {
    /// The state of the cloth that runs on an entity.
    pub fn of(cloth: EntityRef) -> Option<Self> {
        cloth.get::<ClothSimulation>().map(ClothSimulation::save)
    }

    /// Particles of the cloth that it was taken from.
    pub fn particle_count(&self) -> usize {
        self.content.solver.particle_count()
    }

    /// Ticks that it had taken by then.
    pub fn tick_count(&self) -> u64 {
        self.content.tick_count
    }
}

impl MapEntities for ClothSnapshot {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.content.attachments.map_entities(mapper);
        self.content.pins.map_entities(mapper);
    }
}

#[cfg(feature = "serialize")]
crate::serialize::versioned!(ClothSnapshot, content: Box<Content>);

impl ClothSimulation {
    /// All that its later ticks depend on. See [`ClothSnapshot`].
    pub fn save(&self) -> ClothSnapshot {
        let Self {
            solver,
            attachments,
            following,
            rest,
            grab,
            pushing,
            // What it is hung by is looked at before its first tick alone, and then anew.
            hanging: _,
            // These are components, or follow from the mesh.
            shape: _,
            material: _,
            settings: _,
            rest_shape: _,
            weights: _,
            pins,
            placed,
            step,
            last_tick,
            tick_count,
            quarantined,
            // Between ticks there is none.
            outcome: _,
            // These are about what is shown and told.
            told_ready: _,
            shape_version: _,
        } = self;
        let Following { teleport, inertia, teleport_asked, reset_asked, jumped, ride, room: _ } =
            following;
        let content = Content {
            solver: solver.save(),
            attachments: attachments.kept(),
            following: Followed {
                teleport: *teleport,
                inertia: *inertia,
                teleport_asked: *teleport_asked,
                reset_asked: *reset_asked,
                jumped: *jumped,
                ride: *ride,
            },
            rest: rest.clone(),
            grab: grab.as_deref().cloned(),
            pushing: pushing.clone(),
            pins: pins.clone(),
            placed: *placed,
            tick: (step.dt, step.runs),
            last_tick: *last_tick,
            tick_count: *tick_count,
            quarantined: *quarantined,
        };
        ClothSnapshot { content: Box::new(content) }
    }

    /// Takes over a state, with a solver that fits it.
    fn take_over(&mut self, entity: Entity, state: Content, solver: ClothSolver) {
        let Content {
            solver: _,
            mut attachments,
            following,
            rest,
            grab,
            pushing,
            pins,
            placed,
            tick,
            last_tick,
            tick_count,
            quarantined,
        } = state;
        let Followed { teleport, inertia, teleport_asked, reset_asked, jumped, ride } = following;
        attachments.move_to(entity);
        // Room for every motion now, so that no tick needs any.
        attachments.motions.reserve_exact(solver.pins().len() + solver.soft_pins().len());
        self.solver = solver;
        self.attachments = attachments;
        let room = core::mem::take(&mut self.following.room);
        self.following =
            Following { teleport, inertia, teleport_asked, reset_asked, jumped, ride, room };
        self.rest = rest;
        self.grab = grab.map(Box::new);
        self.pushing = pushing;
        self.pins = pins;
        self.placed = placed;
        (self.step.dt, self.step.runs) = tick;
        self.last_tick = last_tick;
        self.tick_count = tick_count;
        self.quarantined = quarantined;
        self.shape_version += 1;
    }
}

impl Content {
    /// Checks what the solver does not know of.
    fn check(&self) -> Result<(), StateError> {
        let good = |ok: bool, what| if ok { Ok(()) } else { Err(StateError::Damaged(what)) };
        let count = self.solver.particle_count();
        good(self.attachments.is_sound(count), "attachments")?;
        good(self.grab.as_ref().is_none_or(|grab| grab.is_sound(count)), "grab")?;
        let (hard, soft) = self.solver.held();
        let attached = self.attachments.attached.iter().map(|at| at.particle);
        good(attached.eq(hard.iter().copied()), "pins")?;
        let mut pulled: Vec<u32> = self.attachments.pulled().collect();
        pulled.extend(self.grab.iter().flat_map(Grabbed::ways).map(|(particle, ..)| particle));
        pulled.sort_unstable();
        good(soft.eq(pulled), "soft pins")?;
        good(self.following.ride.is_none_or(|ride| ride.is_valid()), "ride")?;
        good(self.rest.is_sound(), "rest")?;
        good(self.placed.is_valid(), "pose")?;
        good(self.tick_count <= u64::MAX / 2, "count of ticks")?;
        good((0.0..=1.0).contains(&self.tick.0), "tick")
    }
}

/// Puts states back, where cloths are set up by now.
pub(crate) fn restore_cloths(
    mut cloths: Query<(Entity, &ClothSnapshot, &mut ClothSimulation)>,
    mut cache: ResMut<RestCache>,
    mut commands: Commands,
    mut failures: Failures,
) {
    for (entity, state, mut cloth) in &mut cloths {
        commands.entity(entity).try_remove::<ClothSnapshot>();
        match restore(entity, &mut cloth, &state.content, &mut cache) {
            Ok(()) => {
                for blame in [Blame::Snapshot, Blame::Motion] {
                    failures.clear(entity, blame);
                }
            }
            Err(error) => failures.report(entity, error),
        }
    }
}

fn restore(
    entity: Entity,
    cloth: &mut ClothSimulation,
    state: &Content,
    cache: &mut RestCache,
) -> Result<(), ClothError> {
    let damaged = |problem| ClothError::Snapshot { entity, problem };
    let (expected, got) = (cloth.particle_count(), state.solver.particle_count());
    if expected != got {
        return Err(damaged(StateError::WrongParticleCount { expected, got }));
    }
    state.check().map_err(damaged)?;
    let mut solver = if state.placed.scale == cloth.placed.scale {
        cloth.solver.clone()
    } else {
        scaled(entity, cloth, state.placed.scale, cache)?
    };
    solver.restore(&state.solver).map_err(damaged)?;
    cloth.take_over(entity, state.clone(), solver);
    Ok(())
}

/// The cloth as its entity's scale was when it was set up: it has that size for good.
fn scaled(
    entity: Entity,
    cloth: &ClothSimulation,
    scale: f32,
    cache: &mut RestCache,
) -> Result<ClothSolver, ClothError> {
    let (shape, masses, weights) =
        (&cloth.rest_shape, cloth.settings.masses, cloth.weights.as_ref());
    let topology = topology(entity, shape, scale, masses, weights, cache)?;
    let start = topology.rest_positions().to_vec();
    let made = ClothSolver::new(topology, &start, cloth.material.into(), cloth.settings.into());
    made.map_err(|problem| ClothError::Snapshot { entity, problem: problem.into() })
}
