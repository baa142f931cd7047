//! How things look, told without a graphics card: `paint` makes materials of it where there is a window.

use bevy::prelude::*;
use bevy_drape::prelude::*;

/// How a thing is painted where there is a window.
#[derive(Component, Clone, Copy)]
pub struct Look {
    /// Its color.
    pub color: Color,
    /// From 0, a mirror, to 1.
    pub roughness: f32,
    /// From 0 to 1, metal.
    pub metallic: f32,
}

/// Linen: hardly any shine.
pub fn linen(color: Srgba) -> Look {
    Look { color: color.into(), roughness: 0.85, metallic: 0.0 }
}

/// Glazed clay.
pub fn clay(color: Srgba) -> Look {
    Look { color: color.into(), roughness: 0.35, metallic: 0.0 }
}

/// Polished metal.
pub fn metal(color: Srgba) -> Look {
    Look { color: color.into(), roughness: 0.3, metallic: 0.9 }
}

/// A red.
pub const CORAL: Srgba = Srgba::rgb(0.86, 0.30, 0.25);
/// A green blue.
pub const TEAL: Srgba = Srgba::rgb(0.10, 0.45, 0.50);
/// A dark blue.
pub const INDIGO: Srgba = Srgba::rgb(0.22, 0.25, 0.58);
/// The ground.
pub const SAND: Srgba = Srgba::rgb(0.80, 0.72, 0.60);
/// Nearly white.
pub const IVORY: Srgba = Srgba::rgb(0.90, 0.87, 0.80);
/// A yellow.
pub const BRASS: Srgba = Srgba::rgb(0.85, 0.65, 0.30);

/// The ground at y = 0, which cloths lie on.
pub fn ground(meshes: &mut Assets<Mesh>) -> impl Bundle {
    (
        SdfCollider::from(InfinitePlane3d::default()),
        Mesh3d(meshes.add(Plane3d::default().mesh().size(60.0, 60.0))),
        linen(SAND),
    )
}
