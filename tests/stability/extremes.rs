//! Materials at the ends of their ranges. Truth: bounds that the cloth's size gives, for ten seconds; twice the
//! strain limit after them, with the usual substeps; the plan's own bound.
//!
//! Numbers out of their ranges are refused: `tests/solver/refusals.rs`; ends of the ranges for 2 s on a lattice:
//! `tests/solver/survival.rs`. Shapes that cannot be hung: `tests/hang/refusals.rs`, `tests/ecs/hung.rs`.

use crate::support::{kinds::*, solver::*};
use bevy_drape::solver::{DampingForm, Material, StretchMethod, Substeps};

const N: usize = 9;

#[test]
fn h21_no_strain_no_stiffness_and_damping_beyond_its_limit() {
    let free =
        Material { thread_stiffness: 0.0, shear_stiffness: 0.0, flexural_rigidity: 0.0, ..usual() };
    let materials = [
        ("no strain", Material { max_strain: 0.0, ..usual() }),
        ("no strain, stiffest", Material { max_strain: 0.0, ..stiffest() }),
        ("no threads", Material { thread_stiffness: 0.0, ..usual() }),
        ("no springs", free),
        ("damped beyond its limit", Material { damping: 1e9, ..usual() }),
        ("nothing but damping", Material { damping: 1e9, ..free }),
        ("nothing but bending", Material { flexural_rigidity: 1e9, ..free }),
        ("lightest", Material { area_density: 1e-6, ..usual() }),
        ("lightest, stiffest", Material { area_density: 1e-6, ..stiffest() }),
        ("heaviest", Material { area_density: 1e4, ..usual() }),
        ("in honey", Material { drag: 1e6, ..usual() }),
    ];
    for kind in kinds_of(1.0, N, &materials) {
        for form in [
            StretchMethod::Automatic,
            StretchMethod::ExplicitSprings,
            StretchMethod::ImplicitThreads,
        ] {
            for damping_form in [DampingForm::Axial, DampingForm::Relative] {
                for substeps in [Substeps::default(), Substeps::Fixed(1)] {
                    let mut kind = kind.clone().with_form(form);
                    kind.material.damping_form = damping_form;
                    kind.settings.substeps = substeps;
                    let what = format!("{}, {damping_form:?}, {substeps:?}", kind.what);
                    let mut solver = kind.hanging();
                    solver.set_pins(&[0, N as u32 - 1]).unwrap();
                    let plan = *solver.plan();
                    assert!(plan.margin >= 0.0 && plan.margin <= 0.9001, "{what}: {plan}");
                    steps(&mut solver, &what, TEN_SECONDS, Within::cube(2.5), GRAVITY, &[]);
                    // Without threads the limit alone holds it, one pass a substep.
                    if substeps == Substeps::default() && kind.material.thread_stiffness > 0.0 {
                        let strain = strain(&solver);
                        check_at_most(&format!("{what}: strain"), strain, 0.2);
                    }
                }
            }
        }
    }
}
