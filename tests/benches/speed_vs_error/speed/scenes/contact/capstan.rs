//! P12 CAPSTAN: a strip is pulled over a cylinder, and over an edge, against the ratio of Euler and Eytelwein, with the
//! strip's own weight.

use core::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use bevy::math::{
    Vec3,
    primitives::{Cuboid, Cylinder},
};
use bevy_drape::{
    sdf::SignedDistance,
    solver::{
        ClothSolver, Collider, Lattice, MassLumping, Material, Pose, PushOn, PushWith, Settings,
        Substeps,
    },
};

use super::super::super::run::{FRAME, Run};
use super::super::super::{Extent, Job, Measured, Metric, Outcome, Scene};

const COLUMNS: usize = 5;
const RADIUS: f64 = 0.1;
const EPSILON: f64 = 0.005;
/// Straight parts at both ends \[m\].
const ENDS: f64 = 0.15;
/// It slips once its middle has gone so far \[m\].
const SLIPPED: f64 = 2e-3;
/// Frames in which it comes to rest under equal forces, and in which one grows.
const SETTLING: usize = 120;
const GROWING: usize = 2400;
/// Steps in which the exact ratio is summed up.
const STEPS: u32 = 10_000;

#[derive(Clone, Copy, PartialEq)]
enum Over {
    /// Half a turn.
    Cylinder,
    /// A quarter of one.
    Edge,
}

/// A strip over a solid.
#[derive(Clone, Copy)]
struct Strip {
    over: Over,
    /// Distance of particles \[m\].
    cell: f64,
    /// Force at the end that is held back \[N\].
    force: f64,
    friction: f64,
    budget: u32,
}

impl Over {
    fn turn(self) -> f64 {
        if self == Self::Cylinder { PI } else { FRAC_PI_2 }
    }

    /// Radius of the arc that the strip lies in \[m\].
    fn radius(self) -> f64 {
        if self == Self::Cylinder { RADIUS + EPSILON } else { EPSILON }
    }

    /// Places along a strip, so far apart, in the plane that it bends in.
    fn line(self, cell: f64) -> Vec<Vec3> {
        let (around, arc) = (self.radius(), self.turn() * self.radius());
        let count = ((2.0 * ENDS + arc) / cell).round() as usize + 1;
        let place = |i: usize| {
            let way = i as f64 * cell - ENDS;
            let [x, y] = match self {
                Self::Cylinder => {
                    let angle = (way / around).clamp(0.0, PI);
                    let down = (-way).max(way - arc).max(0.0);
                    [-around * angle.cos(), around * angle.sin() - down]
                }
                Self::Edge => {
                    let angle = (way / around).clamp(0.0, FRAC_PI_2);
                    let (back, down) = ((-way).max(0.0), (way - arc).max(0.0));
                    [around * angle.sin() - back, around * angle.cos() - down]
                }
            };
            Vec3::new(x as f32, y as f32, 0.0)
        };
        (0..count).map(place).collect()
    }

    /// Which way the ends are pulled.
    fn pulls(self) -> [Vec3; 2] {
        [if self == Self::Cylinder { Vec3::NEG_Y } else { Vec3::NEG_X }, Vec3::NEG_Y]
    }

    fn solid(self) -> (Box<dyn SignedDistance>, Pose) {
        let rotation = bevy::math::Quat::from_rotation_x(FRAC_PI_2 as f32);
        match self {
            Self::Cylinder => {
                let solid = Cylinder::new(RADIUS as f32, 1.0);
                (Box::new(solid), Pose { rotation, ..Pose::IDENTITY })
            }
            // Its edge is the z axis.
            Self::Edge => {
                let corner = Vec3::new(-0.5, -0.5, 0.0);
                (Box::new(Cuboid::new(1.0, 1.0, 1.0)), Pose::from_translation(corner))
            }
        }
    }
}

impl Strip {
    fn line(&self) -> Vec<Vec3> {
        self.over.line(self.cell)
    }

    fn solver(&self) -> Outcome<ClothSolver> {
        let line = self.line();
        let across = |column: usize| (column as f64 - 0.5 * (COLUMNS - 1) as f64) * self.cell;
        let places = |at: &dyn Fn(usize) -> Vec3| -> Vec<Vec3> {
            let row =
                |row: usize| (0..COLUMNS).map(move |column| (row, Vec3::Z * across(column) as f32));
            (0..line.len()).flat_map(row).map(|(row, z)| at(row) + z).collect()
        };
        let rest = places(&|row| Vec3::X * (row as f64 * self.cell) as f32);
        let lattice = Lattice::new(line.len(), COLUMNS, &rest, MassLumping::Lumped)?;
        // It bends freely: stiffness and its friction add to what it takes to pull it over a sharp edge.
        let material = Material {
            thread_stiffness: 1e5,
            flexural_rigidity: 0.0,
            bending_friction: 0.0,
            friction: self.friction as f32,
            thickness: EPSILON as f32,
            ..Material::USUAL
        };
        let substeps = Substeps::Automatic { budget: self.budget };
        let settings = Settings { substeps, ..Settings::default() };
        let start = places(&|row| line[row]);
        let mut solver = ClothSolver::new(Arc::new(lattice), &start, material, settings)?;
        solver.set_shared(false);
        Ok(solver)
    }

    /// The ratio of forces at which it is to slip, for a weight by its length \[N/m\]: `dT = mu N ds` and what weighs along
    /// it, with `N = T / r` and what weighs on the solid.
    fn exact(&self, weight: f64) -> f64 {
        let Self { over, force, friction, .. } = *self;
        let hangs = ENDS * weight;
        // One end hangs, or lies on the solid.
        let mut tension = force + if over == Over::Cylinder { hangs } else { friction * hangs };
        let angle = over.turn() / f64::from(STEPS);
        for step in 0..STEPS {
            let turned = (f64::from(step) + 0.5) * angle;
            // Parts of the weight on the solid, and against the way that it slips.
            let (on, against) = match over {
                Over::Cylinder => turned.sin_cos(),
                Over::Edge => (turned.cos(), -turned.sin()),
            };
            let arc = over.radius() * angle;
            let pressed = tension / over.radius() + weight * on;
            tension += (weight * against + friction * pressed) * arc;
        }
        (tension - hangs) / force
    }

    /// The ratio of forces at which it slips.
    fn run(self) -> Outcome<Measured> {
        let (solid, pose) = self.over.solid();
        let collider = Collider { friction: self.friction as f32, ..Collider::new(&*solid, pose) };
        let colliders = [collider];
        let mut run = Run::new(self.solver()?, &colliders);
        let rows = self.line().len();
        let mass = (0..rows * COLUMNS).map(|i| f64::from(run.cloth.mass(i))).sum::<f64>();
        let gravity = f64::from(run.gravity.length());
        let exact = self.exact(mass * gravity / ((rows - 1) as f64 * self.cell));
        let ends = [0, (rows - 1) * COLUMNS];
        let middle = rows / 2 * COLUMNS + COLUMNS / 2;
        let mut found = f64::NAN;
        let mut from = run.cloth.position(middle);
        for frame in 0..SETTLING + GROWING {
            let grown = frame.saturating_sub(SETTLING) as f64 / GROWING as f64;
            // To one and a half times what Coulomb's law allows.
            let ratio = 1.0 + grown * (1.5 * exact - 1.0);
            let forces = [self.force, self.force * ratio];
            for ((end, pull), force) in ends.into_iter().zip(self.over.pulls()).zip(forces) {
                for i in end..end + COLUMNS {
                    let share = pull * (force / COLUMNS as f64) as f32;
                    run.cloth.push(PushOn::Particle(i as u32), PushWith::Force(share))?;
                }
            }
            run.frame();
            let at = run.cloth.position(middle);
            if frame < SETTLING {
                from = at;
            } else if f64::from(at.distance(from)) > SLIPPED {
                found = ratio;
                break;
            }
        }
        let off = 100.0 * (found / exact - 1.0);
        let mut measured = run.measured(vec![found, exact, off]);
        if found.is_nan() {
            measured.failed = Some("does not slip".into());
        }
        Ok(measured)
    }
}

pub fn scene(extent: Extent) -> Outcome<Scene<'static>> {
    let frictions: &[f64] = if extent.quick { &[0.3] } else { &[0.1, 0.3, 0.5] };
    let budgets: &[u32] = if extent.quick { &[20] } else { &[20, 8] };
    // Solids, distances of particles [m], forces [N].
    let kinds = [
        (Over::Cylinder, 0.01, 0.06),
        (Over::Cylinder, 0.01, 0.2),
        (Over::Edge, 0.004, 0.03),
        (Over::Edge, 0.01, 0.06),
    ];
    let mut jobs = Vec::new();
    for (over, cell, force) in kinds {
        let name = match over {
            Over::Cylinder => "cylinder",
            Over::Edge => "edge",
        };
        for &friction in frictions {
            for &budget in budgets {
                let strip = Strip { over, cell, force, friction, budget };
                jobs.push(Job {
                    method: format!("{name}, {force} N, mu = {friction}"),
                    n: strip.line().len(),
                    knob: format!("budget {budget}, {} mm", cell * 1e3),
                    run: Box::new(move || strip.run()),
                });
            }
        }
    }
    Ok(Scene {
        name: "p12",
        title: "P12 CAPSTAN: a strip is pulled over a cylinder, and over an edge",
        about: format!(
            "A strip of {COLUMNS} threads, 1e5 N/m, that bends freely, over half a turn of a fixed cylinder of radius {RADIUS} m and over the \
             edge of a box, a quarter; held {} mm outside. One end is held back by a force, of one to four times its weight, and that at \
             the other grows over {} s. The ratio of forces at which its middle has gone 2 mm, and that of Euler (1769) and Eytelwein (1808) \
             with the strip's own weight.",
            EPSILON * 1e3,
            (GROWING as f32 * FRAME).round()
        ),
        errors: vec![
            Metric::new("slips at", ""),
            Metric::new("exact", ""),
            Metric::new("error", "%"),
        ],
        jobs,
        plots: Vec::new(),
    })
}
