//! A cloth comes down on a table, and after some seconds is pulled away by its hem.
//!
//! `cargo run --example tablecloth --features demo`
//!
//! What pulls is an anchor: pins that are added to a running cloth take hold of it where it is by then.

use bevy::prelude::*;
use bevy_drape::prelude::*;
use examples_common::{CORAL, Example, IVORY, Particles, View, clay, ground, linen};

/// What is told of the example, and where its cloths are at the end.
pub const TABLECLOTH: Example = Example {
    name: "tablecloth",
    about: "A cloth comes down on a table, and is pulled away",
    scene,
    view: View { from: Vec3::new(1.75, 1.55, 2.75), at: Vec3::new(0.05, 0.42, 0.2) },
    bounds: [[-1.5, 0.0, -1.5], [1.5, 1.6, 5.0]],
};

fn main() -> AppExit {
    TABLECLOTH.show()
}

fn scene(app: &mut App) {
    app.add_systems(Startup, spawn).add_systems(FixedUpdate, pull);
}

/// Height of the table, radius and thickness of its top \[m\].
const HEIGHT: f32 = 0.75;
const RADIUS: f32 = 0.55;
const THICKNESS: f32 = 0.04;

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    // Top, leg and foot: a solid of several parts is several colliders.
    let top = Cylinder::new(RADIUS, THICKNESS);
    let leg = Cylinder::new(0.05, HEIGHT - THICKNESS);
    let foot = Cylinder::new(0.28, 0.03);
    for (part, height, resolution) in [
        (top, HEIGHT - 0.5 * THICKNESS, 128),
        (leg, leg.half_height, 64),
        (foot, foot.half_height, 64),
    ] {
        commands.spawn((
            SdfCollider::from(part),
            Mesh3d(meshes.add(part.mesh().resolution(resolution))),
            Transform::from_translation(Vec3::Y * height),
            clay(IVORY),
        ));
    }
    commands.spawn((Hand { holds: false }, Transform::default()));
    commands.spawn((
        Cloth::sheet(Vec2::splat(1.7), UVec2::splat(particles.0)),
        // Cotton on polished wood. As thick as that, it goes round the edge, on which its particles would catch.
        ClothMaterial { friction: 0.05, thickness: 0.012, ..ClothMaterial::COTTON },
        Transform::from_translation(Vec3::Y * (HEIGHT + 0.15)),
        linen(CORAL),
    ));
}

/// What pulls the cloth.
#[derive(Component)]
struct Hand {
    holds: bool,
}

/// When the cloth is pulled \[s\], and how fast the hand goes \[m/s\] for how long \[s\].
const PULLED: f32 = 3.5;
const SPEED: f32 = 1.6;
const DURATION: f32 = 1.5;

/// The hand takes the hem where it is by then, goes, and lets go.
fn pull(
    hand: Single<(Entity, &mut Hand, &mut Transform)>,
    mut cloths: Query<&mut ClothPins>,
    time: Res<Time>,
) {
    let (entity, mut hand, mut place) = hand.into_inner();
    let holds = (0.0..DURATION).contains(&(time.elapsed_secs() - PULLED));
    if holds {
        place.translation += SPEED * time.delta_secs() * Vec3::new(0.0, 0.15, 1.0);
    }
    if hand.holds != holds {
        hand.holds = holds;
        for mut pins in &mut cloths {
            let hem = ClothPins::from(PinSelection::LastRow).anchored_to(entity);
            *pins = if holds { hem } else { ClothPins::none() };
        }
    }
}
