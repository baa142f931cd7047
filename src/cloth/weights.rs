//! Mass and stiffness that vary over a cloth, by vertex colour or by a list.

use bevy::prelude::*;

use crate::error::problems::WeightProblem;
use crate::mesh::factors::Factors;
use crate::mesh::rest_shape::RestShape;

/// Mass and stiffness that vary over a cloth: heavier at the hem, stiffer at the collar. Without
/// it, a cloth is the same everywhere. May be changed at any time.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # use bevy_drape::ClothWeights;
/// # use bevy_drape::ColorChannel;
/// # use bevy_drape::VertexFactor;
/// # fn spawn(mut commands: Commands, mesh: Handle<Mesh>) {
/// commands.spawn((
///     Cloth::of_mesh3d(),
///     Mesh3d(mesh),
///     // Where the mesh is painted red, it is up to five times as heavy.
///     ClothWeights {
///         mass: VertexFactor::Color { channel: ColorChannel::Red, at_zero: 1.0, at_one: 5.0 },
///         ..default()
///     },
/// ));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothWeights {
    /// Factor of the mass that the material's density gives \[1\]. Higher is heavier.
    pub mass: VertexFactor,
    /// Factor of the material's stiffness against stretching, shearing and bending \[1\]. Higher is
    /// stiffer.
    pub stiffness: VertexFactor,
}

/// A factor for each vertex of a mesh, from 0.001 to 1000 \[1\]. A particle of several vertices has
/// their mean.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Debug, PartialEq, Clone)]
pub enum VertexFactor {
    /// One everywhere.
    #[default]
    Uniform,
    /// By a channel of the mesh's vertex colours, in proportion between two values.
    Color {
        /// The channel.
        channel: ColorChannel,
        /// Factor where the channel is 0.
        at_zero: f32,
        /// Factor where the channel is 1.
        at_one: f32,
    },
    /// One number a vertex; of a sheet, by `row * columns + column`.
    Data(Vec<f32>),
}

/// A channel of vertex colours, as they stand in the mesh (`Mesh::ATTRIBUTE_COLOR`).
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Debug, PartialEq, Clone, Hash)]
pub enum ColorChannel {
    /// The first.
    #[default]
    Red,
    /// The second.
    Green,
    /// The third.
    Blue,
    /// The fourth.
    Alpha,
}

impl ClothWeights {
    /// The factors of the particles of a rest shape; `None` where all are one.
    pub(crate) fn factors(&self, rest: &RestShape) -> Result<Option<Factors>, WeightProblem> {
        if self.mass == VertexFactor::Uniform && self.stiffness == VertexFactor::Uniform {
            return Ok(None);
        }
        Ok(Some(Factors {
            mass: self.mass.of_particles("mass", rest)?,
            stiffness: self.stiffness.of_particles("stiffness", rest)?,
        }))
    }
}

impl VertexFactor {
    fn of_particles(
        &self,
        field: &'static str,
        rest: &RestShape,
    ) -> Result<Vec<f32>, WeightProblem> {
        let expected = rest.vertex_count();
        match self {
            Self::Uniform => Ok(vec![1.0; rest.particle_count()]),
            Self::Color { channel, at_zero, at_one } => {
                let colors = rest.colors().ok_or(WeightProblem::NoColors { field })?;
                let channel = *channel as usize;
                let factor = |color: &[f32; 4]| at_zero + (at_one - at_zero) * color[channel];
                means(field, rest, |vertex| factor(&colors[vertex]))
            }
            Self::Data(data) if data.len() != expected => {
                Err(WeightProblem::WrongLength { field, expected, got: data.len() })
            }
            Self::Data(data) => means(field, rest, |vertex| data[vertex]),
        }
    }
}

/// The mean of each particle's vertices.
fn means(
    field: &'static str,
    rest: &RestShape,
    factor: impl Fn(usize) -> f32,
) -> Result<Vec<f32>, WeightProblem> {
    let mut sums = vec![(0.0, 0.0); rest.particle_count()];
    for (vertex, particle) in rest.used_vertices() {
        let value = factor(vertex);
        if !(1e-3..=1e3).contains(&value) {
            return Err(WeightProblem::OutOfRange { field, vertex, value });
        }
        let (sum, count) = &mut sums[particle];
        *sum += value;
        *count += 1.0;
    }
    Ok(sums.into_iter().map(|(sum, count)| sum / count).collect())
}
