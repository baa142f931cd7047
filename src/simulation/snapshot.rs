//! The full state of a running cloth, taken out and put back: for saved games, checkpoints and rewinding.

use bevy::ecs::entity::{EntityMapper, MapEntities};
use bevy::prelude::*;

use crate::cloth::pins::ClothPins;
use crate::error::ClothErrorKind;
use crate::error::failures::{Blame, Failures};
use crate::mesh::rest_cache::RestCache;
use crate::simulation::ClothSimulation;
use crate::simulation::holding::Holding;
use crate::simulation::in_force::InForce;
use crate::simulation::progress::Progress;
use crate::simulation::pushing::Pushing;
use crate::simulation::reference_frame::ReferenceFrame;
use crate::simulation::resizing::{follow_scale, in_size, other_scale};
use crate::simulation::skin::SkinState;
use crate::simulation::sleeping::SleepState;
use crate::simulation::tick_state::TickState;
use crate::solver::{ClothSolver, Pose, SolverState, StateError};

/// All that a running cloth's later ticks depend on, besides the components beside it: with these and this, a
/// scene saved in mid-fall goes on with the same bits.
///
/// It is taken by [`ClothSnapshot::of`] or [`ClothSimulation::save`], between ticks. Put on an entity with a
/// [`Cloth`](crate::Cloth), it is taken over as soon as the cloth is set up, or at once by one that runs, and
/// is gone then. One that is another cloth's, or damaged, is told as a [`ClothErrorKind::Snapshot`], and the cloth
/// stays as it was.
///
/// Colliders that move have a state as well, [`SdfColliderSnapshot`](crate::SdfColliderSnapshot), without which the first
/// tick does not know where they came from, and wakes what sleeps near them. Colliders are met in the order of
/// their entities, so that those of a loaded scene are to be spawned in that order. Time, wind and gravity are
/// the game's. Anchors are entities: in another world, map them ([`MapEntities`]; Bevy's scenes do).
///
/// A cloth that was saved in another scale than its entity has now takes that of its entity.
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
    pins: ClothPins,
    placed: Pose,
    held: Holding,
    skin: Option<SkinState>,
    frame: ReferenceFrame,
    /// It was culled, and goes on where its leader is.
    returns: bool,
    pushing: Pushing,
    sleep: SleepState,
    progress: Progress,
    /// Length of the last tick, and whether the cloth took it.
    tick: (f32, bool),
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
        self.content.progress.tick_count
    }
}

impl MapEntities for ClothSnapshot {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.content.held.attachments.map_entities(mapper);
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
            // The others are components, or follow from the mesh.
            in_force: InForce { pins, placed, .. },
            // What it is hung by is looked at before its first tick alone, and then anew.
            start: _,
            held,
            skin,
            frame,
            pushing,
            // Whether it is seen is not saved. That it was culled is: it goes on from where its leader was then.
            culling,
            lod: _,
            sleep,
            // Between ticks there is no result.
            tick: TickState { step, .. },
            progress,
            // This is about what is shown.
            shape_version: _,
        } = self;
        let content = Content {
            solver: solver.save(),
            pins: pins.clone(),
            placed: *placed,
            held: held.clone(),
            skin: skin.as_ref().map(|skin| skin.state.clone()),
            frame: ReferenceFrame {
                teleport_asked: frame.teleport_asked || culling.has_culled(),
                ..frame.clone()
            },
            returns: culling.has_culled(),
            pushing: pushing.clone(),
            sleep: sleep.clone(),
            progress: progress.clone(),
            tick: (step.dt, step.runs),
        };
        ClothSnapshot { content: Box::new(content) }
    }

    /// Takes over a state, with a solver that fits it.
    fn take_over(&mut self, entity: Entity, state: Content, solver: ClothSolver) {
        let Content {
            solver: _,
            pins,
            placed,
            mut held,
            skin,
            frame,
            returns,
            pushing,
            sleep,
            progress,
            tick,
        } = state;
        self.culling.returns = returns;
        if let (Some(worn), Some(skin)) = (&mut self.skin, skin) {
            worn.restore(skin);
        }
        held.attachments.move_to(entity);
        // Room for every motion now, so that no tick needs any.
        self.tick.motions.pins.clear();
        self.tick.motions.pins.reserve_exact(solver.pins().len() + solver.soft_pins().len());
        (self.tick.step.dt, self.tick.step.runs) = tick;
        (self.in_force.pins, self.in_force.placed) = (pins, placed);
        (self.solver, self.held, self.frame) = (solver, held, frame);
        (self.pushing, self.sleep, self.progress) = (pushing, sleep, progress);
        self.shape_version += 1;
    }
}

impl Content {
    /// Checks what the solver does not know of.
    fn check(&self, cloth: &ClothSimulation) -> Result<(), StateError> {
        let good = |ok: bool, what| if ok { Ok(()) } else { Err(StateError::Damaged(what)) };
        let count = self.solver.particle_count();
        let Holding { attachments, grab } = &self.held;
        good(attachments.is_sound(count), "attachments")?;
        good(grab.as_ref().is_none_or(|grab| grab.is_sound(count)), "grab")?;
        let (hard, soft) = self.solver.held();
        let skin_is_sound = match (&self.skin, &cloth.skin) {
            (Some(state), Some(skin)) => state.is_sound(count, skin.skeleton.joints.len()),
            (state, skin) => state.is_none() && skin.is_none(),
        };
        good(skin_is_sound, "skin")?;
        let mut attached: Vec<_> = attachments.attached.iter().map(|at| at.particle).collect();
        attached.extend(self.skin.iter().flat_map(|skin| &skin.held));
        attached.sort_unstable();
        good(attached == hard, "pins")?;
        let mut pulled: Vec<u32> = attachments.pulled().collect();
        pulled.extend(grab.iter().flat_map(|grab| grab.ways()).map(|(particle, ..)| particle));
        pulled.sort_unstable();
        good(soft.eq(pulled), "soft pins")?;
        good(self.frame.ride.is_none_or(|ride| ride.is_valid()), "ride")?;
        good(self.sleep.is_sound(), "rest")?;
        good(self.placed.is_valid(), "pose")?;
        good(self.progress.tick_count <= u64::MAX / 2, "count of ticks")?;
        good((0.0..=1.0).contains(&self.tick.0), "tick")
    }
}

/// Puts states back, where cloths are set up by now.
pub(crate) fn restore_cloths(
    mut cloths: Query<(Entity, &ClothSnapshot, &mut ClothSimulation)>,
    transforms: TransformHelper,
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
                if let Some(scale) = other_scale(entity, &cloth, &transforms) {
                    follow_scale(entity, &mut cloth, scale, &transforms, &mut cache, &mut failures);
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
) -> Result<(), ClothErrorKind> {
    let damaged = ClothErrorKind::Snapshot;
    let (expected, got) = (cloth.particle_count(), state.solver.particle_count());
    if expected != got {
        return Err(damaged(StateError::WrongParticleCount { expected, got }));
    }
    state.check(cloth).map_err(damaged)?;
    let mut solver = if state.placed.scale == cloth.in_force.placed.scale {
        cloth.solver.clone()
    } else {
        let mut solver = in_size(cloth, state.placed.scale, cache)?;
        let larger = state.placed.scale / cloth.in_force.placed.scale;
        let limits = cloth.solver.skin().into_iter().flatten().map(|limit| limit.scaled(larger));
        let limits: Vec<_> = limits.collect();
        let _ = solver.set_skin((!limits.is_empty()).then_some(&limits));
        solver
    };
    solver.restore(&state.solver).map_err(damaged)?;
    cloth.take_over(entity, state.clone(), solver);
    Ok(())
}
