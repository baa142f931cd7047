//! Crossings: edges of a cloth that pierce its faces.

use bevy_math::{DVec3, Vec3};

use crate::solver::cloth_contact::faces::faces;
use crate::solver::simd::soa::Soa;
use crate::solver::topology::Topology;

/// The box around an edge or a face, and which it is.
struct Bounds {
    low: Vec3,
    high: Vec3,
    of: usize,
}

/// The edges and faces of a cloth, where its particles are.
struct Surface {
    places: Vec<Vec3>,
    faces: Vec<[usize; 3]>,
    edges: Vec<[usize; 2]>,
}

impl Surface {
    fn new(topology: &Topology, x: &Soa, shift: Vec3) -> Self {
        let at = |particle: usize| x.get(topology.slot(particle)) + shift;
        let places = (0..topology.particle_count()).map(at).collect();
        let faces = faces(topology);
        let mut edges: Vec<_> = faces
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        Self { places, faces, edges }
    }
}

/// Edges that pierce faces of which they have no corner, each once for each of these faces. Looks at all of the cloth: for reports,
/// not for every frame.
pub(in crate::solver) fn crossing_edges(topology: &Topology, x: &Soa) -> Vec<[u32; 2]> {
    let own = Surface::new(topology, x, Vec3::ZERO);
    piercing(&own, &own, |ends, corners| !corners.iter().any(|corner| ends.contains(corner)))
}

/// The same, of edges of one cloth and faces of another, whose positions are shifted.
pub(in crate::solver) fn edges_through(
    of: (&Topology, &Soa),
    (topology, x): (&Topology, &Soa),
    shift: Vec3,
) -> Vec<[u32; 2]> {
    let of = Surface::new(of.0, of.1, Vec3::ZERO);
    piercing(&of, &Surface::new(topology, x, shift), |_, _| true)
}

/// Edges of one surface that pierce faces of another, those that are looked at.
fn piercing(
    of: &Surface,
    other: &Surface,
    looks_at: impl Fn([usize; 2], [usize; 3]) -> bool,
) -> Vec<[u32; 2]> {
    let edge_bounds = bounds(&of.places, &of.edges);
    let face_bounds = bounds(&other.places, &other.faces);
    let longest = face_bounds.iter().map(|face| face.high.x - face.low.x).fold(0.0, f32::max);
    let mut found = Vec::new();
    let mut first = 0;
    for edge in &edge_bounds {
        while face_bounds.get(first).is_some_and(|face| face.low.x < edge.low.x - longest) {
            first += 1;
        }
        let near = face_bounds[first..].iter().take_while(|face| face.low.x <= edge.high.x);
        let ends = of.edges[edge.of];
        for face in near {
            if edge.low.cmpgt(face.high).any() || face.low.cmpgt(edge.high).any() {
                continue;
            }
            let corners = other.faces[face.of];
            let segment = ends.map(|end| of.places[end].as_dvec3());
            let triangle = corners.map(|corner| other.places[corner].as_dvec3());
            if looks_at(ends, corners) && pierces(segment, triangle) {
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
