//! The Stanford bunny: its baked field hops through a curtain.

use super::{
    repository::repository,
    scene::{BRASS, CORAL, IVORY, clay, linen, metal, spawn_thing},
};
use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_drape::{ClothInterpolation, prelude::*};

/// A thing that hops towards +z from where it was \[m\].
#[derive(Component)]
pub struct Hopping {
    from: Vec3,
}

/// Length of a hop \[m\], its height \[m\], and how many there are.
const HOP: (f32, f32, f32) = (0.45, 0.22, 5.0);

/// Seconds that a hop takes.
const HOP_TIME: f32 = 0.6;

/// Seconds before the first.
const PAUSE: f32 = 0.5;

/// Adds a curtain, and the bunny behind it.
pub fn add_bunny(world: &mut World, particles: u32) {
    let from = Vec3::new(0.0, 0.0, -1.25);
    let bunny = spawn_bunny(world, Transform::from_translation(from).with_rotation(ahead(0.0)));
    world.entity_mut(bunny).insert(Hopping { from });

    const ROD: f32 = 1.75;
    let (width, height) = (2.0, 1.65);
    let rod = Cylinder::new(0.02, width + 0.2).mesh().build();
    let rod = rod.rotated_by(Quat::from_rotation_z(90.0_f32.to_radians()));
    spawn_thing(world, rod, Vec3::Y * ROD, metal(BRASS));
    world.spawn((
        Cloth::sheet(Vec2::new(width, height), UVec2::splat(particles)),
        ClothPins::from(PinSelection::FirstRow),
        // The ears are hardly thicker than the spacing of the particles: the cloth keeps off a little.
        ClothMaterial { thickness: 0.02, friction: 0.2, drag: 0.5, ..default() },
        // As the bunny, which is drawn where the last tick took it.
        ClothInterpolation::LastTick,
        Transform::from_xyz(0.0, ROD - 0.5 * height, 0.0)
            .with_rotation(Quat::from_rotation_x(90.0_f32.to_radians())),
        linen(CORAL),
    ));
}

/// Lets it hop, along parabolas.
pub fn hop(mut hopping: Query<(&Hopping, &mut Transform)>, time: Res<Time>) {
    let (length, height, count) = HOP;
    let hops = ((time.elapsed_secs() - PAUSE) / HOP_TIME).clamp(0.0, count);
    let part = hops.fract();
    let up = 4.0 * height * part * (1.0 - part);
    for (hopping, mut transform) in &mut hopping {
        transform.translation = hopping.from + Vec3::new(0.0, up, length * hops);
        // Its nose up, then down.
        transform.rotation = ahead(0.25 * (part - 0.5) * up / height);
    }
}

/// The bunny turned to look towards +z, its nose down by an angle \[rad\].
fn ahead(down: f32) -> Quat {
    Quat::from_rotation_x(down) * Quat::from_rotation_y(90.0_f32.to_radians())
}

/// The bunny, to be baked, 1.3 m long. It looks towards its -x.
pub fn spawn_bunny(world: &mut World, place: Transform) -> Entity {
    let mesh = world.resource_mut::<Assets<Mesh>>().add(load_bunny());
    let place = place.with_scale(Vec3::splat(1.3));
    world.spawn((BakeSdf::with_cells(96), Mesh3d(mesh), place, clay(IVORY))).id()
}

/// The Stanford bunny of `assets/`, 1 m long, sitting on y = 0.
fn load_bunny() -> Mesh {
    let path = repository("assets/bunny.obj");
    let (models, _) = tobj::load_obj(&path, &tobj::GPU_LOAD_OPTIONS)
        .unwrap_or_else(|error| panic!("cannot read {}: {error}", path.display()));
    let bunny = &models[0].mesh;
    let positions: Vec<[f32; 3]> = bunny.positions.as_chunks().0.to_vec();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(bunny.indices.clone()))
        .with_computed_smooth_normals()
}

/// Time stands still until the bunny's field is there and cloths that start hung are at rest, so that every
/// run is the same.
pub fn wait_for_tasks(
    baking: Query<(), (With<BakeSdf>, Without<SdfCollider>, Without<ClothFailure>)>,
    cloths: Query<&ClothSimulation>,
    mut time: ResMut<Time<Virtual>>,
) {
    if baking.is_empty() && !cloths.iter().any(ClothSimulation::is_hanging) {
        time.unpause();
    } else {
        time.pause();
    }
}
