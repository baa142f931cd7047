//! Settings by what they are for. Truths: the number of substeps that each promises, and the stability bound
//! `omega^2 <= max(8 ks, 4 ks + 8 kd) / m` of a uniform sheet.

use bevy::prelude::*;
use bevy_drape::{prelude::*, solver::Stretching};

use crate::support::app::*;

#[test]
fn each_quality_is_what_it_says() {
    let mut app = app();
    let material = ClothMaterial {
        area_density: 0.2,
        thread_stiffness: 1000.0,
        shear_stiffness: 300.0,
        flexural_rigidity: 0.0,
        damping: 0.0,
        ..default()
    };
    let sheet = Cloth::sheet(Vec2::ONE, UVec2::splat(64));
    let mut plan = |settings: ClothSettings| {
        let cloth = spawn(&mut app, (sheet, material, settings));
        app.update();
        *simulation(&app, cloth).plan()
    };
    // Ticks are of 1/64 s.
    let game = plan(ClothSettings::GAME);
    assert_eq!((game.stretching, game.substeps), (Stretching::ImplicitThreads, 8));
    let accurate = plan(ClothSettings::ACCURATE);
    assert_eq!((accurate.stretching, accurate.substeps), (Stretching::ImplicitThreads, 32));
    let reference = plan(ClothSettings::REFERENCE);
    let mass = 0.2 / (63.0_f64 * 63.0);
    let omega = (8000.0 / mass).sqrt();
    // Nine tenths of what is stable, of the square.
    let step = 2.0 * 0.9_f64.sqrt() / omega;
    assert_eq!(reference.stretching, Stretching::ExplicitSprings);
    assert_eq!(reference.substeps, (1.0 / 64.0 / step).ceil() as u32);
    assert_eq!((1.0 / 60.0 / step).ceil(), 111.0);
    assert_eq!(reference.clamped, default());
}
