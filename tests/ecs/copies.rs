//! Cloths whose entities are cloned, or saved in a Bevy world and loaded. Truths: a copy goes the way that its original went, to the
//! bit, from the same rest shape; the original goes on; each draws into a mesh of its own; no failure is copied.

use bevy::{
    ecs::entity::{EntityCloner, EntityHashMap},
    prelude::*,
    reflect::GetPath,
    world_serialization::DynamicWorldBuilder,
};
use bevy_drape::{ClothFailure, ClothSkin, prelude::*};

use crate::{
    skin::{dressed, usual},
    support::app::*,
};

/// A cloth that hangs by its first row, and where it is after 20 ticks.
struct Hanging {
    entity: Entity,
    early: Vec<[u32; 3]>,
}

/// A cloth of a mesh, and one that is a sheet. Both have swung out of their rest shape.
fn hanging(app: &mut App) -> [Hanging; 2] {
    let mesh = add_mesh(app, flat_mesh(9, 9));
    let held = || ClothPins::from(PinSelection::FirstRow);
    let of_mesh = spawn(app, (Cloth::of_mesh3d(), Mesh3d(mesh), held()));
    let sheet = spawn(app, (Cloth::sheet(Vec2::ONE, UVec2::splat(9)), held()));
    updates(app, 20);
    let known = [of_mesh, sheet].map(|entity| Hanging { entity, early: bits(app, entity) });
    updates(app, 40);
    known
}

/// Checks a copy that was made in this frame.
#[track_caller]
fn check(app: &mut App, Hanging { entity, early }: &Hanging, copy: Entity) {
    updates(app, 20);
    assert_eq!(failure(app, copy), None);
    assert_eq!(bits(app, copy), *early);
    assert_ne!(bits(app, *entity), *early, "the original has gone on");
    let rest = simulation(app, copy).rest_positions();
    assert!(rest.iter().all(|p| p.y == 0.0));
    let drawn = |entity| app.world().get::<Mesh3d>(entity).unwrap().id();
    assert_ne!(drawn(*entity), drawn(copy));
}

#[test]
fn a_clone_goes_the_way_of_its_original() {
    let mut app = app();
    for original in hanging(&mut app) {
        let copy = app.world_mut().entity_mut(original.entity).clone_and_spawn();
        check(&mut app, &original, copy);
        // And a clone of the clone.
        updates(&mut app, 20);
        let again = app.world_mut().entity_mut(copy).clone_and_spawn();
        check(&mut app, &Hanging { entity: copy, early: original.early }, again);
    }
}

#[test]
fn what_a_saved_world_holds_goes_the_way_of_its_original() {
    let mut app = app();
    let originals = hanging(&mut app);
    let failed = spawn(&mut app, Cloth::sheet(Vec2::ONE, UVec2::splat(1)));
    app.update();
    let told = app.world().get::<ClothFailure>(failed).unwrap();
    // What an inspector sees of it.
    let messages = told.reflect_path("messages").unwrap().try_downcast_ref::<Vec<String>>();
    assert_eq!(messages.unwrap(), &[told.error.to_string()]);
    let known = app.world().resource::<AppTypeRegistry>().clone();
    let entities = originals.iter().map(|original| original.entity).chain([failed]);
    let saved = DynamicWorldBuilder::from_world(app.world(), &known.read())
        .extract_entities(entities)
        .build();
    let mut map = EntityHashMap::default();
    saved.write_to_world(app.world_mut(), &mut map).unwrap();
    assert!(!app.world().entity(map[&failed]).contains::<ClothFailure>());
    updates(&mut app, 20);
    for Hanging { entity, early } in &originals {
        let copy = map[entity];
        assert_eq!((failure(&app, copy), bits(&app, copy)), (None, early.clone()));
    }
    assert!(failure(&app, map[&failed]).is_some());
    // As text: the meshes without a file are lost, and nothing else.
    assert!(saved.serialize(&known.read()).is_ok());
}

/// A character and what it wears, cloned and moved, or saved and loaded: the copy is worn by the copy.
#[test]
fn the_copy_of_a_dressed_character_wears_its_own_coat() {
    let mut app = app();
    let of = dressed(&mut app, usual());
    updates(&mut app, 10);
    let known = app.world().resource::<AppTypeRegistry>().clone();
    let mut all = vec![of.root];
    let mut next = 0;
    while next < all.len() {
        all.extend(app.world().get::<Children>(all[next]).into_iter().flat_map(Children::iter));
        next += 1;
    }
    let saved = DynamicWorldBuilder::from_world(app.world(), &known.read())
        .extract_entities(all.into_iter())
        .build();
    let mut map = EntityHashMap::default();
    saved.write_to_world(app.world_mut(), &mut map).unwrap();
    *transform(&mut app, map[&of.root]) = Transform::from_xyz(5.0, 0.0, 0.0);
    let mut cloner = EntityCloner::build_opt_out(app.world_mut());
    cloner.linked_cloning(true);
    let mut cloner = cloner.finish();
    let clone = cloner.spawn_clone(app.world_mut(), of.root);
    *transform(&mut app, clone) = Transform::from_xyz(-5.0, 0.0, 0.0);
    let is_coat = |&it: &Entity| app.world().entity(it).contains::<ClothSkin>();
    let cloned = app.world().get::<Children>(clone).unwrap().iter().find(is_coat).unwrap();
    updates(&mut app, 20);
    for (copy, x) in [(map[&of.coat], 5.0), (cloned, -5.0), (of.coat, 0.0)] {
        assert_eq!(failure(&app, copy), None);
        let places = positions(&app, copy);
        assert!(places.iter().all(|place| (place.x - x).abs() < 0.8), "{x}: {}", places[0]);
    }
}
