//! Events that a cloth triggers on its own entity.

use bevy::prelude::*;

use crate::solver::SolverError;

/// A cloth is set up, in the shape in which it starts, and will take the next tick: its
/// [`ClothSimulation`](crate::ClothSimulation) is there. A cloth with [`HangOnStart`](crate::HangOnStart) is set up
/// when it hangs at rest.
///
/// Triggered once, and again each time the cloth starts anew, as its [`Cloth`](crate::Cloth) or its mesh was
/// changed, or its [`ClothSimulation`](crate::ClothSimulation) was taken away.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// commands.spawn(Cloth::sheet(Vec2::ONE, UVec2::splat(32))).observe(
///     |ready: On<ClothReady>, cloths: Query<&ClothSimulation>| {
///         if let Ok(cloth) = cloths.get(ready.entity) {
///             println!("{} particles", cloth.particle_count());
///         }
///     },
/// );
/// # }
/// ```
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClothReady {
    /// The cloth.
    pub entity: Entity,
}

/// A cloth has come to rest and sleeps, see [`ClothSleepThreshold`](crate::ClothSleepThreshold). Triggered in the first
/// tick that it does not take.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClothSlept {
    /// The cloth.
    pub entity: Entity,
}

/// A cloth that slept is awake. Triggered in the tick that it takes again, before it is solved.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClothWoke {
    /// The cloth.
    pub entity: Entity,
}

/// A cloth came to positions that are not finite: it is back where the tick began, and is held there until
/// it is reset or has another material, settings or air. Triggered once each time.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq)]
pub struct ClothDiverged {
    /// The cloth.
    pub entity: Entity,
    /// The solver's error.
    pub problem: SolverError,
}
