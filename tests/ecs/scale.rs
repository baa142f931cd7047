//! Cloths whose entities change their scale while they run. Truths: lengths at rest follow the scale; no thread is longer than its limit
//! allows; a cloth that is put into another size looks as before, only larger.

use bevy::prelude::*;
use bevy_drape::prelude::*;

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
fn a_cloth_that_falls_grows_about_its_middle_and_falls_faster() {
    let mut app = app();
    let place = Transform::from_xyz(0.0, 3.0, 0.0);
    let cloth = spawn(&mut app, (Cloth::sheet(Vec2::ONE, UVec2::splat(17)), place));
    updates(&mut app, 20);
    let [middle, speed] = [position(&app, cloth, 144), mean_velocity(&app, cloth)];
    transform(&mut app, cloth).scale = Vec3::splat(2.0);
    app.update();
    assert!((width(&app, cloth) - 2.0).abs() < 0.02);
    assert!((mean_velocity(&app, cloth).y / speed.y - 2.0).abs() < 0.2);
    assert!(position(&app, cloth, 144).distance(middle) < 0.2);
}
