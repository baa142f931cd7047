//! Exact distances at the nodes near the surface.

use super::{Nearest, layout::Layout, triangle::Triangle};
use bevy_math::DVec3;

/// Reach of the band in cells: the diagonal of a cell, so that every node of every cell that the surface
/// passes through is in it.
const REACH: f64 = 1.75;

/// Squared distance up to which [`measure`] has found the nearest of all triangles \[m2\].
pub(super) fn exact_within(layout: &Layout) -> f64 {
    let reach = REACH * f64::from(layout.cell_size);
    reach * reach
}

/// Measures every node within reach of a triangle against it, and keeps the nearest.
pub(super) fn measure(
    layout: &Layout,
    triangles: &[Triangle],
    nearest: &mut Nearest,
    progress: &mut dyn FnMut(f32),
) {
    const REPORT_EVERY: usize = 4096;
    let limit = exact_within(layout);
    for (number, triangle) in triangles.iter().enumerate() {
        if number % REPORT_EVERY == 0 {
            progress(number as f32 / triangles.len() as f32);
        }
        let [from, to] = nodes_around(layout, triangle);
        for z in from[2]..to[2] {
            for y in from[1]..to[1] {
                for x in from[0]..to[0] {
                    let node = layout.index(x, y, z);
                    let point = layout.node(x, y, z);
                    let bound = nearest.squared[node].min(limit);
                    // No point of the triangle is nearer than its plane.
                    let height = triangle.height(point);
                    if height * height > bound {
                        continue;
                    }
                    let squared = triangle.squared_distance(point);
                    if squared <= limit && squared < nearest.squared[node] {
                        nearest.squared[node] = squared;
                        nearest.triangle[node] = number as u32;
                    }
                }
            }
        }
    }
}

/// First node, and one past the last, along each axis, of the triangle's box grown by the reach.
fn nodes_around(layout: &Layout, triangle: &Triangle) -> [[usize; 3]; 2] {
    let (min, max) = triangle.bounds();
    let cell = f64::from(layout.cell_size);
    let reach = DVec3::splat(REACH);
    let origin = layout.origin.as_dvec3();
    let low = ((min - origin) / cell - reach).ceil().max(DVec3::ZERO);
    let high = ((max - origin) / cell + reach).floor().max(DVec3::ZERO);
    let size = layout.size();
    let from = low.to_array().map(|node| node as usize);
    let to = high.to_array().map(|node| node as usize + 1);
    [from, [to[0].min(size[0]), to[1].min(size[1]), to[2].min(size[2])]]
}
