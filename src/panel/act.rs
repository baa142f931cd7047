//! Does what the panel was asked for, through the cloth's components.

use bevy::prelude::*;

use crate::cloth::Cloth;
use crate::cloth::air::ClothAir;
use crate::cloth::gravity::{ClothGravity, ClothGravityOverride};
use crate::cloth::inter_collision::ClothInterCollision;
use crate::cloth::self_collision::ClothSelfCollision;
use crate::cloth::sleep::ClothPaused;
use crate::cloth::teleport::ResetCloth;
use crate::cloth::wind::ClothWindOverride;
use crate::panel::file::{load_material, save_material};
use crate::panel::model::{ClothPanel, PanelAction};

/// Does all that was asked, in that order.
pub(super) fn act(
    mut panel: ResMut<ClothPanel>,
    cloths: Query<
        (Option<&ClothPaused>, Has<ClothGravityOverride>, Has<ClothWindOverride>),
        With<Cloth>,
    >,
    mut commands: Commands,
) {
    if panel.asked.is_empty() {
        return;
    }
    for action in core::mem::take(&mut panel.asked) {
        if let PanelAction::Choose(other) = action {
            if let Some(facts) = panel.facts.as_mut().filter(|_| cloths.contains(other)) {
                facts.chosen = other;
                panel.history.clear();
            }
            continue;
        }
        let Some(chosen) = panel.facts.as_ref().map(|facts| facts.chosen) else { continue };
        let Ok((frozen, own_gravity, own_wind)) = cloths.get(chosen) else { continue };
        let mut cloth = commands.entity(chosen);
        match action {
            PanelAction::Choose(_) => {}
            PanelAction::SetMaterial(material) => drop(cloth.try_insert(material)),
            PanelAction::SetSettings(settings) => drop(cloth.try_insert(settings)),
            PanelAction::SetPins(pins) => drop(cloth.try_insert(pins)),
            PanelAction::SetAir(Some(air)) => drop(cloth.try_insert(air)),
            PanelAction::SetAir(None) => drop(cloth.try_remove::<ClothAir>()),
            PanelAction::SetSelfCollision(Some(asked)) => drop(cloth.try_insert(asked)),
            PanelAction::SetSelfCollision(None) => {
                cloth.try_remove::<ClothSelfCollision>();
            }
            PanelAction::SetInterCollision(Some(asked)) => drop(cloth.try_insert(asked)),
            PanelAction::SetInterCollision(None) => {
                cloth.try_remove::<ClothInterCollision>();
            }
            PanelAction::SetGravity(gravity) if own_gravity => {
                cloth.try_insert(ClothGravityOverride(gravity));
            }
            PanelAction::SetGravity(gravity) => commands.insert_resource(ClothGravity(gravity)),
            PanelAction::SetWind(wind) if own_wind => {
                cloth.try_insert(ClothWindOverride(wind));
            }
            PanelAction::SetWind(wind) => commands.insert_resource(wind),
            PanelAction::Pause(true) => drop(cloth.try_insert_if_new(ClothPaused::default())),
            PanelAction::Pause(false) => drop(cloth.try_remove::<ClothPaused>()),
            PanelAction::Step => {
                let steps = frozen.map_or(0, |frozen| frozen.steps).saturating_add(1);
                cloth.try_insert(ClothPaused { steps });
            }
            PanelAction::Reset => commands.trigger(ResetCloth { entity: chosen }),
            PanelAction::Save(path) => {
                let material = panel.facts.as_ref().map(|facts| facts.material).unwrap_or_default();
                panel.message = match save_material(&path, &material) {
                    Ok(()) => format!("saved {}", path.display()),
                    Err(error) => error.to_string(),
                };
            }
            PanelAction::Load(path) => match load_material(&path) {
                Ok(material) => {
                    cloth.try_insert(material);
                    panel.message = format!("loaded {}", path.display());
                }
                Err(error) => panel.message = error.to_string(),
            },
        }
    }
}
