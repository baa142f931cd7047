//! A guide, to be read. There is no code in it but its snippets, and those compile.
//!
//! - [`coat`]: from nothing to a coat on a character, step by step.
//! - [`settings`]: from what is seen to what to change.
//! - [`names`]: what things are called here, for those who come from Unity, Unreal, Obi or `bevy_silk`.
//! - [`tasks`]: what a cloth can do, and by which component.
//! - [`physics`]: cloths and the rigid bodies of Avian, of Rapier, or of a game's own.
//! - [`how_it_works`]: a page of equations, with their sources.
//! - [`accuracy`]: what the solver is held to, and what it gives up.
//! - [`limits`]: what it cannot do, and where it is less than exact.
//! - [`performance`]: what a tick and each optional part cost.

#[doc = include_str!("coat.md")]
pub mod coat {}

#[doc = include_str!("settings.md")]
pub mod settings {}

#[doc = include_str!("names.md")]
pub mod names {}

#[doc = include_str!("physics.md")]
pub mod physics {}

#[doc = include_str!("how_it_works.md")]
pub mod how_it_works {}

#[doc = include_str!("tasks.md")]
pub mod tasks {}

#[doc = include_str!("accuracy.md")]
pub mod accuracy {}

#[doc = include_str!("limits.md")]
pub mod limits {}

#[doc = include_str!("performance.md")]
pub mod performance {}
