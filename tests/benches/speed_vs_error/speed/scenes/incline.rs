//! P6: a patch on a slope, against Coulomb's law.

use bevy::math::{Quat, Vec3, primitives::InfinitePlane3d};
use bevy_drape::solver::{ClothSolver, Collider, MassLumping, Material, Pose};

use super::super::run::{self, FRAME, Method, Run, cloth};
use super::super::{Extent, Job, Measured, Metric, Outcome, Plot, Scene};
use super::Sheet;

const N: usize = 21;
const MU: f64 = 0.5;

/// How far a patch on a slope of an angle goes in so many frames \[m\], and their times.
fn slide(angle: f64, substeps: u32, frames: usize) -> Outcome<(f64, Measured)> {
    let turn = Quat::from_rotation_z(-angle as f32);
    let plane = InfinitePlane3d::new(Vec3::Y);
    let floor = [Collider::new(&plane, Pose { rotation: turn, ..Pose::IDENTITY })];
    let material = Material { thickness: 0.005, ..run::material(0.5 / (N - 1) as f64) };
    let method = Method::THREADS;
    let settings = method.settings(substeps, MassLumping::Lumped);
    let sheet = Sheet::flat(N, 0.5, 0.005);
    let mut cloth = cloth(&sheet, &method, material, settings)?;
    for (i, &at) in sheet.start().iter().enumerate() {
        cloth.set_position(i, turn * at)?;
    }
    let down = turn * Vec3::X;
    let mean = |cloth: &ClothSolver| {
        let count = N * N;
        (0..count).map(|i| f64::from(cloth.position(i).dot(down))).sum::<f64>() / count as f64
    };
    let before = mean(&cloth);
    let mut run = Run::new(cloth, &floor);
    run.frames(frames);
    let way = mean(&run.cloth) - before;
    Ok((way, run.measured(Vec::new())))
}

/// The least angle at which it does not stay, by bisection \[rad\].
fn threshold(substeps: u32) -> Outcome<f64> {
    let critical = MU.atan();
    let (mut low, mut high) = (critical - 0.05, critical + 0.05);
    for _ in 0..10 {
        let middle = 0.5 * (low + high);
        // What slips at a hundredth of a degree more goes 1.7 mm in 2 s.
        let (way, _) = slide(middle, substeps, 120)?;
        *(if way > 1e-3 { &mut high } else { &mut low }) = middle;
    }
    Ok(0.5 * (low + high))
}

fn measure(substeps: u32) -> Outcome<Measured> {
    let critical = MU.atan();
    let (creep, rest) = slide(0.95 * critical, substeps, 600)?;
    let off = (threshold(substeps)? - critical).abs().to_degrees();
    // A second of sliding: way = (g sin - mu g cos) t^2 / 2.
    let slip = |factor: f64| -> Outcome<f64> {
        let angle = (factor * MU).atan();
        let (way, _) = slide(angle, substeps, 60)?;
        let time = 60.0 * f64::from(FRAME);
        let exact = 0.5 * 9.81 * (angle.sin() - MU * angle.cos()) * time * time;
        Ok(100.0 * (way / exact - 1.0).abs())
    };
    let errors = vec![1e3 * creep.abs(), off, slip(1.05)?, slip(1.5)?];
    Ok(Measured { errors, ..rest })
}

pub fn scene(extent: Extent) -> Outcome<Scene<'static>> {
    let all: &[u32] = if extent.quick { &[8] } else { &[1, 4, 8, 16, 32, 64] };
    let job = |&substeps: &u32| Job {
        method: "threads".into(),
        n: N,
        knob: format!("{substeps} substeps"),
        run: Box::new(move || measure(substeps)),
    };
    Ok(Scene {
        name: "p6",
        title: "P6: a patch on a slope",
        about: "0.5 m x 0.5 m, 21 x 21 particles, friction 0.5. Creep in 10 s at 0.95 of the critical angle; the angle at which it begins \
                to slip, by bisection, against atan 0.5; way in the first second where tan is 1.05 and 1.5 times the coefficient, \
                against (g sin - mu g cos) t^2 / 2."
            .into(),
        errors: vec![
            Metric::new("creep", "mm"),
            Metric::new("threshold", "degrees"),
            Metric::new("slip at 1.05", "%"),
            Metric::new("slip at 1.5", "%"),
        ],
        jobs: all.iter().map(job).collect(),
        plots: vec![Plot::of(3)],
    })
}
