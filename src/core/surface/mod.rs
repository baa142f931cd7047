//! The drawn surface of a cloth: where its particles are in some frame, and the normals and tangents of the surface
//! between them; and a finer surface that it carries. Pure geometry over slices, once a frame; no mesh asset.

mod binding;
mod groups;
mod nearest;
mod normals;
mod points;
mod skinning;
mod tangents;

pub use binding::{Binding, Bond};
pub use groups::{GroupSums, NormalGroups};
pub use normals::GridNormals;
pub use points::{Placing, bounds, has_moved};
pub use skinning::{Influences, skin, skin_with_normals};
pub use tangents::Tangents;
