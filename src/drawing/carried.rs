//! A drawn shape goes where the coarser one that is simulated carries it, and where what holds it is.

use bevy::prelude::*;

use crate::mesh::drawn::{Carrier, ClothMesh, Held};
use crate::mesh::intake::NormalPlan;
use crate::simulation::ClothSimulation;

/// Works out the drawn points from those that are simulated. `to_frame` takes a place in the world into the frame of both, in which lengths
/// are `scale` times as large.
pub(super) fn carry(
    cloth: &ClothSimulation,
    own: &mut ClothMesh,
    scale: f32,
    to_frame: impl Fn(Vec3) -> Vec3,
) {
    let ClothMesh { carrier: Some(carrier), points: out, joints, .. } = own else { return };
    let Carrier { proxy, points, normals, cells, sums, .. } = &mut **carrier;
    match &proxy.simulated.normals {
        NormalPlan::Grid { .. } => cells.write(points, None, normals),
        NormalPlan::Groups(groups) => groups.write(points, sums, normals),
    }
    // The cloth has the size that its entity, or its skeleton, gave it last.
    let scale = scale * cloth.in_force.placed.scale;
    proxy.binding.write(points, normals, scale, out);

    let on_skin = cloth.skin.as_ref().and_then(|skin| skin.drawn.as_deref());
    let is_any_at_zero = on_skin.is_some_and(|skin| skin.at_zero.contains(&true));
    if !note_held(cloth, carrier) && !is_any_at_zero {
        return;
    }
    let Carrier { proxy, points, held, .. } = &**carrier;
    for (particle, (bond, out)) in proxy.binding.bonds().iter().zip(out).enumerate() {
        let at_zero = on_skin.filter(|skin| skin.at_zero[particle]);
        let is_held = |corner: u32| held[corner as usize] != Held::Free;
        let share = if at_zero.is_some() { 1.0 } else { bond.held(is_held) };
        if share == 0.0 {
            continue;
        }
        let is_attached = bond.supports().any(|it| held[it as usize] == Held::Attached);
        let place = match on_skin {
            Some(skin) if !is_attached => to_frame(skin.place(particle, &joints.matrices)),
            // What holds a triangle moves it as it is, whatever the cloth around does.
            _ => proxy.binding.rigid(particle, points, scale),
        };
        if place.is_finite() {
            *out = if share == 1.0 { place } else { out.lerp(place, share) };
        }
    }
}

/// Notes which simulated particles are held hard, and tells whether any is.
fn note_held(cloth: &ClothSimulation, carrier: &mut Carrier) -> bool {
    let attached = &cloth.held.attachments.attached;
    let on_skin = cloth.skin.as_ref().map_or(&[][..], |skin| &skin.state.held);
    carrier.held.fill(Held::Free);
    for particle in on_skin {
        carrier.held[*particle as usize] = Held::OnSkin;
    }
    for pin in attached {
        carrier.held[pin.particle as usize] = Held::Attached;
    }
    !(attached.is_empty() && on_skin.is_empty())
}
