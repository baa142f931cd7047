//! The app that the tests run, and how they look at it.

pub mod leaning;
mod meshes;
pub mod pile;
mod pools;
pub mod saved_scene;

use std::{
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    time::{Duration, Instant},
};

use bevy::{
    app::Plugins,
    asset::AssetPlugin,
    mesh::{MeshPlugin, VertexAttributeValues},
    prelude::*,
    time::TimeUpdateStrategy,
    transform::TransformPlugin,
};
use bevy_drape::{ClothError, ClothExecution, ClothFailure, prelude::*};

pub use meshes::*;
pub use pools::{POOL, in_pools};

pub use examples_common::run_in_series;

/// Set to run every test in the staged form.
pub const STAGED: &str = "BEVY_DRAPE_TEST_STAGED";

/// Bevy's default step.
pub const TICK: Duration = Duration::from_micros(15625);

/// An app after its first frame, which runs no tick. Each further `update` runs one.
pub fn app() -> App {
    app_with(ClothPlugin::default())
}

pub fn app_with<M>(plugins: impl Plugins<M>) -> App {
    app_of(AssetPlugin::default(), plugins)
}

/// An app that reads its assets from a folder.
pub fn app_in(folder: &Path) -> App {
    let file_path = folder.to_str().expect("the path is Unicode").into();
    app_of(AssetPlugin { file_path, ..default() }, ClothPlugin::default())
}

fn app_of<M>(assets: AssetPlugin, plugins: impl Plugins<M>) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, assets, MeshPlugin, TransformPlugin))
        .add_plugins(plugins)
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1))
        .init_resource::<Assets<Image>>();
    run_in_series(&mut app);
    if std::env::var_os(STAGED).is_some() {
        app.insert_resource(ClothExecution::Staged);
    }
    app.finish();
    app.cleanup();
    app.update();
    app
}

/// Time runs on by this much each frame.
pub fn set_frame(app: &mut App, frame: Duration) {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
}

pub fn updates(app: &mut App, count: usize) {
    for _ in 0..count {
        app.update();
    }
}

/// Runs frames until something holds, at most for a minute.
pub fn wait(app: &mut App, done: impl Fn(&App) -> bool) {
    let start = Instant::now();
    while !done(app) {
        app.update();
        std::thread::sleep(Duration::from_millis(1));
        assert!(start.elapsed() < Duration::from_secs(60), "waited in vain");
    }
}

/// A metre of cloth, 8 x 8.
pub fn sheet() -> Cloth {
    Cloth::sheet(Vec2::ONE, UVec2::splat(8))
}

pub fn spawn(app: &mut App, bundle: impl Bundle) -> Entity {
    app.world_mut().spawn(bundle).id()
}

pub fn simulation(app: &App, entity: Entity) -> &ClothSimulation {
    app.world().get(entity).expect("the cloth runs")
}

pub fn position(app: &App, entity: Entity, particle: usize) -> Vec3 {
    simulation(app, entity).position(particle).expect("there is such a particle")
}

pub fn positions(app: &App, entity: Entity) -> Vec<Vec3> {
    simulation(app, entity).positions().collect()
}

pub fn bits(app: &App, entity: Entity) -> Vec<[u32; 3]> {
    positions(app, entity).iter().map(|p| p.to_array().map(f32::to_bits)).collect()
}

pub fn failure(app: &App, entity: Entity) -> Option<ClothError> {
    app.world().get::<ClothFailure>(entity).map(|failure| failure.error.clone())
}

pub fn transform(app: &mut App, entity: Entity) -> Mut<'_, Transform> {
    app.world_mut().get_mut(entity).expect("it has a transform")
}

pub fn add_mesh(app: &mut App, mesh: Mesh) -> Handle<Mesh> {
    app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
}

/// The mesh that an entity is drawn with.
pub fn drawn(app: &App, entity: Entity) -> &Mesh {
    let handle = app.world().get::<Mesh3d>(entity).expect("it is drawn");
    app.world().resource::<Assets<Mesh>>().get(handle).expect("its mesh is there")
}

pub fn attribute(mesh: &Mesh, which: bevy::mesh::MeshVertexAttribute) -> Vec<Vec3> {
    match mesh.attribute(which) {
        Some(VertexAttributeValues::Float32x3(values)) => {
            values.iter().map(|v| Vec3::from_array(*v)).collect()
        }
        _ => panic!("no such attribute"),
    }
}

/// Where the vertices are drawn, in the world.
pub fn drawn_positions(app: &App, entity: Entity) -> Vec<Vec3> {
    let to_world = *app.world().get::<GlobalTransform>(entity).expect("it has a place");
    let local = attribute(drawn(app, entity), Mesh::ATTRIBUTE_POSITION);
    local.into_iter().map(|p| to_world.transform_point(p)).collect()
}

/// The mean of the particles' velocities.
pub fn mean_velocity(app: &App, entity: Entity) -> Vec3 {
    let cloth = simulation(app, entity);
    let count = cloth.particle_count();
    (0..count).filter_map(|i| cloth.velocity(i)).sum::<Vec3>() / count as f32
}

/// How far apart particles are at most, each from itself \[m\].
pub fn farthest(a: &[Vec3], b: &[Vec3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

/// Counts how often something is told of from now on.
pub fn count_told(app: &mut App) -> Arc<AtomicUsize> {
    let told = Arc::new(AtomicUsize::new(0));
    let count = told.clone();
    app.add_observer(move |_: On<Insert, ClothFailure>| {
        count.fetch_add(1, Ordering::Relaxed);
    });
    told
}
