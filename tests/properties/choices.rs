//! What is chosen from: everything that is accepted, and some of what is not.

use bevy::math::{
    Quat, Vec3,
    primitives::{Capsule3d, Cone, Cuboid, Cylinder, InfinitePlane3d, Sphere, Torus},
};
use bevy_drape::{
    sdf::{SignedDistance, shapes::CapsuleBetween},
    solver::{
        Air, Bending, DampingForm, Gusts, Integrator, MassLumping, Material, Pose, Settings,
        SoftPin, StretchMethod, Substeps, Wind, WindFlow, WindShape, Zone,
    },
};
use proptest::prelude::*;

/// From one power of ten to another, evenly in the exponent.
pub fn logarithmic(from: i32, to: i32) -> impl Strategy<Value = f32> + Clone {
    (from as f32..to as f32).prop_map(|exponent| 10.0_f32.powf(exponent))
}

/// The same, or zero.
fn or_zero(from: i32, to: i32) -> impl Strategy<Value = f32> + Clone {
    prop_oneof![1 => Just(0.0), 4 => logarithmic(from, to)]
}

/// Each coordinate up to `most`.
pub fn vector(most: f32) -> impl Strategy<Value = Vec3> + Clone {
    prop::array::uniform3(-1.0_f32..1.0).prop_map(move |v| Vec3::from_array(v) * most)
}

/// Of any length up to `10^to`.
pub fn any_vector(to: i32) -> impl Strategy<Value = Vec3> + Clone {
    (vector(1.0), or_zero(-3, to)).prop_map(|(way, length)| way * length)
}

/// Seldom one that is none.
pub fn wild_vector(to: i32) -> impl Strategy<Value = Vec3> + Clone {
    let odd = vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, f32::MIN_POSITIVE];
    let odd = (0..3_usize, prop::sample::select(odd)).prop_map(|(axis, value)| {
        let mut vector = Vec3::ZERO;
        vector[axis] = value;
        vector
    });
    prop_oneof![1 => odd, 60 => any_vector(to)]
}

pub fn rotation() -> impl Strategy<Value = Quat> + Clone {
    (vector(1.0), -7.0_f32..7.0)
        .prop_map(|(axis, angle)| Quat::from_axis_angle(axis.normalize_or(Vec3::Y), angle))
}

/// The whole range that is accepted.
pub fn material() -> impl Strategy<Value = Material> + Clone {
    let stiffness = (or_zero(-3, 15), or_zero(-3, 15), or_zero(-9, 9), or_zero(-6, 9));
    let form = prop::sample::select(&[DampingForm::Axial, DampingForm::Relative][..]);
    let rest = (or_zero(-3, 6), or_zero(-3, 1), or_zero(-3, 3), or_zero(-4, 0));
    (logarithmic(-6, 4), stiffness, form, rest).prop_map(|(density, k, damping_form, rest)| {
        Material {
            area_density: density.clamp(1e-6, 1e4),
            thread_stiffness: k.0.min(1e15),
            shear_stiffness: k.1.min(1e15),
            flexural_rigidity: k.2.min(1e9),
            bending_friction: k.2.min(1e9),
            damping: k.3.min(1e9),
            damping_form,
            drag: rest.0.min(1e6),
            max_strain: rest.1,
            friction: rest.2,
            thickness: rest.3,
        }
    })
}

/// Integrators for study gain energy without end, and are outside of what is promised.
pub fn settings() -> impl Strategy<Value = Settings> + Clone {
    let substeps = prop_oneof![
        (1_u32..40).prop_map(Substeps::Fixed),
        (1_u32..40).prop_map(|budget| Substeps::Automatic { budget })
    ];
    let form = vec![
        StretchMethod::Automatic,
        StretchMethod::ExplicitSprings,
        StretchMethod::ImplicitThreads,
    ];
    let bending = vec![Bending::SecondDifference, Bending::Flexion];
    let lumping = vec![MassLumping::Lumped, MassLumping::Equal];
    let choices =
        (prop::sample::select(form), prop::sample::select(bending), prop::sample::select(lumping));
    let speeds = (logarithmic(-3, 5), logarithmic(-3, 5));
    (substeps, choices, 0_u32..6, any::<[bool; 2]>(), speeds).prop_map(
        |(substeps, (form, bending, lumping), provot_passes, [tethers, edges], speeds)| Settings {
            substeps,
            stretch_method: form,
            provot_passes,
            lumping,
            bending,
            integrator: Integrator::Verlet,
            tethers,
            max_speed: speeds.0.clamp(1e-3, 1e5),
            max_depenetration_speed: speeds.1.clamp(1e-3, 1e5),
            layers: u32::MAX,
            edges,
        },
    )
}

/// A shape of some size, and seldom of none.
pub fn shape() -> impl Strategy<Value = std::sync::Arc<dyn SignedDistance>> {
    let sizes = (or_zero(-3, 2), or_zero(-3, 2), or_zero(-3, 2));
    (0..8_u8, sizes, vector(1.0)).prop_map(|(which, (a, b, c), way)| {
        let shape: std::sync::Arc<dyn SignedDistance> = match which {
            0 => std::sync::Arc::new(Sphere::new(a)),
            1 => std::sync::Arc::new(Cuboid::new(a, b, c)),
            2 => std::sync::Arc::new(Capsule3d::new(a, b)),
            3 => std::sync::Arc::new(CapsuleBetween { from: way * a, to: way * b, radius: c }),
            4 => std::sync::Arc::new(InfinitePlane3d::new(way.normalize_or(Vec3::Y))),
            5 => std::sync::Arc::new(Cylinder::new(a, b)),
            6 => std::sync::Arc::new(Torus { minor_radius: a, major_radius: b }),
            _ => std::sync::Arc::new(Cone::new(a, b)),
        };
        shape
    })
}

pub fn pose() -> impl Strategy<Value = Pose> + Clone {
    (wild_vector(2), rotation(), logarithmic(-2, 2))
        .prop_map(|(translation, rotation, scale)| Pose { translation, rotation, scale })
}

/// A collider: its shape, and where it is at a tick's start and end; often where it was, or near.
#[derive(Clone, Debug)]
pub struct Solid {
    pub shape: std::sync::Arc<dyn SignedDistance>,
    pub start: Pose,
    pub end: Pose,
    pub friction: f32,
    pub measured: bool,
}

pub fn solid() -> impl Strategy<Value = Solid> {
    (shape(), pose(), prop::option::of((any_vector(3), rotation())), or_zero(-3, 3), any::<bool>())
        .prop_map(|(shape, start, moved, friction, measured)| {
            let end = moved.map_or(start, |(way, rotation)| Pose {
                translation: start.translation + way,
                rotation,
                ..start
            });
            Solid { shape, start, end, friction, measured }
        })
}

pub fn air() -> impl Strategy<Value = Option<Air>> {
    let air = (or_zero(-3, 5), or_zero(-3, 3), or_zero(-3, 3));
    prop::option::of(air.prop_map(|(density, drag, lift)| Air { density, drag, lift }))
}

/// Wind, without its zones.
pub fn wind() -> impl Strategy<Value = Wind<'static>> {
    let gusts = (or_zero(-2, 5), logarithmic(-2, 6), logarithmic(-3, 6), any::<u64>());
    (wild_vector(4), gusts, -1e6..1e6_f64).prop_map(|(velocity, gusts, time)| {
        let (strength, scale, period, seed) = gusts;
        let gusts = Gusts { strength, scale, period, seed };
        Wind { velocity, gusts, time, zones: &[] }
    })
}

pub fn zone() -> impl Strategy<Value = Zone> {
    let shape =
        (0..3_u8, logarithmic(-2, 3), logarithmic(-2, 3)).prop_map(|(which, a, b)| match which {
            0 => WindShape::Sphere(Sphere::new(a)),
            1 => WindShape::Cuboid(Cuboid::new(a, b, a)),
            _ => WindShape::Cone(Cone::new(a, b)),
        });
    let flow = prop_oneof![
        any_vector(4).prop_map(WindFlow::Directional),
        (-1e4_f32..1e4).prop_map(WindFlow::Radial)
    ];
    (shape, flow, or_zero(-3, 3), pose()).prop_map(|(shape, flow, falloff, pose)| Zone {
        shape,
        flow,
        falloff,
        pose,
    })
}

/// A soft pin of some particle.
pub fn soft_pin() -> impl Strategy<Value = SoftPin> {
    (any::<u32>(), logarithmic(-3, 9), or_zero(-3, 9)).prop_map(|(particle, stiffness, damping)| {
        SoftPin { particle, stiffness: stiffness.min(1e9), damping: damping.min(1e9) }
    })
}
