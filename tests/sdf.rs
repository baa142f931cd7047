//! Signed distances, held to truths that know nothing of the code.
//!
//! - Shapes: points made by parametrising their surfaces, with their normals; the least distance to a cloud
//!   of such points; inside and outside by the shape's inequality; central differences for the normal.
//! - Blocks: the single point's bits.
//! - Baked fields: a table of the errors that exact samples make (`data/sdf_error.csv`), analytic
//!   distances in `f64`, and on the bunny the least distance to all triangles and the winding number.

use bevy::math::{DVec3, UVec3, Vec3, bounding::BoundingVolume, primitives::*};
use bevy_drape::sdf::{
    BakeError, BakeSettings, DistanceField, LANES, PointBlock, SampleBlock, SignedDistance,
};
use core::f64::consts::{PI, TAU};

/// Where the meshes are moved to, so that nothing lies on a node.
const SHIFT: DVec3 = DVec3::new(0.013, 0.021, 0.007);

/// A linear congruential generator: the same numbers everywhere.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn in_box(&mut self, half: f64) -> DVec3 {
        DVec3::from_array(core::array::from_fn(|_| self.between(-half, half)))
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.in_box(1.0);
            if (0.1..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }
}

fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

/// A shape with its surface, written down apart from its distance.
struct Case {
    name: &'static str,
    shape: Box<dyn SignedDistance>,
    /// A random point of the surface and the normal there.
    surface: fn(&mut Random) -> (DVec3, DVec3),
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
    let mut random = Random(1);
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
    let mut random = Random(2);
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
    let mut random = Random(3);
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
    let mut random = Random(4);
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
    let odd = [0.0, -0.0, 1e-25, 0.5, -0.7, 3e4, f32::INFINITY, f32::NAN];
    let mut random = Random(5);
    for shape in &shapes {
        for round in 0..2_000 {
            let mut points = PointBlock::default();
            for lane in 0..LANES {
                let p = random.in_box(if round % 3 == 0 { 3.0 } else { 0.65 }).as_vec3();
                (points.x[lane], points.y[lane], points.z[lane]) = (p.x, p.y, p.z);
                if round % 4 == 0 {
                    let pick =
                        |random: &mut Random| odd[(odd.len() as f64 * random.unit()) as usize];
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

#[derive(Clone)]
struct Mesh {
    positions: Vec<Vec3>,
    indices: Vec<u32>,
}

impl Mesh {
    fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> {
        let corner = |i: &u32| self.positions[*i as usize].as_dvec3();
        self.indices.chunks_exact(3).map(move |t| [corner(&t[0]), corner(&t[1]), corner(&t[2])])
    }

    /// Every triangle with vertices of its own.
    fn unwelded(&self) -> Self {
        let positions = self.indices.iter().map(|&i| self.positions[i as usize]).collect();
        Self { positions, indices: (0..self.indices.len() as u32).collect() }
    }

    fn inside_out(&self) -> Self {
        let indices = self.indices.chunks_exact(3).flat_map(|t| [t[0], t[2], t[1]]).collect();
        Self { positions: self.positions.clone(), indices }
    }
}

/// A patch of `n` by `m` quads from a parametrisation by two numbers from 0 to 1; seams are left unwelded,
/// and so must meet in the same bits.
fn patch(mesh: &mut Mesh, n: u32, m: u32, point: impl Fn(f64, f64) -> DVec3) {
    let first = mesh.positions.len() as u32;
    for j in 0..=m {
        for i in 0..=n {
            let p = point(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m));
            mesh.positions.push(p.as_vec3());
        }
    }
    for j in 0..m {
        for i in 0..n {
            let corner = first + i + j * (n + 1);
            let (right, up) = (corner + 1, corner + n + 1);
            mesh.indices.extend([corner, right, up, right, up + 1, up]);
        }
    }
}

/// The six faces of the cube from -1 to 1, each as quads, moved by a function of the point.
fn cube(n: u32, place: impl Fn(DVec3) -> DVec3) -> Mesh {
    let mut mesh = Mesh { positions: Vec::new(), indices: Vec::new() };
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            patch(&mut mesh, n, n, |u, v| {
                let mut p = DVec3::ZERO;
                p[axis] = side;
                // Whole steps first, so that the faces meet in the same bits.
                p[(axis + 1) % 3] = (2.0 * u - 1.0) * side;
                p[(axis + 2) % 3] = 2.0 * v - 1.0;
                place(p)
            });
        }
    }
    mesh
}

/// A sphere, from a cube's faces spread by the tangent so that its triangles are nearly alike.
fn sphere_mesh(n: u32, radius: f64) -> Mesh {
    cube(n, |p| {
        let spread = p.to_array().map(|c| (c * PI / 4.0).tan());
        SHIFT + radius * DVec3::from_array(spread).normalize()
    })
}

fn box_mesh(half: DVec3) -> Mesh {
    cube(1, |p| SHIFT + half * p)
}

fn torus_mesh(major: f64, minor: f64, n: u32, m: u32) -> Mesh {
    let mut mesh = Mesh { positions: Vec::new(), indices: Vec::new() };
    patch(&mut mesh, n, m, |u, v| {
        // The seam's two sides are the same point.
        let (u, v) = (TAU * (u % 1.0), TAU * (v % 1.0));
        let tube = major + minor * u.cos();
        SHIFT + DVec3::new(tube * v.cos(), minor * u.sin(), tube * v.sin())
    });
    mesh
}

fn bunny() -> Mesh {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/bunny.obj");
    let (models, _) = tobj::load_obj(path, &tobj::GPU_LOAD_OPTIONS).expect("the bunny");
    let mesh = &models[0].mesh;
    let positions = mesh.positions.chunks_exact(3).map(Vec3::from_slice).collect();
    Mesh { positions, indices: mesh.indices.clone() }
}

fn bake(mesh: &Mesh, cell_size: f32, margin: f32) -> DistanceField {
    let settings = BakeSettings { cell_size, margin };
    DistanceField::bake(&mesh.positions, &mesh.indices, &settings).expect("a sound mesh")
}

/// Least distance to all triangles, by projection and segments.
fn least_distance(mesh: &Mesh, p: DVec3) -> f64 {
    let to_segment = |a: DVec3, b: DVec3| {
        let share = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a.lerp(b, share))
    };
    let to_triangle = |[a, b, c]: [DVec3; 3]| {
        let normal = (b - a).cross(c - a).normalize();
        let within = |a: DVec3, b: DVec3| (b - a).cross(p - a).dot(normal) >= 0.0;
        if within(a, b) && within(b, c) && within(c, a) {
            normal.dot(p - a).abs()
        } else {
            to_segment(a, b).min(to_segment(b, c)).min(to_segment(c, a))
        }
    };
    mesh.triangles().map(to_triangle).fold(f64::INFINITY, f64::min)
}

/// How often the surface is wound around a point (van Oosterom and Strackee 1983): 1 inside, 0 outside.
fn winding(mesh: &Mesh, p: DVec3) -> f64 {
    let solid_angle = |triangle: [DVec3; 3]| {
        let [a, b, c] = triangle.map(|corner| corner - p);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    mesh.triangles().map(solid_angle).sum::<f64>() / (2.0 * TAU)
}

/// Distance and normal in closed form, in `f64`.
type Truth = fn(DVec3) -> (f64, DVec3);

fn true_sphere(p: DVec3) -> (f64, DVec3) {
    let q = p - SHIFT;
    (q.length() - 0.5, q.normalize())
}

fn true_torus(p: DVec3) -> (f64, DVec3) {
    let q = p - SHIFT;
    let ring = DVec3::new(q.x, 0.0, q.z).normalize() * 0.5;
    ((q - ring).length() - 0.2, (q - ring).normalize())
}

fn true_box(p: DVec3) -> (f64, DVec3) {
    let q = p - SHIFT;
    let beyond = q.abs() - DVec3::new(0.4, 0.5, 0.3);
    if beyond.max_element() > 0.0 {
        let out = beyond.max(DVec3::ZERO);
        return (out.length(), out.normalize() * q.signum());
    }
    let axis = DVec3::AXES[beyond.max_position()];
    (beyond.max_element(), axis * q.signum())
}

fn meshes() -> [(&'static str, Mesh, Truth); 3] {
    // So fine that a facet is a hundredth of the interpolation's error away from the shape.
    [
        ("sphere", sphere_mesh(112, 0.5), true_sphere),
        ("torus", torus_mesh(0.5, 0.2, 112, 224), true_torus),
        ("box", box_mesh(DVec3::new(0.4, 0.5, 0.3)), true_box),
    ]
}

/// Largest and rms error in cells, and rms angle in degrees, within two cells of the surface.
fn band_error(field: &DistanceField, truth: Truth) -> [f64; 3] {
    let h = f64::from(field.cell_size());
    let mut random = Random(7);
    let (mut largest, mut squares, mut angles, mut count) = (0.0_f64, 0.0, 0.0, 0.0);
    for _ in 0..200_000 {
        let p = random.in_box(0.95).as_vec3();
        let (distance, normal) = truth(p.as_dvec3());
        if distance.abs() < 2.0 * h {
            let found = field.sample(p);
            let error = (f64::from(found.distance) - distance) / h;
            largest = largest.max(error.abs());
            squares += error * error;
            angles += found.normal.as_dvec3().angle_between(normal).to_degrees().powi(2);
            count += 1.0;
        }
    }
    [largest, (squares / count).sqrt(), (angles / count).sqrt()]
}

/// Baked fields are as good as exact samples, for smooth and for edged shapes: at most 1.2 times the table.
#[test]
fn baked_fields_err_no_more_than_exact_samples() {
    let table: Vec<(&str, u32, [f64; 3])> = include_str!("data/sdf_error.csv")
        .lines()
        .filter(|line| !line.starts_with('#') && !line.starts_with("shape"))
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |i: usize| cells[i].parse::<f64>().expect("a number");
            (cells[0], number(1) as u32, [number(2), number(3), number(4)])
        })
        .collect();
    assert_eq!(table.len(), 9);
    let meshes = meshes();
    let mut sphere_rms = Vec::new();
    for (name, n, expected) in table {
        let (_, mesh, truth) = meshes.iter().find(|m| m.0 == name).expect("a shape of the table");
        let h = 2.0 / n as f32;
        let found = band_error(&bake(mesh, h, 2.1 * h), *truth);
        for (one, bound) in found.iter().zip(expected) {
            assert!(*one <= 1.2 * bound, "{name} {n}: {found:?}, table {expected:?}");
        }
        if name == "sphere" {
            sphere_rms.push(found[1] * f64::from(h));
        }
    }
    for pair in sphere_rms.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(order >= 1.9, "order {order}");
    }
}

/// Every node has the true distance and sign, to the facets' own error.
#[test]
fn baked_nodes_are_exact() {
    for (name, mesh, truth) in meshes() {
        let field = bake(&mesh, 1.0 / 16.0, 0.3);
        let dims = field.dims();
        let mut values = field.values().iter();
        for z in 0..dims.z {
            for y in 0..dims.y {
                for x in 0..dims.x {
                    let node = field.node(UVec3::new(x, y, z)).as_dvec3();
                    let (distance, _) = truth(node);
                    let found = f64::from(*values.next().expect("a value per node"));
                    let error = (found - distance).abs();
                    assert!(error < 2.5e-4, "{name} at {node}: {found}, not {distance}");
                    if distance.abs() > 0.5 / 16.0 {
                        assert_eq!(found < 0.0, distance < 0.0, "{name} at {node}");
                    }
                }
            }
        }
        assert!(values.next().is_none());
        assert!(field.memory_bytes() >= 4 * dims.element_product() as usize);
    }
}

/// Off the medial axis the interpolated distance rises by 1 m per metre.
#[test]
fn baked_slope_is_one() {
    const STEP: f64 = 1e-3;
    let field = bake(&sphere_mesh(48, 0.5), 1.0 / 32.0, 0.3);
    let mut random = Random(8);
    for _ in 0..20_000 {
        let p = SHIFT + random.direction() * random.between(0.25, 0.75);
        let distance = |p: DVec3| f64::from(field.distance(p.as_vec3()));
        let slope = DVec3::from_array(core::array::from_fn(|axis| {
            let step = DVec3::AXES[axis] * STEP;
            (distance(p + step) - distance(p - step)) / (2.0 * STEP)
        }));
        assert!((0.9..=1.1).contains(&slope.length()), "{slope} at {p}");
        let normal = field.sample(p.as_vec3()).normal.as_dvec3();
        // A step may straddle two cells, whose gradients differ by a few degrees.
        assert!(normal.angle_between(slope) < 0.15, "{normal} and {slope} at {p}");
    }
}

/// On the bunny the nodes have the least distance to all triangles, and the winding number's sign.
#[test]
fn bunny_nodes_equal_brute_force() {
    let mesh = bunny();
    let settings = BakeSettings::for_mesh(&mesh.positions, 64);
    let field = DistanceField::bake(&mesh.positions, &mesh.indices, &settings).expect("the bunny");
    let dims = field.dims();
    assert!((68..=70).contains(&dims.max_element()), "{dims}");
    let mut random = Random(9);
    let mut inside = 0;
    for _ in 0..3_000 {
        let index = (DVec3::splat(0.5) + 0.5 * random.in_box(1.0)) * dims.as_dvec3();
        let index = index.as_uvec3();
        let node = field.node(index).as_dvec3();
        let place = index.x + dims.x * (index.y + dims.y * index.z);
        let found = f64::from(field.values()[place as usize]);
        let least = least_distance(&mesh, node);
        assert!((found.abs() - least).abs() < 1e-6, "{found}, not {least}, at {node}");
        if least > 1e-5 {
            let is_inside = winding(&mesh, node) > 0.5;
            assert_eq!(found < 0.0, is_inside, "{found} at {node}");
            inside += u32::from(is_inside);
        }
    }
    assert!(inside > 300, "only {inside} nodes were inside");
}

/// Outside the grid the distance never exceeds the true one, joins the grid without a step, and grows.
#[test]
fn far_field_is_a_growing_lower_bound() {
    let mesh = bunny();
    let field = bake(&mesh, 1.0 / 32.0, 0.05);
    let grid = field.grid_bounds();
    let (low, high) = (Vec3::from(grid.min).as_dvec3(), Vec3::from(grid.max).as_dvec3());
    let mut random = Random(10);
    let mut at_best = 0.0_f64;
    for _ in 0..1_500 {
        let scale = 10.0_f64.powf(random.between(-1.0, 1.5));
        let p = 0.5 * (low + high) + random.in_box(1.0) * (0.6 + scale);
        let gap = p.distance(p.clamp(low, high));
        let found = field.sample(p.as_vec3());
        let least = least_distance(&mesh, p);
        if gap > 0.03 {
            assert!(f64::from(found.distance) <= least, "{} > {least} at {p}", found.distance);
            at_best = at_best.max(f64::from(found.distance) / least);
            // Along the normal one gets away from the mesh, half as fast as possible at least.
            let further = least_distance(&mesh, p + 1e-3 * found.normal.as_dvec3());
            let outward = (further - least) / 1e-3;
            assert!(outward > 0.5, "{found:?} at {p}");
        }
    }
    assert!(at_best > 0.99, "the bound is never close: {at_best}");

    for _ in 0..500 {
        // From a point of the box's surface straight out: along one, two or three axes.
        let mut start = low + (high - low) * (DVec3::splat(0.5) + 0.5 * random.in_box(1.0));
        let mut out = DVec3::ZERO;
        for axis in 0..3 {
            match (3.0 * random.unit()) as u32 {
                0 => (out[axis], start[axis]) = (-random.unit(), low[axis]),
                1 => (out[axis], start[axis]) = (random.unit(), high[axis]),
                _ => {}
            }
        }
        let mut last = field.distance(start.clamp(low, high).as_vec3());
        let step = field.distance((start + 1e-5 * out).as_vec3()) - last;
        assert!(step.abs() < 5e-5, "a step of {step} at {start}");
        for k in 1..60 {
            let next = field.distance((start + out * (1e-3 * 1.3_f64.powi(k))).as_vec3());
            assert!(next >= last - 2e-6, "{next} after {last} from {start} along {out}");
            last = next;
        }
    }
}

/// The stated margin is a bound, and not a vain one: an edge comes to half of it.
#[test]
fn overestimate_bounds_the_error() {
    let bunny = bunny();
    let field = bake(&bunny, 1.0 / 24.0, 0.1);
    let mut random = Random(11);
    for _ in 0..3_000 {
        let p = (DVec3::new(0.0, 0.5, 0.0) + random.in_box(0.8)).as_vec3();
        let least = least_distance(&bunny, p.as_dvec3());
        let least = if winding(&bunny, p.as_dvec3()) > 0.5 { -least } else { least };
        let excess = f64::from(field.distance(p)) - least;
        assert!(excess <= f64::from(field.overestimate()), "{excess} at {p}");
    }

    let (_, mesh, truth) = &meshes()[2];
    let field = bake(mesh, 1.0 / 16.0, 0.2);
    let mut most = 0.0_f64;
    for _ in 0..100_000 {
        let p = random.in_box(1.0).as_vec3();
        most = most.max(f64::from(field.distance(p)) - truth(p.as_dvec3()).0);
    }
    let stated = f64::from(field.overestimate());
    assert!(most <= stated && most > 0.4 * stated, "{most} of {stated}");
    assert_eq!(Sphere::default().overestimate(), 0.0);
}

/// The same mesh gives the same bits: twice, with vertices of its own per triangle, and moved by whole cells.
#[test]
fn baking_is_repeatable() {
    let mesh = bunny();
    let field = bake(&mesh, 1.0 / 24.0, 0.1);
    let bits =
        |field: &DistanceField| field.values().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&field), bits(&bake(&mesh, 1.0 / 24.0, 0.1)));
    assert_eq!(bits(&field), bits(&bake(&mesh.unwelded(), 1.0 / 24.0, 0.1)));

    let coarse = bake(&sphere_mesh(8, 0.5), 0.125, 0.25);
    let mut moved = sphere_mesh(8, 0.5);
    for p in &mut moved.positions {
        *p = (*p * 4096.0).round() / 4096.0;
    }
    let rounded = bake(&moved, 0.125, 0.25);
    for p in &mut moved.positions {
        *p += Vec3::new(1.0, -0.5, 2.25);
    }
    assert_eq!(bits(&rounded), bits(&bake(&moved, 0.125, 0.25)));
    assert_ne!(bits(&coarse), bits(&rounded));

    let mut shares = Vec::new();
    let settings = BakeSettings { cell_size: 0.1, margin: 0.1 };
    let mut note = |share| shares.push(share);
    DistanceField::bake_with_progress(&mesh.positions, &mesh.indices, &settings, &mut note)
        .expect("the bunny");
    assert!(shares.is_sorted() && shares[0] == 0.0 && shares.last() == Some(&1.0), "{shares:?}");
}

/// A mesh that is inside out is turned, and triangles without area change nothing.
#[test]
fn flawed_but_sound_meshes_bake_alike() {
    let plain = box_mesh(DVec3::new(0.4, 0.5, 0.3));
    let expected = bake(&plain, 0.1, 0.2);
    let agree = |mesh: &Mesh, what: &str| {
        let found = bake(mesh, 0.1, 0.2);
        assert_eq!(found.dims(), expected.dims());
        for (a, b) in found.values().iter().zip(expected.values()) {
            assert!((a - b).abs() < 1e-6, "{what}: {a}, not {b}");
        }
    };
    agree(&plain.inside_out(), "inside out");

    let mut spiked = plain.clone();
    let (a, b) = (spiked.indices[0], spiked.indices[1]);
    spiked.indices.extend([a, b, b]);
    agree(&spiked, "an edge as a triangle");

    // Split each edge of the first triangle on its own side only; slivers fill the gaps. The first edge is a
    // knife's: the sign is wrong beside it if one face alone decides.
    let knife = [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 1.0, 0.08], [0.0, 1.0, -0.08]];
    let knife = Mesh {
        positions: knife.map(|p| Vec3::from_array(p) + SHIFT.as_vec3()).to_vec(),
        indices: vec![0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0],
    };
    let whole = bake(&knife, 0.1, 0.2);
    for edge in 0..3 {
        let mut split = knife.clone();
        let t = [0, 1, 2].map(|k| split.indices[(edge + k) % 3]);
        let [a, b] = [t[0], t[1]].map(|i| split.positions[i as usize]);
        let middle = split.positions.len() as u32;
        // A quarter of the way is met in the same bits, wherever the edge runs along an axis.
        split.positions.push(a + 0.25 * (b - a));
        split.indices.drain(0..3);
        split.indices.extend([t[0], middle, t[2], middle, t[1], t[2], t[0], t[1], middle]);
        let found = bake(&split, 0.1, 0.2);
        for (a, b) in found.values().iter().zip(whole.values()) {
            assert!((a - b).abs() < 1e-6, "a sliver at edge {edge}: {a}, not {b}");
        }
    }
}

/// Above a spike the sign is right, however finely one of its sides is cut up: the angles decide, not the
/// number of triangles.
#[test]
fn tips_have_the_right_sign() {
    let side = (0..=20).map(|k| Vec3::new(0.1, 0.0, 0.1 - 0.01 * k as f32));
    let ring: Vec<Vec3> =
        [Vec3::new(-0.1, 0.0, -0.1), Vec3::new(-0.1, 0.0, 0.1)].into_iter().chain(side).collect();
    let count = ring.len() as u32;
    let mut positions: Vec<Vec3> = ring.iter().map(|&p| p + SHIFT.as_vec3()).collect();
    positions.push(Vec3::Y + SHIFT.as_vec3());
    let sides = (0..count).flat_map(|k| [k, (k + 1) % count, count]);
    let floor = (1..count - 1).flat_map(|k| [0, k + 1, k]);
    let mesh = Mesh { positions, indices: sides.chain(floor).collect() };
    let field = bake(&mesh, 0.1, 0.3);
    let dims = field.dims();
    for (place, &found) in (0_u32..).zip(field.values()) {
        let index = UVec3::new(place % dims.x, place / dims.x % dims.y, place / dims.x / dims.y);
        let node = field.node(index).as_dvec3();
        if found.abs() > 1e-5 {
            assert_eq!(found < 0.0, winding(&mesh, node) > 0.5, "{found} at {node}");
        }
    }
}

/// Each flaw is refused by its own error, which says what to do.
#[test]
fn flawed_meshes_are_refused() {
    let sound = box_mesh(DVec3::splat(0.5));
    let settings = BakeSettings { cell_size: 0.1, margin: 0.1 };
    let refusal = |mesh: &Mesh, settings: BakeSettings| {
        DistanceField::bake(&mesh.positions, &mesh.indices, &settings).expect_err("a flaw")
    };
    let expect = |mesh: &Mesh, error: BakeError, hint: &str| {
        let found = refusal(mesh, settings);
        assert_eq!(found, error);
        assert!(found.to_string().contains(hint), "{found}");
    };
    let with = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = sound.clone();
        change(&mut mesh);
        mesh
    };

    let empty = Mesh { positions: Vec::new(), indices: Vec::new() };
    expect(&empty, BakeError::Empty, "no triangles");
    let partial = with(&|m| m.indices.truncate(35));
    expect(&partial, BakeError::PartialTriangle { index_count: 35 }, "triangle list");
    let past = with(&|m| m.indices[4] = 24);
    expect(&past, BakeError::IndexOutOfRange { index: 24, vertex_count: 24 }, "index buffer");
    let infinite = with(&|m| m.positions[3].y = f32::NAN);
    expect(&infinite, BakeError::NonFinite { index: 3 }, "repair");
    let holed = with(&|m| drop(m.indices.drain(0..3)));
    expect(&holed, BakeError::NotClosed { open_edges: 3 }, "fill its holes");
    let turned = with(&|m| m.indices.swap(0, 1));
    expect(&turned, BakeError::Inconsistent { edges: 3 }, "winding");
    let touching = with(&|m| {
        let first = m.positions.len() as u32;
        let step = Vec3::new(1.0, 1.0, 0.0);
        let corner = |p: Vec3| sound.positions.iter().copied().find(|q| q.distance(p) < 1e-4);
        for p in &sound.positions {
            m.positions.push(corner(*p + step).unwrap_or(*p + step));
        }
        m.indices.extend(sound.indices.iter().map(|i| i + first));
    });
    expect(&touching, BakeError::NonManifold { edges: 1 }, "separate");
    let flat = cube(2, |p| DVec3::new(p.x, p.y, 0.0));
    assert!(matches!(
        refusal(&flat, settings),
        BakeError::NoVolume | BakeError::NonManifold { .. }
    ));
    let mut sheet = Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], indices: vec![0, 1, 2] };
    sheet.indices.extend([0, 2, 1]);
    expect(&sheet, BakeError::NoVolume, "thickness");

    for cell_size in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-42] {
        let found = refusal(&sound, BakeSettings { cell_size, margin: 0.1 });
        assert!(matches!(found, BakeError::CellSize { .. }), "{found}");
    }
    for margin in [-0.1, f32::NAN, f32::INFINITY] {
        let found = refusal(&sound, BakeSettings { cell_size: 0.1, margin });
        assert!(matches!(found, BakeError::Margin { .. }), "{found}");
    }
    for settings in [
        BakeSettings { cell_size: 1e-4, margin: 0.1 },
        BakeSettings { cell_size: 1e-30, margin: 1e30 },
    ] {
        let found = refusal(&sound, settings);
        assert!(matches!(found, BakeError::TooLarge { .. }), "{found}");
        assert!(found.to_string().contains("larger cells"), "{found}");
    }
    let nowhere = BakeSettings::for_mesh(&[], 32);
    assert_eq!(refusal(&empty, nowhere), BakeError::Empty);
}
