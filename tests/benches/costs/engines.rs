//! Colliders of Avian beside `SdfCollider`s by hand: what it costs to adapt them, once and in each tick.

use std::time::Instant;

use crate::{
    app::{app_with, compare},
    bodies::{Primitive, lay, ten},
    turns::{Bound, Wrong, heading, line, median},
};
use avian3d::prelude::*;
use bevy::prelude::*;
use bevy_drape::{AvianClothPlugin, ClothCollider, ClothSystems, SdfCells, prelude::*};

/// Colliders in a crowd of them.
const CROWD: usize = 1000;

pub fn engines(n: u32, rounds: usize, wrong: &mut Wrong) {
    on_ten_primitives(n, rounds, wrong);
    hulls(wrong);
    crowds(rounds.min(200));
}

/// An app with Avian, in which cloths see its colliders.
fn physics_app() -> App {
    app_with(true, (PhysicsPlugins::default(), AvianClothPlugin::default()))
}

impl Primitive {
    fn engines(self) -> Collider {
        match self {
            Self::Ball(radius) => Collider::sphere(radius),
            Self::Cube(side) => Collider::cuboid(side, side, side),
            Self::Capsule { radius, half_length } => Collider::capsule(radius, 2.0 * half_length),
            Self::Cylinder { radius, height } => Collider::cylinder(radius, height),
            Self::Cone { radius, height } => Collider::cone(radius, height),
        }
    }
}

fn on_ten_primitives(n: u32, rounds: usize, wrong: &mut Wrong) {
    #[derive(Clone, Copy, PartialEq)]
    enum Way {
        ByHand,
        One,
        Two,
    }
    // Bodies lie on a ground that is nothing to the cloth.
    let scene = |way: Way| {
        let mut app = physics_app();
        let ground = (RigidBody::Static, Collider::cuboid(10.0, 1.0, 10.0));
        app.world_mut().spawn((ground, Transform::from_xyz(0.0, -0.69, 0.0)));
        for (primitive, place) in ten() {
            let body = (RigidBody::Dynamic, Mass(1.0), SleepingDisabled);
            let still = LockedAxes::ROTATION_LOCKED;
            let mut body = app.world_mut().spawn((body, still, primitive.engines(), place));
            match way {
                Way::ByHand => body.insert(primitive.collider()),
                _ => body.insert(ClothCollider { one_way: way == Way::One, ..default() }),
            };
        }
        lay(&mut app, n);
        app
    };
    heading("on ten primitives of Avian's, us an update", "without", "with");
    let name = "adapted, one-way; against by hand";
    let pair = || [Way::ByHand, Way::One].map(scene);
    line(name, &compare(name, rounds, pair, false, wrong), Bound::Percent(2.0));
    let name = "two-way; against one-way";
    let pair = || [Way::One, Way::Two].map(scene);
    line(name, &compare(name, rounds, pair, false, wrong), Bound::Percent(10.0));
}

/// The instants between what happens in a tick.
#[derive(Resource, Default)]
struct Marks(Vec<Instant>);

fn mark(mut marks: ResMut<Marks>) {
    marks.0.push(Instant::now());
}

/// Marks the end of the engine's tick, of adapting, of gathering, of solving, and of the tick.
fn add_marks(app: &mut App) {
    use ClothSystems::{Finish, Gather, Setup, Solve};
    app.init_resource::<Marks>()
        .add_systems(
            FixedPostUpdate,
            (
                mark.in_set(PhysicsSystems::Last),
                mark.in_set(Setup),
                mark.after(Gather).before(Solve),
                mark.after(Solve).before(Finish),
            ),
        )
        .add_systems(FixedLast, mark);
    examples_common::run_in_series(app);
}

/// Runs a tick, and tells how long adapting, gathering and finishing took \[us\].
fn parts(app: &mut App) -> [f64; 3] {
    app.world_mut().resource_mut::<Marks>().0.clear();
    app.update();
    let marks = &app.world().resource::<Marks>().0;
    let [engine, adapted, gathered, solved, done] = marks[..] else { return [f64::NAN; 3] };
    [(engine, adapted), (adapted, gathered), (solved, done)]
        .map(|(from, to)| (to - from).as_secs_f64() * 1e6)
}

/// Points of a hull, always the same.
fn points(seed: u32) -> Vec<Vec3> {
    let mut state = seed;
    let mut roll = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32 - 0.5
    };
    (0..24).map(|_| Vec3::from([(); 3].map(|()| 0.6 * roll()))).collect()
}

/// Adds a thousand equal hulls of ten shapes.
fn hulls(wrong: &mut Wrong) {
    const TURNS: usize = 9;
    let mut times = [const { Vec::new() }; 4];
    for _ in 0..TURNS {
        // Without Avian's own systems: what is timed is ours.
        let mut app = app_with(true, AvianClothPlugin::default());
        add_marks(&mut app);
        app.update();
        for i in 0..CROWD {
            let hull = Collider::convex_hull(points(1 + i as u32 % 10));
            let cells = SdfCells::Count(16);
            app.world_mut().spawn((hull.unwrap(), ClothCollider { cells, ..default() }));
        }
        let added = parts(&mut app);
        let mut worst = [0.0_f64; 3];
        let start = Instant::now();
        let all_there = |app: &mut App| {
            let mut solids = app.world_mut().query::<&SdfCollider>();
            solids.iter(app.world()).count() == CROWD
        };
        while !all_there(&mut app) && start.elapsed().as_secs() < 60 {
            std::thread::sleep(std::time::Duration::from_millis(5));
            let parts = parts(&mut app);
            worst = [0, 1, 2].map(|i| worst[i].max(parts[i]));
        }
        wrong.unless(all_there(&mut app), "1000 hulls", "they are not there after a minute");
        for (times, time) in times.iter_mut().zip([added[0], added[1], worst[0], worst[1]]) {
            times.push(time);
        }
    }
    let [read, gathered, given, taken] = times.map(median);
    println!("\n1000 hulls of ten shapes that are added, us on the main thread, bound 5000");
    println!("  the tick that reads them {read:.0}, gather {gathered:.0}");
    println!("  the tick that gives them their fields, at worst {given:.0}, gather {taken:.0}");
}

/// A thousand colliders that are far from the cloth, in each tick.
fn crowds(rounds: usize) {
    println!("\na tick with 1000 colliders: adapt and weigh, gather, finish and give, us");
    for (name, body, is_adapted) in [
        ("static, by hand", RigidBody::Static, false),
        ("static", RigidBody::Static, true),
        ("dynamic, by hand", RigidBody::Dynamic, false),
        ("dynamic", RigidBody::Dynamic, true),
    ] {
        for parented in [false, true] {
            let mut app = physics_app();
            app.insert_resource(Gravity::ZERO);
            add_marks(&mut app);
            let cloth = Cloth::sheet(Vec2::ONE, UVec2::splat(16));
            app.world_mut().spawn((cloth, ClothPins::vertices([0, 15])));
            for i in 0..CROWD {
                let place = Vec3::new(50.0 + (i / 40) as f32, -3.0, (i % 40) as f32);
                let body = (body, Transform::from_translation(place));
                let body = app.world_mut().spawn((body, SleepingDisabled)).id();
                let mut collider = app.world_mut().entity_mut(body);
                if parented {
                    collider = app.world_mut().spawn((ChildOf(body), Transform::default()));
                }
                collider.insert(Collider::sphere(0.3));
                if is_adapted {
                    collider.insert(ClothCollider::default());
                } else {
                    collider.insert(SdfCollider::from(Sphere::new(0.3)));
                }
            }
            (0..20).for_each(|_| app.update());
            let mut times = [const { Vec::new() }; 3];
            for _ in 0..rounds {
                for (times, time) in times.iter_mut().zip(parts(&mut app)) {
                    times.push(time);
                }
            }
            let [adapt, gather, finish] = times.map(median);
            let of = if parented { ", children of their bodies" } else { "" };
            let name = format!("{name}{of}");
            println!("  {name:48} {adapt:8.1} {gather:8.1} {finish:8.1}");
        }
    }
}
