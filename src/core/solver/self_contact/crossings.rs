//! Crossings: edges of a cloth that pierce its faces.

use bevy_math::{DVec3, Vec3};

use crate::solver::self_contact::faces::faces;
use crate::solver::simd::soa::Soa;
use crate::solver::topology::Topology;

/// The box around an edge or a face, and which it is.
struct Bounds {
    low: Vec3,
    high: Vec3,
    of: usize,
}

/// Edges that pierce faces of which they have no corner, each once for each of these faces. Looks at all of the cloth: for reports,
/// not for every frame.
pub(in crate::solver) fn crossing_edges(topology: &Topology, x: &Soa) -> Vec<[u32; 2]> {
    let at = |particle: usize| x.get(topology.slot(particle));
    let places: Vec<Vec3> = (0..topology.particle_count()).map(at).collect();
    let faces = faces(topology);
    let mut edges: Vec<_> = faces
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let edge_bounds = bounds(&places, &edges);
    let face_bounds = bounds(&places, &faces);
    let longest = face_bounds.iter().map(|face| face.high.x - face.low.x).fold(0.0, f32::max);
    let mut found = Vec::new();
    let mut first = 0;
    for edge in &edge_bounds {
        while face_bounds.get(first).is_some_and(|face| face.low.x < edge.low.x - longest) {
            first += 1;
        }
        let near = face_bounds[first..].iter().take_while(|face| face.low.x <= edge.high.x);
        let ends = edges[edge.of];
        for face in near {
            if edge.low.cmpgt(face.high).any() || face.low.cmpgt(edge.high).any() {
                continue;
            }
            let corners = faces[face.of];
            let is_apart = !corners.iter().any(|corner| ends.contains(corner));
            let place = |particle: usize| places[particle].as_dvec3();
            if is_apart && pierces(ends.map(place), corners.map(place)) {
                found.push(ends.map(|end| end as u32));
            }
        }
    }
    found
}

/// The boxes around edges or faces, by where they begin along x.
fn bounds<const N: usize>(places: &[Vec3], all: &[[usize; N]]) -> Vec<Bounds> {
    let around = |(of, corners): (usize, &[usize; N])| {
        let none = Bounds { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, of };
        corners.iter().fold(none, |Bounds { low, high, of }, &corner| {
            let p = places[corner];
            Bounds { low: low.min(p), high: high.max(p), of }
        })
    };
    let mut bounds: Vec<_> = all.iter().enumerate().map(around).collect();
    bounds.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
    bounds
}

/// Whether a segment pierces a triangle; one that only touches it does not.
pub(super) fn pierces([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let (low, high) = (p.min(q), p.max(q));
    if a.min(b).min(c).cmpgt(high).any() || a.max(b).max(c).cmplt(low).any() {
        return false;
    }
    let volume = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
    if volume(a, b, c, p) * volume(a, b, c, q) >= 0.0 {
        return false;
    }
    let sides = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    sides.iter().all(|&side| side > 0.0) || sides.iter().all(|&side| side < 0.0)
}
