//! The material of a cloth.

use bevy::prelude::*;

use crate::solver::{DampingForm, Material};

/// The material of a cloth. May be changed at any time.
///
/// All numbers are of the cloth, not of its springs: a finer sheet of the same material behaves the
/// same. The default is a light cotton that gives; for others see [`ClothMaterial::FABRICS`].
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothMaterial {
    /// Mass per area [kg/m2]. Higher is heavier.
    pub area_density: f32,
    /// Resistance of the woven threads to stretching [N/m]. Higher is stiffer and costs more
    /// substeps.
    pub thread_stiffness: f32,
    /// Resistance to shearing, a square turning into a rhombus [N/m]. Higher is stiffer.
    pub shear_stiffness: f32,
    /// Resistance to bending [N m]. Higher makes wider folds.
    pub flexural_rigidity: f32,
    /// Moment for each metre of width with which friction between the yarns resists a change of curvature: half of
    /// Kawabata's hysteresis of bending, 2HB, in \[N\]. Higher comes to rest sooner; with none, a cloth swings for minutes.
    pub bending_friction: f32,
    /// Damping between neighbouring particles [N s/m]. Higher stops ripples sooner.
    pub damping: f32,
    /// Which relative velocity `damping` acts on.
    pub damping_form: DampingForm,
    /// Rate at which still air stops the cloth [1/s]. Higher stops it sooner. The cheapest of airs;
    /// [`ClothAir`](crate::ClothAir) takes its place. The default is 1: the drag that `ClothAir` would have on the default
    /// cloth, broadside at 0.27 m/s.
    pub drag: f32,
    /// Strain, as a part of the rest length, that Provot's correction does not let a spring exceed
    /// \[1\]. Higher stretches more.
    pub max_strain: f32,
    /// Coulomb's coefficient of friction \[1\]. Higher slides less.
    pub friction: f32,
    /// Distance that the cloth keeps from colliders \[m\]. Higher is safer and shows a gap.
    pub thickness: f32,
}

impl ClothMaterial {
    /// The default.
    pub(crate) const USUAL: Self = Self {
        area_density: Material::USUAL.area_density,
        thread_stiffness: Material::USUAL.thread_stiffness,
        shear_stiffness: Material::USUAL.shear_stiffness,
        flexural_rigidity: Material::USUAL.flexural_rigidity,
        bending_friction: Material::USUAL.bending_friction,
        damping: Material::USUAL.damping,
        damping_form: Material::USUAL.damping_form,
        drag: Material::USUAL.drag,
        max_strain: Material::USUAL.max_strain,
        friction: Material::USUAL.friction,
        thickness: Material::USUAL.thickness,
    };
}

impl Default for ClothMaterial {
    fn default() -> Self {
        Self::USUAL
    }
}

impl From<ClothMaterial> for Material {
    fn from(material: ClothMaterial) -> Self {
        Self {
            area_density: material.area_density,
            thread_stiffness: material.thread_stiffness,
            shear_stiffness: material.shear_stiffness,
            flexural_rigidity: material.flexural_rigidity,
            bending_friction: material.bending_friction,
            damping: material.damping,
            damping_form: material.damping_form,
            drag: material.drag,
            max_strain: material.max_strain,
            friction: material.friction,
            thickness: material.thickness,
        }
    }
}
