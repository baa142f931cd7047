//! Things that slide.

use bevy::prelude::*;

/// Slides from one place to another \[m\] in the first seconds, gently.
#[derive(Component)]
pub struct Slide {
    pub from: Vec3,
    pub to: Vec3,
    pub seconds: f32,
}

/// Slides all.
pub fn slide(mut sliding: Query<(&Slide, &mut Transform)>, time: Res<Time>) {
    for (slide, mut transform) in &mut sliding {
        let way = (time.elapsed_secs() / slide.seconds).clamp(0.0, 1.0);
        transform.translation = slide.from.lerp(slide.to, way * way * (3.0 - 2.0 * way));
    }
}
