//! P14: cloths that fall together, are wound up and twisted, with and without self-collision.

use std::{f32::consts::PI, sync::Arc, time::Instant};

use bevy::math::{
    Quat, Vec2, Vec3,
    primitives::{InfinitePlane3d, Sphere},
};
use bevy_drape::solver::{
    ClothSolver, Collider, Graph, Lattice, MassLumping, Material, PinMotion, Pose, SelfCollision,
    Settings, StepInput, Topology,
};

use super::super::run::{FRAME, GRAVITY, dice};
use super::super::{Extent, Job, Measured, Metric, Outcome, Scene};
use super::contact::peers;
use super::piles;

/// The fate of a cloth.
#[derive(Clone, Copy, PartialEq)]
enum Fate {
    /// Falls almost on its edge, into a heap.
    Edge,
    /// Falls over a ball, its corners onto the floor.
    Drape,
    /// Lies on a small ball, which begins to turn.
    Spin,
    /// Is a strip whose ends are turned against each other by so many turns, and come nearer.
    Twist(f32),
    /// Hangs by two corners, and touches nothing.
    Hang,
    /// Lies on the ground.
    Flat,
}

const FATES: [(&str, Fate); 7] = [
    ("EDGE", Fate::Edge),
    ("DRAPE with a floor", Fate::Drape),
    ("SPIN", Fate::Spin),
    ("TWIST 2", Fate::Twist(2.0)),
    ("TWIST 4", Fate::Twist(4.0)),
    ("HANG", Fate::Hang),
    ("flat on the ground", Fate::Flat),
];

impl Fate {
    fn seconds(self) -> f32 {
        if matches!(self, Self::Twist(_)) { 7.0 } else { 4.0 }
    }

    fn lattice(self, n: usize) -> Outcome<Lattice> {
        let (size, rows) = match self {
            Self::Drape => (Vec2::splat(2.0), n),
            Self::Twist(_) => (Vec2::new(1.0, 0.3), (0.3 * n as f32).round() as usize),
            Self::Edge | Self::Spin | Self::Hang | Self::Flat => (Vec2::ONE, n),
        };
        Ok(Lattice::sheet(size, rows, n, MassLumping::Lumped)?)
    }

    /// Where it starts.
    fn start(self, rest: &[Vec3]) -> Vec<Vec3> {
        let mut roll = dice(3);
        let turn = Quat::from_rotation_x(1.5);
        let mut place = |&p: &Vec3| match self {
            Self::Edge => turn * p + Vec3::new(roll(), roll(), roll()) * 0.0005 + Vec3::Y * 0.55,
            Self::Drape => p + Vec3::Y * 0.6,
            Self::Spin => p + Vec3::Y * 0.16,
            Self::Flat => p + Vec3::Y * 0.02,
            Self::Twist(_) | Self::Hang => p,
        };
        rest.iter().map(&mut place).collect()
    }

    fn pins(self, rows: usize, columns: usize) -> Vec<u32> {
        let ends = |row: usize| [row * columns, row * columns + columns - 1];
        let held = match self {
            Self::Twist(_) => (0..rows).flat_map(ends).collect(),
            Self::Hang => ends(0).to_vec(),
            Self::Edge | Self::Drape | Self::Spin | Self::Flat => Vec::new(),
        };
        held.into_iter().map(|particle| particle as u32).collect()
    }

    /// Where a pin is after some seconds.
    fn pin(self, home: Vec3, time: f32) -> Vec3 {
        let Self::Twist(turns) = self else { return home };
        let part = (time / 6.0).min(1.0);
        let turned = Quat::from_rotation_x(home.x.signum() * turns * PI * part) * home;
        Vec3::new(home.x * (1.0 - 0.25 * part), turned.y, turned.z)
    }

    /// Radius of its ball, and height of its ground.
    fn solids(self) -> (Option<f32>, Option<f32>) {
        match self {
            Self::Edge | Self::Flat => (None, Some(0.0)),
            Self::Drape => (Some(0.5), Some(-0.5)),
            Self::Spin => (Some(0.15), Some(-0.16)),
            Self::Twist(_) | Self::Hang => (None, None),
        }
    }

    /// How its ball lies after some seconds.
    fn turned(self, time: f32) -> Pose {
        let angle = if self == Self::Spin { (time - 1.0).max(0.0) * PI } else { 0.0 };
        Pose { rotation: Quat::from_rotation_y(angle), ..Pose::IDENTITY }
    }
}

/// A cloth of a fate.
#[derive(Clone, Copy)]
struct Case {
    fate: Fate,
    n: usize,
    is_mesh: bool,
    collides: bool,
}

impl Case {
    fn topology(&self) -> Outcome<Topology> {
        let lattice = self.fate.lattice(self.n)?;
        if !self.is_mesh {
            return Ok(Arc::new(lattice).into());
        }
        let columns = lattice.columns() as u32;
        let cells = (0..lattice.rows() as u32 - 1)
            .flat_map(|row| (0..columns - 1).map(move |column| row * columns + column));
        let halves = |a: u32| [[a, a + columns, a + columns + 1], [a, a + columns + 1, a + 1]];
        let triangles: Vec<_> = cells.flat_map(halves).collect();
        Ok(Arc::new(Graph::new(lattice.rest_positions(), &triangles, MassLumping::Lumped)?).into())
    }

    fn run(&self) -> Outcome<Measured> {
        let Self { fate, n, .. } = *self;
        let topology = self.topology()?;
        let start = fate.start(topology.rest_positions());
        let rows = topology.particle_count() / n;
        let mut cloth = ClothSolver::new(topology, &start, Material::USUAL, Settings::default())?;
        cloth.set_shared(false);
        cloth.set_pins(&fate.pins(rows, n))?;
        cloth.set_self_collision(self.collides.then(SelfCollision::default))?;
        let home: Vec<_> = cloth.pins().iter().map(|&p| cloth.position(p as usize)).collect();
        let (radius, height) = fate.solids();
        let (ball, ground) = (Sphere::new(radius.unwrap_or(1.0)), InfinitePlane3d::new(Vec3::Y));
        let gravity = if matches!(fate, Fate::Twist(_)) { Vec3::ZERO } else { GRAVITY };
        let frames = (fate.seconds() / FRAME).round() as usize;
        let (mut times, mut worst, mut peak, mut p99) = (Vec::new(), 0, 0.0_f32, 0.0_f32);
        for frame in 0..frames {
            let [from, to] = [frame, frame + 1].map(|frame| frame as f32 * FRAME);
            let pin = |&p: &Vec3| PinMotion { start: fate.pin(p, from), end: fate.pin(p, to) };
            let pins: Vec<_> = home.iter().map(pin).collect();
            let floor = |height: f32| {
                Collider::new(&ground, Pose { translation: Vec3::Y * height, ..Pose::IDENTITY })
            };
            let ball =
                radius.map(|_| Collider::new(&ball, fate.turned(from)).moving_to(fate.turned(to)));
            let colliders: Vec<_> = ball.into_iter().chain(height.map(floor)).collect();
            let input = StepInput {
                dt: FRAME,
                gravity,
                pins: &pins,
                colliders: &colliders,
                ..StepInput::default()
            };
            let begun = Instant::now();
            cloth.tick(&input)?;
            times.push(begun.elapsed().as_secs_f64() * 1e3);
            let strain = cloth.strain();
            (peak, p99) = (peak.max(strain.max), p99.max(strain.p99));
            if frame % 4 == 3 {
                worst = worst.max(cloth.crossings());
            }
        }
        let [p99, peak] = [p99, peak].map(|strain| f64::from(strain) * 100.0);
        let errors = vec![worst.into(), cloth.crossings().into(), p99, peak];
        let work = cloth.topology().particle_count() * cloth.plan().substeps as usize;
        Ok(Measured { frames: times, errors, work, allocations: f64::NAN, ..Measured::default() })
    }
}

pub fn scene(extent: Extent) -> Outcome<Scene<'static>> {
    let sizes: &[usize] = if extent.quick { &[64] } else { &[32, 64, 80, 128] };
    let mut jobs = Vec::new();
    for (name, fate) in FATES {
        let has_sizes = matches!(fate, Fate::Edge | Fate::Drape | Fate::Spin);
        for &n in sizes.iter().filter(|&&n| n == 64 || has_sizes) {
            let mut kinds = vec![(false, false), (false, true)];
            if n == 64 && matches!(fate, Fate::Edge | Fate::Drape) {
                kinds.extend([(true, false), (true, true)]);
            }
            for (is_mesh, collides) in kinds {
                let case = Case { fate, n, is_mesh, collides };
                jobs.push(Job {
                    method: format!("{name}, {}", if is_mesh { "mesh" } else { "sheet" }),
                    n,
                    knob: if collides { "self-collision" } else { "off" }.into(),
                    run: Box::new(move || case.run()),
                });
            }
        }
    }
    jobs.extend(piles::jobs());
    let columns = ["crossings", "at_end", "p99", ""];
    jobs.extend(peers::jobs("peer_layers.csv", "layers", 64, &columns)?);
    Ok(Scene {
        name: "p14",
        title: "P14 LAYERS: cloths that fall together, are wound up and twisted",
        about: "The usual material. EDGE: 1 m x 1 m falls almost on its edge. DRAPE: 2 m x 2 m falls over a ball of radius 0.5 m, its corners onto \
                a floor. SPIN: 1 m x 1 m on a ball of radius 0.15 m, which turns by 180 degrees a second from the first second on. TWIST k: a \
                strip of 1 m x 0.3 m, both ends turned against each other by k turns in 6 s while they come nearer by a quarter. Five sheets, 10 mm \
                apart, fall over a ball of a quarter of their size; ten of 2 m, 0.1 m apart, onto the ground, where a ball dents them. Crossings: edges \
                that pierce faces, of the same cloth or, of several cloths, of another, the most of every fourth frame in 4 s (TWIST: 7 s), and at the end; p99 and largest strain: of all frames. \
                Times are the median frame's, of the substeps that the plan takes."
            .into(),
        errors: vec![
            Metric::new("crossings", ""),
            Metric::new("crossings at the end", ""),
            Metric::new("p99 strain", "%"),
            Metric::new("largest strain", "%"),
        ],
        jobs,
        plots: Vec::new(),
    })
}
