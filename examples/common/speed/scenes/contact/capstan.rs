//! P12 CAPSTAN: a strip is pulled over a cylinder, and over an edge, against Euler and Eytelwein's ratio.

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

/// Distance of particles \[m\].
const CELL: f64 = 0.01;
const COLUMNS: usize = 5;
const RADIUS: f64 = 0.1;
const EPSILON: f64 = 0.005;
/// Straight parts at both ends \[m\].
const ENDS: f64 = 0.15;
/// Force at the end that is held back \[N\].
const FORCE: f64 = 2.0;
/// It slips once its middle has gone so far \[m\].
const SLIPPED: f64 = 2e-3;
/// Frames in which it comes to rest under equal forces, and in which one grows.
const SETTLING: usize = 120;
const GROWING: usize = 600;

#[derive(Clone, Copy, PartialEq)]
enum Over {
    /// Half a turn.
    Cylinder,
    /// A quarter of one.
    Edge,
}

impl Over {
    fn turn(self) -> f64 {
        if self == Self::Cylinder { PI } else { FRAC_PI_2 }
    }

    /// Places along the strip, in the plane that it bends in.
    fn line(self) -> Vec<Vec3> {
        let around = RADIUS + EPSILON;
        let arc = if self == Self::Cylinder { PI * around } else { FRAC_PI_2 * EPSILON };
        let count = ((2.0 * ENDS + arc) / CELL).round() as usize + 1;
        let place = |i: usize| {
            let way = i as f64 * CELL - ENDS;
            let [x, y] = match self {
                Self::Cylinder => {
                    let angle = (way / around).clamp(0.0, PI);
                    let down = (-way).max(way - arc).max(0.0);
                    [-around * angle.cos(), around * angle.sin() - down]
                }
                Self::Edge => {
                    let angle = (way / EPSILON).clamp(0.0, FRAC_PI_2);
                    let (back, down) = ((-way).max(0.0), (way - arc).max(0.0));
                    [EPSILON * angle.sin() - back, EPSILON * angle.cos() - down]
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

    fn strip(self, friction: f32, budget: u32) -> Outcome<ClothSolver> {
        let line = self.line();
        let across = |column: usize| (column as f64 - 0.5 * (COLUMNS - 1) as f64) * CELL;
        let places = |at: &dyn Fn(usize) -> Vec3| -> Vec<Vec3> {
            let row =
                |row: usize| (0..COLUMNS).map(move |column| (row, Vec3::Z * across(column) as f32));
            (0..line.len()).flat_map(row).map(|(row, z)| at(row) + z).collect()
        };
        let rest = places(&|row| Vec3::X * (row as f64 * CELL) as f32);
        let lattice = Lattice::new(line.len(), COLUMNS, &rest, MassLumping::Lumped)?;
        let material = Material {
            thread_stiffness: 1e5,
            friction,
            thickness: EPSILON as f32,
            ..Material::USUAL
        };
        let substeps = Substeps::Automatic { budget };
        let settings = Settings { substeps, ..Settings::default() };
        let start = places(&|row| line[row]);
        let mut solver = ClothSolver::new(Arc::new(lattice), &start, material, settings)?;
        solver.set_shared(false);
        Ok(solver)
    }

    /// The ratio of forces at which it slips.
    fn run(self, friction: f64, budget: u32) -> Outcome<Measured> {
        let (solid, pose) = self.solid();
        let collider = Collider { friction: friction as f32, ..Collider::new(&*solid, pose) };
        let colliders = [collider];
        let exact = (friction * self.turn()).exp();
        let mut run = Run::new(self.strip(friction as f32, budget)?, &colliders);
        let rows = self.line().len();
        let ends = [0, (rows - 1) * COLUMNS];
        let middle = rows / 2 * COLUMNS + COLUMNS / 2;
        let mut found = f64::NAN;
        let mut from = run.cloth.position(middle);
        for frame in 0..SETTLING + GROWING {
            let grown = frame.saturating_sub(SETTLING) as f64 / GROWING as f64;
            // To one and a half times what Coulomb's law allows.
            let ratio = 1.0 + grown * (1.5 * exact - 1.0);
            for ((end, pull), force) in
                ends.into_iter().zip(self.pulls()).zip([FORCE, FORCE * ratio])
            {
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
    let mut jobs = Vec::new();
    for (over, name) in [(Over::Cylinder, "cylinder, half a turn"), (Over::Edge, "edge, a quarter")]
    {
        for &friction in frictions {
            for &budget in budgets {
                jobs.push(Job {
                    method: format!("{name}, mu = {friction}"),
                    n: over.line().len(),
                    knob: format!("budget {budget}"),
                    run: Box::new(move || over.run(friction, budget)),
                });
            }
        }
    }
    Ok(Scene {
        name: "p12",
        title: "P12 CAPSTAN: a strip is pulled over a cylinder, and over an edge",
        about: format!(
            "A strip of {COLUMNS} threads, particles {} cm apart, 1e5 N/m, over a fixed cylinder of radius {RADIUS} m and over the edge of a box; \
             6 g in all; {FORCE} N at one end, and a force at the other that grows over {} s. The ratio of forces at which its middle has gone \
             2 mm, and that of Euler (1769) and Eytelwein (1808), e^(mu phi).",
            CELL * 100.0,
            GROWING as f32 * FRAME
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
