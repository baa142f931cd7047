//! Costs in a Bevy app: colliders that are far away, sleep, what follows an entity, and the plugin
//! around the solver.

use std::time::Instant;

use crate::turns::{Bound, Turns, Wrong, heading, in_turns, line, median};
use bevy::{
    app::{Plugins, TaskPoolOptions, TaskPoolPlugin, TaskPoolThreadAssignmentPolicy},
    asset::AssetPlugin,
    mesh::{Indices, MeshPlugin},
    prelude::*,
    time::TimeUpdateStrategy,
    transform::TransformPlugin,
};
use bevy_drape::{ClothInertia, ClothProxy, ClothSleepThreshold, ClothTeleport, prelude::*};
use examples_common::run_in_series;

fn app(drawn: bool) -> App {
    app_with(drawn, ())
}

/// An app of `MinimalPlugins` and others on one thread, which draws its cloths or not. An update is a tick.
pub fn app_with<M>(drawn: bool, others: impl Plugins<M>) -> App {
    app_of(drawn.then(AssetPlugin::default), others)
}

/// An app as [`app_with`] makes it, which draws where it has files.
pub fn app_of<M>(files: Option<AssetPlugin>, others: impl Plugins<M>) -> App {
    let one = TaskPoolThreadAssignmentPolicy {
        min_threads: 1,
        max_threads: 1,
        percent: 1.0,
        on_thread_spawn: None,
        on_thread_destroy: None,
    };
    let task_pool_options =
        TaskPoolOptions { compute: one, ..TaskPoolOptions::with_num_threads(1) };
    let mut app = App::new();
    app.add_plugins(MinimalPlugins.set(TaskPoolPlugin { task_pool_options }));
    if let Some(files) = files {
        app.add_plugins((files, MeshPlugin, TransformPlugin));
        app.init_resource::<Assets<Image>>();
    }
    app.add_plugins((ClothPlugin::default(), others))
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    run_in_series(&mut app);
    app.finish();
    app.cleanup();
    app
}

fn sheet(n: u32) -> impl Bundle {
    (Cloth::sheet(Vec2::splat(2.0), UVec2::splat(n)), ClothSleepThreshold::NEVER)
}

fn hung(n: u32) -> impl Bundle {
    (sheet(n), ClothPins::vertices([0, n - 1]))
}

/// Runs a tick, and tells its time \[us\].
pub fn update(app: &mut App) -> f64 {
    let before = Instant::now();
    app.update();
    before.elapsed().as_secs_f64() * 1e6
}

/// Runs two ticks, and tells the time of the second \[us\]: the app finds in the caches what it has left there, as from frame to frame
/// of a game, and not what the app beside it has.
pub fn second_update(app: &mut App) -> f64 {
    app.update();
    update(app)
}

fn places(app: &mut App) -> Vec<Vec3> {
    let world = app.world_mut();
    let mut cloths = world.query::<&ClothSimulation>();
    cloths.iter(world).flat_map(|cloth| cloth.positions().collect::<Vec<_>>()).collect()
}

/// Meshes written in the last update.
fn written(app: &App) -> usize {
    let Some(events) = app.world().get_resource::<Messages<AssetEvent<Mesh>>>() else {
        return 0;
    };
    let is_written = |event: &&AssetEvent<Mesh>| matches!(event, AssetEvent::Modified { .. });
    events.iter_current_update_messages().filter(is_written).count()
}

/// Pairs of apps that are compared: where a cloth lies in memory makes it some percent faster or slower.
const PAIRS: usize = 9;

/// Times updates of pairs of apps, whose cloths must run, and come to the same bits where they have to be `same`.
pub fn compare(
    name: &str,
    rounds: usize,
    pair: impl Fn() -> [App; 2],
    same: bool,
    wrong: &mut Wrong,
) -> Turns {
    compare_by(update, name, rounds, pair, same, wrong)
}

/// Compares pairs of apps as [`compare`] does, by the times that `time` tells \[us\].
pub fn compare_by(
    time: fn(&mut App) -> f64,
    name: &str,
    rounds: usize,
    pair: impl Fn() -> [App; 2],
    same: bool,
    wrong: &mut Wrong,
) -> Turns {
    let turns = (0..PAIRS)
        .map(|_| compare_pair(time, name, rounds.div_ceil(PAIRS), pair(), same, wrong))
        .collect::<Vec<_>>();
    let median_of = |value: fn(&Turns) -> f64| median(turns.iter().map(value).collect());
    Turns {
        without: median_of(|it| it.without),
        with: median_of(|it| it.with),
        more: median_of(|it| it.more),
    }
}

fn compare_pair(
    time: fn(&mut App) -> f64,
    name: &str,
    rounds: usize,
    [mut without, mut with]: [App; 2],
    same: bool,
    wrong: &mut Wrong,
) -> Turns {
    for app in [&mut without, &mut with] {
        (0..10).for_each(|_| app.update());
    }
    let turns = in_turns(rounds, || time(&mut without), || time(&mut with));
    let [without, with] = [without, with].map(|mut app| {
        let mut failures = app.world_mut().query::<&ClothFailure>();
        let failed = failures.iter(app.world()).next().map(|failure| failure.error.to_string());
        wrong.unless(failed.is_none(), name, &failed.unwrap_or_default());
        places(&mut app)
    });
    let runs = !with.is_empty() && with.iter().all(|p| p.is_finite());
    wrong.unless(runs, name, "a cloth does not run");
    wrong.unless(!same || without == with, name, "other bits");
    turns
}

/// Moves every cloth's entity to and fro.
fn sway(mut cloths: Query<&mut Transform, With<Cloth>>, time: Res<Time>) {
    for mut place in &mut cloths {
        place.translation.x = 0.5 * ops::sin(3.0 * time.elapsed_secs());
    }
}

pub fn colliders_and_components(n: u32, rounds: usize, wrong: &mut Wrong) {
    heading("a whole update of an app, us", "without", "with");
    let apps = || {
        [false; 2].map(|drawn| {
            let mut app = app(drawn);
            let cloth = app.world_mut().spawn(hung(n)).id();
            (app, cloth)
        })
    };
    for (name, moving) in [("1000 far colliders", false), ("1000 far colliders, moving", true)] {
        let pair = || {
            let [(without, _), (mut with, _)] = apps();
            for i in 0..1000 {
                let place = Vec3::new(50.0 + (i / 40) as f32, -3.0, (i % 40) as f32);
                let solid = SdfCollider::from(Sphere::new(0.3));
                with.world_mut().spawn((solid, Transform::from_translation(place)));
            }
            if moving {
                let shift = |mut places: Query<&mut Transform, With<SdfCollider>>| {
                    places.iter_mut().for_each(|mut place| place.translation.y += 1e-3);
                };
                with.add_systems(FixedUpdate, shift);
            }
            [without, with]
        };
        let turns = compare(name, rounds, pair, true, wrong);
        line(name, &turns, if moving { Bound::None } else { Bound::Percent(2.0) });
    }
    let pair = || {
        let [(without, _), (mut with, cloth)] = apps();
        let unused = (ClothTeleport::default(), ClothInertia::default());
        with.world_mut().entity_mut(cloth).insert(unused);
        [without, with]
    };
    let name = "ClothTeleport and ClothInertia, unused";
    line(name, &compare(name, rounds, pair, true, wrong), Bound::None);
    let pair = || {
        let [(mut without, _), (mut with, cloth)] = apps();
        with.world_mut().entity_mut(cloth).insert(ClothInertia::new(0.3));
        without.add_systems(FixedUpdate, sway);
        with.add_systems(FixedUpdate, sway);
        [without, with]
    };
    let name = "ClothInertia, of what sways";
    line(name, &compare(name, rounds, pair, false, wrong), Bound::None);
}

/// Cloths on the ground, asleep, against none.
pub fn sleep(rounds: usize, wrong: &mut Wrong) {
    const CLOTHS: u32 = 200;
    heading("200 cloths that sleep on the ground, us an update", "without", "with");
    for (name, air) in [("asleep", false), ("asleep, in still air", true)] {
        let [mut without, mut with] = [true; 2].map(app);
        for app in [&mut without, &mut with] {
            app.world_mut().spawn(SdfCollider::from(InfinitePlane3d::default()));
        }
        for i in 0..CLOTHS {
            let place = Vec3::new((i % 20) as f32 * 2.0, 0.01, (i / 20) as f32 * 2.0);
            let cloth = Cloth::sheet(Vec2::ONE, UVec2::splat(16));
            let cloth = with.world_mut().spawn((cloth, Transform::from_translation(place))).id();
            if air {
                with.world_mut().entity_mut(cloth).insert(ClothAir::default());
            }
        }
        let awake = |app: &mut App| {
            let world = app.world_mut();
            let mut cloths = world.query::<&ClothSimulation>();
            cloths.iter(world).filter(|cloth| !cloth.is_asleep()).count()
        };
        let mut ticks = 0;
        while ticks < 2 || ticks < 20 * 64 && awake(&mut with) > 0 {
            with.update();
            ticks += 1;
        }
        without.update();
        let mut meshes = 0;
        let asleep = || {
            let time = update(&mut with);
            meshes += written(&with);
            time
        };
        let turns = in_turns(rounds, || update(&mut without), asleep);
        line(name, &turns, Bound::Each(1.0, CLOTHS));
        let awake = awake(&mut with);
        wrong.unless(awake == 0, name, &format!("{awake} are awake after {ticks} ticks"));
        wrong.unless(meshes == 0, name, &format!("{meshes} meshes were written"));
    }
}

/// The instants between the plugin's sets in one update.
#[derive(Resource, Default)]
struct Marks(Vec<Instant>);

fn mark(mut marks: ResMut<Marks>) {
    marks.0.push(Instant::now());
}

/// Measures what the plugin does around the solver, for a cloth that is drawn: a sheet, a mesh that is no grid, and a sheet that another
/// one carries.
pub fn plugin(n: u32, rounds: usize, wrong: &mut Wrong) {
    println!("\nthe plugin around the solver, a cloth that is drawn, us an update");
    println!("{:27} set up  gather  finish    draw  together  (solve)", "");
    let sheet = |app: &mut App| app.world_mut().spawn(hung(n)).id();
    let mesh = |app: &mut App| {
        let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(without_a_cell(n));
        let cloth = (Cloth::of_mesh3d(), Mesh3d(mesh), ClothSleepThreshold::NEVER);
        app.world_mut().spawn((cloth, ClothPins::vertices([0, n - 1]))).id()
    };
    let carried = |app: &mut App| {
        let of = ClothProxy::ratio(0.2);
        app.world_mut().spawn((hung(n), of)).id()
    };
    around_the_solver("a sheet", sheet, Some(50.0), rounds, wrong);
    around_the_solver("a mesh that is no grid", mesh, None, rounds, wrong);
    around_the_solver("a sheet carried by a fifth", carried, None, rounds, wrong);
}

/// A square of two metres that lacks a cell, which makes it a mesh like any other.
fn without_a_cell(n: u32) -> Mesh {
    let mut mesh = Plane3d::default().mesh().size(2.0, 2.0).subdivisions(n - 2).build();
    if let Some(Indices::U32(corners)) = mesh.indices_mut() {
        let cell = 6 * ((n - 1) * (n / 2) + n / 2) as usize;
        corners.drain(cell..cell + 6);
    }
    mesh
}

/// Prints what the plugin does around the solver for a cloth.
fn around_the_solver(
    name: &str,
    spawn: impl Fn(&mut App) -> Entity,
    most: Option<f64>,
    rounds: usize,
    wrong: &mut Wrong,
) {
    use ClothSystems::{Finish, Gather, LateSetup, Setup, Solve, WriteMeshes};
    let mut app = app(true);
    app.init_resource::<Marks>();
    let cloth = spawn(&mut app);
    for (i, set) in [Setup, Gather, Solve, Finish].into_iter().enumerate() {
        if i == 0 {
            app.add_systems(FixedPostUpdate, mark.before(set));
        }
        // The next set comes after: between two marks is one set.
        let after = mark.after(set);
        match [Gather, Solve, Finish].get(i) {
            Some(&next) => app.add_systems(FixedPostUpdate, after.before(next)),
            None => app.add_systems(FixedPostUpdate, after),
        };
    }
    app.add_systems(
        PostUpdate,
        (mark.after(LateSetup).before(WriteMeshes), mark.after(WriteMeshes)),
    );
    // A large one is made in the background; one that fails is not waited for.
    let is_new = |it: &ClothSimulation| it.tick_count() < 10;
    while app.world().get::<ClothSimulation>(cloth).is_none_or(is_new)
        && app.world().get::<ClothFailure>(cloth).is_none()
    {
        app.update();
        std::thread::yield_now();
    }
    let mut times: [Vec<f64>; 5] = Default::default();
    let mut meshes = 0;
    for _ in 0..rounds {
        app.world_mut().resource_mut::<Marks>().0.clear();
        app.update();
        meshes += written(&app);
        let marks = &app.world().resource::<Marks>().0;
        let [a, b, c, d, e, f, g] = marks[..] else { continue };
        for (times, (from, to)) in times.iter_mut().zip([(a, b), (b, c), (c, d), (d, e), (f, g)]) {
            times.push((to - from).as_secs_f64() * 1e6);
        }
    }
    wrong.unless(meshes == rounds, name, &format!("{meshes} meshes in {rounds} updates"));
    let simulation = app.world().get::<ClothSimulation>(cloth);
    wrong.unless(simulation.is_some_and(|it| it.pinned().len() == 2), name, "no cloth");
    let [setup, gather, solve, finish, draw] = times.map(median);
    let all = setup + gather + finish + draw;
    let bound = most.map_or(String::new(), |most| {
        format!(", bound {most}{}", if all > most { ": MISSED" } else { "" })
    });
    println!(
        "  {name:26} {setup:5.1}   {gather:5.1}   {finish:5.1}   {draw:5.1}     {all:5.1}  ({solve:.1}){bound}"
    );
}
