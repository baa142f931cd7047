//! The rest mesh in, the cloth's own mesh out.

mod draw;
mod groups;
mod intake;
mod normals;
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
