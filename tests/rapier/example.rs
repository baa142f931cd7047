//! The example, run headless.

#[allow(dead_code)]
#[path = "../../examples/rapier.rs"]
mod rapier;

use bevy::prelude::*;
use examples_common::{
    bodies::{HAMMOCK, THROWN, Thing},
    check::check,
    headless,
};

#[test]
fn the_hammock_carries_what_is_thrown_into_it() {
    let mut app = headless::app(rapier::RAPIER, 40, 1);
    println!("{}", headless::simulate(&mut app, 18.0).unwrap());
    assert_eq!(check(app.world_mut()), Ok(()));
    let mut things = app.world_mut().query::<(&Thing, &Transform)>();
    let things: Vec<_> =
        things.iter(app.world()).filter(|(thing, _)| thing.throw.is_some()).collect();
    assert_eq!(things.len(), THROWN + 1);
    let mut carried = 0;
    for (_, &Transform { translation: at, .. }) in things {
        // Nothing is lost, or below the ground.
        assert!(at.is_finite() && at.y > 0.05 && at.length() < 12.0, "{at}");
        let off = (at - HAMMOCK).abs();
        carried += u32::from(at.y > 0.3 && off.x < 0.85 && off.z < 0.5);
    }
    assert!(carried >= 5, "{carried} lie in the hammock");
}
