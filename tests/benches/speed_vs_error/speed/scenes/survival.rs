//! P8: what breaks other solvers: a jump of both pins, a fast ball, a start at random.

use bevy::math::{Vec3, primitives::Sphere};
use bevy_drape::solver::{
    ClothSolver, Collider, MassLumping, Material, PinMotion, Pose, Settings, StepInput,
    StretchMethod, Substeps,
};

use super::super::run::{self, FRAME, GRAVITY, Method, Run, cloth};
use super::super::{Extent, Job, Measured, Metric, Outcome, Scene};
use super::Sheet;

const N: usize = 32;
/// 10 s.
const FRAMES: usize = 600;

#[derive(Clone, Copy)]
enum Case {
    /// Both pins jump by 10 m within one frame.
    Jump,
    /// A ball of radius 0.2 m flies through the middle of a free sheet.
    Ball(f32),
    /// All free particles at random in a cube of 0.1 m.
    Random,
}

/// A ball flies down through a cloth about the origin. Gives how many particles it passed through: whose
/// way, straight in a substep as seen from the ball, came nearer to its middle than half its radius.
fn fly_through(cloth: &mut ClothSolver, speed: f32, peak: &mut f32) -> Outcome<usize> {
    const RADIUS: f32 = 0.2;
    let shape = Sphere::new(RADIUS);
    let mut passed = [false; N * N];
    let mut height = 0.5;
    while height > -1.0 {
        let end = height - speed * FRAME;
        let [from, to] = [height, end].map(|y| Pose::from_translation(Vec3::Y * y));
        let ball = [Collider::new(&shape, from).moving_to(to)];
        let input =
            StepInput { dt: FRAME, gravity: GRAVITY, colliders: &ball, ..StepInput::default() };
        let substeps = cloth.begin_tick(&input)?;
        for substep in 0..substeps {
            let seen = |cloth: &ClothSolver, at: u32| {
                let middle = from.interpolate(&to, at as f32 / substeps as f32).translation;
                (0..N * N).map(|i| cloth.position(i) - middle).collect::<Vec<_>>()
            };
            let before = seen(cloth, substep);
            cloth.accumulate_forces(&input);
            cloth.integrate(&input);
            cloth.correct();
            cloth.collide(&input);
            let ways = before.into_iter().zip(seen(cloth, substep + 1));
            for (passed, (a, b)) in passed.iter_mut().zip(ways) {
                let way = b - a;
                let nearest = (-a.dot(way) / way.length_squared().max(1e-12)).clamp(0.0, 1.0);
                *passed |= (a + way * nearest).length() < 0.5 * RADIUS;
            }
        }
        *peak = peak.max(cloth.end_tick()?.max_strain);
        height = end;
    }
    Ok(passed.iter().filter(|&&passed| passed).count())
}

impl Case {
    fn name(self) -> String {
        match self {
            Self::Jump => "both pins jump 10 m".into(),
            Self::Ball(speed) => format!("a ball at {speed} m/s"),
            Self::Random => "a random start".into(),
        }
    }

    fn run(self, method: &Method, substeps: Substeps) -> Outcome<Measured> {
        let material = Material { flexural_rigidity: 0.0, ..run::material(1.0 / (N - 1) as f64) };
        let sheet = Sheet::flat(N, 1.0, 0.0);
        let settings = Settings { substeps, ..method.settings(1, MassLumping::Lumped) };
        let mut cloth = cloth(&sheet, method, material, settings)?;
        let pinned = !matches!(self, Self::Ball(_));
        if pinned {
            cloth.set_pins(&[0, N as u32 - 1])?;
        }
        if matches!(self, Self::Random) {
            let mut roll = run::dice(7);
            for i in (0..N * N).filter(|i| ![0, N - 1].contains(i)) {
                cloth.set_position(i, Vec3::new(roll(), roll(), roll()) * 0.05)?;
            }
        }
        let mut run = Run::new(cloth, &[]);
        let (mut peak, mut recovered, mut through) = (0.0_f32, 0, f64::NAN);
        if let Self::Ball(speed) = self {
            let passed = fly_through(&mut run.cloth, speed, &mut peak)?;
            through = 100.0 * passed as f64 / (N * N) as f64;
        }
        if matches!(self, Self::Jump) {
            run.frames(60);
            let there = |pin: &PinMotion| PinMotion { end: pin.start + Vec3::X * 10.0, ..*pin };
            run.pins = run.pins.iter().map(there).collect();
            run.frame();
            peak = peak.max(run.cloth.strain().max);
            run.pins = run.pins.iter().map(|pin| PinMotion::still(pin.end)).collect();
        }
        for frame in 0..FRAMES {
            run.frame();
            let strain = run.cloth.strain().max;
            peak = peak.max(strain);
            if strain > 2.0 * material.max_strain {
                recovered = frame + 1;
            }
        }
        let strain = f64::from(run.cloth.strain().max) * 100.0;
        let errors = vec![f64::from(peak) * 100.0, recovered as f64, strain, through];
        let mut measured = run.measured(errors);
        if recovered == FRAMES {
            measured.failed = Some("never recovered".into());
        }
        Ok(measured)
    }
}

pub fn scene(extent: Extent) -> Outcome<Scene<'static>> {
    let automatic = Method { name: "automatic", form: StretchMethod::Automatic, ..Method::THREADS };
    let mut choices = vec![(automatic, Substeps::default(), "the default".to_owned())];
    if !extent.quick {
        for substeps in [4, 8, 20] {
            for method in [Method::THREADS, Method::GRAPH, Method::SPRINGS] {
                let knob = format!("{substeps} substeps");
                choices.push((method, Substeps::Fixed(substeps), knob));
            }
        }
    }
    let cases = [Case::Jump, Case::Ball(50.0), Case::Ball(250.0), Case::Random];
    let mut jobs = Vec::new();
    for case in cases {
        for (method, substeps, knob) in choices.clone() {
            jobs.push(Job {
                method: format!("{}, {}", case.name(), method.name),
                n: N,
                knob,
                run: Box::new(move || case.run(&method, substeps)),
            });
        }
    }
    Ok(Scene {
        name: "p8",
        title: "P8: what breaks other solvers",
        about: "1 m x 1 m, 32 x 32 particles, no bending; 10 s after the event. Largest strain, frames until it stays under twice the limit \
                of 10 %, largest strain at the end, particles that the ball passed through. (A frame of half a second is the clock's \
                affair: see tests/stability.)"
            .into(),
        errors: vec![
            Metric::new("peak strain", "%"),
            Metric::new("frames to recover", ""),
            Metric::new("strain at the end", "%"),
            Metric::new("passed through", "%"),
        ],
        jobs,
        plots: Vec::new(),
    })
}
