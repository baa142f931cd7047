//! Signed distances, held to truths that know nothing of the code.
//!
//! - Shapes: points made by parametrising their surfaces, with their normals; the least distance to a cloud
//!   of such points; inside and outside by the shape's inequality; central differences for the normal.
//! - Swollen solids and compounds: the definition in `f64` over all parts.
//! - Ground: the least distance in `f64` to all triangles, walls and the floor.
//! - Surfaces with a thickness: the least distance in `f64` to all triangles, less the radius.
//! - Saved fields: bit equality, and a checksum written out by its definition.
//! - Blocks: the single point's bits.
//! - Segments: the least of the distances at a thousand of their places.
//! - Fitted capsules: a capsule is its own best capsule.
//! - Baked fields: a table of the errors that exact samples make (`data/sdf_error.csv`), analytic
//!   distances in `f64`, and on the bunny the least distance to all triangles and the winding number.

mod baking;
mod fields;
mod fit;
mod ground;
mod meshes;
mod saved;
mod segments;
mod shapes;
mod shells;
mod solids;
// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "../support/mod.rs"]
mod support;
