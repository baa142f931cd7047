//! Avian's bodies and cloths: a hammock catches what is thrown, a curtain stops it, a crate hangs in a sling. Pull at all of
//! them with the mouse.
//!
//! `cargo run --example avian --features demo,avian`
//!
//! Beside the engine, `AvianClothPlugin` and `ClothCollider` are all there is to it.

use avian3d::prelude::*;
use bevy::prelude::*;
use bevy_drape::prelude::*;
use examples_common::{
    Example, View,
    bodies::{Held, Shape, Thing, add_bodies},
};

/// What is told of the example, and where its cloths are at the end.
pub const AVIAN: Example = Example {
    name: "avian",
    about: "A hammock, a curtain and a sling, and the bodies of Avian that they carry",
    scene,
    view: View { from: Vec3::new(0.45, 2.3, 4.6), at: Vec3::new(0.12, 0.85, 0.0) },
    bounds: [[-2.0, 0.0, -1.8], [2.5, 2.0, 1.8]],
};

#[cfg(feature = "demo")]
fn main() -> AppExit {
    AVIAN.show_with(examples_common::bodies::hold_by_mouse)
}

fn scene(app: &mut App) {
    app.add_plugins((PhysicsPlugins::default(), AvianClothPlugin::default()))
        .add_observer(embody)
        .add_systems(FixedUpdate, follow);
    add_bodies(app);
}

/// Gives a thing its body, which cloths meet.
fn embody(added: On<Add, Thing>, things: Query<&Thing>, mut commands: Commands) -> Result {
    let thing = things.get(added.entity)?;
    let collider = match thing.shape {
        Shape::Ground => Collider::half_space(Vec3::Y),
        Shape::Ball(ball) => Collider::sphere(ball.radius),
        Shape::Crate(Cuboid { half_size: half }) => {
            Collider::cuboid(2.0 * half.x, 2.0 * half.y, 2.0 * half.z)
        }
        Shape::Post(post) => Collider::cylinder(post.radius, 2.0 * post.half_height),
    };
    let mut body = commands.entity(added.entity);
    body.insert((collider, ClothCollider::default()));
    match thing.throw {
        None => body.insert(RigidBody::Static),
        Some(throw) => body.insert((
            RigidBody::Dynamic,
            Mass(throw.mass),
            LinearVelocity(throw.velocity),
            AngularVelocity(throw.spin),
            AngularDamping(2.0),
        )),
    };
    Ok(())
}

/// What the mouse holds follows it.
fn follow(mut held: Query<(&Held, &Position, &mut LinearVelocity)>) {
    for (held, place, mut velocity) in &mut held {
        velocity.0 = held.velocity(place.0);
    }
}
