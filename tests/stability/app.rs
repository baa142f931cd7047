//! Apps without a window, and the cloths in them.

use std::time::Duration;

use bevy::{
    asset::{AssetPlugin, RenderAssetUsages},
    mesh::{Indices, MeshPlugin, PrimitiveTopology},
    prelude::*,
    time::TimeUpdateStrategy,
    transform::TransformPlugin,
};
use bevy_drape::{ClothError, prelude::*};

use crate::outside::ecs::run_in_series;

/// Bevy's fixed step.
pub const TICK: Duration = Duration::from_micros(15625);

/// The bits of all cloths after each tick, in the order in which they were spawned.
#[derive(Resource, Default)]
pub struct Track {
    pub cloths: Vec<Entity>,
    /// A number for all bits of each cloth, tick after tick.
    pub ticks: Vec<Vec<u64>>,
    pub worst: Vec<f32>,
}

/// FNV-1a.
fn hash(places: impl Iterator<Item = Vec3>) -> u64 {
    places
        .flat_map(|p| p.to_array())
        .flat_map(|c| c.to_bits().to_le_bytes())
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
        })
}

fn track(simulations: Query<&ClothSimulation>, mut track: ResMut<Track>) {
    let cloths: Vec<_> =
        track.cloths.iter().filter_map(|&cloth| simulations.get(cloth).ok()).collect();
    for cloth in &cloths {
        assert!(cloth.positions().all(Vec3::is_finite));
    }
    let bits = cloths.iter().map(|cloth| hash(cloth.positions())).collect();
    let worst = cloths.iter().map(|cloth| cloth.strain().max).fold(-1.0, f32::max);
    track.ticks.push(bits);
    track.worst.push(worst);
}

/// An app after its first frame, which runs no tick.
pub fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), MeshPlugin, TransformPlugin))
        .add_plugins(ClothPlugin::default())
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1))
        .init_resource::<Assets<Image>>()
        .init_resource::<Track>()
        .add_systems(FixedLast, track);
    run_in_series(&mut app);
    app.finish();
    app.cleanup();
    app.update();
    app
}

/// Runs a frame of this length.
pub fn frame(app: &mut App, length: Duration) {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(length));
    app.update();
}

pub fn spawn(app: &mut App, bundle: impl Bundle) -> Entity {
    app.world_mut().spawn(bundle).id()
}

/// A cloth that is watched.
pub fn spawn_cloth(app: &mut App, bundle: impl Bundle) -> Entity {
    let cloth = spawn(app, bundle);
    app.world_mut().resource_mut::<Track>().cloths.push(cloth);
    cloth
}

pub fn simulation(app: &App, cloth: Entity) -> &ClothSimulation {
    app.world().get(cloth).expect("the cloth runs")
}

pub fn failure(app: &App, entity: Entity) -> Option<ClothError> {
    app.world().get::<ClothFailure>(entity).map(|failure| failure.error.clone())
}

/// A sheet of a metre with one cell cut out: no lattice.
pub fn holed(app: &mut App, n: u32) -> Mesh3d {
    let place = |i: u32| i as f32 / (n - 1) as f32 - 0.5;
    let positions: Vec<_> = (0..n * n).map(|i| [place(i % n), 0.0, place(i / n)]).collect();
    let mut indices = Vec::new();
    for (r, c) in (0..n - 1).flat_map(|r| (0..n - 1).map(move |c| (r, c))) {
        if (r, c) != (n / 2, n / 2) {
            let (a, below) = (r * n + c, (r + 1) * n + c);
            indices.extend([a, below, a + 1, a + 1, below, below + 1]);
        }
    }
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(indices));
    Mesh3d(app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh))
}

/// The stiffest that is accepted.
pub fn stiffest() -> ClothMaterial {
    ClothMaterial {
        thread_stiffness: 1e15,
        shear_stiffness: 1e15,
        flexural_rigidity: 1e9,
        ..default()
    }
}

/// Spawns a metre of cloth in four ways: a sheet and a mesh, of the default material and of the stiffest.
pub fn spawn_variants(
    app: &mut App,
    n: u32,
    bundle: impl Fn(usize) -> (ClothPins, Transform),
) -> [Entity; 4] {
    [0, 1, 2, 3].map(|i| {
        let material = if i < 2 { ClothMaterial::default() } else { stiffest() };
        let others = (material, bundle(i));
        if i % 2 == 0 {
            spawn_cloth(app, (Cloth::sheet(Vec2::ONE, UVec2::splat(n)), others))
        } else {
            let mesh = holed(app, n);
            spawn_cloth(app, (Cloth::of_mesh3d(), mesh, others))
        }
    })
}
