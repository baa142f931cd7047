//! The air that a cloth moves through.

use bevy::prelude::*;

use crate::solver::Air;

/// Lets a cloth feel the air: drag and lift on each face of it, against the wind. Without it there is
/// neither. May be added, changed and removed at any time.
///
/// It takes the place of [`ClothMaterial::drag`](crate::ClothMaterial::drag), which then does nothing. The
/// wind is [`ClothWind`](crate::ClothWind) and what [`WindZone`](crate::WindZone)s add to it; in still air
/// a level sheet falls at no more than `sqrt(2 m g / (density * drag * area))`.
///
/// A face of area A that the air meets with velocity u feels `density / 2 * A * |u . n|` times
/// `drag * u + lift * (|u| sign(u . n) n - |u . n| u / |u|)`, n being its normal (Keckeisen, Kimmerle,
/// Thomaszewski and Wacker 2004; so does `NvCloth`). No wind is too strong for it, and no substep too long.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// commands.insert_resource(ClothWind::steady(Vec3::new(6.0, 0.0, 1.0)));
/// commands.spawn((
///     Cloth::sheet(Vec2::new(1.5, 1.0), UVec2::new(48, 32)),
///     ClothPins::from(PinSelection::FirstColumn),
///     ClothAir::default(),
/// ));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothAir {
    /// Density of what the cloth moves through [kg/m3]. Higher pushes harder. Air at the sea is 1.225,
    /// water 1000.
    pub density: f32,
    /// Drag along the relative wind \[1\]. Higher is carried along better and falls slower. A flat square
    /// across the wind has 1.17 (Hoerner, Fluid-Dynamic Drag, 1965).
    pub drag: f32,
    /// Lift across the relative wind \[1\]. Higher sails and flutters more; with more lift than drag a
    /// cloth does so on its own, as falling paper does.
    pub lift: f32,
}

impl Default for ClothAir {
    fn default() -> Self {
        Air::default().into()
    }
}

impl From<Air> for ClothAir {
    fn from(Air { density, drag, lift }: Air) -> Self {
        Self { density, drag, lift }
    }
}

impl From<ClothAir> for Air {
    fn from(ClothAir { density, drag, lift }: ClothAir) -> Self {
        Self { density, drag, lift }
    }
}
