//! Whether the way along a cloth is the straight one: in a flat mesh with a convex border.

use bevy_math::DVec3;

use crate::solver::topology::graph::edges::{Edge, Mesh};

/// How far from the plane a particle may be, relative to the size of the mesh, and how far inside the
/// line through a border edge the others.
const TOLERANCE: f64 = 1e-4;

/// A mesh that lies in one plane, all of it on one side of each of its border edges. That takes one
/// border, without holes, and no two sheets on each other.
pub(crate) fn is_flat_and_convex(mesh: &Mesh<'_>, edges: &[Edge]) -> bool {
    let [a, b, c] = mesh.triangles[0].map(|slot| mesh.at(slot));
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let size = (0..mesh.positions.len() as u32).map(|slot| mesh.at(slot).distance(a));
    let tolerance = TOLERANCE * size.fold(0.0, f64::max);
    let in_plane = |slot: u32| (mesh.at(slot) - a).dot(normal).abs() <= tolerance;
    if !(0..mesh.positions.len() as u32).all(in_plane) || edges.iter().any(|edge| edge.sides > 2) {
        return false;
    }
    // The border alone is compared with itself: what is inside a convex border is inside all its lines.
    let border: Vec<&Edge> = edges.iter().filter(|edge| edge.sides == 1).collect();
    let mut corners: Vec<u32> = border.iter().flat_map(|edge| edge.ends).collect();
    corners.sort_unstable();
    corners.dedup();
    // A closed line has as many corners as edges; the areas of sheets on each other would add up to more
    // than it encloses.
    let inside = border.iter().all(|edge| {
        let outward = outward(mesh, edge, normal);
        corners
            .iter()
            .all(|&slot| (mesh.at(slot) - mesh.at(edge.ends[0])).dot(outward) <= tolerance)
    });
    let doubled: f64 = border
        .iter()
        .map(|edge| (mesh.at(edge.ends[0]) - a).dot(outward(mesh, edge, normal)) * edge.length)
        .sum();
    let area: f64 = (0..mesh.triangles.len()).map(|triangle| mesh.area(triangle)).sum();
    inside && corners.len() == border.len() && (0.5 * doubled - area).abs() <= 1e-3 * area
}

/// In the plane, across a border edge and away from its triangle.
fn outward(mesh: &Mesh<'_>, edge: &Edge, normal: DVec3) -> DVec3 {
    let [a, b] = edge.ends.map(|slot| mesh.at(slot));
    let across = (b - a).cross(normal).normalize_or_zero();
    if (mesh.at(edge.opposite[0]) - a).dot(across) > 0.0 { -across } else { across }
}
