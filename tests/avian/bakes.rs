//! Fields are baked once a shape.

use crate::falls::physics_app;
use crate::support::{app::*, dice::Dice, sheets::ground_of_a_level};
use avian3d::prelude::*;
use bevy::prelude::*;
use bevy_drape::{AvianClothPlugin, ClothCollider, CustomSdf, SdfCells, SdfShape, prelude::*};
use std::{collections::BTreeSet, sync::Arc, time::Instant};

/// Ten hulls, always the same.
fn hulls() -> Vec<Collider> {
    let mut dice = Dice(3);
    let mut points = || (0..24).map(|_| 0.3 * dice.vector()).collect();
    (0..10).map(|_| Collider::convex_hull(points()).unwrap()).collect()
}

/// Where in memory the field of an entity is.
fn field(app: &App, entity: Entity) -> Option<usize> {
    match &app.world().get::<SdfCollider>(entity)?.shape {
        SdfShape::Custom(CustomSdf(field)) => Some(Arc::as_ptr(field).addr()),
        _ => None,
    }
}

fn are_baked(app: &App, entities: &[Entity]) -> bool {
    entities.iter().all(|entity| field(app, *entity).is_some())
}

#[test]
fn a_thousand_hulls_of_ten_shapes_are_ten_bakes() {
    // Without Avian's own systems, so that what is timed is ours.
    let mut app = app_with((ClothPlugin::default(), AvianClothPlugin::default()));
    let cells = SdfCells::Count(16);
    let mut entities = Vec::new();
    for i in 0..100 {
        // Equal shapes, not the same ones; scaled, some of them.
        for hull in hulls() {
            let scale = Transform::from_scale(Vec3::splat(1.0 + (i % 2) as f32));
            let wish = ClothCollider { cells, ..default() };
            entities.push(spawn(&mut app, (hull, scale, wish)));
        }
    }
    let start = Instant::now();
    app.update();
    println!("the frame that adds 1000 hulls: {:?}", start.elapsed());
    wait(&mut app, |app| are_baked(app, &entities));
    let fields: BTreeSet<_> = entities.iter().map(|entity| field(&app, *entity)).collect();
    assert_eq!(fields.len(), 10);
    app.update();
    let start = Instant::now();
    app.update();
    println!("a frame with 1000 hulls: {:?}", start.elapsed());
}

/// A level that is there twice is one shell; of another thickness it is another.
#[test]
fn a_surface_is_made_once_a_thickness() {
    let mut app = physics_app();
    let level = || {
        let (vertices, triangles) = ground_of_a_level();
        Collider::trimesh(vertices, triangles)
    };
    let shared = level();
    let wish = |thickness| ClothCollider { thickness, ..default() };
    let entities = [(shared.clone(), 0.04), (shared, 0.04), (level(), 0.04), (level(), 0.06)]
        .map(|(collider, thickness)| spawn(&mut app, (collider, wish(thickness))));
    wait(&mut app, |app| are_baked(app, &entities));
    let [a, b, equal, thicker] = entities.map(|entity| field(&app, entity));
    assert_eq!((a, a), (b, equal));
    assert_ne!(a, thicker);
}

#[test]
fn a_field_is_finer_where_it_is_asked_for() {
    let mut app = physics_app();
    let hull = hulls().remove(0);
    let wish = |count| ClothCollider { cells: SdfCells::Count(count), ..default() };
    let entities = [8, 16, 16].map(|count| spawn(&mut app, (hull.clone(), wish(count))));
    wait(&mut app, |app| are_baked(app, &entities));
    let [coarse, fine, also_fine] = entities.map(|entity| field(&app, entity));
    assert_eq!(fine, also_fine);
    assert_ne!(coarse, fine);
    // The old one serves until the new one is there.
    app.world_mut().entity_mut(entities[0]).insert(wish(17));
    app.update();
    assert!(field(&app, entities[0]).is_some());
    wait(&mut app, |app| field(app, entities[0]) != coarse);
}

#[test]
fn a_field_that_nobody_has_is_dropped() {
    let mut app = physics_app();
    let entity = spawn(&mut app, (hulls().remove(0), ClothCollider::default()));
    wait(&mut app, |app| are_baked(app, &[entity]));
    let SdfShape::Custom(CustomSdf(field)) = &app.world().get::<SdfCollider>(entity).unwrap().shape
    else {
        panic!("it is baked");
    };
    let field = Arc::downgrade(field);
    app.world_mut().despawn(entity);
    updates(&mut app, 2);
    assert_eq!(field.strong_count(), 0);
}
