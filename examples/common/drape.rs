//! Cloths that come down on spheres and on a mesh.

use super::scene::{CORAL, IVORY, TEAL, clay, spawn_sheet, spawn_solid};
use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_drape::prelude::*;

/// Three spheres on the ground, and a cloth above.
pub fn add_spheres(world: &mut World, particles: u32, center: Vec3) {
    for (x, z, radius) in [(-0.38, -0.20, 0.45), (0.46, -0.12, 0.33), (0.06, 0.46, 0.24)] {
        let sphere = Sphere::new(radius);
        let mesh = sphere.mesh().uv(96, 48);
        let place = center + Vec3::new(x, radius, z);
        spawn_solid(world, mesh, place, clay(IVORY), sphere);
    }
    let place = center + 1.1 * Vec3::Y;
    spawn_sheet(world, particles, 2.0, place, CORAL, ClothMaterial::default());
}

/// The bunny, to be baked, and a cloth above.
pub fn add_bunny(world: &mut World, particles: u32, center: Vec3) {
    let mesh = world.resource_mut::<Assets<Mesh>>().add(load_bunny());
    world.spawn((
        BakeSdf::with_cells(96),
        Mesh3d(mesh),
        Transform::from_translation(center).with_scale(Vec3::splat(1.3)),
        clay(IVORY),
    ));
    // Its ears are hardly thicker than the spacing of the particles: the cloth keeps off a little.
    let material = ClothMaterial { thickness: 0.02, ..default() };
    let place = center + 1.32 * Vec3::Y;
    // And the tips of the ears stop it as two points: twice the usual substeps hold the strain there.
    let settings = ClothSettings { substeps: Substeps::Automatic { budget: 40 }, ..default() };
    spawn_sheet(world, particles, 2.0, place, TEAL, material).insert(settings);
}

/// The Stanford bunny of `assets/`, 1 m long, sitting on y = 0.
fn load_bunny() -> Mesh {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/bunny.obj");
    let (models, _) = tobj::load_obj(path, &tobj::GPU_LOAD_OPTIONS)
        .unwrap_or_else(|error| panic!("cannot read {path}: {error}"));
    let bunny = &models[0].mesh;
    let positions: Vec<[f32; 3]> = bunny.positions.as_chunks().0.to_vec();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(bunny.indices.clone()))
        .with_computed_smooth_normals()
}

/// Time stands still until the bunny's field is there, so that every run is the same.
pub fn wait_for_bakes(
    waiting: Query<(), (With<BakeSdf>, Without<SdfCollider>, Without<ClothFailure>)>,
    mut time: ResMut<Time<Virtual>>,
) {
    if waiting.is_empty() {
        time.unpause();
    } else {
        time.pause();
    }
}
