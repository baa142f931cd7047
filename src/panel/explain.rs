//! The choices of the solver and their reasons, in words.

use crate::cloth::material::ClothMaterial;
use crate::solver::{Plan, PlanReason, Stretching};

/// The meaning of a plan, a sentence a line: the form and its reason, the substeps, how near it is to the limit of
/// stability, and which constants are lower than the material asks for.
pub fn explain(plan: &Plan, material: &ClothMaterial) -> Vec<String> {
    let form = match plan.stretching {
        Stretching::ExplicitSprings => "Explicit springs",
        Stretching::ImplicitThreads => "Whole threads",
    };
    let reason = match plan.reason {
        PlanReason::Asked => "as set".to_owned(),
        PlanReason::SpringsSuffice => "they carry this stiffness within the budget".to_owned(),
        PlanReason::SpringsNeed(count) => format!("springs would need {count} substeps"),
        PlanReason::SpringsGive => "springs would stretch beyond the strain limit".to_owned(),
    };
    let mut lines = vec![
        format!("{form}: {reason}."),
        format!("{} substeps of {:.3} ms.", plan.substeps, 1e3 * plan.step),
        format!("Stability: {} % of the limit (90 % at most).", short(100.0 * plan.margin)),
    ];
    if plan.layers > 0 {
        lines.push(format!("Layers of cloth ask for {} substeps or more.", plan.layers));
    }
    if plan.bodies > 0 {
        lines.push(format!("Bodies that strike it ask for {} substeps.", plan.bodies));
    }
    let clamped = [
        (
            "Thread stiffness",
            plan.clamped.thread,
            material.thread_stiffness,
            plan.thread_stiffness,
            "N/m",
        ),
        (
            "Shear stiffness",
            plan.clamped.shear,
            material.shear_stiffness,
            plan.shear_stiffness,
            "N/m",
        ),
        (
            "Rigidity",
            plan.clamped.bending,
            material.flexural_rigidity,
            plan.flexural_rigidity,
            "N m",
        ),
        ("Damping", plan.clamped.damping, material.damping, plan.damping, "N s/m"),
    ];
    for (name, _, asked, used, unit) in clamped.into_iter().filter(|(_, clamped, ..)| *clamped) {
        let (asked, used) = (short(asked), short(used));
        lines.push(format!("{name} {used} in place of {asked} {unit}: more substeps carry more."));
    }
    lines
}

/// Three figures.
pub(super) fn short(value: f32) -> String {
    let size = value.abs();
    match size {
        0.0 => "0".into(),
        _ if !(1e-2..1e5).contains(&size) => format!("{value:.2e}"),
        _ if size < 1.0 => format!("{value:.3}"),
        _ if size < 100.0 => format!("{value:.1}"),
        _ => format!("{value:.0}"),
    }
}
