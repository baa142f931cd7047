//! Cloths that are pulled at with the mouse: Bevy's picking finds the point, a [`ClothGrab`] holds it.

use bevy::picking::backend::ray::{RayId, RayMap};
use bevy::picking::mesh_picking::MeshPickingPlugin;
use bevy::picking::mesh_picking::ray_cast::RayCastBackfaces;
use bevy::picking::pointer::{PointerId, PointerPress};
use bevy::prelude::*;

use crate::cloth::grab::{ClothGrab, GrabHold};
use crate::simulation::ClothSimulation;

/// Lets the mouse, or a finger, pull at cloths: pressed on one, it grabs what is there and draws it along, at the
/// distance from the camera where it was grabbed, until it is let go.
///
/// It works by Bevy's picking: what is in front of the cloth is picked in its place, and
/// `Pickable::IGNORE` on a cloth leaves it alone. Brings Bevy's `MeshPickingPlugin`, which needs the default
/// plugins. A cloth that has a [`ClothGrab`] of the game's own is not touched.
///
/// ```no_run
/// use bevy::prelude::*;
/// use bevy_drape::{ClothPickingPlugin, prelude::*};
///
/// App::new().add_plugins((DefaultPlugins, ClothPlugin::default(), ClothPickingPlugin)).run();
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct ClothPickingPlugin;

/// How the mouse pulls at cloths.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Debug, PartialEq, Clone)]
pub struct ClothPicking {
    /// Whether the mouse can pull cloths.
    pub enabled: bool,
    /// The button that pulls.
    pub button: PointerButton,
    /// Distance within which particles are grabbed \[m\], the nearest at least. Larger grabs more.
    pub radius: f32,
    /// See [`ClothGrab::stiffness`] \[N/m\].
    pub stiffness: f32,
    /// See [`ClothGrab::damping`] \[N s/m\].
    pub damping: f32,
    /// See [`ClothGrab::max_force`] \[N\].
    pub max_force: f32,
}

impl Default for ClothPicking {
    fn default() -> Self {
        let ClothGrab { stiffness, damping, max_force, .. } = ClothGrab::particle(0, Vec3::ZERO);
        let button = PointerButton::Primary;
        Self { enabled: true, button, radius: 0.05, stiffness, damping, max_force }
    }
}

/// The grip of a pointer on a cloth.
#[derive(Component, Clone, Copy, Debug)]
struct Grip {
    /// The pointer, and the camera that it was seen by.
    ray: RayId,
    button: PointerButton,
    /// Distance of what is held from the camera, along its view \[m\].
    depth: f32,
}

impl Plugin for ClothPickingPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<MeshPickingPlugin>() {
            app.add_plugins(MeshPickingPlugin);
        }
        // Cloth has two sides.
        app.register_required_components::<ClothSimulation, RayCastBackfaces>()
            .register_type::<ClothPicking>()
            .init_resource::<ClothPicking>()
            .add_observer(grab)
            .add_systems(Update, (drag, let_go).chain().run_if(any_with_component::<Grip>));
    }
}

/// A pointer is pressed on a cloth.
fn grab(
    press: On<Pointer<Press>>,
    picking: Res<ClothPicking>,
    cloths: Query<&ClothSimulation, (Without<ClothGrab>, Without<Grip>)>,
    cameras: Query<&GlobalTransform, With<Camera>>,
    mut commands: Commands,
) {
    let Press { button, hit, .. } = &press.event;
    let (Ok(cloth), Ok(camera)) = (cloths.get(press.entity), cameras.get(hit.camera)) else {
        return;
    };
    let Some(place) = hit.position.filter(|_| picking.enabled && *button == picking.button) else {
        return;
    };
    // What is drawn may be a part of a tick from where the cloth is.
    let distances = cloth.positions().map(|it| it.distance_squared(place));
    let Some(nearest) = distances.reduce(f32::min).map(f32::sqrt) else { return };
    let radius = picking.radius.max(1.001 * nearest + 1e-6);
    let &ClothPicking { stiffness, damping, max_force, .. } = &*picking;
    let hold = GrabHold::Within { centre: place, radius };
    let depth = (place - camera.translation()).dot(*camera.forward());
    let grip = Grip { ray: RayId::new(hit.camera, press.pointer_id), button: *button, depth };
    commands
        .entity(press.entity)
        .try_insert((grip, ClothGrab { hold, target: place, stiffness, damping, max_force }));
}

/// Grabbed particles follow their pointer, in the plane across the view where they were grabbed. Outside of the view
/// they stay.
fn drag(
    mut held: Query<(&Grip, &mut ClothGrab)>,
    cameras: Query<&GlobalTransform, With<Camera>>,
    rays: Option<Res<RayMap>>,
) {
    for (grip, mut grab) in &mut held {
        let ray = rays.as_ref().and_then(|rays| rays.map.get(&grip.ray));
        let (Some(ray), Ok(camera)) = (ray, cameras.get(grip.ray.camera)) else { continue };
        let forward = camera.forward();
        let along = ray.direction.dot(*forward);
        let away = grip.depth - (ray.origin - camera.translation()).dot(*forward);
        if along > 1e-3 {
            let target = ray.origin + *ray.direction * (away / along);
            grab.set_if_neq(ClothGrab { target, ..*grab });
        }
    }
}

/// The button is up, or the pointer is gone.
fn let_go(
    held: Query<(Entity, &Grip)>,
    pointers: Query<(&PointerId, &PointerPress)>,
    mut commands: Commands,
) {
    for (entity, grip) in &held {
        let pressed = pointers.iter().any(|(id, press)| {
            let down = match grip.button {
                PointerButton::Primary => press.is_primary_pressed(),
                PointerButton::Secondary => press.is_secondary_pressed(),
                PointerButton::Middle => press.is_middle_pressed(),
            };
            *id == grip.ray.pointer && down
        });
        if !pressed {
            commands.entity(entity).try_remove::<(Grip, ClothGrab)>();
        }
    }
}
