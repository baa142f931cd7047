//! Cloth that is drawn finer than it is simulated. Truths: the rest shape as it was made, carried rigidly; the places of anchors and of
//! the formula by which shaders move skinned vertices, for what is held; the same cloth without a proxy, in what it weighs and where it
//! hangs; bit equality between frame rates; that a change of proxy moves nothing; and that what is refused is told.

use crate::{
    skin::{dressed, skinned, usual, walk},
    support::app::*,
};
use bevy::{mesh::VertexAttributeValues, prelude::*};
use bevy_drape::{
    ClothErrorKind, ClothGravityOverride, ClothPaused, ClothProxy, ClothSkin, ClothWeights,
    ColorChannel, PinSelection, ProxyProblem, SkinMap, VertexFactor, prelude::*,
};
use std::time::Duration;

/// Columns and rows that are drawn.
const FINE: u32 = 25;

fn fine() -> Cloth {
    Cloth::sheet(Vec2::new(1.0, 1.2), UVec2::splat(FINE))
}

/// A quarter of a tube of 1 m, a grid in space.
fn gutter() -> Mesh {
    let part = |i: u32| i as f32 / (FINE - 1) as f32;
    grid_mesh(
        FINE,
        FINE,
        |v| (v + 7) % (FINE * FINE),
        |r, c| {
            let angle = 1.6 * part(c);
            Vec3::new(angle.sin(), angle.cos(), part(r))
        },
    )
}

/// The same with fewer triangles, but for a hole: no grid.
fn coarse_gutter(cells: u32) -> Mesh {
    let part = |i: u32| i as f32 / cells as f32;
    let mut mesh = grid_mesh(
        cells + 1,
        cells + 1,
        |v| v,
        |r, c| {
            let angle = 1.6 * part(c);
            Vec3::new(angle.sin(), angle.cos(), part(r))
        },
    );
    let Some(bevy::mesh::Indices::U32(indices)) = mesh.indices_mut() else { panic!() };
    let hole = 6 * (cells * cells / 2) as usize;
    indices.drain(hole..hole + 6);
    mesh
}

fn place() -> Transform {
    Transform::from_xyz(3.0, 2.0, -5.0)
        .with_rotation(Quat::from_euler(EulerRot::XYZ, 0.4, 2.0, -0.7))
        .with_scale(Vec3::splat(0.6))
}

fn coarse_count(app: &App, cloth: Entity) -> usize {
    simulation(app, cloth).particle_count()
}

#[test]
fn a_cloth_that_has_not_moved_is_drawn_as_it_was_made() {
    let mut app = app();
    let mesh = gutter();
    let rest = attribute(&mesh, Mesh::ATTRIBUTE_POSITION);
    let [mesh, own] = [mesh, coarse_gutter(6)].map(|mesh| add_mesh(&mut app, mesh));
    let proxies = [
        (ClothProxy::grid(9, 7), 63),
        // Neither columns nor rows of the coarse grid are among those that are drawn.
        (ClothProxy::grid(8, 11), 88),
        (ClothProxy::ratio(0.25), 169),
        (ClothProxy::ratio(1.0), 625),
        (ClothProxy::mesh(own), 49),
    ];
    for (proxy, count) in proxies {
        let still = (ClothPaused::default(), ClothGravityOverride(Vec3::ZERO), place());
        let what = format!("{proxy:?}");
        let cloths = [
            spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d(mesh.clone()), proxy.clone(), still)),
            spawn(&mut app, (fine(), proxy, still)),
        ];
        let is_own = what.contains("Mesh");
        app.update();
        for (cloth, rest) in cloths.iter().zip([Some(&rest), None]).take(2 - usize::from(is_own)) {
            assert_eq!(failure(&app, *cloth), None);
            assert_eq!(coarse_count(&app, *cloth), count, "{what}");
            let flat = |i: u32| {
                let at = Vec2::new((i % FINE) as f32, (i / FINE) as f32) / (FINE - 1) as f32 - 0.5;
                Vec3::new(at.x, 0.0, 1.2 * at.y)
            };
            let rest = rest.cloned().unwrap_or_else(|| (0..FINE * FINE).map(flat).collect());
            let expected: Vec<_> = rest.iter().map(|p| place().transform_point(*p)).collect();
            let off = farthest(&drawn_positions(&app, *cloth), &expected);
            assert!(off < 5e-6, "{what}: {off}");
            // Once it has begun, it grows with its entity, about its middle.
            app.world_mut().entity_mut(*cloth).insert(ClothPaused { steps: 1 });
            updates(&mut app, 2);
            let before = drawn_positions(&app, *cloth);
            transform(&mut app, *cloth).scale = Vec3::splat(1.1);
            app.update();
            let larger = drawn_positions(&app, *cloth);
            let from_first = |places: &[Vec3], by: f32| -> Vec<_> {
                places.iter().map(|place| (place - places[0]) * by).collect()
            };
            let ratio = 1.1 / place().scale.x;
            let off = farthest(&from_first(&larger, 1.0), &from_first(&before, ratio));
            assert!(off < 1e-4, "{what}, scaled: {off}");
            *transform(&mut app, *cloth) = place();
            app.update();
        }
        // It moves rigidly with what it is pinned to.
        if !is_own {
            app.world_mut().entity_mut(cloths[1]).remove::<ClothPaused>();
            app.world_mut().entity_mut(cloths[1]).insert(ClothPins::from(PinSelection::All));
            let to = Transform::from_xyz(-1.0, 0.3, 0.2).with_rotation(Quat::from_rotation_z(2.0));
            updates(&mut app, 3);
            let before = drawn_positions(&app, cloths[1]);
            *transform(&mut app, cloths[1]) = to.with_scale(Vec3::splat(0.6));
            updates(&mut app, 3);
            let motion = to.with_scale(Vec3::splat(0.6)).compute_affine()
                * place().compute_affine().inverse();
            let expected: Vec<_> = before.iter().map(|p| motion.transform_point3(*p)).collect();
            let off = farthest(&drawn_positions(&app, cloths[1]), &expected);
            assert!(off < 5e-6, "{what}: {off}");
        }
        cloths.into_iter().for_each(|cloth| _ = app.world_mut().despawn(cloth));
    }
}

#[test]
fn what_is_pinned_is_drawn_where_its_anchor_is_at_every_frame_rate() {
    for rate in [30.0, 64.0, 144.0] {
        let mut app = app();
        let hand = spawn(&mut app, Transform::from_xyz(0.0, 2.0, 0.0));
        // The first row, by vertices of what is drawn.
        let pins = ClothPins::vertices(0..FINE).anchored_to(hand);
        let proxy = ClothProxy::grid(10, 13);
        let cloth = spawn(&mut app, (fine(), proxy, pins, Transform::from_xyz(0.0, 2.0, 0.0)));
        app.update();
        let rest = drawn_positions(&app, cloth)[..FINE as usize].to_vec();
        let local: Vec<_> = rest.iter().map(|p| *p - Vec3::Y * 2.0).collect();
        set_frame(&mut app, Duration::from_secs_f32(1.0 / rate));
        let mut lowest = 0.0_f32;
        for frame in 0..(2.0 * rate) as u32 {
            let time = frame as f32 / rate;
            let to = Transform::from_xyz((3.0 * time).sin(), 2.0 + 0.2 * time, 0.0)
                .with_rotation(Quat::from_rotation_y(2.0 * time));
            *transform(&mut app, hand) = to;
            app.update();
            let drawn = drawn_positions(&app, cloth);
            let expected: Vec<_> = local.iter().map(|p| to.transform_point(*p)).collect();
            let off = farthest(&drawn[..FINE as usize], &expected);
            assert!(off < 1e-5, "{rate}: {off} at {time}");
            lowest = lowest.min(drawn.last().unwrap().y - to.translation.y);
        }
        assert_eq!(simulation(&app, cloth).pinned().len(), 10);
        assert!(lowest < -0.7, "it hangs: {lowest}");
    }
}

#[test]
fn what_the_skin_holds_is_drawn_where_the_skeleton_is() {
    for (rate, max_distance) in [30.0, 60.0, 144.0]
        .map(|rate| (rate, 0.0.into()))
        .into_iter()
        .chain([(60.0, SkinMap::color(ColorChannel::Red, 0.0, 0.15))])
    {
        let mut app = app();
        let worn = ClothSkin { max_distance, ..default() };
        let is_all = worn.max_distance == SkinMap::Uniform(0.0);
        let of = dressed(&mut app, worn);
        app.world_mut().entity_mut(of.coat).insert(ClothProxy::grid(4, 5));
        app.update();
        assert_eq!((failure(&app, of.coat), coarse_count(&app, of.coat)), (None, 20));
        set_frame(&mut app, Duration::from_secs_f32(1.0 / rate));
        let (mut worst, mut furthest) = (0.0_f32, 0.0_f32);
        for frame in 0..(1.5 * rate) as u32 {
            walk(&mut app, &of, frame as f32 / rate);
            app.update();
            let expected: Vec<_> = skinned(&mut app, &of).into_iter().map(|it| it.0).collect();
            let drawn = drawn_positions(&app, of.coat);
            // The first two rows of nine have no way to go.
            let held = if is_all { 81 } else { 18 };
            worst = worst.max(farthest(&drawn[..held], &expected[..held]));
            furthest = furthest.max(farthest(&drawn, &expected));
        }
        assert!(worst < 1e-5, "{rate}: {worst}");
        // What hangs free goes about as far as it may: the particles do, and the surface between them is curved.
        assert_eq!(is_all, furthest < 1e-5);
        assert!(furthest < 0.2, "{furthest}");
    }
}

#[test]
fn no_step_is_seen_between_what_is_held_and_what_is_free() {
    let normals = |app: &App, cloth| attribute(drawn(app, cloth), Mesh::ATTRIBUTE_NORMAL);
    let mut app = app();
    let of = dressed(&mut app, usual());
    app.world_mut().entity_mut(of.coat).insert(ClothPaused::default());
    app.update();
    let without = normals(&app, of.coat);
    app.world_mut().entity_mut(of.coat).insert(ClothProxy::grid(4, 5));
    updates(&mut app, 2);
    assert_eq!(coarse_count(&app, of.coat), 20);
    // In the rest pose there is none at all.
    for (a, b) in normals(&app, of.coat).iter().zip(&without) {
        assert!(a.angle_between(*b).to_degrees() < 0.1, "{a} {b}");
    }
    // A curtain of which the held row lies still and the rest swings: the second row of vertices is in the first row of cells.
    let pins = ClothPins::from(PinSelection::FirstRow);
    let cloth = spawn(&mut app, (fine(), ClothProxy::grid(9, 9), pins, Transform::default()));
    updates(&mut app, 40);
    let drawn = drawn_positions(&app, cloth);
    let row = |r: u32| &drawn[(r * FINE) as usize..((r + 1) * FINE) as usize];
    for r in 1..6 {
        let bends = row(r - 1).iter().zip(row(r)).zip(row(r + 1));
        let most = bends.map(|((a, b), c)| (*b - *a).angle_between(*c - *b)).fold(0.0, f32::max);
        assert!(most.to_degrees() < 14.0, "{r}: {}", most.to_degrees());
    }
}

#[test]
fn vertices_of_the_drawn_mesh_tell_of_particles() {
    let mut app = app();
    let mut mesh = gutter();
    let rest = attribute(&mesh, Mesh::ATTRIBUTE_POSITION);
    let red = |p: &Vec3| [p.z, 0.0, 0.0, 1.0];
    mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, rest.iter().map(red).collect::<Vec<_>>());
    let mesh = Mesh3d(add_mesh(&mut app, mesh));
    let mass = VertexFactor::Color { channel: ColorChannel::Red, at_zero: 1.0, at_one: 5.0 };
    let weights = ClothWeights { mass, ..default() };
    let pins = ClothPins::color(ColorChannel::Red, 0.99);
    let of = |app: &mut App, proxy: Option<ClothProxy>| {
        let cloth = (Cloth::of_mesh3d(), mesh.clone(), pins.clone(), weights.clone(), place());
        let cloth = spawn(app, cloth);
        if let Some(proxy) = proxy {
            app.world_mut().entity_mut(cloth).insert(proxy);
        }
        app.update();
        assert_eq!(failure(app, cloth), None);
        cloth
    };
    let own = add_mesh(&mut app, coarse_gutter(8));
    let without = of(&mut app, None);
    let total = |app: &App, cloth| {
        let cloth = simulation(app, cloth);
        (0..cloth.particle_count()).filter_map(|i| cloth.mass(i)).sum::<f32>()
    };
    for (proxy, held) in
        [(ClothProxy::grid(9, 9), 9), (ClothProxy::ratio(0.2), 12), (ClothProxy::mesh(own), 9)]
    {
        let cloth = of(&mut app, Some(proxy));
        assert_eq!(simulation(&app, cloth).pinned().len(), held);
        let (all, part) = (total(&app, without), total(&app, cloth));
        assert!((part / all - 1.0).abs() < 0.03, "{part} of {all}");
        // Each vertex has a particle, and it is near.
        let running = simulation(&app, cloth);
        for (vertex, rest) in rest.iter().enumerate() {
            let particle = running.particle_of_vertex(vertex as u32).unwrap();
            let at = running.rest_positions()[particle as usize] / 0.6;
            assert!(at.distance(*rest) < 0.2, "{vertex}: {at} {rest}");
        }
        assert_eq!(running.particle_of_vertex(FINE * FINE), None);
    }
}

#[test]
fn frames_make_no_difference() {
    let run = |rate: f32| {
        let mut app = app();
        let pins = ClothPins::vertices([0, FINE - 1]);
        let cloth = spawn(&mut app, (fine(), ClothProxy::grid(9, 11), pins, Transform::default()));
        set_frame(&mut app, Duration::from_secs_f32(1.0 / rate));
        while simulation_is_before(&app, cloth, 64) {
            app.update();
        }
        assert_eq!(simulation(&app, cloth).tick_count(), 64);
        bits(&app, cloth)
    };
    assert_eq!(run(64.0), run(128.0));
}

fn simulation_is_before(app: &App, cloth: Entity, tick: u64) -> bool {
    let running = app.world().get::<ClothSimulation>(cloth);
    running.is_none_or(|running| running.tick_count() < tick)
}

#[test]
fn a_change_of_proxy_moves_nothing() {
    let mut app = app();
    let hand = spawn(&mut app, Transform::from_xyz(0.1, 0.2, 0.3));
    let pins = ClothPins::vertices([0, FINE - 1]).anchored_to(hand);
    let cloth = spawn(&mut app, (fine(), pins, Transform::default()));
    updates(&mut app, 25);
    let handle = app.world().get::<Mesh3d>(cloth).unwrap().clone();
    let corners = [0, FINE as usize - 1].map(|i| drawn_positions(&app, cloth)[i]);
    let levels = [Some(13), Some(7), None, Some(9), Some(7), None];
    for (turn, side) in levels.into_iter().cycle().take(12).enumerate() {
        // No time goes by meanwhile, so that nothing but the change is seen.
        set_frame(&mut app, Duration::ZERO);
        app.update();
        let (before, velocity) = (drawn_positions(&app, cloth), mean_velocity(&app, cloth));
        let ticks = simulation(&app, cloth).tick_count();
        match side {
            Some(side) => {
                app.world_mut().entity_mut(cloth).insert(ClothProxy::grid(side, side));
            }
            None => _ = app.world_mut().entity_mut(cloth).remove::<ClothProxy>(),
        }
        app.update();
        let count = side.unwrap_or(FINE).pow(2) as usize;
        assert_eq!((coarse_count(&app, cloth), failure(&app, cloth)), (count, None));
        let off = farthest(&drawn_positions(&app, cloth), &before);
        let now = mean_velocity(&app, cloth);
        // Fewer points cannot tell all of its folds. More of them tell all that was there.
        let is_finer = side.is_none();
        assert!(off < if is_finer { 0.006 } else { 0.08 }, "{turn}: {off}");
        assert!(velocity.distance(now) < 0.3, "{turn}: {velocity} {now}");
        set_frame(&mut app, Duration::from_millis(11));
        updates(&mut app, 7);
        assert!(simulation(&app, cloth).tick_count() > ticks, "it goes on");
        assert_eq!(*app.world().get::<Mesh3d>(cloth).unwrap(), handle, "the same asset");
    }
    // What its anchor holds has stayed where that holds it.
    let now = [0, FINE as usize - 1].map(|i| drawn_positions(&app, cloth)[i]);
    assert!(farthest(&now, &corners) < 1e-5, "{now:?} {corners:?}");
}

#[test]
fn what_a_moving_hand_holds_stays_in_it() {
    let mut app = app();
    let hand = spawn(&mut app, Transform::from_xyz(0.1, 0.2, 0.3));
    let pins = ClothPins::vertices([0, FINE - 1]).anchored_to(hand);
    let cloth = spawn(&mut app, (fine(), pins, Transform::default()));
    set_frame(&mut app, Duration::from_millis(11));
    updates(&mut app, 5);
    let in_hand = |app: &App| {
        let to_hand = app.world().get::<Transform>(hand).unwrap().compute_affine().inverse();
        let drawn = drawn_positions(app, cloth);
        [0, FINE as usize - 1].map(|i| to_hand.transform_point3(drawn[i]))
    };
    let before = in_hand(&app);
    for step in 1..=60 {
        let mut place = transform(&mut app, hand);
        place.translation += Vec3::new(0.03, 0.01, -0.02);
        place.rotate_y(0.05);
        match step % 6 {
            1 => _ = app.world_mut().entity_mut(cloth).insert(ClothProxy::grid(9, 9)),
            3 => _ = app.world_mut().entity_mut(cloth).insert(ClothProxy::grid(13, 13)),
            5 => _ = app.world_mut().entity_mut(cloth).remove::<ClothProxy>(),
            _ => {}
        }
        app.update();
        let off = farthest(&in_hand(&app), &before);
        assert!(off < 2e-5, "{step}: {off}");
    }
}

#[test]
fn a_worn_cloth_goes_on_within_its_limits() {
    let mut app = app();
    let of = dressed(&mut app, usual());
    for frame in 0..90 {
        let time = frame as f32 / 64.0;
        walk(&mut app, &of, time);
        if frame % 10 == 5 {
            match frame / 10 % 3 {
                0 => _ = app.world_mut().entity_mut(of.coat).insert(ClothProxy::grid(5, 5)),
                1 => _ = app.world_mut().entity_mut(of.coat).insert(ClothProxy::ratio(0.5)),
                _ => _ = app.world_mut().entity_mut(of.coat).remove::<ClothProxy>(),
            }
        }
        app.update();
        assert_eq!(failure(&app, of.coat), None);
        let running = simulation(&app, of.coat);
        let limits = running.skin_limits().unwrap();
        let places = running.skin_places().unwrap();
        for ((at, place), limit) in running.positions().zip(places).zip(limits) {
            let beyond = at.distance(*place) - limit.max_distance;
            assert!(beyond < 1e-4, "{frame}: {beyond}");
        }
        let expected: Vec<_> = skinned(&mut app, &of).into_iter().map(|it| it.0).collect();
        assert!(farthest(&drawn_positions(&app, of.coat)[..18], &expected[..18]) < 1e-5);
    }
}

#[test]
fn what_cannot_be_simulated_is_refused() {
    let mut app = app();
    let holed = Mesh3d(add_mesh(&mut app, holed_mesh()));
    let far = add_mesh(&mut app, flat_mesh(4, 4).translated_by(Vec3::X * 3.0));
    let empty = add_mesh(&mut app, triangle_mesh(vec![[0.0; 3]; 3], vec![]));
    let missing = Handle::<Mesh>::Uuid(uuid(), std::marker::PhantomData);
    type Is = fn(&ProxyProblem) -> bool;
    let rows: Vec<(Option<Mesh3d>, ClothProxy, Is, &str)> = vec![
        (None, ClothProxy::grid(26, 5), |it| matches!(it, ProxyProblem::Grid { .. }), "25"),
        (None, ClothProxy::grid(5, 1), |it| matches!(it, ProxyProblem::Grid { .. }), "at least 2"),
        (None, ClothProxy::ratio(0.0), |it| matches!(it, ProxyProblem::Ratio(_)), "above 0"),
        (None, ClothProxy::ratio(1.1), |it| matches!(it, ProxyProblem::Ratio(_)), "1.1"),
        (None, ClothProxy::ratio(f32::NAN), |it| matches!(it, ProxyProblem::Ratio(_)), "NaN"),
        (
            Some(holed.clone()),
            ClothProxy::grid(3, 3),
            |it| matches!(it, ProxyProblem::NotAGrid(_)),
            "no grid",
        ),
        #[cfg(not(feature = "simplify"))]
        (
            Some(holed),
            ClothProxy::ratio(0.5),
            |it| matches!(it, ProxyProblem::NoSimplifier),
            "feature `simplify`",
        ),
        (None, ClothProxy::mesh(far), |it| matches!(it, ProxyProblem::TooFar { .. }), "same frame"),
        (None, ClothProxy::mesh(empty), |it| matches!(it, ProxyProblem::Mesh(_)), "no triangles"),
        (None, ClothProxy::mesh(missing), |it| matches!(it, ProxyProblem::Mesh(_)), "not among"),
    ];
    for (mesh, bad, is, says) in rows {
        let bystander = spawn(&mut app, (sheet(), Transform::default()));
        let cloth = match mesh {
            Some(mesh) => spawn(&mut app, (Cloth::of_mesh3d(), mesh, bad.clone())),
            None => spawn(&mut app, (fine(), bad.clone())),
        };
        let running = spawn(&mut app, (fine(), ClothProxy::grid(6, 6)));
        updates(&mut app, 2);
        app.world_mut().entity_mut(running).insert(ClothProxy::grid(99, 99));
        updates(&mut app, 2);
        let error = failure(&app, cloth).expect(says);
        let ClothErrorKind::Proxy(problem) = &error.kind else { panic!("{error}") };
        assert!(is(problem), "{error}");
        let text = error.to_string();
        assert!(text.contains(says) && text.contains(&cloth.to_string()), "{text}");
        assert!(text.contains("`ClothProxy`"), "{text}");
        assert!(app.world().get::<ClothSimulation>(cloth).is_none());
        // One that runs goes on as it was.
        assert!(failure(&app, running).is_some());
        assert_eq!(coarse_count(&app, running), 36);
        assert!(simulation(&app, running).tick_count() > 2);
        assert!(simulation(&app, bystander).tick_count() > 2);
        assert_eq!(failure(&app, bystander), None);
        // Mended, it runs.
        app.world_mut().entity_mut(cloth).remove::<ClothProxy>();
        app.world_mut().entity_mut(running).insert(ClothProxy::grid(7, 7));
        updates(&mut app, 2);
        assert_eq!([cloth, running].map(|it| failure(&app, it)), [None, None]);
        assert!(simulation(&app, cloth).tick_count() > 0);
        assert_eq!(coarse_count(&app, running), 49);
        [bystander, cloth, running].into_iter().for_each(|it| _ = app.world_mut().despawn(it));
    }
}

fn uuid() -> bevy::asset::uuid::Uuid {
    bevy::asset::uuid::Uuid::from_u128(77)
}

#[test]
fn tangents_go_with_the_drawn_mesh() {
    let mut app = app();
    let mut mesh = gutter();
    let count = mesh.count_vertices();
    mesh.insert_attribute(Mesh::ATTRIBUTE_TANGENT, vec![[0.0, 0.0, 1.0, 1.0]; count]);
    let mesh = Mesh3d(add_mesh(&mut app, mesh));
    let still = (ClothProxy::grid(9, 9), ClothPaused::default());
    let turn = Transform::from_rotation(Quat::from_rotation_x(0.4));
    let cloth = spawn(&mut app, (Cloth::of_mesh3d(), mesh, still, turn));
    updates(&mut app, 2);
    let Some(VertexAttributeValues::Float32x4(tangents)) =
        drawn(&app, cloth).attribute(Mesh::ATTRIBUTE_TANGENT)
    else {
        panic!("it has tangents")
    };
    for tangent in tangents {
        let [x, y, z, w] = *tangent;
        assert!(Vec3::new(x, y, z).distance(Vec3::Z) < 1e-4 && w == 1.0, "{tangent:?}");
    }
}
