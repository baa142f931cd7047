//! Points that no cloth can hang from are refused, by name.

use bevy::math::{Vec2, Vec3};
use bevy_drape::{
    hang::{HangError, HangingPoint, hang},
    solver::{MassLumping, Topology},
};

use crate::{support::solver::*, surface::point};

fn refused(points: &[HangingPoint], max_strain: f32, down: Vec3) -> HangError {
    let topology = Topology::from(sheet(Vec2::ONE, 9, 9, MassLumping::Lumped));
    hang(&topology, topology.rest_positions(), points, max_strain, down).unwrap_err()
}

#[test]
fn too_few_points() {
    assert_eq!(refused(&[], 0.0, GRAVITY), HangError::TooFewPoints(0));
    assert_eq!(refused(&[point(3, Vec3::Y)], 0.0, GRAVITY), HangError::TooFewPoints(1));
}

#[test]
fn points_further_apart_than_the_cloth_reaches() {
    let points = |span: f32| [point(0, Vec3::ZERO), point(8, Vec3::X * span)];
    let error = refused(&points(1.05), 0.04, GRAVITY);
    assert!(matches!(error, HangError::TooFar { first: 0, second: 8, .. }), "{error}");
    assert!(error.to_string().contains("1.04"), "{error}");
    let topology = Topology::from(sheet(Vec2::ONE, 9, 9, MassLumping::Lumped));
    let rest = topology.rest_positions();
    // As far as it may stretch, it is taut.
    let places = hang(&topology, rest, &points(1.05), 0.05, GRAVITY).unwrap();
    for (c, place) in places[..9].iter().enumerate() {
        assert!(place.distance(Vec3::X * 1.05 * c as f32 / 8.0) < 1e-6);
    }
    // Any two are looked at, not neighbours alone; upwards as well.
    let three = [point(0, Vec3::ZERO), point(40, Vec3::Y * 0.5), point(80, Vec3::Y * 2.0)];
    assert!(matches!(refused(&three, 0.0, GRAVITY), HangError::TooFar { .. }));
}

#[test]
fn points_at_one_place() {
    let at = Vec3::new(1.0, 2.0, 3.0);
    let expected = HangError::Coincident { first: 0, second: 8 };
    assert_eq!(refused(&[point(0, at), point(8, at)], 0.0, GRAVITY), expected);
    // One above the other is no trouble, nor are ends that are nearly at one place.
    let topology = Topology::from(sheet(Vec2::ONE, 9, 9, MassLumping::Lumped));
    for second in [Vec3::Y * 0.5, Vec3::Y * -0.999, Vec3::X * 1e-4] {
        let points = [point(0, Vec3::ZERO), point(8, second)];
        let places = hang(&topology, topology.rest_positions(), &points, 0.0, GRAVITY).unwrap();
        assert!(places.iter().all(|place| place.is_finite()));
        let lowest = places.iter().map(|place| place.y).fold(0.0, f32::min);
        // The fold of the first row, a metre below it.
        check("depth [m]", lowest.into(), -1.0 - 0.5 * f64::from(1.0 - second.y), 0.07);
    }
}

#[test]
fn particles_that_are_not_there_or_twice() {
    let points = [point(0, Vec3::ZERO), point(81, Vec3::X)];
    assert_eq!(
        refused(&points, 0.0, GRAVITY),
        HangError::NoSuchParticle { particle: 81, count: 81 }
    );
    let points = [point(4, Vec3::ZERO), point(8, Vec3::X * 0.1), point(4, Vec3::X)];
    assert_eq!(refused(&points, 0.0, GRAVITY), HangError::Twice(4));
}

#[test]
fn numbers_that_are_none() {
    let points = [point(0, Vec3::ZERO), point(8, Vec3::X * f32::NAN)];
    assert_eq!(refused(&points, 0.0, GRAVITY), HangError::NonFinite(8));
    let points = [point(0, Vec3::ZERO), point(8, Vec3::X * 0.5)];
    for down in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
        assert_eq!(refused(&points, 0.0, down), HangError::NoGravity);
    }
}
