//! A hundred characters of a glTF file in skirts that are cloth, of which few are seen at a time.
//!
//! `cargo run --release --example crowd --features demo,simplify`
//!
//! They walk around the camera, which turns. A skirt that no view sees stands still (`ClothCulling`), one that is far away does
//! less with a quarter of its particles (`ClothLod`, `ClothProxy`), and if all of them take longer than 4 ms a frame, the furthest do less still (`ClothBudget`).

use bevy::prelude::*;
use bevy_drape::{ClothBudget, ClothCulling, ClothLevel, ClothLod, ClothProxy, prelude::*};
use examples_common::{Caption, Example, View, add_gltf, ground};

// As one of them is dressed there.
#[allow(dead_code)]
#[path = "skirt.rs"]
mod skirt;

use skirt::{Walker, animate, spawn_character};

const CROWD: Example = Example {
    name: "crowd",
    about: "A hundred glTF characters in skirts, of which few are seen at a time",
    scene,
    view: View { from: Vec3::new(0.0, 1.6, 0.0), at: Vec3::new(0.0, 1.0, -5.0) },
    bounds: [[-13.0, 0.1, -13.0], [13.0, 1.6, 13.0]],
};

fn main() -> AppExit {
    CROWD.show()
}

/// Circles that they walk on, and how many on each.
const CIRCLES: usize = 5;
const ON_CIRCLE: usize = 20;
/// Radius of a circle \[m\].
fn radius(circle: usize) -> f32 {
    4.5 + 1.6 * circle as f32
}
/// How fast they walk \[m/s\], and how fast the camera turns \[rad/s\].
const SPEED: f32 = 1.3;
const TURN: f32 = 0.25;

fn scene(app: &mut App) {
    add_gltf(app);
    app.insert_resource(ClothBudget::new(4.0))
        .add_systems(Startup, spawn)
        .add_systems(FixedUpdate, walk)
        .add_systems(Update, (animate, spare, turn, tell));
}

/// The circle that someone walks on, and where on it they began \[rad\].
#[derive(Component, Clone, Copy)]
struct Circle(usize, f32);

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, assets: Res<AssetServer>) {
    commands.spawn(ground(&mut meshes));
    for i in 0..CIRCLES * ON_CIRCLE {
        let (circle, number) = (i % CIRCLES, i / CIRCLES);
        let start =
            (number as f32 + 0.37 * circle as f32) / ON_CIRCLE as f32 * core::f32::consts::TAU;
        let circle = Circle(circle, start);
        spawn_character(&mut commands, &assets, (Walker::default(), circle, circle.place(0.0)));
    }
}

impl Circle {
    fn place(self, way: f32) -> Transform {
        let Self(circle, start) = self;
        let (sin, cos) = (start + way / radius(circle)).sin_cos();
        Transform::from_translation(radius(circle) * Vec3::new(cos, 0.0, sin))
            .looking_to(Vec3::new(-sin, 0.0, cos), Vec3::Y)
    }
}

fn walk(mut walkers: Query<(&mut Walker, &Circle, &mut Transform)>, time: Res<Time>) {
    for (mut walker, circle, mut transform) in &mut walkers {
        walker.speed = SPEED;
        walker.way += SPEED * time.delta_secs();
        *transform = circle.place(walker.way);
    }
}

/// Lets a skirt that is new do no more than is seen of it.
fn spare(skirts: Query<Entity, Added<Cloth>>, mut commands: Commands) {
    for skirt in &skirts {
        commands.entity(skirt).insert((
            ClothCulling::default(),
            ClothLod {
                levels: vec![
                    ClothLevel::at(6.0).substeps(10),
                    ClothLevel::at(9.0).substeps(6).proxy(ClothProxy::ratio(0.25)),
                ],
                ..default()
            },
        ));
    }
}

fn turn(mut cameras: Query<&mut Transform, With<Camera3d>>, time: Res<Time<Virtual>>) {
    for mut camera in &mut cameras {
        camera.rotation = Quat::from_rotation_y(TURN * time.elapsed_secs());
    }
}

fn tell(budget: Res<ClothBudget>, mut caption: ResMut<Caption>) {
    let Some((culled, levels)) = budget.cloths.split_last() else { return };
    caption.0 = vec![format!(
        "{levels:?} at levels 0, 1, 2, {culled} unseen, {} raised; {:.1} ms",
        budget.raised, budget.measured
    )];
}
