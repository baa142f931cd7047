//! What the tests share. Each test crate includes it by one line, and uses a part of it:
//!
//! - [`solver`]: sheets, materials, ways to run, measures and bits of what has no ECS.
//! - [`kinds`]: the cloths that hard cases are run with, as lattices and as meshes.
//! - [`app`]: an app with the plugin, and how it is looked at.
//! - [`dice`], [`table`]: numbers that only look random, reference tables.

pub mod app;
pub mod bits;
pub mod checks;
pub mod dice;
pub mod distances;
pub mod kinds;
pub mod materials;
pub mod measures;
pub mod runs;
pub mod sheets;
pub mod table;

/// All that tests of the solver need.
pub mod solver {
    pub use super::{
        bits::*, checks::*, dice::Dice, materials::*, measures::*, runs::*, sheets::*, table::table,
    };
}
