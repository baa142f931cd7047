//! Bad input is refused by name, and nothing has changed when it is.

use bevy::math::{Quat, Vec2, Vec3, primitives::Sphere};
use bevy_drape::solver::{
    ClothSolver, Collider, Lattice, LatticeError, MassLumping, Material, PinMotion, Pose, Settings,
    SolverError, StepInput, StretchMethod, Substeps,
};

use crate::support::solver::*;

const NAN: Vec3 = Vec3::new(0.0, f32::NAN, 0.0);

fn solver() -> ClothSolver {
    let lattice = sheet(Vec2::ONE, 4, 5, MassLumping::Lumped);
    let mut solver =
        at_rest(&lattice, Vec3::ZERO, plain(), settings(StretchMethod::ImplicitThreads, 4));
    solver.set_pins(&[0, 4]).unwrap();
    run(&mut solver, 3, GRAVITY, &[]);
    solver
}

/// Does it to a solver, and looks whether anything of it changed.
fn refused(
    what: &str,
    act: impl FnOnce(&mut ClothSolver) -> Result<(), SolverError>,
) -> SolverError {
    let mut solver = solver();
    let before = format!("{solver:?}");
    let error = act(&mut solver).expect_err(what);
    assert!(format!("{solver:?}") == before, "{what}: {error} left a change");
    assert!(!error.to_string().is_empty());
    error
}

#[test]
fn every_number_of_the_material_has_a_range() {
    type Set = fn(&mut Material, f32);
    let fields: [(&str, Set, &[f32]); 9] = [
        ("area_density", |m, v| m.area_density = v, &[0.0, -1.0, 1e5]),
        ("thread_stiffness", |m, v| m.thread_stiffness = v, &[-1.0, 1e16]),
        ("shear_stiffness", |m, v| m.shear_stiffness = v, &[-1.0, 1e16]),
        ("flexural_rigidity", |m, v| m.flexural_rigidity = v, &[-1.0, 1e10]),
        ("damping", |m, v| m.damping = v, &[-1.0, 1e10]),
        ("drag", |m, v| m.drag = v, &[-1.0, 1e7]),
        ("max_strain", |m, v| m.max_strain = v, &[-0.1, 11.0]),
        ("friction", |m, v| m.friction = v, &[-0.1, 1e4]),
        ("thickness", |m, v| m.thickness = v, &[-0.1, 11.0]),
    ];
    for (name, set, values) in fields {
        for &value in values.iter().chain(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY]) {
            let mut material = plain();
            set(&mut material, value);
            match refused(name, |s| s.set_material(material)) {
                SolverError::Parameter(error) => assert_eq!(error.name, name),
                other => panic!("{name} = {value}: {other}"),
            }
            let lattice = sheet(Vec2::ONE, 3, 3, MassLumping::Lumped);
            let made = ClothSolver::new(
                lattice.clone(),
                lattice.rest_positions(),
                material,
                Settings::default(),
            );
            assert!(matches!(made, Err(SolverError::Parameter(_))), "{name} = {value}");
        }
    }
}

#[test]
fn every_number_of_the_settings_has_a_range() {
    let base = settings(StretchMethod::ImplicitThreads, 4);
    for (name, bad) in [
        ("substeps", Settings { substeps: Substeps::Fixed(0), ..base }),
        ("substeps", Settings { substeps: Substeps::Fixed(5000), ..base }),
        ("substeps", Settings { substeps: Substeps::Automatic { budget: 0 }, ..base }),
        ("provot_passes", Settings { provot_passes: 1001, ..base }),
        ("max_speed", Settings { max_speed: 0.0, ..base }),
        ("max_speed", Settings { max_speed: f32::NAN, ..base }),
        ("max_speed", Settings { max_speed: f32::INFINITY, ..base }),
        ("max_depenetration_speed", Settings { max_depenetration_speed: 0.0, ..base }),
        ("max_depenetration_speed", Settings { max_depenetration_speed: f32::NAN, ..base }),
    ] {
        match refused(name, |s| s.set_settings(bad)) {
            SolverError::Parameter(error) => assert_eq!(error.name, name),
            other => panic!("{name}: {other}"),
        }
    }
    let equal = Settings { lumping: MassLumping::Equal, ..base };
    let error = refused("lumping", |s| s.set_settings(equal));
    assert_eq!(
        error,
        SolverError::OtherLumping { made: MassLumping::Lumped, asked: MassLumping::Equal }
    );
}

#[test]
fn particles_that_are_not_there_or_nowhere_are_refused() {
    let missing = SolverError::NoSuchParticle { particle: 20, count: 20 };
    assert_eq!(refused("pin", |s| s.set_pins(&[3, 20])), missing);
    assert_eq!(refused("position", |s| s.set_position(20, Vec3::ZERO)), missing);
    assert_eq!(refused("velocity", |s| s.set_velocity(20, Vec3::ZERO)), missing);
    for bad in [NAN, Vec3::X * f32::INFINITY, Vec3::Z * -2e7] {
        let error = refused("position", |s| s.set_position(7, bad));
        assert_eq!(error, SolverError::NonFinite { what: "position", particle: 7 });
        let error = refused("velocity", |s| s.set_velocity(7, bad));
        assert_eq!(error, SolverError::NonFinite { what: "velocity", particle: 7 });
        let lattice = sheet(Vec2::ONE, 2, 2, MassLumping::Lumped);
        let start = [Vec3::ZERO, Vec3::X, bad, Vec3::ONE];
        let made = ClothSolver::new(lattice, &start, plain(), Settings::default());
        assert_eq!(made.err(), Some(SolverError::NonFinite { what: "position", particle: 2 }));
    }
    let lattice = sheet(Vec2::ONE, 2, 2, MassLumping::Lumped);
    let made = ClothSolver::new(lattice, &[Vec3::ZERO; 3], plain(), Settings::default());
    assert_eq!(made.err(), Some(SolverError::WrongPositionCount { expected: 4, got: 3 }));
}

#[test]
fn a_rest_shape_of_other_particles_is_refused() {
    let solver = solver();
    let remade = |[rows, columns]: [usize; 2], lumping| {
        let lattice = sheet(Vec2::ONE, rows, columns, lumping);
        let settings = Settings { lumping, ..Settings::default() };
        solver.remade(lattice.into(), settings).map(|remade| positions(&remade))
    };
    // As many particles in other rows, and another number of them.
    for other in [[5, 4], [2, 10], [4, 6], [3, 5]] {
        assert_eq!(remade(other, MassLumping::Lumped).err(), Some(SolverError::OtherParticles));
    }
    assert_eq!(remade([4, 5], MassLumping::Equal), Ok(positions(&solver)));
}

#[test]
fn a_tick_with_bad_input_does_not_begin() {
    let pins = [PinMotion::still(Vec3::ZERO), PinMotion::still(Vec3::X)];
    let good = StepInput {
        dt: TICK,
        gravity: GRAVITY,
        pins: &pins,
        colliders: &[],
        ..StepInput::default()
    };
    for dt in [0.0, -TICK, 1.5, f32::NAN, f32::INFINITY] {
        let error = refused("dt", |s| s.tick(&StepInput { dt, ..good }).map(drop));
        assert!(matches!(error, SolverError::Tick(_)), "{error}");
        let error = refused("plan", |s| s.plan_for(dt).map(drop));
        assert!(matches!(error, SolverError::Tick(_)), "{error}");
    }
    for gravity in [NAN, Vec3::X * f32::INFINITY, Vec3::Y * 2e6] {
        let error = refused("gravity", |s| s.tick(&StepInput { gravity, ..good }).map(drop));
        assert_eq!(error, SolverError::Gravity);
    }
    for braking in [-1.0, f32::NAN, f32::INFINITY] {
        let error = refused("braking", |s| s.tick(&StepInput { braking, ..good }).map(drop));
        assert!(matches!(error, SolverError::Parameter(_)), "{error}");
    }
    for motions in [0, 1] {
        let input = StepInput { pins: &pins[..motions], ..good };
        let error = refused("pins", |s| s.begin_tick(&input).map(drop));
        assert_eq!(error, SolverError::WrongPinCount { pins: 2, motions });
    }
    for bad in [NAN, Vec3::X * f32::NEG_INFINITY, Vec3::X * 2e7] {
        for motion in
            [PinMotion { start: bad, end: Vec3::ZERO }, PinMotion { start: Vec3::ZERO, end: bad }]
        {
            let pins = [pins[0], motion];
            let error = refused("pin", |s| s.tick(&StepInput { pins: &pins, ..good }).map(drop));
            assert_eq!(error, SolverError::PinTarget(1));
        }
    }
}

#[test]
fn bad_colliders_are_refused_by_number() {
    let ball = Sphere::new(1.0);
    let far = Pose::from_translation(Vec3::X * 100.0);
    let fine = Collider::new(&ball, far);
    let with = |start: Pose, end: Pose, friction: f32| {
        Collider::new(&ball, start).moving_to(end).with_friction(friction)
    };
    let pins = [PinMotion::still(Vec3::ZERO), PinMotion::still(Vec3::X)];
    let scaled = |scale| Pose { scale, ..far };
    let turned = |rotation| Pose { rotation, ..far };
    for bad in [
        with(Pose::from_translation(NAN), far, 0.5),
        with(far, Pose::from_translation(NAN), 0.5),
        with(scaled(0.0), far, 0.5),
        with(far, scaled(-1.0), 0.5),
        with(scaled(f32::NAN), far, 0.5),
        with(scaled(f32::INFINITY), far, 0.5),
        with(turned(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)), far, 0.5),
        with(far, turned(Quat::from_xyzw(0.0, 0.0, 0.0, 2.0)), 0.5),
        with(far, turned(Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)), 0.5),
        with(far, far, -0.1),
        with(far, far, f32::NAN),
        with(far, far, f32::INFINITY),
    ] {
        let colliders = [fine, bad];
        let input = StepInput {
            dt: TICK,
            gravity: GRAVITY,
            pins: &pins,
            colliders: &colliders,
            ..StepInput::default()
        };
        assert_eq!(refused("collider", |s| s.tick(&input).map(drop)), SolverError::Collider(1));
    }
}

#[test]
fn what_is_no_lattice_is_refused() {
    let grid: Vec<_> = (0..6).map(|i| Vec3::new((i % 3) as f32, 0.0, (i / 3) as f32)).collect();
    let make = |rows, columns, positions: &[Vec3]| {
        Lattice::new(rows, columns, positions, MassLumping::Lumped)
    };
    assert!(make(2, 3, &grid).is_ok());
    assert_eq!(make(1, 6, &grid), Err(LatticeError::TooSmall { rows: 1, columns: 6 }));
    assert_eq!(
        make(2, 2, &grid),
        Err(LatticeError::WrongLength { rows: 2, columns: 2, positions: 6 })
    );
    assert!(matches!(make(1 << 13, 1 << 13, &grid), Err(LatticeError::TooLarge { .. })));
    assert!(matches!(make(usize::MAX, 2, &grid), Err(LatticeError::TooLarge { .. })));
    for bad in [NAN, Vec3::X * f32::INFINITY, Vec3::Y * 2e6] {
        let mut grid = grid.clone();
        grid[4] = bad;
        assert_eq!(make(2, 3, &grid), Err(LatticeError::NonFinite { particle: 4 }));
    }
    let mut grid = grid;
    grid[4] = grid[5];
    assert_eq!(make(2, 3, &grid), Err(LatticeError::Coincident { first: 4, second: 5 }));
    for size in [Vec2::new(0.0, 1.0), Vec2::new(1.0, f32::NAN), Vec2::new(f32::INFINITY, 1.0)] {
        assert!(Lattice::sheet(size, 3, 3, MassLumping::Lumped).is_err(), "{size}");
    }
    assert!(Lattice::sheet(Vec2::ONE, usize::MAX, usize::MAX, MassLumping::Lumped).is_err());
    // A negative size is a mirrored sheet at best.
    assert!(
        SolverError::from(LatticeError::TooSmall { rows: 1, columns: 6 })
            .to_string()
            .contains("2 x 2")
    );
}

#[test]
fn a_cloth_that_leaves_the_world_is_put_back_at_rest() {
    let lattice = sheet(Vec2::ONE, 3, 3, MassLumping::Lumped);
    let settings = Settings { max_speed: 1e5, ..settings(StretchMethod::ImplicitThreads, 1) };
    let mut solver = at_rest(&lattice, Vec3::X * 9.99e6, plain(), settings);
    for i in 0..9 {
        solver.set_velocity(i, Vec3::X * 1e5).unwrap();
    }
    let before = positions(&solver);
    let input = StepInput {
        dt: 1.0,
        gravity: Vec3::ZERO,
        pins: &[],
        colliders: &[],
        ..StepInput::default()
    };
    assert_eq!(solver.tick(&input), Err(SolverError::Diverged));
    assert_eq!(positions(&solver), before);
    assert_eq!(fastest(&solver), 0.0);
    assert!(solver.tick(&input).is_ok(), "it goes on");
}
