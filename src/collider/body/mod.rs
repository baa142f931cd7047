//! The body of a character, as its clothes collide with it: capsules that fit themselves to its skin.
//!
//! | file | what it does |
//! | --- | --- |
//! | here | components: what is asked for |
//! | `fit` | reads skinned meshes, and makes a list of capsules |
//! | `parts` | systems: from that list to colliders on the joints |

pub(crate) mod fit;
pub(crate) mod parts;

use bevy::ecs::entity::MapEntities;
use bevy::prelude::*;

use crate::cloth::layers::ClothLayers;
use crate::collider::SdfCollider;
use crate::collider::body::parts::BodyParts;

/// Lets clothes collide with a skinned character: capsules on its joints, that fit themselves to its skin. May be changed at any time.
///
/// It goes on the entity that has the `SkinnedMesh`, or on any above: the root of a character that a glTF file is spawned below. All
/// skinned meshes at or below the entity count, but for cloths. They are waited for while they load.
///
/// Each vertex goes to the joint that moves it most, and small joints to the ones above: fingers to the hand. A joint gets one capsule,
/// or up to four where one is too far from its skin. They have the shape that the meshes have unposed.
///
/// Their colliders become children of the joints, and are gone with this component. Each time that they have been fitted, a
/// [`ClothBodyFitted`] is triggered.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::{ClothBody, ClothBodyFitted};
/// # fn spawn(mut commands: Commands) {
/// // On the root of a character, loaded or not.
/// # let character = (Transform::default(), Visibility::default());
/// commands.spawn((character, ClothBody::default())).observe(trim);
/// # }
/// // None on the head, and all a centimetre thicker.
/// fn trim(fitted: On<ClothBodyFitted>, mut bodies: Query<&mut ClothBody>, names: Query<&Name>) {
///     let Ok(mut body) = bodies.get_mut(fitted.entity) else { return };
///     if let Some(capsules) = &mut body.capsules {
///         capsules.retain(|it| names.get(it.joint).is_ok_and(|name| name.as_str() != "head"));
///         capsules.iter_mut().for_each(|it| it.radius += 0.01);
///     }
/// }
/// ```
#[derive(Component, Reflect, MapEntities, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
#[require(BodyParts)]
pub struct ClothBody {
    /// The capsules. `None`, the default, has them fitted, and they are then listed here: to be dropped, changed, and added to.
    #[entities]
    pub capsules: Option<Vec<BodyCapsule>>,
    /// Coulomb's coefficient of friction of all of them \[1\]. Higher holds better; a pair's is the geometric mean.
    pub friction: f32,
    /// The layers that they are in.
    pub layers: ClothLayers,
}

/// The capsules of a [`ClothBody`] have been fitted, and are listed in it. What is changed of them now, no tick has seen before.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClothBodyFitted {
    /// The entity of the body.
    pub entity: Entity,
}

/// A capsule of a [`ClothBody`], in the frame of a joint.
#[derive(Reflect, MapEntities, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Debug, PartialEq, Clone)]
pub struct BodyCapsule {
    /// The joint that it goes with.
    #[entities]
    #[cfg_attr(feature = "serialize", serde(with = "crate::serialize::entity"))]
    pub joint: Entity,
    /// One end of its axis, in the frame of the joint \[m\].
    pub from: Vec3,
    /// The other end.
    pub to: Vec3,
    /// Radius \[m\].
    pub radius: f32,
}

impl Default for ClothBody {
    /// To be fitted, with a friction of 0.5, in all layers.
    fn default() -> Self {
        Self { capsules: None, friction: 0.5, layers: ClothLayers::ALL }
    }
}

impl ClothBody {
    fn collider(&self, capsule: &BodyCapsule) -> SdfCollider {
        SdfCollider::capsule_between(capsule.from, capsule.to, capsule.radius)
            .with_friction(self.friction)
            .in_layers(self.layers)
    }
}
