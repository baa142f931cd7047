//! A character of a glTF file that walks and sprints, in a skirt that is cloth.
//!
//! `cargo run --example skirt --features demo`
//!
//! The file is `assets/character.glb`; the example `character` wrote it. Its skirt is skinned to hips and thighs, and red is painted
//! where it is free. Two components make it cloth: `ClothSkin` on the skirt, `ClothBody` on the character.

use bevy::{gltf::GltfMeshName, prelude::*, world_serialization::WorldInstanceReady};
use bevy_drape::{
    ClothBody, ClothInterpolation, ClothSkin, ColorChannel, SkinBackstop, SkinMap, prelude::*,
};
use examples_common::{Awaited, Example, View, add_gltf, ground};

/// What is told of the example, and where its cloths are at the end.
pub const SKIRT: Example = Example {
    name: "skirt",
    about: "A glTF character that walks and sprints, in a skirt",
    scene,
    view: View { from: Vec3::new(0.3, 1.35, 4.3), at: Vec3::new(0.0, 0.8, 0.0) },
    bounds: [[-2.6, 0.1, -2.6], [2.6, 1.6, 2.6]],
};

fn main() -> AppExit {
    SKIRT.show()
}

fn scene(app: &mut App) {
    add_gltf(app);
    app.add_systems(Startup, spawn).add_systems(FixedUpdate, walk).add_systems(Update, animate);
}

/// The file.
const CHARACTER: &str = "character.glb";
/// Speeds that its animations are made for \[m/s\].
const WALK: f32 = 1.3;
const SPRINT: f32 = 4.0;
/// Radius of the circle \[m\].
const CIRCLE: f32 = 1.4;

/// A character that walks.
#[derive(Component, Default)]
pub struct Walker {
    /// How far it has come \[m\].
    pub way: f32,
    /// How fast it is \[m/s\].
    pub speed: f32,
}

/// The animations of a walk and a sprint, and who walks.
#[derive(Component)]
pub struct Gaits {
    clips: [AnimationNodeIndex; 2],
    walker: Entity,
}

/// Spawns the character; its skirt becomes cloth as soon as it is there.
fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, assets: Res<AssetServer>) {
    commands.spawn(ground(&mut meshes));
    spawn_character(&mut commands, &assets, (Walker::default(), place(0.0)));
}

/// Spawns a character that walks.
pub fn spawn_character(commands: &mut Commands, assets: &AssetServer, walker: impl Bundle) {
    commands
        .spawn((
            WorldAssetRoot(assets.load(GltfAssetLabel::Scene(0).from_asset(CHARACTER))),
            walker,
            // Time begins when it is there.
            Awaited,
            // Capsules on its joints, that fit themselves to its skin.
            ClothBody { friction: 0.2, ..default() },
        ))
        .observe(dress)
        .observe(start);
}

/// Makes the skirt cloth.
fn dress(
    ready: On<WorldInstanceReady>,
    children: Query<&Children>,
    meshes: Query<(Entity, &GltfMeshName)>,
    mut commands: Commands,
) {
    let parts = meshes.iter_many(children.iter_descendants(ready.entity));
    for (skirt, _) in parts.filter(|(_, name)| name.0 == "skirt") {
        commands.entity(skirt).insert((
            Cloth::of_mesh3d(),
            ClothSkin {
                // The waistband is held, the hem may go 30 cm away.
                max_distance: SkinMap::color(ColorChannel::Red, 0.0, 0.3),
                // Nothing goes more than 10 cm into where the skirt would be.
                backstop: Some(SkinBackstop { distance: 0.1.into(), ..default() }),
                drive: 6.0.into(),
                ..default()
            },
            ClothMaterial { area_density: 0.25, thickness: 0.01, friction: 0.2, ..default() },
            ClothAir::default(),
            ClothInterpolation::LastTick,
        ));
    }
}

/// Starts the animations.
fn start(
    ready: On<WorldInstanceReady>,
    children: Query<&Children>,
    mut players: Query<&mut AnimationPlayer>,
    assets: Res<AssetServer>,
    mut graphs: ResMut<Assets<AnimationGraph>>,
    mut commands: Commands,
) {
    let clip = |index| assets.load(GltfAssetLabel::Animation(index).from_asset(CHARACTER));
    let (graph, gaits) = AnimationGraph::from_clips([clip(0), clip(1)]);
    let graph = graphs.add(graph);
    for part in children.iter_descendants(ready.entity) {
        if let Ok(mut player) = players.get_mut(part) {
            for gait in &gaits {
                player.play(*gait).repeat();
            }
            let gaits = Gaits { clips: [gaits[0], gaits[1]], walker: ready.entity };
            commands.entity(part).insert((AnimationGraphHandle(graph.clone()), gaits));
        }
    }
    commands.entity(ready.entity).remove::<Awaited>();
}

/// Where the character is on its circle.
fn place(way: f32) -> Transform {
    let (sin, cos) = (way / CIRCLE).sin_cos();
    Transform::from_translation(CIRCLE * Vec3::new(cos, 0.0, sin))
        .looking_to(Vec3::new(-sin, 0.0, cos), Vec3::Y)
}

/// Stands for half a second, walks for four, then sprints and walks in turn.
fn walk(mut walkers: Query<(&mut Walker, &mut Transform)>, time: Res<Time>) {
    for (mut walker, mut transform) in &mut walkers {
        let wanted = match time.elapsed_secs() {
            t if t < 0.5 => 0.0,
            t if (t - 0.5) % 6.5 < 4.0 => WALK,
            _ => SPRINT,
        };
        let most = 6.0 * time.delta_secs();
        walker.speed += (wanted - walker.speed).clamp(-most, most);
        walker.way += walker.speed * time.delta_secs();
        *transform = place(walker.way);
    }
}

/// Plays the animations as fast as each character goes, and as much of each.
pub fn animate(walkers: Query<&Walker>, mut players: Query<(&mut AnimationPlayer, &Gaits)>) {
    for (mut player, Gaits { clips: [walk, sprint], walker }) in &mut players {
        let Ok(&Walker { speed, .. }) = walkers.get(*walker) else { continue };
        // One cycle for both: in between, steps are as long as each has its part.
        let sprints = ((speed - WALK) / (SPRINT - WALK)).clamp(0.0, 1.0);
        for (gait, weight, usual) in [(walk, 1.0 - sprints, WALK), (sprint, sprints, SPRINT)] {
            if let Some(gait) = player.animation_mut(*gait) {
                gait.set_weight(weight).set_speed(speed / usual);
            }
        }
    }
}
