//! Meshes that are no grids, simplified to be simulated. Truths: counts; edges of about one length; the outline and the hole of the
//! drawn mesh; the rest shape as it was made; where a cloth of all particles hangs; bit equality; and that what cannot be simplified
//! is refused.

#[allow(dead_code, unused_imports)]
mod support;

use bevy::prelude::*;
use bevy_drape::{ClothErrorKind, ClothProxy, ProxyProblem, prelude::*};
use support::app::*;

/// A metre of cloth of 33 x 33 with a hole.
fn holed() -> Mesh {
    mesh_without(33, [15, 11])
}

fn spawned(app: &mut App, mesh: Mesh, proxy: Option<ClothProxy>) -> Entity {
    let mesh = Mesh3d(add_mesh(app, mesh));
    let pins = ClothPins::vertices([0, 32]);
    let cloth = spawn(app, (Cloth::of_mesh3d(), mesh, pins));
    if let Some(proxy) = proxy {
        app.world_mut().entity_mut(cloth).insert(proxy);
    }
    app.update();
    cloth
}

#[test]
fn a_part_of_the_particles_carries_the_whole() {
    let mut app = app();
    for ratio in [0.5, 0.25, 0.1] {
        let mesh = holed();
        let rest = attribute(&mesh, Mesh::ATTRIBUTE_POSITION);
        let cloth = spawned(&mut app, mesh, Some(ClothProxy::ratio(ratio)));
        assert_eq!(failure(&app, cloth), None);
        let running = simulation(&app, cloth);
        let part = running.particle_count() as f32 / rest.len() as f32;
        assert!((part / ratio - 1.0).abs() < 0.25, "{ratio}: {part}");
        assert_eq!(running.pinned().len(), 2);
        // Some of the drawn vertices, the outermost among them.
        let points = running.rest_positions();
        assert!(points.iter().all(|p| rest.iter().any(|r| r.distance(*p) < 1e-6)));
        let outline = |all: &[Vec3]| {
            let around = |(a, b): (Vec3, Vec3), p: &Vec3| (a.min(*p), b.max(*p));
            all.iter().fold((Vec3::MAX, Vec3::MIN), around)
        };
        assert_eq!(outline(points), outline(&rest));
        // Triangles of about one size.
        let graph = running.topology().as_graph().expect("no grid");
        let triangles = graph.triangles();
        let lengths = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let length = |(a, b): (u32, u32)| points[a as usize].distance(points[b as usize]);
        let mut lengths: Vec<_> = lengths.map(length).collect();
        lengths.sort_by(f32::total_cmp);
        let (low, high) = (lengths[lengths.len() / 20], lengths[lengths.len() * 19 / 20]);
        assert!(high < 4.0 * low, "{ratio}: {low} to {high}");
        let off = farthest(&drawn_positions(&app, cloth), &rest);
        assert!(off < 0.01, "{ratio}: {off}");
        app.world_mut().despawn(cloth);
    }
}

#[test]
fn it_hangs_where_the_whole_hangs() {
    let hung = |proxy: Option<ClothProxy>| {
        let mut app = app();
        let cloth = spawned(&mut app, holed(), proxy);
        let drag = ClothMaterial { drag: 3.0, ..default() };
        app.world_mut().entity_mut(cloth).insert(drag);
        updates(&mut app, 64 * 4);
        assert_eq!(failure(&app, cloth), None);
        drawn_positions(&app, cloth)
    };
    let whole = hung(None);
    let part = hung(Some(ClothProxy::ratio(0.25)));
    let square = |(a, b): (&Vec3, &Vec3)| a.distance_squared(*b);
    let rms = (whole.iter().zip(&part).map(square).sum::<f32>() / whole.len() as f32).sqrt();
    assert!(rms < 0.015, "{rms}");
    assert_eq!(part, hung(Some(ClothProxy::ratio(0.25))), "the same bits");
}

#[test]
fn what_cannot_be_simplified_is_refused() {
    let mut app = app();
    let refused = |app: &mut App, mesh, ratio| {
        let cloth = spawned(app, mesh, Some(ClothProxy::ratio(ratio)));
        failure(app, cloth).expect("it is told")
    };
    // Squares that nothing connects: some would be gone.
    let corner = |i: u32| [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::X + Vec3::Z][i as usize % 4] * 0.1;
    let place = |i: u32| corner(i) + Vec3::new((i / 4 % 8) as f32, 0.0, (i / 32) as f32) * 0.2;
    let positions = (0..256).map(|i| place(i).to_array()).collect();
    let indices = (0..64).flat_map(|i| [0, 2, 1, 1, 2, 3].map(|c| 4 * i + c)).collect();
    let error = refused(&mut app, triangle_mesh(positions, indices), 0.1);
    let is = matches!(error.kind, ClothErrorKind::Proxy(ProxyProblem::LostParts { from: 64, .. }));
    assert!(is, "{error}");
    assert!(error.to_string().contains("larger ratio"), "{error}");
    // Walls of rooms: at each edge three of them meet, or four.
    let at = |x: u32, y: u32, z: u32| (z * 5 + y) * 5 + x;
    let positions = (0..125).map(|i| [i % 5, i / 5 % 5, i / 25].map(|c| c as f32 * 0.1)).collect();
    let mut indices = Vec::new();
    for i in 0..125 {
        let (x, y, z) = (i % 5, i / 5 % 5, i / 25);
        let walls = [
            (x < 4 && y < 4, [at(x, y, z), at(x + 1, y, z), at(x, y + 1, z), at(x + 1, y + 1, z)]),
            (y < 4 && z < 4, [at(x, y, z), at(x, y + 1, z), at(x, y, z + 1), at(x, y + 1, z + 1)]),
            (z < 4 && x < 4, [at(x, y, z), at(x, y, z + 1), at(x + 1, y, z), at(x + 1, y, z + 1)]),
        ];
        for (_, [a, b, c, d]) in walls.into_iter().filter(|(is_there, _)| *is_there) {
            indices.extend([a, b, c, b, d, c]);
        }
    }
    let error = refused(&mut app, triangle_mesh(positions, indices), 0.2);
    let is = matches!(error.kind, ClothErrorKind::Proxy(ProxyProblem::TooSimple { .. }));
    assert!(is, "{error}");
    assert!(error.to_string().contains("larger ratio"), "{error}");
}
