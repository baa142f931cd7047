//! What a solver does in each stage of a substep: which kernels run, on what, in which order.
//!
//! | stage | file | beside it |
//! | --- | --- | --- |
//! | 1 | `forces` | `external`, `bending_friction` |
//! | 2 | `integrate` | `houbolt`, `explicit` |
//! | 3 | `correct` | `soft_pins` |
//! | 4 | `collide` | |
//!
//! The stages of a triangle mesh that differ from those of a sheet are in `mesh`.

mod bending_friction;
mod collide;
mod correct;
mod explicit;
mod external;
mod forces;
mod houbolt;
mod integrate;
pub(crate) mod mesh;
mod soft_pins;
