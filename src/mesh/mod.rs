//! The rest mesh in.
//!
//! | file | what it does |
//! | --- | --- |
//! | `source` | finds a cloth's mesh asset, waits for it, makes the copy that is drawn into |
//! | `raw` | reads the asset's data: the door, where they are checked |
//! | `weld`, `surface` | vertices at one place become one; triangles without area are left out |
//! | `grid`, `intake` | the surface becomes rows and columns, or stays triangles |
//! | `rest_shape`, `factors` | the shape at rest; factors of mass and stiffness |
//! | `proxy`, `faces` | a coarse shape that is simulated in the place of the one that is drawn |
//! | `drawn` | the mesh that a cloth draws into, and what was last drawn |
//! | `skinned` | which joints of a skinned mesh move each particle |
//! | `rest_cache`, `background` | equal rest shapes are shared; those of large meshes are made in the background |

pub(crate) mod background;
pub(crate) mod drawn;
pub(crate) mod faces;
pub(crate) mod factors;
pub(crate) mod grid;
pub(crate) mod intake;
pub(crate) mod proxy;
pub(crate) mod raw;
pub(crate) mod rest_cache;
pub(crate) mod rest_shape;
pub(crate) mod skinned;
pub(crate) mod source;
pub(crate) mod surface;
pub(crate) mod weld;
