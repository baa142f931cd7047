//! Colliders of distance fields: loaded from files, waited for, and told of when they never come.

use crate::support::app::*;
use bevy::{asset::AssetLoadError, prelude::*, tasks::futures_lite::future::yield_now};
use bevy_drape::{
    ClothError, ClothErrorKind, FieldProblem,
    prelude::*,
    sdf::{BakeSettings, DistanceField, SavedFieldError},
};
use std::{
    fs,
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

/// A cube of a metre.
fn cube() -> DistanceField {
    let mesh = box_mesh(0.5);
    let positions = attribute(&mesh, Mesh::ATTRIBUTE_POSITION);
    let indices: Vec<_> = mesh.indices().unwrap().iter().map(|i| i as u32).collect();
    let settings = BakeSettings { cell_size: 0.0625, margin: 0.125 };
    DistanceField::bake(&positions, &indices, &settings).unwrap()
}

/// An empty folder for a test's assets.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn load(app: &App, file: &'static str) -> Handle<DistanceField> {
    app.world().resource::<AssetServer>().load(file)
}

fn fields(app: &mut App) -> Mut<'_, Assets<DistanceField>> {
    app.world_mut().resource_mut()
}

fn is_there(app: &App, field: &Handle<DistanceField>) -> bool {
    app.world().resource::<Assets<DistanceField>>().contains(field)
}

fn field_problem(app: &App, collider: Entity) -> Option<FieldProblem> {
    match failure(app, collider)? {
        ClothError { entity, kind: ClothErrorKind::Field(problem) } if entity == collider => {
            Some(problem)
        }
        other => panic!("{other}"),
    }
}

/// A sheet just above the cube.
fn above(app: &mut App) -> Entity {
    spawn(app, (sheet(), Transform::from_xyz(0.0, 0.52, 0.0)))
}

/// Whether the sheet lies on the cube.
fn rests(app: &App, cloth: Entity) -> bool {
    (position(app, cloth, 27).y - 0.505).abs() < 5e-3
}

#[test]
fn a_saved_field_is_loaded_and_carries() {
    let folder = folder("carries");
    fs::write(folder.join("cube.sdf"), cube().to_bytes()).unwrap();
    let mut app = app_in(&folder);
    let field = load(&app, "cube.sdf");
    let collider = spawn(&mut app, SdfCollider::field(field.clone()));
    wait(&mut app, |app| is_there(app, &field));
    assert_eq!(fields(&mut app).get(&field), Some(&cube()));
    let cloth = above(&mut app);
    updates(&mut app, 40);
    assert!(rests(&app, cloth), "{}", position(&app, cloth, 27));
    assert_eq!(failure(&app, collider), None);
}

#[test]
fn a_field_that_is_loading_is_waited_for() {
    let mut app = app();
    let open = Arc::new(AtomicBool::new(false));
    let gate = open.clone();
    let field = app.world().resource::<AssetServer>().add_async(async move {
        while !gate.load(Ordering::Acquire) {
            yield_now().await;
        }
        Ok::<_, AssetLoadError>(cube())
    });
    let collider = spawn(&mut app, SdfCollider::field(field.clone()));
    let early = above(&mut app);
    updates(&mut app, 30);
    // Free fall, and nothing is amiss.
    assert!(position(&app, early, 27).y < 0.0);
    assert_eq!(failure(&app, collider), None);
    open.store(true, Ordering::Release);
    wait(&mut app, |app| is_there(app, &field));
    let cloth = above(&mut app);
    updates(&mut app, 40);
    assert!(rests(&app, cloth));
    assert_eq!((failure(&app, collider), failure(&app, cloth)), (None, None));
}

#[test]
fn files_that_are_no_fields_are_told_to_their_colliders_alone() {
    let good = cube().to_bytes();
    let mut damaged = good.clone();
    damaged[1000] ^= 4;
    let mut newer = good.clone();
    newer[8] = 9;
    let files: [(&str, Option<&[u8]>, Option<SavedFieldError>); 5] = [
        ("damaged.sdf", Some(&damaged), Some(SavedFieldError::Damaged { part: "distances" })),
        ("header.sdf", Some(&newer), Some(SavedFieldError::Damaged { part: "header" })),
        ("foreign.sdf", Some(b"v 0 0 0"), Some(SavedFieldError::Foreign)),
        (
            "short.sdf",
            Some(&good[..500]),
            Some(SavedFieldError::Truncated { expected: good.len(), found: 500 }),
        ),
        ("none.sdf", None, None),
    ];
    let folder = folder("refused");
    fs::write(folder.join("good.sdf"), &good).unwrap();
    let mut app = app_in(&folder);
    let mut told = Vec::new();
    for (name, bytes, problem) in files {
        if let Some(bytes) = bytes {
            fs::write(folder.join(name), bytes).unwrap();
        }
        let collider = SdfCollider::field(load(&app, name));
        told.push((name, spawn(&mut app, collider), problem));
    }
    let field = load(&app, "good.sdf");
    let carrier = spawn(&mut app, SdfCollider::field(field.clone()));
    wait(&mut app, |app| {
        is_there(app, &field)
            && told.iter().all(|(_, collider, _)| failure(app, *collider).is_some())
    });
    for (name, collider, content) in &told {
        let message = failure(&app, *collider).unwrap().to_string();
        assert!(message.contains(&collider.to_string()) && message.contains(name), "{message}");
        match (field_problem(&app, *collider).unwrap(), content) {
            (FieldProblem::Content { path, problem }, Some(expected)) => {
                assert_eq!((path.as_str(), &problem), (*name, expected));
            }
            (FieldProblem::LoadFailed { path, .. }, None) => assert_eq!(path, *name),
            (other, _) => panic!("{name}: {other}"),
        }
    }
    let cloth = above(&mut app);
    updates(&mut app, 40);
    assert!(rests(&app, cloth));
    assert_eq!((failure(&app, carrier), failure(&app, cloth)), (None, None));
    // Mended by another shape.
    let mended = told[0].1;
    app.world_mut().get_mut::<SdfCollider>(mended).unwrap().shape = SdfShape::Field(field);
    app.update();
    assert_eq!(failure(&app, mended), None);
}

#[test]
fn fields_that_nothing_brings_are_told_of() {
    let mut app = app();
    let added = fields(&mut app).add(cube());
    let promised = fields(&mut app).reserve_handle();
    let nowhere = spawn(&mut app, SdfCollider::field(Handle::default()));
    let late = spawn(&mut app, SdfCollider::field(promised.clone()));
    let removed = spawn(&mut app, SdfCollider::field(added.clone()));
    updates(&mut app, 2);
    assert_eq!(field_problem(&app, removed), None);
    fields(&mut app).remove(&added);
    let falls = above(&mut app);
    updates(&mut app, 20);
    for collider in [nowhere, late, removed] {
        assert_eq!(field_problem(&app, collider), Some(FieldProblem::Missing));
        assert!(failure(&app, collider).unwrap().to_string().contains(&collider.to_string()));
    }
    assert!(position(&app, falls, 27).y < 0.3);
    assert_eq!(failure(&app, falls), None);
    // What is added after all is used.
    fields(&mut app).insert(&promised, cube()).unwrap();
    let cloth = above(&mut app);
    updates(&mut app, 40);
    assert!(rests(&app, cloth));
    assert_eq!(failure(&app, late), None);
    assert!(failure(&app, nowhere).is_some());
}
