//! Looks at the chosen cloth.

use bevy::diagnostic::{Diagnostic, DiagnosticsStore};
use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::cloth::Cloth;
use crate::cloth::air::ClothAir;
use crate::cloth::gravity::{ClothGravity, ClothGravityOverride};
use crate::cloth::inter_collision::ClothInterCollision;
use crate::cloth::material::ClothMaterial;
use crate::cloth::pins::ClothPins;
use crate::cloth::self_collision::ClothSelfCollision;
use crate::cloth::settings::ClothSettings;
use crate::cloth::sleep::ClothPaused;
use crate::cloth::wind::{ClothWind, ClothWindOverride};
use crate::collider::tick_colliders::{ColliderRoom, TickColliders};
use crate::diagnostics::ClothDiagnosticsPlugin;
use crate::error::ClothFailure;
use crate::panel::history::PanelSample;
use crate::panel::model::{ClothPanel, PanelFacts};
use crate::proximity::for_each_near;
use crate::sdf::DistanceField;
use crate::simulation::ClothSimulation;

/// A cloth and all that can be changed of it.
#[derive(QueryData)]
pub(super) struct Looked {
    cloth: &'static ClothSimulation,
    material: Option<&'static ClothMaterial>,
    settings: Option<&'static ClothSettings>,
    pins: Option<&'static ClothPins>,
    air: Option<&'static ClothAir>,
    self_collision: Option<&'static ClothSelfCollision>,
    inter_collision: Option<&'static ClothInterCollision>,
    gravity: Option<&'static ClothGravityOverride>,
    wind: Option<&'static ClothWindOverride>,
    frozen: Has<ClothPaused>,
    failure: Option<&'static ClothFailure>,
}

/// The surroundings of the chosen cloth.
#[derive(SystemParam)]
pub(super) struct Around<'w> {
    gravity: Option<Res<'w, ClothGravity>>,
    wind: Option<Res<'w, ClothWind>>,
    snapshot: Option<Res<'w, TickColliders>>,
    fields: Option<Res<'w, Assets<DistanceField>>>,
    store: Option<Res<'w, DiagnosticsStore>>,
    time: Res<'w, Time<Fixed>>,
}

/// Gathers the facts, and measures where a tick has gone by.
pub(super) fn gather(
    mut panel: ResMut<ClothPanel>,
    cloths: Query<(Entity, Option<&Name>), (With<Cloth>, With<ClothSimulation>)>,
    looked: Query<Looked>,
    around: Around,
) {
    let mut names: Vec<_> =
        cloths.iter().map(|(entity, name)| (entity, called(entity, name))).collect();
    names.sort_unstable_by_key(|(entity, _)| entity.index_u32());
    let before = panel.facts.as_ref().map(|facts| facts.chosen);
    let chosen = before.filter(|it| names.iter().any(|(entity, _)| entity == it));
    let chosen = chosen.or_else(|| names.first().map(|(entity, _)| *entity));
    if chosen != before {
        panel.history.clear();
    }
    let found = chosen.and_then(|chosen| Some((chosen, looked.get(chosen).ok()?)));
    let Some((chosen, found)) = found else {
        panel.facts = None;
        return;
    };
    panel.facts = Some(facts(names, chosen, &found, &around));
    let time = around.time.elapsed_secs_f64();
    if panel.history.last().is_none_or(|last| last.time < time) {
        let sample = measure(&found, &around, time);
        panel.history.push(sample);
    }
}

fn called(entity: Entity, name: Option<&Name>) -> String {
    name.map_or_else(|| format!("cloth {entity}"), ToString::to_string)
}

fn facts(
    cloths: Vec<(Entity, String)>,
    chosen: Entity,
    found: &LookedItem<'_, '_>,
    around: &Around,
) -> PanelFacts {
    PanelFacts {
        cloths,
        chosen,
        particle_count: found.cloth.particle_count(),
        spacing: spacing(found.cloth),
        material: found.material.copied().unwrap_or_default(),
        settings: found.settings.copied().unwrap_or_default(),
        pins: found.pins.cloned().unwrap_or_default(),
        air: found.air.copied(),
        self_collision: found.self_collision.copied(),
        inter_collision: found.inter_collision.copied(),
        gravity: gravity(found, around),
        wind: found
            .wind
            .map_or_else(|| around.wind.as_deref().copied().unwrap_or_default(), |w| w.0),
        paused: found.frozen,
        asleep: found.cloth.is_asleep(),
        plan: *found.cloth.plan(),
        errors: found.failure.iter().flat_map(|it| it.errors()).map(ToString::to_string).collect(),
    }
}

fn spacing(cloth: &ClothSimulation) -> f32 {
    cloth.topology().structural_springs().map(|(.., rest)| rest).fold(f32::INFINITY, f32::min)
}

fn gravity(found: &LookedItem<'_, '_>, around: &Around) -> Vec3 {
    let everywhere = || around.gravity.as_deref().copied().unwrap_or_default().0;
    found.gravity.map_or_else(everywhere, |own| own.0)
}

fn measure(found: &LookedItem<'_, '_>, around: &Around, time: f64) -> PanelSample {
    let cloth = found.cloth;
    let (sum, count) = cloth.solver.strain_sum();
    let gravity = gravity(found, around).as_dvec3();
    let (mut kinetic, mut height) = (0.0, 0.0);
    for (particle, rest) in cloth.rest_positions().iter().enumerate() {
        let mass = f64::from(cloth.solver.mass(particle));
        let velocity = cloth.velocity(particle).unwrap_or_default().as_dvec3();
        kinetic += 0.5 * mass * velocity.length_squared();
        // Over the rest shape where it was set up, which only shifts it.
        let start = cloth.in_force.placed.translation + cloth.in_force.placed.rotation * *rest;
        height -= mass * gravity.dot((cloth.solver.position(particle) - start).as_dvec3());
    }
    let tick = around.store.as_deref().and_then(|store| store.get(&ClothDiagnosticsPlugin::TICK));
    PanelSample {
        time,
        max_strain: cloth.last_tick().map_or(0.0, |tick| f64::from(tick.max_strain)),
        mean_strain: sum / count.max(1) as f64,
        kinetic,
        height,
        depth: f64::from(depth(cloth, around)),
        milliseconds: tick.and_then(Diagnostic::smoothed).unwrap_or_default(),
    }
}

/// How deep the deepest particle is \[m\].
fn depth(cloth: &ClothSimulation, around: &Around) -> f32 {
    let Some(snapshot) = &around.snapshot else { return 0.0 };
    let mut deepest = 0.0_f32;
    for collider in snapshot.colliders(around.fields.as_deref(), ColliderRoom::default()) {
        for_each_near(cloth, &collider, 0.0, |near| deepest = deepest.max(-near.distance));
    }
    deepest
}
