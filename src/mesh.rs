//! The rest mesh in, the cloth's own mesh out.

mod draw;
mod normals;
mod rest;

pub use rest::MeshProblem;

pub(crate) use draw::{ClothMesh, draw_cloths};
pub(crate) use rest::{MeshSource, RestShape, source_of};
