//! Meshes as they come: welded, not manifold, degenerate. They go through an app's own door.

use super::{
    choices::*,
    hold,
    soup::{Soup, app, check_soup},
};
use bevy_drape::prelude::*;
use proptest::prelude::*;
use std::cell::RefCell;

/// Corners on a coarse grid coincide often, and lie on lines.
fn soup() -> impl Strategy<Value = Soup> {
    let coarse = || [0..5_i8, 0..3_i8, 0..5_i8].prop_map(|p| p.map(f32::from));
    let fine = || vector(3.0).prop_map(|p| p.to_array());
    let corner =
        prop_oneof![6 => coarse(), 2 => fine(), 1 => wild_vector(7).prop_map(|p| p.to_array())];
    let corner = (corner, -6..6_i32).prop_map(|(p, nudge)| {
        // Within and beyond what is welded.
        p.map(|x| if nudge > 0 { x + 10.0_f32.powi(-nudge - 2) } else { x })
    });
    (prop::collection::vec(corner, 0..30), logarithmic(-6, 5)).prop_flat_map(|(corners, scale)| {
        let count = corners.len() as u32;
        let index = prop_oneof![200 => 0..count.max(1), 1 => Just(count + 7)];
        let triangle = [index.clone(), index.clone(), index];
        let triangles = prop::collection::vec(triangle, 0..50);
        let odd = (any::<bool>(), 0..3_usize, any::<u32>(), material());
        (triangles, odd).prop_map(move |(triangles, (strip, loose, pin, material))| Soup {
            positions: corners.iter().map(|p| p.map(|x| x * scale)).collect(),
            indices: triangles.as_flattened()[..triangles.len() * 3 - loose.min(triangles.len())]
                .to_vec(),
            strip,
            pin,
            material: ClothMaterial {
                area_density: material.area_density,
                thread_stiffness: material.thread_stiffness,
                shear_stiffness: material.shear_stiffness,
                flexural_rigidity: material.flexural_rigidity,
                bending_friction: material.bending_friction,
                damping: material.damping,
                damping_form: material.damping_form,
                drag: material.drag,
                max_strain: material.max_strain,
                friction: material.friction,
                thickness: material.thickness,
            },
        })
    })
}

#[test]
fn no_mesh_panics_or_makes_a_cloth_that_is_none() {
    let app = RefCell::new(app());
    let cloths = std::cell::Cell::new(0);
    hold(1500, &soup(), |soup| {
        let found = check_soup(&mut app.borrow_mut(), &soup);
        let is_cloth = found.map_err(TestCaseError::fail)?;
        cloths.set(cloths.get() + u32::from(is_cloth));
        Ok(())
    });
    assert!(cloths.get() > 300, "only {} meshes were cloths", cloths.get());
}
