//! One and eight threads. Truth: bit equality. One, two and four threads, and forms: `tests/ecs/execution.rs`;
//! instruction sets: `tests/solver/determinism.rs` and `graph_determinism.rs`.

use crate::support::{app::*, bits::Fingerprint};
use bevy::{
    asset::AssetPlugin, mesh::MeshPlugin, prelude::*, time::TimeUpdateStrategy,
    transform::TransformPlugin,
};
use bevy_drape::{ColliderImpulse, prelude::*, solver::Gusts};

/// Thirty sheets and meshes in gusts, over colliders that move, held hard, softly and not at all: the bits of
/// all their positions, folded.
fn scene(app: &mut App) -> u64 {
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    let gusts = Gusts { strength: 4.0, seed: 3, ..default() };
    app.insert_resource(ClothWind::steady(Vec3::new(2.0, 0.0, 1.0)).with_gusts(gusts));
    app.add_systems(FixedUpdate, |mut solids: Query<&mut Transform, With<SdfCollider>>| {
        for mut transform in &mut solids {
            transform.rotate_y(0.02);
        }
    });
    spawn(app, (SdfCollider::from(Cuboid::new(0.8, 0.4, 0.5)), ColliderImpulse::default()));
    let hand = spawn(app, Transform::from_xyz(0.0, 0.6, 0.0));
    let mesh = add_mesh(app, holed_mesh());
    let cloths: Vec<_> = (0..30_u32)
        .map(|i| {
            let material =
                ClothMaterial { thread_stiffness: [20.0, 2e3, 1e15][i as usize % 3], ..default() };
            let pins = match i % 4 {
                0 => ClothPins::none(),
                1 => ClothPins::vertices([0, 7]),
                2 => ClothPins::vertices([3]).anchored_to(hand),
                _ => ClothPins::vertices([5]).softly(50.0, 0.1),
            };
            let place = Transform::from_xyz((i % 5) as f32 * 0.1, 0.6, 0.0);
            let more = (material, pins, place, ClothAir::default());
            if i % 2 == 0 {
                spawn(app, (Cloth::sheet(Vec2::ONE, UVec2::new(6 + i % 7, 15 - i % 5)), more))
            } else {
                spawn(app, (Cloth::of_mesh3d(), Mesh3d(mesh.clone()), more))
            }
        })
        .collect();
    updates(app, 640);
    let bits: Vec<_> = cloths.iter().flat_map(|cloth| bits(app, *cloth)).collect();
    Fingerprint::of(&bits)
}

#[test]
fn h24_one_and_eight_threads_give_the_same_bits() {
    let name = "pool::h24_one_and_eight_threads_give_the_same_bits";
    let plugins = |app: &mut App| {
        let cloth = ClothPlugin::default();
        app.add_plugins((AssetPlugin::default(), MeshPlugin, TransformPlugin, cloth));
    };
    let Some(bits) = in_pools(name, &[1, 8], plugins, |app| scene(app).to_string()) else {
        return;
    };
    assert_eq!(bits[0], bits[1]);
}
