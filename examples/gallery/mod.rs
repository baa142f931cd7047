//! The scenes of the examples, by name: for `headless`, `soak` and the tests, which run them without a window.

// What only a window has is not run here: the mains, and what the mouse does.
#![allow(dead_code)]

#[path = "../bunny.rs"]
mod bunny;
#[path = "../cape.rs"]
mod cape;
#[path = "../curtain.rs"]
mod curtain;
#[path = "../drape.rs"]
mod drape;
#[path = "../fabrics.rs"]
mod fabrics;
#[path = "../flag.rs"]
mod flag;
#[path = "../heap.rs"]
mod heap;
#[path = "../hung.rs"]
mod hung;
#[path = "../laundry.rs"]
mod laundry;
#[path = "../panel.rs"]
mod panel;
#[path = "../pile.rs"]
mod pile;
#[path = "../sail.rs"]
mod sail;
#[path = "../shirt.rs"]
mod shirt;
#[path = "../skirt.rs"]
mod skirt;
#[path = "../stress.rs"]
mod stress;
#[path = "../tablecloth.rs"]
mod tablecloth;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use examples_common::Example;

/// All scenes.
pub const SCENES: [Example; 17] = [
    drape::DRAPE,
    drape::SPHERES,
    bunny::BUNNY,
    curtain::CURTAIN,
    hung::HUNG,
    flag::FLAG,
    sail::SAIL,
    cape::CAPE,
    shirt::SHIRT,
    skirt::SKIRT,
    tablecloth::TABLECLOTH,
    heap::HEAP,
    pile::PILE,
    laundry::LAUNDRY,
    fabrics::FABRICS,
    stress::STRESS,
    // Without its panel.
    Example { name: "tuned", ..panel::PANEL },
];

/// The scene of a name.
///
/// # Panics
/// When there is none.
pub fn scene(name: &str) -> Example {
    let found = SCENES.into_iter().find(|scene| scene.name == name);
    found.unwrap_or_else(|| panic!("there is no scene {name}"))
}

/// Reads a scene's name on the command line.
pub fn parser() -> impl TypedValueParser<Value = Example> {
    let values = SCENES.map(|scene| PossibleValue::new(scene.name).help(scene.about));
    PossibleValuesParser::new(values).map(|name| scene(&name))
}
