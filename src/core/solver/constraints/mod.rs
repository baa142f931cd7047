//! Constraints, which correct displacements: threads, shear, the strain limit, tethers, pins, skin.

pub(crate) mod graph_strain_limit;
pub(crate) mod pin_motion;
pub(crate) mod pins;
pub(crate) mod shear;
pub(crate) mod skin;
pub(crate) mod soft_pins;
pub(crate) mod strain_check;
pub(crate) mod strain_limit;
pub(crate) mod tethers;
pub(crate) mod threads;
mod weft;
