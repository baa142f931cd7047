//! The render material of a cloth.

use bevy::prelude::*;

/// The same material for something that is seen from both sides, as cloth is: nothing is left out, and the back
/// is lit by normals that point its way.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::two_sided;
/// # fn make(mut materials: ResMut<Assets<StandardMaterial>>) {
/// let linen = materials.add(two_sided(StandardMaterial {
///     base_color: Color::srgb(0.86, 0.30, 0.25),
///     perceptual_roughness: 0.85,
///     ..default()
/// }));
/// # }
/// ```
pub fn two_sided(material: StandardMaterial) -> StandardMaterial {
    StandardMaterial { double_sided: true, cull_mode: None, ..material }
}
