//! Bit equality: twice, stage by stage, on every instruction set.

use bevy::math::{Quat, Vec2, Vec3, bounding::Aabb3d, primitives::Sphere};
use bevy_drape::{
    sdf::{SdfSample, SignedDistance},
    solver::{
        Bending, ClothSolver, Collider, DampingForm, Isa, MassLumping, Material, PinMotion, Pose,
        Settings, StepInput, StretchMethod,
    },
};

use crate::support::solver::*;

/// A wavy floor that only its author knows.
#[derive(Debug)]
struct Waves;

impl SignedDistance for Waves {
    fn sample(&self, point: Vec3) -> SdfSample {
        let slope = 0.1 * point.x;
        let normal = Vec3::new(-slope, 1.0, 0.0).normalize();
        SdfSample { distance: (point.y + 0.6 - 0.05 * point.x * point.x) * normal.y, normal }
    }

    fn bounds(&self) -> Option<Aabb3d> {
        None
    }

    fn overestimate(&self) -> f32 {
        0.1
    }
}

/// 37 x 53 particles, so that rows and columns end within a block; everything on.
fn busy(settings: Settings, damping_form: DampingForm) -> ClothSolver {
    let lattice = sheet(Vec2::new(1.3, 0.9), 37, 53, settings.lumping);
    let material = Material {
        thread_stiffness: 300.0,
        shear_stiffness: 20.0,
        flexural_rigidity: 1e-5,
        damping: 0.002,
        damping_form,
        drag: 0.3,
        max_strain: 0.02,
        friction: 0.4,
        ..plain()
    };
    let mut solver = at_rest(&lattice, Vec3::new(0.01, 0.3, 0.02), material, settings);
    // Six groups: more than there are tethers for a particle.
    solver.set_pins(&[0, 1, 52, 1000, 37 * 53 - 1, 36 * 53, 700, 53]).unwrap();
    solver
}

fn surroundings(tick: i32) -> [(Pose, Pose); 2] {
    let at = |tick: i32| Pose {
        translation: Vec3::new(0.2 * tick as f32 * TICK, 0.0, 0.1),
        rotation: Quat::from_rotation_z(0.05 * tick as f32),
        scale: 1.0 + 0.001 * tick as f32,
    };
    [(at(tick), at(tick + 1)), (Pose::IDENTITY, Pose::IDENTITY)]
}

/// Runs the busy scene, whole ticks or by stages; the bits after each tick.
fn bits_of(mut solver: ClothSolver, staged: bool) -> Vec<Vec<[u32; 6]>> {
    let ball = Sphere::new(0.2);
    let home: Vec<_> = solver.pins().iter().map(|&p| solver.position(p as usize)).collect();
    let mut out = Vec::new();
    for tick in 0..24 {
        let [(s0, e0), (s1, e1)] = surroundings(tick);
        let colliders = [
            Collider::new(&ball, s0).moving_to(e0),
            Collider::new(&Waves, s1).moving_to(e1).with_friction(0.2),
        ];
        let at = |tick: i32, p: Vec3| p + Vec3::Y * 0.1 * tick as f32 * TICK;
        let pins: Vec<_> =
            home.iter().map(|&p| PinMotion { start: at(tick, p), end: at(tick + 1, p) }).collect();
        let input = StepInput {
            dt: TICK,
            gravity: GRAVITY,
            pins: &pins,
            colliders: &colliders,
            ..StepInput::default()
        };
        if staged {
            for _ in 0..solver.begin_tick(&input).unwrap() {
                solver.accumulate_forces(&input);
                solver.integrate(&input);
                solver.correct();
                solver.collide(&input);
            }
            solver.end_tick().unwrap();
        } else {
            solver.tick(&input).unwrap();
        }
        out.push(bits(&solver));
    }
    assert!(solver.strain().max > 0.0);
    out
}

fn variants() -> Vec<(Settings, DampingForm)> {
    let threads = settings(StretchMethod::ImplicitThreads, 6);
    let springs = Settings { provot_passes: 2, ..settings(StretchMethod::ExplicitSprings, 6) };
    let equal = Settings { lumping: MassLumping::Equal, bending: Bending::Flexion, ..springs };
    vec![
        (threads, DampingForm::Axial),
        (springs, DampingForm::Relative),
        (equal, DampingForm::Axial),
    ]
}

#[test]
fn the_same_run_gives_the_same_bits() {
    for (settings, damping) in variants() {
        let first = bits_of(busy(settings, damping), false);
        assert!(first == bits_of(busy(settings, damping), false), "twice: {settings:?}");
        assert!(first == bits_of(busy(settings, damping), true), "by stages: {settings:?}");
        assert!(first[0] != first[23], "nothing moved");
    }
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let available: Vec<_> = Isa::ALL.into_iter().filter(|isa| isa.is_available()).collect();
    assert!(available.contains(&Isa::detect()) && available[0] == Isa::Baseline);
    for (settings, damping) in variants() {
        let on = |isa| {
            let mut solver = busy(settings, damping);
            solver.set_isa(isa);
            bits_of(solver, false)
        };
        let baseline = on(Isa::Baseline);
        for &isa in &available[1..] {
            let wide = on(isa);
            for (tick, (a, b)) in baseline.iter().zip(&wide).enumerate() {
                if let Some(i) = (0..a.len()).find(|&i| a[i] != b[i]) {
                    panic!("{isa:?}, {settings:?}: particle {i} differs at tick {tick}");
                }
            }
        }
    }
}

#[test]
fn what_lies_beside_the_sheet_does_not_matter() {
    // Transposing a scene exchanges rows and columns, and with them which of them are padded. The
    // order of sums changes, so that only rounding may differ.
    let settings = settings(StretchMethod::ExplicitSprings, 8);
    let material = Material {
        thread_stiffness: 10.0,
        shear_stiffness: 3.0,
        flexural_rigidity: 1e-5,
        ..plain()
    };
    let run_one = |rows: usize, columns: usize, turned: bool| {
        let lattice = sheet(
            Vec2::new((columns - 1) as f32, (rows - 1) as f32) * 0.05,
            rows,
            columns,
            MassLumping::Lumped,
        );
        let start: Vec<_> = lattice
            .rest_positions()
            .iter()
            .map(|&p| {
                let (x, z) = if turned { (p.z, p.x) } else { (p.x, p.z) };
                p + Vec3::Y * (0.1 * x * x - 0.07 * z + 0.2 * x * z)
            })
            .collect();
        let mut solver = ClothSolver::new(lattice, &start, material, settings).unwrap();
        run(&mut solver, 16, Vec3::ZERO, &[]);
        positions(&solver)
    };
    let (a, b) = (run_one(15, 33, false), run_one(33, 15, true));
    let turned: Vec<_> = (0..15 * 33)
        .map(|i| {
            let p = b[(i % 33) * 15 + i / 33];
            Vec3::new(p.z, p.y, p.x)
        })
        .collect();
    check_at_most("a scene and its transpose, apart [m]", farthest(&a, &turned), 1e-5);
}
