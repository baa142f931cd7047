//! P5: a sheet dropped on a ball, exact or baked.

use std::rc::Rc;

use bevy::math::{DVec3, Vec3, primitives::Sphere};
use bevy_drape::{
    sdf::{BakeSettings, DistanceField, SignedDistance},
    solver::{Collider, MassLumping, Pose},
};

use super::super::run::{self, Method, Run, cloth, places};
use super::super::{Extent, Job, Measured, Metric, Outcome, Plot, Scene};
use super::Sheet;

const N: usize = 41;
const RADIUS: f64 = 0.5;
const EPSILON: f64 = 0.005;
/// 10 s.
const FRAMES: usize = 600;

/// The ball's triangles: an octahedron whose faces are split into `parts` x `parts`, blown up.
pub fn triangles(parts: usize) -> (Vec<Vec3>, Vec<u32>) {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for face in 0..8 {
        let sign = |axis: u32| if face >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let corners = [Vec3::X * sign(0), Vec3::Y * sign(1), Vec3::Z * sign(2)];
        let inward = sign(0) * sign(1) * sign(2) < 0.0;
        let at = |i: usize, j: usize| {
            let k = parts - i - j;
            let [a, b, c] = [i, j, k].map(|part| part as f32);
            (corners[0] * a + corners[1] * b + corners[2] * c).normalize() * RADIUS as f32
        };
        let mut push = |a: Vec3, b: Vec3, c: Vec3| {
            let first = positions.len() as u32;
            positions.extend(if inward { [a, c, b] } else { [a, b, c] });
            indices.extend([first, first + 1, first + 2]);
        };
        for i in 0..parts {
            for j in 0..parts - i {
                push(at(i + 1, j), at(i, j + 1), at(i, j));
                if i + j + 2 <= parts {
                    push(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                }
            }
        }
    }
    (positions, indices)
}

fn baked(cells: u32) -> Outcome<DistanceField> {
    let (positions, indices) = triangles(48);
    let settings = BakeSettings::for_mesh(&positions, cells);
    Ok(DistanceField::bake(&positions, &indices, &settings)?)
}

/// Deepest of points of all faces below the surface \[m\].
fn deepest_face(x: &[DVec3]) -> f64 {
    let mut deepest = f64::NEG_INFINITY;
    for row in 0..N - 1 {
        for column in 0..N - 1 {
            let at = row * N + column;
            for face in [[at, at + N, at + 1], [at + 1, at + N, at + N + 1]] {
                let [a, b, c] = face.map(|i| x[i]);
                for p in [(a + b + c) / 3.0, (a + b) / 2.0, (b + c) / 2.0, (a + c) / 2.0] {
                    deepest = deepest.max(RADIUS - p.length());
                }
            }
        }
    }
    deepest
}

fn run(shape: &dyn SignedDistance, method: &Method, substeps: u32) -> Outcome<Measured> {
    let sheet = Sheet::flat(N, 1.6, (RADIUS + 0.1) as f32);
    let settings = method.settings(substeps, MassLumping::Lumped);
    let cloth = cloth(&sheet, method, run::material(1.6 / (N - 1) as f64), settings)?;
    let ball = [Collider::new(shape, Pose::IDENTITY)];
    let mut run = Run::new(cloth, &ball);
    let (mut violation, mut face, mut jitter) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut before = places(&run.cloth);
    let start = before.clone();
    for frame in 1..=FRAMES {
        run.frame();
        let x = places(&run.cloth);
        for p in &x {
            violation = violation.max(RADIUS + EPSILON - p.length());
        }
        face = face.max(deepest_face(&x));
        if frame > FRAMES - 120 {
            jitter = jitter.max(run::rms(&x, &before));
        }
        before = x;
    }
    // Of what touches at rest, how far it is from where it is to be held.
    let gaps = before.iter().map(|p| p.length() - RADIUS - EPSILON).filter(|gap| gap.abs() < 1e-3);
    let (sum, count) = gaps.fold((0.0, 0.0), |(sum, count), gap| (sum + gap.abs(), count + 1.0));
    let symmetry = before
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let mirror = before[i / N * N + N - 1 - i % N];
            p.distance(DVec3::new(-mirror.x, mirror.y, mirror.z))
        })
        .fold(0.0, f64::max);
    let drop = start[0].y - before.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let strain = f64::from(run.cloth.strain().p99) * 100.0;
    let mean = if count > 0.0 { 1e3 * sum / count } else { f64::NAN };
    let mut measured = run.measured(vec![
        1e3 * violation.max(0.0),
        1e3 * face.max(0.0),
        mean,
        1e3 * jitter,
        1e3 * symmetry,
        strain,
    ]);
    if drop > 2.0 {
        measured.failed = Some("slid off the ball".into());
    }
    Ok(measured)
}

pub fn scene(extent: Extent) -> Outcome<Scene<'static>> {
    let mut shapes: Vec<(&str, Rc<dyn SignedDistance>)> =
        vec![("exact ball", Rc::new(Sphere::new(RADIUS as f32)))];
    if !extent.quick {
        shapes.push(("baked, 32 cells", Rc::new(baked(32)?)));
        shapes.push(("baked, 64 cells", Rc::new(baked(64)?)));
    }
    let all: &[u32] = if extent.quick { &[4, 16] } else { &[2, 4, 8, 16, 32, 64] };
    let mut jobs = Vec::new();
    let mut push = |name: &str, shape: &Rc<dyn SignedDistance>, method: Method, substeps: u32| {
        let shape = shape.clone();
        jobs.push(Job {
            method: name.into(),
            n: N,
            knob: format!("{substeps} substeps"),
            run: Box::new(move || run(&*shape, &method, substeps)),
        });
    };
    for (name, shape) in &shapes {
        for &substeps in all {
            push(name, shape, Method::THREADS, substeps);
        }
    }
    if !extent.quick {
        for &substeps in all {
            push("exact ball, mesh", &shapes[0].1, Method::GRAPH, substeps);
        }
    }
    Ok(Scene {
        name: "p5",
        title: "P5: a sheet dropped on a ball",
        about: "1.6 m x 1.6 m, 41 x 41 particles, released 0.1 m above the pole of a ball of radius 0.5 m, epsilon 5 mm, friction 0.5; \
                10 s, spring damping C = 0.02 sqrt(ks m). Gap violation: how far a particle was nearer to the ball than epsilon, in any \
                frame; face: how deep a point of a triangle was below the surface (particles collide, faces do not: epsilon has to hold \
                a^2 / 4R = 0.8 mm for them); gap error: of what touches at rest, in the mean; jitter: RMS displacement a frame over the \
                last 2 s, at most; symmetry: from its mirror image. A baked ball is a polyhedron of 18,432 faces on a grid."
            .into(),
        errors: vec![
            Metric::new("gap violation", "mm"),
            Metric::new("face below the surface", "mm"),
            Metric::new("gap error", "mm"),
            Metric::new("jitter", "mm"),
            Metric::new("asymmetry", "mm"),
            Metric::new("p99 strain", "%"),
        ],
        jobs,
        plots: vec![Plot::of(5)],
    })
}
