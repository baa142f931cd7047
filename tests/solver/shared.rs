//! A large sheet or mesh, whose bands and domains the threads of a pool share: the same bits as in one piece, whatever the
//! number of threads.

use bevy::math::{Vec2, Vec3, primitives::Sphere};
use bevy_drape::solver::{
    Bending, ClothSolver, Collider, DampingForm, Graph, Lattice, MassLumping, Material, PinMotion,
    Pose, Settings, Stage, StepInput, StretchMethod, Topology,
};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Arc;

use crate::support::solver::*;

/// Rows and columns: enough for sheets of threads to be shared and for meshes of two domains, bands that end within a strip,
/// blocks that end within a row.
const SIZE: [usize; 2] = [293, 141];
const TICKS: i32 = 10;

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

#[derive(Clone, Copy, PartialEq)]
enum Shape {
    Sheet,
    /// Its cells differ in size.
    UnevenSheet,
    /// Its vertices are jittered, and it has waves at rest.
    Mesh,
}

fn topology(shape: Shape, lumping: MassLumping) -> Topology {
    let [rows, columns] = SIZE;
    let even_sheet = sheet(Vec2::new(2.0, 3.0), rows, columns, lumping);
    let bent = |p: &Vec3| Vec3::new(p.x * (1.0 + 0.02 * p.x), p.y, p.z * (1.0 + 0.03 * p.z * p.z));
    match shape {
        Shape::Sheet => even_sheet.into(),
        Shape::UnevenSheet => {
            let positions: Vec<_> = even_sheet.rest_positions().iter().map(bent).collect();
            Arc::new(Lattice::new(rows, columns, &positions, lumping).unwrap()).into()
        }
        Shape::Mesh => {
            let (mut positions, triangles) = jittered(rows, columns, 0.0125, 0.25, 3);
            for p in &mut positions {
                *p = Vec3::new(p.x - 0.9, 0.02 * (9.0 * p.z).sin(), p.z - 1.8);
            }
            Arc::new(Graph::new(&positions, &triangles, lumping).unwrap()).into()
        }
    }
}

struct Variant {
    what: &'static str,
    settings: Settings,
    material: Material,
    shape: Shape,
    /// Whether single particles are pinned; else a whole edge is.
    points: bool,
}

fn variants() -> [Variant; 6] {
    let soft =
        Material { thread_stiffness: 300.0, shear_stiffness: 20.0, friction: 0.4, ..plain() };
    // What threads leave is made up for where there is drag.
    let stiff = Material { thread_stiffness: 1e4, shear_stiffness: 1e3, drag: 1.0, ..soft };
    let threads = settings(StretchMethod::ImplicitThreads, 5);
    let springs = Settings { provot_passes: 2, ..settings(StretchMethod::ExplicitSprings, 5) };
    let damped = Material { flexural_rigidity: 1e-5, damping: 0.002, ..soft };
    let axial = Material { damping_form: DampingForm::Axial, max_strain: 0.02, ..damped };
    let flexion = Settings { lumping: MassLumping::Equal, bending: Bending::Flexion, ..springs };
    let (sheet, uneven, mesh) = (Shape::Sheet, Shape::UnevenSheet, Shape::Mesh);
    [
        Variant { what: "threads", settings: threads, material: stiff, shape: sheet, points: true },
        Variant {
            what: "limited",
            settings: threads,
            material: Material { drag: 1.0, ..axial },
            shape: uneven,
            points: false,
        },
        Variant {
            what: "springs",
            settings: springs,
            material: damped,
            shape: sheet,
            points: true,
        },
        Variant {
            what: "flexion",
            settings: flexion,
            material: axial,
            shape: uneven,
            points: true,
        },
        Variant {
            what: "mesh, threads",
            settings: threads,
            material: Material { drag: 1.0, ..axial },
            shape: mesh,
            points: true,
        },
        Variant {
            what: "mesh, springs",
            settings: springs,
            material: damped,
            shape: mesh,
            points: false,
        },
    ]
}

/// A cloth that swings into a ball that comes towards it: the bits after each tick, and what the ball was given.
fn busy(
    variant: &Variant,
    topology: &Topology,
    shared: bool,
    staged: bool,
) -> Vec<(Vec<[u32; 6]>, [u32; 3])> {
    let Variant { settings, material, points, .. } = *variant;
    let mut solver = at_rest(topology, Vec3::ZERO, material, settings);
    solver.set_shared(shared);
    let [rows, columns] = SIZE.map(|n| n as u32);
    let corners =
        [0, columns - 1, rows / 2 * columns + 7, (rows - 1) * columns, rows * columns - 1];
    let edge: Vec<u32> = (0..rows).map(|row| row * columns).collect();
    solver.set_pins(if points { &corners } else { &edge }).unwrap();
    let home: Vec<_> = solver.pins().iter().map(|&p| solver.position(p as usize)).collect();
    let ball = Sphere::new(0.6);
    let (low, high) = solver.bounds();
    let under = 0.5 * (low + high) - Vec3::Y * 0.62;
    let at = |tick: i32, from: Vec3, speed: f32| from + Vec3::Y * speed * tick as f32 * TICK;
    (0..TICKS)
        .map(|tick| {
            let pose = |tick| Pose { translation: at(tick, under, 1.0), ..Pose::IDENTITY };
            let collider = Collider::new(&ball, pose(tick)).moving_to(pose(tick + 1)).measured();
            let pin = |&p: &Vec3| PinMotion { start: at(tick, p, 0.3), end: at(tick + 1, p, 0.3) };
            let pins: Vec<_> = home.iter().map(pin).collect();
            let input = StepInput {
                dt: TICK,
                gravity: GRAVITY,
                pins: &pins,
                colliders: &[collider],
                ..StepInput::default()
            };
            take_tick(&mut solver, &input, staged);
            let is_cut = shared && rayon::current_num_threads() > 1;
            assert_eq!(solver.band_count() > 1, is_cut, "{}", variant.what);
            (bits(&solver), solver.impulse(0).linear.to_array().map(f32::to_bits))
        })
        .collect()
}

fn take_tick(solver: &mut ClothSolver, input: &StepInput<'_>, staged: bool) {
    if staged {
        for _ in 0..solver.begin_tick(input).unwrap() {
            solver.accumulate_forces(input);
            solver.integrate(input);
            solver.correct();
            solver.collide(input);
        }
        solver.end_tick().unwrap();
    } else {
        solver.tick(input).unwrap();
    }
}

#[test]
fn any_number_of_threads_gives_the_bits_of_one_piece() {
    for variant in variants() {
        let topology = topology(variant.shape, variant.settings.lumping);
        let whole = busy(&variant, &topology, false, false);
        let (first, last) = (&whole[0], &whole[TICKS as usize - 1]);
        assert!(first.0 != last.0, "{}: nothing moved", variant.what);
        assert!(whole.iter().any(|(_, impulse)| *impulse != [0; 3]), "{}: no touch", variant.what);
        for (threads, staged) in [(1, false), (2, false), (4, false), (2, true)] {
            let shared = pool(threads).install(|| busy(&variant, &topology, true, staged));
            for (tick, (a, b)) in whole.iter().zip(&shared).enumerate() {
                let what = format!("{}, {threads} threads, tick {tick}", variant.what);
                let columns = SIZE[1];
                if let Some(i) = (0..a.0.len()).find(|&i| a.0[i] != b.0[i]) {
                    panic!("{what}: row {}, column {} differs", i / columns, i % columns);
                }
                assert!(a.1 == b.1, "{what}: impulse {:?} is {:?}", a.1, b.1);
            }
        }
    }
}

/// An observed tick has the bits of a plain one, its stages in their order, and is taken in the pool where threads share
/// it.
#[test]
fn an_observed_tick_is_the_same_tick() {
    let Variant { settings, material, shape, .. } = variants()[0];
    let topology = topology(shape, settings.lumping);
    let mut plain = at_rest(&topology, Vec3::ZERO, material, settings);
    plain.set_shared(true);
    let mut observed = plain.clone();
    let input = StepInput { dt: TICK, gravity: GRAVITY, ..StepInput::default() };
    let (mut stages, mut in_pool) = (Vec::new(), Vec::new());
    let report = observed.tick_observed(&input, |stage| {
        stages.push(stage);
        in_pool.push(rayon::current_thread_index().is_some());
    });
    assert_eq!(report, plain.tick(&input));
    assert_eq!(bits(&observed), bits(&plain));
    let substep = [Stage::Forces, Stage::Integrate, Stage::Correct, Stage::Collide];
    let all = [Stage::Begin].into_iter().chain(substep.into_iter().cycle().take(4 * 5));
    assert!(stages.iter().copied().eq(all), "{stages:?}");
    let is_shared = rayon::current_num_threads() > 1;
    assert!(in_pool.iter().all(|&inside| inside == is_shared), "{in_pool:?}");
}
