//! The app that the tests run, and how they look at it.

use bevy::{
    app::{Plugins, TaskPoolOptions, TaskPoolPlugin, TaskPoolThreadAssignmentPolicy},
    asset::{AssetPlugin, RenderAssetUsages},
    mesh::{Indices, MeshPlugin, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
    tasks::ComputeTaskPool,
    time::TimeUpdateStrategy,
    transform::TransformPlugin,
};
use bevy_drape::{ClothError, ClothExecution, prelude::*};
use std::{
    path::Path,
    process::Command,
    time::{Duration, Instant},
};

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

/// A grid of quads with its vertices renamed by `name`, in the places that `place` gives to its rows and
/// columns.
pub fn grid_mesh(
    rows: u32,
    columns: u32,
    name: impl Fn(u32) -> u32,
    place: impl Fn(u32, u32) -> Vec3,
) -> Mesh {
    let mut positions = vec![[0.0; 3]; (rows * columns) as usize];
    for r in 0..rows {
        for c in 0..columns {
            positions[name(r * columns + c) as usize] = place(r, c).to_array();
        }
    }
    let mut indices = Vec::new();
    for r in 0..rows - 1 {
        for c in 0..columns - 1 {
            let a = r * columns + c;
            let (b, below, d) = (a + 1, a + columns, a + columns + 1);
            indices.extend([a, below, b, b, below, d].map(&name));
        }
    }
    triangle_mesh(positions, indices)
}

/// A metre of cloth, 8 x 8 as the sheet, with one cell cut out: no grid.
pub fn holed_mesh() -> Mesh {
    let place = |r: u32, c: u32| Vec3::new(c as f32 / 7.0 - 0.5, 0.0, r as f32 / 7.0 - 0.5);
    let mut mesh = grid_mesh(8, 8, |v| v, place);
    let Some(Indices::U32(indices)) = mesh.indices_mut() else { panic!("it has indices") };
    indices.drain(6 * 24..6 * 25);
    mesh
}

pub fn triangle_mesh(positions: Vec<[f32; 3]>, indices: Vec<u32>) -> Mesh {
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(indices))
}

/// A closed box around the origin.
pub fn box_mesh(half: f32) -> Mesh {
    let corner = |i: u32| [1, 2, 4].map(|bit| if i & bit == 0 { -half } else { half });
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    triangle_mesh((0..8).map(corner).collect(), indices)
}

/// Set in the processes that [`in_pools`] starts.
pub const POOL: &str = "BEVY_DRAPE_TEST_POOL";

/// What a scene comes to in compute pools of each size. A process has one pool for good, so each size has a
/// process of its own: the test of this name again, with a variable set. There it is `None`.
#[allow(clippy::print_stdout)]
pub fn in_pools(
    name: &str,
    sizes: &[usize],
    plugins: impl Fn(&mut App),
    scene: impl Fn(&mut App) -> String,
) -> Option<Vec<String>> {
    if let Ok(size) = std::env::var(POOL) {
        let size = size.parse().unwrap();
        let mut app = app_of_pool(size);
        plugins(&mut app);
        app.insert_resource(ClothExecution::Fused);
        app.finish();
        app.cleanup();
        app.update();
        assert_eq!(ComputeTaskPool::get().thread_num(), size);
        println!("bits {}", scene(&mut app));
        return None;
    }
    let bits = sizes.iter().map(|size| {
        let output = Command::new(std::env::current_exe().unwrap())
            .args([name, "--exact", "--nocapture"])
            .env(POOL, size.to_string())
            .output()
            .unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let line =
            text.lines().find_map(|line| line.split_once("bits ")).map(|(_, bits)| bits.to_owned());
        line.unwrap_or_else(|| panic!("{text}"))
    });
    Some(bits.collect())
}

fn app_of_pool(size: usize) -> App {
    let exactly = TaskPoolThreadAssignmentPolicy {
        min_threads: size,
        max_threads: size,
        percent: 1.0,
        on_thread_spawn: None,
        on_thread_destroy: None,
    };
    let task_pool_options =
        TaskPoolOptions { max_total_threads: 16, compute: exactly, ..default() };
    let mut app = App::new();
    app.add_plugins(MinimalPlugins.set(TaskPoolPlugin { task_pool_options }));
    app
}
