//! P10 FAST: a solid moves through a curtain, and stops.

use bevy::math::{
    Quat, Vec3,
    primitives::{Capsule3d, Cuboid, Sphere},
};
use bevy_drape::{
    sdf::SignedDistance,
    solver::{Collider, Material, PinMotion, Pose, StepInput},
};

use super::super::super::run::{FRAME, GRAVITY};
use super::super::super::{Extent, Job, Measured, Metric, Outcome, Scene};
use super::{Cloth, peers};

const N: usize = 64;
/// Strain that no thread should be left at.
const HOOKED: f32 = 0.5;

#[derive(Clone, Copy)]
struct Case {
    name: &'static str,
    speed: f32,
}

impl Case {
    fn solid(self) -> (Box<dyn SignedDistance>, f32) {
        match self.name {
            "ball" => (Box::new(Sphere::new(0.15)), 0.0),
            "box" => (Box::new(Cuboid::new(0.3, 0.3, 0.05)), 0.3),
            _ => (Box::new(Capsule3d::new(0.05, 0.5)), 0.0),
        }
    }

    fn run(self, cloth: Cloth) -> Outcome<Measured> {
        let (solid, yaw) = self.solid();
        let upright = |at: Vec3| Vec3::new(at.x, -(at.z + 0.5), 0.0);
        let mut solver = cloth.solver(Material::USUAL, upright)?;
        let held: Vec<_> =
            (0..(N * N) as u32).filter(|&i| solver.position(i as usize).y > -1e-4).collect();
        solver.set_pins(&held)?;
        let pin = |&particle: &u32| PinMotion::still(solver.position(particle as usize));
        let pins: Vec<_> = solver.pins().iter().map(pin).collect();
        let pose = |frame: usize| {
            let z = (self.speed * frame as f32 * FRAME - 1.0).min(0.5);
            let rotation = Quat::from_rotation_y(yaw);
            Pose { rotation, ..Pose::from_translation(Vec3::new(0.05, -0.5, z)) }
        };
        let frames = if self.speed < 2.0 { 420 } else { 180 };
        let (mut peak, mut times) = (0.0_f32, Vec::new());
        for frame in 0..frames {
            let collider = Collider::new(&*solid, pose(frame)).moving_to(pose(frame + 1));
            let colliders = [collider];
            let input = StepInput {
                dt: FRAME,
                gravity: GRAVITY,
                pins: &pins,
                colliders: &colliders,
                ..StepInput::default()
            };
            let begun = std::time::Instant::now();
            let report = solver.tick(&input)?;
            times.push(begun.elapsed().as_secs_f64() * 1e3);
            peak = peak.max(report.max_strain);
        }
        let strained = |&(a, b, rest): &(usize, usize, f32)| {
            solver.position(a).distance(solver.position(b)) > (1.0 + HOOKED) * rest
        };
        let hooked = solver.topology().structural_springs().filter(strained).count();
        let [end, peak] = [solver.strain().max, peak].map(|strain| f64::from(strain) * 100.0);
        let work = N * N * solver.plan().substeps as usize;
        let errors = vec![hooked as f64, end, peak];
        Ok(Measured { frames: times, errors, work, allocations: f64::NAN, ..Measured::default() })
    }
}

pub fn scene(extent: Extent) -> Outcome<Scene<'static>> {
    let speeds: &[f32] =
        if extent.quick { &[2.0, 10.0] } else { &[0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 100.0] };
    let mut jobs = Vec::new();
    for name in ["ball", "box", "capsule"] {
        for &speed in speeds {
            let case = Case { name, speed };
            for cloth in Cloth::all(1.0, N, extent) {
                jobs.push(Job {
                    method: format!("{name} {speed} m/s, {}", cloth.method()),
                    n: N,
                    knob: cloth.knob(),
                    run: Box::new(move || case.run(cloth)),
                });
            }
        }
    }
    jobs.extend(peers::jobs("peer_contact.csv", "fast", N, &["over_50", "at_end", "peak"])?);
    Ok(Scene {
        name: "p10",
        title: "P10 FAST: a solid moves through a curtain, and stops",
        about: "1 m x 1 m, 64 x 64 particles of the usual material, held by its upper row; a ball of radius 0.15 m, a box of 0.3 x 0.3 x 0.05 m \
                turned by 0.3 rad, or an upright capsule of radius 0.05 m and length 0.5 m, whose middle goes from 1 m in front of it to \
                0.5 m behind. Threads beyond 50 % and the largest strain 3 s after the beginning (7 s below 2 m/s), and the \
                largest strain of all frames."
            .into(),
        errors: vec![
            Metric::new("beyond 50 %", ""),
            Metric::new("strain at the end", "%"),
            Metric::new("peak strain", "%"),
        ],
        jobs,
        plots: Vec::new(),
    })
}
