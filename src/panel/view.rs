//! The windows: drawn from the facts, it asks for actions and changes nothing itself.

use core::ops::RangeInclusive;

use bevy::prelude::{ResMut, Vec3};
use bevy_egui::EguiContexts;
use bevy_egui::egui::{self, DragValue, Slider, Ui};

use crate::cloth::air::ClothAir;
use crate::cloth::material::ClothMaterial;
use crate::cloth::pins::{ClothPins, PinHold, PinSelection};
use crate::cloth::settings::ClothSettings;
use crate::panel::explain::{explain, short};
use crate::panel::model::{ClothPanel, PanelAction, PanelFacts};
use crate::panel::plots::draw_plots;
use crate::solver::{Bending, StretchMethod, Substeps};

/// Draws the windows.
pub(super) fn draw_panel(mut contexts: EguiContexts, panel: Option<ResMut<ClothPanel>>) {
    let Some(mut panel) = panel.filter(|panel| panel.open) else { return };
    let panel = &mut *panel;
    let mut open = true;
    // Without a camera there is nothing to draw on, yet.
    let Ok(context) = contexts.ctx_mut() else { return };
    egui::Window::new("Cloth")
        .open(&mut open)
        .default_pos([12.0, 12.0])
        .default_width(310.0)
        .default_height(640.0)
        .vscroll(true)
        .show(context, |ui| match &panel.facts {
            None => drop(ui.label("There is no cloth.")),
            Some(facts) => {
                let asked = draw_cloth(ui, facts, &mut panel.path, &panel.message);
                panel.asked.extend(asked);
            }
        });
    if panel.facts.is_some() {
        let right = context.content_rect().right_top() + egui::vec2(-12.0, 12.0);
        egui::Window::new("Measured")
            .pivot(egui::Align2::RIGHT_TOP)
            .default_pos(right)
            .default_width(280.0)
            .show(context, |ui| draw_plots(ui, &panel.history));
    }
    panel.open = open;
}

fn draw_cloth(
    ui: &mut Ui,
    facts: &PanelFacts,
    path: &mut String,
    message: &str,
) -> Vec<PanelAction> {
    let mut asked = Vec::new();
    choose(ui, facts, &mut asked);
    drive(ui, facts, &mut asked);
    for error in &facts.errors {
        ui.colored_label(ui.visuals().error_fg_color, error);
    }
    section(ui, "What the solver chose", true, |ui| {
        for line in explain(&facts.plan, &facts.material) {
            ui.label(line);
        }
    });
    section(ui, "Material", true, |ui| {
        edit_material(ui, facts.material, &mut asked);
        edit_file(ui, path, message, &mut asked);
    });
    section(ui, "Settings", false, |ui| edit_settings(ui, facts.settings, &mut asked));
    section(ui, "Self-collision", false, |ui| edit_self_collision(ui, facts, &mut asked));
    section(ui, "Other cloths", false, |ui| edit_inter_collision(ui, facts, &mut asked));
    section(ui, "Pins", false, |ui| edit_pins(ui, &facts.pins, &mut asked));
    section(ui, "Air, wind, gravity", false, |ui| edit_surroundings(ui, facts, &mut asked));
    asked
}

fn section(ui: &mut Ui, title: &str, open: bool, contents: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(title).default_open(open).show(ui, contents);
}

fn choose(ui: &mut Ui, facts: &PanelFacts, asked: &mut Vec<PanelAction>) {
    let name = |of| facts.cloths.iter().find(|(entity, _)| *entity == of).map(|(_, name)| name);
    let chosen = name(facts.chosen).cloned().unwrap_or_default();
    ui.horizontal(|ui| {
        egui::ComboBox::from_id_salt("cloth").selected_text(chosen).show_ui(ui, |ui| {
            for (entity, name) in &facts.cloths {
                if ui.selectable_label(*entity == facts.chosen, name).clicked() {
                    asked.push(PanelAction::Choose(*entity));
                }
            }
        });
        let state = match (facts.paused, facts.asleep) {
            (true, _) => "paused",
            (_, true) => "asleep",
            _ => "awake",
        };
        ui.label(format!("{} particles, {state}", facts.particle_count));
    });
}

fn drive(ui: &mut Ui, facts: &PanelFacts, asked: &mut Vec<PanelAction>) {
    ui.horizontal(|ui| {
        let pause = if facts.paused { "Go on" } else { "Pause" };
        if ui.button(pause).clicked() {
            asked.push(PanelAction::Pause(!facts.paused));
        }
        if ui.button("Step").clicked() {
            asked.push(PanelAction::Step);
        }
        if ui.button("Reset").clicked() {
            asked.push(PanelAction::Reset);
        }
    });
}

fn edit_material(ui: &mut Ui, was: ClothMaterial, asked: &mut Vec<PanelAction>) {
    let mut to = was;
    let known = ClothMaterial::FABRICS.iter().find(|(_, fabric)| *fabric == was);
    egui::ComboBox::from_label("fabric").selected_text(known.map_or("its own", |it| it.0)).show_ui(
        ui,
        |ui| {
            for (name, fabric) in ClothMaterial::FABRICS {
                ui.selectable_value(&mut to, fabric, name);
            }
        },
    );
    slide(ui, &mut to.area_density, 0.01..=2.0, "kg/m²");
    slide(ui, &mut to.thread_stiffness, 10.0..=1e5, "N/m threads");
    slide(ui, &mut to.shear_stiffness, 0.0..=1e4, "N/m shear");
    slide(ui, &mut to.flexural_rigidity, 0.0..=1e-2, "N m bending");
    slide(ui, &mut to.bending_friction, 0.0..=1e-2, "N bending friction");
    slide(ui, &mut to.damping, 0.0..=1.0, "N s/m damping");
    slide(ui, &mut to.drag, 0.0..=10.0, "1/s drag");
    slide(ui, &mut to.max_strain, 0.0..=5.0, "strain limit");
    slide(ui, &mut to.friction, 0.0..=2.0, "friction");
    slide(ui, &mut to.thickness, 1e-4..=0.1, "m thickness");
    if to != was {
        asked.push(PanelAction::SetMaterial(to));
    }
}

/// A slider over powers of ten, that also takes what is typed beyond its range.
fn slide(ui: &mut Ui, value: &mut f32, range: RangeInclusive<f32>, label: &str) {
    let slider = Slider::new(value, range).logarithmic(true).smallest_positive(1e-7);
    let slider = slider.custom_formatter(|value, _| short(value as f32));
    ui.add(slider.text(label).clamping(egui::SliderClamping::Never));
}

fn edit_file(ui: &mut Ui, path: &mut String, message: &str, asked: &mut Vec<PanelAction>) {
    ui.horizontal(|ui| {
        ui.add(egui::TextEdit::singleline(path).desired_width(140.0));
        if ui.button("Save").clicked() {
            asked.push(PanelAction::Save(path.clone().into()));
        }
        if ui.button("Load").clicked() {
            asked.push(PanelAction::Load(path.clone().into()));
        }
    });
    if !message.is_empty() {
        ui.label(message);
    }
}

fn edit_settings(ui: &mut Ui, was: ClothSettings, asked: &mut Vec<PanelAction>) {
    let mut to = was;
    ui.horizontal(|ui| {
        ui.label("quality");
        let qualities = [
            ("game", ClothSettings::GAME),
            ("default", ClothSettings::default()),
            ("accurate", ClothSettings::ACCURATE),
            ("reference", ClothSettings::REFERENCE),
        ];
        for (name, quality) in qualities {
            ui.selectable_value(&mut to, ClothSettings { layers: was.layers, ..quality }, name);
        }
    });
    edit_substeps(ui, &mut to.substeps);
    ui.horizontal(|ui| {
        ui.selectable_value(&mut to.stretch_method, StretchMethod::Automatic, "as fits");
        ui.selectable_value(&mut to.stretch_method, StretchMethod::ExplicitSprings, "springs");
        ui.selectable_value(&mut to.stretch_method, StretchMethod::ImplicitThreads, "threads");
    });
    ui.horizontal(|ui| {
        ui.selectable_value(&mut to.bending, Bending::SecondDifference, "second differences");
        ui.selectable_value(&mut to.bending, Bending::Flexion, "flexion springs");
    });
    ui.add(Slider::new(&mut to.provot_passes, 0..=16).text("Provot passes"));
    ui.checkbox(&mut to.tethers, "tethers");
    ui.checkbox(&mut to.edges, "edges collide");
    slide(ui, &mut to.max_speed, 1.0..=1000.0, "m/s at most");
    slide(ui, &mut to.max_depenetration_speed, 0.1..=100.0, "m/s out of colliders");
    if to != was {
        asked.push(PanelAction::SetSettings(to));
    }
}

fn edit_substeps(ui: &mut Ui, substeps: &mut Substeps) {
    ui.horizontal(|ui| {
        let count = match *substeps {
            Substeps::Automatic { budget } => budget,
            Substeps::Fixed(count) => count,
        };
        ui.selectable_value(substeps, Substeps::Automatic { budget: count }, "at most");
        ui.selectable_value(substeps, Substeps::Fixed(count), "always");
        let (Substeps::Automatic { budget: count } | Substeps::Fixed(count)) = substeps;
        ui.add(DragValue::new(count).range(1..=1000).suffix(" substeps"));
    });
}

fn edit_self_collision(ui: &mut Ui, facts: &PanelFacts, asked: &mut Vec<PanelAction>) {
    let mut to = facts.self_collision;
    edit_collision(ui, "collides with itself", &mut to, |ui, to| {
        edit_layer(ui, facts.spacing, &mut to.distance, &mut to.friction);
    });
    if to != facts.self_collision {
        asked.push(PanelAction::SetSelfCollision(to));
    }
}

fn edit_inter_collision(ui: &mut Ui, facts: &PanelFacts, asked: &mut Vec<PanelAction>) {
    let mut to = facts.inter_collision;
    edit_collision(ui, "collides with other cloths", &mut to, |ui, to| {
        edit_layer(ui, facts.spacing, &mut to.distance, &mut to.friction);
    });
    if to != facts.inter_collision {
        asked.push(PanelAction::SetInterCollision(to));
    }
}

/// A switch for a component, and what can be set of it.
fn edit_collision<T: Default>(
    ui: &mut Ui,
    name: &str,
    component: &mut Option<T>,
    edit: impl FnOnce(&mut Ui, &mut T),
) {
    let mut collides = component.is_some();
    if ui.checkbox(&mut collides, name).changed() {
        *component = collides.then(T::default);
    }
    if let Some(component) = component {
        edit(ui, component);
    }
}

fn edit_layer(ui: &mut Ui, spacing: f32, distance: &mut Option<f32>, friction: &mut f32) {
    let mut automatic = distance.is_none();
    if ui.checkbox(&mut automatic, "distance from the particle spacing").changed() {
        // Whatever the triangles, it is no larger than they allow.
        *distance = (!automatic).then_some(0.8 * spacing);
    }
    if let Some(distance) = distance {
        slide(ui, distance, 0.1 * spacing..=spacing, "m distance");
    }
    ui.add(Slider::new(friction, 0.0..=2.0).text("friction of layers"));
}

fn edit_pins(ui: &mut Ui, was: &ClothPins, asked: &mut Vec<PanelAction>) {
    let mut to = was.clone();
    let mut taken = None;
    for (index, pin) in to.pins.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            let anchor = pin.anchor.map(|it| format!(" at {it}")).unwrap_or_default();
            ui.label(format!("{}{anchor}", describe(&pin.selection)));
            if ui.small_button("release").clicked() {
                taken = Some(index);
            }
        });
        edit_hold(ui, index, &mut pin.hold);
    }
    if let Some(index) = taken {
        to.pins.remove(index);
    }
    ui.menu_button("Pin more", |ui| {
        let corners = PinSelection::Corners;
        let sides = [
            PinSelection::FirstRow,
            PinSelection::LastRow,
            PinSelection::FirstColumn,
            PinSelection::LastColumn,
            PinSelection::All,
        ];
        for selection in [corners].into_iter().chain(sides) {
            if ui.button(describe(&selection)).clicked() {
                to.pins.push(selection.into());
            }
        }
    });
    if to != *was {
        asked.push(PanelAction::SetPins(to));
    }
}

fn describe(selection: &PinSelection) -> String {
    match selection {
        PinSelection::Vertices(vertices) if vertices.len() == 1 => {
            format!("vertex {}", vertices[0])
        }
        PinSelection::Vertices(vertices) => format!("{} vertices", vertices.len()),
        PinSelection::Within { .. } => "a box".into(),
        PinSelection::Color { above, .. } => format!("painted above {above}"),
        PinSelection::Corners => "corners".into(),
        PinSelection::FirstRow => "first row".into(),
        PinSelection::LastRow => "last row".into(),
        PinSelection::FirstColumn => "first column".into(),
        PinSelection::LastColumn => "last column".into(),
        PinSelection::All => "all".into(),
    }
}

fn edit_hold(ui: &mut Ui, index: usize, hold: &mut PinHold) {
    ui.push_id(index, |ui| {
        let mut soft = matches!(hold, PinHold::Soft { .. });
        if ui.checkbox(&mut soft, "by springs").changed() {
            *hold =
                if soft { PinHold::Soft { stiffness: 100.0, damping: 1.0 } } else { PinHold::Hard };
        }
        if let PinHold::Soft { stiffness, damping } = hold {
            slide(ui, stiffness, 1.0..=1e5, "N/m");
            slide(ui, damping, 0.0..=1e3, "N s/m");
        }
    });
}

fn edit_surroundings(ui: &mut Ui, facts: &PanelFacts, asked: &mut Vec<PanelAction>) {
    let mut air = facts.air;
    let mut feels = air.is_some();
    if ui.checkbox(&mut feels, "feels the air").changed() {
        air = feels.then(ClothAir::default);
    }
    if let Some(air) = &mut air {
        slide(ui, &mut air.density, 0.0..=1000.0, "kg/m³ of air");
        ui.add(Slider::new(&mut air.drag, 0.0..=4.0).text("drag"));
        ui.add(Slider::new(&mut air.lift, 0.0..=4.0).text("lift"));
    }
    if air != facts.air {
        asked.push(PanelAction::SetAir(air));
    }
    let mut wind = facts.wind;
    drag(ui, "wind", &mut wind.velocity, " m/s");
    slide(ui, &mut wind.gusts.strength, 0.0..=50.0, "m/s gusts");
    if wind != facts.wind {
        asked.push(PanelAction::SetWind(wind));
    }
    let mut gravity = facts.gravity;
    drag(ui, "gravity", &mut gravity, " m/s²");
    if gravity != facts.gravity {
        asked.push(PanelAction::SetGravity(gravity));
    }
}

fn drag(ui: &mut Ui, label: &str, value: &mut Vec3, unit: &str) {
    ui.horizontal(|ui| {
        for part in [&mut value.x, &mut value.y, &mut value.z] {
            ui.add(DragValue::new(part).speed(0.05).max_decimals(2));
        }
        ui.label(format!("{unit} {label}").trim_start().to_owned());
    });
}
