//! The wind at cloths, and its zones.

use bevy::color::palettes::css;
use bevy::prelude::*;

use crate::cloth::air::ClothAir;
use crate::cloth::wind::{ClothWind, ClothWindOverride};
use crate::gizmos::ClothGizmos;
use crate::simulation::ClothSimulation;
use crate::solver::{WindFlow, WindShape, Zone};
use crate::wind::zone::WindZones;

/// Arrows at a cloth, at most.
const MOST_ARROWS: usize = 64;

/// Arrows at particles of each cloth that feels the wind; outlines of the zones.
pub(super) fn draw_wind(
    cloths: Query<(&ClothSimulation, Option<&ClothWindOverride>), With<ClothAir>>,
    wind: Option<Res<ClothWind>>,
    zones: Option<Res<WindZones>>,
    time: Res<Time<Fixed>>,
    mut gizmos: Gizmos<ClothGizmos>,
) {
    let everywhere = wind.as_deref().copied().unwrap_or_default();
    let zones = zones.as_deref().map_or(&[][..], WindZones::get);
    let scale = gizmos.config_ext.wind_scale;
    for (cloth, own) in &cloths {
        let wind = own.map_or(everywhere, |own| own.0).at(time.elapsed_secs_f64(), zones);
        // One that cannot be used is told of elsewhere.
        if wind.validate().is_err() {
            continue;
        }
        let step = cloth.particle_count().div_ceil(MOST_ARROWS);
        for place in cloth.positions().step_by(step) {
            gizmos.arrow(place, place + scale * wind.at(place), css::SKY_BLUE);
        }
    }
    for zone in zones {
        draw_zone(zone, scale, &mut gizmos);
    }
}

fn draw_zone(zone: &Zone, scale: f32, gizmos: &mut Gizmos<ClothGizmos>) {
    let pose = &zone.pose;
    let place = Isometry3d::new(pose.translation, pose.rotation);
    let color = css::LIGHT_STEEL_BLUE;
    let (source, deep) = match zone.shape {
        WindShape::Cuboid(Cuboid { half_size }) => {
            let half_size = half_size * pose.scale;
            gizmos.primitive_3d(&Cuboid { half_size }, place, color);
            (Vec3::ZERO, half_size.min_element())
        }
        WindShape::Sphere(Sphere { radius }) => {
            let radius = radius * pose.scale;
            gizmos.sphere(place, radius, color);
            (Vec3::ZERO, radius)
        }
        WindShape::Cone(Cone { radius, height }) => {
            let (radius, height) = (radius * pose.scale, height * pose.scale);
            gizmos.primitive_3d(&Cone { radius, height }, place, color);
            (0.5 * height * Vec3::Y, height)
        }
    };
    let middle = place * source;
    match zone.flow {
        WindFlow::Directional(velocity) => {
            gizmos.arrow(middle, middle + scale * (pose.rotation * velocity), color);
        }
        WindFlow::Radial(speed) => {
            let ways = match zone.shape {
                WindShape::Cone(_) => &[Vec3::NEG_Y][..],
                _ => &[Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z],
            };
            for way in ways {
                // Towards the middle where it sucks.
                let inner = middle + 0.5 * deep * (pose.rotation * *way);
                gizmos.arrow(inner, inner + scale * speed * (pose.rotation * *way), color);
            }
        }
    }
}
