//! Weil's geometric model (1986): where a cloth is that hangs from given points, without simulating
//! how it came there. Pure geometry over a rest shape, and the relaxation that ends it.
//!
//! 1. [`hang`]: catenaries are hung between the hanging points, as long as the cloth between them. Of two
//!    that cross the higher is kept, so that they bound triangles (`triangulate`); those are split by
//!    further catenaries, from a corner to the middle of the side across, until every particle lies on
//!    one. What lies outside of all triangles hangs down from the nearest curve (`surface`).
//! 2. [`relax`]: the solver's own forces and gravity take the shape to rest.
//!
//! A curve's length is that of the straight line in the cloth at rest, spread out flat. A rest shape that
//! is not flat is flattened first (`flatten`): its ways along the cloth become distances in a plane.
//!
//! J. Weil, *The Synthesis of Cloth Objects*, SIGGRAPH 1986.

mod catenary;
mod flatten;
mod relax;
mod surface;
mod triangulate;

pub use catenary::{Catenary, CatenaryError};
pub use relax::{RelaxReport, Relaxation, relax};
pub use surface::{HangError, HangingPoint, hang};
