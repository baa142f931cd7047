//! The whole data flow on one page.
//!
//! The simulation itself is in `core`, a crate of its own without an ECS. The plugin brings it into Bevy.
//!
//! # Rooms
//!
//! Each knows only the ones above it in this table. A test keeps it so (`tests/architecture.rs`).
//!
//! | room | what it holds |
//! | --- | --- |
//! | `serialize` | entities and versioned states through serde |
//! | `error` | [`ClothError`](crate::ClothError), what can be wrong, and who is told |
//! | `pose` | poses of entities, now and through a tick |
//! | `schedule` | the sets and the schedule that cloths are stepped in |
//! | `mesh` | the rest mesh in: read, welded, made a grid or triangles, shared |
//! | `cloth` | the components and events of a cloth, and nothing that runs |
//! | `collider` | the components of colliders and bodies, their shapes and fields, and where they are in a tick |
//! | `simulation` | the running cloth: set-up, changes, pins, anchors, grabs, pushes, hanging, sleep, levels of detail, snapshots |
//! | `wind` | the wind of a tick, and its zones |
//! | `step` | one tick: gather, solve fused or staged, finish |
//! | `drawing` | writes a cloth's mesh, once a frame |
//! | `plugin` | what runs when |
//! | `engines` | the colliders of physics engines, made colliders of cloths |
//! | `diagnostics` | measurements, where they are asked for |
//! | `proximity` | what of a cloth is near a collider, for those below |
//! | `gizmos` | debug drawing |
//! | `panel` | a tuning panel |
//! | `picking` | cloths that the mouse pulls at |
//!
//! # Where does something new go?
//!
//! | new | goes to | and |
//! | --- | --- | --- |
//! | a force of a game's own | nowhere: `ClothForces`, `PushCloth`, or a system between two stages of [`ClothSubstep`] | |
//! | a force | `core/solver/forces`: see *A new force* in `core/solver/mod.rs` | a component in `cloth`, like `ClothAir`, handed on in `Gather`, like `wind::gather_air`: what could move a cloth wakes it (`cloth.sleep.disturb()`) |
//! | a constraint | `core/solver/constraints`: see *A new constraint* in `core/solver/mod.rs` | a setting that switches it, or a number of the material |
//! | a solid of a game's own | nowhere: `SdfShape::Custom` takes any [`SignedDistance`](crate::sdf::SignedDistance) | |
//! | a collider shape | `core/sdf/shapes`, with its truth in `tests/sdf/shapes.rs`; `collider/shape.rs` (a variant, `get`, `From`) | `collider/check.rs`, `core/serialize.rs`; for speed a `KnownShape` in `core/sdf`, and `nearest_on_segments` where it can be computed; a distance that is no more than a bound overrides `overestimate` of [`SignedDistance`](crate::sdf::SignedDistance) |
//! | a physics engine | `engines`: a file like `avian.rs`, which says what `engines/engine.rs` asks | a feature; its tests beside `tests/avian`; a shape of parry's that is new: `engines/read.rs` |
//! | a setting, a number of the material | `core/solver/settings.rs` (the number, its range), `cloth/settings.rs` or `cloth/material.rs` (what it means to a user) | a slider in `panel/view.rs`, a line in `guide/settings.md`; `core/solver/plan` if substeps depend on it; one that changes what is set up once is in `core/solver/setup.rs` (`new`, `remade`) as well |
//! | a setting by quality | `cloth/quality.rs` | read off the report, in `tests/ecs/quality.rs` |
//! | a component of a cloth | its file in `cloth`; its system in `simulation` (of the air, in `wind`), or a term in the query of one that is there; `register_type` and the system in `build` below, `lib.rs` | what it remembers: a field of `simulation/mod.rs` or of a part of it, set up in `simulation/setup.rs`, saved in `simulation/snapshot.rs`; numbers that are out of range: `ClothComponent` in `error/mod.rs` |
//! | a component of a collider or a wind zone | component and system together, in `collider` or `wind`, like `SdfCollider`, `BakeSdf` and `WindZone`; `register_type` and the system in `build` below, `lib.rs` | an observer of its removal in `build` below, like `forget_zone` |
//! | an event that a game triggers | its struct in `cloth`, like `PushCloth` in `cloth/forces.rs`; its observer in `simulation`, like `pushing::ask_for_push`; `add_observer` in `build` below, `lib.rs` | a `ClothErrorKind` where it can be refused |
//! | an event that a cloth triggers | `cloth/events.rs`; triggered in `simulation` or `step`; `lib.rs` | |
//! | a source of wind | `core/solver/forces/wind` (its law, its check); `cloth/wind.rs` (the component, `ClothWind::at`); `wind/mod.rs` (`gather_air`; `blows`, which keeps cloths awake) | `simulation/tick_state.rs` (`ClothStep`), `simulation/sleeping.rs` (as seen from a cloth that rides along), `gizmos/wind.rs` |
//!
//! The compiler names most of the rest: what has to know all shapes or numbers lists them without `..` or `_`.

use bevy::app::{FixedPostUpdate, PostUpdate, RunFixedMainLoop, RunFixedMainLoopSystems};
use bevy::asset::AssetEventSystems;
use bevy::camera::visibility::{VisibilityPlugin, VisibilitySystems};
use bevy::ecs::intern::Interned;
use bevy::ecs::schedule::{ScheduleConfigs, ScheduleLabel, SingleThreadedExecutor};
use bevy::ecs::system::ScheduleSystem;
use bevy::prelude::*;

use crate::cloth::Cloth;
use crate::cloth::air::ClothAir;
use crate::cloth::culling::ClothCulling;
use crate::cloth::forces::ClothForces;
use crate::cloth::grab::ClothGrab;
use crate::cloth::gravity::{ClothGravity, ClothGravityOverride};
use crate::cloth::hang_on_start::HangOnStart;
use crate::cloth::inter_collision::ClothInterCollision;
use crate::cloth::lod::{ClothBudget, ClothLod};
use crate::cloth::material::ClothMaterial;
use crate::cloth::pins::ClothPins;
use crate::cloth::proxy::ClothProxy;
use crate::cloth::self_collision::ClothSelfCollision;
use crate::cloth::settings::{ClothInterpolation, ClothSettings};
use crate::cloth::skin::ClothSkin;
use crate::cloth::sleep::{ClothPaused, ClothSleepThreshold};
use crate::cloth::teleport::{ClothInertia, ClothTeleport};
use crate::cloth::weights::ClothWeights;
use crate::cloth::wind::{ClothWind, ClothWindOverride};
use crate::collider::bake::{BakeSdf, cancel_bake, finish_bakes, start_bakes};
use crate::collider::body::ClothBody;
use crate::collider::body::parts::{fit_bodies, forget_body, place_bodies};
use crate::collider::disturbance::{Disturbances, note_disturbances};
use crate::collider::gather_bodies::{forget_mass, gather_bodies};
use crate::collider::impulse::ColliderImpulse;
use crate::collider::load::DistanceFieldLoader;
use crate::collider::mass::{BodyImpulse, ColliderBody, ColliderMass};
use crate::collider::snapshot::{SdfColliderSnapshot, forget_states, restore_collider};
use crate::collider::tick_colliders::{
    TickColliders, drop_disabled, forget_collider, gather_colliders, take_up_enabled,
};
use crate::collider::{SdfCollider, SdfColliderDisabled};
use crate::drawing::draw_cloths;
use crate::error::ClothFailure;
use crate::error::failures::Failures;
use crate::mesh::drawn::ClothMesh;
use crate::mesh::rest_cache::RestCache;
use crate::mesh::source::ClothSource;
use crate::pose::frames::FrameClock;
use crate::schedule::{ClothSubstep, ClothSubstepSystems, ClothSystems};
use crate::sdf::DistanceField;
use crate::simulation::ClothSimulation;
use crate::simulation::anchors::gather_pins;
use crate::simulation::changes::apply_changes;
use crate::simulation::culling::{Seeing, cull_cloths};
use crate::simulation::grabbing::apply_grabs;
use crate::simulation::hanging::{cancel_hanging, hang_cloths};
use crate::simulation::inter_collision::apply_inter_collision;
use crate::simulation::lod::{Spent, choose_levels, start_clock, stop_clock, take_levels};
use crate::simulation::pinning::apply_pins;
use crate::simulation::pushing::ask_for_push;
use crate::simulation::ready::tell_ready;
use crate::simulation::reference_frame::{ask_for_reset, ask_for_teleport};
use crate::simulation::resizing::follow_scales;
use crate::simulation::self_collision::apply_self_collision;
use crate::simulation::setup::set_up_cloths;
use crate::simulation::skin::taken::{TakenSkin, give_back, put_on};
use crate::simulation::skin::wear::wear_skins;
use crate::simulation::sleeping::choose_steps;
use crate::simulation::snapshot::{ClothSnapshot, restore_cloths};
use crate::step::bodies::{share_bodies, tell_bodies};
use crate::step::impulses::sum_impulses;
use crate::step::islands::Islands;
use crate::step::islands::form::form_islands;
use crate::step::islands::settle::settle_islands;
use crate::step::islands::tell::tell_entangled;
use crate::step::{
    ClothExecution, Runner, accumulate_forces, begin_staged, choose_execution, collide, correct,
    finish_tick, gather_step, in_fixed_step, in_variable_step, integrate, is_staged, note_poses,
    refuse_variable_step, run_substeps, solve_fused,
};
use crate::wind::gather_air;
use crate::wind::zone::{WindZone, WindZones, forget_zone, gather_zones};

/// Cloth for an app: registers the components, the systems and their sets.
///
/// Cloths are stepped in `FixedPostUpdate`, or in another schedule of the fixed main loop given to
/// [`ClothPlugin::new`]. One that runs at a variable step is refused.
///
/// Works under bare `MinimalPlugins`: what has no meshes is not drawn, what has no assets bakes no
/// fields.
#[derive(Clone, Copy, Debug)]
pub struct ClothPlugin {
    schedule: Interned<dyn ScheduleLabel>,
}

impl ClothPlugin {
    /// Steps cloths in another schedule of the fixed main loop.
    pub fn new(schedule: impl ScheduleLabel) -> Self {
        Self { schedule: schedule.intern() }
    }

    /// The schedule in which cloths are stepped.
    pub(crate) fn schedule(&self) -> Interned<dyn ScheduleLabel> {
        self.schedule
    }
}

impl Default for ClothPlugin {
    fn default() -> Self {
        Self::new(FixedPostUpdate)
    }
}

impl Plugin for ClothPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Cloth>()
            .register_type::<ClothSimulation>()
            .register_type::<ClothFailure>()
            .register_type::<ClothSource>()
            .register_type::<TakenSkin>()
            .register_type::<ClothMaterial>()
            .register_type::<ClothSettings>()
            .register_type::<ClothPins>()
            .register_type::<ClothWeights>()
            .register_type::<ClothInterpolation>()
            .register_type::<ClothProxy>()
            .register_type::<ClothGravity>()
            .register_type::<ClothGravityOverride>()
            .register_type::<ClothAir>()
            .register_type::<ClothSkin>()
            .register_type::<ClothSelfCollision>()
            .register_type::<ClothInterCollision>()
            .register_type::<ClothWind>()
            .register_type::<ClothWindOverride>()
            .register_type::<WindZone>()
            .register_type::<ClothExecution>()
            .register_type::<ClothTeleport>()
            .register_type::<ClothInertia>()
            .register_type::<HangOnStart>()
            .register_type::<ClothCulling>()
            .register_type::<ClothLod>()
            .register_type::<ClothBudget>()
            .register_type::<ClothSleepThreshold>()
            .register_type::<ClothPaused>()
            .register_type::<ClothForces>()
            .register_type::<ClothGrab>()
            .register_type::<SdfCollider>()
            .register_type::<SdfColliderDisabled>()
            .register_type::<ClothBody>()
            .register_type::<ColliderImpulse>()
            .register_type::<ColliderMass>()
            .register_type::<ColliderBody>()
            .register_type::<BodyImpulse>()
            .register_type::<ClothSnapshot>()
            .register_type::<SdfColliderSnapshot>()
            .register_type::<BakeSdf>()
            .init_resource::<ClothGravity>()
            .init_resource::<ClothWind>()
            .init_resource::<WindZones>()
            .init_resource::<ClothExecution>()
            .init_resource::<RestCache>()
            .init_resource::<TickColliders>()
            .init_resource::<Disturbances>()
            .init_resource::<FrameClock>()
            .init_resource::<Runner>()
            .init_resource::<Spent>()
            .init_resource::<Islands>()
            .add_observer(tear_down)
            .add_observer(ask_for_teleport)
            .add_observer(ask_for_reset)
            .add_observer(ask_for_push)
            .add_observer(forget_collider)
            .add_observer(drop_disabled)
            .add_observer(take_up_enabled)
            .add_observer(forget_body)
            .add_observer(forget_mass)
            .add_observer(restore_collider)
            .add_observer(forget_zone)
            .add_observer(cancel_bake)
            .add_observer(cancel_hanging)
            .add_observer(give_back);
        register_fields(app);

        // Once a frame, before its ticks: note where things are.
        app.add_systems(
            RunFixedMainLoop,
            (cull_cloths, choose_levels, note_poses)
                .chain()
                .in_set(ClothSystems::TrackPoses)
                .after(RunFixedMainLoopSystems::BeforeFixedMainLoop)
                .before(RunFixedMainLoopSystems::FixedMainLoop),
        );

        // Each tick: set up -> gather -> solve -> finish.
        use ClothSystems::{Bake, Finish, Gather, LateSetup, Setup, Solve, WriteMeshes};
        app.configure_sets(self.schedule, (Setup, Gather, Solve, Finish).chain())
            .configure_sets(self.schedule, (Gather, Solve, Finish).run_if(in_fixed_step))
            .add_systems(
                self.schedule,
                (
                    set_up::<true>().in_set(Setup),
                    refuse_variable_step.run_if(in_variable_step).after(Setup).before(Gather),
                    (
                        gather_colliders,
                        gather_bodies,
                        note_disturbances,
                        gather_pins,
                        gather_step,
                        gather_zones,
                        gather_air,
                        choose_steps,
                        share_bodies,
                        form_islands,
                        tell_entangled,
                    )
                        .chain()
                        .in_set(Gather),
                    // The exclusive systems touch no more than their neighbours here, which are not
                    // exempt.
                    (
                        choose_execution.ambiguous_with_all(),
                        solve_fused.run_if(not(is_staged)),
                        (begin_staged, run_substeps.ambiguous_with_all()).chain().run_if(is_staged),
                    )
                        .chain()
                        .in_set(Solve),
                    (sum_impulses, tell_bodies, finish_tick, settle_islands, forget_states)
                        .chain()
                        .in_set(Finish),
                ),
            );

        // What all of them take, where there is a budget.
        let measured = || resource_exists::<ClothBudget>;
        app.add_systems(
            self.schedule,
            (
                start_clock.run_if(measured()).after(Setup).before(Gather),
                stop_clock.run_if(measured()).after(Finish),
            ),
        );

        // Each substep, unless fused: forces -> integrate -> correct -> collide.
        use ClothSubstepSystems::{Collide, Correct, Forces, Integrate};
        app.init_schedule(ClothSubstep)
            .edit_schedule(ClothSubstep, |schedule| {
                schedule.set_executor(SingleThreadedExecutor::new());
            })
            .configure_sets(ClothSubstep, (Forces, Integrate, Correct, Collide).chain())
            .add_systems(
                ClothSubstep,
                (
                    accumulate_forces.in_set(Forces),
                    integrate.in_set(Integrate),
                    correct.in_set(Correct),
                    collide.in_set(Collide),
                ),
            );

        // Once a frame: show it.
        app.configure_sets(
            PostUpdate,
            (Bake, LateSetup, WriteMeshes)
                .chain()
                .after(TransformSystems::Propagate)
                .before(AssetEventSystems),
        )
        // What is culled looks whether a view turns to it.
        .configure_sets(PostUpdate, WriteMeshes.after(VisibilitySystems::UpdateFrusta))
        .add_systems(
            PostUpdate,
            (
                (start_bakes, finish_bakes.run_if(resource_exists::<Assets<DistanceField>>))
                    .chain()
                    .in_set(Bake),
                set_up::<false>().in_set(LateSetup),
                draw_cloths.in_set(WriteMeshes),
            ),
        );
    }

    fn finish(&self, app: &mut App) {
        // Assets and views may have been added after this plugin.
        register_fields(app);
        if app.is_plugin_added::<VisibilityPlugin>() {
            app.insert_resource(Seeing);
        }
    }
}

/// Components become running cloths, and change them. Runs in each tick, and at each frame's end.
fn set_up<const IN_TICK: bool>() -> ScheduleConfigs<ScheduleSystem> {
    (
        fit_bodies,
        place_bodies,
        take_levels,
        set_up_cloths,
        wear_skins,
        follow_scales,
        apply_changes,
        apply_self_collision,
        apply_inter_collision,
        restore_cloths,
        apply_pins::<IN_TICK>,
        hang_cloths,
        apply_grabs,
        tell_ready,
    )
        .chain()
}

/// Makes distance fields assets that can be loaded, in an app that has assets.
fn register_fields(app: &mut App) {
    let world = app.world();
    if world.contains_resource::<AssetServer>()
        && !world.contains_resource::<Assets<DistanceField>>()
    {
        app.init_asset::<DistanceField>().register_asset_loader(DistanceFieldLoader);
    }
}

/// When `Cloth` is removed, stops the simulation and clears its errors; the mesh keeps its last shape, or is skinned again.
fn tear_down(
    removed: On<Remove, Cloth>,
    skins: Query<(&TakenSkin, Option<&ClothMesh>, Option<&Mesh3d>)>,
    mut commands: Commands,
    mut failures: Failures,
) {
    let mut entity = commands.entity(removed.entity);
    match skins.get(removed.entity) {
        Ok((taken, own, shown)) => put_on(&mut entity, taken, own, shown),
        Err(_) => drop(entity.try_remove::<(ClothSimulation, ClothMesh, ClothSource)>()),
    }
    failures.clear_those_of_cloths(removed.entity);
}
