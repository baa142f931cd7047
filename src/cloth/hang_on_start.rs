//! Cloths that start where they hang.

use bevy::prelude::*;

use crate::hang::Relaxation;
use crate::solver::ParameterError;

/// Starts the cloth hung from its pins, at rest, instead of in its rest shape.
///
/// From its first frame on the cloth is in the shape of Weil's geometric model (see
/// [`hang`](mod@crate::hang)); from there it comes to rest in a background task, under gravity and its own
/// forces, without colliders and wind. Meanwhile it stands still, and is carried along with what leads it.
/// Its simulated time starts when the task is done: however long that takes, it starts alike.
///
/// The pins hang at two or more places, no two of them further apart than the cloth between them reaches.
/// Where they do not, that is told as a [`ClothErrorKind::Hang`](crate::ClothErrorKind::Hang), and the cloth starts in its rest shape.
///
/// Read once, when the cloth starts; has no effect on a running cloth. Removing it while the cloth comes to
/// rest in the background lets the cloth start from where it is.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A curtain of 1.8 m between rings 1.2 m apart.
/// let mut ring = |x| commands.spawn(Transform::from_xyz(x, 2.2, 0.0)).id();
/// let (left, right) = (ring(-0.6), ring(0.6));
/// commands.spawn((
///     Cloth::sheet(Vec2::splat(1.8), UVec2::splat(64)),
///     ClothPins::vertices([0])
///         .anchored_to(left)
///         .and(ClothPins::vertices([63]).anchored_to(right)),
///     HangOnStart::default(),
/// ));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct HangOnStart {
    /// Where pins that have an anchor hang.
    pub places: HangingPlaces,
    /// Speed below which all particles are at rest [m/s]. Lower comes closer to rest and takes longer.
    pub speed: f32,
    /// Time that the cloth may take to come to rest \[s\], simulated in the background; it starts as it
    /// is by then. Longer comes closer to rest. With 0 it starts in Weil's shape.
    pub longest: f32,
}

/// Where pins that have an anchor hang. One that has none hangs at its rest position.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Debug, PartialEq, Clone)]
pub enum HangingPlaces {
    /// At the anchor: one particle at its origin; several that it holds are around that as they are
    /// around their middle at rest.
    #[default]
    Anchors,
    /// At their rest positions, as cloths do that are not hung: the anchor is where it is relative to
    /// them.
    Rest,
}

impl Default for HangOnStart {
    fn default() -> Self {
        let Relaxation { speed, longest } = Relaxation::default();
        Self { places: HangingPlaces::default(), speed, longest }
    }
}

impl HangOnStart {
    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        let check = |name, value: f32, most: f32, range| {
            let good = value >= 0.0 && value <= most;
            if good { Ok(()) } else { Err(ParameterError { name, value, range }) }
        };
        check("speed", self.speed, f32::MAX, "at least 0 m/s, and finite")?;
        check("longest", self.longest, 3600.0, "from 0 to 3600 s")
    }
}
