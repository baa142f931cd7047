//! Solids made of others: swollen ones and compounds. The truth is the definition in `f64`: the least
//! distance to any of the parts, each written down apart from its shape, less the radius.

use crate::support::dice::Dice;
use bevy::math::{DQuat, DVec3, Quat, Vec3, primitives::*};
use bevy_drape::sdf::shapes::{Compound, CompoundError, Part, Rounded};
use bevy_drape::sdf::{LANES, PointBlock, SampleBlock, SignedDistance};
use std::sync::Arc;

/// A point every shape is asked at: a third of them near, a third around, a third far.
pub fn somewhere(dice: &mut Dice, size: f64) -> Vec3 {
    let half = [0.4, 1.5, 40.0][dice.below(3)];
    (dice.in_box(half) * size).as_vec3()
}

/// The distance is what `truth` says, changes by no more than the way, the normal is its gradient where that has
/// length one, and blocks have the single points' bits. `exact` says where the truth is to be met; elsewhere the
/// distance has to be between it and zero.
pub fn hold_to(
    solid: &dyn SignedDistance,
    size: f64,
    seed: u64,
    truth: impl Fn(DVec3) -> f64,
    exact: impl Fn(f64) -> bool,
) {
    let mut dice = Dice(seed);
    let (mut compared, mut inside) = (0, 0);
    for _ in 0..10_000 {
        let point = somewhere(&mut dice, size);
        let found = solid.sample(point);
        let (distance, true_distance) = (f64::from(found.distance), truth(point.as_dvec3()));
        let rounding = 2e-6 * (size + point.as_dvec3().length());
        assert!(distance >= -rounding || true_distance <= rounding, "{point}: {distance}");
        if exact(true_distance) {
            let off = (distance - true_distance).abs();
            assert!(off < rounding, "{point}: {distance}, not {true_distance}");
        } else {
            assert!(distance > true_distance - rounding && distance < rounding, "{point}");
        }
        inside += i32::from(distance < 0.0);
        assert!((found.normal.length() - 1.0).abs() < 1e-5, "{point}: {found:?}");

        let step = (dice.direction() * dice.unit() * 0.3 * size).as_vec3();
        let (there, way) = (solid.distance(point + step), f64::from(step.length()));
        let change = (f64::from(there) - distance).abs();
        assert!(change < way + 2.0 * rounding, "{point}: {change} over {way}");

        let h = 1e-3 * size;
        let at = |p: DVec3| f64::from(solid.distance(p.as_vec3()));
        let p = point.as_dvec3();
        if p.length() < 3.0 * size {
            let before = DVec3::AXES.map(|a| (distance - at(p - h * a)) / h);
            let after = DVec3::AXES.map(|a| (at(p + h * a) - distance) / h);
            let [before, after] = [before, after].map(DVec3::from_array);
            // They differ across an edge or the medial axis.
            if (before - after).length() < 0.01 {
                compared += 1;
                let off = (found.normal.as_dvec3() - 0.5 * (before + after)).length();
                assert!(off < 0.02, "{point}: {found:?}, not {before} or {after}");
            }
        }
    }
    assert!(compared > 4_000, "only {compared} normals compared");
    assert!(inside > 15, "only {inside} points inside");
    blocks_are_points(solid, size, seed + 1);
}

/// Blocks have the points' bits, and what is no number is not near.
fn blocks_are_points(solid: &dyn SignedDistance, size: f64, seed: u64) {
    let odd = [0.0, -0.0, 1e-25, 0.5, -0.7, 3e4, 1e30, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    let mut dice = Dice(seed);
    for round in 0..1_000 {
        let mut points = PointBlock::default();
        for lane in 0..LANES {
            let mut point = somewhere(&mut dice, size);
            if round % 4 == 0 {
                point[dice.below(3)] = odd[dice.below(odd.len())];
                point[dice.below(3)] = odd[dice.below(odd.len())];
            }
            points.set(lane, point);
        }
        let (mut samples, mut distances) = (SampleBlock::default(), [0.0; LANES]);
        solid.sample_block(&points, &mut samples);
        solid.distance_block(&points, &mut distances);
        for (lane, distance) in distances.into_iter().enumerate() {
            let point = points.point(lane);
            let one = solid.sample(point);
            let normal = [samples.nx[lane], samples.ny[lane], samples.nz[lane]];
            let bits = |v: f32| if v.is_nan() { f32::NAN.to_bits() } else { v.to_bits() };
            assert_eq!(bits(samples.distance[lane]), bits(one.distance), "{point}");
            assert_eq!(bits(distance), bits(one.distance), "{point}");
            assert_eq!(bits(solid.distance(point)), bits(one.distance), "{point}");
            assert_eq!(normal.map(bits), one.normal.to_array().map(bits), "{point}");
            assert!((one.normal.length() - 1.0).abs() < 1e-5, "{point}: {one:?}");
            if point.is_nan() {
                let nowhere = one.distance.is_nan() || one.distance == f32::INFINITY;
                assert!(nowhere, "{point}: {one:?}");
            }
        }
    }
}

/// What a part is, in words of its own: a ball, a box or a segment with a radius.
#[derive(Clone, Copy)]
enum Truth {
    Ball(f64),
    Box(DVec3),
    Capsule(f64, f64),
}

impl Truth {
    fn solid(self) -> Arc<dyn SignedDistance> {
        match self {
            Self::Ball(radius) => Arc::new(Sphere::new(radius as f32)),
            Self::Box(half) => Arc::new(Cuboid { half_size: half.as_vec3() }),
            Self::Capsule(radius, half) => {
                Arc::new(Capsule3d { radius: radius as f32, half_length: half as f32 })
            }
        }
    }

    fn distance(self, p: DVec3) -> f64 {
        match self {
            Self::Ball(radius) => p.length() - radius,
            Self::Capsule(radius, half) => p.distance(DVec3::Y * p.y.clamp(-half, half)) - radius,
            Self::Box(half) => {
                let depth = (half - p.abs()).min_element();
                if depth > 0.0 { -depth } else { p.distance(p.clamp(-half, half)) }
            }
        }
    }
}

/// Parts here and there: turned, some inside others, and far from the origin for their size.
fn scene(count: usize, dice: &mut Dice) -> Vec<(Truth, Vec3, Quat)> {
    let part = |i: usize| {
        let truth = match i % 3 {
            0 => Truth::Ball(dice.between(0.1, 0.4)),
            1 => Truth::Box(DVec3::splat(0.3) + 0.2 * dice.in_box(1.0)),
            _ => Truth::Capsule(dice.between(0.05, 0.2), dice.between(0.1, 0.5)),
        };
        let turn = DQuat::from_axis_angle(dice.direction(), dice.between(0.0, 3.0));
        (truth, dice.in_box(1.0).as_vec3(), turn.as_quat())
    };
    (0..count).map(part).collect()
}

fn compound(scene: &[(Truth, Vec3, Quat)]) -> Compound {
    let part = |&(truth, translation, rotation): &(Truth, Vec3, Quat)| Part {
        solid: truth.solid(),
        translation,
        rotation,
    };
    Compound::new(scene.iter().map(part)).unwrap()
}

/// The distance is the least of the parts'; see [`hold_to`].
#[test]
fn compounds_are_as_near_as_their_nearest_part() {
    let mut dice = Dice(40);
    for count in [1, 2, 7, 40, 300] {
        let scene = scene(count, &mut dice);
        let truth = |p: DVec3| {
            let part = |&(truth, t, q): &(Truth, Vec3, Quat)| {
                truth.distance(q.as_dquat().normalize().inverse() * (p - t.as_dvec3()))
            };
            scene.iter().map(part).fold(f64::INFINITY, f64::min)
        };
        let solid = compound(&scene);
        hold_to(&solid, 1.0, count as u64, truth, |_| true);

        let bounds = solid.bounds().unwrap();
        for _ in 0..3_000 {
            let p = dice.in_box(2.0);
            if truth(p) < 0.0 {
                let p = p.as_vec3a();
                assert!(p.cmpge(bounds.min).all() && p.cmple(bounds.max).all(), "{p}");
            }
        }
    }
}

/// A part without a box is never passed over, and takes the box of the whole.
#[test]
fn compounds_may_hold_half_spaces() {
    let mut dice = Dice(41);
    let scene = scene(6, &mut dice);
    let tilt = Quat::from_rotation_x(0.4);
    let mut parts: Vec<Part> = scene
        .iter()
        .map(|&(truth, translation, rotation)| Part { solid: truth.solid(), translation, rotation })
        .collect();
    parts.insert(3, Part::new(InfinitePlane3d::default(), Vec3::NEG_Y, tilt));
    let solid = Compound::new(parts).unwrap();
    assert!(solid.bounds().is_none());
    let others = compound(&scene);
    let normal = tilt.as_dquat() * DVec3::Y;
    for _ in 0..10_000 {
        let p = somewhere(&mut dice, 1.0);
        let plane = normal.dot(p.as_dvec3() + DVec3::Y);
        let truth = plane.min(f64::from(others.distance(p)));
        let found = f64::from(solid.distance(p));
        assert!((found - truth).abs() < 2e-6 * (1.0 + p.as_dvec3().length()), "{p}");
    }
    blocks_are_points(&solid, 1.0, 42);
}

/// What the solver takes on trust is the worst of the parts'.
#[test]
fn compounds_promise_no_more_than_their_parts() {
    let at = |solid: Arc<dyn SignedDistance>, x: f32| Part {
        solid,
        translation: Vec3::X * x,
        rotation: Quat::IDENTITY,
    };
    let balls = [at(Arc::new(Sphere::new(0.5)), 0.0), at(Arc::new(Sphere::new(0.2)), 2.0)];
    let solid = Compound::new(balls.clone()).unwrap();
    assert_eq!((solid.least_radius(), solid.core_depth(), solid.overestimate()), (0.2, 0.0, 0.0));
    assert_eq!(solid.part_count(), 2);
    let bounds = solid.bounds().unwrap();
    assert!((Vec3::from(bounds.max) - Vec3::new(2.2, 0.5, 0.5)).length() < 1e-6);

    #[derive(Debug)]
    struct Rough;
    impl SignedDistance for Rough {
        fn sample(&self, point: Vec3) -> bevy_drape::sdf::SdfSample {
            Sphere::new(0.5).sample(point)
        }
        fn bounds(&self) -> Option<bevy::math::bounding::Aabb3d> {
            None
        }
        fn overestimate(&self) -> f32 {
            0.03
        }
    }
    let solid = Compound::new(balls.into_iter().chain([at(Arc::new(Rough), 1.0)])).unwrap();
    assert_eq!((solid.least_radius(), solid.overestimate()), (0.0, 0.03));
    let swollen = Rounded::new(Rough, 0.1);
    assert_eq!((swollen.least_radius(), swollen.overestimate()), (0.0, 0.03));
}

/// What is no compound is told.
#[test]
fn compounds_are_checked() {
    assert_eq!(Compound::new([]).unwrap_err(), CompoundError::NoParts);
    let part = |t, q| Compound::new([Part::new(Sphere::new(1.0), t, q)]);
    assert!(part(Vec3::ONE, Quat::from_xyzw(0.0, 0.6, 0.0, 0.8)).is_ok());
    for bad in [f32::NAN, f32::INFINITY, -1e8] {
        let error = part(Vec3::new(0.0, bad, 0.0), Quat::IDENTITY).unwrap_err();
        assert!(matches!(error, CompoundError::Translation { part: 0, .. }), "{error}");
    }
    for bad in [f32::NAN, f32::INFINITY, 0.0, 2.0] {
        let error = part(Vec3::ZERO, Quat::from_xyzw(0.0, 0.0, 0.0, bad)).unwrap_err();
        assert!(matches!(error, CompoundError::Rotation { part: 0, .. }), "{error}");
    }
}

/// A box of a box and a radius; a ball of a point and a radius.
#[test]
fn rounded_solids_are_swollen() {
    let half = DVec3::new(0.5, 0.2, 0.8);
    let inner = Truth::Box(half);
    let solid = Rounded { solid: inner.solid(), radius: 0.25 };
    hold_to(&solid, 1.0, 50, |p| inner.distance(p) - 0.25, |_| true);
    assert_eq!((solid.core_depth(), solid.least_radius()), (0.45, 0.25));
    let bounds = solid.bounds().unwrap();
    assert!((Vec3::from(bounds.max) - Vec3::new(0.75, 0.45, 1.05)).length() < 1e-6);

    let ball = Rounded::new(Sphere::new(0.25), 0.5);
    let same = Sphere::new(0.75);
    assert_eq!((ball.core_depth(), ball.least_radius()), (0.75, 0.75));
    let mut dice = Dice(51);
    for _ in 0..1_000 {
        let p = somewhere(&mut dice, 1.0);
        let off = (ball.distance(p) - same.distance(p)).abs();
        assert!(off < 1e-6 * (1.0 + p.length()), "{p}");
    }
    // Numbers that are none do no harm.
    for radius in [f32::NAN, f32::INFINITY, -1.0] {
        let odd = Rounded::new(Sphere::new(0.25), radius);
        assert!(odd.sample(Vec3::ONE).normal.is_normalized());
        assert!(odd.core_depth() >= 0.0 && odd.least_radius() >= 0.0);
    }
}
