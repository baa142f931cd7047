//! Real-time cloth for Bevy: a mass-spring sheet that hangs, drapes and slides over solids.
//!
//! Add [`ClothPlugin`], spawn a [`Cloth`] and something to fall on:
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_drape::prelude::*;
//!
//! let mut app = App::new();
//! // A game has `DefaultPlugins`. Bare `MinimalPlugins` simulate as well, and draw nothing.
//! app.add_plugins((MinimalPlugins, ClothPlugin::default()));
//! // Each update takes one fixed tick, whatever the clock says: a test has the same result every time.
//! app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(1));
//! app.world_mut().spawn((SdfCollider::from(Sphere::new(0.5)), Transform::default()));
//! let cloth = app
//!     .world_mut()
//!     .spawn((
//!         Cloth::sheet(Vec2::splat(1.6), UVec2::splat(24)),
//!         ClothMaterial { area_density: 0.15, ..default() },
//!         Transform::from_xyz(0.0, 0.6, 0.0),
//!     ))
//!     .id();
//! // What `App::run` does in a game.
//! app.finish();
//! app.cleanup();
//! for _ in 0..40 {
//!     app.update();
//! }
//! let running = app.world().get::<ClothSimulation>(cloth);
//! let running = running.expect("the cloth is set up in its first frame");
//! assert!(running.positions().all(|position| position.length() > 0.499));
//! # assert!(running.last_tick().is_some());
//! ```
//!
//! The [`guide`] goes from here to a cape, and from what is seen to what to change.
//!
//! # How a tick goes
//!
//! - **Set up**: a [`Cloth`] with its [`ClothMaterial`], [`ClothPins`] and [`ClothSettings`] becomes a
//!   [`ClothSimulation`]; changed components change it. With [`HangOnStart`] it starts where it hangs, at
//!   rest.
//! - **Gather**: where colliders and pins are at the tick's start and at its end, gravity and wind. A
//!   cloth whose entity has jumped is carried along ([`ClothTeleport`]); one that is frozen
//!   ([`ClothPaused`]), is not seen ([`ClothCulling`]) or sleeps ([`ClothSleepThreshold`]) sits the tick out.
//! - **Solve**: so many substeps of forces, Verlet integration, correction, collision. How many, and
//!   whether by explicit springs or by whole threads, follows from the material; see
//!   [`ClothSimulation::plan`].
//! - **Write meshes**: once a frame, each cloth's own mesh asset is written in place, if anything has moved.
//!
//! # Units
//!
//! SI throughout: metres, kilograms, seconds, newtons. A finer sheet of the same material weighs
//! the same and stretches alike.
//!
//! # What goes wrong
//!
//! Nothing a game passes makes a cloth panic: what cannot be used is a [`ClothError`] that names
//! the entity and says what to do, logged once and kept on the entity as [`ClothFailure`]. Other
//! cloths go on. The log is Bevy's: `MinimalPlugins` are without it, so add its `LogPlugin` there.
//!
//! # What is guaranteed
//!
//! Each sentence is held by the tests named after it; what is not here is not promised.
//!
//! - **Nothing becomes NaN, and nothing panics.** Whatever is accepted of shapes, materials, settings,
//!   pins, colliders, gravity, wind and steps, all positions, velocities and drawn vertices stay finite;
//!   what is not accepted is a typed error that names its entity, and a tick that comes to what is no number
//!   is undone and told as [`solver::SolverError::Diverged`] (`tests/properties`: thousands of random cases and
//!   a fuzzer's corpus; `tests/ecs/bad_input`; `tests/stability`, `h14` to `h16`, `h21`, `h22`).
//!   [`solver::Integrator::Euler`] and [`solver::Integrator::Midpoint`] are for study and outside of this.
//! - **What cannot be fulfilled does not shake.** Pins led further apart than the cloth reaches leave a
//!   cloth of the default material at rest between them, up to a fifth too far; stiffer ones, and further, stay
//!   bounded (`h20`). A cloth that is clamped between colliders with no room for it stays bounded (`h23`).
//! - **At rest it rests**: over nine minutes, hung or on a floor, nothing moves by more than 0.01 mm in a tick, or drifts
//!   by more than 0.5 mm (`h17`). On the flanks of a ball, where friction is at its limit, a particle may slip once in
//!   minutes: by 0.3 mm in a tick, and by a centimetre in all. What hangs from one particle alone turns about it, by a
//!   centimetre a second at most where drag is 2 /s.
//! - **One cloth's trouble is its own**: others go on in the same bits (`h15`, `tests/ecs/bad_input`).
//! - **The same input gives the same bits**: in every run, with any number of CPU threads, fused or staged, on
//!   every instruction set of x86-64 (`tests/ecs/execution`, `h24`, `tests/solver/determinism` and
//!   `graph_determinism`), and anywhere in the world where all poses are representable (`h18`).
//! - **Frames do not matter** to what is moved in the fixed schedule: every frame rate gives the same bits
//!   (`tests/ecs/pins`, `what_moves_in_the_fixed_schedule_does_not_depend_on_the_frame_rate`; of soft pins
//!   `tests/ecs/anchors`, `what_moves_in_ticks_holds_soft_pins_alike_at_every_frame_rate`). What is moved once
//!   a frame is taken where it was at each tick's time, a frame late: its bits do depend on the frames, but what moves evenly moves
//!   evenly in every tick (`tests/ecs/frames`).
//!
//! # Limits
//!
//! - A cloth is a rectangular sheet, or a triangle mesh; a skinned one wants [`ClothSkin`].
//! - Cloths collide with themselves where [`ClothSelfCollision`] asks for it, with each other where [`ClothInterCollision`] does, and
//!   push colliders that have a [`ColliderMass`].
//! - Colliders are rigid, and scaled alike along all axes.
//! - The step is fixed: the plugin runs in the fixed main loop and nowhere else.

// On docs.rs each item says which feature it needs.
#![cfg_attr(docsrs, feature(doc_cfg))]
// A library does not print; programs among the examples may.
#![warn(clippy::print_stdout, clippy::print_stderr)]

mod cloth;
mod collider;
mod diagnostics;
mod drawing;
#[cfg(any(feature = "avian", feature = "rapier"))]
mod engines;
mod error;
#[cfg(feature = "gizmos")]
mod gizmos;
pub mod guide;
#[cfg(feature = "pbr")]
mod looks;
mod mesh;
#[cfg(feature = "panel")]
mod panel;
#[cfg(feature = "picking")]
mod picking;
mod plugin;
mod pose;
#[cfg(any(feature = "gizmos", feature = "panel"))]
mod proximity;
mod schedule;
#[cfg(feature = "serialize")]
mod serialize;
mod simulation;
mod step;
mod wind;

#[doc(inline)]
pub use bevy_drape_core::{hang, sdf, solver};
pub use cloth::air::ClothAir;
pub use cloth::culling::ClothCulling;
pub use cloth::events::{ClothDiverged, ClothReady, ClothSlept, ClothWoke};
pub use cloth::forces::{ClothForce, ClothForces, PushCloth};
pub use cloth::grab::{ClothGrab, GrabHold};
pub use cloth::gravity::{ClothGravity, ClothGravityOverride};
pub use cloth::hang_on_start::{HangOnStart, HangingPlaces};
pub use cloth::inter_collision::ClothInterCollision;
pub use cloth::layers::ClothLayers;
pub use cloth::lod::{ClothBudget, ClothLevel, ClothLod};
pub use cloth::material::ClothMaterial;
pub use cloth::pins::{ClothPins, Pin, PinHold, PinSelection};
pub use cloth::proxy::ClothProxy;
pub use cloth::self_collision::ClothSelfCollision;
pub use cloth::settings::{ClothInterpolation, ClothSettings};
pub use cloth::skin::{ClothSkin, SkinBackstop, SkinMap};
pub use cloth::sleep::{ClothPaused, ClothSleepThreshold};
pub use cloth::teleport::{ClothInertia, ClothTeleport, ResetCloth, TeleportCloth};
pub use cloth::weights::{ClothWeights, ColorChannel, VertexFactor};
pub use cloth::wind::{ClothWind, ClothWindOverride};
pub use cloth::{Cloth, ClothShape};
pub use collider::bake::{BakeSdf, SdfCells};
pub use collider::body::{BodyCapsule, ClothBody, ClothBodyFitted};
pub use collider::impulse::ColliderImpulse;
pub use collider::load::{DistanceFieldLoader, LoadFieldError};
pub use collider::mass::{BodyImpulse, ColliderBody, ColliderMass};
pub use collider::shape::{CustomSdf, SdfShape};
pub use collider::snapshot::SdfColliderSnapshot;
pub use collider::{SdfCollider, SdfColliderDisabled};
pub use diagnostics::ClothDiagnosticsPlugin;
#[cfg(any(feature = "avian", feature = "rapier"))]
pub use engines::ClothCollider;
#[cfg(feature = "avian")]
pub use engines::avian::AvianClothPlugin;
#[cfg(feature = "rapier")]
pub use engines::rapier::RapierClothPlugin;
pub use error::body::BodyProblem;
pub use error::engine::EngineProblem;
pub use error::problems::{
    FieldProblem, GrabProblem, GridProblem, HangProblem, MeshProblem, PinProblem, ScaleProblem,
    WeightProblem,
};
pub use error::proxy::ProxyProblem;
pub use error::skin::SkinProblem;
pub use error::{ClothComponent, ClothError, ClothErrorKind, ClothFailure};
#[cfg(feature = "gizmos")]
pub use gizmos::SdfSlice;
#[cfg(feature = "gizmos")]
pub use gizmos::{ClothGizmos, ClothGizmosPlugin};
#[cfg(feature = "pbr")]
pub use looks::two_sided;
pub use mesh::intake::ClothIntake;
pub use mesh::surface::SkippedTriangles;
#[cfg(feature = "panel")]
pub use panel::explain;
#[cfg(feature = "panel")]
pub use panel::{ClothPanel, PanelAction, PanelFacts};
#[cfg(feature = "panel")]
pub use panel::{ClothPanelModelPlugin, ClothPanelPlugin};
#[cfg(feature = "panel")]
pub use panel::{MaterialFileError, load_material, save_material};
#[cfg(feature = "panel")]
pub use panel::{PanelHistory, PanelSample};
#[cfg(feature = "picking")]
pub use picking::{ClothPicking, ClothPickingPlugin};
pub use plugin::ClothPlugin;
pub use schedule::{ClothSubstep, ClothSubstepSystems, ClothSystems};
pub use simulation::ClothSimulation;
pub use simulation::snapshot::ClothSnapshot;
pub use step::ClothExecution;
pub use wind::zone::WindZone;

/// The items that most games need: `use bevy_drape::prelude::*`. All others are in the crate itself and in its modules.
pub mod prelude {
    #[cfg(feature = "avian")]
    pub use crate::AvianClothPlugin;
    #[cfg(any(feature = "avian", feature = "rapier"))]
    pub use crate::ClothCollider;
    #[cfg(feature = "rapier")]
    pub use crate::RapierClothPlugin;
    pub use crate::{
        BakeSdf, Cloth, ClothAir, ClothFailure, ClothGravity, ClothInertia, ClothInterCollision,
        ClothLayers, ClothMaterial, ClothPaused, ClothPins, ClothPlugin, ClothReady,
        ClothSelfCollision, ClothSettings, ClothSimulation, ClothSnapshot, ClothSystems,
        ClothTeleport, ClothWind, HangOnStart, PinSelection, PushCloth, ResetCloth, SdfCollider,
        SdfShape, TeleportCloth, WindZone,
    };
}

/// The README's snippets compile, where there is a window to show one in.
#[cfg(all(doctest, feature = "demo"))]
#[doc = include_str!("../README.md")]
struct Readme;
