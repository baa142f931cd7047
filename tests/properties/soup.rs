//! A mesh of any triangles, brought into an app as a cloth: what must hold of it. For the property tests and
//! for the fuzzer.

use bevy::{
    asset::{AssetPlugin, RenderAssetUsages},
    mesh::{Indices, MeshPlugin, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
    time::TimeUpdateStrategy,
    transform::TransformPlugin,
};
use bevy_drape::prelude::*;

#[path = "../../examples/common/series.rs"]
mod series;
use series::run_in_series;

/// A mesh, and what the cloth is made of that is to come of it.
#[derive(Clone, Debug)]
pub struct Soup {
    pub positions: Vec<[f32; 3]>,
    pub indices: Vec<u32>,
    /// A strip, not a list.
    pub strip: bool,
    /// A vertex that is to be held.
    pub pin: u32,
    pub material: ClothMaterial,
}

/// An app that takes meshes in.
pub fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), MeshPlugin, TransformPlugin))
        .add_plugins(ClothPlugin::default())
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    run_in_series(&mut app);
    app.finish();
    app.cleanup();
    app.update();
    app
}

/// Ticks that a cloth is looked at for.
const TICKS: usize = 3;

/// Takes a mesh in, runs it for a few ticks, and takes it out again. Tells whether it became a cloth.
///
/// # Errors
/// What did not hold.
pub fn check_soup(app: &mut App, soup: &Soup) -> Result<bool, String> {
    let topology =
        if soup.strip { PrimitiveTopology::TriangleStrip } else { PrimitiveTopology::TriangleList };
    let mesh = Mesh::new(topology, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, soup.positions.clone())
        .with_inserted_indices(Indices::U32(soup.indices.clone()));
    let handle = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    let pins = ClothPins::vertices([soup.pin % soup.positions.len().max(1) as u32]);
    let bundle = (Cloth::of_mesh3d(), Mesh3d(handle.clone()), pins, soup.material);
    let cloth = app.world_mut().spawn(bundle).id();
    let mut outcome = Ok(false);
    for _ in 0..TICKS {
        app.update();
        outcome = look(app, cloth);
        if outcome.is_err() {
            break;
        }
    }
    app.world_mut().despawn(cloth);
    app.world_mut().resource_mut::<Assets<Mesh>>().remove(&handle);
    outcome
}

fn look(app: &App, cloth: Entity) -> Result<bool, String> {
    let failure = app.world().get::<ClothFailure>(cloth).map(|failure| failure.error.to_string());
    if failure.as_ref().is_some_and(|failure| !failure.contains(&cloth.to_string())) {
        return Err(format!("it does not name its entity: {failure:?}"));
    }
    let Some(running) = app.world().get::<ClothSimulation>(cloth) else {
        return if failure.is_some() { Ok(false) } else { Err("neither a cloth nor told".into()) };
    };
    if let Some(particle) = running.positions().position(|p| !p.is_finite()) {
        return Err(format!("particle {particle} is nowhere, {failure:?}"));
    }
    for particle in 0..running.particle_count() {
        if !running.velocity(particle).is_some_and(Vec3::is_finite) {
            return Err(format!("particle {particle} has no velocity"));
        }
    }
    let meshes = app.world().resource::<Assets<Mesh>>();
    let drawn = app.world().get::<Mesh3d>(cloth).and_then(|mesh| meshes.get(mesh));
    let drawn = drawn.ok_or("it is not drawn")?;
    for which in [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL] {
        let Some(VertexAttributeValues::Float32x3(values)) = drawn.attribute(which) else {
            return Err("an attribute is missing".into());
        };
        if let Some(vertex) = values.iter().position(|v| !Vec3::from_array(*v).is_finite()) {
            return Err(format!("vertex {vertex} is drawn nowhere"));
        }
    }
    Ok(true)
}
