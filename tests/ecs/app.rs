//! The plugin in apps of all sorts.

use crate::support::app::*;
use bevy::{
    camera::visibility::VisibilityPlugin,
    ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel},
    prelude::*,
    reflect::GetPath,
    time::TimeUpdateStrategy,
};
use bevy_drape::{
    ClothDiagnosticsPlugin, ClothError, ClothErrorKind, ClothExecution, ClothSubstep, prelude::*,
};
use std::time::Duration;

#[test]
fn bare_minimal_plugins_are_enough() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, ClothPlugin::default()));
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 0.4, 0.0)));
    let mesh = spawn(&mut app, Cloth::of_mesh3d());
    let solid = spawn(&mut app, BakeSdf::default());
    spawn(&mut app, SdfCollider::from(Sphere::new(0.3)));
    app.finish();
    app.cleanup();
    updates(&mut app, 30);
    assert_eq!(simulation(&app, cloth).tick_count(), 29);
    assert!(positions(&app, cloth).iter().all(|p| p.length() > 0.3));
    assert!(app.world().get::<Mesh3d>(cloth).is_none());
    for entity in [mesh, solid] {
        let error = failure(&app, entity).expect("there are no meshes").to_string();
        assert!(error.contains("MeshPlugin"), "{error}");
    }
}

fn forbid_ambiguities(app: &mut App, label: impl ScheduleLabel) {
    app.edit_schedule(label, |schedule| {
        schedule.set_build_settings(ScheduleBuildSettings {
            ambiguity_detection: LogLevel::Error,
            hierarchy_detection: LogLevel::Error,
            ..default()
        });
    });
}

#[test]
fn no_order_is_left_to_chance() {
    let mut app = app_with((ClothPlugin::default(), VisibilityPlugin, ClothDiagnosticsPlugin));
    forbid_ambiguities(&mut app, FixedPostUpdate);
    forbid_ambiguities(&mut app, PostUpdate);
    forbid_ambiguities(&mut app, RunFixedMainLoop);
    forbid_ambiguities(&mut app, ClothSubstep);
    app.insert_resource(ClothExecution::Staged);
    let cloth = spawn(&mut app, sheet());
    // An ambiguous schedule does not build, and the frame panics.
    updates(&mut app, 2);
    assert_eq!(simulation(&app, cloth).tick_count(), 2);
}

#[test]
fn any_schedule_of_the_fixed_loop_will_do() {
    let mut app = app_with(ClothPlugin::new(FixedUpdate));
    let cloth = spawn(&mut app, sheet());
    updates(&mut app, 5);
    assert_eq!(simulation(&app, cloth).tick_count(), 5);
}

#[test]
fn a_variable_step_is_refused() {
    let mut app = app_with(ClothPlugin::new(Update));
    let cloth = spawn(&mut app, sheet());
    for frame in 5..15 {
        set_frame(&mut app, Duration::from_millis(frame));
        app.update();
    }
    assert_eq!(simulation(&app, cloth).tick_count(), 0);
    assert!(matches!(
        failure(&app, cloth),
        Some(ClothError { kind: ClothErrorKind::VariableStep, .. })
    ));
}

#[test]
fn a_paused_game_stands_still() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet());
    updates(&mut app, 5);
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    let before = bits(&app, cloth);
    updates(&mut app, 5);
    assert_eq!(bits(&app, cloth), before);
    assert_eq!(failure(&app, cloth), None);
}

#[test]
fn components_are_registered() {
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    for name in [
        "Cloth",
        "ClothMaterial",
        "ClothSettings",
        "ClothPins",
        "ClothWeights",
        "ClothInterpolation",
        "ClothAir",
        "ClothSelfCollision",
        "ClothInterCollision",
        "ClothWindOverride",
        "WindZone",
        "ClothGravityOverride",
        "ClothTeleport",
        "ClothInertia",
        "ClothCulling",
        "ClothLod",
        "ClothProxy",
        "ClothBudget",
        "ClothSleepThreshold",
        "ClothPaused",
        "ClothForces",
        "ClothGrab",
        "HangOnStart",
        "ClothSnapshot",
        "ClothSimulation",
        "ClothFailure",
        "SdfCollider",
        "SdfColliderDisabled",
        "SdfColliderSnapshot",
        "ColliderImpulse",
        "BakeSdf",
    ] {
        let known = registry.get_with_short_type_path(name);
        let known = known.unwrap_or_else(|| panic!("{name} is not registered"));
        assert!(known.data::<ReflectComponent>().is_some(), "{name}");
    }
    for name in ["ClothGravity", "ClothWind", "ClothExecution"] {
        let known = registry.get_with_short_type_path(name);
        let known = known.unwrap_or_else(|| panic!("{name} is not registered"));
        assert!(known.data::<ReflectResource>().is_some(), "{name}");
    }
}

#[test]
fn an_inspector_sees_a_running_cloth() {
    let mut app = app();
    let material = ClothMaterial { thickness: 0.007, ..default() };
    let cloth = spawn(&mut app, (sheet(), material));
    updates(&mut app, 5);
    let simulation = simulation(&app, cloth);
    assert_eq!(simulation.path::<u64>("progress.tick_count"), Ok(&simulation.tick_count()));
    assert_eq!(simulation.path::<f32>("in_force.material.thickness"), Ok(&0.007));
    assert_eq!(simulation.path::<bool>("progress.quarantined"), Ok(&false));
}

#[test]
fn components_can_be_written_in_scenes() {
    fn has_template<T: FromTemplate>() {}
    has_template::<Cloth>();
    has_template::<WindZone>();
    has_template::<ClothMaterial>();
    has_template::<ClothPins>();
    has_template::<ClothSettings>();
    let mut app = app();
    let cloth = spawn(&mut app, Cloth::default());
    spawn(&mut app, (SdfCollider::default(), Transform::from_xyz(0.0, -0.6, 0.0)));
    spawn(&mut app, WindZone::default());
    updates(&mut app, 30);
    assert_eq!(failure(&app, cloth), None);
    assert_eq!(simulation(&app, cloth).particle_count(), 1024);
    assert!(position(&app, cloth, 0).y < -0.1);
}
