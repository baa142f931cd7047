//! The drawn mesh: where, when, and nothing else.

use crate::support::app::*;
use bevy::{
    asset::RenderAssetUsages,
    camera::primitives::Aabb,
    math::DVec3,
    mesh::{Indices, VertexAttributeValues},
    prelude::*,
    time::TimeUpdateStrategy,
};
use bevy_drape::{ClothError, ClothErrorKind, ClothInterpolation, MeshProblem, prelude::*};

/// How often meshes were marked modified.
#[derive(Resource, Default)]
struct Writes(usize);

fn count_writes(mut events: MessageReader<AssetEvent<Mesh>>, mut writes: ResMut<Writes>) {
    writes.0 += events.read().filter(|e| matches!(e, AssetEvent::Modified { .. })).count();
}

fn counting_app() -> App {
    let mut app = app();
    app.init_resource::<Writes>().add_systems(Last, count_writes);
    app
}

fn writes(app: &mut App) -> usize {
    core::mem::take(&mut app.world_mut().resource_mut::<Writes>().0)
}

#[test]
fn a_moving_cloth_is_written_once_a_frame() {
    let mut app = counting_app();
    spawn(&mut app, sheet());
    updates(&mut app, 3);
    for ticks in [0, 1, 3] {
        app.insert_resource(TimeUpdateStrategy::FixedTimesteps(ticks));
        app.update();
        writes(&mut app);
        updates(&mut app, 10);
        assert_eq!(writes(&mut app), if ticks == 0 { 0 } else { 10 });
    }
    // Between ticks as well: the blend goes on.
    set_frame(&mut app, TICK / 4);
    updates(&mut app, 8);
    assert_eq!(writes(&mut app), 8);
}

#[test]
fn a_still_cloth_is_not_written() {
    let mut app = counting_app();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let cloth = spawn(&mut app, (sheet(), ClothPins::from(PinSelection::Corners)));
    set_frame(&mut app, TICK / 2);
    updates(&mut app, 6);
    writes(&mut app);
    updates(&mut app, 10);
    assert_eq!(writes(&mut app), 0);
    // The entity alone moves.
    app.world_mut().entity_mut(cloth).insert(ClothPins::none());
    updates(&mut app, 4);
    writes(&mut app);
    let before = positions(&app, cloth);
    transform(&mut app, cloth).translation.x += 1.0;
    updates(&mut app, 10);
    assert_eq!(writes(&mut app), 1);
    let shown = drawn_positions(&app, cloth);
    for ((shown, now), before) in shown.iter().zip(positions(&app, cloth)).zip(before) {
        assert!(now.distance(before) < 1e-6 && shown.distance(now) < 1e-5);
    }
}

#[test]
fn what_stops_is_written_to_its_end() {
    let mut app = counting_app();
    let cloth = spawn(&mut app, (sheet(), ClothPins::from(PinSelection::All)));
    app.insert_resource(ClothGravity(Vec3::ZERO));
    updates(&mut app, 3);
    transform(&mut app, cloth).translation.y = 1.0;
    updates(&mut app, 5);
    writes(&mut app);
    updates(&mut app, 5);
    assert_eq!(writes(&mut app), 0);
    let local = attribute(drawn(&app, cloth), Mesh::ATTRIBUTE_POSITION);
    assert!(local.iter().all(|p| p.y.abs() < 1e-6));
}

#[test]
fn frames_between_ticks_show_a_blend() {
    for (interpolation, blends) in
        [(ClothInterpolation::Blend, true), (ClothInterpolation::LastTick, false)]
    {
        let mut app = app();
        let cloth = spawn(&mut app, (sheet(), interpolation));
        updates(&mut app, 10);
        let start = position(&app, cloth, 0);
        app.update();
        let end = position(&app, cloth, 0);
        set_frame(&mut app, TICK / 4);
        for quarter in 1..4 {
            app.update();
            let blend = if blends { quarter as f32 / 4.0 } else { 1.0 };
            let shown = drawn_positions(&app, cloth)[0];
            assert!(shown.distance(start.lerp(end, blend)) < 1e-6, "{quarter}: {shown}");
        }
        assert_eq!(position(&app, cloth, 0), end);
    }
}

#[test]
fn the_picture_is_where_the_particles_are_wherever_the_entity_goes() {
    let mut app = app();
    let place = Transform::from_xyz(100.0, 20.0, -30.0)
        .with_rotation(Quat::from_rotation_x(1.0))
        .with_scale(Vec3::splat(2.0));
    let cloth = (sheet(), place, ClothInterpolation::LastTick);
    let cloth = spawn(&mut app, cloth);
    app.add_systems(Update, |mut cloths: Query<&mut Transform, With<Cloth>>| {
        for mut transform in &mut cloths {
            transform.translation += Vec3::new(0.3, 0.1, 0.0);
            transform.rotate_z(0.1);
        }
    });
    updates(&mut app, 20);
    for (shown, simulated) in drawn_positions(&app, cloth).iter().zip(positions(&app, cloth)) {
        assert!(shown.distance(simulated) < 1e-4);
    }
    let aabb = app.world().get::<Aabb>(cloth).unwrap();
    let local = attribute(drawn(&app, cloth), Mesh::ATTRIBUTE_POSITION);
    let min = local.iter().copied().reduce(Vec3::min).unwrap();
    let max = local.iter().copied().reduce(Vec3::max).unwrap();
    assert!(Vec3::from(aabb.min()).distance(min) < 1e-4);
    assert!(Vec3::from(aabb.max()).distance(max) < 1e-4);
}

#[test]
fn far_from_the_worlds_origin_the_picture_is_as_fine_as_at_it() {
    let shown = [0.0, 16384.0].map(|x| {
        let mut app = app();
        let pins = ClothPins::from(PinSelection::FirstRow);
        let cloth = spawn(&mut app, (sheet(), pins, Transform::from_xyz(x, 0.0, 0.0)));
        updates(&mut app, 40);
        attribute(drawn(&app, cloth), Mesh::ATTRIBUTE_POSITION)
    });
    for (near, far) in shown[0].iter().zip(&shown[1]) {
        // A float has steps of a millimetre there.
        assert!(near.distance(*far) < 2e-3, "{near} {far}");
    }
}

#[test]
fn normals_are_those_of_the_triangles_around() {
    let mut app = app();
    spawn(&mut app, SdfCollider::from(Sphere::new(0.3)));
    let material = ClothMaterial { drag: 0.2, ..default() };
    let cloth = spawn(&mut app, (sheet(), material, Transform::from_xyz(0.0, 0.31, 0.0)));
    updates(&mut app, 40);
    let mesh = drawn(&app, cloth);
    let normals = attribute(mesh, Mesh::ATTRIBUTE_NORMAL);
    let reference =
        attribute(&mesh.clone().with_computed_area_weighted_normals(), Mesh::ATTRIBUTE_NORMAL);
    for (normal, reference) in normals.iter().zip(&reference) {
        assert!((normal.length() - 1.0).abs() < 1e-5);
        // Cells count whole here, by their triangles there: to 0.995.
        assert!(normal.dot(*reference) > 0.99, "{normal} {reference}");
    }
    let tilted = normals.iter().filter(|n| n.y < 0.9).count();
    assert!(tilted > 8, "the cloth is draped");
}

/// How far normals are from those of the surface that the particles are on, at most; `n` a side.
fn normals_off(n: u32, is_grid: bool) -> f64 {
    let mut app = app();
    let place = |i: u32| i as f32 / (n - 1) as f32;
    let height = |x: f32, z: f32| 0.1 * (4.0 * x).sin() * (3.0 * z).cos();
    let on_wave = |r: u32, c: u32| {
        let (x, z) = (place(c), place(r));
        Vec3::new(x, height(x, z), z)
    };
    let mut mesh = grid_mesh(n, n, |v| v, on_wave);
    if !is_grid {
        // Without the last triangle.
        let Some(Indices::U32(indices)) = mesh.indices_mut() else { panic!("it has indices") };
        indices.truncate(indices.len() - 3);
    }
    let mesh = Mesh3d(add_mesh(&mut app, mesh));
    let cloth = spawn(&mut app, (Cloth::of_mesh3d(), mesh, ClothPins::vertices(0..n * n - 1)));
    updates(&mut app, 4);
    let normals = attribute(drawn(&app, cloth), Mesh::ATTRIBUTE_NORMAL);
    // At the border only one side is known.
    let inner = |i: &u32| (1..n - 1).contains(&(i % n)) && (1..n - 1).contains(&(i / n));
    let off = |i: u32| {
        let (x, z) = (f64::from(place(i % n)), f64::from(place(i / n)));
        let slope_x = 0.4 * (4.0 * x).cos() * (3.0 * z).cos();
        let slope_z = -0.3 * (4.0 * x).sin() * (3.0 * z).sin();
        let exact = DVec3::new(-slope_x, 1.0, -slope_z).normalize();
        normals[i as usize].as_dvec3().distance(exact)
    };
    // The corner hangs.
    (0..n * n).filter(inner).filter(|&i| i != (n - 1) * n - 2).map(off).fold(0.0, f64::max)
}

#[test]
fn normals_are_those_of_the_surface_to_second_order() {
    for is_grid in [true, false] {
        let (coarse, fine) = (normals_off(17, is_grid), normals_off(33, is_grid));
        assert!(fine < 2e-3, "grid {is_grid}: {fine}");
        let order = (coarse / fine).log2();
        assert!((order - 2.0).abs() < 0.1, "grid {is_grid}: order {order}, {coarse} and {fine}");
    }
}

#[test]
fn all_else_of_the_mesh_stays() {
    let mut app = app();
    let colors = vec![[0.1, 0.2, 0.3, 1.0]; 20];
    let uvs: Vec<_> = (0..20).map(|i| [i as f32, 0.5]).collect();
    let mesh = grid_mesh(4, 5, |v| 19 - v, |r, c| Vec3::new(c as f32, 0.0, r as f32))
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colors.clone())
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_1, uvs.clone());
    let indices = mesh.indices().cloned();
    let mut mesh = mesh;
    mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
    let mesh = Mesh3d(add_mesh(&mut app, mesh));
    let cloth = spawn(&mut app, (Cloth::of_mesh3d(), mesh));
    updates(&mut app, 10);
    let mesh = drawn(&app, cloth);
    assert_eq!(mesh.indices().cloned(), indices);
    assert_eq!(mesh.count_vertices(), 20);
    let same = |which, values: VertexAttributeValues| {
        assert_eq!(
            mesh.attribute(which).map(VertexAttributeValues::get_bytes),
            Some(values.get_bytes())
        );
    };
    same(Mesh::ATTRIBUTE_COLOR, colors.into());
    same(Mesh::ATTRIBUTE_UV_1, uvs.into());
    assert_eq!(mesh.attributes().count(), 4, "and normals");
    // But it has to stay where it can be written.
    assert_eq!(mesh.asset_usage, RenderAssetUsages::default());
}

#[test]
fn a_mesh_taken_from_under_the_cloth_is_told() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet());
    updates(&mut app, 3);
    let handle = app.world().get::<Mesh3d>(cloth).unwrap().0.clone();
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.get_mut(&handle).unwrap().take_gpu_data().unwrap();
    updates(&mut app, 2);
    let gone = MeshProblem::TakenToGpu;
    assert_eq!(
        failure(&app, cloth),
        Some(ClothError { entity: cloth, kind: ClothErrorKind::Draw(gone) })
    );
    assert_eq!(simulation(&app, cloth).tick_count(), 5);
}

/// A sheet as a mesh that has tangents, slanted to its edges.
fn mesh_with_tangents() -> Mesh {
    let place = |r: u32, c: u32| Vec3::new(c as f32 / 7.0 - 0.5, 0.0, r as f32 / 7.0 - 0.5);
    let tangent = |i| [0.8, 0.0, 0.6, if i < 32 { 1.0 } else { -1.0 }];
    let tangents: Vec<[f32; 4]> = (0..64).map(tangent).collect();
    let mut mesh = grid_mesh(8, 8, |v| v, place);
    mesh.insert_attribute(Mesh::ATTRIBUTE_TANGENT, tangents);
    mesh
}

fn tangents(mesh: &Mesh) -> Vec<Vec4> {
    match mesh.attribute(Mesh::ATTRIBUTE_TANGENT) {
        Some(VertexAttributeValues::Float32x4(values)) => {
            values.iter().map(|v| Vec4::from_array(*v)).collect()
        }
        _ => panic!("it has no tangents"),
    }
}

#[test]
fn tangents_turn_with_the_cloth() {
    let mut app = app();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let mesh = add_mesh(&mut app, mesh_with_tangents());
    let hand = spawn(&mut app, Transform::default());
    let pins = ClothPins::from(PinSelection::All).anchored_to(hand);
    let cloth = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d(mesh), pins));
    updates(&mut app, 3);
    let turn = Quat::from_rotation_z(1.1);
    transform(&mut app, hand).rotation = turn;
    updates(&mut app, 3);
    let drawn = drawn(&app, cloth);
    for (vertex, tangent) in tangents(drawn).into_iter().enumerate() {
        let asked = turn * Vec3::new(0.8, 0.0, 0.6);
        assert!(tangent.truncate().distance(asked) < 1e-5, "{tangent} {asked}");
        assert_eq!(tangent.w, if vertex < 32 { 1.0 } else { -1.0 });
    }
}

#[test]
fn tangents_of_a_cloth_that_hangs_hang_with_it() {
    let mut app = app();
    let mesh = add_mesh(&mut app, mesh_with_tangents());
    let pins = ClothPins::from(PinSelection::FirstRow);
    let material = ClothMaterial { drag: 5.0, ..default() };
    let cloth = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d(mesh), pins, material));
    updates(&mut app, 400);
    let drawn = drawn(&app, cloth);
    let normals = attribute(drawn, Mesh::ATTRIBUTE_NORMAL);
    // What pointed along z, away from the row that is held, points down now.
    let asked = Vec3::new(0.8, -0.6, 0.0);
    for (vertex, (tangent, normal)) in tangents(drawn).into_iter().zip(normals).enumerate() {
        let tangent = tangent.truncate();
        assert!((tangent.length() - 1.0).abs() < 1e-5 && tangent.dot(normal).abs() < 1e-5);
        // The upper rows are bent.
        assert!(vertex < 16 || tangent.distance(asked) < 0.1, "{vertex}: {tangent}");
    }
}

#[test]
fn a_mesh_that_is_changed_starts_its_cloth_anew() {
    let mut app = app();
    let mesh = add_mesh(&mut app, flat_mesh(5, 5));
    let cloth = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d(mesh.clone())));
    let other = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d(mesh.clone())));
    updates(&mut app, 20);
    let before = bits(&app, cloth);
    let change = |app: &mut App, to: Mesh| {
        *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&mesh).unwrap() = to;
        updates(app, 2);
    };
    // Nothing that a cloth is made of.
    change(
        &mut app,
        flat_mesh(5, 5).with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0_f32; 2]; 25]),
    );
    assert_ne!(bits(&app, cloth), before);
    assert_eq!(simulation(&app, cloth).tick_count(), 22);
    change(&mut app, flat_mesh(6, 7));
    for cloth in [cloth, other] {
        assert_eq!(failure(&app, cloth), None);
        assert_eq!(simulation(&app, cloth).particle_count(), 42);
        assert!(simulation(&app, cloth).tick_count() <= 2);
    }
    // What makes no cloth is told of, and the old one goes on until it is mended.
    change(&mut app, Mesh::new(bevy::mesh::PrimitiveTopology::LineList, default()));
    assert!(failure(&app, cloth).is_some());
    assert_eq!(simulation(&app, cloth).particle_count(), 42);
    change(&mut app, flat_mesh(4, 4));
    assert_eq!(failure(&app, cloth), None);
    assert_eq!(simulation(&app, cloth).particle_count(), 16);
    // Once.
    assert_eq!(simulation(&app, cloth).tick_count(), 2);
}

#[test]
fn what_could_not_be_drawn_starts_anew_when_its_simulation_is_removed() {
    let mut app = app();
    let mesh = add_mesh(&mut app, flat_mesh(5, 5));
    let cloth = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d(mesh)));
    updates(&mut app, 2);
    let own = app.world().get::<Mesh3d>(cloth).unwrap().id();
    app.world_mut().resource_mut::<Assets<Mesh>>().remove(own);
    updates(&mut app, 2);
    assert!(matches!(failure(&app, cloth), Some(ClothError { kind: ClothErrorKind::Draw(_), .. })));
    app.world_mut().entity_mut(cloth).remove::<ClothSimulation>();
    updates(&mut app, 2);
    assert_eq!(failure(&app, cloth), None);
    assert_eq!(drawn_positions(&app, cloth).len(), 25);
}
