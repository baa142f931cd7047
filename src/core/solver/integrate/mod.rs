//! Time integration: Verlet's method, and what carries corrections from one substep to the next.

pub(crate) mod explicit;
pub(crate) mod houbolt;
pub(crate) mod verlet;
