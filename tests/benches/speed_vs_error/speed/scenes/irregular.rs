//! P13: HANG on an irregular mesh, and the swing of an irregular sheet that hangs from a bar; with a sheet in the same runs.

use std::{f64::consts::TAU, rc::Rc, sync::Arc};

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{
    ClothSolver, Graph, Lattice, MassLumping, Material, Settings, Substeps, Topology,
};
use examples_common::repository;

use super::super::run::{Run, dice};
use super::super::{Against, Extent, Job, Measured, Metric, Outcome, Plot, Scene};
use super::falls;
use crate::exact::Motion;

/// How far a vertex is off its place in the grid, in spacings.
const JITTER: f32 = 0.3;

/// A square in the xz plane around the origin, whose inner vertices are jittered and whose diagonals go either way.
pub fn square(side: f32, n: usize, lumping: MassLumping) -> Outcome<Topology> {
    let cell = side / (n - 1) as f32;
    let mut roll = dice(7);
    let mut positions = Vec::new();
    for row in 0..n {
        for column in 0..n {
            let is_inner = row > 0 && row + 1 < n && column > 0 && column + 1 < n;
            let off = Vec3::new(roll(), 0.0, roll()) * JITTER;
            let off = if is_inner { off } else { Vec3::ZERO };
            let place = Vec3::new(column as f32, 0.0, row as f32) + off;
            positions.push(place * cell - Vec3::new(0.5, 0.0, 0.5) * side);
        }
    }
    let mut triangles = Vec::new();
    for a in (0..n * (n - 1)).filter(|a| a % n + 1 < n) {
        let [a, b, c, d] = [a, a + 1, a + n, a + n + 1].map(|vertex| vertex as u32);
        triangles.extend(if roll() > 0.0 {
            [[a, c, d], [a, d, b]]
        } else {
            [[a, c, b], [b, c, d]]
        });
    }
    Ok(Arc::new(Graph::new(&positions, &triangles, lumping)?).into())
}

/// One metre of irregular mesh, or of sheet.
fn cloth(is_mesh: bool, n: usize, lumping: MassLumping) -> Outcome<Topology> {
    if is_mesh {
        return square(1.0, n, lumping);
    }
    Ok(Arc::new(Lattice::sheet(Vec2::ONE, n, n, lumping)?).into())
}

const KINDS: [(&str, bool); 2] = [("sheet", false), ("mesh", true)];

fn job(
    (name, is_mesh): (&str, bool),
    n: usize,
    substeps: u32,
    run: impl Fn(bool, usize, Substeps) -> Outcome<Measured> + 'static,
) -> Job<'static> {
    Job {
        method: name.into(),
        n,
        knob: format!("{substeps} substeps"),
        run: Box::new(move || run(is_mesh, n, Substeps::Fixed(substeps))),
    }
}

/// 3 s.
const FRAMES: usize = 180;

fn fall(is_mesh: bool, n: usize, substeps: Substeps, exact: &Motion) -> Outcome<Measured> {
    let lumping = MassLumping::Equal;
    let topology = cloth(is_mesh, n, lumping)?;
    let edge = Vec3::Z * 0.5;
    let rest: Vec<_> = topology.rest_positions().iter().map(|&at| at + edge).collect();
    let settings = Settings { substeps, lumping, ..Settings::default() };
    let mut solver = ClothSolver::new(topology, &rest, falls::MATERIAL, settings)?;
    solver.set_shared(false);
    solver.set_pins(&[0, n as u32 - 1])?;
    let mut run = Run::new(solver, &[]);
    let (mut square, mut p99, mut largest) = (0.0, 0.0_f32, 0.0_f32);
    for frame in 1..=FRAMES {
        run.frame();
        if frame % 6 == 0 && frame <= 36 {
            square += exact.mean_square(&run.cloth, &rest, frame as f64 / 60.0) / 6.0;
        }
        if frame % 60 == 0 {
            p99 = p99.max(run.cloth.strain().p99);
        }
        largest = largest.max(run.cloth.strain().max);
    }
    let [p99, largest] = [p99, largest].map(|strain| f64::from(strain) * 100.0);
    Ok(run.measured(vec![square.sqrt() * 1e3, p99, largest]))
}

pub fn hang(extent: Extent) -> Outcome<Scene<'static>> {
    let (sizes, all): (&[usize], &[u32]) = if extent.quick {
        (&[48], &[8, 20])
    } else {
        (&[32, 48, 64, 96, 128], &[4, 8, 20, 40, 80])
    };
    let mut jobs = Vec::new();
    for &n in sizes {
        let exact = Rc::new(Motion::new(n));
        for kind in KINDS {
            for &substeps in all {
                let exact = exact.clone();
                jobs.push(job(kind, n, substeps, move |is_mesh, n, substeps| {
                    fall(is_mesh, n, substeps, &exact)
                }));
            }
        }
    }
    jobs.extend(peers()?);
    let by_substeps = |metric| Plot { n: Some(48), against: Against::Substeps, ..Plot::of(metric) };
    Ok(Scene {
        name: "p13",
        title: "P13 IRREGULAR: HANG on a mesh of jittered vertices",
        about: "The cloth of HANG as a mesh, its vertices jittered by up to 0.3 spacings and its diagonals random, and as a sheet in the same \
                run. RMS: all particles against the exact motion of the inextensible sheet at t = 0.1, 0.2 ... 0.6 s; p99 strain: the worst \
                of t = 1, 2, 3 s; largest strain: of any thread after any frame of 3 s. Others: as recorded, times of their own machine \
                (tests/data/peer_irregular.csv)."
            .into(),
        errors: vec![
            Metric::new("RMS", "mm"),
            Metric::new("p99 strain", "%"),
            Metric::new("largest strain", "%"),
        ],
        jobs,
        plots: vec![
            Plot { n: Some(48), ..Plot::of(0) },
            by_substeps(0),
            by_substeps(1),
            Plot { against: Against::Resolution, ..Plot::of(0) },
        ],
    })
}

/// What other solvers reached at 48 a side, as recorded.
fn peers() -> Outcome<Vec<Job<'static>>> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(repository("tests/data/peer_irregular.csv"))?;
    let mut jobs = Vec::new();
    for row in reader.records() {
        let row = row?;
        let number = |at: usize| row[at].parse::<f64>();
        let measured = Measured {
            frames: vec![number(5)?],
            errors: vec![number(2)?, number(3)?, number(4)?],
            allocations: f64::NAN,
            ..Measured::default()
        };
        jobs.push(Job {
            method: row[0].into(),
            n: 48,
            knob: row[1].into(),
            run: Box::new(move || Ok(measured.clone())),
        });
    }
    Ok(jobs)
}

/// The first zero of the Bessel function J0, and the frequency of a chain's first mode over `sqrt(g / L)`.
const ZERO: f64 = 2.404826;
const FIRST: f64 = 1.202413;
/// Largest velocity at the start \[m/s\].
const SPEED: f64 = 0.05;

/// The first mode of a hanging chain of one metre (Daniel Bernoulli 1732) at a height below its bar.
fn mode(height: f64) -> f64 {
    let quarter = ZERO * ZERO * (1.0 + height).max(0.0) / 4.0;
    let terms = (1..14).scan(1.0, |term, k| {
        *term *= -quarter / f64::from(k * k);
        Some(*term)
    });
    1.0 + terms.sum::<f64>()
}

/// How much faster than the chain it swings \[%\], and the part of the first two seconds' amplitude that is left in the last two.
fn swinging(is_mesh: bool, n: usize, substeps: Substeps) -> Outcome<Measured> {
    const SETTLING: usize = 120;
    const SWINGING: usize = 900;
    const LOOK: usize = 120;
    let topology = cloth(is_mesh, n, MassLumping::Lumped)?;
    let hung = |at: &Vec3| Vec3::new(at.x, -(at.z + 0.5), 0.0);
    let start: Vec<_> = topology.rest_positions().iter().map(hung).collect();
    let material = Material { drag: 0.0, bending_friction: 0.0, ..Material::USUAL };
    let settings = Settings { substeps, ..Settings::default() };
    let mut solver = ClothSolver::new(topology, &start, material, settings)?;
    solver.set_shared(false);
    solver.set_pins(&(0..n as u32).collect::<Vec<_>>())?;
    let mut run = Run::new(solver, &[]);
    // Its threads come to their length.
    run.frames(SETTLING);
    for particle in n..n * n {
        let speed = SPEED * mode(run.cloth.position(particle).y.into());
        run.cloth.set_velocity(particle, Vec3::Z * speed as f32)?;
    }
    let mut amplitudes = Vec::new();
    for _ in 0..SWINGING {
        run.frame();
        let part = |i: usize| {
            let at = run.cloth.position(i).as_dvec3();
            at.z * mode(at.y) * f64::from(run.cloth.mass(i))
        };
        amplitudes.push((0..n * n).map(part).sum::<f64>());
    }
    let largest = |part: &[f64]| part.iter().fold(0.0_f64, |most, it| most.max(it.abs()));
    let left = largest(&amplitudes[SWINGING - LOOK..]) / largest(&amplitudes[..LOOK]);
    let upwards = |(frame, pair): (usize, &[f64])| {
        let crosses = pair[0] < 0.0 && pair[1] >= 0.0;
        crosses.then(|| frame as f64 - pair[0] / (pair[1] - pair[0]))
    };
    let passages: Vec<_> = amplitudes.windows(2).enumerate().filter_map(upwards).collect();
    let (Some(first), Some(last)) = (passages.first(), passages.last()) else {
        return Err("it does not swing".into());
    };
    let period = (last - first) / (passages.len() - 1) as f64 / 60.0;
    let exact = TAU / (FIRST * f64::from(super::super::run::GRAVITY.length()).sqrt());
    Ok(run.measured(vec![(exact / period - 1.0) * 100.0, left]))
}

pub fn swing(extent: Extent) -> Outcome<Scene<'static>> {
    let all: &[u32] = if extent.quick { &[20] } else { &[8, 20, 40] };
    let jobs = KINDS
        .into_iter()
        .flat_map(|kind| all.iter().map(move |&substeps| job(kind, 48, substeps, swinging)));
    Ok(Scene {
        name: "p13_swing",
        title: "P13 IRREGULAR: a hanging sheet swings in its first mode",
        about: "1 m x 1 m, 48 x 48 particles of the usual material without drag and friction, held by a bar, as the mesh of P13 and as a \
                sheet. Frequency: against 1.202413 sqrt(g / L) of the inextensible chain (Daniel Bernoulli 1732); amplitude: what is left of \
                it after 15 s."
            .into(),
        errors: vec![Metric::new("frequency", "%"), Metric::new("amplitude left", "")],
        jobs: jobs.collect(),
        plots: Vec::new(),
    })
}
