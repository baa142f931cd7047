//! Materials and settings, from nothing but threads to the stiffest that is accepted.

use bevy_drape::{
    ClothMaterial,
    solver::{DampingForm, Material, Settings, StretchMethod, Substeps},
};

/// 0.2 kg/m2 and threads of 1000 N/m; all else is off.
pub fn plain() -> Material {
    Material {
        area_density: 0.2,
        thread_stiffness: 1000.0,
        shear_stiffness: 0.0,
        flexural_rigidity: 0.0,
        bending_friction: 0.0,
        damping: 0.0,
        damping_form: DampingForm::Axial,
        drag: 0.0,
        max_strain: 10.0,
        friction: 0.0,
        thickness: 0.005,
    }
}

pub fn settings(form: StretchMethod, substeps: u32) -> Settings {
    Settings { stretch_method: form, substeps: Substeps::Fixed(substeps), ..Settings::default() }
}

/// What a user gets who sets nothing.
pub fn usual() -> Material {
    ClothMaterial::default().into()
}

/// The stiffest that is accepted.
pub fn stiffest() -> Material {
    Material {
        thread_stiffness: 1e15,
        shear_stiffness: 1e15,
        flexural_rigidity: 1e9,
        damping: 1e9,
        ..usual()
    }
}
