//! Shapes and blocks.

use crate::{meshes::*, support::dice::Dice};
use bevy::math::{DVec3, Vec3, bounding::BoundingVolume, primitives::*};
use bevy_drape::sdf::shapes::CapsuleBetween;
use bevy_drape::sdf::{LANES, PointBlock, SampleBlock, SignedDistance};
use core::f64::consts::TAU;

fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

/// A shape with its surface, written down apart from its distance.
struct Case {
    name: &'static str,
    shape: Box<dyn SignedDistance>,
    /// A random point of the surface and the normal there.
    surface: fn(&mut Dice) -> (DVec3, DVec3),
    inside: fn(DVec3) -> bool,
    /// How far one may go in along the normal, from any point of the surface, and how far out.
    reach: [f64; 2],
}

fn around(angle: f64) -> DVec3 {
    DVec3::new(angle.cos(), 0.0, angle.sin())
}

fn cases() -> Vec<Case> {
    vec![
        Case {
            name: "sphere",
            shape: Box::new(Sphere::new(0.7)),
            surface: |r| {
                let n = r.direction();
                (0.7 * n, n)
            },
            inside: |p| p.length() < 0.7,
            reach: [0.6, 3.0],
        },
        Case {
            name: "cuboid",
            shape: Box::new(Cuboid::new(0.8, 1.2, 1.0)),
            surface: |r| {
                let half = DVec3::new(0.4, 0.6, 0.5);
                let axis = (3.0 * r.unit()) as usize;
                let mut p = r.in_box(1.0) * half;
                let mut n = DVec3::ZERO;
                n[axis] = if r.unit() < 0.5 { -1.0 } else { 1.0 };
                p[axis] = n[axis] * half[axis];
                (p, n)
            },
            inside: |p| p.x.abs() < 0.4 && p.y.abs() < 0.6 && p.z.abs() < 0.5,
            reach: [0.0, 3.0],
        },
        Case {
            name: "capsule",
            shape: Box::new(Capsule3d::new(0.3, 1.0)),
            surface: |r| {
                if r.unit() < 0.5 {
                    let n = r.direction();
                    (0.3 * n + DVec3::Y * 0.5 * n.y.signum(), n)
                } else {
                    let n = around(r.between(0.0, TAU));
                    (0.3 * n + DVec3::Y * r.between(-0.5, 0.5), n)
                }
            },
            inside: |p| (p - DVec3::Y * p.y.clamp(-0.5, 0.5)).length() < 0.3,
            reach: [0.25, 3.0],
        },
        Case {
            name: "cylinder",
            shape: Box::new(Cylinder::new(0.4, 1.0)),
            surface: |r| {
                let n = around(r.between(0.0, TAU));
                if r.unit() < 0.5 {
                    (0.4 * n + DVec3::Y * r.between(-0.5, 0.5), n)
                } else {
                    let side = if r.unit() < 0.5 { -1.0 } else { 1.0 };
                    (0.4 * r.unit().sqrt() * n + DVec3::Y * 0.5 * side, DVec3::Y * side)
                }
            },
            inside: |p| p.x.hypot(p.z) < 0.4 && p.y.abs() < 0.5,
            reach: [0.0, 3.0],
        },
        Case {
            name: "torus",
            shape: Box::new(Torus { minor_radius: 0.2, major_radius: 0.6 }),
            surface: |r| {
                let (out, angle) = (around(r.between(0.0, TAU)), r.between(0.0, TAU));
                let n = angle.cos() * out + DVec3::Y * angle.sin();
                (0.6 * out + 0.2 * n, n)
            },
            inside: |p| (p.x.hypot(p.z) - 0.6).hypot(p.y) < 0.2,
            reach: [0.15, 0.35],
        },
        Case {
            name: "cone",
            shape: Box::new(Cone::new(0.5, 1.2)),
            surface: |r| {
                let out = around(r.between(0.0, TAU));
                if r.unit() < 0.6 {
                    let down = r.unit().sqrt();
                    let n = (1.2 * out + 0.5 * DVec3::Y).normalize();
                    (0.5 * down * out + DVec3::Y * (0.6 - 1.2 * down), n)
                } else {
                    (0.5 * r.unit().sqrt() * out - DVec3::Y * 0.6, -DVec3::Y)
                }
            },
            inside: |p| p.y > -0.6 && p.x.hypot(p.z) < 0.5 * (0.6 - p.y) / 1.2,
            reach: [0.0, 3.0],
        },
    ]
}

/// On the surface the distance is zero, and `s` further along the normal it is `s`.
#[test]
fn shapes_measure_along_their_normals() {
    let mut random = Dice(1);
    for case in cases() {
        for _ in 0..20_000 {
            let (on_surface, normal) = (case.surface)(&mut random);
            let s = random.between(-case.reach[0], case.reach[1]);
            let found = case.shape.sample((on_surface + s * normal).as_vec3());
            assert!(
                (f64::from(found.distance) - s).abs() < 2e-6,
                "{} at {s}: {found:?}",
                case.name
            );
            if s.abs() > 1e-2 {
                let angle = found.normal.as_dvec3().angle_between(normal);
                assert!(angle < 1e-4, "{} at {s}: {found:?}, not {normal}", case.name);
            }
            let at_surface = case.shape.distance(on_surface.as_vec3());
            assert!(at_surface.abs() < 5e-7, "{} on its surface: {at_surface}", case.name);
        }
    }
}

/// The distance is the least distance to the surface, near, inside and far; its sign says inside.
#[test]
fn shapes_measure_to_the_nearest_point() {
    let mut random = Dice(2);
    for case in cases() {
        let cloud: Vec<DVec3> = (0..40_000).map(|_| (case.surface)(&mut random).0).collect();
        for trial in 0..300 {
            let p = random.in_box(if trial % 10 == 0 { 1000.0 } else { 1.2 });
            let p = p.as_vec3().as_dvec3();
            let found = f64::from(case.shape.distance(p.as_vec3()));
            let least = cloud.iter().map(|s| s.distance(p)).fold(f64::INFINITY, f64::min);
            let rounding = 1e-6 * (1.0 + p.length());
            // Forty thousand points leave gaps of some 0.03 m; edges are met from one side only.
            assert!(found.abs() <= least + rounding, "{} at {p}: {found} > {least}", case.name);
            assert!(found.abs() >= least - 0.03, "{} at {p}: {found} < {least}", case.name);
            if found.abs() > 1e-5 {
                assert_eq!(found < 0.0, (case.inside)(p), "{} at {p}: {found}", case.name);
            }
        }
        let bounds = case.shape.bounds().expect("a bounded shape");
        for &s in &cloud {
            let s = s.as_vec3a();
            assert!(s.cmpge(bounds.min - 1e-6).all() && s.cmple(bounds.max + 1e-6).all());
        }
        let grown = bounds.shrink(bevy::math::Vec3A::splat(0.02));
        let escapes = cloud.iter().any(|s| s.as_vec3a().cmpgt(grown.max).any());
        assert!(escapes, "{}: its box is too large", case.name);
    }
}

/// The normal is the distance's gradient, by central differences, wherever that has length one.
#[test]
fn shapes_normals_are_gradients() {
    const STEP: f64 = 1e-3;
    let mut random = Dice(3);
    for case in cases() {
        let mut compared = 0;
        for _ in 0..5_000 {
            let p = random.in_box(1.2);
            let distance = |p: DVec3| f64::from(case.shape.distance(p.as_vec3()));
            let gradient = DVec3::from_array(core::array::from_fn(|axis| {
                let step = DVec3::AXES[axis] * STEP;
                (distance(p + step) - distance(p - step)) / (2.0 * STEP)
            }));
            let found = case.shape.sample(p.as_vec3()).normal.as_dvec3();
            assert!((found.length() - 1.0).abs() < 1e-6, "{}: {found}", case.name);
            // A difference across an edge or the medial axis is shorter.
            if (gradient.length() - 1.0).abs() < 1e-3 {
                compared += 1;
                assert!((found - gradient).length() < 0.03, "{} at {p}: {found}", case.name);
            }
        }
        assert!(compared > 4_500, "{}: only {compared} compared", case.name);
    }
}

/// A half-space is solid below its plane.
#[test]
fn half_space_is_solid_below() {
    let mut random = Dice(4);
    for _ in 0..1_000 {
        let normal = random.direction();
        let plane = InfinitePlane3d::new(normal.as_vec3());
        let across = normal.any_orthonormal_vector() * random.between(-5.0, 5.0);
        let s = random.between(-3.0, 3.0);
        let found = plane.sample((across + s * normal).as_vec3());
        assert!((f64::from(found.distance) - s).abs() < 3e-6);
        assert!((found.normal.as_dvec3() - normal).length() < 1e-6);
        assert!(plane.bounds().is_none());
    }
}

/// Where the gradient vanishes, and for coordinates that are no numbers, the normal is still a unit vector.
#[test]
fn normals_are_defined_everywhere() {
    let mut shapes: Vec<Box<dyn SignedDistance>> = cases().into_iter().map(|c| c.shape).collect();
    shapes.push(Box::new(InfinitePlane3d::default()));
    shapes.push(Box::new(bake(&sphere_mesh(8, 0.5), 0.1, 0.2)));
    shapes.push(Box::new(Sphere::new(0.0)));
    shapes.push(Box::new(Cone::new(0.0, 0.0)));
    shapes.push(Box::new(Cuboid::new(0.0, 0.0, 0.0)));
    let odd = [0.0, -0.0, 1e-30, 0.6, -0.5, 1e30, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    for shape in &shapes {
        for x in odd {
            for y in odd {
                for z in odd {
                    let p = Vec3::new(x, y, z);
                    let found = shape.sample(p);
                    let length = found.normal.length();
                    assert!((length - 1.0).abs() < 1e-5, "{shape:?} at {p}: {found:?}");
                    if p.is_nan() {
                        assert!(
                            found.distance.is_nan() || found.distance > 1.0,
                            "{shape:?} at {p}: {found:?}"
                        );
                    }
                }
            }
        }
    }
    assert_eq!(Sphere::new(0.7).sample(Vec3::ZERO).normal, Vec3::Y);
    assert_eq!(Cuboid::default().sample(Vec3::ZERO).normal, Vec3::Y);
}

/// A block gives the bits of its points, one by one.
#[test]
fn blocks_give_the_same_bits() {
    let mut shapes: Vec<Box<dyn SignedDistance>> = cases().into_iter().map(|c| c.shape).collect();
    shapes.push(Box::new(InfinitePlane3d::new(Vec3::new(0.3, 0.9, -0.2))));
    shapes.push(Box::new(bake(&sphere_mesh(8, 0.5), 0.1, 0.2)));
    let (from, to) = (Vec3::new(-0.3, -0.4, 0.1), Vec3::new(0.2, 0.5, -0.1));
    shapes.push(Box::new(CapsuleBetween { from, to, radius: 0.2 }));
    let odd = [0.0, -0.0, 1e-25, 0.5, -0.7, 3e4, f32::INFINITY, f32::NAN];
    let mut random = Dice(5);
    for shape in &shapes {
        for round in 0..2_000 {
            let mut points = PointBlock::default();
            for lane in 0..LANES {
                let p = random.in_box(if round % 3 == 0 { 3.0 } else { 0.65 }).as_vec3();
                (points.x[lane], points.y[lane], points.z[lane]) = (p.x, p.y, p.z);
                if round % 4 == 0 {
                    let pick = |random: &mut Dice| odd[(odd.len() as f64 * random.unit()) as usize];
                    points.x[lane] = pick(&mut random);
                    points.z[lane] = pick(&mut random);
                }
            }
            let mut samples = SampleBlock::default();
            let mut distances = [0.0; LANES];
            shape.sample_block(&points, &mut samples);
            shape.distance_block(&points, &mut distances);
            for (lane, &distance) in distances.iter().enumerate() {
                let p = points.point(lane);
                let one = shape.sample(p);
                assert!(same(samples.distance[lane], one.distance), "{shape:?} at {p}");
                assert!(same(distance, one.distance), "{shape:?} at {p}");
                assert!(same(shape.distance(p), one.distance), "{shape:?} at {p}");
                assert!(same(samples.nx[lane], one.normal.x), "{shape:?} at {p}");
                assert!(same(samples.ny[lane], one.normal.y), "{shape:?} at {p}");
                assert!(same(samples.nz[lane], one.normal.z), "{shape:?} at {p}");
            }
        }
    }
}
