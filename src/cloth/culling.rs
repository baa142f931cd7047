//! Cloths that no view sees.

use bevy::prelude::*;

use crate::solver::ParameterError;

/// Stops a cloth while no view sees it, shadows included: it then costs next to nothing. For crowds, and for large levels.
///
/// Whether it is seen is Bevy's `ViewVisibility` of its entity, so that an app without Bevy's `VisibilityPlugin`, and an entity that has no
/// mesh, never stop. It keeps its shape meanwhile, and goes along with what leads it: its entity, its first anchor, or the skeleton that
/// it is worn on. As it turns up it is drawn there in the same frame, and goes on with the velocities that it had, turned with its leader.
/// A worn one has gone along with each place of its skin, so that it is within its max distance, and goes on from rest. Colliders that
/// have jumped meanwhile do not sweep through it.
///
/// To other cloths it is as a wall while it stands. Views differ from one player to the next: a game that must run alike on all machines
/// leaves this component off, or gives it to what nothing else depends on.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothCulling {
    /// Time that a cloth goes on after it was last seen \[s\]. Longer suits views that turn to and fro. The default is 0.5 s.
    pub after: f32,
}

impl Default for ClothCulling {
    fn default() -> Self {
        Self { after: 0.5 }
    }
}

impl ClothCulling {
    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        if self.after >= 0.0 && self.after.is_finite() {
            return Ok(());
        }
        let range = "at least 0 s, and finite";
        Err(ParameterError { name: "after", value: self.after, range })
    }
}
