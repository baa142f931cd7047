//! What is said in the log: by what name, and what nothing but the log can say.

use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{ClothSelfCollision, prelude::*};
use std::{
    fmt,
    sync::{Mutex, Once, PoisonError},
};
use tracing::{
    Event, Metadata, Subscriber,
    field::{Field, Visit},
    span::{Attributes, Id, Record},
};

static SAID: Mutex<Vec<String>> = Mutex::new(Vec::new());
static BEGIN: Once = Once::new();

/// Keeps what is said, by any thread.
struct Listener;

impl Subscriber for Listener {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target().starts_with("bevy_drape") && !metadata.is_span()
    }

    fn event(&self, event: &Event<'_>) {
        struct Message(String);
        impl Visit for Message {
            fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
                if field.name() == "message" {
                    self.0 = format!("{value:?}");
                }
            }
        }
        let mut message = Message(String::new());
        event.record(&mut message);
        SAID.lock().unwrap_or_else(PoisonError::into_inner).push(message.0);
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }
    fn record(&self, _: &Id, _: &Record<'_>) {}
    fn record_follows_from(&self, _: &Id, _: &Id) {}
    fn enter(&self, _: &Id) {}
    fn exit(&self, _: &Id) {}
}

fn listen() {
    BEGIN.call_once(|| tracing::subscriber::set_global_default(Listener).expect("it is the first"));
}

/// What was said that has these words, by all tests.
fn said(words: &str) -> Vec<String> {
    let said = SAID.lock().unwrap_or_else(PoisonError::into_inner);
    said.iter().filter(|it| it.contains(words)).cloned().collect()
}

#[test]
fn an_error_gives_the_entitys_name_once() {
    listen();
    let mut app = app();
    let bad = ClothMaterial { friction: f32::NAN, ..default() };
    let cloth = spawn(&mut app, (Name::new("Robe of the third monk"), sheet(), bad));
    updates(&mut app, 5);
    let said = said("Robe of the third monk");
    assert_eq!(said.len(), 1, "{said:?}");
    for part in [&cloth.to_string(), "friction is NaN", "change `ClothMaterial`"] {
        assert!(said[0].contains(part), "{said:?}");
    }
}

#[test]
fn a_world_without_the_plugin_is_told_once() {
    listen();
    let words = "without `ClothPlugin`";
    // No other test leaves the plugin out.
    let mut app = app();
    spawn(&mut app, sheet());
    app.update();
    assert_eq!(said(words), [""; 0]);
    let mut bare = App::new();
    bare.add_plugins(MinimalPlugins);
    bare.add_systems(Startup, |mut commands: Commands| {
        commands.spawn_batch([sheet(), sheet()]);
    });
    bare.update();
    spawn(&mut bare, sheet());
    bare.update();
    assert_eq!(said(words).len(), 1, "{:?}", said(words));
}

#[test]
fn a_mesh_that_a_sheet_replaces_is_told_of() {
    listen();
    let mut app = app();
    let mesh = add_mesh(&mut app, Plane3d::default().mesh().build());
    spawn(&mut app, sheet());
    let loud = spawn(&mut app, (sheet(), Mesh3d(mesh)));
    updates(&mut app, 3);
    // From now on the mesh is the sheet's own.
    app.world_mut().entity_mut(loud).insert(Cloth::sheet(Vec2::ONE, UVec2::splat(4)));
    updates(&mut app, 3);
    // No other test gives a sheet a mesh.
    let said = said("the sheet replaces");
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].contains(&loud.to_string()), "{said:?}");
}

#[test]
fn a_cloth_that_is_tangled_is_told_of_once() {
    listen();
    let mut app = app();
    // A number that is no other test's.
    for _ in 0..977 {
        app.world_mut().spawn_empty();
    }
    let loop_ = add_mesh(&mut app, looped_mesh());
    let own = ClothSelfCollision::default();
    let flat = [spawn(&mut app, (sheet(), own)), spawn(&mut app, Cloth::of_mesh3d())];
    let flat_mesh = Mesh3d(add_mesh(&mut app, holed_mesh()));
    app.world_mut().entity_mut(flat[1]).insert((flat_mesh, own));
    let tangled = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d(loop_), own));
    let of = |cloth: Entity| said(&format!("cloth {cloth}: it is tangled"));
    wait(&mut app, |_| !of(tangled).is_empty());
    updates(&mut app, 20);
    assert_eq!(of(tangled).len(), 1);
    assert!(flat.iter().all(|cloth| of(*cloth).is_empty()));
}
