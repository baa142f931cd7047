//! A scene for physics engines: things are thrown into a hammock and against a curtain, and a crate hangs in a sling.
//!
//! The engine is the example's own. It gives each [`Thing`] a body, and lets what is [`Held`] follow the mouse.

use crate::{BRASS, CORAL, INDIGO, IVORY, Look, Particles, TEAL, clay, ground, linen, metal};
use bevy::{mesh::VertexAttributeValues, prelude::*};
use bevy_drape::{ClothInterpolation, prelude::*};
use std::f32::consts::{FRAC_PI_2, TAU};

/// What an engine gives a body.
#[derive(Component, Clone, Copy)]
pub struct Thing {
    /// Its shape.
    pub shape: Shape,
    /// How it is thrown; `None` if it stands.
    pub throw: Option<Throw>,
}

/// The shape of a thing.
#[derive(Clone, Copy)]
pub enum Shape {
    /// All below y = 0.
    Ground,
    /// A ball.
    Ball(Sphere),
    /// A box.
    Crate(Cuboid),
    /// A post, or a bar.
    Post(Cylinder),
}

/// How a thing is thrown.
#[derive(Clone, Copy)]
pub struct Throw {
    /// Its mass \[kg\].
    pub mass: f32,
    /// Its velocity at the start \[m/s\].
    pub velocity: Vec3,
    /// Its angular velocity \[rad/s\].
    pub spin: Vec3,
}

/// Is on a thing that the mouse holds: to where it pulls it \[m\].
#[derive(Component, Clone, Copy)]
pub struct Held(pub Vec3);

impl Held {
    /// The velocity that takes a thing there \[m/s\].
    pub fn velocity(&self, place: Vec3) -> Vec3 {
        (8.0 * (self.0 - place)).clamp_length_max(6.0)
    }
}

/// The middle of the hammock, between the bars that hold it, and its extent \[m\].
pub const HAMMOCK: Vec3 = Vec3::new(-0.95, 1.15, 0.25);
/// Length and width of the hammock, and how deep it hangs \[m\].
const HAMMOCK_SIZE: Vec3 = Vec3::new(1.7, 0.45, 1.0);
/// Height and depth of the beam that curtain and crate hang from, and where it begins and ends \[m\].
const BEAM: f32 = 1.95;
const BEAM_Z: f32 = -0.35;
const BEAM_X: [f32; 2] = [0.2, 2.15];
/// Where along the beam the curtain is, and its size \[m\].
const CURTAIN: f32 = 1.5;
const CURTAIN_SIZE: Vec2 = Vec2::new(1.0, 1.65);
/// Where the crate is, its size \[m\] and mass \[kg\].
const CRATE: Vec3 = Vec3::new(0.58, 0.95, BEAM_Z);
const CRATE_SIZE: Vec3 = Vec3::new(0.36, 0.28, 0.28);
const CRATE_MASS: f32 = 5.0;

/// How many things are thrown, and one in how many seconds.
pub const THROWN: usize = 16;
const EVERY: f32 = 0.8;

/// Adds the scene. The engine and its plugin for cloths are added beside it.
pub fn add_bodies(app: &mut App) {
    app.add_systems(Startup, (spawn_hammock, spawn_beam, spawn_curtain, spawn_crate))
        .add_systems(FixedPreUpdate, throw);
}

impl Shape {
    fn mesh(self) -> Mesh {
        match self {
            Self::Ground => Plane3d::default().into(),
            Self::Ball(ball) => ball.into(),
            Self::Crate(cuboid) => cuboid.into(),
            Self::Post(post) => post.into(),
        }
    }
}

/// A thing that can be seen.
fn thing(shape: Shape, throw: Option<Throw>, look: Look, meshes: &mut Assets<Mesh>) -> impl Bundle {
    (Thing { shape, throw }, Mesh3d(meshes.add(shape.mesh())), look)
}

/// A post that stands on the ground, or another cylinder.
fn post(radius: f32, height: f32, meshes: &mut Assets<Mesh>) -> impl Bundle {
    thing(Shape::Post(Cylinder::new(radius, height)), None, metal(BRASS), meshes)
}

/// A grid of particles, where `place` puts them: given how far across and along they are, from 0 to 1.
fn bent(particles: u32, place: impl Fn(Vec2) -> Vec3) -> Mesh {
    let mut mesh = Plane3d::default().mesh().size(1.0, 1.0).subdivisions(particles - 2).build();
    if let Some(VertexAttributeValues::Float32x3(places)) =
        mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION)
    {
        for at in places {
            *at = place(Vec2::new(at[0], at[2]) + 0.5).to_array();
        }
    }
    mesh
}

/// A cloth between two bars, on two posts.
fn spawn_hammock(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    particles: Res<Particles>,
) {
    let ground = ground(&mut meshes);
    commands.spawn((ground, Thing { shape: Shape::Ground, throw: None }));
    let half = 0.5 * HAMMOCK_SIZE;
    for side in [-1.0, 1.0] {
        let bar = HAMMOCK + Vec3::X * side * (half.x + 0.03);
        let along_z = Quat::from_rotation_x(FRAC_PI_2);
        commands.spawn((
            post(0.015, HAMMOCK_SIZE.z + 0.1, &mut meshes),
            Transform::from_translation(bar).with_rotation(along_z),
        ));
        let height = HAMMOCK.y + 0.1;
        let foot = (bar + Vec3::X * side * 0.045).with_y(0.5 * height);
        commands.spawn((post(0.03, height, &mut meshes), Transform::from_translation(foot)));
    }
    // Its sides are shorter than its middle, so that nothing rolls off.
    let hammock = bent(particles.0, |at| {
        let side = 2.0 * at - 1.0;
        let deep = (1.0 - side.x * side.x) * (1.0 - 0.6 * side.y * side.y);
        Vec3::new(half.x * side.x, -HAMMOCK_SIZE.y * deep, half.z * side.y)
    });
    let ends = Vec3::new(half.x - 1e-3, 1.0, 1.0);
    let pins = ClothPins::within(-Vec3::ONE, ends * Vec3::new(-1.0, 1.0, 1.0))
        .and(ClothPins::within(ends * Vec3::new(1.0, -1.0, -1.0), Vec3::ONE));
    commands.spawn((
        Cloth::of_mesh3d(),
        // As the bodies, which are drawn where the last tick took them.
        ClothInterpolation::LastTick,
        Mesh3d(meshes.add(hammock)),
        ClothMaterial { area_density: 0.3, drag: 0.5, ..ClothMaterial::CANVAS },
        pins,
        Transform::from_translation(HAMMOCK),
        linen(TEAL),
    ));
}

fn spawn_beam(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
    let [from, to] = BEAM_X;
    for x in BEAM_X {
        let foot = Vec3::new(x, 0.5 * BEAM, BEAM_Z);
        commands.spawn((post(0.03, BEAM, &mut meshes), Transform::from_translation(foot)));
    }
    commands.spawn((
        post(0.02, to - from, &mut meshes),
        Transform::from_xyz(0.5 * (from + to), BEAM, BEAM_Z)
            .with_rotation(Quat::from_rotation_z(FRAC_PI_2)),
    ));
}

/// A curtain in folds.
fn spawn_curtain(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    particles: Res<Particles>,
) {
    let curtain = bent(particles.0, |at| {
        let fold = 0.035 * (6.0 * TAU * at.x).sin();
        Vec3::new(CURTAIN_SIZE.x * (at.x - 0.5), -CURTAIN_SIZE.y * at.y, fold)
    });
    let top = Vec3::new(CURTAIN_SIZE.x, 1e-3, 1.0);
    commands.spawn((
        Cloth::of_mesh3d(),
        ClothInterpolation::LastTick,
        Mesh3d(meshes.add(curtain)),
        ClothMaterial::COTTON,
        ClothPins::within(-top, top),
        Transform::from_xyz(CURTAIN, BEAM - 0.04, BEAM_Z),
        linen(CORAL),
    ));
}

/// A crate in a sling: a band that hangs from the beam, goes around the crate, and is pinned to it below.
fn spawn_crate(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    particles: Res<Particles>,
) {
    let throw = Throw { mass: CRATE_MASS, velocity: Vec3::ZERO, spin: Vec3::ZERO };
    let shape = Shape::Crate(Cuboid::from_size(CRATE_SIZE));
    let body =
        (thing(shape, Some(throw), clay(BRASS), &mut meshes), Transform::from_translation(CRATE));
    let body = commands.spawn(body).id();

    // The band's way in the plane across the beam, seen from the crate.
    let half = 0.5 * CRATE_SIZE.zy() + 0.012;
    let hook = Vec2::new(0.012, BEAM - CRATE.y - 0.02);
    let mirror = Vec2::new(-1.0, 1.0);
    let way = [hook, half, half * Vec2::new(1.0, -1.0), -half, half * mirror, hook * mirror];
    let lengths: Vec<f32> = way.windows(2).map(|ends| ends[0].distance(ends[1])).collect();
    let whole: f32 = lengths.iter().sum();
    let band = bent(particles.0, |at| {
        let mut left = at.y * whole;
        let mut part = 0;
        while part < lengths.len() - 1 && left > lengths[part] {
            left -= lengths[part];
            part += 1;
        }
        let (from, to) = (way[part], way[part + 1]);
        let place = from.lerp(to, (left / lengths[part]).min(1.0));
        Vec3::new(0.24 * (at.x - 0.5), place.y, place.x)
    });
    let above = Vec3::new(1.0, hook.y + 1e-3, 1.0);
    let below = Vec3::new(1.0, -half.y + 1e-3, half.x - 0.03);
    let pins = ClothPins::within(below * Vec3::new(-1.0, 1.0, -1.0) - 2e-3 * Vec3::Y, below)
        .anchored_to(body)
        .and(ClothPins::within(above * Vec3::new(-1.0, 1.0, -1.0) - 2e-3 * Vec3::Y, above));
    commands.spawn((
        Cloth::of_mesh3d(),
        ClothInterpolation::LastTick,
        Mesh3d(meshes.add(band)),
        ClothMaterial { area_density: 0.3, drag: 0.5, ..ClothMaterial::CANVAS },
        pins,
        Transform::from_translation(CRATE),
        linen(INDIGO),
    ));
}

/// Throws one thing after the other: balls and boxes, light and heavy, from one side and from the other.
fn throw(
    mut thrown: Local<usize>,
    time: Res<Time>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut commands: Commands,
) {
    if *thrown == THROWN || time.elapsed_secs() < EVERY * (*thrown as f32 + 0.5) {
        return;
    }
    let number = *thrown;
    *thrown += 1;
    // From a beach ball to a shot.
    let (mass, size, look) = [
        (0.05, 0.13, clay(IVORY)),
        (0.4, 0.09, clay(CORAL)),
        (1.5, 0.11, clay(INDIGO)),
        (4.0, 0.085, metal(BRASS)),
        (0.2, 0.1, clay(TEAL)),
    ][number % 5];
    let shape = if number % 3 == 1 {
        Shape::Crate(Cuboid::from_length(1.7 * size))
    } else {
        Shape::Ball(Sphere::new(size))
    };
    let side = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
    let aside = 0.25 * side * ((number % 4) as f32 - 1.0);
    let curtain = Vec3::new(CURTAIN + 0.5 * aside, 1.1, BEAM_Z);
    let (from, to) = match number % 8 {
        3 | 6 => (curtain + Vec3::new(-0.4, 0.2, 2.6 * side), curtain),
        7 => (CRATE + Vec3::new(-0.3, 0.1, 2.4), CRATE),
        _ => (HAMMOCK + Vec3::new(2.4 * side, -0.3, 0.5), HAMMOCK + Vec3::X * aside),
    };
    // How fast it flies, to be there in time.
    const FLIGHT: f32 = 1.0;
    let velocity = (to - from) / FLIGHT + Vec3::Y * 0.5 * 9.81 * FLIGHT;
    let throw = Throw { mass, velocity, spin: Vec3::new(2.0, 1.0, -3.0) * side };
    commands
        .spawn((thing(shape, Some(throw), look, &mut meshes), Transform::from_translation(from)));
}

/// Lets the mouse hold things that can be thrown.
#[cfg(feature = "demo")]
pub fn hold_by_mouse(app: &mut App) {
    app.add_observer(pull).add_observer(let_go);
}

/// A thing follows the pointer, as far from the camera as it is.
#[cfg(feature = "demo")]
fn pull(
    drag: On<Pointer<Drag>>,
    things: Query<(&Thing, &GlobalTransform)>,
    camera: Single<(&Camera, &GlobalTransform)>,
    mut commands: Commands,
) {
    let (camera, eye) = *camera;
    if let Ok((thing, place)) = things.get(drag.entity)
        && thing.throw.is_some()
        && let Ok(ray) = camera.viewport_to_world(eye, drag.pointer_location.position)
        && let Some(at) =
            ray.plane_intersection_point(place.translation(), InfinitePlane3d::new(eye.forward()))
    {
        commands.entity(drag.entity).insert(Held(at));
    }
}

#[cfg(feature = "demo")]
fn let_go(drag: On<Pointer<DragEnd>>, mut commands: Commands) {
    commands.entity(drag.entity).try_remove::<Held>();
}
