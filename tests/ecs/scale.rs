//! Cloths whose entities change their scale while they run. Truths: lengths at rest follow the scale; no thread is longer than its limit
//! allows; a cloth that is put into another size looks as before, only larger.

use bevy::prelude::*;
use bevy_drape::{ClothComponent, ClothError, ClothErrorKind, prelude::*};

use crate::support::app::*;

fn curtain() -> impl Bundle {
    (Cloth::sheet(Vec2::ONE, UVec2::splat(17)), ClothPins::from(PinSelection::FirstRow))
}

/// Width of a cloth along x \[m\].
fn width(app: &App, cloth: Entity) -> f32 {
    let along = || simulation(app, cloth).positions().map(|p| p.x);
    along().fold(f32::MIN, f32::max) - along().fold(f32::MAX, f32::min)
}

#[test]
fn a_cloth_that_pops_in_is_never_overstretched() {
    let mut app = app();
    let cloth = spawn(&mut app, (curtain(), Transform::from_scale(Vec3::splat(0.05))));
    for frame in 1..=90 {
        let part = (frame as f32 / 30.0).min(1.0);
        transform(&mut app, cloth).scale = Vec3::splat(0.05 + 0.95 * part);
        app.update();
        let strain = simulation(&app, cloth).strain().max;
        assert!(strain < 0.15, "{frame}: {strain}");
    }
    assert_eq!(failure(&app, cloth), None);
    assert!((width(&app, cloth) - 1.0).abs() < 0.02);
    let rest = simulation(&app, cloth).rest_positions().to_vec();
    assert!((rest[0].distance(rest[16]) - 1.0).abs() < 1e-3);
}

#[test]
fn a_cloth_that_falls_grows_about_its_middle_and_falls_on() {
    let mut app = app();
    let place = Transform::from_xyz(0.0, 3.0, 0.0);
    let cloth = spawn(&mut app, (Cloth::sheet(Vec2::ONE, UVec2::splat(17)), place));
    updates(&mut app, 20);
    let [middle, speed] = [position(&app, cloth, 144), mean_velocity(&app, cloth)];
    transform(&mut app, cloth).scale = Vec3::splat(2.0);
    app.update();
    assert!((width(&app, cloth) - 2.0).abs() < 0.02);
    assert!((mean_velocity(&app, cloth).y / speed.y - 1.0).abs() < 0.1);
    assert!(position(&app, cloth, 144).distance(middle) < 0.2);
}

#[test]
fn a_cloth_that_grows_and_jumps_is_carried() {
    let mut app = app();
    let cloth = spawn(&mut app, curtain());
    updates(&mut app, 30);
    *transform(&mut app, cloth) = Transform::from_xyz(50.0, 0.0, 0.0).with_scale(Vec3::splat(2.0));
    for _ in 0..30 {
        app.update();
        let running = simulation(&app, cloth);
        assert!(running.strain().max < 0.15, "{}", running.strain().max);
        assert!(running.positions().all(|p| p.distance(Vec3::X * 50.0) < 3.0));
    }
    assert!((width(&app, cloth) - 2.0).abs() < 0.1);
}

#[test]
fn a_cape_grows_with_the_character_that_it_hangs_on() {
    let mut app = app();
    let character = spawn(&mut app, Transform::from_xyz(20.0, 0.0, 0.0));
    let place = Transform::from_xyz(0.0, 1.0, 0.0);
    let hands = [-0.5, 0.5]
        .map(|side| spawn(&mut app, (Transform::from_xyz(side, 1.5, 0.0), ChildOf(character))));
    let held = [[0, 1, 2], [14, 15, 16]].map(ClothPins::vertices);
    let [left, right] = held;
    let pins = left.anchored_to(hands[0]).and(right.anchored_to(hands[1]));
    let cape = Cloth::sheet(Vec2::ONE, UVec2::splat(17));
    let cape = spawn(&mut app, (cape, pins, place, ChildOf(character)));
    updates(&mut app, 60);
    for frame in 1..=60 {
        let part = (frame as f32 / 20.0).min(1.0);
        transform(&mut app, character).scale = Vec3::splat(1.0 + part);
        app.update();
        let strain = simulation(&app, cape).strain().max;
        assert!(strain < 0.15, "{frame}: {strain}");
    }
    assert_eq!(failure(&app, cape), None);
    assert!((width(&app, cape) - 2.0).abs() < 0.2);
}

#[test]
fn a_distance_that_is_too_large_for_a_small_cloth_is_told_and_comes_back() {
    let mut app = app();
    let apart = ClothSelfCollision { distance: Some(0.05), ..default() };
    let cloth = spawn(&mut app, (curtain(), apart));
    updates(&mut app, 10);
    assert_eq!(failure(&app, cloth), None);
    for (scale, is_told) in [(0.5, true), (1.0, false)] {
        transform(&mut app, cloth).scale = Vec3::splat(scale);
        updates(&mut app, 2);
        let told = failure(&app, cloth);
        assert_eq!(told.is_some(), is_told, "{told:?}");
        if let Some(ClothError { kind, .. }) = told {
            let component = ClothComponent::ClothSelfCollision;
            assert!(
                matches!(kind, ClothErrorKind::Parameter { component: of, .. } if of == component)
            );
        }
        assert!((width(&app, cloth) - scale).abs() < 0.1);
        assert!(simulation(&app, cloth).strain().max < 0.15);
    }
}
