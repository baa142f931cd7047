//! A character as a modelling program would write it: joints, a body and a skirt that they move, and two animations, in a file of glTF.

mod glb;
mod skirt;

use crate::{
    IVORY, TEAL,
    body::{Bone, body},
    figure::{HIPS, JOINTS},
};
use bevy::{math::ops, prelude::*};
use glb::{Keys, Writer};
use std::f32::consts::{PI, TAU};

/// The names of the joints, in their order.
const NAMES: [&str; 15] = [
    "hips",
    "spine",
    "chest",
    "neck",
    "head",
    "upper_arm.l",
    "forearm.l",
    "upper_arm.r",
    "forearm.r",
    "thigh.l",
    "shin.l",
    "foot.l",
    "thigh.r",
    "shin.r",
    "foot.r",
];
/// Spacing of the body's vertices \[m\].
const CELL: f32 = 0.022;
/// Poses of a cycle.
const KEYS: usize = 24;

/// How the character moves.
struct Gait {
    name: &'static str,
    /// Length of a cycle of two steps \[s\].
    cycle: f32,
    /// How far thighs swing to both sides, and arms \[rad\].
    swing: [f32; 2],
    /// How far knees and elbows are bent in the mean \[rad\].
    bent: [f32; 2],
    /// How far the spine leans forward \[rad\].
    lean: f32,
    /// How far the hips go up and down \[m\].
    bounce: f32,
}

/// 1.3 m/s.
const WALK: Gait = Gait {
    name: "walk",
    cycle: 1.12,
    swing: [0.42, 0.4],
    bent: [0.4, 0.35],
    lean: 0.04,
    bounce: 0.02,
};
/// 4 m/s.
const SPRINT: Gait = Gait {
    name: "sprint",
    cycle: 0.62,
    swing: [0.8, 0.8],
    bent: [0.9, 1.3],
    lean: 0.22,
    bounce: 0.04,
};

/// The file, binary.
pub fn character() -> Vec<u8> {
    let parents = JOINTS.map(|joint| joint.parent);
    let poses: Vec<Isometry3d> = (0..JOINTS.len()).map(bind_pose).collect();
    let mut placed: Vec<Isometry3d> = Vec::new();
    for (pose, parent) in poses.iter().zip(parents) {
        placed.push(parent.map_or(*pose, |parent| placed[parent] * *pose));
    }
    let mut file = Writer::default();
    let joints = file.joints(&NAMES, &parents, &poses);
    let skin = file.skin(&joints, &placed);
    let bones: Vec<Bone> =
        JOINTS.iter().zip(&placed).map(|(joint, pose)| joint.bone_at(*pose)).collect();
    let body = body(&bones, &parents, CELL);
    let clay = file.material("clay", IVORY, false);
    file.skinned("body", &body, clay, skin);
    let linen = file.material("linen", TEAL, true);
    file.skinned("skirt", &skirt::skirt(), linen, skin);
    for gait in [WALK, SPRINT] {
        let keys = JOINTS.iter().enumerate().map(|(joint, it)| Keys {
            joint: joints[joint],
            rotations: cycle().map(|turn| gait.rotation(joint, turn)).collect(),
            translations: cycle().map(|turn| it.at + gait.translation(joint, turn)).collect(),
        });
        let times: Vec<f32> = cycle().map(|turn| turn / TAU * gait.cycle).collect();
        file.animation(gait.name, &times, keys);
    }
    file.write("character")
}

/// A joint in its parent's frame as the skin is bound: arms and legs are spread, so that no two limbs grow into each other.
fn bind_pose(joint: usize) -> Isometry3d {
    let spread = match NAMES[joint] {
        "upper_arm.l" => -0.8,
        "upper_arm.r" => 0.8,
        "thigh.l" => -0.15,
        "thigh.r" => 0.15,
        _ => 0.0,
    };
    Isometry3d::new(JOINTS[joint].at, about(Vec3::Z, spread))
}

/// A turn about an axis, of the same bits on every platform.
fn about(axis: Vec3, angle: f32) -> Quat {
    Quat::from_vec4((axis * ops::sin(0.5 * angle)).extend(ops::cos(0.5 * angle)))
}

/// Angles of a cycle, its end included.
fn cycle() -> impl Iterator<Item = f32> {
    (0..=KEYS).map(|key| TAU * key as f32 / KEYS as f32)
}

impl Gait {
    /// How a joint is turned in its parent's frame.
    fn rotation(&self, joint: usize, turn: f32) -> Quat {
        let left = NAMES[joint].ends_with(".l");
        let turn = if left { turn } else { turn + PI };
        let x = match NAMES[joint].split('.').next().unwrap_or_default() {
            "spine" => -self.lean,
            "head" => 0.5 * self.lean,
            "upper_arm" => -self.swing[1] * ops::sin(turn),
            "forearm" => self.bent[1] - 0.3 * self.swing[1] * ops::sin(turn),
            "thigh" => 0.25 * self.swing[0] + self.swing[0] * ops::sin(turn),
            // A knee is bent most as its leg comes forward.
            "shin" => -self.bent[0] * (1.0 + ops::cos(turn)),
            _ => 0.0,
        };
        // Clear of the skirt.
        let z = match NAMES[joint] {
            "upper_arm.l" => -0.35,
            "upper_arm.r" => 0.35,
            _ => 0.0,
        };
        about(Vec3::Z, z) * about(Vec3::X, x)
    }

    /// How far a joint is from its place.
    fn translation(&self, joint: usize, turn: f32) -> Vec3 {
        let is_root = JOINTS[joint].parent.is_none();
        // The hips are highest where a leg stands upright.
        let down = 1.0 - ops::cos(2.0 * turn);
        if is_root { Vec3::NEG_Y * self.bounce * down } else { Vec3::ZERO }
    }
}

/// Height of the hips, from which the skirt hangs \[m\].
const WAIST: f32 = HIPS + 0.16;
