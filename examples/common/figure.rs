//! A character that walks in a circle: joints, and a skin over all.

use crate::{
    IVORY,
    body::{Bone, body},
    clay,
};
use bevy::{
    camera::visibility::NoFrustumCulling,
    mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    prelude::*,
};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// A joint, the capsule around its bone, and how it turns about its x axis as the figure walks.
#[derive(Component, Clone, Copy)]
pub struct Joint {
    /// The joint that it hangs on, by its place in [`JOINTS`].
    pub(crate) parent: Option<usize>,
    /// Place in the parent's frame \[m\].
    pub(crate) at: Vec3,
    /// The capsule: from, to and radius \[m\].
    bone: (Vec3, Vec3, f32),
    /// Mean angle, swing to both sides of it \[rad\], and where in the stride it is \[rad\].
    turn: (f32, f32, f32),
}

/// The chest, which carries neck and arms.
pub const CHEST: usize = 2;

/// Its height at the start \[m\].
pub const CHEST_HEIGHT: f32 = HIPS + 0.12 + 0.25;

/// Height of the hips \[m\].
pub(crate) const HIPS: f32 = 0.92;

/// Speed \[m/s\], radius of the circle \[m\], length of a stride of both legs \[m\].
const SPEED: f32 = 1.3;
const CIRCLE: f32 = 1.0;
const STRIDE: f32 = 1.45;

/// Spacing of the skin's vertices \[m\].
const CELL: f32 = 0.015;

const fn joint(
    parent: Option<usize>,
    at: [f32; 3],
    bone: ([f32; 3], [f32; 3], f32),
    turn: (f32, f32, f32),
) -> Joint {
    let (from, to, radius) = bone;
    let bone = (Vec3::from_array(from), Vec3::from_array(to), radius);
    Joint { parent, at: Vec3::from_array(at), bone, turn }
}

/// Hips, spine, chest, neck, head; then arms and legs, left and right. It looks towards -z.
#[rustfmt::skip]
pub(crate) const JOINTS: [Joint; 15] = [
    joint(None, [0.0, HIPS, 0.0], ([-0.07, 0.0, 0.0], [0.07, 0.0, 0.0], 0.11), (0.0, 0.0, 0.0)),
    joint(Some(0), [0.0, 0.12, 0.0], ([0.0, 0.0, 0.0], [0.0, 0.2, 0.0], 0.11), (-0.05, 0.0, 0.0)),
    joint(Some(1), [0.0, 0.25, 0.0], ([-0.14, 0.08, 0.0], [0.14, 0.08, 0.0], 0.075), (0.0, 0.0, 0.0)),
    joint(Some(2), [0.0, 0.12, 0.0], ([0.0, 0.0, 0.0], [0.0, 0.12, 0.0], 0.05), (0.0, 0.0, 0.0)),
    joint(Some(3), [0.0, 0.16, 0.0], ([0.0, 0.03, -0.015], [0.0, 0.11, -0.015], 0.09), (0.0, 0.0, 0.0)),
    joint(Some(2), [-0.2, 0.06, 0.0], ([0.0, 0.0, 0.0], [-0.03, -0.27, 0.0], 0.045), (0.0, -0.4, 0.0)),
    joint(Some(5), [-0.03, -0.28, 0.0], ([0.0, 0.0, 0.0], [0.0, -0.25, 0.0], 0.038), (0.4, -0.2, 0.0)),
    joint(Some(2), [0.2, 0.06, 0.0], ([0.0, 0.0, 0.0], [0.03, -0.27, 0.0], 0.045), (0.0, -0.4, PI)),
    joint(Some(7), [0.03, -0.28, 0.0], ([0.0, 0.0, 0.0], [0.0, -0.25, 0.0], 0.038), (0.4, -0.2, PI)),
    joint(Some(0), [-0.09, -0.04, 0.0], ([0.0, 0.0, 0.0], [0.0, -0.4, 0.0], 0.07), (0.1, 0.45, 0.0)),
    joint(Some(9), [0.0, -0.42, 0.0], ([0.0, 0.0, 0.0], [0.0, -0.4, 0.0], 0.05), (-0.4, -0.4, FRAC_PI_2)),
    joint(Some(10), [0.0, -0.4, 0.0], ([0.0, 0.0, 0.0], [0.0, 0.0, -0.13], 0.045), (0.0, 0.0, 0.0)),
    joint(Some(0), [0.09, -0.04, 0.0], ([0.0, 0.0, 0.0], [0.0, -0.4, 0.0], 0.07), (0.1, 0.45, PI)),
    joint(Some(12), [0.0, -0.42, 0.0], ([0.0, 0.0, 0.0], [0.0, -0.4, 0.0], 0.05), (-0.4, -0.4, PI + FRAC_PI_2)),
    joint(Some(13), [0.0, -0.4, 0.0], ([0.0, 0.0, 0.0], [0.0, 0.0, -0.13], 0.045), (0.0, 0.0, 0.0)),
];

impl Joint {
    /// The capsule around its bone, when the joint is somewhere.
    pub(crate) fn bone_at(&self, pose: Isometry3d) -> Bone {
        let (from, to, radius) = self.bone;
        (pose * from, pose * to, radius)
    }
}

/// A joint that is there, and the capsule around its bone, in the joint's frame \[m\].
pub struct Limb {
    /// The joint.
    pub joint: Entity,
    /// One end of the bone.
    pub from: Vec3,
    /// The other end.
    pub to: Vec3,
    /// How thick the flesh on it is.
    pub radius: f32,
}

/// Adds the figure; tells its limbs, of which [`CHEST`] is one.
pub fn spawn_figure(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    bindposes: &mut Assets<SkinnedMeshInverseBindposes>,
) -> Vec<Limb> {
    let mut limbs: Vec<Limb> = Vec::new();
    for joint in JOINTS {
        let (from, to, radius) = joint.bone;
        let mut new = commands.spawn((joint, pose(&joint, 0.0), Visibility::default()));
        if let Some(parent) = joint.parent {
            new.insert(ChildOf(limbs[parent].joint));
        }
        limbs.push(Limb { joint: new.id(), from, to, radius });
    }
    let joints = limbs.iter().map(|limb| limb.joint).collect();
    let (mesh, back) = skin();
    let skin = SkinnedMesh { inverse_bindposes: bindposes.add(back), joints };
    // Its bounds are those of the start.
    commands.spawn((Mesh3d(meshes.add(mesh)), skin, NoFrustumCulling, clay(IVORY)));
    limbs
}

/// The mesh that the joints move, and from where each moves it.
fn skin() -> (Mesh, Vec<Mat4>) {
    // At the start no joint is turned.
    let mut places: Vec<Vec3> = Vec::new();
    for joint in JOINTS {
        places.push(joint.at + joint.parent.map_or(Vec3::ZERO, |parent| places[parent]));
    }
    let bones: Vec<_> = JOINTS
        .iter()
        .zip(&places)
        .map(|(joint, place)| joint.bone_at(Isometry3d::from_translation(*place)))
        .collect();
    let mesh = body(&bones, &JOINTS.map(|joint| joint.parent), CELL);
    (mesh, places.iter().map(|place| Mat4::from_translation(-place)).collect())
}

/// Walks.
pub fn walk(mut joints: Query<(&Joint, &mut Transform)>, time: Res<Time>) {
    for (joint, mut transform) in &mut joints {
        *transform = pose(joint, time.elapsed_secs());
    }
}

/// Where the figure's ground is after some time \[s\]; it starts within a second.
pub fn place(time: f32) -> Transform {
    let (sin, cos) = (way(time) / CIRCLE).sin_cos();
    Transform::from_translation(CIRCLE * Vec3::new(cos, 0.0, sin))
        .looking_to(Vec3::new(-sin, 0.0, cos), Vec3::Y)
}

/// How far it has walked \[m\].
fn way(time: f32) -> f32 {
    let start = time.min(1.0);
    SPEED * (0.5 * start * start + (time - start))
}

/// A joint in its parent's frame.
fn pose(joint: &Joint, time: f32) -> Transform {
    let stride = TAU * way(time) / STRIDE;
    let (mean, swing, phase) = joint.turn;
    let angle = time.min(1.0) * (mean + swing * (stride + phase).sin());
    let turned = Transform::from_translation(joint.at).with_rotation(Quat::from_rotation_x(angle));
    if joint.parent.is_some() {
        return turned;
    }
    // The hips are highest where a leg stands upright.
    let down = 0.025 * time.min(1.0) * (1.0 - (2.0 * stride).cos());
    place(time) * turned.with_translation(joint.at - down * Vec3::Y)
}
