//! Which meshes can be baked, and how the others are refused.

use crate::{meshes::*, support::dice::Dice};
use bevy::math::{DVec3, UVec3, Vec3};
use bevy_drape::sdf::{BakeError, BakeSettings, DistanceField, SignedDistance};

/// A mesh that is inside out is turned, and triangles without area change nothing.
#[test]
fn flawed_but_sound_meshes_bake_alike() {
    let plain = box_mesh(DVec3::new(0.4, 0.5, 0.3));
    let expected = bake(&plain, 0.1, 0.2);
    let agree = |mesh: &Mesh, what: &str| {
        let found = bake(mesh, 0.1, 0.2);
        assert_eq!(found.dims(), expected.dims());
        for (a, b) in found.values().iter().zip(expected.values()) {
            assert!((a - b).abs() < 1e-6, "{what}: {a}, not {b}");
        }
    };
    agree(&plain.inside_out(), "inside out");

    let mut spiked = plain.clone();
    let (a, b) = (spiked.indices[0], spiked.indices[1]);
    spiked.indices.extend([a, b, b]);
    agree(&spiked, "an edge as a triangle");

    // Split each edge of the first triangle on its own side only; slivers fill the gaps. The first edge is a
    // knife's: the sign is wrong beside it if one face alone decides.
    let knife = [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 1.0, 0.08], [0.0, 1.0, -0.08]];
    let knife = Mesh {
        positions: knife.map(|p| Vec3::from_array(p) + SHIFT.as_vec3()).to_vec(),
        indices: vec![0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0],
    };
    let whole = bake(&knife, 0.1, 0.2);
    for edge in 0..3 {
        let mut split = knife.clone();
        let t = [0, 1, 2].map(|k| split.indices[(edge + k) % 3]);
        let [a, b] = [t[0], t[1]].map(|i| split.positions[i as usize]);
        let middle = split.positions.len() as u32;
        // A quarter of the way is met in the same bits, wherever the edge runs along an axis.
        split.positions.push(a + 0.25 * (b - a));
        split.indices.drain(0..3);
        split.indices.extend([t[0], middle, t[2], middle, t[1], t[2], t[0], t[1], middle]);
        let found = bake(&split, 0.1, 0.2);
        for (a, b) in found.values().iter().zip(whole.values()) {
            assert!((a - b).abs() < 1e-6, "a sliver at edge {edge}: {a}, not {b}");
        }
    }
}

/// Above a spike the sign is right, however finely one of its sides is cut up: the angles decide, not the
/// number of triangles.
#[test]
fn tips_have_the_right_sign() {
    let side = (0..=20).map(|k| Vec3::new(0.1, 0.0, 0.1 - 0.01 * k as f32));
    let ring: Vec<Vec3> =
        [Vec3::new(-0.1, 0.0, -0.1), Vec3::new(-0.1, 0.0, 0.1)].into_iter().chain(side).collect();
    let count = ring.len() as u32;
    let mut positions: Vec<Vec3> = ring.iter().map(|&p| p + SHIFT.as_vec3()).collect();
    positions.push(Vec3::Y + SHIFT.as_vec3());
    let sides = (0..count).flat_map(|k| [k, (k + 1) % count, count]);
    let floor = (1..count - 1).flat_map(|k| [0, k + 1, k]);
    let mesh = Mesh { positions, indices: sides.chain(floor).collect() };
    let field = bake(&mesh, 0.1, 0.3);
    let dims = field.dims();
    for (place, &found) in (0_u32..).zip(field.values()) {
        let index = UVec3::new(place % dims.x, place / dims.x % dims.y, place / dims.x / dims.y);
        let node = field.node(index).as_dvec3();
        if found.abs() > 1e-5 {
            assert_eq!(found < 0.0, winding(&mesh, node) > 0.5, "{found} at {node}");
        }
    }
}

/// Each flaw is refused by its own error, which says what to do.
#[test]
fn flawed_meshes_are_refused() {
    let sound = box_mesh(DVec3::splat(0.5));
    let settings = BakeSettings { cell_size: 0.1, margin: 0.1 };
    let refusal = |mesh: &Mesh, settings: BakeSettings| {
        DistanceField::bake(&mesh.positions, &mesh.indices, &settings).expect_err("a flaw")
    };
    let expect = |mesh: &Mesh, error: BakeError, hint: &str| {
        let found = refusal(mesh, settings);
        assert_eq!(found, error);
        assert!(found.to_string().contains(hint), "{found}");
    };
    let with = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = sound.clone();
        change(&mut mesh);
        mesh
    };

    let empty = Mesh { positions: Vec::new(), indices: Vec::new() };
    expect(&empty, BakeError::Empty, "no triangles");
    let partial = with(&|m| m.indices.truncate(35));
    expect(&partial, BakeError::PartialTriangle { index_count: 35 }, "triangle list");
    let past = with(&|m| m.indices[4] = 24);
    expect(&past, BakeError::IndexOutOfRange { index: 24, vertex_count: 24 }, "index buffer");
    let infinite = with(&|m| m.positions[3].y = f32::NAN);
    expect(&infinite, BakeError::NonFinite { index: 3 }, "repair");
    let holed = with(&|m| drop(m.indices.drain(0..3)));
    expect(&holed, BakeError::NotClosed { open_edges: 3 }, "fill its holes");
    let turned = with(&|m| m.indices.swap(0, 1));
    expect(&turned, BakeError::Inconsistent { edges: 3 }, "winding");
    let touching = with(&|m| {
        let first = m.positions.len() as u32;
        let step = Vec3::new(1.0, 1.0, 0.0);
        let corner = |p: Vec3| sound.positions.iter().copied().find(|q| q.distance(p) < 1e-4);
        for p in &sound.positions {
            m.positions.push(corner(*p + step).unwrap_or(*p + step));
        }
        m.indices.extend(sound.indices.iter().map(|i| i + first));
    });
    expect(&touching, BakeError::NonManifold { edges: 1 }, "separate");
    let flat = cube(2, |p| DVec3::new(p.x, p.y, 0.0));
    assert!(matches!(
        refusal(&flat, settings),
        BakeError::NoVolume | BakeError::NonManifold { .. }
    ));
    let mut sheet = Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], indices: vec![0, 1, 2] };
    sheet.indices.extend([0, 2, 1]);
    expect(&sheet, BakeError::NoVolume, "thickness");

    for cell_size in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-42, 1e-10, 1e10] {
        let found = refusal(&sound, BakeSettings { cell_size, margin: 0.1 });
        assert!(matches!(found, BakeError::CellSize { .. }), "{found}");
    }
    for margin in [-0.1, f32::NAN, f32::INFINITY] {
        let found = refusal(&sound, BakeSettings { cell_size: 0.1, margin });
        assert!(matches!(found, BakeError::Margin { .. }), "{found}");
    }
    for settings in [
        BakeSettings { cell_size: 1e-4, margin: 0.1 },
        BakeSettings { cell_size: 1e-9, margin: f32::MAX },
    ] {
        let found = refusal(&sound, settings);
        assert!(matches!(found, BakeError::TooLarge { .. }), "{found}");
        assert!(found.to_string().contains("larger cells"), "{found}");
    }
    let nowhere = BakeSettings::for_mesh(&[], 32);
    assert_eq!(refusal(&empty, nowhere), BakeError::Empty);
}

/// Cells as small and as large as may be still have their normals, and distances without overflow.
#[test]
fn fields_of_any_allowed_size_work() {
    for scale in [0.9e-8, 0.89e10] {
        let mut mesh = sphere_mesh(6, 0.5);
        for p in &mut mesh.positions {
            *p = (*p - SHIFT.as_vec3()) * scale;
        }
        let field = bake(&mesh, 0.112 * scale, 0.25 * scale);
        let mut random = Dice(12);
        for _ in 0..500 {
            let direction = random.direction();
            let share = random.between(0.2, 3.0);
            let found = field.sample((direction * share).as_vec3() * scale);
            assert!((found.normal.as_dvec3() - direction).length() < 0.3, "{found:?}");
            let error = f64::from(found.distance / scale) - (share - 0.5);
            assert!(error < 0.05 && (share > 0.7 || error > -0.05), "{found:?} at {share}");
        }
        assert_eq!(DistanceField::from_bytes(&field.to_bytes()), Ok(field));
    }
}
