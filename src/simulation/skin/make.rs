//! The skin of a cloth, made of its components and its mesh.

use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;

use crate::cloth::skin::{ClothSkin, MapSource};
use crate::error::ClothErrorKind;
use crate::error::skin::SkinProblem;
use crate::mesh::rest_shape::RestShape;
use crate::mesh::skinned::SkinnedShape;
use crate::pose::bindposes::Bindposes;
use crate::pose::skeleton::{Joints, Seen};
use crate::simulation::ClothSimulation;
use crate::simulation::skin::{Limits, Skin};

/// What skins are made of.
#[derive(SystemParam)]
pub(crate) struct Skins<'w, 's> {
    bindposes: Bindposes<'w>,
    names: Query<'w, 's, &'static Name>,
    pub joints: Joints<'w, 's>,
}

impl Skins<'_, '_> {
    /// The skin of a mesh that has been made a rest shape, and another that is `drawn`, where there is one; `None` while its bind poses are loading.
    ///
    /// # Errors
    /// [`SkinProblem`] where it has none that can be used.
    pub fn make(
        &self,
        skinned: Option<&SkinnedMesh>,
        mesh: &Mesh,
        rest: &RestShape,
        drawn: Option<&RestShape>,
    ) -> Result<Option<Skin>, SkinProblem> {
        let skinned = skinned.ok_or(SkinProblem::NotSkinned)?;
        let Some(bindposes) = self.bindposes.of(skinned)? else { return Ok(None) };
        let joints = &skinned.joints;
        let shape = SkinnedShape::read(mesh, rest, joints.len())?;
        let drawn = drawn.map(|it| SkinnedShape::read(mesh, it, joints.len())).transpose()?;
        let skeleton = self.joints.skeleton(joints, bindposes);
        let mut seen = Seen::default();
        self.joints.look(&skeleton, &mut seen).map_err(SkinProblem::JointGone)?;
        let shares = shape.shares(joints.len());
        let mut leader = 0;
        for (joint, &share) in shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
            if let Err(scale) = scale_of(&seen.matrices[joint]) {
                return Err(SkinProblem::UnevenScale { joint: joints[joint], scale });
            }
            if share > shares[leader] {
                leader = joint;
            }
        }
        let root = self.joints.root(skeleton.joints[leader]);
        Ok(Some(Skin::new(skeleton, shape, drawn, leader as u16, (seen, root))))
    }

    /// The limits of all particles, as a component asks for them.
    ///
    /// # Errors
    /// [`SkinProblem`] of the first map that cannot be used.
    pub fn limits(
        &self,
        asked: &ClothSkin,
        skin: &Skin,
        mesh: &Mesh,
        (rest, drawn): (&RestShape, &RestShape),
        scale: f32,
    ) -> Result<Limits, SkinProblem> {
        let joints = &skin.skeleton.joints;
        let is_called = |name: &str, joint: &Entity| {
            self.names.get(*joint).is_ok_and(|known| known.as_str() == name)
        };
        let joint = |name: &str| joints.iter().position(|it| is_called(name, it)).map(|i| i as u16);
        let source = |rest, shape| MapSource { rest, mesh, shape, joint: &joint };
        let of_particles = asked.limits(&source(rest, &skin.shape), scale)?;
        let at_zero = match &skin.drawn {
            Some(it) => asked.at_zero(&source(drawn, &it.shape))?,
            None => Vec::new(),
        };
        Ok(Limits { of_particles, at_zero })
    }
}

impl Skin {
    /// How much larger than the mesh the skeleton makes the cloth at the last tick's end. Rounded to a part in 8000, so that cloths of
    /// characters that are alike share what follows from it.
    ///
    /// # Errors
    /// The scale of each axis, where it cannot be used.
    pub fn scale(&self) -> Result<f32, Vec3> {
        const HALF: u32 = 1 << 10;
        let scale = scale_of(&self.state.track.end()[self.leader as usize])?;
        Ok(f32::from_bits((scale.to_bits() + HALF) & !(2 * HALF - 1)))
    }

    /// Whether the cloth has a size.
    ///
    /// # Errors
    /// [`SkinProblem::UnevenScale`] of the joint that leads it.
    pub fn check_scale(&self) -> Result<(), SkinProblem> {
        let problem = |scale| SkinProblem::UnevenScale { joint: self.leader(), scale };
        self.scale().map(|_| ()).map_err(problem)
    }
}

/// Puts a skin on a cloth that is new, as its component asks for.
///
/// # Errors
/// A map that cannot be used, or a place that is too far.
pub(crate) fn put_on(
    cloth: &mut ClothSimulation,
    worn: &ClothSkin,
    mut skin: Skin,
    mesh: &Mesh,
    skins: &Skins,
) -> Result<(), ClothErrorKind> {
    let shapes = (&cloth.in_force.rest_shape, cloth.drawn_shape());
    let scale = cloth.in_force.placed.scale;
    let limits = skins.limits(worn, &skin, mesh, shapes, scale).map_err(ClothErrorKind::Skin)?;
    limit(cloth, &mut skin, &limits)?;
    cloth.solver.place(skin.places()).map_err(ClothErrorKind::Solver)?;
    cloth.in_force.skin = Some(worn.clone());
    cloth.skin = Some(Box::new(skin));
    Ok(())
}

/// Takes over limits for a skin.
pub(crate) fn limit(
    cloth: &mut ClothSimulation,
    skin: &mut Skin,
    limits: &Limits,
) -> Result<(), ClothErrorKind> {
    let all = &limits.of_particles;
    cloth.solver.set_skin(Some(all)).map_err(ClothErrorKind::Solver)?;
    skin.limit(limits);
    // Room for every motion now, so that no tick needs any.
    cloth.tick.motions.skin.reserve_exact(all.len());
    Ok(())
}

/// The scale of a matrix that turns, and scales alike along all axes.
fn scale_of(matrix: &Affine3A) -> Result<f32, Vec3> {
    let axes = matrix.matrix3;
    let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis];
    let scale = Vec3::new(x.length(), y.length(), z.length());
    let mean = scale.element_sum() / 3.0;
    let skew = x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs());
    let is_even = (scale - mean).abs().max_element() <= 1e-3 * mean && skew <= 1e-3 * mean * mean;
    let is_mirrored = x.cross(y).dot(z) <= 0.0;
    let usable = (1e-6..=1e6).contains(&mean);
    if usable && is_even && !is_mirrored {
        Ok(mean)
    } else {
        Err(if is_mirrored { -scale } else { scale })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::{Mat3A, Vec3A};

    #[test]
    fn only_even_scales_are_taken() {
        let turn = Quat::from_euler(EulerRot::XYZ, 0.3, -1.2, 2.0);
        let scaled = |x, y, z| {
            let scale = Vec3::new(x, y, z);
            scale_of(&Affine3A::from_scale_rotation_translation(scale, turn, Vec3::ONE))
        };
        assert!((scaled(0.01, 0.01, 0.01).unwrap() - 0.01).abs() < 1e-7);
        assert!(scaled(1.0, 1.01, 1.0).is_err());
        assert!(scaled(-2.0, 2.0, 2.0).unwrap_err().abs_diff_eq(Vec3::splat(-2.0), 1e-5));
        assert!(scaled(0.0, 0.0, 0.0).is_err());
        assert!(scaled(f32::NAN, 1.0, 1.0).is_err());
        let mut sheared = Affine3A::IDENTITY;
        sheared.matrix3 = Mat3A::from_cols(Vec3A::X, Vec3A::new(0.6, 0.8, 0.0), Vec3A::Z);
        assert!(scale_of(&sheared).is_err());
    }
}
