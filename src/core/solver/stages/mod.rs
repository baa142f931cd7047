//! The stages of a substep: which kernels run, on what, in which order.
//!
//! | stage | file | beside it |
//! | --- | --- | --- |
//! | 1 | `forces` | `external`, `bending_friction` |
//! | 2 | `integrate` | `houbolt`, `explicit` |
//! | 3 | `correct` | `self_contact`, `soft_pins` |
//! | 4 | `collide` | |
//!
//! The parts of stages that differ between a sheet and a mesh are in `model`.

mod bending_friction;
mod collide;
mod correct;
mod explicit;
mod external;
mod forces;
mod houbolt;
mod integrate;
mod self_contact;
mod soft_pins;
