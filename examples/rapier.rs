//! Rapier's bodies and cloths: a hammock catches what is thrown, a curtain stops it, a crate hangs in a sling. Pull at all of
//! them with the mouse.
//!
//! `cargo run --example rapier --features demo,rapier`
//!
//! Beside the engine, `RapierClothPlugin` and `ClothCollider` are all there is to it. In a fixed schedule cloths move bodies.

use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_rapier3d::prelude::*;
use examples_common::{
    Example, View,
    bodies::{Held, Shape, Thing, add_bodies},
};

/// What is told of the example, and where its cloths are at the end.
pub const RAPIER: Example = Example {
    name: "rapier",
    about: "A hammock, a curtain and a sling, and the bodies of Rapier that they carry",
    scene,
    view: View { from: Vec3::new(0.45, 2.3, 4.6), at: Vec3::new(0.12, 0.85, 0.0) },
    bounds: [[-2.0, 0.0, -1.8], [2.5, 2.0, 1.8]],
};

#[cfg(feature = "demo")]
fn main() -> AppExit {
    RAPIER.show_with(examples_common::bodies::hold_by_mouse)
}

fn scene(app: &mut App) {
    let physics = RapierPhysicsPlugin::<NoUserData>::default().in_fixed_schedule();
    app.add_plugins((physics, RapierClothPlugin::default()))
        .add_observer(embody)
        .add_systems(FixedPreUpdate, follow);
    add_bodies(app);
}

/// Gives a thing its body, which cloths meet.
fn embody(added: On<Add, Thing>, things: Query<&Thing>, mut commands: Commands) -> Result {
    let thing = things.get(added.entity)?;
    let collider = match thing.shape {
        Shape::Ground => Collider::halfspace(Vec3::Y).ok_or("its normal has a length")?,
        Shape::Ball(ball) => Collider::ball(ball.radius),
        Shape::Crate(Cuboid { half_size: half }) => Collider::cuboid(half.x, half.y, half.z),
        Shape::Post(post) => Collider::cylinder(post.half_height, post.radius),
    };
    let mut body = commands.entity(added.entity);
    body.insert((collider, ClothCollider::default()));
    match thing.throw {
        None => body.insert(RigidBody::Fixed),
        Some(throw) => body.insert((
            RigidBody::Dynamic,
            ColliderMassProperties::Mass(throw.mass),
            Velocity { linear: throw.velocity, angular: throw.spin },
            Damping { linear_damping: 0.0, angular_damping: 2.0 },
        )),
    };
    Ok(())
}

/// What the mouse holds follows it.
fn follow(mut held: Query<(&Held, &Transform, &mut Velocity)>) {
    for (held, place, mut velocity) in &mut held {
        velocity.linear = held.velocity(place.translation);
    }
}
