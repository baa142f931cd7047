//! The sets and the schedule that cloths are stepped in.

use bevy::ecs::schedule::ScheduleLabel;
use bevy::prelude::*;

/// The sets of systems that act on cloths, in this order. `Setup` to `Finish` are in the plugin's schedule,
/// once a tick.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClothSystems {
    /// Before the fixed loop of each frame: where anchors and colliders are is noted, so that what
    /// moves once a frame can be taken where it was at each tick's time. After all of `BeforeFixedMainLoop`.
    TrackPoses,
    /// Components become running cloths, and changed components change them.
    Setup,
    /// Poses of colliders and pins through the tick, gravity and wind; teleports and resets; who takes
    /// the tick.
    Gather,
    /// The substeps.
    Solve,
    /// Errors are told, statistics kept.
    Finish,
    /// In `PostUpdate`, after transforms are propagated: meshes are baked to fields.
    Bake,
    /// In `PostUpdate`, after `Bake`: the same as `Setup`, so that a cloth is seen in the frame that spawned it.
    LateSetup,
    /// In `PostUpdate`, after `LateSetup`: meshes are written, if anything has moved.
    WriteMeshes,
}

/// The schedule of one substep, run serially as often as the tick has substeps.
///
/// The plugin's four stages are in [`ClothSubstepSystems`]. A game's own systems go between them;
/// as soon as there are any, this schedule is run in place of the fused form. See
/// [`ClothExecution`](crate::ClothExecution).
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ClothSubstep;

/// The stages of a substep, in this order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClothSubstepSystems {
    /// Springs, bending, damping, gravity, air.
    Forces,
    /// Verlet; pins move to where they are to be.
    Integrate,
    /// Threads or Provot's correction, tethers.
    Correct,
    /// Particles leave the colliders; friction.
    Collide,
}
