//! The rest mesh in, the cloth's own mesh out.
//!
//! | file | what it does |
//! | --- | --- |
//! | `rest` | finds a cloth's mesh asset, waits for it, makes the copy that is drawn into |
//! | `raw` | reads the asset's data: the door, where they are checked |
//! | `weld`, `surface` | vertices at one place become one, what is no triangle is left out |
//! | `intake` | the surface becomes rows and columns, or stays triangles |
//! | `draw` | writes positions, normals and tangents, once a frame: what `bevy_drape_core::surface` makes of them |

mod draw;
mod intake;
mod raw;
mod rest;
mod surface;
mod weld;

pub use intake::ClothIntake;
pub use rest::MeshProblem;
pub use surface::SkippedTriangles;

pub(crate) use draw::{ClothMesh, draw_cloths};
pub(crate) use intake::{Connection, MeshShape};
pub(crate) use rest::{MeshSource, RestShape, source_of};
