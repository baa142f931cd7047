//! What the solver complains of, told to the component that it is about.

use bevy::reflect::Typed;

use crate::cloth::settings::ClothSettings;
use crate::error::problems::ScaleProblem;
use crate::error::{ClothComponent, ClothErrorKind};
use crate::solver::SolverError;

/// The solver's complaint about a component.
pub(crate) fn component_error(component: ClothComponent, problem: SolverError) -> ClothErrorKind {
    match problem {
        SolverError::Parameter(problem) => ClothErrorKind::Parameter { component, problem },
        problem => solver_error(problem),
    }
}

/// A solver's complaint, told to the component that it is about.
pub(crate) fn solver_error(problem: SolverError) -> ClothErrorKind {
    match problem {
        SolverError::Parameter(problem) => {
            let settings = ClothSettings::type_info().as_struct();
            let of_settings = settings.is_ok_and(|it| it.field(problem.name).is_some());
            let component = if of_settings {
                ClothComponent::ClothSettings
            } else {
                ClothComponent::ClothMaterial
            };
            ClothErrorKind::Parameter { component, problem }
        }
        SolverError::Lattice(problem) => ClothErrorKind::Shape(problem),
        SolverError::Graph(problem) => ClothErrorKind::Graph(problem),
        problem => ClothErrorKind::Solver(problem),
    }
}

/// A shape that cannot be used at a huge or tiny scale may be good at another.
pub(crate) fn scale_at_fault(error: ClothErrorKind, scale: f32) -> ClothErrorKind {
    match error {
        ClothErrorKind::Shape(_) | ClothErrorKind::Graph(_) if !(1e-3..=1e3).contains(&scale) => {
            ClothErrorKind::Scale(ScaleProblem::OutOfRange(scale))
        }
        error => error,
    }
}
