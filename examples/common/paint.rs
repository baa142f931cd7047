//! What things look like.

use crate::Look;
use bevy::{
    asset::RenderAssetUsages,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_drape::{prelude::*, two_sided};

/// Gives new things their material; cloth has two sides and a hem.
pub(crate) fn paint(
    new: Query<(Entity, &Look, Has<Cloth>), Added<Look>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
    mut commands: Commands,
) {
    for (entity, look, is_cloth) in &new {
        let mut material = StandardMaterial {
            base_color: look.color,
            perceptual_roughness: look.roughness,
            metallic: look.metallic,
            ..default()
        };
        if is_cloth {
            material = two_sided(material);
            material.reflectance = 0.25;
            material.base_color_texture = Some(images.add(hem(look.color)));
            material.base_color = Color::WHITE;
        }
        commands.entity(entity).insert(MeshMaterial3d(materials.add(material)));
    }
}

/// The color with two light stripes along the border.
fn hem(color: Color) -> Image {
    const SIDE: u32 = 512;
    let plain = color.to_srgba().to_u8_array();
    let light = color.mix(&Color::WHITE, 0.75).to_srgba().to_u8_array();
    let texel = |i: u32| {
        let (x, y) = (i % SIDE, i / SIDE);
        let inset = x.min(y).min(SIDE - 1 - x).min(SIDE - 1 - y);
        if matches!(inset, 16..24 | 30..46) { light } else { plain }
    };
    let texels = (0..SIDE * SIDE).flat_map(texel).collect();
    let size = Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 };
    let format = TextureFormat::Rgba8UnormSrgb;
    Image::new(size, TextureDimension::D2, texels, format, RenderAssetUsages::RENDER_WORLD)
}
