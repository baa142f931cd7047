//! A cloth that lies on ten primitives: what it costs that they are bodies, and that they are an engine's.

use crate::{
    app::{app_with, compare},
    turns::{Bound, Wrong, heading, line},
};
use bevy::prelude::*;
use bevy_drape::{ClothSleepThreshold, ColliderMass, prelude::*};

/// Kinds of primitives that the cloth lies on.
#[derive(Clone, Copy)]
pub enum Primitive {
    Ball(f32),
    Cube(f32),
    Capsule { radius: f32, half_length: f32 },
    Cylinder { radius: f32, height: f32 },
    Cone { radius: f32, height: f32 },
}

impl Primitive {
    /// As one places it by hand.
    pub fn collider(self) -> SdfCollider {
        match self {
            Self::Ball(radius) => Sphere::new(radius).into(),
            Self::Cube(side) => Cuboid::from_length(side).into(),
            Self::Capsule { radius, half_length } => {
                let end = Vec3::Y * half_length;
                SdfCollider::capsule_between(-end, end, radius)
            }
            Self::Cylinder { radius, height } => Cylinder::new(radius, height).into(),
            Self::Cone { radius, height } => Cone { radius, height }.into(),
        }
    }
}

/// Ten of them under a sheet of 2 m.
pub fn ten() -> impl Iterator<Item = (Primitive, Transform)> {
    let kinds = [
        Primitive::Ball(0.18),
        Primitive::Cube(0.3),
        Primitive::Capsule { radius: 0.12, half_length: 0.06 },
        Primitive::Cylinder { radius: 0.15, height: 0.3 },
        Primitive::Cone { radius: 0.18, height: 0.36 },
    ];
    (0..10).map(move |i| {
        let place = Vec3::new((i % 5) as f32 * 0.4 - 0.8, 0.0, (i / 5) as f32 - 0.5);
        (kinds[i % 5], Transform::from_translation(place))
    })
}

/// Lays a sheet of 2 m over them.
pub fn lay(app: &mut App, particles: u32) {
    let cloth = Cloth::sheet(Vec2::splat(2.0), UVec2::splat(particles));
    let above = Transform::from_xyz(0.0, 0.25, 0.0);
    app.world_mut().spawn((cloth, ClothSleepThreshold::NEVER, above));
    (0..64).for_each(|_| app.update());
}

pub fn bodies(n: u32, rounds: usize, wrong: &mut Wrong) {
    heading("on ten primitives, us an update", "without", "with");
    let pair = || {
        [false, true].map(|moves| {
            let mut app = app_with(false, ());
            for (primitive, place) in ten() {
                let mut solid = app.world_mut().spawn((primitive.collider(), place));
                if moves {
                    solid.insert(ColliderMass::sphere(1.0, 0.2));
                }
            }
            lay(&mut app, n);
            app
        })
    };
    let name = "ColliderMass, of what stands still";
    line(name, &compare(name, rounds, pair, false, wrong), Bound::Percent(10.0));
}
