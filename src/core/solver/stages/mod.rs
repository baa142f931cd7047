//! The stages of a substep: which kernels run, on what, in which order.
//!
//! | stage | file | beside it |
//! | --- | --- | --- |
//! | 1 | `forces` | `external`, `bending_friction` |
//! | 2 | `integrate` | `houbolt`, `explicit` |
//! | 3 | `correct` | `carrying`, `cloth_contact`, `skin`, `soft_pins`, `pulling` |
//! | 4 | `collide` | `worn` |
//!
//! The parts of stages that differ between a sheet and a mesh are in `model`.

mod bending_friction;
mod carrying;
mod cloth_contact;
mod collide;
mod correct;
mod explicit;
mod external;
mod forces;
mod houbolt;
mod integrate;
pub(super) mod pulling;
mod skin;
mod soft_pins;
mod striking;
mod worn;
