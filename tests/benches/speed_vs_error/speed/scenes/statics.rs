//! P1 to P3: what cloths come to rest at, held against equilibria found in `f64` by Newton's method.

use std::rc::Rc;

use bevy::math::{DVec3, Vec3};
use bevy_drape::solver::{MassLumping, Material, StretchMethod};

use super::super::run::{self, GRAVITY, Method, Run, cloth, places, rms};
use super::super::{Extent, Job, Metric, Outcome, Plot, Scene};
use super::Sheet;
use crate::reference::{Fabric, Model};

/// Frames of the longest settling: 10 s.
const SETTLED: usize = 600;

/// Springs with passes of Provot's correction, and the other ways to hold a thread.
const METHODS: [Method; 7] = [
    Method::THREADS,
    Method::UNTETHERED,
    Method::GRAPH,
    Method { name: "springs, no Provot", passes: 0, ..Method::SPRINGS },
    Method { name: "springs, Provot x1", passes: 1, ..Method::SPRINGS },
    Method { name: "springs, Provot x4", passes: 4, ..Method::SPRINGS },
    Method {
        name: "mesh, springs",
        form: StretchMethod::ExplicitSprings,
        graph: true,
        ..Method::THREADS
    },
];

/// A scene that is settled and compared with a model at rest.
struct Static {
    sheet: Sheet,
    held: Vec<usize>,
    material: Material,
    start: Vec<Vec3>,
    exact: Vec<DVec3>,
    /// What an inextensible cloth's lowest particle is at \[m\], if that is known.
    inextensible: Option<f64>,
    /// Of the error to the inextensible one, the length that it is told in parts of.
    length: f64,
}

impl Static {
    /// The fabric in the reference's terms.
    fn fabric(material: &Material) -> Fabric {
        Fabric {
            density: f64::from(material.area_density),
            thread: f64::from(material.thread_stiffness),
            shear: f64::from(material.shear_stiffness),
            rigidity: f64::from(material.flexural_rigidity),
            ..Fabric::default()
        }
    }

    fn model(sheet: &Sheet, material: &Material, held: &[usize]) -> Model {
        let cells = [sheet.columns - 1, sheet.rows - 1];
        let mut model = Model::sheet(&Self::fabric(material), cells, sheet.cell, held);
        model.gravity = GRAVITY.as_dvec3();
        model
    }

    fn job(self: &Rc<Self>, method: Method, substeps: u32) -> Job<'static> {
        let scene = self.clone();
        Job {
            method: method.name.into(),
            n: self.sheet.rows.max(self.sheet.columns) - 1,
            knob: format!("{substeps} substeps"),
            run: Box::new(move || scene.run(&method, substeps)),
        }
    }

    fn run(&self, method: &Method, substeps: u32) -> Outcome<super::super::Measured> {
        let settings = method.settings(substeps, MassLumping::Lumped);
        let mut cloth = cloth(&self.sheet, method, self.material, settings)?;
        for (i, &at) in self.start.iter().enumerate() {
            cloth.set_position(i, at)?;
        }
        let held: Vec<_> = self.held.iter().map(|&i| i as u32).collect();
        cloth.set_pins(&held)?;
        let mut run = Run::new(cloth, &[]);
        run.settle(SETTLED);
        let there = places(&run.cloth);
        let strain = run.cloth.strain();
        let lowest = |x: &[DVec3]| x.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
        let off = rms(&there, &self.exact) / self.length;
        let inextensible = self.inextensible.map_or(f64::NAN, |y| (lowest(&there) / y - 1.0).abs());
        let (max, mean) = (f64::from(strain.max) * 100.0, f64::from(strain.mean) * 100.0);
        let mut measured = run.measured(vec![off, inextensible, max, mean]);
        if off > 1.0 {
            measured.failed = Some("not at rest, or gone".into());
        }
        Ok(measured)
    }
}

fn metrics() -> Vec<Metric> {
    vec![
        Metric::new("RMS from the equilibrium", "L"),
        Metric::new("lowest point from inextensible", "relative"),
        Metric::new("max strain", "%"),
        Metric::new("mean strain", "%"),
    ]
}

/// Drag under which statics settle \[1/s\].
fn settling(material: Material) -> Material {
    Material { drag: 2.0, ..material }
}

fn sweep(statics: &[Rc<Static>], extent: Extent) -> Vec<Job<'static>> {
    let (methods, all): (&[Method], &[u32]) = if extent.quick {
        (&METHODS[..1], &[2, 8, 32])
    } else {
        (&METHODS, &[1, 2, 4, 8, 16, 32, 64])
    };
    let mut jobs = Vec::new();
    for (at, scene) in statics.iter().enumerate() {
        // Finer sheets show what the number of particles does; the methods are compared on the first.
        let methods = if at == 0 { methods } else { &methods[..1] };
        for method in methods {
            jobs.extend(all.iter().map(|&substeps| scene.job(*method, substeps)));
        }
    }
    jobs
}

pub fn strip(extent: Extent) -> Outcome<Scene<'static>> {
    let cell = 1.0 / 40.0;
    let sheet = Sheet {
        rows: 5,
        columns: 41,
        cell: bevy::math::DVec2::splat(cell),
        down: Vec3::Z,
        corner: Vec3::ZERO,
    };
    let held: Vec<_> = (0..5).flat_map(|row| [sheet.at(row, 0), sheet.at(row, 40)]).collect();
    let material = settling(run::material(cell));
    // A parabola of about the catenary's sag, of the span that is asked for.
    let start: Vec<_> = sheet
        .start()
        .iter()
        .map(|p| {
            let s = 2.0 * p.x - 1.0;
            Vec3::new(0.4 * s + 0.4, -0.265 * (1.0 - s * s), p.z)
        })
        .collect();
    let model = Static::model(&sheet, &material, &held);
    let exact = model.equilibrium(&doubled(&start));
    let scene = Static {
        sheet,
        held,
        material,
        start,
        exact,
        inextensible: Some(-0.265_437_5),
        length: 1.0,
    };
    Ok(Scene {
        name: "p1",
        title: "P1: a strip between its short edges",
        about: "1.0 m x 0.1 m, 40 x 4 cells, the short edges held 0.8 m apart; settled. RMS from the equilibrium of the same springs, \
                found in f64 by Newton's method (left over: 1e-9 of the weight); lowest point against the inextensible catenary's sag, \
                0.2654375 m, from which the springs' own equilibrium is as far as the last digits of the methods agree to."
            .into(),
        errors: metrics(),
        jobs: sweep(&[Rc::new(scene)], extent),
        plots: vec![Plot { floor: Some(3e-6), ..Plot::of(0) }],
    })
}

pub fn curtain(extent: Extent) -> Outcome<Scene<'static>> {
    let statics = [20, 40, 80].map(|cells| {
        let sheet = Sheet::upright(cells + 1, 1.0);
        let held: Vec<_> = (0..=cells).collect();
        // Columns that nothing joins but their own springs have a closed form.
        let plain = Material { shear_stiffness: 0.0, flexural_rigidity: 0.0, ..run::material(1.0) };
        let material =
            settling(Material { damping: run::damping(1.0 / cells as f64) as f32, ..plain });
        let n = cells as f64;
        let load = run::DENSITY * 9.81 / run::THREAD;
        let start = sheet.start();
        let exact = start.iter().map(|p| {
            let s = -f64::from(p.y);
            // The spring i carries what hangs below its middle.
            let i = (s * n).round();
            let stretched = load * (i * (n - 0.5) - i * (i - 1.0) / 2.0) / (n * n);
            p.as_dvec3() - DVec3::Y * stretched
        });
        let exact = exact.collect();
        let inextensible = Some(-1.0);
        Rc::new(Static { sheet, held, material, start, exact, inextensible, length: 1.0 })
    });
    Ok(Scene {
        name: "p2",
        title: "P2: a sheet that hangs from its top edge",
        about: "1 m x 1 m, no shear springs, no bending; settled. RMS from the closed form of its springs under its own weight, whose \
                elongation is half of rho g L / K = 1.96e-3, exactly."
            .into(),
        errors: metrics(),
        jobs: sweep(&statics, extent),
        plots: vec![Plot { floor: Some(1e-6), ..Plot::of(0) }],
    })
}

pub fn corners(extent: Extent) -> Outcome<Scene<'static>> {
    let sizes: &[usize] = if extent.quick { &[20] } else { &[20, 40] };
    let statics: Vec<_> = sizes
        .iter()
        .map(|&cells| {
            let sheet = Sheet::upright(cells + 1, 1.0);
            let held = vec![0, cells];
            // In its own plane: in space its equilibrium is not the only one.
            let material = run::material(1.0 / cells as f64);
            let material = settling(Material { flexural_rigidity: 0.0, ..material });
            let start = sheet.start();
            let exact = Static::model(&sheet, &material, &held).equilibrium(&doubled(&start));
            let (inextensible, length) = (None, 1.0);
            Rc::new(Static { sheet, held, material, start, exact, inextensible, length })
        })
        .collect();
    Ok(Scene {
        name: "p3",
        title: "P3: a sheet hung from two corners",
        about: "1 m x 1 m in its own plane, no bending (Provot's scene); settled. RMS from its equilibrium, found in f64 by Newton's \
                method (left over: 1e-9 of the weight)."
            .into(),
        errors: metrics(),
        jobs: sweep(&statics, extent),
        plots: vec![Plot { n: Some(20), floor: Some(3e-6), ..Plot::of(0) }],
    })
}

fn doubled(x: &[Vec3]) -> Vec<DVec3> {
    x.iter().map(|p| p.as_dvec3()).collect()
}
