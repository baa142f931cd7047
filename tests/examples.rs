//! Each example's scene, run headless, held to what a cloth must do: it stays finite, in its box and
//! above the ground, out of the solids, and within its strain limit.

#[path = "../examples/common/mod.rs"]
mod common;

use bevy::prelude::*;
use bevy_drape::prelude::*;
use common::{check::check, headless, report::Report, scene::Scene};

fn run(scene: Scene, seconds: f32) -> (App, Report) {
    let mut app = headless::app(scene, 64, 1);
    let report = headless::simulate(&mut app, seconds).unwrap();
    println!("{report}");
    check(app.world_mut()).unwrap();
    (app, report)
}

fn hold(report: &Report) {
    assert!(report.peak <= report.limit + 0.01, "strain {}", report.peak);
    assert!(report.depth <= 1e-4, "depth {} m", report.depth);
}

fn cloths(app: &mut App) -> Vec<Vec<Vec3>> {
    let mut query = app.world_mut().query::<&ClothSimulation>();
    query.iter(app.world()).map(|cloth| cloth.positions().collect()).collect()
}

fn highest(cloth: &[Vec3]) -> f32 {
    cloth.iter().map(|position| position.y).fold(f32::MIN, f32::max)
}

#[test]
fn drape() {
    let (mut app, report) = run(Scene::Drape, 4.0);
    let cloths = cloths(&mut app);
    assert_eq!(cloths.len(), 2);
    for cloth in cloths {
        // It lies on something, and its hem is near the ground.
        assert!(highest(&cloth) > 0.6, "{}", highest(&cloth));
        assert!(cloth.iter().any(|position| position.y < 0.1));
    }
    hold(&report);
}

#[test]
fn curtain() {
    let (mut app, report) = run(Scene::Curtain, 6.0);
    let cloths = cloths(&mut app);
    let cloth = &cloths[0];
    // It hangs from its corners, which have come closer, and falls in folds below them.
    assert!((cloth[63].x - cloth[0].x - 1.24).abs() < 1e-3);
    assert_eq!((cloth[0].y, cloth[63].y), (2.2, 2.2));
    assert!(cloth[64..].iter().all(|position| position.y < 2.2));
    assert!(cloth[32].y < 1.9, "{}", cloth[32].y);
    hold(&report);
}

#[test]
fn the_check_sees_what_is_wrong() {
    let mut app = headless::app(Scene::Spheres, 8, 1);
    assert!(check(app.world_mut()).is_err(), "it has not run");
    headless::simulate(&mut app, 0.2).unwrap();
    assert_eq!(check(app.world_mut()), Ok(()));
    app.world_mut().resource_mut::<common::check::Bounds>().max.y = 0.5;
    assert!(check(app.world_mut()).unwrap_err().contains("left"));
    app.world_mut().resource_mut::<common::check::Bounds>().max.y = 1.6;
    app.world_mut()
        .spawn(SdfCollider::from(Sphere::default()))
        .insert(Transform::from_scale(Vec3::new(1.0, 2.0, 1.0)));
    headless::simulate(&mut app, 0.3).unwrap();
    assert!(check(app.world_mut()).unwrap_err().contains("scale"));
}
