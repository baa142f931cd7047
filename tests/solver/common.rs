//! Scenes and measurements that the tests share.

use std::sync::Arc;

use bevy::math::{DVec3, Vec2, Vec3};
use bevy_drape::solver::{
    ClothSolver, Collider, DampingForm, Graph, Lattice, MassLumping, Material, PinMotion, Settings,
    StepInput, StretchMethod, Substeps, TickReport, Topology,
};

pub const TICK: f32 = 1.0 / 64.0;
pub const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);

/// Prints a measurement beside what it ought to be, and fails beyond the tolerance.
#[track_caller]
#[allow(clippy::print_stdout)]
pub fn check(what: &str, measured: f64, reference: f64, tolerance: f64) {
    println!("{what}: {measured:.6e}, reference {reference:.6e}, tolerance {tolerance:.1e}");
    let error = (measured - reference).abs();
    assert!(error <= tolerance, "{what}: {measured} is {error} from {reference}");
}

/// Prints a measurement beside its bound, and fails above it.
#[track_caller]
#[allow(clippy::print_stdout)]
pub fn check_at_most(what: &str, measured: f64, bound: f64) {
    println!("{what}: {measured:.6e}, at most {bound:.1e}");
    assert!(measured <= bound, "{what}: {measured} is above {bound}");
}

/// 0.2 kg/m2 and threads of 1000 N/m; all else is off.
pub fn plain() -> Material {
    Material {
        area_density: 0.2,
        thread_stiffness: 1000.0,
        shear_stiffness: 0.0,
        flexural_rigidity: 0.0,
        bending_friction: 0.0,
        damping: 0.0,
        damping_form: DampingForm::Axial,
        drag: 0.0,
        max_strain: 10.0,
        friction: 0.0,
        thickness: 0.005,
    }
}

pub fn settings(form: StretchMethod, substeps: u32) -> Settings {
    Settings { stretch_method: form, substeps: Substeps::Fixed(substeps), ..Settings::default() }
}

/// A flat sheet in the xz plane.
pub fn sheet(size: Vec2, rows: usize, columns: usize, lumping: MassLumping) -> Arc<Lattice> {
    Arc::new(Lattice::sheet(size, rows, columns, lumping).unwrap())
}

/// A flat sheet in the xy plane, its first row on top at y = 0.
pub fn curtain(size: Vec2, rows: usize, columns: usize, lumping: MassLumping) -> Arc<Lattice> {
    let positions: Vec<_> = (0..rows)
        .flat_map(|r| (0..columns).map(move |c| (r, c)))
        .map(|(r, c)| {
            let (x, y) = (c as f32 / (columns - 1) as f32, r as f32 / (rows - 1) as f32);
            Vec3::new((x - 0.5) * size.x, -y * size.y, 0.0)
        })
        .collect();
    Arc::new(Lattice::new(rows, columns, &positions, lumping).unwrap())
}

/// A cloth in its rest shape, moved by `offset`.
pub fn at_rest<T: Clone + Into<Topology>>(
    topology: &T,
    offset: Vec3,
    material: Material,
    settings: Settings,
) -> ClothSolver {
    let topology: Topology = topology.clone().into();
    let positions: Vec<_> = topology.rest_positions().iter().map(|&p| p + offset).collect();
    ClothSolver::new(topology, &positions, material, settings).unwrap()
}

/// Pins, then soft pins, that stay where their particles are.
pub fn still(solver: &ClothSolver) -> Vec<PinMotion> {
    let soft = solver.soft_pins().map(|pin| pin.particle);
    let held = solver.pins().iter().copied().chain(soft);
    held.map(|p| PinMotion::still(solver.position(p as usize))).collect()
}

/// Takes ticks with the pins where they are.
pub fn run(
    solver: &mut ClothSolver,
    ticks: usize,
    gravity: Vec3,
    colliders: &[Collider<'_>],
) -> TickReport {
    let pins = still(solver);
    let input = StepInput { dt: TICK, gravity, pins: &pins, colliders, ..StepInput::default() };
    let mut report = TickReport::default();
    for _ in 0..ticks {
        report = solver.tick(&input).unwrap();
    }
    report
}

pub fn positions(solver: &ClothSolver) -> Vec<Vec3> {
    (0..solver.topology().particle_count()).map(|i| solver.position(i)).collect()
}

pub fn velocities(solver: &ClothSolver) -> Vec<Vec3> {
    (0..solver.topology().particle_count()).map(|i| solver.velocity(i)).collect()
}

/// The bits of all positions relative to the origin, and velocities.
pub fn bits(solver: &ClothSolver) -> Vec<[u32; 6]> {
    (0..solver.topology().particle_count())
        .map(|i| {
            let (x, v) = (solver.local_position(i), solver.velocity(i));
            [x.x, x.y, x.z, v.x, v.y, v.z].map(f32::to_bits)
        })
        .collect()
}

pub fn farthest(a: &[Vec3], b: &[Vec3]) -> f64 {
    let apart = |(a, b): (&Vec3, &Vec3)| a.as_dvec3().distance(b.as_dvec3());
    a.iter().zip(b).map(apart).fold(0.0, f64::max)
}

pub fn fastest(solver: &ClothSolver) -> f64 {
    velocities(solver).iter().map(|v| v.as_dvec3().length()).fold(0.0, f64::max)
}

/// Linear and angular momentum about the world's origin. The velocity is that of the last substep's
/// middle, but along it the lever does not change.
pub fn momenta(solver: &ClothSolver) -> (DVec3, DVec3) {
    let count = solver.topology().particle_count();
    (0..count).fold((DVec3::ZERO, DVec3::ZERO), |(linear, angular), i| {
        let p = solver.velocity(i).as_dvec3() * f64::from(solver.mass(i));
        (linear + p, angular + solver.position(i).as_dvec3().cross(p))
    })
}

/// Strains of structural and shear springs, from rest shape and positions alone.
pub fn strains(solver: &ClothSolver) -> Vec<f64> {
    let lattice = solver.lattice().unwrap();
    let (rows, columns) = (lattice.rows(), lattice.columns());
    let rest = lattice.rest_positions();
    let mut out = Vec::new();
    for r in 0..rows {
        for c in 0..columns {
            for (dr, dc) in [(0, 1), (1, 0), (1, 1), (1, -1)] {
                let (r2, c2) = (r + dr, c as isize + dc);
                if r2 < rows && c2 >= 0 && (c2 as usize) < columns {
                    let (i, j) = (r * columns + c, r2 * columns + c2 as usize);
                    let length =
                        solver.position(i).as_dvec3().distance(solver.position(j).as_dvec3());
                    out.push(length / rest[i].as_dvec3().distance(rest[j].as_dvec3()) - 1.0);
                }
            }
        }
    }
    out
}

pub fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// Numbers from -1 to 1 that are the same everywhere (an LCG of Knuth's).
pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
    }

    pub fn vector(&mut self) -> Vec3 {
        Vec3::new(self.roll(), self.roll(), self.roll())
    }
}

/// Rows of a reference table, without its comments and its head.
pub fn table(text: &str) -> Vec<Vec<String>> {
    text.lines()
        .filter(|line| !line.starts_with('#'))
        .skip(1)
        .map(|line| line.split(',').map(str::to_owned).collect())
        .collect()
}

/// A sheet of `rows` x `columns` particles in the xz plane, `cell` apart, triangulated with diagonals
/// at random; inner particles are off by up to `jitter` cells. Rows along z, columns along x, the
/// first particle at the origin.
pub fn jittered(
    rows: usize,
    columns: usize,
    cell: f32,
    jitter: f32,
    seed: u64,
) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut dice = Dice(seed);
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for r in 0..rows {
        for c in 0..columns {
            let inner = r > 0 && r + 1 < rows && c > 0 && c + 1 < columns;
            let (x, z) = (dice.roll() * jitter, dice.roll() * jitter);
            let off = if inner { Vec3::new(x, 0.0, z) } else { Vec3::ZERO };
            positions.push((Vec3::new(c as f32, 0.0, r as f32) + off) * cell);
            if r + 1 == rows || c + 1 == columns {
                continue;
            }
            let at = (r * columns + c) as u32;
            let (right, below, across) = (at + 1, at + columns as u32, at + columns as u32 + 1);
            if dice.roll() > 0.0 {
                triangles.extend([[at, below, across], [at, across, right]]);
            } else {
                triangles.extend([[at, below, right], [right, below, across]]);
            }
        }
    }
    (positions, triangles)
}

/// A graph of a [`jittered`] sheet, lumped.
pub fn mesh(rows: usize, columns: usize, cell: f32, jitter: f32) -> Arc<Graph> {
    let (positions, triangles) = jittered(rows, columns, cell, jitter, 7);
    Arc::new(Graph::new(&positions, &triangles, MassLumping::Lumped).unwrap())
}

/// A sheet of nearly equilateral triangles of side `side` in the xz plane, rows along x; odd rows
/// begin half a side later, with the same number of particles, and the borders across are cut
/// straight.
pub fn hexagonal(rows: usize, columns: usize, side: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let height = side * 0.75_f32.sqrt();
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for r in 0..rows {
        for c in 0..columns {
            let shift = if r % 2 == 1 { 0.5 } else { 0.0 };
            let last = columns as f32 - 1.0;
            let x = if c == 0 { 0.0 } else { (c as f32 + shift).min(last) };
            let x = if c + 2 == columns && r % 2 == 1 { last - 0.5 } else { x };
            positions.push(Vec3::new(x * side, 0.0, r as f32 * height));
            if r + 1 == rows || c + 1 == columns {
                continue;
            }
            let at = (r * columns + c) as u32;
            let (right, below, across) = (at + 1, at + columns as u32, at + columns as u32 + 1);
            if r % 2 == 1 {
                triangles.extend([[at, below, across], [at, across, right]]);
            } else {
                triangles.extend([[at, below, right], [right, below, across]]);
            }
        }
    }
    (positions, triangles)
}
