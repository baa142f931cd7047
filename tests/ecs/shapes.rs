//! Closed, wrapped and irregular meshes as cloths: they come in whole, hang, and do not split.
//!
//! Truths: Euler's formula (a closed surface of genus 0 has F = 2 V - 4 triangles, a torus F = 2 V);
//! that vertices which coincided coincide; the mesh's own normals; the strain limit.

use crate::support::app::*;
use bevy::{math::ops, mesh::VertexAttributeValues, prelude::*};
use bevy_drape::{
    ClothErrorKind, ClothIntake, ClothInterpolation, ClothSleepThreshold, MeshProblem,
    prelude::*,
    solver::{Substeps, Topology},
};
use std::sync::Arc;

fn intake(app: &App, entity: Entity) -> ClothIntake {
    assert_eq!(failure(app, entity), None);
    simulation(app, entity).intake().expect("it comes from a mesh").clone()
}

fn spawn_mesh(app: &mut App, mesh: &Mesh, more: impl Bundle) -> Entity {
    let handle = Mesh3d(add_mesh(app, mesh.clone()));
    spawn(app, (Cloth::of_mesh3d(), handle, ClothInterpolation::LastTick, more))
}

/// Pins whatever is at most `depth` below the highest vertex.
fn top(mesh: &Mesh, depth: f32) -> ClothPins {
    let positions = attribute(mesh, Mesh::ATTRIBUTE_POSITION);
    let highest = positions.iter().map(|p| p.y).fold(f32::NEG_INFINITY, f32::max);
    ClothPins::within(Vec3::new(-9.0, highest - depth, -9.0), Vec3::splat(9.0))
}

/// Pairs of vertices that coincide.
fn coincident(mesh: &Mesh) -> Vec<(usize, usize)> {
    let positions = attribute(mesh, Mesh::ATTRIBUTE_POSITION);
    let pairs = (0..positions.len()).flat_map(|a| (0..a).map(move |b| (b, a)));
    pairs.filter(|&(a, b)| positions[a].distance(positions[b]) < 1e-6).collect()
}

/// Bevy's own meshes, and F - 2 V of each.
fn primitives() -> Vec<(&'static str, Mesh, i64)> {
    let torus = Torus { minor_radius: 0.2, major_radius: 0.5 };
    vec![
        ("uv sphere", Sphere::new(0.5).mesh().uv(24, 16), -4),
        ("ico sphere", Sphere::new(0.5).mesh().ico(4).unwrap(), -4),
        ("cylinder", Cylinder::new(0.4, 1.0).mesh().resolution(24).segments(8).build(), -4),
        ("capsule", Capsule3d::new(0.3, 0.6).mesh().longitudes(20).latitudes(10).build(), -4),
        ("torus", torus.mesh().major_resolution(32).minor_resolution(12).build(), 0),
        ("cuboid", Cuboid::new(1.0, 0.6, 0.8).mesh().build(), -4),
    ]
}

#[test]
fn bevys_own_meshes_come_in_whole() {
    for (what, mesh, difference) in primitives() {
        let mut app = app();
        let entity = spawn_mesh(&mut app, &mesh, ());
        app.update();
        let intake = intake(&app, entity);
        assert_eq!(intake.skipped.total(), 0, "{what}");
        assert_eq!((intake.pieces, intake.crowded_edges, intake.unused_vertices), (1, 0, 0));
        assert_eq!(intake.triangles as i64 - 2 * intake.particles as i64, difference, "{what}");
        assert!(intake.grid.is_err(), "{what}");
        assert_eq!(intake.welded_vertices() > 0, what != "ico sphere", "{what}");
        if what == "cuboid" {
            assert_eq!((intake.vertices, intake.particles), (24, 8));
        }
    }
}

#[test]
fn normals_are_smooth_over_seams_and_split_at_hard_edges() {
    for (what, mesh, _) in primitives() {
        let mut app = app();
        app.insert_resource(ClothGravity(Vec3::ZERO));
        let entity = spawn_mesh(&mut app, &mesh, ());
        app.update();
        let before = attribute(&mesh, Mesh::ATTRIBUTE_NORMAL);
        let now = attribute(drawn(&app, entity), Mesh::ATTRIBUTE_NORMAL);
        for (vertex, (now, before)) in now.iter().zip(&before).enumerate() {
            // Coarse triangles are not quite the curved surface.
            assert!(now.dot(*before) > 0.99, "{what}, vertex {vertex}: {now} {before}");
        }
        let (mut seams, mut edges) = (0, 0);
        for (a, b) in coincident(&mesh) {
            if before[a].dot(before[b]) > 0.999 {
                assert_eq!(now[a], now[b], "{what}");
                seams += 1;
            } else {
                edges += 1;
            }
        }
        let hard = ["cylinder", "cuboid"].contains(&what);
        let seamless = ["cuboid", "ico sphere"].contains(&what);
        assert_eq!((edges > 0, seams > 0), (hard, !seamless), "{what}");
    }
}

/// Hangs a mesh for some ticks, with at most so many substeps in 1/60 s, and checks that it stays
/// whole.
#[track_caller]
fn hang(what: &str, mesh: &Mesh, pins: ClothPins, ticks: usize, budget: u32) {
    let mut app = app();
    // Aslant, so that what stands upright in its plane moves too.
    app.insert_resource(ClothGravity(Vec3::new(2.0, -9.3, 2.0)));
    // Braked, so that it is nearly at rest in the end.
    let material = ClothMaterial { drag: 3.0, ..default() };
    let settings = ClothSettings { substeps: Substeps::Automatic { budget }, ..default() };
    // Nor asleep: it is looked at after so many ticks.
    let entity = spawn_mesh(&mut app, mesh, (pins, material, settings, ClothSleepThreshold::NEVER));
    wait(&mut app, |app| app.world().get::<ClothSimulation>(entity).is_some());
    let gone = simulation(&app, entity).tick_count() as usize;
    updates(&mut app, ticks - gone);
    assert_eq!(failure(&app, entity), None, "{what}");
    let running = simulation(&app, entity);
    assert_eq!(running.tick_count(), ticks as u64);
    assert!(!running.pinned().is_empty() && running.pinned().len() < running.particle_count());
    let rest = attribute(mesh, Mesh::ATTRIBUTE_POSITION);
    let shown = attribute(drawn(&app, entity), Mesh::ATTRIBUTE_POSITION);
    let normals = attribute(drawn(&app, entity), Mesh::ATTRIBUTE_NORMAL);
    assert!(shown.iter().all(|p| p.is_finite() && p.length() < 3.0), "{what}");
    assert!(normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5), "{what}");
    if rest.len() < 2000 {
        for (a, b) in coincident(mesh) {
            assert_eq!(shown[a], shown[b], "{what}: a seam opens");
        }
    }
    for &pinned in running.pinned() {
        let pinned = pinned as usize;
        let off = position(&app, entity, pinned).distance(running.rest_positions()[pinned]);
        assert!(off < 1e-5, "{what}: a pin slips");
    }
    let moved = shown.iter().zip(&rest).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(moved > 1e-3, "{what}: nothing moves");
    // Edges as they are drawn, not as the solver counts them, against its limit of 10 %.
    let mut longest = 0.0_f32;
    let indices: Vec<_> = mesh.indices().unwrap().iter().collect();
    for &[a, b, c] in indices.as_chunks::<3>().0 {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            let length = rest[a].distance(rest[b]);
            if length > 1e-4 {
                longest = longest.max(shown[a].distance(shown[b]) / length - 1.0);
            }
        }
    }
    assert!(longest < 0.105, "{what}: an edge is stretched by {longest}");
}

#[test]
fn bevys_own_meshes_hang_and_stay_whole() {
    for (what, mesh, _) in primitives() {
        hang(what, &mesh, top(&mesh, 0.05), 120, 20);
    }
}

/// A number from -1 to 1.
fn noise(seed: u32) -> f32 {
    let mixed = (seed ^ (seed >> 15)).wrapping_mul(0x2C1B_3C6D);
    let mixed = (mixed ^ (mixed >> 12)).wrapping_mul(0x297A_2D39);
    ((mixed ^ (mixed >> 15)) >> 8) as f32 / (1 << 23) as f32 - 1.0
}

/// A disc of rings with six vertices more each, jittered, its vertices in shuffled order: 6 n^2
/// triangles. It stands upright.
fn irregular_disc(rings: u32) -> Mesh {
    let count = 1 + 3 * rings * (rings + 1);
    let name = |v: u32| (v as u64 * 7919 % count as u64) as u32;
    let first = |ring: u32| if ring == 0 { 0 } else { 1 + 3 * ring * (ring - 1) };
    let vertex =
        |ring: u32, at: u32| name(first(ring) + if ring == 0 { 0 } else { at % (6 * ring) });
    let mut positions = vec![[0.0; 3]; count as usize];
    for ring in 0..=rings {
        for at in 0..(6 * ring).max(1) {
            let v = vertex(ring, at);
            let jitter = if ring == rings { 0.0 } else { 0.2 };
            let radius = (ring as f32 + jitter * noise(v)) / rings as f32;
            let angle = (at as f32 + jitter * noise(v + count)) / (6 * ring).max(1) as f32;
            let angle = angle * core::f32::consts::TAU;
            positions[v as usize] = [radius * ops::sin(angle), radius * ops::cos(angle), 0.0];
        }
    }
    let mut indices = Vec::new();
    for ring in 1..=rings {
        for side in 0..6 {
            for step in 0..ring {
                let (outer, inner) = (side * ring + step, side * (ring - 1) + step);
                let corners = [vertex(ring, outer), vertex(ring, outer + 1)];
                indices.extend([vertex(ring - 1, inner), corners[1], corners[0]]);
                if step + 1 < ring {
                    let next = vertex(ring - 1, inner + 1);
                    indices.extend([vertex(ring - 1, inner), next, corners[1]]);
                }
            }
        }
    }
    triangle_mesh(positions, indices)
}

#[test]
fn an_irregular_mesh_of_20_000_triangles_hangs() {
    let mesh = irregular_disc(58);
    let mut app = app();
    let entity = spawn_mesh(&mut app, &mesh, ());
    wait(&mut app, |app| app.world().get::<ClothSimulation>(entity).is_some());
    let intake = intake(&app, entity);
    assert_eq!((intake.triangles, intake.skipped.total()), (6 * 58 * 58, 0));
    assert_eq!(intake.vertices, intake.particles);
    assert!(intake.grid.is_err());
    // Where the rim leaves the pins, single edges carry so much that the usual 20 do not hold them.
    hang("irregular disc", &mesh, top(&mesh, 0.2), 64, 60);
}

#[test]
fn a_large_mesh_is_set_up_in_the_background() {
    let mesh = irregular_disc(58);
    let mut app = app();
    let [one, other, gone] = [(); 3].map(|()| spawn_mesh(&mut app, &mesh, ()));
    let is_there = |app: &App, entity| app.world().get::<ClothSimulation>(entity).is_some();
    app.update();
    assert!(![one, other, gone].into_iter().any(|entity| is_there(&app, entity)));
    app.world_mut().despawn(gone);
    wait(&mut app, |app| is_there(app, one));
    // Equal meshes share what was made, and so are there together.
    let [one, other] = [one, other].map(|entity| simulation(&app, entity).topology());
    let (Topology::Graph(one), Topology::Graph(other)) = (one, other) else {
        panic!("a disc is no grid");
    };
    assert!(Arc::ptr_eq(one, other));
}

#[test]
fn a_large_mesh_is_set_up_whatever_else_is_wrong_with_its_entity() {
    let mut app = app();
    let bad = SdfCollider::new(Sphere::new(0.1)).with_friction(f32::NAN);
    let entity = spawn_mesh(&mut app, &irregular_disc(58), (bad, Transform::default()));
    wait(&mut app, |app| app.world().get::<ClothSimulation>(entity).is_some());
    assert!(failure(&app, entity).is_some());
}

#[test]
fn a_large_mesh_that_is_no_cloth_is_refused_all_the_same() {
    let mut mesh = irregular_disc(58);
    let mut positions = attribute(&mesh, Mesh::ATTRIBUTE_POSITION);
    positions[3].x = f32::NAN;
    let positions: Vec<_> = positions.iter().map(Vec3::to_array).collect();
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    let mut app = app();
    let entity = spawn_mesh(&mut app, &mesh, ());
    wait(&mut app, |app| failure(app, entity).is_some());
    let ClothErrorKind::Mesh(problem) = failure(&app, entity).unwrap().kind else {
        panic!("of the mesh")
    };
    assert!(matches!(problem, MeshProblem::NonFinite(3)), "{problem}");
}

/// A tube with two sleeves: wherever a hole is cut into it, the hole's border is carried outwards.
fn shirt() -> Mesh {
    let (columns, rows, cuff) = (32_u32, 18_u32, 10_u32);
    let around = |c: u32| (c % columns) as f32 / columns as f32 * core::f32::consts::TAU;
    let place = |r: u32, c: u32| {
        let (angle, y) = (around(c), 0.9 - r as f32 * 0.05);
        [0.3 * ops::cos(angle), y, 0.2 * ops::sin(angle)]
    };
    let name = |r: u32, c: u32| r * columns + c % columns;
    let mut positions: Vec<_> =
        (0..rows).flat_map(|r| (0..columns).map(move |c| place(r, c))).collect();
    let mut indices = Vec::new();
    let mut quad = |[a, b, c, d]: [u32; 4]| indices.extend([a, b, c, c, b, d]);
    // Holes of 4 x 4 cells at +x and -x.
    let sides = [columns - 2, columns / 2 - 2];
    let in_hole = |r: u32, c: u32| {
        (2..6).contains(&r) && sides.iter().any(|s| (c + columns - s) % columns < 4)
    };
    for r in 0..rows - 1 {
        for c in 0..columns {
            if !in_hole(r, c) {
                quad([name(r, c), name(r + 1, c), name(r, c + 1), name(r + 1, c + 1)]);
            }
        }
    }
    for (side, out) in sides.into_iter().zip([1.0, -1.0]) {
        let border = (0..4)
            .map(|i| name(2, side + i))
            .chain((0..4).map(|i| name(2 + i, side + 4)))
            .chain((0..4).map(|i| name(6, side + 4 - i)))
            .chain((0..4).map(|i| name(6 - i, side)));
        let mut ring: Vec<_> = border.collect();
        for _ in 0..cuff {
            let next: Vec<_> = (0..16).map(|i| positions.len() as u32 + i).collect();
            for &vertex in &ring {
                let [x, y, z] = positions[vertex as usize];
                positions.push([x + out * 0.05, y - 0.01, z]);
            }
            for i in 0..16 {
                quad([ring[i], ring[(i + 1) % 16], next[i], next[(i + 1) % 16]]);
            }
            ring = next;
        }
    }
    triangle_mesh(positions, indices)
}

#[test]
fn a_shirt_of_tubes_hangs_from_its_collar() {
    let mesh = shirt();
    let mut app = app();
    let entity = spawn_mesh(&mut app, &mesh, ());
    app.update();
    let intake = intake(&app, entity);
    assert_eq!((intake.pieces, intake.crowded_edges, intake.skipped.total()), (1, 0, 0));
    // A sphere with four holes: V - E + F = -2, and 3 F = 2 E - B edges of the border.
    let border = 2 * 32 + 2 * 16;
    let (v, f) = (intake.particles as i64, intake.triangles as i64);
    assert_eq!(2 * v - f - border, -4);
    hang("shirt", &mesh, top(&mesh, 0.01), 120, 20);
}

#[test]
fn a_book_of_pages_hangs_although_three_triangles_meet_at_its_spine() {
    // Three grids of 6 x 8 that share their first column.
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    for page in 0..3_u32 {
        let angle = page as f32 * 2.1;
        for i in 0..48 {
            let (along, out) = ((i / 8) as f32 * 0.1, (i % 8) as f32 * 0.1);
            positions.push([out * ops::cos(angle), -along, out * ops::sin(angle)]);
        }
        for cell in 0..35_u32 {
            let a = page * 48 + cell / 7 * 8 + cell % 7;
            indices.extend([a, a + 8, a + 1, a + 1, a + 8, a + 9]);
        }
    }
    let mesh = triangle_mesh(positions, indices);
    let mut app = app();
    let entity = spawn_mesh(&mut app, &mesh, ());
    app.update();
    let intake = intake(&app, entity);
    assert_eq!((intake.particles, intake.pieces, intake.crowded_edges), (6 + 3 * 42, 1, 5));
    hang("book", &mesh, top(&mesh, 0.01), 120, 20);
}

#[test]
fn what_is_no_part_of_the_cloth_is_drawn_with_it() {
    // A sphere with a spare vertex, and a triangle on a line.
    let mut mesh = Sphere::new(0.5).mesh().uv(16, 12);
    for (which, value) in [
        (Mesh::ATTRIBUTE_POSITION, [5.0, 5.0, 5.0]),
        (Mesh::ATTRIBUTE_NORMAL, [f32::NAN, 0.0, 0.0]),
    ] {
        let Some(VertexAttributeValues::Float32x3(values)) = mesh.attribute_mut(which) else {
            panic!("it has them")
        };
        values.push(value);
    }
    mesh.remove_attribute(Mesh::ATTRIBUTE_UV_0);
    let mut app = app();
    let entity = spawn_mesh(&mut app, &mesh, top(&mesh, 9.0));
    updates(&mut app, 3);
    assert_eq!(intake(&app, entity).unused_vertices, 1);
    let last = mesh.count_vertices() - 1;
    let shown = attribute(drawn(&app, entity), Mesh::ATTRIBUTE_POSITION)[last];
    assert_eq!(shown, position(&app, entity, 0));
    let normals = attribute(drawn(&app, entity), Mesh::ATTRIBUTE_NORMAL);
    assert!(normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
}
