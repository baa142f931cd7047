//! What a pass over the threads leaves too long is made up for over time: sheets and irregular meshes at rest are as long with few
//! substeps as with many, and do not contract when they are let go.

use bevy::math::{Vec2, Vec3, primitives::Sphere};
use bevy_drape::solver::{
    Air, ClothSolver, Collider, MassLumping, Material, Pose, SolverState, StretchMethod,
    Stretching, Topology,
};

use crate::support::solver::*;

const N: usize = 32;

/// Which kind of cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Sheet,
    Mesh,
}

const KINDS: [Kind; 2] = [Kind::Sheet, Kind::Mesh];

/// A square metre of the usual cloth by two corners, let go flat.
fn by_two_corners(kind: Kind, n: usize, substeps: u32, material: Material) -> ClothSolver {
    let topology: Topology = match kind {
        Kind::Sheet => sheet(Vec2::ONE, n, n, MassLumping::Lumped).into(),
        Kind::Mesh => mesh(n, n, 1.0 / (n - 1) as f32, 0.3).into(),
    };
    let settings = settings(StretchMethod::ImplicitThreads, substeps);
    let mut solver = at_rest(&topology, Vec3::ZERO, material, settings);
    solver.set_pins(&[0, n as u32 - 1]).unwrap();
    solver
}

/// Strain of which one spring in a hundred has more, or where `least`, less.
fn percentile(solver: &ClothSolver, least: bool) -> f64 {
    let mut strains = thread_strains(solver);
    strains.sort_by(f64::total_cmp);
    let hundredth = strains.len() / 100;
    if least { strains[hundredth] } else { strains[strains.len() - 1 - hundredth] }
}

#[test]
fn few_substeps_hang_as_many_do() {
    let hung = |kind, substeps| {
        let mut solver = by_two_corners(kind, N, substeps, usual());
        run(&mut solver, 12 * 64, GRAVITY, &[]);
        // Folds differ, how low the cloth hangs does not.
        let row = &positions(&solver)[N * (N - 1)..];
        let height = row.iter().map(|p| f64::from(p.y)).sum::<f64>() / N as f64;
        (height, percentile(&solver, false))
    };
    // Without shifts a mesh is 2 mm lower with 20.
    for (kind, bounds) in [
        (Kind::Sheet, [(20, 2e-4, 0.007), (8, 1e-3, 0.008)]),
        (Kind::Mesh, [(20, 6e-4, 0.006), (8, 1.5e-3, 0.012)]),
    ] {
        let (truth, _) = hung(kind, 100);
        for (substeps, off, strain) in bounds {
            let (height, p99) = hung(kind, substeps);
            let what = format!("{kind:?}, {substeps} substeps");
            check(&format!("{what}: height of the hem [m]"), height, truth, off);
            check_at_most(&format!("{what}: p99 strain"), p99, strain);
        }
    }
}

/// Truth: with 200 substeps both come to 0.4 %.
#[test]
fn fine_cloths_hang_within_their_strain() {
    for (kind, bounds) in
        [(Kind::Sheet, [(20, 0.0045), (8, 0.005)]), (Kind::Mesh, [(20, 0.008), (8, 0.02)])]
    {
        for (substeps, most) in bounds {
            let mut solver = by_two_corners(kind, 64, substeps, usual());
            run(&mut solver, 15 * 64, GRAVITY, &[]);
            let strain = percentile(&solver, false);
            check_at_most(&format!("{kind:?}, {substeps} substeps: p99 strain"), strain, most);
        }
    }
}

#[test]
fn a_cloth_that_is_let_go_does_not_contract() {
    for (kind, most) in [(Kind::Sheet, 0.004), (Kind::Mesh, 0.012)] {
        let mut solver = by_two_corners(kind, N, 8, usual());
        run(&mut solver, 8 * 64, GRAVITY, &[]);
        solver.set_pins(&[]).unwrap();
        run(&mut solver, 24, GRAVITY, &[]);
        // Shifts that went as slowly as they came would leave 2.8 % of a mesh here.
        let contracts = -percentile(&solver, true);
        check_at_most(&format!("{kind:?}: shortest percent, 0.4 s later"), contracts, most);
    }
}

/// Shifts follow a load late, which gives energy. Without drag there are none; else drag or air takes more.
#[test]
fn a_cloth_gains_no_energy() {
    let in_air = Some(Air::default());
    let cases = [(0.0, None), (0.1, None), (1.0, None), (0.0, in_air)];
    let of_kind = |kind| cases.into_iter().map(move |(drag, air)| (kind, drag, air));
    for (kind, drag, air) in KINDS.into_iter().flat_map(of_kind) {
        for substeps in [8, 20] {
            let material = Material { drag, bending_friction: 0.0, ..usual() };
            let mut solver = by_two_corners(kind, 24, substeps, material);
            solver.set_air(air).unwrap();
            let energy = |solver: &ClothSolver| {
                let of = |particle: usize| {
                    let (v, height) = (solver.velocity(particle), solver.position(particle).y);
                    f64::from(solver.mass(particle) * (0.5 * v.length_squared() + 9.81 * height))
                };
                (0..24 * 24).map(of).sum::<f64>()
            };
            let mut before = energy(&solver);
            for second in 0..12 {
                run(&mut solver, 64, GRAVITY, &[]);
                let now = energy(&solver);
                let what = format!(
                    "{kind:?}, drag {drag}, {substeps} substeps, second {second}: gain [J]"
                );
                check_at_most(&what, now - before, 5e-3);
                before = now;
            }
        }
    }
}

#[test]
fn a_mesh_at_rest_on_a_ball_is_as_long_as_its_tensions_say() {
    let topology = Topology::from(mesh(48, 48, 1.6 / 47.0, 0.3));
    let lying = |substeps| {
        let settings = settings(StretchMethod::ImplicitThreads, substeps);
        let mut solver = at_rest(&topology, Vec3::new(-0.8, 0.56, -0.8), usual(), settings);
        let ball = Sphere::new(0.5);
        run(&mut solver, 12 * 64, GRAVITY, &[Collider::new(&ball, Pose::IDENTITY)]);
        percentile(&solver, false)
    };
    check_at_most("p99 strain, 8 substeps", lying(8), 0.012);
    check_at_most("p99 strain, 20 substeps", lying(20), 0.009);
}

/// A state that is saved in mid-motion has the shifts. A cloth that is placed anew has none.
#[test]
fn shifts_are_saved() {
    for kind in KINDS {
        let mut solver = by_two_corners(kind, N, 8, usual());
        run(&mut solver, 200, GRAVITY, &[]);
        let saved: SolverState = solver.save();
        assert!(shifts(&saved) > 0);
        let mut other = by_two_corners(kind, N, 8, usual());
        other.restore(&saved).unwrap();
        for solver in [&mut solver, &mut other] {
            run(solver, 100, GRAVITY, &[]);
        }
        assert_eq!(bits(&solver), bits(&other), "{kind:?}");
        let rest: Vec<_> = solver.topology().rest_positions().to_vec();
        let mut new = by_two_corners(kind, N, 8, usual());
        for solver in [&mut solver, &mut new] {
            solver.place(&rest).unwrap();
            run(solver, 100, GRAVITY, &[]);
        }
        assert_eq!(farthest(&positions(&solver), &positions(&new)), 0.0, "{kind:?}");
    }
}

/// Shifts of threads are not used after the cloth has been stretched by explicit springs.
#[test]
fn explicit_springs_take_shifts_away() {
    for kind in KINDS {
        let mut solver = by_two_corners(kind, N, 8, usual());
        run(&mut solver, 200, GRAVITY, &[]);
        let shifted = solver.save();
        let threads = *solver.settings();
        let explicit = settings(StretchMethod::ExplicitSprings, 40);
        solver.set_settings(explicit).unwrap();
        run(&mut solver, 1, GRAVITY, &[]);
        assert_eq!(solver.plan().stretching, Stretching::ExplicitSprings);
        solver.set_settings(threads).unwrap();
        let saved = solver.save();
        assert!(shifts(&shifted) > 0 && shifts(&saved) == 0, "{kind:?}");
    }
}

/// How many numbers of a saved state are shifts.
fn shifts(state: &SolverState) -> usize {
    let text = format!("{state:?}");
    let (_, from) = text.split_once("shifts: [").unwrap();
    from.split_once(']').unwrap().0.split_terminator(',').count()
}

#[test]
fn shifts_outlive_another_mass_but_no_reset() {
    for kind in KINDS {
        let mut solver = by_two_corners(kind, N, 8, usual());
        run(&mut solver, 200, GRAVITY, &[]);
        let count = shifts(&solver.save());
        assert!(count > 0, "{kind:?}");
        let other = solver.remade(solver.topology().clone(), *solver.settings()).unwrap();
        assert_eq!(shifts(&other.save()), count, "{kind:?}");
        solver.reset(&Pose::IDENTITY).unwrap();
        assert_eq!(shifts(&solver.save()), 0, "{kind:?}");
    }
}
