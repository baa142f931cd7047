//! The panel without its window: what it gathers is what the components and closed forms say, and what it is
//! asked for is what the components become.

use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{
    ClothGravityOverride, ClothInterCollision, ClothPanel, ClothPanelModelPlugin,
    ClothSelfCollision, ClothWindOverride, PanelAction, PanelFacts, PanelHistory, explain,
    load_material, prelude::*, save_material,
};
use std::{fs, path::Path};

fn panel_app() -> App {
    app_with((ClothPlugin::default(), ClothPanelModelPlugin))
}

fn panel(app: &App) -> &ClothPanel {
    app.world().resource()
}

fn facts(app: &App) -> &PanelFacts {
    panel(app).facts().expect("there is a cloth")
}

fn ask(app: &mut App, action: PanelAction) {
    app.world_mut().resource_mut::<ClothPanel>().ask(action);
    app.update();
}

fn has<C: Component + Clone>(app: &App, entity: Entity) -> Option<C> {
    app.world().get::<C>(entity).cloned()
}

#[test]
fn it_chooses_among_the_cloths() {
    let mut app = panel_app();
    app.update();
    assert_eq!(panel(&app).facts(), None);
    let first = spawn(&mut app, (sheet(), Name::new("cape"), ClothMaterial::SILK));
    let second =
        spawn(&mut app, (sheet(), ClothMaterial::DENIM, Transform::from_xyz(0.0, 9.0, 0.0)));
    updates(&mut app, 3);
    let it = facts(&app);
    assert_eq!((it.chosen, it.material, it.particle_count), (first, ClothMaterial::SILK, 64));
    let names: Vec<_> = it.cloths.iter().map(|(entity, name)| (*entity, name.as_str())).collect();
    assert_eq!(names, [(first, "cape"), (second, &*format!("cloth {second}"))]);
    ask(&mut app, PanelAction::Choose(second));
    assert_eq!((facts(&app).chosen, facts(&app).material), (second, ClothMaterial::DENIM));
    // One that is gone is not kept to.
    app.world_mut().despawn(second);
    app.update();
    assert_eq!(facts(&app).chosen, first);
    app.world_mut().despawn(first);
    app.update();
    assert_eq!(panel(&app).facts(), None);
    ask(&mut app, PanelAction::Reset);
}

#[test]
fn it_changes_the_components() {
    let mut app = panel_app();
    let cloth = spawn(&mut app, sheet());
    updates(&mut app, 2);
    let settings = ClothSettings::ACCURATE;
    let pins = ClothPins::from(PinSelection::Corners);
    let air = ClothAir { lift: 2.0, ..default() };
    let own = ClothSelfCollision { friction: 0.2, ..default() };
    let others = ClothInterCollision { friction: 0.3, ..default() };
    let wind = ClothWind::steady(Vec3::X * 3.0);
    for action in [
        PanelAction::SetMaterial(ClothMaterial::WOOL),
        PanelAction::SetSettings(settings),
        PanelAction::SetPins(pins.clone()),
        PanelAction::SetAir(Some(air)),
        PanelAction::SetSelfCollision(Some(own)),
        PanelAction::SetInterCollision(Some(others)),
        PanelAction::SetWind(wind),
        PanelAction::SetGravity(Vec3::NEG_Y),
    ] {
        ask(&mut app, action);
    }
    assert_eq!(has::<ClothMaterial>(&app, cloth), Some(ClothMaterial::WOOL));
    assert_eq!(has::<ClothSettings>(&app, cloth), Some(settings));
    assert_eq!(has::<ClothPins>(&app, cloth), Some(pins.clone()));
    assert_eq!(has::<ClothAir>(&app, cloth), Some(air));
    assert_eq!(has::<ClothSelfCollision>(&app, cloth), Some(own));
    assert_eq!(has::<ClothInterCollision>(&app, cloth), Some(others));
    assert_eq!(*app.world().resource::<ClothWind>(), wind);
    assert_eq!(app.world().resource::<ClothGravity>().0, Vec3::NEG_Y);
    // In the frame that asked, so that a slider that is dragged goes on from there.
    let it = facts(&app);
    assert_eq!((it.material, it.settings, &it.pins), (ClothMaterial::WOOL, settings, &pins));
    assert_eq!((it.air, it.wind, it.gravity), (Some(air), wind, Vec3::NEG_Y));
    assert_eq!((it.self_collision, it.inter_collision), (Some(own), Some(others)));
    assert!((it.spacing - 1.0 / 7.0).abs() < 1e-6);
    // And the running cloth follows.
    updates(&mut app, 2);
    assert_eq!(simulation(&app, cloth).pinned(), [0, 7, 56, 63]);
    assert_eq!(simulation(&app, cloth).plan().substeps, 32);
    let said = explain(simulation(&app, cloth).plan(), &ClothMaterial::WOOL);
    assert!(said.iter().any(|line| line.contains("Layers of cloth")), "{said:?}");
    ask(&mut app, PanelAction::SetSelfCollision(None));
    assert_eq!(has::<ClothSelfCollision>(&app, cloth), None);
    ask(&mut app, PanelAction::SetInterCollision(None));
    assert_eq!(has::<ClothInterCollision>(&app, cloth), None);
    ask(&mut app, PanelAction::SetAir(None));
    assert_eq!(has::<ClothAir>(&app, cloth), None);
}

#[test]
fn what_a_cloth_has_of_its_own_is_changed_there() {
    let mut app = panel_app();
    let own = (ClothGravityOverride(Vec3::X), ClothWindOverride::default());
    let cloth = spawn(&mut app, (sheet(), own));
    updates(&mut app, 2);
    assert_eq!(facts(&app).gravity, Vec3::X);
    let wind = ClothWind::steady(Vec3::Z);
    ask(&mut app, PanelAction::SetGravity(Vec3::Y));
    ask(&mut app, PanelAction::SetWind(wind));
    assert_eq!(has::<ClothGravityOverride>(&app, cloth), Some(ClothGravityOverride(Vec3::Y)));
    assert_eq!(has::<ClothWindOverride>(&app, cloth), Some(ClothWindOverride(wind)));
    assert_eq!(*app.world().resource::<ClothGravity>(), ClothGravity::default());
    assert_eq!(*app.world().resource::<ClothWind>(), ClothWind::default());
}

#[test]
fn it_pauses_steps_and_resets() {
    let mut app = panel_app();
    let cloth = spawn(&mut app, sheet());
    updates(&mut app, 10);
    ask(&mut app, PanelAction::Pause(true));
    let ticks = simulation(&app, cloth).tick_count();
    updates(&mut app, 5);
    assert_eq!(simulation(&app, cloth).tick_count(), ticks);
    assert!(facts(&app).paused);
    ask(&mut app, PanelAction::Step);
    ask(&mut app, PanelAction::Step);
    updates(&mut app, 5);
    assert_eq!(simulation(&app, cloth).tick_count(), ticks + 2);
    // Paused again it does not lose what it has.
    ask(&mut app, PanelAction::Pause(true));
    ask(&mut app, PanelAction::Pause(false));
    updates(&mut app, 2);
    assert!(simulation(&app, cloth).tick_count() > ticks + 2 && !facts(&app).paused);
    assert!(position(&app, cloth, 0).y < -0.01);
    ask(&mut app, PanelAction::Reset);
    app.update();
    assert!(position(&app, cloth, 0).y > -0.01);
}

#[test]
fn energies_are_those_of_a_fall() {
    let mut app = panel_app();
    let material = ClothMaterial { drag: 0.0, area_density: 0.3, ..default() };
    spawn(&mut app, (sheet(), material, Transform::from_xyz(0.0, 5.0, 0.0)));
    updates(&mut app, 64);
    // 1 m2 of 0.3 kg/m2: `m g^2 t^2 / 2` of motion, as much less of height.
    let last = *panel(&app).history().last().expect("it measured");
    let time = 64.0 / 64.0;
    let energy = 0.5 * 0.3 * (9.81_f64 * time).powi(2);
    assert!((last.kinetic / energy - 1.0).abs() < 0.03, "{} {energy}", last.kinetic);
    assert!((last.kinetic + last.height).abs() < 0.03 * energy, "{last:?}");
    assert!(last.max_strain.abs() < 1e-3 && last.mean_strain.abs() < 1e-3);
    assert!(last.milliseconds > 0.0);
}

#[test]
fn depth_is_measured() {
    let mut app = panel_app();
    spawn(&mut app, (sheet(), ClothPins::from(PinSelection::All)));
    spawn(
        &mut app,
        (SdfCollider::from(InfinitePlane3d::default()), Transform::from_xyz(0.0, 0.03, 0.0)),
    );
    updates(&mut app, 3);
    let last = panel(&app).history().last().expect("it measured");
    assert!((last.depth - 0.03).abs() < 1e-5, "{}", last.depth);
}

#[test]
fn history_has_an_end() {
    let mut app = panel_app();
    spawn(&mut app, sheet());
    updates(&mut app, PanelHistory::LENGTH + 20);
    let samples: Vec<_> = panel(&app).history().samples().collect();
    assert_eq!(samples.len(), PanelHistory::LENGTH);
    assert!(samples.is_sorted_by(|a, b| a.time < b.time));
}

#[test]
fn closed_it_measures_nothing() {
    let mut app = panel_app();
    spawn(&mut app, sheet());
    app.world_mut().resource_mut::<ClothPanel>().open = false;
    updates(&mut app, 5);
    assert!(panel(&app).facts().is_none() && panel(&app).history().last().is_none());
}

#[test]
fn materials_are_saved_and_loaded() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("panel_material.ron");
    for (_, fabric) in ClothMaterial::FABRICS {
        save_material(&path, &fabric).unwrap();
        assert_eq!(load_material(&path).unwrap(), fabric);
    }
    let mut app = panel_app();
    let cloth = spawn(&mut app, (sheet(), ClothMaterial::CANVAS));
    updates(&mut app, 2);
    ask(&mut app, PanelAction::Save(path.clone()));
    assert!(panel(&app).message().contains("saved"), "{}", panel(&app).message());
    ask(&mut app, PanelAction::SetMaterial(ClothMaterial::SILK));
    ask(&mut app, PanelAction::Load(path.clone()));
    assert_eq!(has::<ClothMaterial>(&app, cloth), Some(ClothMaterial::CANVAS));
    // What is no material says where.
    fs::write(&path, "(area_density: much)").unwrap();
    let error = load_material(&path).unwrap_err().to_string();
    assert!(error.contains("panel_material.ron") && error.contains("1:"), "{error}");
    ask(&mut app, PanelAction::Load("nowhere/at/all.ron".into()));
    assert!(panel(&app).message().contains("nowhere"), "{}", panel(&app).message());
    assert_eq!(has::<ClothMaterial>(&app, cloth), Some(ClothMaterial::CANVAS));
}

#[test]
fn what_cannot_be_used_is_said() {
    let mut app = panel_app();
    spawn(&mut app, sheet());
    updates(&mut app, 2);
    assert!(facts(&app).errors.is_empty());
    ask(&mut app, PanelAction::SetMaterial(ClothMaterial { area_density: -1.0, ..default() }));
    updates(&mut app, 2);
    assert!(facts(&app).errors[0].contains("area_density"), "{:?}", facts(&app).errors);
}

#[test]
fn it_says_what_the_solver_chose_and_why() {
    let mut app = panel_app();
    let fine = Cloth::sheet(Vec2::ONE, UVec2::splat(64));
    let stiff = ClothMaterial { thread_stiffness: 5000.0, flexural_rigidity: 1.0, ..default() };
    spawn(&mut app, (fine, stiff));
    updates(&mut app, 2);
    let said = explain(&facts(&app).plan, &facts(&app).material).join(" ");
    let plan = &facts(&app).plan;
    assert!(said.contains("Whole threads: springs would need"), "{said}");
    assert!(said.contains(&format!("{} substeps", plan.substeps)), "{said}");
    assert!(said.contains("Rigidity") && said.contains("in place of 1.0 N m"), "{said}");
    assert!(said.contains('%'), "{said}");
}
