//! The plugin in an app: headless, with assets, meshes and transforms, nothing drawn on a screen.
//!
//! Truths: bit equality between forms, frame rates and pool sizes; exact places of pins; counted asset
//! events; sampled points for contact; and that what is refused is told to its own entity alone.

mod anchors;
mod app;
mod bad_colliders;
mod bad_input;
mod bodies;
mod body;
mod colliders;
mod copies;
mod culling;
mod diagnostics;
mod events;
mod execution;
mod fabrics;
mod fields;
mod frames;
mod grab;
mod hung;
mod intake;
mod inter_collision;
mod lod;
mod mesh;
mod pins;
mod proxy;
mod push;
mod quality;
mod refusals;
mod scale;
mod seams;
mod self_collision;
mod setup;
mod shapes;
mod skin;
mod sleep;
mod state;
// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "../support/mod.rs"]
mod support;
mod teleport;
mod told;
mod wind;
