//! The scenes: cloths, solids and how they look, without a window.

use super::{
    check::Bounds,
    curtain::{add_curtain, slide_rings},
    drape::{add_bunny, add_spheres, wait_for_bakes},
};
use bevy::prelude::*;
use bevy_drape::prelude::*;

/// How a thing is painted where there is a window.
#[derive(Component, Clone, Copy)]
pub struct Look {
    pub color: Color,
    pub roughness: f32,
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

pub const CORAL: Srgba = Srgba::rgb(0.86, 0.30, 0.25);
pub const TEAL: Srgba = Srgba::rgb(0.10, 0.45, 0.50);
pub const INDIGO: Srgba = Srgba::rgb(0.22, 0.25, 0.58);
const SAND: Srgba = Srgba::rgb(0.80, 0.72, 0.60);
pub const IVORY: Srgba = Srgba::rgb(0.90, 0.87, 0.80);
pub const BRASS: Srgba = Srgba::rgb(0.85, 0.65, 0.30);

/// One of the examples' scenes.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// A cloth onto three spheres, and beside it one onto the Stanford bunny.
    Drape,
    /// Only the spheres and their cloth.
    Spheres,
    /// Only the bunny and its cloth.
    Bunny,
    /// A cloth hung from two corners that come closer.
    Curtain,
}

impl Scene {
    /// Adds the scene to an app that has a [`ClothPlugin`], meshes and transforms.
    pub fn add_to(self, app: &mut App, particles: u32) {
        app.init_resource::<Assets<Image>>();
        app.add_systems(Update, wait_for_bakes).add_systems(FixedUpdate, slide_rings);
        let world = app.world_mut();
        add_ground(world);
        let bounds = match self {
            Self::Drape => {
                add_spheres(world, particles, Vec3::new(-1.1, 0.0, 0.0));
                add_bunny(world, particles, Vec3::new(1.1, 0.0, 0.0));
                Bounds { min: Vec3::new(-2.6, 0.0, -1.4), max: Vec3::new(2.6, 1.6, 1.4) }
            }
            Self::Spheres | Self::Bunny => {
                let add = if self == Self::Spheres { add_spheres } else { add_bunny };
                add(world, particles, Vec3::ZERO);
                Bounds { min: Vec3::new(-1.4, 0.0, -1.4), max: Vec3::new(1.4, 1.6, 1.4) }
            }
            Self::Curtain => {
                add_curtain(world, particles);
                Bounds { min: Vec3::new(-1.5, 0.0, -2.4), max: Vec3::new(1.5, 2.6, 2.4) }
            }
        };
        world.insert_resource(bounds);
    }
}

fn add_ground(world: &mut World) {
    let mesh = Plane3d::default().mesh().size(60.0, 60.0).build();
    spawn_solid(world, mesh, Vec3::ZERO, linen(SAND), InfinitePlane3d::default());
}

/// A square sheet, lying flat.
pub fn spawn_sheet(
    world: &mut World,
    particles: u32,
    side: f32,
    place: Vec3,
    color: Srgba,
    material: ClothMaterial,
) -> EntityWorldMut<'_> {
    world.spawn((
        Cloth::sheet(Vec2::splat(side), UVec2::splat(particles)),
        material,
        Transform::from_translation(place),
        linen(color),
    ))
}

/// A solid and its mesh.
pub fn spawn_solid(
    world: &mut World,
    mesh: Mesh,
    place: Vec3,
    look: Look,
    shape: impl Into<SdfShape>,
) {
    let mesh = Mesh3d(world.resource_mut::<Assets<Mesh>>().add(mesh));
    world.spawn((SdfCollider::new(shape), mesh, Transform::from_translation(place), look));
}
