//! Crossings: edges of a cloth that pierce its faces.

use core::cmp::Ordering;

use bevy_math::DVec3;

use crate::solver::self_contact::faces::faces;
use crate::solver::simd::soa::Soa;
use crate::solver::topology::Topology;

/// A span along x, and what it is of.
struct Span {
    low: f64,
    high: f64,
    of: usize,
}

/// Edges that pierce faces of which they have no corner, each once for each of these faces. Looks at all of the cloth: for reports,
/// not for every frame.
pub(in crate::solver) fn crossing_edges(topology: &Topology, x: &Soa) -> Vec<[u32; 2]> {
    let at = |particle: usize| x.get(topology.slot(particle)).as_dvec3();
    let places: Vec<DVec3> = (0..topology.particle_count()).map(at).collect();
    let faces = faces(topology);
    let mut edges: Vec<_> = faces
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let edge_spans = spans(&places, &edges);
    let face_spans = spans(&places, &faces);
    let longest = face_spans.iter().map(|span| span.high - span.low).fold(0.0, f64::max);
    let mut found = Vec::new();
    let mut first = 0;
    for edge in &edge_spans {
        while face_spans.get(first).is_some_and(|face| face.low < edge.low - longest) {
            first += 1;
        }
        let near = face_spans[first..].iter().take_while(|face| face.low <= edge.high);
        let ends = edges[edge.of];
        for face in near.filter(|face| face.high >= edge.low) {
            let corners = faces[face.of];
            let is_apart = !corners.iter().any(|corner| ends.contains(corner));
            if is_apart && pierces(ends.map(|end| places[end]), corners.map(|c| places[c])) {
                found.push(ends.map(|end| end as u32));
            }
        }
    }
    found
}

/// The spans of edges or faces along x, by where they begin.
fn spans<const N: usize>(places: &[DVec3], all: &[[usize; N]]) -> Vec<Span> {
    let span = |(of, corners): (usize, &[usize; N])| {
        let along = corners.map(|corner| places[corner].x);
        let low = along.into_iter().fold(f64::INFINITY, f64::min);
        let high = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
        Span { low, high, of }
    };
    let mut spans: Vec<_> = all.iter().enumerate().map(span).collect();
    spans.sort_by(|a, b| a.low.partial_cmp(&b.low).unwrap_or(Ordering::Equal));
    spans
}

/// Whether a segment pierces a triangle; one that only touches it does not.
fn pierces([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
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
