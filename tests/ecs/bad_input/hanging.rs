//! Numbers of `HangOnStart` that are out of their ranges.

use super::{INF, NAN, bundle, told, world};
use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{ClothComponent, ClothErrorKind, HangOnStart};

/// What it is, and the number that is bad.
pub fn bad() -> impl Iterator<Item = (String, HangOnStart)> {
    let usual = HangOnStart::default();
    let speeds = [NAN, INF, -INF, -1.0].map(|speed| HangOnStart { speed, ..usual });
    let longest = [NAN, INF, -1.0, 3601.0].map(|longest| HangOnStart { longest, ..usual });
    let speeds =
        speeds.into_iter().map(|bad| (format!("HangOnStart.speed = {:?}", bad.speed), bad));
    let longest =
        longest.into_iter().map(|bad| (format!("HangOnStart.longest = {:?}", bad.longest), bad));
    speeds.chain(longest)
}

/// Such a cloth starts in its rest shape, as one that is not hung.
#[test]
fn numbers_of_hanging() {
    let (mut app, good) = world();
    let cloths: Vec<_> =
        bad().map(|(what, bad)| (what, spawn(&mut app, (bundle(), bad)))).collect();
    updates(&mut app, 16);
    for (what, cloth) in &cloths {
        let error = told(&app, *cloth, what);
        let ClothErrorKind::Parameter { component: ClothComponent::HangOnStart, problem } =
            error.kind
        else {
            panic!("{what}: {error}")
        };
        assert!(what.starts_with(&format!("HangOnStart.{} = ", problem.name)), "{what}: {problem}");
        assert!(bits(&app, *cloth) == bits(&app, good), "{what}");
        app.world_mut().entity_mut(*cloth).remove::<HangOnStart>();
    }
    updates(&mut app, 4);
    for (what, cloth) in &cloths {
        assert_eq!(failure(&app, *cloth), None, "{what}: mended");
        assert!(bits(&app, *cloth) == bits(&app, good), "{what}: mended");
    }
    assert!(bits(&app, good) == super::alone(20));
}
