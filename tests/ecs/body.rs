//! Bodies of characters. Truths: the capsules that the skin was made of; the formula of skinning for where they are; what was there
//! before, once the component is gone; and that what is refused is told to its own entity.

use crate::support::app::*;
use bevy::{
    ecs::system::RunSystemOnce,
    mesh::{
        VertexAttributeValues,
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
};
use bevy_drape::{
    BodyCapsule, BodyProblem, ClothBody, ClothBodyFitted, ClothErrorKind, ClothLayers, SdfShape,
    SkinProblem, prelude::*,
};
use std::f32::consts::TAU;

/// The thigh and the shin of a leg, in the frames of its joints, which are turned: from, to and radius \[m\].
const BONES: [(Vec3, Vec3, f32); 2] =
    [(Vec3::ZERO, Vec3::new(0.0, 0.0, 0.4), 0.08), (Vec3::ZERO, Vec3::new(0.0, 0.0, 0.38), 0.05)];

struct Leg {
    root: Entity,
    joints: [Entity; 2],
    mesh: Entity,
}

/// From the joints' frames to the mesh's, unposed: z goes down.
fn binds() -> [Mat4; 2] {
    let down = Quat::from_rotation_x(TAU / 4.0);
    [0.9, 0.45].map(|height| Mat4::from_rotation_translation(down, Vec3::Y * height))
}

/// A tube around a bone, closed by caps, with a joint that moves all of it.
fn tube((from, to, radius): (Vec3, Vec3, f32), joint: u16, into: &mut Vertices) {
    let first = into.positions.len() as u32;
    let bind = binds()[joint as usize];
    for ring in 0..16_u32 {
        let t = ring as f32 / 15.0;
        let (middle, angle) = match t {
            t if t < 0.25 => (from, (t - 0.25) * TAU),
            t if t > 0.75 => (to, (t - 0.75) * TAU),
            t => (from.lerp(to, 2.0 * t - 0.5), 0.0),
        };
        for step in 0..16_u32 {
            let (sin, cos) = (TAU * step as f32 / 16.0).sin_cos();
            let out = Vec3::new(cos * angle.cos(), sin * angle.cos(), angle.sin());
            into.positions.push(bind.transform_point3(middle + out * radius).to_array());
            into.joints.push([joint, 1 - joint, 0, 0]);
            into.weights.push([0.7, 0.3, 0.0, 0.0]);
            if ring < 15 {
                let at = |ring: u32, step: u32| first + ring * 16 + step % 16;
                let [a, b] = [at(ring, step), at(ring, step + 1)];
                let [c, d] = [at(ring + 1, step), at(ring + 1, step + 1)];
                into.indices.extend([a, b, c, b, d, c]);
            }
        }
    }
}

#[derive(Default)]
struct Vertices {
    positions: Vec<[f32; 3]>,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
    indices: Vec<u32>,
}

fn skin() -> Mesh {
    let mut all = Vertices::default();
    for (bone, joint) in BONES.into_iter().zip(0..) {
        tube(bone, joint, &mut all);
    }
    let joints = VertexAttributeValues::Uint16x4(all.joints);
    triangle_mesh(all.positions, all.indices)
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints)
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, all.weights)
}

/// A leg that is posed elsewhere than it was bound.
fn leg(app: &mut App, mesh: Mesh) -> Leg {
    let place = Transform::from_xyz(3.0, 0.2, -1.0).with_rotation(Quat::from_rotation_y(0.7));
    let root = spawn(app, (place, Visibility::default()));
    let hip = Transform::from_matrix(binds()[0]);
    let hip = spawn(app, (hip, Name::new("hip"), ChildOf(root)));
    let knee = Transform::from_matrix(binds()[0].inverse() * binds()[1])
        .with_rotation(Quat::from_rotation_x(0.5));
    let knee = spawn(app, (knee, Name::new("knee"), ChildOf(hip)));
    let joints = [hip, knee];
    let mut all = app.world_mut().resource_mut::<Assets<SkinnedMeshInverseBindposes>>();
    let poses = binds().map(|it| it.inverse()).to_vec();
    let inverse_bindposes = all.add(SkinnedMeshInverseBindposes::from(poses));
    let skinned = SkinnedMesh { inverse_bindposes, joints: joints.to_vec() };
    let mesh = Mesh3d(add_mesh(app, mesh));
    let mesh = spawn(app, (mesh, skinned, Transform::default(), ChildOf(root)));
    Leg { root, joints, mesh }
}

fn capsules(app: &App, body: Entity) -> Vec<BodyCapsule> {
    app.world().get::<ClothBody>(body).unwrap().capsules.clone().unwrap_or_default()
}

/// The ends and the radius of each collider in the world \[m\].
fn colliders(app: &mut App) -> Vec<(Vec3, Vec3, f32)> {
    let look = |colliders: Query<(Entity, &SdfCollider)>, transforms: TransformHelper| {
        let place = |(entity, collider): (Entity, &SdfCollider)| {
            let SdfShape::CapsuleBetween(capsule) = collider.shape else { panic!("a capsule") };
            let place = transforms.compute_global_transform(entity).unwrap();
            let ends = [capsule.from, capsule.to].map(|end| place.transform_point(end));
            (ends[0], ends[1], capsule.radius)
        };
        colliders.iter().map(place).collect::<Vec<_>>()
    };
    app.world_mut().run_system_once(look).unwrap()
}

/// Whether the colliders are those of the bones, where the joints are now.
fn are_on_bones(app: &mut App, of: &Leg) -> bool {
    let found = colliders(app);
    let joints = of.joints;
    let look = move |transforms: TransformHelper| {
        joints.map(|joint| transforms.compute_global_transform(joint).unwrap())
    };
    let joints = app.world_mut().run_system_once(look).unwrap();
    let is_there = |(joint, (from, to, radius)): (&GlobalTransform, (Vec3, Vec3, f32))| {
        let ends = [from, to].map(|end| joint.transform_point(end));
        found.iter().any(|(a, b, thick)| {
            let off = |ends: [Vec3; 2]| a.distance(ends[0]).max(b.distance(ends[1]));
            let off = off(ends).min(off([ends[1], ends[0]]));
            off < 2e-3 && (thick - radius).abs() < 2e-3
        })
    };
    found.len() == 2 && joints.iter().zip(BONES).all(is_there)
}

fn problem(app: &App, body: Entity) -> Option<BodyProblem> {
    match failure(app, body)?.kind {
        ClothErrorKind::Body(problem) => Some(problem),
        other => panic!("another problem: {other}"),
    }
}

#[derive(Resource, Default)]
struct Fitted(Vec<Entity>);

#[test]
fn a_body_has_the_capsules_that_its_skin_was_made_of_and_they_go_along() {
    let mut app = app();
    app.init_resource::<Fitted>().add_observer(
        |fitted: On<ClothBodyFitted>, mut all: ResMut<Fitted>| all.0.push(fitted.entity),
    );
    let of = leg(&mut app, skin());
    app.world_mut().entity_mut(of.root).insert(ClothBody::default());
    app.update();
    assert!(are_on_bones(&mut app, &of));
    assert_eq!(app.world().resource::<Fitted>().0, [of.root]);
    let joints: Vec<_> = capsules(&app, of.root).iter().map(|it| it.joint).collect();
    assert_eq!(joints, of.joints);
    transform(&mut app, of.root).translation.y = 5.0;
    transform(&mut app, of.joints[1]).rotation = Quat::from_rotation_x(1.5);
    updates(&mut app, 3);
    assert!(are_on_bones(&mut app, &of));
    assert_eq!(failure(&app, of.root), None);
    // On the entity of the mesh itself, and taken off again.
    app.world_mut().entity_mut(of.root).remove::<ClothBody>();
    updates(&mut app, 1);
    assert_eq!(colliders(&mut app), []);
    app.world_mut().entity_mut(of.mesh).insert(ClothBody::default());
    updates(&mut app, 1);
    assert!(are_on_bones(&mut app, &of));
    app.world_mut().entity_mut(of.mesh).despawn();
    updates(&mut app, 1);
    assert_eq!(colliders(&mut app), []);
}

/// A foot that is too small for a capsule of its own goes to the joint above.
#[test]
fn small_joints_go_to_the_ones_above() {
    let mut app = app();
    let mut all = Vertices::default();
    tube(BONES[0], 0, &mut all);
    tube((Vec3::ZERO, Vec3::Z * 0.01, 0.004), 1, &mut all);
    let joints = VertexAttributeValues::Uint16x4(all.joints);
    let mesh = triangle_mesh(all.positions, all.indices)
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints)
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, all.weights);
    let of = leg(&mut app, mesh);
    app.world_mut().entity_mut(of.root).insert(ClothBody::default());
    app.update();
    let found = capsules(&app, of.root);
    assert!(!found.is_empty() && found.iter().all(|it| it.joint == of.joints[0]), "{found:?}");
}

#[test]
fn a_game_drops_changes_and_adds_capsules() {
    let mut app = app();
    let of = leg(&mut app, skin());
    let trim = |fitted: On<ClothBodyFitted>, mut bodies: Query<&mut ClothBody>| {
        let mut body = bodies.get_mut(fitted.entity).unwrap();
        body.capsules.as_mut().unwrap().truncate(1);
    };
    app.world_mut().entity_mut(of.root).insert(ClothBody::default()).observe(trim);
    app.update();
    assert_eq!(colliders(&mut app).len(), 1);
    let body = |app: &mut App, change: &dyn Fn(&mut ClothBody, &mut Vec<BodyCapsule>)| {
        let mut body = app.world_mut().get_mut::<ClothBody>(of.root).unwrap();
        let mut capsules = body.capsules.clone().unwrap();
        change(&mut body, &mut capsules);
        body.capsules = Some(capsules);
        app.update();
    };
    let before = colliders(&mut app);
    body(&mut app, &|body, list| {
        body.friction = 0.1;
        body.layers = ClothLayers(8);
        list[0].radius += 0.02;
        list.push(BodyCapsule { joint: of.joints[1], from: Vec3::ZERO, to: Vec3::Z, radius: 0.3 });
    });
    let after = colliders(&mut app);
    assert_eq!(after.len(), 2);
    assert!((after[0].2 - before[0].2 - 0.02).abs() < 1e-6);
    let told = |colliders: Query<&SdfCollider>| {
        colliders.iter().map(|it| (it.friction, it.layers)).collect::<Vec<_>>()
    };
    let expected = [(0.1, ClothLayers(8)); 2];
    assert_eq!(app.world_mut().run_system_once(told).unwrap(), expected);
    // One that is not listed any more is gone.
    body(&mut app, &|_, list| list.truncate(1));
    assert_eq!(colliders(&mut app), [after[0]]);
    body(&mut app, &|_, list| list.push(list[0]));
    // What cannot be used is told of, and the others stay.
    body(&mut app, &|_, list| list[0].radius = f32::NAN);
    assert!(matches!(problem(&app, of.root), Some(BodyProblem::Capsule { capsule: 0, .. })));
    assert_eq!(colliders(&mut app).len(), 1);
    let stranger = spawn(&mut app, ());
    body(&mut app, &|_, list| (list[0].radius, list[1].joint) = (0.1, stranger));
    let expected = BodyProblem::JointGone { capsule: 1, joint: stranger };
    assert_eq!(problem(&app, of.root), Some(expected));
    assert_eq!(colliders(&mut app).len(), 1);
    body(&mut app, &|_, list| list.truncate(1));
    assert_eq!((problem(&app, of.root), colliders(&mut app).len()), (None, 1));
    // Anew, and trimmed again.
    app.world_mut().get_mut::<ClothBody>(of.root).unwrap().capsules = None;
    app.update();
    assert_eq!(colliders(&mut app), before);
    // What follows a joint that is gone is gone with it.
    app.world_mut().entity_mut(of.joints[0]).despawn();
    updates(&mut app, 2);
    assert_eq!(colliders(&mut app), []);
}

#[test]
fn clothes_are_no_part_of_the_body_and_lie_on_it() {
    let mut app = app();
    let of = leg(&mut app, skin());
    let stocking = {
        let skinned = app.world().get::<SkinnedMesh>(of.mesh).unwrap().clone();
        let mut mesh = skin();
        let Some(VertexAttributeValues::Float32x3(places)) =
            mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION)
        else {
            panic!("it has places")
        };
        places.iter_mut().for_each(|[x, _, z]| (*x, *z) = (1.5 * *x, 1.5 * *z));
        let mesh = Mesh3d(add_mesh(&mut app, mesh));
        spawn(&mut app, (mesh, skinned, Cloth::of_mesh3d(), Transform::default(), ChildOf(of.root)))
    };
    app.world_mut().entity_mut(of.root).insert(ClothBody::default());
    app.update();
    assert!(are_on_bones(&mut app, &of));
    // It is no garment without its component, and the body does not mind.
    assert!(failure(&app, stocking).is_some() && failure(&app, of.root).is_none());
}

#[test]
fn bodies_wait_for_their_meshes_and_tell_when_none_come() {
    let mut app = app();
    let body = spawn(&mut app, (Transform::default(), ClothBody::default()));
    updates(&mut app, 3);
    assert_eq!(failure(&app, body), None);
    // Ten seconds later, by the clock.
    app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(
        std::time::Duration::from_secs(6),
    ));
    updates(&mut app, 3);
    assert_eq!(problem(&app, body), Some(BodyProblem::NoSkinnedMesh));
    let of = leg(&mut app, skin());
    app.world_mut().entity_mut(of.root).insert(ChildOf(body));
    updates(&mut app, 2);
    assert_eq!(failure(&app, body), None);
    assert!(are_on_bones(&mut app, &of));
}

#[test]
fn meshes_that_cannot_be_read_are_told_of_and_taken_when_they_mend() {
    let refused = |mesh: Mesh| {
        let mut app = app();
        let of = leg(&mut app, mesh);
        app.world_mut().entity_mut(of.root).insert(ClothBody::default());
        updates(&mut app, 2);
        assert_eq!(colliders(&mut app), []);
        let problem = problem(&app, of.root).unwrap();
        // As soon as the mesh is good and it is looked at again.
        let good = Mesh3d(add_mesh(&mut app, skin()));
        app.world_mut().entity_mut(of.mesh).insert(good);
        updates(&mut app, 80);
        assert!(are_on_bones(&mut app, &of) && failure(&app, of.root).is_none());
        (of, problem)
    };
    let mut bare = skin();
    bare.remove_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT);
    let (of, found) = refused(bare);
    assert_eq!(found, BodyProblem::Mesh { mesh: of.mesh, problem: SkinProblem::NoWeights });
    let count = skin().count_vertices();
    let far = VertexAttributeValues::Uint16x4(vec![[9, 0, 0, 0]; count]);
    let (_, found) = refused(skin().with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, far));
    let problem = SkinProblem::NoSuchJoint { vertex: 0, joint: 9, joints: 2 };
    assert!(matches!(&found, BodyProblem::Mesh { problem: it, .. } if *it == problem), "{found}");
    let flat = skin().with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[1.0; 3]; count]);
    assert_eq!(refused(flat).1, BodyProblem::NoArea);
    let lost = skin().with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[f32::NAN; 3]; count]);
    let (_, found) = refused(lost);
    assert!(matches!(found, BodyProblem::Mesh { problem: SkinProblem::Mesh(_), .. }), "{found}");
}
