//! Inside or outside.
//!
//! The nearest point may lie on an edge or a vertex, where one face's normal can be on the wrong side. The
//! sum of the normals around it, weighted by the faces' angles, never is (Baerentzen and Aanaes 2005).

use super::{
    Nearest,
    layout::Layout,
    mesh::ClosedMesh,
    triangle::{Feature, Triangle},
};
use bevy_math::DVec3;

/// The signed distance at every node \[m\].
pub(super) fn finish(
    layout: &Layout,
    mesh: &ClosedMesh,
    triangles: &[Triangle],
    nearest: &Nearest,
    progress: &mut dyn FnMut(f32),
) -> Box<[f32]> {
    let [width, height, depth] = layout.size();
    let mut values = Vec::with_capacity(layout.node_count());
    for z in 0..depth {
        progress(z as f32 / depth as f32);
        for y in 0..height {
            for x in 0..width {
                let node = layout.index(x, y, z);
                let triangle = &triangles[nearest.triangle[node] as usize];
                let distance = nearest.squared[node].sqrt();
                let outward = side(mesh, triangle, layout.node(x, y, z));
                values.push(if outward < 0.0 { -distance } else { distance } as f32);
            }
        }
    }
    progress(1.0);
    values.into_boxed_slice()
}

/// Positive in front of the triangle's nearest feature, negative behind it.
fn side(mesh: &ClosedMesh, triangle: &Triangle, point: DVec3) -> f64 {
    let (feature, offset) = triangle.nearest(point);
    let normal = match feature {
        Feature::Face => triangle.normal,
        Feature::Edge(edge) => mesh.edge_normal(triangle.source, edge),
        Feature::Vertex(corner) => mesh.vertex_normal(triangle.source, corner),
    };
    mesh.orientation * normal.dot(offset)
}
