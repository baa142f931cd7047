//! The stages of a substep, each timed by itself, in nanoseconds a particle: `cargo bench`.
//!
//! Criterion's throughput is in particles: `thrpt: 500 Melem/s` are 2 ns a particle and substep.

use std::{hint::black_box, sync::Arc, time::Duration, time::Instant};

use bevy::math::{Vec2, Vec3, primitives::Sphere};
use bevy_drape::solver::{
    ClothSolver, Collider, DampingForm, Isa, Lattice, MassLumping, Material, PinMotion, Pose,
    Settings, Stage, StepInput, StretchMethod, Substeps,
};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

const SIDES: [usize; 4] = [32, 64, 128, 256];

/// What is timed: a stage of a cloth of some material, or all of them.
struct Case {
    name: &'static str,
    stage: Option<Stage>,
    form: StretchMethod,
    material: Material,
    /// Distance of a ball's middle below the cloth's \[m\], if there is one; its radius is 0.5 m.
    ball: Option<f32>,
}

/// Soft enough for 16 substeps to carry all springs on 256 particles a side.
const SOFT: Material = Material {
    area_density: 0.2,
    thread_stiffness: 1.0,
    shear_stiffness: 0.3,
    flexural_rigidity: 0.0,
    bending_friction: 0.0,
    damping: 0.0,
    damping_form: DampingForm::Axial,
    drag: 0.0,
    max_strain: 10.0,
    friction: 0.5,
    thickness: 0.005,
};

const STIFF: Material = Material { thread_stiffness: 1000.0, shear_stiffness: 300.0, ..SOFT };

fn cases() -> Vec<Case> {
    let springs = Case {
        name: "explicit springs",
        stage: Some(Stage::Forces),
        form: StretchMethod::ExplicitSprings,
        material: SOFT,
        ball: None,
    };
    let bend = Material { flexural_rigidity: 1e-9, ..SOFT };
    let damped = Material { damping: 1e-6, ..SOFT };
    let relative = Material { damping_form: DampingForm::Relative, ..damped };
    let (form, material) = (StretchMethod::ImplicitThreads, STIFF);
    vec![
        Case {
            name: "explicit substep with bending, all stages but Provot's limit",
            stage: None,
            material: bend,
            ..springs
        },
        Case { name: "forces: springs and bending", material: bend, ..springs },
        Case { name: "forces: springs and axial damping", material: damped, ..springs },
        Case { name: "forces: springs and relative damping", material: relative, ..springs },
        Case { name: "integrate", stage: Some(Stage::Integrate), form, material, ..springs },
        Case {
            name: "correct: threads and shear",
            stage: Some(Stage::Correct),
            form,
            material,
            ..springs
        },
        Case { name: "collide: nothing", stage: Some(Stage::Collide), form, material, ..springs },
        Case {
            name: "collide: a ball out of reach",
            stage: Some(Stage::Collide),
            form,
            material,
            ball: Some(1.0),
        },
        Case {
            name: "collide: lying on a ball",
            stage: Some(Stage::Collide),
            form,
            material,
            ball: Some(0.505),
        },
        springs,
    ]
}

fn cloth(case: &Case, n: usize, isa: Isa) -> ClothSolver {
    let lattice = Arc::new(Lattice::sheet(Vec2::ONE, n, n, MassLumping::Lumped).unwrap());
    let settings = Settings {
        stretch_method: case.form,
        substeps: Substeps::Fixed(16),
        provot_passes: u32::from(case.stage.is_some()),
        ..Settings::default()
    };
    let start = lattice.rest_positions().to_vec();
    let mut cloth = ClothSolver::new(lattice, &start, case.material, settings).unwrap();
    if case.ball.is_none() {
        cloth.set_pins(&[0, n as u32 - 1]).unwrap();
    }
    cloth.set_isa(isa);
    cloth.set_shared(false);
    cloth
}

/// Time that the stage takes in so many substeps.
fn time(case: &Case, cloth: &ClothSolver, substeps: u64) -> Duration {
    let mut cloth = cloth.clone();
    let pins: Vec<_> =
        cloth.pins().iter().map(|&p| PinMotion::still(cloth.position(p as usize))).collect();
    let ball = Sphere::new(0.5);
    let place = Pose::from_translation(Vec3::NEG_Y * case.ball.unwrap_or(0.0));
    let balls = [Collider::new(&ball, place)];
    let input = StepInput {
        dt: 1.0 / 60.0,
        gravity: Vec3::NEG_Y * if case.ball == Some(1.0) { 0.0 } else { 9.81 },
        pins: &pins,
        colliders: if case.ball.is_some() { &balls } else { &[] },
        ..StepInput::default()
    };
    let mut spent = Duration::ZERO;
    let mut left = substeps;
    while left > 0 {
        let mut begun = Instant::now();
        let ticked = cloth.tick_observed(&input, |stage| {
            let now = Instant::now();
            if left > 0 && stage != Stage::Begin && case.stage.is_none_or(|timed| timed == stage) {
                spent += now - begun;
            }
            left -= u64::from(left > 0 && stage == Stage::Collide);
            begun = now;
        });
        black_box(ticked.unwrap());
    }
    spent
}

fn stages(criterion: &mut Criterion) {
    for case in cases() {
        let mut group = criterion.benchmark_group(case.name);
        for n in SIDES {
            for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
                let cloth = cloth(&case, n, isa);
                group.throughput(Throughput::Elements((n * n) as u64));
                group.bench_function(BenchmarkId::new(format!("{isa:?}"), n), |bencher| {
                    bencher.iter_custom(|substeps| time(&case, &cloth, substeps));
                });
            }
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600));
    targets = stages
}
criterion_main!(benches);
