//! Each example's scene, run headless, held to what a cloth must do: it stays finite, in its box and
//! above the ground, out of the solids, and within its strain limit. What `bake` writes is held to the
//! field that the mesh bakes to.

#[path = "../../examples/bake.rs"]
#[allow(dead_code)]
mod bake;
#[path = "../../examples/gallery/mod.rs"]
mod gallery;
mod skirt;

use bevy::prelude::*;
use bevy_drape::{
    ClothInterCollision, ClothSelfCollision,
    prelude::*,
    sdf::{BakeSettings, DistanceField, SignedDistance},
};
use clap::Parser;
use examples_common::{
    check::{Bounds, check},
    headless,
    report::Report,
    repository,
};
use gallery::scene;
use std::{fs, path::Path};

fn run(name: &str, seconds: f32) -> (App, Report) {
    let mut app = headless::app(scene(name), 64, 1);
    let report = headless::simulate(&mut app, seconds).unwrap();
    println!("{report}");
    check(app.world_mut()).unwrap();
    (app, report)
}

fn hold(report: &Report) {
    hold_within(report, 0.01);
}

/// Strain may pass its limit by so much for a moment: what a pass of Provot's correction leaves.
fn hold_within(report: &Report, excess: f32) {
    assert!(report.peak <= report.limit + excess, "strain {}", report.peak);
    assert!(report.depth <= 1e-4, "depth {} m", report.depth);
}

/// Places of the particles of each cloth, in the order in which they were spawned.
fn cloths(app: &mut App) -> Vec<Vec<Vec3>> {
    let mut query = app.world_mut().query::<(Entity, &ClothSimulation)>();
    let mut cloths: Vec<_> = query.iter(app.world()).collect();
    cloths.sort_unstable_by_key(|(entity, _)| entity.index_u32());
    cloths.into_iter().map(|(_, cloth)| cloth.positions().collect()).collect()
}

fn highest(cloth: &[Vec3]) -> f32 {
    cloth.iter().map(|position| position.y).fold(f32::MIN, f32::max)
}

#[test]
fn drape() {
    let (mut app, report) = run("drape", 4.0);
    let cloths = cloths(&mut app);
    assert_eq!(cloths.len(), 2);
    for cloth in cloths {
        // It lies on something, and its hem is near the ground.
        assert!(highest(&cloth) > 0.6, "{}", highest(&cloth));
        assert!(cloth.iter().any(|position| position.y < 0.1));
    }
    // The bunny's ears catch it as it falls: 7 to 21 % for a moment, from 60 to 66 particles a side.
    hold_within(&report, 0.12);
}

#[test]
fn shirt() {
    let (mut app, report) = run("shirt", 4.0);
    let shirt = cloths(&mut app).remove(0);
    // It hangs on the dummy's arms, neither slipped off nor blown off its neck, and is as wide and as long as it was.
    let extent = |axis: usize| {
        shirt.iter().fold((f32::MAX, f32::MIN), |(l, h), at| (l.min(at[axis]), h.max(at[axis])))
    };
    let [(left, right), (low, high)] = [extent(0), extent(1)];
    assert!(right - left > 0.95 && right - left < 1.2, "{left} {right}");
    assert!(low > 0.55 && high > 1.3 && high < 1.5, "{low} {high}");
    hold_within(&report, 0.08);
}

#[test]
fn curtain() {
    let (mut app, report) = run("curtain", 6.0);
    let cloth = cloths(&mut app).remove(0);
    // It hangs from rings at its height, that have come to 0.64 of 2.2 m (within the first tick's way), and
    // falls in folds between them.
    let width = cloth[63].x - cloth[0].x;
    assert!((width - 0.64 * 2.2).abs() < 0.01, "{width}");
    assert!((cloth[0].y - cloth[63].y).abs() < 1e-3);
    let middle = &cloth[64 * 32..64 * 33];
    let (low, high) =
        middle.iter().fold((f32::MAX, f32::MIN), |(l, h), at| (l.min(at.z), h.max(at.z)));
    assert!(high - low > 0.05, "{low} {high}");
    assert!(cloth[64 * 63..].iter().all(|position| position.y < 0.4));
    hold(&report);
}

#[test]
fn tablecloth() {
    let (mut app, report) = run("tablecloth", 3.3);
    let cloth = cloths(&mut app).remove(0);
    // It lies on the table, and hangs over its edge.
    assert!((cloth[64 * 32 + 32].y - 0.762).abs() < 2e-3, "{}", cloth[64 * 32 + 32]);
    assert!(cloth.iter().any(|at| at.y < 0.5));
    hold(&report);
    // Then it is pulled off, over one side.
    let report = headless::simulate(&mut app, 6.5).unwrap();
    println!("{report}");
    check(app.world_mut()).unwrap();
    let cloth = cloths(&mut app).remove(0);
    let back = cloth.iter().map(|at| at.z).fold(f32::MAX, f32::min);
    assert!(back > 0.3 && highest(&cloth) < 0.3, "{back} {}", highest(&cloth));
    assert!(report.depth <= 1e-4, "depth {} m", report.depth);
}

#[test]
fn heap() {
    // The check asks for no crossing of those that collide with themselves.
    let (mut app, report) = run("heap", 3.0);
    let mut query = app.world_mut().query::<(&ClothSimulation, Has<ClothSelfCollision>)>();
    let crossings: Vec<_> =
        query.iter(app.world()).map(|(cloth, collides)| (cloth.crossings(), collides)).collect();
    assert_eq!(crossings.iter().filter(|(_, collides)| *collides).count(), 2);
    // The others are told apart from them.
    for (crossings, collides) in crossings {
        assert!(collides || crossings > 100, "{crossings}");
    }
    // Heaps lie low, towels on benches.
    let heights: Vec<_> = cloths(&mut app).iter().map(|cloth| highest(cloth)).collect();
    assert!(heights.iter().all(|height| (0.02..0.5).contains(height)), "{heights:?}");
    assert!(report.depth <= 1e-4, "depth {} m", report.depth);
}

/// Crossings of cloths of a scene, two by two: of those that collide, and of those that do not.
fn crossings_between(app: &mut App) -> [u32; 2] {
    let mut query = app.world_mut().query::<(&ClothSimulation, Has<ClothInterCollision>)>();
    let all: Vec<_> = query.iter(app.world()).collect();
    let mut crossings = [0; 2];
    for (place, (one, collides)) in all.iter().enumerate() {
        for (other, _) in all[..place].iter().filter(|(_, other)| other == collides) {
            crossings[usize::from(!collides)] += one.crossings_with(other);
        }
    }
    crossings
}

#[test]
fn pile() {
    let (mut app, report) = run("pile", 3.0);
    let [with, without] = crossings_between(&mut app);
    assert_eq!(with, 0);
    assert!(without > 1000, "{without}");
    let heights: Vec<_> = cloths(&mut app).iter().map(|cloth| highest(cloth)).collect();
    // Each of those that collide lies higher than the one below; the others lie in one place.
    assert!(heights[..4].is_sorted_by(|a, b| a + 0.005 < *b), "{heights:?}");
    assert!(heights[4..].iter().all(|height| *height < heights[1]), "{heights:?}");
    assert!(report.depth <= 1e-4, "depth {} m", report.depth);
}

#[test]
fn laundry() {
    let (mut app, report) = run("laundry", 3.0);
    let [with, without] = crossings_between(&mut app);
    assert_eq!(with, 0);
    assert!(without > 100, "{without}");
    assert!(cloths(&mut app).iter().all(|cloth| highest(cloth) > 1.2), "they hang on their rails");
    assert!(report.depth <= 1e-4, "depth {} m", report.depth);
}

#[test]
fn fabrics() {
    let (mut app, report) = run("fabrics", 3.0);
    let cloths = cloths(&mut app);
    assert_eq!(cloths.len(), 6);
    for cloth in &cloths {
        // On its post, over the edge of which it hangs.
        assert!((highest(cloth) - 0.625).abs() < 0.02, "{}", highest(cloth));
        assert!(cloth.iter().any(|at| at.y < 0.45));
    }
    assert!(report.depth <= 1e-4, "depth {} m", report.depth);
}

#[test]
fn stress() {
    let (mut app, report) = run("stress", 1.5);
    let cloths = cloths(&mut app);
    let particles: usize = cloths.iter().map(Vec::len).sum();
    assert!(particles >= 100_000 && cloths.len() >= 50, "{particles} in {}", cloths.len());
    // The largest of a hundred cloths. Corners whip onto the ground, and friction stops them within a substep; their springs are short.
    hold_within(&report, 0.36);
}

#[test]
fn tuned() {
    let (mut app, report) = run("tuned", 4.0);
    assert_eq!(cloths(&mut app).len(), 2);
    // Corners whip onto the ground, and friction stops them within a substep.
    hold_within(&report, 0.04);
}

#[test]
fn flag() {
    let (mut app, report) = run("flag", 3.0);
    let early = cloths(&mut app).remove(0);
    headless::simulate(&mut app, 3.25).unwrap();
    let late = cloths(&mut app).remove(0);
    // The luff stays at the mast, the fly streams with the wind, and flutters.
    for row in 0..42 {
        assert_eq!(early[64 * row], late[64 * row]);
        assert!(late[64 * row + 63].x - late[0].x > 0.7, "{}", late[64 * row + 63]);
    }
    let moved = early.iter().zip(&late).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(moved > 0.1, "{moved}");
    hold(&report);
}

#[test]
fn sail() {
    let (mut app, report) = run("sail", 4.0);
    let cloth = cloths(&mut app).remove(0);
    let corners = [0, 63, 64 * 63, 64 * 64 - 1].map(|corner| cloth[corner]);
    assert!(corners.iter().all(|corner| corner.z.abs() < 1e-3), "{corners:?}");
    // The wind along z fills it.
    assert!(cloth[64 * 32 + 32].z > 0.3, "{}", cloth[64 * 32 + 32]);
    hold(&report);
}

#[test]
fn cape() {
    let (mut app, report) = run("cape", 5.0);
    let cloth = cloths(&mut app).remove(0);
    // It hangs from its collar, which is its highest part, on a circle of 1 m.
    let collar = cloth[16];
    assert!((collar.xz().length() - 1.0).abs() < 0.1 && collar.y > 1.35, "{collar}");
    assert!(highest(&cloth) < collar.y + 0.02);
    let hem = cloth[cloth.len() - 32];
    assert!(hem.y < 0.8 && hem.distance(collar) > 0.8, "{hem}");
    // What presses on edges stretches them after threads were held to their limit, for a tick: 12.7 % at most.
    hold_within(&report, 0.03);
}

#[test]
fn bunny() {
    let (mut app, report) = run("bunny", 3.4);
    // On the way it is lifted far from the rod, at z = 0; then it hangs at the bunny's tail.
    let depth = |cloth: &[Vec3]| cloth.iter().map(|at| at.z).fold(f32::MIN, f32::max);
    let cloth = cloths(&mut app).remove(0);
    assert!(depth(&cloth) > 0.5, "{}", depth(&cloth));
    headless::simulate(&mut app, 8.0).unwrap();
    let cloth = cloths(&mut app).remove(0);
    // How far down the tail it slides is chance: less than 0.4 m was seen, and 0.43 m.
    assert!(depth(&cloth) < 0.47, "{}", depth(&cloth));
    // Where it strikes the ears, one edge after the other is held.
    hold_within(&report, 0.05);
}

#[test]
fn hung() {
    let mut app = headless::app(scene("hung"), 64, 1);
    headless::simulate(&mut app, 0.1).unwrap();
    let before = cloths(&mut app);
    let report = headless::simulate(&mut app, 1.1).unwrap();
    println!("{report}");
    check(app.world_mut()).unwrap();
    let moved: Vec<f32> = before
        .iter()
        .zip(cloths(&mut app))
        .map(|(from, to)| from.iter().zip(to).map(|(a, b)| a.distance(b)).fold(0.0, f32::max))
        .collect();
    // The one that starts hung stays; the one that starts flat comes down.
    assert!(moved[0] < 0.02 * 1.6 && moved[1] > 0.5 * 1.6, "{moved:?}");
    hold(&report);
}

#[test]
fn the_check_sees_what_is_wrong() {
    let mut app = headless::app(scene("spheres"), 8, 1);
    assert!(check(app.world_mut()).is_err(), "it has not run");
    headless::simulate(&mut app, 0.2).unwrap();
    assert_eq!(check(app.world_mut()), Ok(()));
    app.world_mut().resource_mut::<Bounds>().max.y = 0.5;
    assert!(check(app.world_mut()).unwrap_err().contains("left"));
    app.world_mut().resource_mut::<Bounds>().max.y = 1.6;
    app.world_mut()
        .spawn(SdfCollider::from(Sphere::default()))
        .insert(Transform::from_scale(Vec3::new(1.0, 2.0, 1.0)));
    headless::simulate(&mut app, 0.3).unwrap();
    assert!(check(app.world_mut()).unwrap_err().contains("scale"));
}

fn run_bake(arguments: &[&str]) -> Result<(), String> {
    let cli = bake::Cli::try_parse_from([&["bake"], arguments].concat());
    bake::run(&cli.map_err(|error| error.to_string())?).map_err(|error| error.to_string())
}

#[test]
fn bake_writes_the_field_of_a_mesh() {
    let bunny = repository("assets/bunny.obj");
    let bunny = bunny.to_str().unwrap();
    let output = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bunny.sdf");
    let name = output.to_str().unwrap();
    run_bake(&[bunny, name, "--cells", "12"]).unwrap();
    let field = DistanceField::from_bytes(&fs::read(&output).unwrap()).unwrap();
    let (models, _) = tobj::load_obj(bunny, &tobj::GPU_LOAD_OPTIONS).unwrap();
    let mesh = &models[0].mesh;
    let positions: Vec<_> = mesh.positions.as_chunks().0.iter().map(|p| Vec3::from(*p)).collect();
    let settings = BakeSettings::for_mesh(&positions, 12);
    assert_eq!(DistanceField::bake(&positions, &mesh.indices, &settings), Ok(field));

    run_bake(&[bunny, name, "--cell-size", "0.1", "--margin", "0.35"]).unwrap();
    let field = DistanceField::from_bytes(&fs::read(&output).unwrap()).unwrap();
    assert_eq!(field.cell_size(), 0.1);
    let bounds = field.bounds().unwrap();
    assert!((bounds.min - field.grid_bounds().min).min_element() >= 0.35);
}

#[test]
fn bake_says_why_it_cannot() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let open = folder.join("open.obj");
    fs::write(&open, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let empty = folder.join("empty.obj");
    fs::write(&empty, "").unwrap();
    let bunny = repository("assets/bunny.obj");
    let bunny = bunny.to_str().unwrap();
    let out = folder.join("refused.sdf");
    let _ = fs::remove_file(&out);
    let out = out.to_str().unwrap();
    for (arguments, reason) in [
        (&[open.to_str().unwrap(), out][..], "not closed"),
        (&[empty.to_str().unwrap(), out], "no triangles"),
        (&["nowhere.obj", out], "nowhere.obj"),
        (&[bunny, "bunny.obj"], ".sdf"),
        (&[bunny, "nowhere/at/all.sdf", "-c", "4"], "nowhere"),
        (&[bunny, out, "-s", "-1"], "cell size of -1"),
        (&[bunny, out, "-s", "1e-5"], "larger cells"),
        (&[bunny, out, "-m", "nan"], "margin"),
        (&[bunny, out, "-c", "0"], "0 is not in"),
        (&[bunny, out, "-c", "8", "-s", "0.1"], "cannot be used with"),
    ] {
        let error = run_bake(arguments).unwrap_err();
        assert!(error.contains(reason), "{arguments:?}: {error}");
    }
    assert!(!Path::new(out).exists());
}
