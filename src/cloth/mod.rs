//! The components that users spawn and tune: [`Cloth`] and those beside it.

pub(crate) mod air;
pub(crate) mod culling;
pub(crate) mod events;
pub(crate) mod fabrics;
pub(crate) mod forces;
pub(crate) mod forgotten;
pub(crate) mod grab;
pub(crate) mod gravity;
pub(crate) mod hang_on_start;
pub(crate) mod inter_collision;
pub(crate) mod layers;
pub(crate) mod lod;
pub(crate) mod material;
pub(crate) mod pins;
pub(crate) mod proxy;
pub(crate) mod quality;
pub(crate) mod self_collision;
pub(crate) mod settings;
pub(crate) mod skin;
pub(crate) mod sleep;
pub(crate) mod teleport;
pub(crate) mod weights;
pub(crate) mod wind;

use bevy::prelude::*;

use crate::cloth::material::ClothMaterial;
use crate::cloth::pins::ClothPins;
use crate::cloth::settings::{ClothInterpolation, ClothSettings};

/// A piece of cloth.
///
/// Spawning it is enough: required components are inserted with defaults; removing the material, settings, pins or
/// interpolation restores its default. The plugin adds a [`ClothSimulation`](crate::ClothSimulation) as soon as the
/// cloth has all it needs. A [`Cloth::sheet`] makes its own mesh (where the app has meshes at all); give the entity a
/// `MeshMaterial3d` to see it, two-sided (`double_sided: true, cull_mode: None`).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// commands.spawn((
///     Cloth::sheet(Vec2::splat(2.0), UVec2::splat(64)),
///     ClothPins::vertices([0, 63]),
///     Transform::from_xyz(0.0, 2.0, 0.0),
/// ));
/// # }
/// ```
///
/// The cloth is simulated in world space. It starts where the entity's transform puts its rest
/// shape; afterwards moving the entity moves only the pins that follow it, unless it jumps
/// ([`ClothTeleport`](crate::ClothTeleport)) or the cloth is to ride along ([`ClothInertia`](crate::ClothInertia)). The entity may be scaled
/// alike along all axes, at any time: the cloth follows in steps of 1 %, about the anchor that leads it if it is pinned, else about its middle.
/// A large mesh is made anew at each step, in the frame.
/// Another scale is refused with a [`ClothError`](crate::ClothError).
///
/// Changing the component starts the cloth anew.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
#[require(ClothMaterial, ClothSettings, ClothPins, ClothInterpolation, Transform, Visibility)]
#[component(on_add = forgotten::ask_for_plugin)]
pub struct Cloth {
    /// Where the rest shape comes from.
    pub shape: ClothShape,
}

/// Where the rest shape of a [`Cloth`] comes from.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Debug, PartialEq, Clone)]
pub enum ClothShape {
    /// A flat rectangle in the entity's xz plane, centred on its origin.
    Sheet {
        /// Width along x and depth along z \[m\]. Larger is more cloth.
        size: Vec2,
        /// Columns (along x) and rows (along z) of particles, at least 2 each. More is finer and
        /// slower.
        particles: UVec2,
    },
    /// The entity's own `Mesh3d`.
    Mesh,
}

impl Default for Cloth {
    /// A square sheet of 1 m with 32 x 32 particles.
    fn default() -> Self {
        Self::sheet(Vec2::ONE, UVec2::splat(32))
    }
}

impl Cloth {
    /// A flat sheet of `size` metres in the entity's xz plane, centred on its origin and facing +y.
    ///
    /// `particles` are its columns, along +x, and its rows, along +z. The particle in row `r` and
    /// column `c` is vertex `r * columns + c`.
    pub fn sheet(size: Vec2, particles: UVec2) -> Self {
        Self { shape: ClothShape::Sheet { size, particles } }
    }

    /// The triangles of the entity's `Mesh3d`, whatever their shape in space.
    ///
    /// Vertices at the same place (within 1e-5 of the mesh's largest side) are one particle: seams
    /// of the texture do not open, and hard edges stay hard. Triangles without area are left out,
    /// and counted in [`ClothSimulation::intake`](crate::ClothSimulation::intake). A mesh with a vertex on an edge that its triangle does
    /// not have is refused: the cloth would come open there. An open grid of rows x columns quads, the
    /// vertices in any order, is solved faster than other meshes.
    ///
    /// The mesh may still be loading. The cloth draws into a copy of its own: the asset is never
    /// written to, and any number of cloths can be made from it.
    pub fn of_mesh3d() -> Self {
        Self { shape: ClothShape::Mesh }
    }
}
