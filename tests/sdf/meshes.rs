//! Meshes to bake, and the truth about them.

use crate::support::dice::Dice;
use bevy::math::{DVec3, Vec3};
use bevy_drape::sdf::{BakeSettings, DistanceField, SignedDistance};
use core::f64::consts::{PI, TAU};
use examples_common::repository;

/// Where the meshes are moved to, so that nothing lies on a node.
pub const SHIFT: DVec3 = DVec3::new(0.013, 0.021, 0.007);

#[derive(Clone)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    pub indices: Vec<u32>,
}

impl Mesh {
    pub fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> {
        let corner = |i: &u32| self.positions[*i as usize].as_dvec3();
        self.indices.chunks_exact(3).map(move |t| [corner(&t[0]), corner(&t[1]), corner(&t[2])])
    }

    /// Every triangle with vertices of its own.
    pub fn unwelded(&self) -> Self {
        let positions = self.indices.iter().map(|&i| self.positions[i as usize]).collect();
        Self { positions, indices: (0..self.indices.len() as u32).collect() }
    }

    pub fn inside_out(&self) -> Self {
        let indices = self.indices.chunks_exact(3).flat_map(|t| [t[0], t[2], t[1]]).collect();
        Self { positions: self.positions.clone(), indices }
    }
}

/// A patch of `n` by `m` quads from a parametrisation by two numbers from 0 to 1; seams are left unwelded,
/// and so must meet in the same bits.
pub fn patch(mesh: &mut Mesh, n: u32, m: u32, point: impl Fn(f64, f64) -> DVec3) {
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
pub fn cube(n: u32, place: impl Fn(DVec3) -> DVec3) -> Mesh {
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
pub fn sphere_mesh(n: u32, radius: f64) -> Mesh {
    cube(n, |p| {
        let spread = p.to_array().map(|c| (c * PI / 4.0).tan());
        SHIFT + radius * DVec3::from_array(spread).normalize()
    })
}

pub fn box_mesh(half: DVec3) -> Mesh {
    cube(1, |p| SHIFT + half * p)
}

pub fn torus_mesh(major: f64, minor: f64, n: u32, m: u32) -> Mesh {
    let mut mesh = Mesh { positions: Vec::new(), indices: Vec::new() };
    patch(&mut mesh, n, m, |u, v| {
        // The seam's two sides are the same point.
        let (u, v) = (TAU * (u % 1.0), TAU * (v % 1.0));
        let tube = major + minor * u.cos();
        SHIFT + DVec3::new(tube * v.cos(), minor * u.sin(), tube * v.sin())
    });
    mesh
}

pub fn bunny() -> Mesh {
    let (models, _) =
        tobj::load_obj(repository("assets/bunny.obj"), &tobj::GPU_LOAD_OPTIONS).expect("the bunny");
    let mesh = &models[0].mesh;
    let positions = mesh.positions.chunks_exact(3).map(Vec3::from_slice).collect();
    Mesh { positions, indices: mesh.indices.clone() }
}

pub fn bake(mesh: &Mesh, cell_size: f32, margin: f32) -> DistanceField {
    let settings = BakeSettings { cell_size, margin };
    DistanceField::bake(&mesh.positions, &mesh.indices, &settings).expect("a sound mesh")
}

/// Least distance to all triangles, by projection and segments.
pub fn least_distance(mesh: &Mesh, p: DVec3) -> f64 {
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
pub fn winding(mesh: &Mesh, p: DVec3) -> f64 {
    let solid_angle = |triangle: [DVec3; 3]| {
        let [a, b, c] = triangle.map(|corner| corner - p);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    mesh.triangles().map(solid_angle).sum::<f64>() / (2.0 * TAU)
}

/// Distance and normal in closed form, in `f64`.
pub type Truth = fn(DVec3) -> (f64, DVec3);

pub fn true_sphere(p: DVec3) -> (f64, DVec3) {
    let q = p - SHIFT;
    (q.length() - 0.5, q.normalize())
}

pub fn true_torus(p: DVec3) -> (f64, DVec3) {
    let q = p - SHIFT;
    let ring = DVec3::new(q.x, 0.0, q.z).normalize() * 0.5;
    ((q - ring).length() - 0.2, (q - ring).normalize())
}

pub fn true_box(p: DVec3) -> (f64, DVec3) {
    let q = p - SHIFT;
    let beyond = q.abs() - DVec3::new(0.4, 0.5, 0.3);
    if beyond.max_element() > 0.0 {
        let out = beyond.max(DVec3::ZERO);
        return (out.length(), out.normalize() * q.signum());
    }
    let axis = DVec3::AXES[beyond.max_position()];
    (beyond.max_element(), axis * q.signum())
}

pub fn meshes() -> [(&'static str, Mesh, Truth); 3] {
    // So fine that a facet is a hundredth of the interpolation's error away from the shape.
    [
        ("sphere", sphere_mesh(112, 0.5), true_sphere),
        ("torus", torus_mesh(0.5, 0.2, 112, 224), true_torus),
        ("box", box_mesh(DVec3::new(0.4, 0.5, 0.3)), true_box),
    ]
}

/// Largest and rms error in cells, and rms angle in degrees, within two cells of the surface.
pub fn band_error(field: &DistanceField, truth: Truth) -> [f64; 3] {
    let h = f64::from(field.cell_size());
    let mut random = Dice(7);
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
