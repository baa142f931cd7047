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
//! In a game, the plugin's [`HangOnStart`](https://docs.rs/bevy_drape/latest/bevy_drape/struct.HangOnStart.html) does both.
//! To a solver of one's own (with the plugin, these are `bevy_drape::hang`, `bevy_drape::solver` and `bevy::math`):
//!
//! ```
//! use bevy_math::{Vec2, Vec3};
//! use bevy_drape_core::{
//!     hang::{HangingPoint, Relaxation, hang, relax},
//!     solver::{
//!         ClothSolver, Lattice, MassLumping, Material, PinMotion, Settings, StepInput, Topology,
//!     },
//! };
//! use std::sync::Arc;
//!
//! // A metre of cloth, from two corners that are 0.8 m apart.
//! let sheet = Lattice::sheet(Vec2::ONE, 9, 9, MassLumping::Lumped)?;
//! let topology = Topology::from(Arc::new(sheet));
//! let gravity = Vec3::NEG_Y * 9.81;
//! let corners = [(0, Vec3::ZERO), (8, Vec3::X * 0.8)];
//! let points = corners.map(|(particle, place)| HangingPoint { particle, place });
//! let material = Material::default();
//! let places = hang(&topology, topology.rest_positions(), &points, material.max_strain, gravity)?;
//! let mut cloth = ClothSolver::new(topology, &places, material, Settings::default())?;
//! cloth.set_pins(&corners.map(|(particle, _)| particle))?;
//! let pins = corners.map(|(_, place)| PinMotion::still(place));
//! let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..Default::default() };
//! let report = relax(&mut cloth, &input, Relaxation::default())?;
//! assert!(report.at_rest);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! J. Weil, *The Synthesis of Cloth Objects*, SIGGRAPH 1986.

mod catenary;
mod flatten;
mod points;
mod relax;
mod surface;
mod triangulate;

pub use catenary::{Catenary, CatenaryError};
pub use points::{HangError, HangingPoint};
pub use relax::{RelaxReport, Relaxation, relax};
pub use surface::hang;
