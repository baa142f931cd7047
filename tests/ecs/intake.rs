//! Any mesh comes in, or is told why not.
//!
//! Truths: counts made by hand; the places of welded vertices; the source mesh's own data; that
//! what is refused is told to its entity alone.

use crate::support::app::*;
use bevy::{
    asset::RenderAssetUsages,
    mesh::{
        Indices, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues,
        skinning::SkinnedMesh,
    },
    prelude::*,
};
use bevy_drape::{
    ClothError, ClothErrorKind, ClothIntake, ClothInterpolation, ClothWeights, ColorChannel,
    GridProblem, MeshProblem, PinProblem, SkippedTriangles, VertexFactor, WeightProblem,
    prelude::*, solver::MassLumping,
};

/// The error of a cloth of this mesh. It names the entity, and another cloth goes on.
fn refused(mesh: Mesh) -> MeshProblem {
    let mut app = app();
    let mesh = Mesh3d(add_mesh(&mut app, mesh));
    let entity = spawn(&mut app, (Cloth::of_mesh3d(), mesh));
    let good = spawn(&mut app, sheet());
    updates(&mut app, 3);
    let error = failure(&app, entity).expect("it is refused");
    assert!(error.to_string().contains(&entity.to_string()), "{error}");
    assert_eq!(failure(&app, good), None);
    assert!(simulation(&app, good).tick_count() > 0);
    assert!(app.world().get::<ClothSimulation>(entity).is_none());
    match error {
        ClothError { kind: ClothErrorKind::Mesh(problem), .. } => problem,
        other => panic!("{other}"),
    }
}

/// A cloth of a mesh, after its first frame.
fn taken_in(app: &mut App, mesh: Mesh, more: impl Bundle) -> Entity {
    let mesh = Mesh3d(add_mesh(app, mesh));
    let entity = spawn(app, (Cloth::of_mesh3d(), mesh, more));
    app.update();
    entity
}

fn intake(app: &App, entity: Entity) -> ClothIntake {
    assert_eq!(failure(app, entity), None);
    simulation(app, entity).intake().expect("it comes from a mesh").clone()
}

fn bare(topology: PrimitiveTopology) -> Mesh {
    Mesh::new(topology, RenderAssetUsages::default())
}

#[test]
fn meshes_that_are_no_cloth_are_told_why() {
    let corners = || vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let with = |positions: Vec<[f32; 3]>, indices: Vec<u32>| triangle_mesh(positions, indices);
    let taken = || {
        let mut mesh = flat_mesh(3, 3);
        mesh.take_gpu_data().unwrap();
        mesh
    };
    let without_positions = || {
        let mut mesh = flat_mesh(3, 3);
        mesh.remove_attribute(Mesh::ATTRIBUTE_POSITION);
        mesh
    };
    let far = |x: f32| {
        let mut positions = corners();
        positions[2][0] = x;
        with(positions, vec![0, 1, 2, 1, 3, 2])
    };
    let lines = || {
        bare(PrimitiveTopology::LineStrip)
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners())
    };
    let soup = |count: usize| {
        bare(PrimitiveTopology::TriangleList)
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0, 1.0, 0.0]; count])
    };
    let line: Vec<_> = (0..4).map(|i| [i as f32, 2.0 * i as f32, 0.0]).collect();
    for (what, mesh, expected) in [
        ("nothing at all", bare(PrimitiveTopology::TriangleList), MeshProblem::NoPositions),
        ("no positions", without_positions(), MeshProblem::NoPositions),
        ("taken", taken(), MeshProblem::TakenToGpu),
        ("lines", lines(), MeshProblem::NotTriangles),
        ("no vertices", with(vec![], vec![]), MeshProblem::Empty),
        ("isolated vertices alone", with(corners(), vec![]), MeshProblem::Empty),
        ("NaN", far(f32::NAN), MeshProblem::NonFinite(2)),
        ("infinite", far(f32::NEG_INFINITY), MeshProblem::NonFinite(2)),
        ("huge", far(1e30), MeshProblem::NonFinite(2)),
        ("loose indices", with(corners(), vec![0, 1, 2, 1]), MeshProblem::LooseIndices(4)),
        ("loose corners", soup(4), MeshProblem::LooseIndices(4)),
        (
            "an index too high",
            with(corners(), vec![0, 1, 2, 1, 4, 2]),
            MeshProblem::BadIndex { index: 4, vertices: 4 },
        ),
        ("one triangle", with(corners(), vec![0, 1, 2]), MeshProblem::OneTriangle { skipped: 0 }),
        (
            "one triangle, often",
            with(corners(), vec![0, 1, 2, 2, 1, 0, 1, 1, 3]),
            MeshProblem::OneTriangle { skipped: 2 },
        ),
        (
            "repeated corners",
            with(corners(), vec![0, 0, 1, 2, 3, 2]),
            MeshProblem::AllDegenerate { triangles: 2 },
        ),
        ("one place", soup(6), MeshProblem::AllDegenerate { triangles: 2 }),
        ("a line", with(line, vec![0, 1, 2, 1, 3, 2]), MeshProblem::AllDegenerate { triangles: 2 }),
    ] {
        let problem = refused(mesh);
        assert_eq!(problem, expected, "{what}");
        assert!(problem.to_string().len() > 20, "{what}");
    }
}

#[test]
fn what_loads_late_is_waited_for_and_what_fails_to_load_is_told() {
    let mut app = app();
    let never = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let waiting = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d(never)));
    let missing = app.world().resource::<AssetServer>().load("no such file.mesh");
    let failing = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d(missing)));
    let failed = |app: &App| failure(app, failing).is_some();
    for _ in 0..2000 {
        if failed(&app) {
            break;
        }
        app.update();
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert!(matches!(
        failure(&app, failing),
        Some(ClothError { kind: ClothErrorKind::Mesh(MeshProblem::LoadFailed(_)), .. })
    ));
    assert!(matches!(
        failure(&app, waiting),
        Some(ClothError { kind: ClothErrorKind::Mesh(MeshProblem::Missing), .. })
    ));
    assert!(app.world().get::<ClothSimulation>(waiting).is_none());
}

#[test]
fn what_can_be_skipped_is_skipped_and_counted() {
    // Two by two cells, an isolated vertex, and four triangles that are none.
    let mut mesh = flat_mesh(3, 3);
    let mut positions: Vec<_> =
        attribute(&mesh, Mesh::ATTRIBUTE_POSITION).iter().map(Vec3::to_array).collect();
    positions.extend([[0.5, 0.0, 0.0], [9.0, 9.0, 9.0], [0.0, 0.0, 0.0]]);
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    let Some(Indices::U32(indices)) = mesh.indices_mut() else { panic!("it has indices") };
    // On a line, with a corner twice, a welded corner twice, and the first triangle from behind.
    indices.extend([0, 9, 1, 4, 4, 5, 0, 11, 4]);
    let first = [indices[2], indices[1], indices[0]];
    indices.extend(first);
    let mut app = app();
    let entity = taken_in(&mut app, mesh, ClothInterpolation::LastTick);
    let expected = ClothIntake {
        vertices: 12,
        particles: 9,
        unused_vertices: 2,
        triangles: 8,
        skipped: SkippedTriangles { collapsed: 2, zero_area: 1, duplicate: 1 },
        crowded_edges: 0,
        pieces: 1,
        grid: Ok(UVec2::splat(3)),
    };
    assert_eq!(intake(&app, entity), expected);
    assert_eq!(expected.welded_vertices(), 1);
    let running = simulation(&app, entity);
    assert_eq!(running.particle_of_vertex(11), running.particle_of_vertex(0));
    assert_eq!([9, 10, 12].map(|v| running.particle_of_vertex(v)), [None; 3]);
    updates(&mut app, 30);
    let shown = attribute(drawn(&app, entity), Mesh::ATTRIBUTE_POSITION);
    // The vertex on the line goes with the nearer end, the isolated one with the first particle.
    assert!(shown[9] == shown[0] || shown[9] == shown[1]);
    assert_eq!((shown[10], shown[11]), (position(&app, entity, 0), shown[0]));
    let normals = attribute(drawn(&app, entity), Mesh::ATTRIBUTE_NORMAL);
    assert!(normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
}

#[test]
fn lists_without_indices_and_strips_are_cloths() {
    let mut list = flat_mesh(4, 5);
    list.duplicate_vertices();
    let place = |i: u32| [(i / 2) as f32, 0.0, (i % 2) as f32];
    let strip = bare(PrimitiveTopology::TriangleStrip)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, (0..8).map(place).collect::<Vec<_>>());
    for (mesh, vertices, grid) in [(list, 72, UVec2::new(5, 4)), (strip, 8, UVec2::new(4, 2))] {
        let mut app = app();
        let entity = taken_in(&mut app, mesh, ());
        let intake = intake(&app, entity);
        let sides = |grid: UVec2| (grid.min_element(), grid.max_element());
        assert_eq!(intake.grid.map(sides), Ok(sides(grid)));
        assert_eq!(intake.vertices, vertices);
        updates(&mut app, 10);
        assert_eq!(drawn(&app, entity).count_vertices(), vertices);
        assert!(drawn_positions(&app, entity).iter().all(|p| p.y < -0.01));
    }
}

/// A grid as glTF files have it: small indices, all usual attributes, a UV seam through the middle.
fn like_gltf(wide: bool) -> Mesh {
    let (rows, columns) = (5_u16, 9_u16);
    let seam = |c: u16| u16::from(c > 4);
    // Columns 0 to 4, and 4 to 8 again on the other side of the seam.
    let index = |r: u16, c: u16, right: bool| r * (columns + 1) + c + u16::from(right);
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    for r in 0..rows {
        for c in (0..=4).chain(4..columns) {
            positions.push([f32::from(c) * 0.1, -f32::from(r) * 0.1, 0.0]);
        }
        for c in 0..columns - 1 {
            let right = seam(c + 1) == 1;
            if r + 1 < rows {
                let (a, b) = (index(r, c, right), index(r, c + 1, right));
                let (d, e) = (index(r + 1, c, right), index(r + 1, c + 1, right));
                indices.extend([a, d, b, b, d, e]);
            }
        }
    }
    let count = positions.len();
    let indices = if wide {
        Indices::U32(indices.into_iter().map(u32::from).collect())
    } else {
        Indices::U16(indices)
    };
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; count])
        .with_inserted_attribute(Mesh::ATTRIBUTE_TANGENT, vec![[1.0, 0.0, 0.0, 1.0]; count])
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.25, 0.75]; count])
        .with_inserted_indices(indices)
}

#[test]
fn cloth_of_a_gltf_scene_works_as_loaded() {
    for wide in [false, true] {
        let mut app = app();
        let scene = Transform::from_xyz(1.0, 2.0, 3.0).with_scale(Vec3::splat(2.0));
        let scene = spawn(&mut app, (scene, Visibility::default()));
        let node = Transform::from_rotation(Quat::from_rotation_y(0.5));
        let mesh = add_mesh(&mut app, like_gltf(wide));
        // The scene is there first; the game finds the node and makes it cloth.
        let node = spawn(&mut app, (Mesh3d(mesh.clone()), node, ChildOf(scene)));
        app.update();
        let pins = ClothPins::vertices(0..10);
        app.world_mut().entity_mut(node).insert((Cloth::of_mesh3d(), pins));
        app.update();
        let told = intake(&app, node);
        assert_eq!((told.vertices, told.particles, told.welded_vertices()), (50, 45, 5));
        assert!(told.grid.is_ok());
        updates(&mut app, 60);
        let (before, now) = (like_gltf(wide), drawn(&app, node));
        let shown = attribute(now, Mesh::ATTRIBUTE_POSITION);
        let normals = attribute(now, Mesh::ATTRIBUTE_NORMAL);
        for row in 0..5 {
            let (left, right) = (row * 10 + 4, row * 10 + 5);
            assert_eq!((shown[left], normals[left]), (shown[right], normals[right]));
        }
        let rest = attribute(&before, Mesh::ATTRIBUTE_POSITION);
        assert!((0..10).all(|i| shown[i].distance(rest[i]) < 1e-5), "it hangs where it was");
        assert!((0..50).all(|i| shown[i].distance(rest[i]) < 0.1));
        assert!(normals.iter().all(|n| n.z > 0.5));
        assert_eq!(now.indices(), before.indices());
        let bytes =
            |mesh: &Mesh| mesh.attribute(Mesh::ATTRIBUTE_UV_0).unwrap().get_bytes().to_vec();
        assert_eq!(bytes(now), bytes(&before));
        // Tangents turn with the cloth, which has hardly moved.
        let tangents = |mesh: &Mesh| match mesh.attribute(Mesh::ATTRIBUTE_TANGENT) {
            Some(VertexAttributeValues::Float32x4(values)) => values.clone(),
            _ => panic!("it has tangents"),
        };
        for (now, before) in tangents(now).into_iter().zip(tangents(&before)) {
            assert!(Vec4::from(now).distance(Vec4::from(before)) < 0.1, "{now:?} {before:?}");
        }
        let asset = app.world().resource::<Assets<Mesh>>().get(&mesh).unwrap();
        assert_eq!(attribute(asset, Mesh::ATTRIBUTE_POSITION), rest);
    }
}

#[test]
fn mirrored_and_uneven_gltf_nodes_are_told() {
    for scale in [Vec3::new(-1.0, 1.0, 1.0), Vec3::splat(-1.0), Vec3::new(1.0, 2.0, 1.0)] {
        let mut app = app();
        let scene = spawn(&mut app, Transform::from_scale(scale));
        let mesh = Mesh3d(add_mesh(&mut app, like_gltf(false)));
        let node = spawn(&mut app, (mesh, Cloth::of_mesh3d(), ChildOf(scene)));
        updates(&mut app, 2);
        let error = failure(&app, node);
        assert!(
            matches!(error, Some(ClothError { kind: ClothErrorKind::Scale(_), .. })),
            "{scale}: {error:?}"
        );
        transform(&mut app, scene).scale = Vec3::ONE;
        updates(&mut app, 2);
        assert_eq!(failure(&app, node), None);
        assert!(simulation(&app, node).tick_count() > 0);
    }
}

#[test]
fn a_skinned_mesh_is_told_until_it_is_skinned_no_more() {
    let mut app = app();
    let joints = VertexAttributeValues::Uint16x4(vec![[0; 4]; 50]);
    let mesh = like_gltf(false)
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints)
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[1.0, 0.0, 0.0, 0.0]; 50]);
    let entity = taken_in(&mut app, mesh, SkinnedMesh::default());
    assert!(matches!(
        failure(&app, entity),
        Some(ClothError { kind: ClothErrorKind::Mesh(MeshProblem::Skinned), .. })
    ));
    app.world_mut().entity_mut(entity).remove::<SkinnedMesh>();
    updates(&mut app, 2);
    assert_eq!(intake(&app, entity).particles, 45);
    // No joints are left to follow.
    assert!(!drawn(&app, entity).contains_attribute(Mesh::ATTRIBUTE_JOINT_INDEX));
}

#[test]
fn equal_meshes_share_their_rest_shape_as_long_as_it_is_in_use() {
    let mut app = app();
    let handle = add_mesh(&mut app, like_gltf(false));
    let other = add_mesh(&mut app, like_gltf(false));
    let spawn_at = |app: &mut App, handle: &Handle<Mesh>, x: f32, scale: f32| {
        let place = Transform::from_xyz(x, 0.0, 0.0).with_scale(Vec3::splat(scale));
        spawn(app, (Cloth::of_mesh3d(), Mesh3d(handle.clone()), place))
    };
    let cloths = [
        spawn_at(&mut app, &handle, 0.0, 1.0),
        spawn_at(&mut app, &handle, 2.0, 1.0),
        spawn_at(&mut app, &other, 4.0, 1.0),
        spawn_at(&mut app, &handle, 6.0, 2.0),
    ];
    app.update();
    let rest = |app: &App, i: usize| simulation(app, cloths[i]).rest_positions().as_ptr();
    assert_eq!(rest(&app, 0), rest(&app, 1));
    assert_eq!(rest(&app, 0), rest(&app, 2));
    assert_ne!(rest(&app, 0), rest(&app, 3));
    // The asset is changed in place: what is spawned now is another cloth.
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let mut mesh = meshes.get_mut(&handle).unwrap();
    if let Some(VertexAttributeValues::Float32x3(p)) = mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION)
    {
        p.iter_mut().for_each(|p| p[0] *= 2.0);
    }
    drop(mesh);
    let late = spawn_at(&mut app, &handle, 8.0, 1.0);
    app.update();
    let width = |entity| {
        let rest = simulation(&app, entity).rest_positions();
        rest.iter().map(|p| p.x).fold(0.0, f32::max)
    };
    assert!((width(late) - 1.6).abs() < 1e-5 && (width(cloths[0]) - 0.8).abs() < 1e-5);
}

/// Red grows from 0 in the first column to 1 in the last, in the format asked for.
fn painted(bytes: bool) -> Mesh {
    let red = |v: u32| (v % 5) as f32 / 4.0;
    let values: VertexAttributeValues = if bytes {
        let color = |v| [(red(v) * 255.0).round() as u8, 0, 0, 255];
        VertexAttributeValues::Unorm8x4((0..20).map(color).collect())
    } else {
        (0..20).map(|v| [red(v), 0.0, 0.0, 1.0]).collect::<Vec<_>>().into()
    };
    let attribute = MeshVertexAttribute { format: (&values).into(), ..Mesh::ATTRIBUTE_COLOR };
    flat_mesh(4, 5).with_inserted_attribute(attribute, values)
}

#[test]
fn colours_choose_pins() {
    for bytes in [false, true] {
        let mut app = app();
        let pins = ClothPins::color(ColorChannel::Red, 0.6);
        let entity = taken_in(&mut app, painted(bytes), pins);
        let running = simulation(&app, entity);
        let mut expected: Vec<_> = (0..20)
            .filter(|v| v % 5 >= 3)
            .map(|v| running.particle_of_vertex(v).unwrap())
            .collect();
        expected.sort_unstable();
        assert_eq!(running.pinned(), expected);
    }
}

#[test]
fn pins_that_choose_nothing_are_told() {
    let mut plain = flat_mesh(4, 5);
    let mut positions: Vec<_> =
        attribute(&plain, Mesh::ATTRIBUTE_POSITION).iter().map(Vec3::to_array).collect();
    positions.push([9.0; 3]);
    plain.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    let cylinder = Cylinder::new(0.5, 1.0).mesh().build();
    let above = |above: f32| ClothPins::color(ColorChannel::Green, above);
    let cases = [
        (plain.clone(), above(0.5), PinProblem::NoColors),
        (painted(true), above(0.5), PinProblem::Empty),
        (painted(true), above(f32::NAN), PinProblem::Empty),
        (plain.clone(), ClothPins::vertices([20]), PinProblem::UnusedVertex(20)),
        (plain, ClothPins::vertices([3, 21]), PinProblem::NoSuchVertex { vertex: 21, count: 21 }),
        (cylinder.clone(), PinSelection::Corners.into(), PinProblem::NotAGrid),
        (cylinder.clone(), PinSelection::FirstRow.into(), PinProblem::NotAGrid),
        (cylinder, PinSelection::LastColumn.into(), PinProblem::NotAGrid),
    ];
    for (mesh, pins, expected) in cases {
        let mut app = app();
        let entity = taken_in(&mut app, mesh, pins);
        let error = failure(&app, entity).expect("it is told");
        assert_eq!(
            error,
            ClothError { entity, kind: ClothErrorKind::Pin { pin: 0, problem: expected } },
            "{error}"
        );
        assert!(error.to_string().contains(&entity.to_string()), "{error}");
        updates(&mut app, 2);
        assert!(simulation(&app, entity).tick_count() > 0, "it runs, and hangs on nothing");
    }
}

#[test]
fn weights_come_from_colours_and_lists() {
    let by_color = VertexFactor::Color { channel: ColorChannel::Red, at_zero: 1.0, at_one: 3.0 };
    let by_list = VertexFactor::Data((0..20).map(|v| 1.0 + (v % 5) as f32 * 0.5).collect());
    for (mesh, factor) in
        [(painted(false), by_color.clone()), (painted(true), by_color), (flat_mesh(4, 5), by_list)]
    {
        let mut app = app();
        let plain = taken_in(&mut app, mesh.clone(), ());
        let weights = ClothWeights { mass: factor, ..default() };
        let weighed = taken_in(&mut app, mesh, weights);
        for vertex in 0..20 {
            let mass = |entity| {
                let running = simulation(&app, entity);
                let particle = running.particle_of_vertex(vertex).unwrap();
                running.mass(particle as usize).unwrap()
            };
            let expected = 1.0 + 2.0 * (vertex % 5) as f32 / 4.0;
            let got = mass(weighed) / mass(plain);
            // Bytes are coarse.
            assert!((got - expected).abs() < 5e-3, "{got} {expected}");
        }
    }
}

#[test]
fn weights_are_changed_live_and_taken_away() {
    let mut app = app();
    let pins = || ClothPins::from(PinSelection::FirstRow);
    let material = ClothMaterial { thread_stiffness: 100.0, drag: 5.0, ..default() };
    let entity = spawn(&mut app, (sheet(), pins(), material));
    let plain = spawn(&mut app, (sheet(), pins(), material));
    updates(&mut app, 400);
    let lowest = |app: &App, entity| position(app, entity, 63).distance(position(app, entity, 7));
    let before = lowest(&app, entity);
    let heavy = VertexFactor::Data(vec![3.0; 64]);
    app.world_mut().entity_mut(entity).insert(ClothWeights { mass: heavy, ..default() });
    app.update();
    assert!((lowest(&app, entity) - before).abs() < 0.01, "it goes on from where it was");
    updates(&mut app, 400);
    // Three times the load, three times the stretch: what is beyond a metre.
    let ratio = (lowest(&app, entity) - 1.0) / (before - 1.0);
    assert!((ratio - 3.0).abs() < 0.1, "{ratio}");
    app.world_mut().entity_mut(entity).remove::<ClothWeights>();
    updates(&mut app, 400);
    assert!((lowest(&app, entity) - lowest(&app, plain)).abs() < 1e-3);
    assert_eq!(failure(&app, entity), None);
}

#[test]
fn weights_that_cannot_be_used_are_told_and_the_last_good_ones_stay() {
    let data = |values: &[f32]| VertexFactor::Data(values.to_vec());
    let with = |at: usize, value: f32| {
        let mut values = [1.0; 64];
        values[at] = value;
        data(&values)
    };
    let color = VertexFactor::Color { channel: ColorChannel::Blue, at_zero: 1.0, at_one: 2.0 };
    let cases: [(VertexFactor, fn(&WeightProblem) -> bool); 8] = [
        (data(&[]), |p| matches!(p, WeightProblem::WrongLength { expected: 64, got: 0, .. })),
        (data(&[1.0; 65]), |p| matches!(p, WeightProblem::WrongLength { got: 65, .. })),
        (with(3, 0.0), |p| matches!(p, WeightProblem::OutOfRange { vertex: 3, .. })),
        (with(9, -1.0), |p| matches!(p, WeightProblem::OutOfRange { vertex: 9, .. })),
        (with(63, f32::NAN), |p| matches!(p, WeightProblem::OutOfRange { vertex: 63, .. })),
        (with(0, f32::INFINITY), |p| matches!(p, WeightProblem::OutOfRange { vertex: 0, .. })),
        (with(1, 1e9), |p| matches!(p, WeightProblem::OutOfRange { vertex: 1, .. })),
        (color, |p| matches!(p, WeightProblem::NoColors { .. })),
    ];
    for (factor, is_expected) in cases {
        for stiff in [false, true] {
            let weights = if stiff {
                ClothWeights { stiffness: factor.clone(), ..default() }
            } else {
                ClothWeights { mass: factor.clone(), ..default() }
            };
            let mut app = app();
            let new = spawn(&mut app, (sheet(), weights.clone()));
            let running = spawn(&mut app, sheet());
            let good = spawn(&mut app, sheet());
            updates(&mut app, 3);
            app.world_mut().entity_mut(running).insert(weights);
            updates(&mut app, 3);
            for entity in [new, running] {
                let error = failure(&app, entity).expect("it is told");
                assert!(error.to_string().contains(&entity.to_string()), "{error}");
                let named = if stiff { "`stiffness`" } else { "`mass`" };
                assert!(error.to_string().contains(named), "{error}");
                let ClothError { kind: ClothErrorKind::Weights(problem), .. } = error else {
                    panic!("{error}")
                };
                assert!(is_expected(&problem), "{problem}");
            }
            assert!(app.world().get::<ClothSimulation>(new).is_none());
            assert_eq!(bits(&app, running), bits(&app, good));
            app.world_mut().entity_mut(running).remove::<ClothWeights>();
            app.world_mut().entity_mut(new).insert(ClothWeights::default());
            updates(&mut app, 2);
            assert_eq!((failure(&app, new), failure(&app, running)), (None, None));
            assert!(app.world().get::<ClothSimulation>(new).is_some());
        }
    }
}

#[test]
fn why_a_mesh_is_no_grid_is_kept() {
    let mut app = app();
    let mut holed = flat_mesh(6, 6);
    let Some(Indices::U32(indices)) = holed.indices_mut() else { panic!("it has indices") };
    indices.drain(72..78);
    let entity = taken_in(&mut app, holed, ());
    assert_eq!(intake(&app, entity).grid, Err(GridProblem::Border));
}

#[test]
fn weights_and_masses_of_a_graph_are_changed_live() {
    let mut app = app();
    let mesh = Cylinder::new(0.5, 1.0).mesh().resolution(12).segments(4).build();
    let count = mesh.count_vertices();
    let entity = taken_in(&mut app, mesh, ());
    updates(&mut app, 10);
    let total = |app: &App| {
        let running = simulation(app, entity);
        (0..running.particle_count()).map(|p| running.mass(p).unwrap()).sum::<f32>()
    };
    let (before, place) = (total(&app), position(&app, entity, 0));
    let weights = ClothWeights { mass: VertexFactor::Data(vec![2.0; count]), ..default() };
    app.world_mut().entity_mut(entity).insert(weights);
    app.update();
    assert!((total(&app) - 2.0 * before).abs() < 1e-4 * before);
    app.world_mut().get_mut::<ClothSettings>(entity).unwrap().masses = MassLumping::Equal;
    app.update();
    assert_eq!(failure(&app, entity), None);
    assert!((total(&app) - 2.0 * before).abs() < 1e-4 * before, "the weights stay");
    assert_eq!(simulation(&app, entity).mass(0), simulation(&app, entity).mass(1));
    // Two more ticks of falling at some 1.6 m/s.
    assert!(position(&app, entity, 0).distance(place) < 0.1);
}
