//! P4: a sheet swings from two corners, against the same model in `f64` at a far smaller step.

use std::rc::Rc;

use bevy::math::DVec3;
use bevy_drape::solver::{Integrator, MassLumping, Material, Settings};

use super::super::run::{self, FRAME, GRAVITY, Method, Run, cloth, places, rms};
use super::super::{Extent, Job, Measured, Metric, Outcome, Plot, Scene};
use super::Sheet;
use crate::reference::{self, Fabric, Model, Motion};

const CELLS: usize = 20;

/// One horizon: how long, whether damped, and where the reference is then.
struct Horizon {
    sheet: Sheet,
    material: Material,
    frames: usize,
    exact: Vec<DVec3>,
    /// Of the reference, by half its step \[L\].
    own: f64,
    /// What a start disturbed by 1e-6 m comes to \[L\].
    chaos: f64,
}

impl Horizon {
    fn new(damped: bool, frames: usize) -> Self {
        let cell = 1.0 / CELLS as f64;
        let sheet = Sheet::flat(CELLS + 1, 1.0, 0.0);
        let mut material = run::material(cell);
        if !damped {
            material.damping = 0.0;
        }
        let fabric = Fabric {
            density: run::DENSITY,
            thread: run::THREAD,
            shear: run::SHEAR,
            rigidity: run::RIGIDITY,
            damping: f64::from(material.damping),
            ..Fabric::default()
        };
        let mut model = Model::sheet(&fabric, [CELLS; 2], sheet.cell, &[0, CELLS]);
        model.gravity = GRAVITY.as_dvec3();
        let start: Vec<_> = sheet.start().iter().map(|p| p.as_dvec3()).collect();
        // The bound of the uniform lattice: sqrt(max(8 ks, 4 ks + 8 kd) / m).
        let stiffest = (8.0 * run::THREAD).max(4.0 * run::THREAD + 8.0 * run::SHEAR);
        let largest = 2.0 / (stiffest / (run::DENSITY * cell * cell)).sqrt();
        let swing = |start: &[DVec3], part: f64| {
            let steps = (f64::from(FRAME) * part / largest).ceil() as usize;
            let mut motion = Motion::at_rest(start);
            let h = f64::from(FRAME) / steps as f64;
            model.steps(&mut motion, reference::Method::Verlet, h, steps * frames);
            motion.x
        };
        let exact = swing(&start, 16.0);
        let own = rms(&exact, &swing(&start, 8.0)) / 3.0;
        let mut dice = run::dice(1);
        let mut roll = || f64::from(dice());
        let disturbed: Vec<_> =
            start.iter().map(|p| p + 1e-6 * DVec3::new(roll(), roll(), roll())).collect();
        let chaos = rms(&swing(&disturbed, 8.0), &swing(&start, 8.0));
        Self { sheet, material, frames, exact, own, chaos }
    }

    fn run(&self, method: &Method, integrator: Integrator, substeps: u32) -> Outcome<Measured> {
        let settings = method.settings(substeps, MassLumping::Lumped);
        let settings = Settings { integrator, max_speed: 1e4, ..settings };
        // No limit: the reference has none.
        let material = Material { max_strain: 10.0, ..self.material };
        let mut cloth = cloth(&self.sheet, method, material, settings)?;
        cloth.set_pins(&[0, CELLS as u32])?;
        let clamped = cloth.plan_for(FRAME)?.clamped.thread;
        let mut run = Run::new(cloth, &[]);
        run.frames(self.frames);
        let off = rms(&places(&run.cloth), &self.exact);
        let middle = |x: &[DVec3]| x.iter().map(|p| p.y).sum::<f64>() / x.len() as f64;
        let height = (middle(&places(&run.cloth)) - middle(&self.exact)).abs();
        // A few frames tell no time: it goes on, measured no more.
        if !run.has_failed() {
            run.frames(360_usize.saturating_sub(self.frames));
        }
        let mut measured = run.measured(vec![off, height]);
        // Another material is not compared with this one.
        if clamped {
            measured.failed = Some("the substeps do not carry the stiffness".into());
        } else if off > 1.0 {
            measured.failed = Some("blew up".into());
        }
        Ok(measured)
    }
}

pub fn scene(extent: Extent) -> Outcome<Scene<'static>> {
    let short = Rc::new(Horizon::new(false, 30));
    let mut horizons = vec![("", short.clone())];
    if !extent.quick {
        horizons.push((", damped, 3 s", Rc::new(Horizon::new(true, 180))));
    }
    let mut jobs = Vec::new();
    for (suffix, horizon) in &horizons {
        let mut push = |name: &str, method: Method, integrator, all: &[u32]| {
            for &substeps in all {
                let horizon = horizon.clone();
                jobs.push(Job {
                    method: format!("{name}{suffix}"),
                    n: CELLS,
                    knob: format!("{substeps} substeps"),
                    run: Box::new(move || horizon.run(&method, integrator, substeps)),
                });
            }
        };
        let all = if extent.quick { &[4, 16, 64][..] } else { &[2, 4, 8, 16, 32, 64, 128, 256] };
        push("threads", Method::THREADS, Integrator::Verlet, all);
        let fine = if extent.quick { &[64][..] } else { &[32, 40, 64, 128, 256] };
        push("springs", Method::SPRINGS, Integrator::Verlet, fine);
        if !extent.quick {
            push("springs, midpoint", Method::SPRINGS, Integrator::Midpoint, &fine[2..]);
            push("springs, Euler", Method::SPRINGS, Integrator::Euler, &fine[2..]);
        }
    }
    let told = |(suffix, horizon): &(&str, Rc<Horizon>)| {
        let seconds = horizon.frames as f64 / 60.0;
        format!(
            " {seconds} s{}: its own error {:.1e} L; a start disturbed by 1e-6 m differs by {:.1e} L.",
            if suffix.is_empty() { " undamped" } else { " damped (C = 0.02 sqrt(ks m))" },
            horizon.own,
            horizon.chaos
        )
    };
    let about = "1 m x 1 m, 20 x 20 cells, horizontal, released from rest. RMS from the same model in f64 by Verlet's method at a \
                 sixteenth of the stable step, L = 1 m, and height of the mean of all particles."
        .to_owned()
        + &horizons.iter().map(told).collect::<String>();
    Ok(Scene {
        name: "p4",
        title: "P4: a sheet swings from two corners",
        about,
        errors: vec![Metric::new("RMS", "L"), Metric::new("mean height", "m")],
        jobs,
        plots: vec![Plot { floor: Some(2e-7), chaos: Some(short.chaos), ..Plot::of(0) }],
    })
}
