//! Capsules fitted to surfaces. Truths: a capsule is its own best capsule; two limbs are two capsules; a body's vertices are near its
//! capsules, whatever its units; each capsule is in the frame of its joint.

use bevy::math::{Affine3A, Quat, Vec3};
use bevy_drape::sdf::{
    SignedDistance,
    fit::{BodySurface, JointCapsule, SurfacePoint, fit_body, fit_capsules},
    shapes::CapsuleBetween,
};
use std::f32::consts::{PI, TAU};

/// Rings around a capsule, from end to end, and the triangles between them.
fn surface(capsule: CapsuleBetween) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    const AROUND: usize = 16;
    const RINGS: usize = 24;
    let CapsuleBetween { from, to, radius } = capsule;
    let axis = (to - from).normalize_or(Vec3::Y);
    let (side, other) = axis.any_orthonormal_pair();
    let mut points = Vec::new();
    for ring in 0..RINGS {
        // A quarter of the rings in each cap.
        let part = ring as f32 / (RINGS - 1) as f32;
        let (middle, angle) = match part {
            p if p < 0.25 => (from, -PI / 2.0 + p * TAU),
            p if p > 0.75 => (to, (p - 0.75) * TAU),
            p => (from.lerp(to, 2.0 * p - 0.5), 0.0),
        };
        for step in 0..AROUND {
            let (sin, cos) = (TAU * step as f32 / AROUND as f32).sin_cos();
            let out = (side * cos + other * sin) * angle.cos() + axis * angle.sin();
            points.push(middle + out * radius);
        }
    }
    let mut triangles = Vec::new();
    for ring in 0..RINGS - 1 {
        for step in 0..AROUND {
            let at = |ring: usize, step: usize| (ring * AROUND + step % AROUND) as u32;
            let [a, b] = [at(ring, step), at(ring, step + 1)];
            let [c, d] = [at(ring + 1, step), at(ring + 1, step + 1)];
            triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    (points, triangles)
}

fn evenly(points: Vec<Vec3>) -> Vec<SurfacePoint> {
    points.into_iter().map(|point| SurfacePoint { point, area: 0.01 }).collect()
}

fn is_near(found: CapsuleBetween, expected: CapsuleBetween, tolerance: f32) -> bool {
    let ends = |a: Vec3, b: Vec3| a.distance(expected.from).max(b.distance(expected.to));
    let ends = ends(found.from, found.to).min(ends(found.to, found.from));
    ends < tolerance && (found.radius - expected.radius).abs() < tolerance
}

/// An arm, a ball, and a stick, at three sizes.
#[test]
fn a_capsule_is_its_own_best_capsule() {
    let (from, to) = (Vec3::new(0.2, 1.0, -0.3), Vec3::new(0.5, 0.6, 0.1));
    for (to, radius) in [(to, 0.12), (from, 0.3), (to, 0.01)] {
        for size in [0.01, 1.0, 100.0] {
            let expected =
                CapsuleBetween { from: from * size, to: to * size, radius: radius * size };
            let (points, _) = surface(expected);
            let [found] = fit_capsules(&evenly(points), 0.01 * size, 4)[..] else {
                panic!("one is enough")
            };
            assert!(is_near(found, expected, 2e-3 * size), "{found:?} {expected:?}");
        }
    }
}

#[test]
fn a_tube_is_as_long_as_its_skin() {
    let radius = 0.1;
    let ring = |i: usize| {
        let (sin, cos) = (TAU * i as f32 / 16.0).sin_cos();
        Vec3::new(radius * cos, (i / 16) as f32 * 0.05, radius * sin)
    };
    let [found] = fit_capsules(&evenly((0..16 * 9).map(ring).collect()), 0.01, 4)[..] else {
        panic!("one is enough")
    };
    let expected = CapsuleBetween { from: Vec3::ZERO, to: Vec3::Y * 0.4, radius };
    assert!(is_near(found, expected, 0.01), "{found:?}");
}

#[test]
fn two_limbs_are_two_capsules_where_two_are_allowed() {
    let upper = CapsuleBetween { from: Vec3::ZERO, to: Vec3::X * 0.5, radius: 0.08 };
    let lower = CapsuleBetween { from: Vec3::Y * 0.9, to: Vec3::new(0.0, 0.9, 0.5), radius: 0.05 };
    let points: Vec<_> = [upper, lower].into_iter().flat_map(|it| surface(it).0).collect();
    let points = evenly(points);
    let found = fit_capsules(&points, 0.01, 4);
    assert_eq!(found.len(), 2, "{found:?}");
    for expected in [upper, lower] {
        assert!(found.iter().any(|it| is_near(*it, expected, 5e-3)), "{found:?}");
    }
    assert_eq!(fit_capsules(&points, 1.0, 4).len(), 1, "near enough as it is");
    let [one] = fit_capsules(&points, 0.01, 1)[..] else { panic!("one was allowed") };
    let outside = points.iter().filter(|it| one.sample(it.point).distance > 0.016).count();
    assert!(outside as f32 <= 0.03 * points.len() as f32, "{outside} of {}", points.len());
}

/// Skin that pokes out is seen, a capsule that is too wide is not: that of a flat limb is nearer to its width than to its thickness.
#[test]
fn a_flat_limb_is_covered() {
    let round = surface(CapsuleBetween { from: Vec3::ZERO, to: Vec3::X * 0.5, radius: 0.1 }).0;
    let flat = round.into_iter().map(|it| it * Vec3::new(1.0, 0.7, 1.0));
    let [found] = fit_capsules(&evenly(flat.collect()), 0.02, 1)[..] else { panic!("one") };
    // The mean of its half width and its half thickness is 0.085.
    assert!(found.radius > 0.09 && found.radius < 0.1, "{found:?}");
}

#[test]
fn no_surface_has_no_capsule() {
    assert_eq!(fit_capsules(&[], 0.01, 4), []);
    let lost = SurfacePoint { point: Vec3::NAN, area: f32::NAN };
    assert_eq!(fit_capsules(&[lost], 0.01, 4), []);
    // A point and a flat patch have one, however thin.
    let points = evenly(vec![Vec3::ONE]);
    assert!(fit_capsules(&points, 0.01, 4).iter().all(|it| it.radius.is_finite()));
}

/// An upper arm, a forearm and a finger, as a mesh of `size`, bound by joints that are turned.
#[test]
fn a_body_has_capsules_on_its_joints_in_their_frames() {
    for size in [1.0, 100.0] {
        let bone = |from: f32, to: f32, radius: f32| CapsuleBetween {
            from: Vec3::X * from * size,
            to: Vec3::X * to * size,
            radius: radius * size,
        };
        let bones = [bone(0.0, 0.3, 0.06), bone(0.33, 0.6, 0.05), bone(0.65, 0.66, 0.004)];
        let (mut points, mut triangles, mut owners) = (Vec::new(), Vec::new(), Vec::new());
        for (joint, bone) in bones.into_iter().enumerate() {
            let (new, between) = surface(bone);
            let first = points.len() as u32;
            owners.extend(vec![joint as u16; new.len()]);
            points.extend(new);
            triangles.extend(between.into_iter().map(|it| it.map(|vertex| vertex + first)));
        }
        let turn = |i: usize| Quat::from_rotation_z(0.4 + i as f32);
        let inverse_bindposes = [0, 1, 2]
            .map(|i| Affine3A::from_rotation_translation(turn(i), bones[i].from).inverse());
        // In the skeleton, the hand's joints come in another order.
        let surface = BodySurface {
            points: &points,
            triangles: &triangles,
            owners: &owners,
            joints: &[2, 0, 3],
            inverse_bindposes: &inverse_bindposes,
        };
        let parents = [Some(2), None, Some(1), Some(0)];
        let found = fit_body(&[surface], &parents);
        // The finger goes with the forearm.
        assert!(found.iter().all(|it| [0, 2].contains(&it.joint)), "{found:?}");
        let upper: Vec<_> = found.iter().filter(|it| it.joint == 2).collect();
        let [JointCapsule { capsule, .. }] = upper[..] else { panic!("{found:?}") };
        let along = turn(0).inverse() * Vec3::X * 0.3 * size;
        let expected = CapsuleBetween { from: Vec3::ZERO, to: along, radius: 0.06 * size };
        assert!(is_near(*capsule, expected, 2e-3 * size), "{capsule:?} {expected:?}");
        let in_mesh = |joint: usize| inverse_bindposes[[1, 3, 0, 2][joint]];
        let distance = |point: &Vec3| {
            let to =
                |it: &JointCapsule| it.capsule.sample(in_mesh(it.joint).transform_point3(*point));
            found.iter().map(|it| to(it).distance).fold(f32::MAX, f32::min)
        };
        let outside = points.iter().filter(|point| distance(point) > 0.02 * size).count();
        assert!(outside as f32 <= 0.05 * points.len() as f32, "{outside} of {}", points.len());
    }
}

/// Two limbs on one joint, and a thumb of two joints on the second of them, which is as small: at any size two capsules, both on the
/// joint.
#[test]
fn what_is_small_goes_up_as_far_as_there_is_anything_large() {
    for size in [0.01, 1.0, 100.0] {
        let limb = |from: Vec3, to: Vec3, radius: f32| CapsuleBetween {
            from: from * size,
            to: to * size,
            radius: radius * size,
        };
        let thumb = Vec3::new(0.5, 0.0, 0.0);
        let limbs = [
            (0, limb(Vec3::ZERO, Vec3::X * 0.5, 0.08)),
            (0, limb(Vec3::Y * 0.9, Vec3::new(0.0, 0.9, 0.5), 0.05)),
            (1, limb(thumb, thumb + Vec3::X * 0.01, 0.004)),
            (2, limb(thumb, thumb + Vec3::X * 0.02, 0.004)),
        ];
        let (mut points, mut triangles, mut owners) = (Vec::new(), Vec::new(), Vec::new());
        for (joint, limb) in limbs {
            let (new, between) = surface(limb);
            let first = points.len() as u32;
            owners.extend(vec![joint; new.len()]);
            points.extend(new);
            triangles.extend(between.into_iter().map(|it| it.map(|vertex| vertex + first)));
        }
        let surface = BodySurface {
            points: &points,
            triangles: &triangles,
            owners: &owners,
            joints: &[0, 1, 2],
            inverse_bindposes: &[Affine3A::IDENTITY; 3],
        };
        let found = fit_body(&[surface], &[None, Some(0), Some(1)]);
        let joints: Vec<_> = found.iter().map(|it| it.joint).collect();
        assert_eq!(joints, [0, 0], "{found:?}");
    }
}
