//! Places with wind of their own.

use bevy::prelude::*;

use crate::error::failures::{Blame, Failures};
use crate::error::{ClothComponent, ClothErrorKind};
use crate::pose::pose_now;
use crate::solver::{ParameterError, WindFlow, WindShape, Zone};

/// Wind in a box, a ball or a cone: a fan, an explosion, the draught of a door. It adds to the
/// [`ClothWind`](crate::ClothWind), and zones that overlap add up. Cloths with
/// [`ClothAir`](crate::ClothAir) feel it.
///
/// It follows its entity, which may be scaled alike along all axes. Another scale is refused with a
/// [`ClothError`](crate::ClothError), and the zone is ignored until that is fixed. May be changed at any
/// time. A zone costs no time for cloths that are nowhere near.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A fan that blows along its own -z, and a blast.
/// commands.spawn((
///     WindZone::directional(Cuboid::new(1.0, 1.0, 4.0), Vec3::NEG_Z * 8.0),
///     Transform::from_xyz(0.0, 1.0, 2.0),
/// ));
/// commands.spawn(WindZone::radial(Sphere::new(3.0), 20.0).with_falloff(2.0));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
#[require(Transform)]
pub struct WindZone {
    /// Where it blows, in the entity's frame.
    pub shape: WindShape,
    /// Which way it blows and how fast.
    pub flow: WindFlow,
    /// Depth below the border at which the wind has its full speed \[m\]; towards the border it fades
    /// smoothly. Higher is softer, 0 is a hard border. Where the shape is nowhere as deep the wind is
    /// weaker everywhere. Scales with the entity.
    pub falloff: f32,
}

impl Default for WindZone {
    /// A fan that blows along its own -z at 5 m/s, in a cube of 1 m.
    fn default() -> Self {
        Self::directional(Cuboid::default(), Vec3::NEG_Z * 5.0)
    }
}

impl WindZone {
    /// Falloff of a new zone \[m\].
    pub const DEFAULT_FALLOFF: f32 = 0.25;

    /// Wind of the same velocity [m/s] everywhere, in the entity's frame: it turns with the entity.
    pub fn directional(shape: impl Into<WindShape>, velocity: Vec3) -> Self {
        let flow = WindFlow::Directional(velocity);
        Self { shape: shape.into(), flow, falloff: Self::DEFAULT_FALLOFF }
    }

    /// Wind away from the middle, or from the tip of a cone, at this speed [m/s]. Below zero it sucks.
    pub fn radial(shape: impl Into<WindShape>, speed: f32) -> Self {
        let flow = WindFlow::Radial(speed);
        Self { shape: shape.into(), flow, falloff: Self::DEFAULT_FALLOFF }
    }

    /// With another falloff \[m\]. Higher is softer.
    pub fn with_falloff(self, falloff: f32) -> Self {
        Self { falloff, ..self }
    }

    fn validate(&self) -> Result<(), ParameterError> {
        if !self.shape.is_valid() {
            let range = "positive and at most 1e7 m";
            return Err(ParameterError { name: "size", value: self.shape.worst_size(), range });
        }
        let speed = self.flow.speed();
        if !(0.0..=Zone::FASTEST).contains(&speed) {
            let range = "finite and at most 1e5 m/s";
            return Err(ParameterError { name: "speed", value: speed, range });
        }
        if !(0.0..=1e7).contains(&self.falloff) {
            let range = "from 0 to 1e7 m";
            return Err(ParameterError { name: "falloff", value: self.falloff, range });
        }
        Ok(())
    }
}

/// All zones of a tick, in the order of their entities.
#[derive(Resource, Default)]
pub(crate) struct WindZones {
    found: Vec<(Entity, Zone)>,
    zones: Vec<Zone>,
}

impl WindZones {
    /// The zones as the solver takes them.
    pub fn get(&self) -> &[Zone] {
        &self.zones
    }
}

/// Takes all zones where they are now.
pub(crate) fn gather_zones(
    zones: Query<(Entity, &WindZone)>,
    transforms: TransformHelper,
    mut gathered: ResMut<WindZones>,
    mut failures: Failures,
) {
    let WindZones { found, zones: sorted } = &mut *gathered;
    found.clear();
    sorted.clear();
    for (entity, zone) in &zones {
        match gather(entity, zone, &transforms) {
            Ok(zone) => {
                found.push((entity, zone));
                failures.clear(entity, Blame::Component(ClothComponent::WindZone));
                failures.clear(entity, Blame::Pose);
            }
            Err(error) => failures.report(entity, error),
        }
    }
    found.sort_unstable_by_key(|(entity, _)| *entity);
    sorted.extend(found.iter().map(|(_, zone)| *zone));
}

/// Clears a zone's errors when `WindZone` is removed.
pub(crate) fn forget_zone(removed: On<Remove, WindZone>, mut failures: Failures) {
    failures.clear(removed.entity, Blame::Component(ClothComponent::WindZone));
    failures.clear(removed.entity, Blame::Pose);
}

fn gather(
    entity: Entity,
    zone: &WindZone,
    transforms: &TransformHelper,
) -> Result<Zone, ClothErrorKind> {
    let component = ClothComponent::WindZone;
    zone.validate().map_err(|problem| ClothErrorKind::Parameter { component, problem })?;
    let pose = pose_now(transforms, entity)?;
    let WindZone { shape, flow, falloff } = *zone;
    Ok(Zone { shape, flow, falloff, pose })
}
