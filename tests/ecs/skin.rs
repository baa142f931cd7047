//! Cloths that are worn. Truths: the formula by which shaders move skinned vertices, for what is held; that nothing is beyond its
//! max distance or behind its backstop at any tick's end, whatever the skeleton does; bit equality (saved and loaded, forms); what
//! the entity was before, once the skin is given back; and that what is refused is told to its own entity.

use crate::support::app::*;
use bevy::{
    camera::visibility::DynamicSkinnedMeshBounds,
    ecs::system::RunSystemOnce,
    mesh::{
        MeshVertexAttribute, VertexAttributeValues, VertexFormat,
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
    time::TimeUpdateStrategy,
};
use bevy_drape::{
    ClothErrorKind, ClothExecution, ClothInertia, ClothProxy, ClothSkin, ColorChannel, HangProblem,
    SkinBackstop, SkinMap, SkinProblem, prelude::*, solver::SkinLimit,
};
use std::{sync::atomic::Ordering, time::Duration};

/// Rows and columns of the coat's back.
const SIDE: u32 = 9;
/// Most that a particle is beyond its bounds at a tick's end \[m\].
pub(crate) const CLOSE: f32 = 1e-4;
const FREE: MeshVertexAttribute =
    MeshVertexAttribute::new("DRAPE_FREE", 987_123, VertexFormat::Float32);

/// Joints of a character: hips at 1 m, and two thighs below.
pub(crate) struct Character {
    pub(crate) root: Entity,
    joints: [Entity; 3],
    pub(crate) coat: Entity,
}

/// The freedom of a row of the coat: none in the first two, all in the last.
fn freedom(row: u32) -> f32 {
    (row.saturating_sub(1)) as f32 / (SIDE - 2) as f32
}

/// A coat's back that hangs from the hips to the knees, the left half led by the left thigh the more the lower it is. Painted in
/// red and in an attribute where it is free, and, if asked, by the weight of a joint that does not move it.
fn coat() -> Mesh {
    let place = |i: u32| i as f32 / (SIDE - 1) as f32;
    let mesh =
        grid_mesh(SIDE, SIDE, |v| v, |r, c| Vec3::new(place(c) - 0.5, 1.0 - 0.6 * place(r), -0.2));
    let vertices = || (0..SIDE).flat_map(|r| (0..SIDE).map(move |c| (r, c)));
    let weights = vertices().map(|(r, c)| {
        let thigh = 0.8 * place(r);
        let side = place(c);
        [1.0 - thigh, thigh * (1.0 - side), thigh * side, 0.0]
    });
    mesh.with_inserted_attribute(
        Mesh::ATTRIBUTE_NORMAL,
        vec![[0.0, 0.0, -1.0]; (SIDE * SIDE) as usize],
    )
    .with_inserted_attribute(
        Mesh::ATTRIBUTE_COLOR,
        vertices().map(|(r, _)| [freedom(r), 1.0, 1.0, 1.0]).collect::<Vec<_>>(),
    )
    .with_inserted_attribute(FREE, vertices().map(|(r, _)| freedom(r)).collect::<Vec<_>>())
    .with_inserted_attribute(
        Mesh::ATTRIBUTE_JOINT_INDEX,
        VertexAttributeValues::Uint16x4(vec![[0, 1, 2, 0]; (SIDE * SIDE) as usize]),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights.collect::<Vec<_>>())
}

fn bind_places() -> [Vec3; 3] {
    [Vec3::Y, Vec3::new(-0.1, 0.9, 0.0), Vec3::new(0.1, 0.9, 0.0)]
}

fn add_bindposes(app: &mut App, poses: &[Mat4]) -> Handle<SkinnedMeshInverseBindposes> {
    let mut all = app.world_mut().resource_mut::<Assets<SkinnedMeshInverseBindposes>>();
    all.add(SkinnedMeshInverseBindposes::from(poses.to_vec()))
}

/// A character in its bind pose, with a skinned coat that is no cloth yet.
fn character(app: &mut App, mesh: Mesh) -> Character {
    let root = spawn(app, (Transform::default(), Visibility::default()));
    let places = bind_places();
    let joint = |app: &mut App, at: Vec3, name: &'static str, parent| {
        spawn(app, (Transform::from_translation(at), Name::new(name), ChildOf(parent)))
    };
    let hips = joint(app, places[0], "hips", root);
    let left = joint(app, places[1] - places[0], "thigh.l", hips);
    let right = joint(app, places[2] - places[0], "thigh.r", hips);
    let joints = [hips, left, right];
    let inverse_bindposes = add_bindposes(app, &places.map(|at| Mat4::from_translation(-at)));
    let skinned = SkinnedMesh { inverse_bindposes, joints: joints.to_vec() };
    let mesh = Mesh3d(add_mesh(app, mesh));
    // Its own transform does not matter.
    let place = Transform::from_xyz(0.3, 0.1, -0.2).with_scale(Vec3::splat(1.7));
    let coat = spawn(app, (mesh, skinned, DynamicSkinnedMeshBounds, place, ChildOf(root)));
    Character { root, joints, coat }
}

pub(crate) fn dressed(app: &mut App, worn: ClothSkin) -> Character {
    let character = character(app, coat());
    app.world_mut().entity_mut(character.coat).insert((Cloth::of_mesh3d(), worn));
    app.update();
    character
}

/// Up to 15 cm in the last row, none in the first two, not a centimetre into the body.
pub(crate) fn usual() -> ClothSkin {
    ClothSkin {
        max_distance: SkinMap::color(ColorChannel::Red, 0.0, 0.15),
        backstop: Some(SkinBackstop { distance: 0.01.into(), ..default() }),
        ..default()
    }
}

/// The character walks, and dashes by 5 m in 0.1 s from 1 s on.
pub(crate) fn walk(app: &mut App, of: &Character, time: f32) {
    let dash = ((time - 1.0) / 0.1).clamp(0.0, 1.0) * 5.0;
    *transform(app, of.root) = Transform::from_xyz(1.5 * time + dash, 0.0, 0.4 * time)
        .with_rotation(Quat::from_rotation_y(0.9 * (3.0 * time).sin()));
    let swing = 0.7 * (8.0 * time).sin();
    transform(app, of.joints[0]).translation.y = 1.0 + 0.04 * (16.0 * time).sin();
    transform(app, of.joints[1]).rotation = Quat::from_rotation_x(swing);
    transform(app, of.joints[2]).rotation = Quat::from_rotation_x(-swing);
}

/// Places and normals of all particles, as shaders work them out of where joints are.
pub(crate) fn skinned(app: &mut App, of: &Character) -> Vec<(Vec3, Vec3)> {
    let binds = bind_places().map(|at| Mat4::from_translation(-at));
    let joints = of.joints;
    let look = move |transforms: TransformHelper| {
        joints.map(|joint| transforms.compute_global_transform(joint).unwrap().to_matrix())
    };
    let globals = app.world_mut().run_system_once(look).unwrap();
    let mesh = coat();
    let places = attribute(&mesh, Mesh::ATTRIBUTE_POSITION);
    let Some(VertexAttributeValues::Float32x4(weights)) =
        mesh.attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT)
    else {
        panic!("it has weights")
    };
    let vertex = |(place, weights): (&Vec3, &[f32; 4])| {
        let sum = (0..3).fold(Mat4::ZERO, |sum, i| sum + globals[i] * binds[i] * weights[i]);
        let normal = Mat3::from_mat4(sum).inverse().transpose() * Vec3::NEG_Z;
        (sum.transform_point3(*place), normal.normalize())
    };
    places.iter().zip(weights).map(vertex).collect()
}

/// How far any particle is beyond its bounds, when the skin is there \[m\].
pub(crate) fn beyond(app: &App, of: &Character, skin: &[(Vec3, Vec3)], scale: f32) -> f32 {
    let each = positions(app, of.coat).into_iter().zip(skin).enumerate();
    each.map(|(i, (at, (place, normal)))| {
        let off = at - *place;
        let most = 0.15 * scale * freedom(i as u32 / SIDE);
        (off.length() - most).max(-0.01 * scale - off.dot(*normal))
    })
    .fold(f32::NEG_INFINITY, f32::max)
}

fn is_taken(app: &App, of: &Character) -> bool {
    let entity = app.world().entity(of.coat);
    !entity.contains::<SkinnedMesh>() && !entity.contains::<DynamicSkinnedMeshBounds>()
}

#[test]
fn what_is_held_is_drawn_where_the_skeleton_is_at_every_frame_rate() {
    for rate in [30.0, 60.0, 144.0] {
        let mut app = app();
        let worn = ClothSkin { max_distance: 0.0.into(), ..default() };
        let of = dressed(&mut app, worn);
        set_frame(&mut app, Duration::from_secs_f32(1.0 / rate));
        let mut worst = 0.0_f32;
        for frame in 0..(1.5 * rate) as u32 {
            walk(&mut app, &of, frame as f32 / rate);
            app.update();
            let expected = skinned(&mut app, &of);
            for (drawn, (place, _)) in drawn_positions(&app, of.coat).iter().zip(expected) {
                worst = worst.max(drawn.distance(place));
            }
        }
        assert!(simulation(&app, of.coat).tick_count() > 80);
        assert!(worst < 1e-5, "{rate}: {worst}");
    }
}

#[test]
fn what_is_free_is_drawn_as_near_to_the_skeleton_as_it_is() {
    for rate in [30.0, 144.0] {
        let mut app = app();
        let of = dressed(&mut app, usual());
        set_frame(&mut app, Duration::from_secs_f32(1.0 / rate));
        let (mut worst, mut furthest) = (f32::NEG_INFINITY, 0.0_f32);
        for frame in 0..(1.5 * rate) as u32 {
            walk(&mut app, &of, frame as f32 / rate);
            app.update();
            let skin = skinned(&mut app, &of);
            let drawn = drawn_positions(&app, of.coat).into_iter().zip(skin).enumerate();
            for (vertex, (drawn, (place, _))) in drawn {
                let off = drawn.distance(place);
                worst = worst.max(off - 0.15 * freedom(vertex as u32 / SIDE));
                furthest = furthest.max(off);
            }
        }
        assert!(worst < CLOSE, "{rate}: {worst}");
        assert!(furthest > 0.1, "{rate}: it is free: {furthest}");
    }
}

#[test]
fn nothing_is_beyond_its_bounds_at_any_ticks_end() {
    let mut app = app();
    let of = dressed(&mut app, usual());
    let loose = dressed(
        &mut app,
        ClothSkin { max_distance: SkinMap::color(ColorChannel::Red, 0.0, 9.0), ..default() },
    );
    assert!(is_taken(&app, &of));
    assert_eq!(failure(&app, of.coat), None);
    let (mut worst, mut free) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
    for tick in 0..200 {
        // A tick sees where the joints were put in the frame before.
        let skin = skinned(&mut app, &of);
        app.update();
        worst = worst.max(beyond(&app, &of, &skin, 1.0));
        free = free.max(beyond(&app, &loose, &skin, 1.0));
        for it in [&of, &loose] {
            walk(&mut app, it, tick as f32 / 64.0);
        }
    }
    assert!(worst < CLOSE, "{worst}");
    assert!(free > 0.2, "one that is not bounded leaves: {free}");
    let largest = simulation(&app, of.coat).strain().max;
    assert!(largest < 0.11, "{largest}");
}

#[test]
fn a_skin_is_given_back() {
    for with_cloth in [false, true] {
        let mut app = app();
        let of = dressed(&mut app, usual());
        updates(&mut app, 5);
        assert!(is_taken(&app, &of));
        assert!(!drawn(&app, of.coat).contains_attribute(Mesh::ATTRIBUTE_JOINT_INDEX));
        assert!(!drawn(&app, of.coat).contains_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT));
        // The mask is not drawn, unless it is asked for.
        assert!(!drawn(&app, of.coat).contains_attribute(Mesh::ATTRIBUTE_COLOR));
        app.world_mut().entity_mut(of.coat).insert(ClothSkin { draws_mask: true, ..usual() });
        app.update();
        assert!(drawn(&app, of.coat).contains_attribute(Mesh::ATTRIBUTE_COLOR));
        let mut coat_ = app.world_mut().entity_mut(of.coat);
        if with_cloth {
            coat_.remove::<(Cloth, ClothSkin)>();
        } else {
            coat_.remove::<ClothSkin>();
        }
        updates(&mut app, 2);
        let entity = app.world().entity(of.coat);
        assert_eq!(entity.get::<SkinnedMesh>().unwrap().joints, of.joints);
        assert!(entity.contains::<DynamicSkinnedMeshBounds>());
        assert!(drawn(&app, of.coat).contains_attribute(Mesh::ATTRIBUTE_JOINT_INDEX));
        assert!(!entity.contains::<ClothSimulation>());
        // A cloth without its skin is told that it is skinned.
        assert_eq!(failure(&app, of.coat).is_some(), !with_cloth);
        // And on again.
        app.world_mut().entity_mut(of.coat).insert((Cloth::of_mesh3d(), usual()));
        updates(&mut app, 2);
        assert!(is_taken(&app, &of) && failure(&app, of.coat).is_none());
    }
}

#[test]
fn all_masks_say_the_same() {
    let list = (0..SIDE * SIDE).map(|vertex| 0.15 * freedom(vertex / SIDE)).collect();
    let limits = |map: SkinMap, mesh: fn() -> Mesh| {
        let mut app = app();
        let of = character(&mut app, mesh());
        let worn = ClothSkin { max_distance: map, ..default() };
        app.world_mut().entity_mut(of.coat).insert((Cloth::of_mesh3d(), worn));
        updates(&mut app, 2);
        assert_eq!(failure(&app, of.coat), None);
        simulation(&app, of.coat).skin_limits().unwrap().to_vec()
    };
    let by_list = limits(SkinMap::Data(list), coat);
    let close = |other: Vec<SkinLimit>| {
        let pairs = by_list.iter().zip(other);
        pairs.fold(0.0, |most: f32, (a, b)| most.max((a.max_distance - b.max_distance).abs()))
    };
    assert!(close(limits(SkinMap::color(ColorChannel::Red, 0.0, 0.15), coat)) < 0.15 / 255.0);
    assert!(close(limits(SkinMap::attribute("DRAPE_FREE", 0.0, 0.15), coat)) < 0.15 / 255.0);
    // A mask in the weights of a thigh: what the other joints have is no part of it.
    let weighted = || {
        let weights =
            (0..SIDE * SIDE).map(|v| [1.0 - freedom(v / SIDE), 0.0, freedom(v / SIDE), 0.0]);
        coat().with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights.collect::<Vec<_>>())
    };
    assert!(close(limits(SkinMap::joint_weight("thigh.r", 0.0, 0.15), weighted)) < 0.15 / 255.0);
    // What is infinite at one is so but for where it is zero.
    let ends = limits(SkinMap::color(ColorChannel::Red, 0.0, f32::INFINITY), coat);
    assert!(ends.iter().zip(&by_list).all(|(end, by)| {
        end.max_distance == if by.max_distance > 0.0 { f32::INFINITY } else { 0.0 }
    }));
}

#[test]
fn pins_without_an_anchor_hold_to_the_skin() {
    let mut app = app();
    let of = dressed(&mut app, ClothSkin::default());
    let last = (SIDE * (SIDE - 1)..SIDE * SIDE).collect::<Vec<_>>();
    app.world_mut().entity_mut(of.coat).insert(ClothPins::vertices((0..SIDE).chain(last.clone())));
    for tick in 0..40 {
        let skin = skinned(&mut app, &of);
        app.update();
        for particle in (0..SIDE).chain(last.clone()) {
            let off =
                position(&app, of.coat, particle as usize).distance(skin[particle as usize].0);
            assert!(off < 1e-5, "{tick} {particle}: {off}");
        }
        walk(&mut app, &of, tick as f32 / 64.0);
    }
    let middle = (SIDE * SIDE / 2) as usize;
    assert!(position(&app, of.coat, middle).distance(skinned(&mut app, &of)[middle].0) > 0.01);
}

#[test]
fn saved_and_loaded_it_goes_on_in_the_same_bits_in_either_form() {
    let mut all = Vec::new();
    for execution in [ClothExecution::Fused, ClothExecution::Staged] {
        let mut app = app();
        app.insert_resource(execution);
        let of = dressed(&mut app, ClothSkin { drive: 3.0.into(), ..usual() });
        app.world_mut().entity_mut(of.coat).insert(ClothInertia::new(0.5));
        let run = |app: &mut App, frames: core::ops::Range<u32>| {
            app.insert_resource(TimeUpdateStrategy::FixedTimesteps(3));
            for frame in frames {
                walk(app, &of, frame as f32 * 3.0 / 64.0);
                app.update();
            }
        };
        run(&mut app, 0..10);
        let saved = simulation(&app, of.coat).save();
        #[cfg(feature = "serialize")]
        let saved: ClothSnapshot =
            postcard::from_bytes(&postcard::to_allocvec(&saved).unwrap()).unwrap();
        let at = bits(&app, of.coat);
        run(&mut app, 10..30);
        let expected = bits(&app, of.coat);
        app.world_mut().entity_mut(of.coat).insert(saved);
        // A frame without ticks takes it over.
        app.insert_resource(TimeUpdateStrategy::FixedTimesteps(0));
        app.update();
        assert_eq!((failure(&app, of.coat), bits(&app, of.coat) == at), (None, true));
        run(&mut app, 10..30);
        assert_eq!(bits(&app, of.coat), expected, "{execution:?}");
        all.push(expected);
    }
    assert_eq!(all[0], all[1]);
    // The state of another skin is refused.
    let mut app = app();
    let of = dressed(&mut app, usual());
    let bare = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d::default()));
    let mesh = add_mesh(&mut app, coat());
    app.world_mut().entity_mut(bare).insert(Mesh3d(mesh));
    updates(&mut app, 3);
    let saved = simulation(&app, of.coat).save();
    app.world_mut().entity_mut(bare).insert(saved);
    app.update();
    let told = failure(&app, bare).map(|error| error.kind);
    assert!(matches!(told, Some(ClothErrorKind::Snapshot(_))), "{told:?}");
}

#[test]
fn jumps_carry_it_and_lifts_take_it_along() {
    let mut app = app();
    let of = dressed(&mut app, usual());
    updates(&mut app, 64);
    let shape = |app: &mut App| {
        let skin = skinned(app, &of);
        let all = positions(app, of.coat).into_iter().zip(skin);
        all.map(|(at, (place, _))| at - place).collect::<Vec<_>>()
    };
    let before = shape(&mut app);
    transform(&mut app, of.root).translation += Vec3::new(40.0, 3.0, -7.0);
    app.update();
    let off = farthest(&before, &shape(&mut app));
    assert!(off < 2e-3, "a jump moves it by {off}");
    // One that rides along feels nothing of how it is moved.
    app.world_mut().entity_mut(of.coat).insert(ClothInertia::new(0.0));
    for _ in 0..64 {
        transform(&mut app, of.root).translation += Vec3::new(0.2, 0.1, 0.0);
        app.update();
    }
    let off = farthest(&before, &shape(&mut app));
    assert!(off < 5e-3, "it is left behind by {off}");
}

#[test]
fn it_grows_with_its_skeleton() {
    let mut app = app();
    let of = dressed(&mut app, usual());
    updates(&mut app, 64);
    let width =
        |app: &App| position(app, of.coat, 0).distance(position(app, of.coat, SIDE as usize - 1));
    let rest = |app: &App| {
        let rest = simulation(app, of.coat).rest_positions();
        rest[0].distance(rest[SIDE as usize - 1])
    };
    for (scale, steps) in [(2.0, 64), (0.5, 1), (1.0, 1)] {
        let from = transform(&mut app, of.root).scale.x;
        for step in 1..=steps {
            let part = step as f32 / steps as f32;
            transform(&mut app, of.root).scale = Vec3::splat(from + (scale - from) * part);
            app.update();
        }
        updates(&mut app, 64);
        let skin = skinned(&mut app, &of);
        assert!((width(&app) - scale).abs() < 1e-3 * scale, "{scale}: {}", width(&app));
        assert!((rest(&app) - scale).abs() < 0.011 * scale, "{scale}: {}", rest(&app));
        let off = beyond(&app, &of, &skin, scale);
        assert!(off < 0.011 * 0.15 * scale, "{scale}: {off}");
        let strain = simulation(&app, of.coat).strain().max;
        assert!(strain < 0.05, "{scale}: {strain}");
    }
    // An uneven one is told, and the cloth stays what it is.
    transform(&mut app, of.root).scale = Vec3::new(1.0, 2.0, 1.0);
    updates(&mut app, 2);
    assert!(matches!(problem(&app, of.coat), Some(SkinProblem::UnevenScale { .. })));
    transform(&mut app, of.root).scale = Vec3::ONE;
    updates(&mut app, 2);
    assert_eq!(failure(&app, of.coat), None);
}

fn problem(app: &App, entity: Entity) -> Option<SkinProblem> {
    match failure(app, entity)?.kind {
        ClothErrorKind::Skin(problem) => Some(problem),
        _ => None,
    }
}

/// What a coat of this mesh is refused for, while another one goes on; it stays skinned.
#[track_caller]
fn refused(mesh: Mesh, worn: ClothSkin, change: impl Fn(&mut App, &Character)) -> SkinProblem {
    let mut app = app();
    let other = dressed(&mut app, usual());
    let of = character(&mut app, mesh);
    app.world_mut().entity_mut(of.coat).insert((Cloth::of_mesh3d(), worn));
    change(&mut app, &of);
    updates(&mut app, 3);
    assert!(app.world().get::<ClothSimulation>(of.coat).is_none());
    assert_eq!((failure(&app, other.coat), is_taken(&app, &other)), (None, true));
    assert!(
        !is_taken(&app, &of)
            || !drawn(&app, of.coat).contains_attribute(Mesh::ATTRIBUTE_JOINT_INDEX)
    );
    let told = failure(&app, of.coat).unwrap().to_string();
    assert!(told.contains(&of.coat.to_string()) && told.contains("ClothSkin"), "{told}");
    problem(&app, of.coat).unwrap()
}

#[test]
fn what_cannot_be_worn_is_told_with_what_to_do() {
    let count = (SIDE * SIDE) as usize;
    let nothing = |_: &mut App, _: &Character| {};
    let with_weights = |weights: [f32; 4]| {
        coat().with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![weights; count])
    };
    let mut bare = coat();
    bare.remove_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT);
    assert_eq!(refused(bare, usual(), nothing), SkinProblem::NoWeights);
    for weights in
        [[0.0; 4], [0.5, 0.2, 0.0, 0.0], [1.5, -0.5, 0.0, 0.0], [f32::NAN, 1.0, 0.0, 0.0]]
    {
        let problem = refused(with_weights(weights), usual(), nothing);
        assert!(matches!(problem, SkinProblem::Weights { vertex: 0, .. }), "{problem:?}");
    }
    let far = VertexAttributeValues::Uint16x4(vec![[0, 7, 2, 0]; count]);
    let far = coat().with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, far);
    assert!(matches!(
        refused(far, usual(), nothing),
        SkinProblem::NoSuchJoint { joint: 7, joints: 3, .. }
    ));
    let mut unpainted = coat();
    unpainted.remove_attribute(Mesh::ATTRIBUTE_COLOR);
    let field = "max_distance";
    assert_eq!(refused(unpainted, usual(), nothing), SkinProblem::NoColors { field });
    let by = |max_distance: SkinMap| ClothSkin { max_distance, ..default() };
    let problem = refused(coat(), by(SkinMap::attribute("NONE", 0.0, 1.0)), nothing);
    assert_eq!(problem, SkinProblem::NoAttribute { field, name: "NONE".into() });
    let problem = refused(coat(), by(SkinMap::joint_weight("tail", 0.0, 1.0)), nothing);
    assert_eq!(problem, SkinProblem::NoNamedJoint { field, name: "tail".into() });
    let problem = refused(coat(), by(SkinMap::Data(vec![1.0; 3])), nothing);
    assert_eq!(problem, SkinProblem::WrongLength { field, expected: count, got: 3 });
    for bad in [-1.0, f32::NAN] {
        let problem = refused(coat(), by(bad.into()), nothing);
        assert!(matches!(problem, SkinProblem::OutOfRange { particle: 0, .. }), "{problem:?}");
    }
    let flat = coat().with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0; 3]; count]);
    assert_eq!(refused(flat, usual(), nothing), SkinProblem::NoNormal { particle: 0 });
    let problem = refused(coat(), usual(), |app, of| {
        app.world_mut().entity_mut(of.coat).remove::<SkinnedMesh>();
    });
    assert_eq!(problem, SkinProblem::NotSkinned);
    let problem = refused(coat(), usual(), |app, of| {
        app.world_mut().entity_mut(of.coat).insert(Cloth::sheet(Vec2::ONE, UVec2::splat(4)));
    });
    assert_eq!(problem, SkinProblem::NotAMesh);
    let change = |change: fn(&mut App, &mut SkinnedMesh)| {
        move |app: &mut App, of: &Character| {
            let mut skinned = app.world().get::<SkinnedMesh>(of.coat).unwrap().clone();
            change(app, &mut skinned);
            app.world_mut().entity_mut(of.coat).insert(skinned);
        }
    };
    let problem =
        refused(coat(), usual(), change(|_, it| it.inverse_bindposes = Handle::default()));
    assert_eq!(problem, SkinProblem::NoBindposes);
    let fewer = change(|_, it| it.joints.truncate(2));
    assert_eq!(
        refused(coat(), usual(), fewer),
        SkinProblem::WrongBindposeCount { joints: 2, bindposes: 3 }
    );
    let many = change(|app, it| {
        it.inverse_bindposes = add_bindposes(app, &[Mat4::IDENTITY; 300]);
        it.joints = vec![it.joints[0]; 300];
    });
    assert_eq!(
        refused(coat(), usual(), many),
        SkinProblem::TooManyJoints { joints: 300, most: 256 }
    );
    for scale in [Vec3::new(1.0, 1.5, 1.0), Vec3::new(-1.0, 1.0, 1.0), Vec3::ZERO] {
        let problem =
            refused(coat(), usual(), move |app, of| transform(app, of.root).scale = scale);
        assert!(matches!(problem, SkinProblem::UnevenScale { .. }), "{problem:?}");
    }
    let problem = refused(coat(), usual(), |app, of| {
        app.world_mut().despawn(of.joints[2]);
    });
    assert!(matches!(problem, SkinProblem::JointGone(_)));
}

#[test]
fn a_worn_cloth_is_not_hung() {
    let mut app = app();
    let of = dressed(&mut app, usual());
    app.world_mut().entity_mut(of.coat).insert(HangOnStart::default());
    updates(&mut app, 1);
    let other = character(&mut app, coat());
    app.world_mut().entity_mut(other.coat).insert((
        Cloth::of_mesh3d(),
        usual(),
        HangOnStart::default(),
    ));
    app.update();
    let told = failure(&app, other.coat).map(|error| error.kind);
    assert_eq!(told, Some(ClothErrorKind::Hang(HangProblem::Worn)));
    updates(&mut app, 20);
    let skin = skinned(&mut app, &other);
    assert!(simulation(&app, other.coat).tick_count() > 10);
    assert!(beyond(&app, &other, &skin, 1.0) < CLOSE);
}

#[test]
fn what_mends_is_worn_and_what_breaks_goes_on() {
    let mut app = app();
    let of = character(&mut app, coat());
    transform(&mut app, of.root).scale = Vec3::new(1.0, 2.0, 1.0);
    app.world_mut().entity_mut(of.coat).insert((Cloth::of_mesh3d(), usual()));
    updates(&mut app, 2);
    assert!(matches!(problem(&app, of.coat), Some(SkinProblem::UnevenScale { .. })));
    transform(&mut app, of.root).scale = Vec3::ONE;
    updates(&mut app, 2);
    assert!(is_taken(&app, &of) && failure(&app, of.coat).is_none());
    // A map that cannot be used: the last good one stays.
    let limits = simulation(&app, of.coat).skin_limits().unwrap().to_vec();
    app.world_mut().entity_mut(of.coat).insert(ClothSkin { drive: f32::NAN.into(), ..usual() });
    updates(&mut app, 2);
    assert!(matches!(problem(&app, of.coat), Some(SkinProblem::OutOfRange { .. })));
    assert_eq!(simulation(&app, of.coat).skin_limits().unwrap(), limits);
    app.world_mut().entity_mut(of.coat).insert(ClothSkin { max_distance: 0.0.into(), ..usual() });
    updates(&mut app, 2);
    assert_eq!(failure(&app, of.coat), None);
    assert_eq!(simulation(&app, of.coat).pinned().len(), (SIDE * SIDE) as usize);
    // A joint that is gone stays where it was, and is told of.
    app.world_mut().despawn(of.joints[1]);
    let gone = of.joints[1];
    updates(&mut app, 3);
    assert_eq!(problem(&app, of.coat), Some(SkinProblem::JointGone(gone)));
    assert!(positions(&app, of.coat).iter().all(|at| at.is_finite() && at.length() < 2.0));
    let ticks = simulation(&app, of.coat).tick_count();
    // Another mesh, and another skeleton.
    let other = character(&mut app, coat());
    let skinned = app.world_mut().entity_mut(other.coat).take::<SkinnedMesh>().unwrap();
    app.world_mut().entity_mut(of.coat).insert((skinned, usual()));
    updates(&mut app, 2);
    assert!(is_taken(&app, &of) && failure(&app, of.coat).is_none());
    assert!(simulation(&app, of.coat).tick_count() < ticks);
    transform(&mut app, other.root).translation.x = 1.0;
    updates(&mut app, 2);
    assert!((position(&app, of.coat, 0).x - 0.5).abs() < 1e-5);
}

#[test]
fn garments_of_one_skeleton_do_not_disturb_each_other() {
    // A coat, and a second one over it that comes, is carried by a proxy, is swapped for another, and goes.
    let run = |second: bool| {
        let mut app = app();
        let of = dressed(&mut app, usual());
        let mut places = Vec::new();
        let mut other = None;
        for frame in 0..120 {
            walk(&mut app, &of, frame as f32 / 64.0);
            match frame {
                10 if second => {
                    let binds = bind_places().map(|at| Mat4::from_translation(-at));
                    let inverse_bindposes = add_bindposes(&mut app, &binds);
                    let skinned = SkinnedMesh { inverse_bindposes, joints: of.joints.to_vec() };
                    let mesh = Mesh3d(add_mesh(&mut app, coat()));
                    let cloth = (Cloth::of_mesh3d(), usual(), ClothProxy::grid(5, 5));
                    other = Some(spawn(&mut app, (mesh, skinned, cloth, ChildOf(of.root))));
                }
                50 if second => {
                    let wider = coat().scaled_by(Vec3::new(1.1, 1.0, 1.2));
                    let mesh = Mesh3d(add_mesh(&mut app, wider));
                    app.world_mut().entity_mut(other.unwrap()).insert(mesh);
                }
                90 if second => _ = app.world_mut().despawn(other.take().unwrap()),
                _ => {}
            }
            app.update();
            if let (Some(other), true) = (other, frame > 12) {
                assert_eq!(failure(&app, other), None);
                let running = simulation(&app, other);
                assert_eq!(running.particle_count(), 25);
                let places = running.skin_places().unwrap();
                let limits = running.skin_limits().unwrap();
                for ((at, place), limit) in running.positions().zip(places).zip(limits) {
                    assert!(at.distance(*place) < limit.max_distance + CLOSE, "{frame}");
                }
                // Swapped, it is the other mesh that is drawn.
                let widest = |p: &Vec3| (p.x - transform_of(&app, &of).x).abs();
                assert!(drawn_positions(&app, other).iter().map(widest).fold(0.0, f32::max) < 3.0);
            }
            places.push(bits(&app, of.coat));
            assert_eq!(failure(&app, of.coat), None);
        }
        places
    };
    assert!(run(false) == run(true), "the first one has the same bits all the time");
}

fn transform_of(app: &App, of: &Character) -> Vec3 {
    app.world().get::<Transform>(of.root).unwrap().translation
}

/// A change of the simulated shape goes on where the cloth was; on another skeleton it begins where that is.
#[test]
fn another_skeleton_and_another_proxy_at_once_start_at_the_skeleton() {
    for more_joints in [false, true] {
        let mut app = app();
        let of = dressed(&mut app, usual());
        updates(&mut app, 10);
        let other = character(&mut app, coat());
        *transform(&mut app, other.root) = Transform::from_xyz(4.0, 0.0, 0.0);
        let mut skinned = app.world().get::<SkinnedMesh>(other.coat).unwrap().clone();
        if more_joints {
            skinned.joints.push(spawn(&mut app, (Transform::default(), ChildOf(other.root))));
            let binds = bind_places().map(|at| Mat4::from_translation(-at));
            let binds: Vec<_> = binds.into_iter().chain([Mat4::IDENTITY]).collect();
            skinned.inverse_bindposes = add_bindposes(&mut app, &binds);
        }
        app.world_mut().entity_mut(of.coat).insert((skinned, ClothProxy::grid(5, 5)));
        for _ in 0..10 {
            app.update();
            let strain = simulation(&app, of.coat).strain().max;
            assert!(strain < 0.02, "{more_joints}: {strain}");
        }
        assert_eq!(failure(&app, of.coat), None);
        let places = positions(&app, of.coat);
        assert_eq!(places.len(), 25);
        assert!(places.iter().all(|place| (place.x - 4.0).abs() < 0.8), "{:?}", places[0]);
    }
}

/// A limb that is torn off is a joint of the same skeleton: the coat goes on with another shape.
#[test]
fn a_joint_with_another_parent_is_of_the_same_skeleton() {
    let mut app = app();
    let of = dressed(&mut app, usual());
    updates(&mut app, 20);
    let before = simulation(&app, of.coat).tick_count();
    app.world_mut().entity_mut(of.joints[1]).insert(ChildOf(of.root));
    transform(&mut app, of.joints[1]).translation.y += 1.0;
    updates(&mut app, 2);
    app.world_mut().entity_mut(of.coat).insert(ClothProxy::grid(5, 5));
    updates(&mut app, 2);
    assert_eq!(simulation(&app, of.coat).particle_count(), 25);
    assert_eq!(simulation(&app, of.coat).tick_count(), before + 4);
}

#[test]
fn a_skinned_mesh_without_its_joints_is_told_of_once() {
    for is_old_gone in [false, true] {
        let mut app = app();
        let of = dressed(&mut app, usual());
        let other = character(&mut app, coat());
        let skinned = app.world().get::<SkinnedMesh>(other.coat).unwrap().clone();
        app.world_mut().despawn(other.root);
        let told = count_told(&mut app);
        app.world_mut().entity_mut(of.coat).remove::<ChildOf>().insert(skinned);
        if is_old_gone {
            app.world_mut().despawn(of.root);
        }
        updates(&mut app, 30);
        assert!(matches!(problem(&app, of.coat), Some(SkinProblem::JointGone(_))));
        let told = told.load(Ordering::Relaxed);
        assert!(told <= if is_old_gone { 3 } else { 1 }, "{told}");
    }
}

#[test]
fn a_mesh_that_comes_as_it_is_taken_off_stays() {
    let ways: [fn(&mut EntityCommands); 2] = [
        |it| {
            it.remove::<ClothSkin>();
        },
        |it| {
            it.remove::<Cloth>();
        },
    ];
    for undress in ways {
        let mut app = app();
        let of = dressed(&mut app, usual());
        updates(&mut app, 5);
        let mesh = add_mesh(&mut app, coat());
        let mut commands = app.world_mut().commands();
        let mut commands = commands.entity(of.coat);
        commands.insert(Mesh3d(mesh.clone()));
        undress(&mut commands);
        app.world_mut().flush();
        updates(&mut app, 3);
        assert_eq!(app.world().get::<Mesh3d>(of.coat).unwrap().0, mesh);
        assert!(app.world().entity(of.coat).contains::<SkinnedMesh>());
    }
}
