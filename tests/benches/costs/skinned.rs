//! The cost of knowing where a skinned mesh is.

use crate::turns::median;
use bevy::math::{Affine3A, Vec3};
use bevy_drape_core::surface::{Influences, skin_with_normals};
use std::{hint::black_box, time::Instant};

/// Vertices, and the joints that move them, four each.
const VERTICES: usize = 5000;
const JOINTS: usize = 20;
/// Longest that skinning them may take \[us\].
const LONGEST: f64 = 80.0;

/// Skins points and normals as a tick does.
pub fn skinning(rounds: usize) {
    let joints: Vec<_> = (0..JOINTS).map(|i| joint(i as f32)).collect();
    let points: Vec<_> = (0..VERTICES).map(|i| joint(i as f32).transform_point3(Vec3::X)).collect();
    let normals: Vec<_> = points.iter().map(|it| it.normalize()).collect();
    let influences: Vec<_> = (0..VERTICES)
        .map(|i| Influences {
            joints: [0, 1, 2, 3].map(|k| ((i / 50 + k) % JOINTS) as u16),
            weights: [0.4, 0.3, 0.2, 0.1],
        })
        .collect();
    let time = || {
        let before = Instant::now();
        let mut sum = Vec3::ZERO;
        skin_with_normals(
            black_box(&points),
            &normals,
            &influences,
            &joints,
            |_, place, normal| sum += place + normal,
        );
        black_box(sum);
        before.elapsed().as_secs_f64() * 1e6
    };
    let took = median((0..rounds).map(|_| time()).collect());
    let missed = if took > LONGEST { ": MISSED" } else { "" };
    println!("  skinning {VERTICES} vertices and normals: {took:.1} us, bound {LONGEST}{missed}");
}

fn joint(k: f32) -> Affine3A {
    Affine3A::from_rotation_y(0.3 * k) * Affine3A::from_translation(Vec3::new(k, 1.0, -k) * 0.01)
}
