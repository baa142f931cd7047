//! Forces on particles: explicit springs, bending, damping, loads from outside, air.

pub(crate) mod aerodynamics;
pub(crate) mod bending;
pub(crate) mod bending_friction;
pub(crate) mod damping;
pub(crate) mod external;
pub(crate) mod families;
pub(crate) mod graph_bending;
pub(crate) mod graph_bending_friction;
pub(crate) mod graph_springs;
pub(crate) mod spring_rows;
pub(crate) mod springs;
pub(crate) mod wind;
