//! The named fabrics. Truths: the sheet of rubber by the formulas of isotropic elasticity, the strain limit,
//! and that a heavier load or a softer cloth is stretched more.

use bevy::prelude::*;
use bevy_drape::{ClothSleepThreshold, prelude::*};

use crate::support::app::*;

#[test]
fn rubber_is_a_sheet_of_a_millimetre() {
    let (young, thickness, density) = (1.5e6_f64, 1e-3, 930.0);
    let rubber = ClothMaterial::RUBBER;
    // C11 = ks + kd, C12 = kd; E h = C11 - C12^2 / C11; isotropic where 2 C66 = C11 - C12.
    let (ks, kd) = (f64::from(rubber.thread_stiffness), f64::from(rubber.shear_stiffness));
    let modulus = ks + kd - kd * kd / (ks + kd);
    assert!((modulus / (young * thickness) - 1.0).abs() < 1e-3, "{modulus}");
    assert!((ks / (2.0 * kd) - 1.0).abs() < 1e-6);
    let rigidity = young * thickness.powi(3) / (12.0 * (1.0 - 0.25));
    assert!((f64::from(rubber.flexural_rigidity) / rigidity - 1.0).abs() < 5e-3);
    assert!((f64::from(rubber.area_density) / (density * thickness) - 1.0).abs() < 1e-6);
}

#[test]
fn each_hangs_from_its_first_row_within_its_strain() {
    let mut app = app();
    let cloths = ClothMaterial::FABRICS.map(|(name, material)| {
        let cloth = Cloth::sheet(Vec2::splat(1.0), UVec2::splat(24));
        // Upright, the first row on top.
        let place = Transform::from_rotation(Quat::from_rotation_x(90.0_f32.to_radians()));
        let material = ClothMaterial { drag: 2.0, ..material };
        let pins = ClothPins::from(PinSelection::FirstRow);
        let cloth = (cloth, material, pins, ClothSleepThreshold::NEVER, place);
        (name, material, spawn(&mut app, cloth))
    });
    updates(&mut app, 256);
    for (name, material, entity) in cloths {
        assert_eq!(failure(&app, entity), None, "{name}");
        let cloth = simulation(&app, entity);
        let positions: Vec<_> = cloth.positions().collect();
        assert!(positions.iter().all(|p| p.is_finite()), "{name}");
        let top = positions.iter().map(|p| p.y).fold(f32::MIN, f32::max);
        let bottom = positions.iter().map(|p| p.y).fold(f32::MAX, f32::min);
        let longer = top - bottom - 1.0;
        // Half the strain of a strip that hangs from its top: rho g L / (2 ks), a little less with shear.
        let strip = material.area_density * 9.81 / (2.0 * material.thread_stiffness);
        println!("{name}: longer by {longer:.2e}, as a strip of threads {strip:.2e}");
        let rounding = 2e-6;
        assert!(longer > 0.7 * strip - rounding, "{name}");
        assert!(longer < 1.02 * strip + rounding, "{name}");
    }
}
