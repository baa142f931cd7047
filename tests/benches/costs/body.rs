//! The body of a character: what its capsules cost, and what of its skin they leave outside.

use crate::{
    app::{app_of, update},
    turns::{Bound, Wrong, heading, in_turns, line},
};
use bevy::{
    asset::{AssetPlugin, LoadState},
    ecs::system::RunSystemOnce,
    mesh::{
        Indices, VertexAttributeValues,
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
};
use bevy_drape::{BodyCapsule, ClothBody};
use examples_common::add_gltf;
use std::{path::Path, time::Duration};

/// Updates that a file may take to load, of a hundredth of a second at least.
const PATIENCE: usize = 1000;
/// How long fitting may take, once for a character \[us\].
const LONGEST: f64 = 5000.0;
/// Vertices that are outside by more than this, on an adult whose skin has [`ADULT`], count as left out \[m\].
const LEFT_OUT: f32 = 0.02;
/// The skin of an adult \[m^2\].
const ADULT: f32 = 1.8;
/// The part of the vertices that may be left out.
const MOST_LEFT_OUT: f32 = 0.05;

/// Fits the bodies of glTF files again and again.
pub fn bodies_of(files: &[impl AsRef<Path>], rounds: usize, wrong: &mut Wrong) {
    heading("an update in which capsules are fitted, us", "without", "with");
    for file in files {
        let file = file.as_ref();
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        match character(file) {
            Ok((app, body)) => fit_again(app, body, &name, rounds, wrong),
            Err(error) => wrong.unless(false, &name, &error),
        }
    }
}

/// An app with the character of a file, with its capsules.
fn character(file: &Path) -> Result<(App, Entity), String> {
    let file = file.canonicalize().map_err(|error| error.to_string())?;
    let (folder, name) = (file.parent().ok_or("it is a folder")?, file.file_name());
    let file_path = folder.to_string_lossy().into();
    let mut app = app_of(Some(AssetPlugin { file_path, ..default() }), add_gltf);
    let name = name.unwrap_or_default().to_string_lossy().into_owned();
    let scene: Handle<WorldAsset> =
        app.world().load_asset(GltfAssetLabel::Scene(0).from_asset(name));
    let id = scene.id();
    let place = (Transform::default(), Visibility::default());
    let body = app.world_mut().spawn((WorldAssetRoot(scene), ClothBody::default(), place)).id();
    for _ in 0..PATIENCE {
        app.update();
        if capsules(&app, body).is_some() {
            return Ok((app, body));
        }
        // One with textures takes an app that reads images.
        if let Some(LoadState::Failed(error)) =
            app.world().resource::<AssetServer>().get_load_state(id)
        {
            return Err(error.to_string().lines().next().unwrap_or_default().into());
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    Err("no capsules were fitted".into())
}

fn capsules(app: &App, body: Entity) -> Option<&Vec<BodyCapsule>> {
    app.world().get::<ClothBody>(body)?.capsules.as_ref()
}

fn fit_again(app: App, body: Entity, name: &str, rounds: usize, wrong: &mut Wrong) {
    let before = capsules(&app, body).cloned();
    let app = std::cell::RefCell::new(app);
    let without = || update(&mut app.borrow_mut());
    let with = || {
        let mut app = app.borrow_mut();
        if let Some(mut body) = app.world_mut().get_mut::<ClothBody>(body) {
            body.capsules = None;
        }
        update(&mut app)
    };
    let turns = in_turns(rounds, without, with);
    line(name, &turns, Bound::Each(LONGEST, 1));
    let mut app = app.into_inner();
    wrong.unless(capsules(&app, body) == before.as_ref(), name, "other capsules each time");
    let count = before.map_or(0, |it| it.len());
    let Seen { vertices, outside } = look(&mut app);
    let part = outside as f32 / vertices.max(1) as f32;
    println!(
        "  {vertices} vertices, {count} capsules, {:.2} % outside by more than 2 cm",
        1e2 * part
    );
    wrong.unless(vertices > 0 && part <= MOST_LEFT_OUT, name, "too much of its skin is outside");
}

/// The skin that capsules leave outside.
struct Seen {
    vertices: usize,
    outside: usize,
}

/// Goes through the skin of all characters, where their joints are.
fn look(app: &mut App) -> Seen {
    app.world_mut().run_system_once(left_out).expect("meshes and poses are there")
}

fn left_out(
    skinned: Query<(&SkinnedMesh, &Mesh3d)>,
    bodies: Query<&ClothBody>,
    transforms: TransformHelper,
    meshes: Res<Assets<Mesh>>,
    bindposes: Res<Assets<SkinnedMeshInverseBindposes>>,
) -> Seen {
    let global = |joint| transforms.compute_global_transform(joint).ok().map(|it| it.to_matrix());
    let (mut places, mut area) = (Vec::new(), 0.0);
    for (skin, mesh) in &skinned {
        let (Some(mesh), Some(inverses)) =
            (meshes.get(mesh), bindposes.get(&skin.inverse_bindposes))
        else {
            continue;
        };
        let joints: Vec<_> = skin.joints.iter().map(|it| global(*it).unwrap_or_default()).collect();
        let matrices: Vec<_> = joints.iter().zip(inverses.iter()).map(|(a, b)| *a * *b).collect();
        let skin = on_skin(mesh, &matrices).unwrap_or_default();
        area += area_of(mesh, &skin);
        places.extend(skin);
    }
    let capsules: Vec<_> = bodies.iter().flat_map(|body| body.capsules.iter().flatten()).collect();
    let solids: Vec<_> = capsules
        .iter()
        .filter_map(|it| Some((*it, global(it.joint)?)))
        .map(|(it, joint)| {
            let scale = joint.determinant().abs().cbrt();
            (joint.transform_point3(it.from), joint.transform_point3(it.to), it.radius * scale)
        })
        .collect();
    let far = LEFT_OUT * (area / ADULT).sqrt();
    let is_outside = |place: &&Vec3| {
        let outside = |&(from, to, radius): &(Vec3, Vec3, f32)| {
            let along = to - from;
            let part = (**place - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
            place.distance(from + along * part.clamp(0.0, 1.0)) - radius
        };
        solids.iter().all(|solid| outside(solid) > far)
    };
    Seen { vertices: places.len(), outside: places.iter().filter(is_outside).count() }
}

/// Where the vertices of a mesh are, by the formula of shaders.
fn on_skin(mesh: &Mesh, matrices: &[Mat4]) -> Option<Vec<Vec3>> {
    let (
        VertexAttributeValues::Float32x3(places),
        VertexAttributeValues::Uint16x4(joints),
        VertexAttributeValues::Float32x4(weights),
    ) = (
        mesh.attribute(Mesh::ATTRIBUTE_POSITION)?,
        mesh.attribute(Mesh::ATTRIBUTE_JOINT_INDEX)?,
        mesh.attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT)?,
    )
    else {
        return None;
    };
    let place = |((place, joints), weights): ((&[f32; 3], &[u16; 4]), &[f32; 4])| {
        let sum = joints
            .iter()
            .zip(weights)
            .fold(Mat4::ZERO, |sum, (joint, weight)| sum + matrices[usize::from(*joint)] * *weight);
        sum.transform_point3(Vec3::from_array(*place))
    };
    Some(places.iter().zip(joints).zip(weights).map(place).collect())
}

fn area_of(mesh: &Mesh, places: &[Vec3]) -> f32 {
    let indices: Vec<usize> = match mesh.indices() {
        Some(Indices::U16(it)) => it.iter().map(|i| usize::from(*i)).collect(),
        Some(Indices::U32(it)) => it.iter().map(|i| *i as usize).collect(),
        None => (0..places.len()).collect(),
    };
    let (triangles, _) = indices.as_chunks::<3>();
    let double =
        |[a, b, c]: &[usize; 3]| (places[*b] - places[*a]).cross(places[*c] - places[*a]).length();
    triangles.iter().map(double).sum::<f32>() / 2.0
}
