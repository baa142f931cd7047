//! Apps without a window, and the cloths in them.

use std::time::Duration;

use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_drape::prelude::*;

pub use crate::support::app::{TICK, add_mesh, app_with, failure, mesh_without, simulation, spawn};
use crate::support::bits::Fingerprint;

/// The bits of all cloths after each tick, in the order in which they were spawned.
#[derive(Resource, Default)]
pub struct Track {
    pub cloths: Vec<Entity>,
    /// A number for all bits of each cloth, tick after tick.
    pub ticks: Vec<Vec<u64>>,
    pub worst: Vec<f32>,
}

fn track(simulations: Query<&ClothSimulation>, mut track: ResMut<Track>) {
    let cloths: Vec<_> =
        track.cloths.iter().filter_map(|&cloth| simulations.get(cloth).ok()).collect();
    for cloth in &cloths {
        assert!(cloth.positions().all(Vec3::is_finite));
    }
    let fingerprint = |cloth: &&ClothSimulation| {
        let bits: Vec<_> = cloth.positions().map(|p| p.to_array().map(f32::to_bits)).collect();
        Fingerprint::of(&bits)
    };
    let bits = cloths.iter().map(fingerprint).collect();
    let worst = cloths.iter().map(|cloth| cloth.strain().max).fold(-1.0, f32::max);
    track.ticks.push(bits);
    track.worst.push(worst);
}

/// An app that keeps a track, after its first frame, which runs no tick.
pub fn app() -> App {
    let track = |app: &mut App| _ = app.init_resource::<Track>().add_systems(FixedLast, track);
    app_with((ClothPlugin::default(), track))
}

/// Runs a frame of this length.
pub fn frame(app: &mut App, length: Duration) {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(length));
    app.update();
}

/// A cloth that is watched.
pub fn spawn_cloth(app: &mut App, bundle: impl Bundle) -> Entity {
    let cloth = spawn(app, bundle);
    app.world_mut().resource_mut::<Track>().cloths.push(cloth);
    cloth
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
            let mesh = Mesh3d(add_mesh(app, mesh_without(n, [n / 2; 2])));
            spawn_cloth(app, (Cloth::of_mesh3d(), mesh, others))
        }
    })
}
