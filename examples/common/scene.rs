//! The scenes: cloths, solids and how they look, without a window.

use super::{
    bunny::{add_bunny, hop, wait_for_tasks},
    cape::add_cape,
    check::Bounds,
    curtain::{add_curtain, draw_curtain},
    drape::{add_covered_bunny, add_spheres},
    fabrics::add_fabrics,
    figure::walk,
    flag::add_flag,
    hung::add_hung,
    sail::add_sail,
    slide::slide,
    stress::add_stress,
    tablecloth::{add_tablecloth, pull},
    tuned::add_tuned,
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

/// Polished metal.
pub fn metal(color: Srgba) -> Look {
    Look { color: color.into(), roughness: 0.3, metallic: 0.9 }
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
    /// The bunny hops through a curtain.
    Bunny,
    /// A curtain on a rail, that is drawn.
    Curtain,
    /// A curtain that starts hung, beside one that starts flat.
    Hung,
    /// A flag in a gusty wind.
    Flag,
    /// A sail that fills in a steady wind.
    Sail,
    /// A cape on the shoulders of a figure that walks.
    Cape,
    /// A cloth comes down on a table, and is pulled away.
    Tablecloth,
    /// The six fabrics that have names, each over a post.
    Fabrics,
    /// A hundred thousand particles in many cloths.
    Stress,
    /// A cloth in a breeze and one on a ball, to be tuned.
    Tuned,
}

impl Scene {
    /// Adds the scene to an app that has a [`ClothPlugin`], meshes and transforms.
    pub fn add_to(self, app: &mut App, particles: u32) {
        app.init_resource::<Assets<Image>>();
        app.add_systems(Update, wait_for_tasks)
            .add_systems(FixedUpdate, (slide, hop, walk, draw_curtain, pull));
        let world = app.world_mut();
        add_ground(world);
        // The box that the cloths are in at the end.
        let (min, max) = match self {
            Self::Drape => {
                add_spheres(world, particles, Vec3::new(-1.1, 0.0, 0.0));
                add_covered_bunny(world, particles, Vec3::new(1.1, 0.0, 0.0));
                ([-2.6, 0.0, -1.4], [2.6, 1.6, 1.4])
            }
            Self::Spheres => {
                add_spheres(world, particles, Vec3::ZERO);
                ([-1.4, 0.0, -1.4], [1.4, 1.6, 1.4])
            }
            Self::Bunny => {
                add_bunny(world, particles);
                ([-1.3, 0.0, -1.8], [1.3, 1.8, 1.8])
            }
            Self::Curtain => {
                add_curtain(world, particles);
                ([-1.3, 0.1, -0.8], [1.3, 2.3, 0.8])
            }
            Self::Hung => {
                add_hung(world, particles);
                ([-2.5, 0.0, -2.4], [2.5, 2.6, 2.4])
            }
            Self::Flag => {
                add_flag(world, particles);
                ([-1.0, 0.5, -1.2], [1.0, 2.6, 1.2])
            }
            Self::Sail => {
                add_sail(world, particles);
                ([-1.0, 0.3, -0.1], [1.0, 2.4, 1.2])
            }
            Self::Cape => {
                add_cape(world, particles);
                ([-2.2, 0.1, -2.2], [2.2, 1.6, 2.2])
            }
            Self::Tablecloth => {
                add_tablecloth(world, particles);
                ([-1.5, 0.0, -1.5], [1.5, 1.6, 5.0])
            }
            Self::Fabrics => {
                add_fabrics(world, particles);
                ([-2.2, 0.0, -1.7], [2.2, 1.0, 1.7])
            }
            Self::Stress => {
                add_stress(world, particles);
                ([-4.5, 0.0, -4.5], [4.5, 1.0, 4.5])
            }
            Self::Tuned => {
                add_tuned(world, particles);
                ([-2.0, 0.0, -1.5], [2.0, 2.0, 2.0])
            }
        };
        world.insert_resource(Bounds { min: min.into(), max: max.into() });
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

/// A mesh that cloths do not meet.
pub fn spawn_thing(world: &mut World, mesh: impl Into<Mesh>, place: Vec3, look: Look) -> Entity {
    let mesh = Mesh3d(world.resource_mut::<Assets<Mesh>>().add(mesh));
    world.spawn((mesh, Transform::from_translation(place), look)).id()
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
