//! P7: a strip clamped at one end, against the heavy elastica.

use bevy::math::{DVec2, Vec3};
use bevy_drape::solver::{Bending, MassLumping, Material, Settings};

use super::super::run::{self, FRAME, Method, Run, cloth};
use super::super::{Extent, Job, Measured, Metric, Outcome, Plot, Scene};
use super::Sheet;

/// H/W of the heavy elastica at Gamma = w L^3 / B (`tests/data/heavy_elastica_master.csv`).
const MASTER: [(f64, f64); 3] = [(1.0, 0.124_561_8), (10.0, 1.066_802_3), (100.0, 5.888_104_6)];

/// Curvature at which flexion springs resist as the rigidity says \[1/m\].
const FLEXION_CURVATURE: f64 = 20.0;

fn droop(gamma: f64, cells: usize, bending: Bending, exact: f64) -> Outcome<Measured> {
    let cell = 1.0 / cells as f64;
    let rigidity = run::DENSITY * 9.81 / gamma;
    // The step that the model's own stiffness asks for: 32 B / (rho a^4), or four times the flexion
    // constant over half the mass.
    let omega = match bending {
        Bending::SecondDifference => (32.0 * rigidity / run::DENSITY).sqrt() / (cell * cell),
        Bending::Flexion => {
            let constant = 8.0 * rigidity / FLEXION_CURVATURE.powi(2) / cell.powi(4);
            (8.0 * constant / (run::DENSITY * cell * cell)).sqrt()
        }
    };
    let substeps = (f64::from(FRAME) * omega / 1.8).ceil().max(16.0) as u32;
    // Nearly critical for the first mode, 3.5 sqrt(B / rho) / L^2.
    let drag = (7.0 * (rigidity / run::DENSITY).sqrt()).max(6.0);
    let material = Material {
        thread_stiffness: 1e6,
        shear_stiffness: 0.0,
        flexural_rigidity: rigidity as f32,
        damping: 0.0,
        drag: drag as f32,
        ..run::material(cell)
    };
    let sheet = Sheet {
        rows: cells + 2,
        columns: 3,
        cell: DVec2::splat(cell),
        down: Vec3::Z,
        corner: Vec3::ZERO,
    };
    let method = Method::UNTETHERED;
    let settings = Settings { bending, ..method.settings(substeps, MassLumping::Lumped) };
    let mut cloth = cloth(&sheet, &method, material, settings)?;
    cloth.set_pins(&[0, 1, 2, 3, 4, 5])?;
    let clamped = cloth.plan_for(FRAME)?.clamped.bending;
    let mut run = Run::new(cloth, &[]);
    run.settle(600);
    let tip = run.cloth.position(3 * (cells + 1) + 1).as_dvec3();
    let ratio = -tip.y / (tip.z - cell);
    let mut measured = run.measured(vec![(ratio / exact - 1.0).abs(), ratio]);
    if clamped {
        measured.failed = Some("the substeps do not carry the rigidity".into());
    }
    Ok(measured)
}

pub fn scene(extent: Extent) -> Outcome<Scene<'static>> {
    let all: &[usize] = if extent.quick { &[10] } else { &[5, 10, 20] };
    let mut jobs = Vec::new();
    for (gamma, exact) in MASTER {
        for (name, bending) in [
            ("second differences", Bending::SecondDifference),
            ("flexion springs", Bending::Flexion),
        ] {
            for &cells in all {
                jobs.push(Job {
                    method: format!("{name}, Gamma = {gamma}"),
                    n: cells,
                    knob: format!("{cells} cells"),
                    run: Box::new(move || droop(gamma, cells, bending, exact)),
                });
            }
        }
    }
    Ok(Scene {
        name: "p7",
        title: "P7: a strip clamped at one end",
        about: "Length 1 m, two cells wide, two rows held; rigidity by Gamma = w L^3 / B; settled, with as many substeps as the rigidity \
                needs. Droop over reach, H/W, against the heavy elastica (its table is exact to 7 digits)."
            .into(),
        errors: vec![Metric::new("H/W from the elastica", "relative"), Metric::new("H/W", "")],
        jobs,
        plots: vec![Plot::of(0)],
    })
}
