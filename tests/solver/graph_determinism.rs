//! Bit equality of meshes: stage by stage, and on every instruction set.

use std::sync::Arc;

use bevy::math::{Quat, Vec3, primitives::Sphere};
use bevy_drape::solver::{
    Bending, ClothSolver, Collider, DampingForm, Graph, Isa, MassLumping, Material, Pose, Settings,
    StepInput, StretchMethod,
};

use crate::support::solver::*;

/// Everything on: rectangles, and other cells; curved at rest; six groups of pins.
fn busy(form: StretchMethod, bending: Bending, damping_form: DampingForm) -> ClothSolver {
    let (mut positions, triangles) = jittered(23, 31, 0.04, 0.25, 2);
    for (i, p) in positions.iter_mut().enumerate() {
        if i < 11 * 31 {
            *p = Vec3::new((i % 31) as f32 * 0.04, 0.0, (i / 31) as f32 * 0.04);
        }
        p.y = 0.1 * p.x * p.x;
    }
    let graph = Arc::new(Graph::new(&positions, &triangles, MassLumping::Lumped).unwrap());
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
    let settings = Settings { bending, ..settings(form, 7) };
    let mut solver = at_rest(&graph, Vec3::new(0.01, 0.3, 0.02), material, settings);
    solver.set_pins(&[0, 1, 30, 340, 500, 600, 31 * 23 - 1]).unwrap();
    solver
}

/// Two thirds of a second over a ball; in stages where asked.
fn fall(mut solver: ClothSolver, staged: bool) -> Vec<[u32; 6]> {
    let ball = Sphere::new(0.25);
    let pins = still(&solver);
    for tick in 0..40 {
        let at = |tick: i32| Pose {
            translation: Vec3::new(0.6 + 0.2 * tick as f32 * TICK, 0.0, 0.4),
            rotation: Quat::from_rotation_z(0.05 * tick as f32),
            scale: 1.0,
        };
        let collider = Collider::new(&ball, at(tick)).moving_to(at(tick + 1));
        let colliders = [collider];
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
    }
    bits(&solver)
}

#[test]
fn stages_and_instruction_sets_give_the_same_bits() {
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        for (bending, damping) in [
            (Bending::SecondDifference, DampingForm::Axial),
            (Bending::Flexion, DampingForm::Relative),
        ] {
            let reference = fall(busy(form, bending, damping), false);
            let what = format!("{form:?} {bending:?} {damping:?}");
            assert!(reference == fall(busy(form, bending, damping), true), "{what}, staged");
            for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
                let mut solver = busy(form, bending, damping);
                solver.set_isa(isa);
                assert!(reference == fall(solver, false), "{what}, {isa:?}");
            }
        }
    }
}
