//! HANG and DRAPE: the scenes that other solvers were measured on.

use std::rc::Rc;

use bevy::math::{Vec3, primitives::Sphere};
use bevy_drape::solver::{
    ClothSolver, Collider, DampingForm, MassLumping, Material, Pose, Settings, StretchMethod,
    Substeps,
};

use super::super::run::{Method, Run, cloth};
use super::super::{Extent, Job, Measured, Metric, Outcome, Plot, Scene, peers};
use super::Sheet;
use crate::exact::Motion;

/// Threads that do not stretch, as the scenes ask; no bending, no damping.
pub(super) const MATERIAL: Material = Material {
    area_density: 0.2,
    thread_stiffness: 1e6,
    shear_stiffness: 1e6,
    flexural_rigidity: 0.0,
    bending_friction: 0.0,
    damping: 0.0,
    damping_form: DampingForm::Axial,
    drag: 0.0,
    max_strain: 0.1,
    friction: 0.5,
    thickness: 0.0,
};

const FRAMES: usize = 180;
const RADIUS: f32 = 0.5;

#[derive(Clone, Copy, PartialEq)]
enum Fall {
    Hang,
    Drape,
}

impl Fall {
    fn sheet(self, n: usize) -> Sheet {
        match self {
            Self::Hang => Sheet { corner: Vec3::new(-0.5, 0.0, 0.0), ..Sheet::flat(n, 1.0, 0.0) },
            Self::Drape => Sheet::flat(n, 2.0, 0.6),
        }
    }

    fn cloth(self, n: usize, method: &Method, substeps: Substeps) -> Outcome<ClothSolver> {
        let settings = Settings { substeps, ..method.settings(1, MassLumping::Equal) };
        let mut cloth = cloth(&self.sheet(n), method, MATERIAL, settings)?;
        if self == Self::Hang {
            cloth.set_pins(&[0, n as u32 - 1])?;
        }
        Ok(cloth)
    }

    fn run(
        self,
        n: usize,
        method: &Method,
        substeps: Substeps,
        exact: Option<&Motion>,
    ) -> Outcome<Measured> {
        let (shape, still) = (Sphere::new(RADIUS), Pose::IDENTITY);
        let ball = [Collider::new(&shape, still)];
        let colliders: &[_] = if self == Self::Drape { &ball } else { &[] };
        let mut run = Run::new(self.cloth(n, method, substeps)?, colliders);
        let rest = self.sheet(n).start();
        let (mut square, mut strain, mut depth) = (0.0, 0.0_f32, 0.0_f32);
        for frame in 1..=FRAMES {
            run.frame();
            if let Some(exact) = exact.filter(|_| frame % 6 == 0 && frame <= 36) {
                square += exact.mean_square(&run.cloth, &rest, frame as f64 / 60.0) / 6.0;
            }
            if frame % 60 == 0 {
                strain = strain.max(run.cloth.strain().p99 * 100.0);
            }
            let below = |i| (RADIUS - run.cloth.position(i).length()) * 1e3;
            depth = colliders.iter().flat_map(|_| (0..n * n).map(below)).fold(depth, f32::max);
        }
        let first = if self == Self::Hang { square.sqrt() * 1e3 } else { f64::from(depth) };
        Ok(run.measured(vec![first, f64::from(strain)]))
    }
}

/// As deep as a surface may be entered for a drape to count \[mm\].
const DEEP: f64 = 5.0;

pub fn hang(extent: Extent) -> Outcome<Scene<'static>> {
    let plot = |metric, error| Plot { n: Some(64), peers: Some(error), ..Plot::of(metric) };
    Ok(Scene {
        name: "hang",
        title: "HANG: a square held by two corners falls from rest",
        about: "1 m x 1 m, 0.2 kg/m2 over particles of equal mass, threads and shear that do not stretch (1e6 N/m), no bending, no \
                damping; 3 s. RMS: all particles against the exact motion of the inextensible sheet at t = 0.1, 0.2 ... 0.6 s \
                (integrated with dt = 2e-5 s; its own error is below 1e-3 mm). p99 strain: what 99 % of the threads stay below, the worst \
                of t = 1, 2, 3 s."
            .into(),
        errors: vec![Metric::new("RMS", "mm"), Metric::new("p99 strain", "%")],
        jobs: jobs(Fall::Hang, extent)?,
        plots: vec![plot(0, peers::Error::Rms), plot(1, peers::Error::Strain)],
    })
}

pub fn drape(extent: Extent) -> Outcome<Scene<'static>> {
    let peers = Some(peers::Error::Strain);
    Ok(Scene {
        name: "drape",
        title: "DRAPE: a square falls onto a sphere",
        about: format!(
            "2 m x 2 m, the cloth of HANG, at 0.6 m over the middle of a fixed sphere of radius 0.5 m, friction 0.5; 3 s. p99 strain \
             as in HANG; depth of the deepest particle below the surface in any frame. Deeper than {DEEP} mm is a failure."
        ),
        errors: vec![Metric::new("depth", "mm"), Metric::new("p99 strain", "%")],
        jobs: jobs(Fall::Drape, extent)?,
        plots: vec![Plot { n: Some(64), peers, ..Plot::of(1) }],
    })
}

fn jobs(fall: Fall, extent: Extent) -> Outcome<Vec<Job<'static>>> {
    let automatic = Method { name: "automatic", form: StretchMethod::Automatic, ..Method::THREADS };
    let mut jobs = Vec::new();
    let mut push = |exact: &Option<Rc<Motion>>, method: Method, n: usize, substeps: Substeps| {
        let exact = exact.clone();
        let knob = match substeps {
            Substeps::Fixed(count) => format!("{count} substeps"),
            Substeps::Automatic { .. } => "the default".into(),
        };
        jobs.push(Job {
            method: method.name.into(),
            n,
            knob,
            run: Box::new(move || {
                let mut measured = fall.run(n, &method, substeps, exact.as_deref())?;
                if fall == Fall::Drape && measured.errors[0] > DEEP {
                    measured.failed = Some("too deep".into());
                }
                if measured.errors[1] > 1e4 {
                    measured.failed = Some("blew up".into());
                }
                Ok(measured)
            }),
        });
    };
    let sizes: &[usize] = if extent.quick { &[64] } else { &[32, 64, 128] };
    for &n in sizes {
        let exact = (fall == Fall::Hang).then(|| Rc::new(Motion::new(n)));
        let all: &[u32] =
            if extent.quick { &[2, 4, 8, 16] } else { &[2, 3, 4, 6, 8, 12, 16, 24, 32, 64] };
        for &substeps in all {
            push(&exact, Method::THREADS, n, Substeps::Fixed(substeps));
        }
        push(&exact, automatic, n, Substeps::default());
        if extent.quick {
            continue;
        }
        for substeps in [4, 8, 16, 32] {
            if fall == Fall::Hang {
                push(&exact, Method::UNTETHERED, n, Substeps::Fixed(substeps));
            }
            push(&exact, Method::GRAPH, n, Substeps::Fixed(substeps));
        }
        if n <= 64 {
            for substeps in [16, 64, 256] {
                push(&exact, Method::SPRINGS, n, Substeps::Fixed(substeps));
            }
        }
    }
    Ok(jobs)
}
