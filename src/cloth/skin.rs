//! Cloth that is worn: it takes a skinned mesh over, and is held near where the skeleton moves it.

use bevy::prelude::*;
use bevy_drape_core::surface::Influences;

use crate::cloth::weights::ColorChannel;
use crate::error::skin::SkinProblem;
use crate::mesh::rest_shape::RestShape;
use crate::mesh::skinned::SkinnedShape;
use crate::solver::{Backstop, SkinLimit};

/// Lets a cloth take over the skin of its entity: coats, skirts and capes of animated characters. It goes beside
/// [`Cloth::of_mesh3d`](crate::Cloth::of_mesh3d) on the entity that has the `SkinnedMesh`. May be changed at any time.
///
/// Where the skeleton would move a particle is its *place on the skin*. The three maps say how far it may go from there. Where its
/// max distance is 0, it is held there, and drawn where the skeleton is drawn. Hard pins without an anchor hold to the skin as well.
///
/// The plugin takes `SkinnedMesh` off the entity and draws into a copy of the mesh without joints, as the renderer would move the
/// cloth a second time. When this component or the cloth is removed, the mesh is drawn skinned as before. A
/// `SkinnedMesh` or a `Mesh3d` that is inserted meanwhile is taken over in place of the former.
///
/// The cloth starts where its skin is, and has the size that its skeleton gives it; the entity's own transform does not matter, as for
/// all skinned meshes. The joint that moves most of it leads it: see [`ClothTeleport`](crate::ClothTeleport) and
/// [`ClothInertia`](crate::ClothInertia). Animations move joints once a frame: each tick takes
/// them where they were at its time, a frame late.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::{ClothSkin, ColorChannel, SkinBackstop, SkinMap, prelude::*};
/// // A scene has been spawned: the skirt becomes cloth.
/// fn dress(skirts: Query<(Entity, &Name), Added<Mesh3d>>, mut commands: Commands) {
///     for (entity, name) in &skirts {
///         if name.as_str() == "skirt" {
///             commands.entity(entity).insert((
///                 Cloth::of_mesh3d(),
///                 ClothSkin {
///                     // Black is held, white may go 20 cm away.
///                     max_distance: SkinMap::color(ColorChannel::Red, 0.0, 0.2),
///                     // Nothing goes more than a centimetre into the body.
///                     backstop: Some(SkinBackstop { distance: 0.01.into(), ..default() }),
///                     ..default()
///                 },
///             ));
///         }
///     }
/// }
/// # bevy::ecs::system::assert_is_system(dress);
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothSkin {
    /// How far a particle goes from its place on the skin at most \[m\], 0 or more; 0 holds it there, and infinite (the default) lets
    /// it go anywhere.
    pub max_distance: SkinMap,
    /// What no particle enters, behind its place on the skin; `None` is nothing.
    pub backstop: Option<SkinBackstop>,
    /// Rate of the critically damped spring that draws a particle to its place on the skin \[1/s\], from 0 to 10000: a tenth of the way
    /// is left after a time of about `4 / drive`. Higher follows the animation closer; 0 (the default) draws nothing.
    pub drive: SkinMap,
    /// Whether vertex colours are drawn although a map goes by them. A mask that is painted in colours would tint the
    /// `StandardMaterial`, and so it is left out of what is drawn by default.
    pub draws_mask: bool,
}

/// A ball behind each particle's place on the skin, along the skin's normal there, that the particle does not enter: the body, as far
/// as it matters to this particle.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Debug, PartialEq, Clone)]
pub struct SkinBackstop {
    /// How far behind the place the ball begins \[m\]. Higher lets the cloth further in; negative keeps it out by that much, at most by
    /// the max distance.
    pub distance: SkinMap,
    /// Radius of the ball \[m\], above 0; infinite (the default) is all that is behind. Larger than the triangles around, so that no
    /// particle goes past it.
    pub radius: SkinMap,
}

/// A number for each vertex of a skinned mesh. A particle of several vertices has their mean.
///
/// Lengths are in the units of the mesh's own positions, and grow with the skeleton's scale, as the mesh does.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Debug, PartialEq, Clone)]
pub enum SkinMap {
    /// The same everywhere.
    Uniform(f32),
    /// By a channel of the mesh's vertex colours, in proportion between two numbers.
    Color {
        /// The channel.
        channel: ColorChannel,
        /// The number where the channel is 0.
        at_zero: f32,
        /// The number where the channel is 1. If it is infinite, so are all above 0.
        at_one: f32,
    },
    /// By an attribute of one float a vertex, in proportion between two numbers. Of glTF files, Bevy loads those that were registered by
    /// `GltfPlugin::add_custom_vertex_attribute`, without the underscore that their names begin with in the file.
    Attribute {
        /// The attribute's name, as it was registered.
        name: String,
        /// The number where the attribute is 0.
        at_zero: f32,
        /// The number where the attribute is 1. If it is infinite, so are all above 0.
        at_one: f32,
    },
    /// By the weight of a joint, in proportion between two numbers: a joint that moves nothing else is a mask that every modelling
    /// program can paint.
    JointWeight {
        /// The `Name` of the joint.
        joint: String,
        /// The number where the joint has no weight.
        at_zero: f32,
        /// The number where it has all of it. If it is infinite, so are all above 0.
        at_one: f32,
    },
    /// One number a vertex.
    Data(Vec<f32>),
}

impl From<f32> for SkinMap {
    fn from(value: f32) -> Self {
        Self::Uniform(value)
    }
}

impl Default for ClothSkin {
    fn default() -> Self {
        Self {
            max_distance: SkinMap::Uniform(f32::INFINITY),
            backstop: None,
            drive: SkinMap::Uniform(0.0),
            draws_mask: false,
        }
    }
}

impl Default for SkinBackstop {
    fn default() -> Self {
        Self { distance: SkinMap::Uniform(0.0), radius: SkinMap::Uniform(f32::INFINITY) }
    }
}

impl ClothSkin {
    /// Whether a map goes by vertex colours that are not to be drawn.
    pub(crate) fn hides_colors(&self) -> bool {
        let backstop = self.backstop.as_ref();
        let of_backstop = backstop.into_iter().flat_map(|it| [&it.distance, &it.radius]);
        let mut all = [&self.max_distance, &self.drive].into_iter().chain(of_backstop);
        !self.draws_mask && all.any(|map| matches!(map, SkinMap::Color { .. }))
    }

    /// The limits of all particles, when the skeleton makes the mesh larger by `scale`.
    pub(crate) fn limits(&self, on: &MapSource, scale: f32) -> Result<Vec<SkinLimit>, SkinProblem> {
        let max_distance = self.max_distance.of_particles("max_distance", on)?;
        let drive = self.drive.of_particles("drive", on)?;
        let backstop = match &self.backstop {
            Some(SkinBackstop { distance, radius }) => Some((
                distance.of_particles("backstop.distance", on)?,
                radius.of_particles("backstop.radius", on)?,
            )),
            None => None,
        };
        let limit = |particle: usize| {
            let stop = |(distance, radius): &(Vec<f32>, Vec<f32>)| Backstop {
                distance: distance[particle] * scale,
                radius: radius[particle] * scale,
            };
            let max_distance = max_distance[particle] * scale;
            let backstop = backstop.as_ref().map(stop);
            let limit = SkinLimit { max_distance, backstop, drive: drive[particle] };
            if backstop.is_some() && on.shape.normals[particle] == Vec3::ZERO {
                return Err(SkinProblem::NoNormal { particle });
            }
            let checked = limit.validate();
            checked.map(|()| limit).map_err(|problem| SkinProblem::OutOfRange { particle, problem })
        };
        (0..max_distance.len()).map(limit).collect()
    }

    /// Which particles have a max distance of 0.
    pub(crate) fn at_zero(&self, on: &MapSource) -> Result<Vec<bool>, SkinProblem> {
        let distances = self.max_distance.of_particles("max_distance", on)?;
        Ok(distances.iter().map(|distance| *distance == 0.0).collect())
    }
}

/// What maps are read from.
pub(crate) struct MapSource<'a> {
    pub rest: &'a RestShape,
    /// The mesh that the rest shape was made of.
    pub mesh: &'a Mesh,
    pub shape: &'a SkinnedShape,
    /// The index of the joint of a name.
    pub joint: &'a dyn Fn(&str) -> Option<u16>,
}

impl SkinMap {
    /// By a channel of the mesh's vertex colours: `at_zero` where it is 0, `at_one` where it is 1.
    pub fn color(channel: ColorChannel, at_zero: f32, at_one: f32) -> Self {
        Self::Color { channel, at_zero, at_one }
    }

    /// By an attribute of one float a vertex: `at_zero` where it is 0, `at_one` where it is 1.
    pub fn attribute(name: impl Into<String>, at_zero: f32, at_one: f32) -> Self {
        Self::Attribute { name: name.into(), at_zero, at_one }
    }

    /// By the weight of a joint: `at_zero` where it has none, `at_one` where it has all of it.
    pub fn joint_weight(joint: impl Into<String>, at_zero: f32, at_one: f32) -> Self {
        Self::JointWeight { joint: joint.into(), at_zero, at_one }
    }

    fn of_particles(&self, field: &'static str, on: &MapSource) -> Result<Vec<f32>, SkinProblem> {
        let count = on.rest.particle_count();
        match self {
            Self::Uniform(value) => Ok(vec![*value; count]),
            Self::Color { channel, at_zero, at_one } => {
                let colors = on.rest.colors().ok_or(SkinProblem::NoColors { field })?;
                let channel = *channel as usize;
                Ok(means(on.rest, |vertex| between(*at_zero, *at_one, colors[vertex][channel])))
            }
            Self::Attribute { name, at_zero, at_one } => {
                let values = floats(on.mesh, name).filter(|it| it.len() == on.rest.vertex_count());
                let missing = || SkinProblem::NoAttribute { field, name: name.clone() };
                let values = values.ok_or_else(missing)?;
                Ok(means(on.rest, |vertex| between(*at_zero, *at_one, values[vertex])))
            }
            Self::JointWeight { joint, at_zero, at_one } => {
                let missing = || SkinProblem::NoNamedJoint { field, name: joint.clone() };
                let index = (on.joint)(joint).ok_or_else(missing)?;
                let weight = |it: &Influences| {
                    let all = it.joints.into_iter().zip(it.weights);
                    all.filter(|(joint, _)| *joint == index).map(|(_, weight)| weight).sum()
                };
                let at = |it| between(*at_zero, *at_one, weight(it));
                Ok(on.shape.influences.iter().map(at).collect())
            }
            Self::Data(data) if data.len() != on.rest.vertex_count() => {
                let expected = on.rest.vertex_count();
                Err(SkinProblem::WrongLength { field, expected, got: data.len() })
            }
            Self::Data(data) => Ok(means(on.rest, |vertex| data[vertex])),
        }
    }
}

/// The number at a part of the way from one to another. Where one of them is infinite, so is all that is between.
fn between(at_zero: f32, at_one: f32, part: f32) -> f32 {
    if part == 0.0 {
        at_zero
    } else if part == 1.0 {
        at_one
    } else if at_zero.is_infinite() {
        at_zero
    } else {
        at_zero + (at_one - at_zero) * part
    }
}

/// The mean of each particle's vertices.
fn means(rest: &RestShape, value: impl Fn(usize) -> f32) -> Vec<f32> {
    let mut sums = vec![(0.0, 0.0); rest.particle_count()];
    for (vertex, particle) in rest.used_vertices() {
        let (sum, count) = &mut sums[particle];
        *sum += value(vertex);
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| sum / count).collect()
}

/// The attribute of a name, if it is of one float a vertex.
fn floats<'a>(mesh: &'a Mesh, name: &str) -> Option<&'a [f32]> {
    use bevy::mesh::VertexAttributeValues::Float32;
    let mut all = mesh.try_attributes().ok()?;
    let (_, values) = all.find(|(attribute, _)| attribute.name == name)?;
    match values {
        Float32(values) => Some(values),
        _ => None,
    }
}
