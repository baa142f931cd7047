//! From components to a running cloth.

use crate::support::app::*;
use bevy::{
    camera::primitives::Aabb,
    mesh::{Indices, VertexAttributeValues},
    prelude::*,
};
use bevy_drape::{ClothGravityOverride, prelude::*, solver::MassLumping};
use std::sync::Arc;

#[test]
fn a_sheet_alone_is_set_up_and_drawn_in_the_frame_that_spawns_it() {
    let mut app = app();
    let cloth = Cloth::sheet(Vec2::new(3.0, 1.0), UVec2::new(4, 3));
    let entity = spawn(&mut app, (cloth, Transform::from_xyz(10.0, 2.0, 0.0)));
    app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(0));
    app.update();
    let running = simulation(&app, entity);
    assert_eq!((running.rows(), running.columns(), running.particle_count()), (3, 4, 12));
    assert_eq!(running.tick_count(), 0);
    let expected = |i: usize| Vec3::new((i % 4) as f32 - 1.5, 0.0, (i / 4) as f32 * 0.5 - 0.5);
    let mesh = drawn(&app, entity);
    for (i, local) in attribute(mesh, Mesh::ATTRIBUTE_POSITION).into_iter().enumerate() {
        assert!(local.distance(expected(i)) < 1e-6);
        assert!(position(&app, entity, i).distance(expected(i) + Vec3::new(10.0, 2.0, 0.0)) < 1e-6);
    }
    assert!(attribute(mesh, Mesh::ATTRIBUTE_NORMAL).iter().all(|n| *n == Vec3::Y));
    assert_eq!(mesh.attribute(Mesh::ATTRIBUTE_UV_0).map(VertexAttributeValues::len), Some(12));
    assert_eq!(mesh.indices().map(Indices::len), Some(36));
    let aabb = app.world().get::<Aabb>(entity).expect("it has bounds");
    assert!(Vec3::from(aabb.half_extents).distance(Vec3::new(1.5, 0.0, 0.5)) < 1e-6);
}

#[test]
fn the_front_of_every_triangle_of_a_sheet_is_up() {
    let mut app = app();
    let entity = spawn(&mut app, Cloth::sheet(Vec2::ONE, UVec2::new(3, 4)));
    app.update();
    let mesh = drawn(&app, entity);
    for triangle in mesh.triangles().expect("it has triangles") {
        let [a, b, c] = triangle.vertices;
        assert!((b - a).cross(c - a).y > 0.0);
    }
}

/// A quarter of a tube of 5 rows and 9 columns, in shuffled order.
fn tube() -> (Mesh, impl Fn(u32) -> u32) {
    let name = |v: u32| (v * 7 + 3) % 45;
    let place = |r: u32, c: u32| {
        let angle = c as f32 * 0.2;
        Vec3::new(angle.sin(), angle.cos(), r as f32 * 0.25)
    };
    (grid_mesh(5, 9, name, place), name)
}

#[test]
fn a_curved_grid_in_any_vertex_order_is_a_cloth_that_keeps_its_shape() {
    let mut app = app();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let (mesh, name) = tube();
    let places = attribute(&mesh, Mesh::ATTRIBUTE_POSITION);
    let turned = Transform::from_xyz(0.0, 5.0, 1.0).with_rotation(Quat::from_rotation_x(0.5));
    let mesh = Mesh3d(add_mesh(&mut app, mesh));
    let entity = spawn(&mut app, (Cloth::of_mesh3d(), mesh, turned));
    app.update();
    let running = simulation(&app, entity);
    assert_eq!(running.rows() * running.columns(), 45);
    assert_eq!(running.rows().min(running.columns()), 5);
    // Neighbours of the grid are neighbours of the cloth.
    let place = |v: u32| running.particle_of_vertex(name(v)).expect("it has a particle") as usize;
    let (a, b) = (place(10), place(11));
    let columns = running.columns();
    assert_eq!((a / columns).abs_diff(b / columns) + (a % columns).abs_diff(b % columns), 1);
    updates(&mut app, 60);
    for (vertex, place) in places.iter().enumerate() {
        let particle = simulation(&app, entity).particle_of_vertex(vertex as u32).unwrap();
        let now = position(&app, entity, particle as usize);
        assert!(now.distance(turned.transform_point(*place)) < 1e-4);
    }
    let shown = attribute(drawn(&app, entity), Mesh::ATTRIBUTE_POSITION);
    assert!(shown.iter().zip(&places).all(|(a, b)| a.distance(*b) < 1e-4));
    // The mesh's front stays its front.
    let normals = attribute(drawn(&app, entity), Mesh::ATTRIBUTE_NORMAL);
    for (normal, place) in normals.iter().zip(&places) {
        assert!(normal.dot(Vec3::new(place.x, place.y, 0.0)) > 0.9);
    }
}

#[test]
fn a_mesh_that_loads_late_is_waited_for() {
    let mut app = app();
    let handle = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let entity = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d(handle.clone())));
    updates(&mut app, 5);
    assert!(app.world().get::<ClothSimulation>(entity).is_none());
    let error = failure(&app, entity).expect("nothing loads it").to_string();
    assert!(error.contains("nothing loads it"), "{error}");
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(&handle, tube().0).unwrap();
    updates(&mut app, 2);
    assert_eq!(simulation(&app, entity).particle_count(), 45);
    assert_eq!(failure(&app, entity), None);
}

#[test]
fn two_cloths_from_one_mesh_share_nothing() {
    let mut app = app();
    let handle = add_mesh(&mut app, tube().0);
    let high = Transform::from_xyz(0.0, 3.0, 0.0);
    let free = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d(handle.clone()), high));
    let held = (Cloth::of_mesh3d(), Mesh3d(handle.clone()), ClothPins::from(PinSelection::All));
    let held = spawn(&mut app, held);
    updates(&mut app, 10);
    let original = attribute(&tube().0, Mesh::ATTRIBUTE_POSITION);
    let asset = app.world().resource::<Assets<Mesh>>().get(&handle).unwrap();
    assert_eq!(attribute(asset, Mesh::ATTRIBUTE_POSITION), original);
    assert_eq!(attribute(drawn(&app, held), Mesh::ATTRIBUTE_POSITION), original);
    let fallen = attribute(drawn(&app, free), Mesh::ATTRIBUTE_POSITION);
    assert!(fallen.iter().zip(&original).all(|(a, b)| a.y < b.y - 0.01));
}

#[test]
fn equal_sheets_share_their_rest_shape() {
    let mut app = app();
    let cloths = [0.0, 1.0].map(|x| spawn(&mut app, (sheet(), Transform::from_xyz(x, 0.0, 0.0))));
    let other = spawn(&mut app, Cloth::sheet(Vec2::splat(2.0), UVec2::splat(8)));
    app.update();
    let lattice = |entity| simulation(&app, entity).lattice().unwrap();
    assert!(Arc::ptr_eq(lattice(cloths[0]), lattice(cloths[1])));
    assert!(!Arc::ptr_eq(lattice(cloths[0]), lattice(other)));
}

#[test]
fn a_uniform_scale_makes_the_cloth_larger() {
    let mut app = app();
    let parent = spawn(&mut app, Transform::from_scale(Vec3::splat(2.0)));
    let entity =
        spawn(&mut app, (sheet(), Transform::from_scale(Vec3::splat(1.5)), ChildOf(parent)));
    app.insert_resource(ClothGravity(Vec3::ZERO));
    updates(&mut app, 10);
    assert!((simulation(&app, entity).topology().total_area() - 9.0).abs() < 1e-4);
    assert!(position(&app, entity, 0).distance(Vec3::new(-1.5, 0.0, -1.5)) < 1e-5);
    let shown = attribute(drawn(&app, entity), Mesh::ATTRIBUTE_POSITION);
    assert!(shown[0].distance(Vec3::new(-0.5, 0.0, -0.5)) < 1e-5);
}

#[test]
fn changing_the_shape_starts_anew() {
    let mut app = app();
    let entity = spawn(&mut app, sheet());
    updates(&mut app, 10);
    assert!(position(&app, entity, 0).y < -0.05);
    *app.world_mut().get_mut::<Cloth>(entity).unwrap() = Cloth::sheet(Vec2::ONE, UVec2::new(3, 5));
    app.update();
    assert_eq!(simulation(&app, entity).particle_count(), 15);
    assert_eq!(drawn(&app, entity).count_vertices(), 15);
    assert!(position(&app, entity, 0).y > -0.05);
}

#[test]
fn removing_the_simulation_starts_a_mesh_anew_from_the_original() {
    let mut app = app();
    let handle = add_mesh(&mut app, tube().0);
    let entity = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d(handle)));
    updates(&mut app, 30);
    app.world_mut().entity_mut(entity).remove::<ClothSimulation>();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    updates(&mut app, 2);
    let original = attribute(&tube().0, Mesh::ATTRIBUTE_POSITION);
    let shown = attribute(drawn(&app, entity), Mesh::ATTRIBUTE_POSITION);
    assert!(shown.iter().zip(&original).all(|(a, b)| a.distance(*b) < 1e-4));
}

#[test]
fn what_else_is_wrong_with_an_entity_keeps_no_cloth_from_being_set_up() {
    let mut app = app();
    let bad = SdfCollider::new(Sphere::new(0.1)).with_friction(f32::NAN);
    let entity = spawn(&mut app, (sheet(), bad, ClothPaused::default(), Transform::default()));
    updates(&mut app, 2);
    assert!(failure(&app, entity).is_some());
    // Before its first tick it is set up where its entity is.
    transform(&mut app, entity).translation.x = 5.0;
    app.update();
    assert!(positions(&app, entity).iter().all(|place| place.x > 4.0));
    app.world_mut().entity_mut(entity).remove::<ClothSimulation>();
    app.update();
    assert_eq!(simulation(&app, entity).particle_count(), 64);
}

#[test]
fn a_refused_component_that_is_taken_off_is_no_reason_any_more() {
    let mut app = app();
    let bad = ClothMaterial { drag: f32::NAN, ..default() };
    let entity = spawn(&mut app, (sheet(), bad, Transform::default()));
    updates(&mut app, 2);
    assert!(failure(&app, entity).is_some());
    app.world_mut().entity_mut(entity).remove::<ClothMaterial>();
    updates(&mut app, 2);
    assert_eq!(failure(&app, entity), None);
    assert_eq!(simulation(&app, entity).particle_count(), 64);
}

#[test]
fn other_masses_keep_place_and_motion() {
    let mut app = app();
    let entity = spawn(&mut app, sheet());
    updates(&mut app, 20);
    let before = positions(&app, entity);
    let speed = simulation(&app, entity).velocity(0).unwrap();
    app.world_mut().get_mut::<ClothSettings>(entity).unwrap().masses = MassLumping::Equal;
    app.update();
    let after = position(&app, entity, 0);
    let expected = before[0] + speed * TICK.as_secs_f32();
    assert!(after.distance(expected) < 0.005, "{after} is not near {expected}");
    assert_eq!(failure(&app, entity), None);
}

#[test]
fn a_material_is_edited_live() {
    let mut app = app();
    let material = ClothMaterial { drag: 0.0, ..default() };
    let cloths = [0, 1].map(|_| spawn(&mut app, (sheet(), material)));
    updates(&mut app, 10);
    app.world_mut().get_mut::<ClothMaterial>(cloths[1]).unwrap().drag = 20.0;
    updates(&mut app, 20);
    let [free, braked] = cloths.map(|cloth| position(&app, cloth, 0).y);
    assert!(free < -1.0 && braked > 0.5 * free, "{free} {braked}");
}

#[test]
fn gravity_may_be_a_cloths_own() {
    let mut app = app();
    let down = spawn(&mut app, sheet());
    let up = spawn(&mut app, (sheet(), ClothGravityOverride(Vec3::Y)));
    updates(&mut app, 30);
    assert!(position(&app, down, 0).y < 0.0);
    assert!(position(&app, up, 0).y > 0.0);
}

#[test]
fn cloths_come_and_go() {
    let mut app = app();
    let cloths = [0, 1, 2].map(|_| spawn(&mut app, sheet()));
    updates(&mut app, 3);
    app.world_mut().despawn(cloths[0]);
    app.world_mut().entity_mut(cloths[1]).remove::<Cloth>();
    let late = spawn(&mut app, sheet());
    updates(&mut app, 3);
    assert!(app.world().get::<ClothSimulation>(cloths[1]).is_none());
    assert!(app.world().get::<Mesh3d>(cloths[1]).is_some());
    assert_eq!(simulation(&app, cloths[2]).tick_count(), 6);
    assert_eq!(simulation(&app, late).tick_count(), 3);
}
