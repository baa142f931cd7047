//! T-junctions: where one side of an edge has a particle on it that the other side does not have. Nothing sews such sides
//! together, so that a cloth would come open there.
//!
//! It is found by the borders of both sides: an edge with a triangle on one side only, and others, with triangles on one side
//! as well, that lead along it from one of its ends to the other. A slit that is closed at rest is none, as long as it
//! has particles on both sides.

use std::collections::BTreeMap;

use bevy_math::DVec3;

use crate::solver::topology::graph::edges::{Edge, Mesh};

/// How far from an edge a particle on it may lie, in lengths of the edge.
const NEAR: f64 = 1e-4;

/// A particle that lies on an edge of which it is no end, all by slot.
pub(crate) struct Junction {
    pub slot: u32,
    pub edge: [u32; 2],
}

/// The first T-junction of a mesh, if it has any.
pub(crate) fn find(mesh: &Mesh<'_>, edges: &[Edge]) -> Option<Junction> {
    let mut beside: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    let borders = || edges.iter().filter(|edge| edge.sides == 1).map(|edge| edge.ends);
    for [a, b] in borders() {
        beside.entry(a).or_default().push(b);
        beside.entry(b).or_default().push(a);
    }
    borders().find_map(|edge| {
        let slot = first_on(mesh, &beside, edge)?;
        Some(Junction { slot, edge })
    })
}

/// The first particle of a border that leads along an edge from its first end to its second, other than the edge itself.
fn first_on(mesh: &Mesh<'_>, beside: &BTreeMap<u32, Vec<u32>>, [a, b]: [u32; 2]) -> Option<u32> {
    let (from, way) = (mesh.at(a), mesh.at(b) - mesh.at(a));
    let mut path: Vec<u32> = Vec::new();
    let (mut at, mut so_far) = (a, 0.0);
    loop {
        let ahead = |&&next: &&u32| {
            next != b && share(mesh.at(next) - from, way).is_some_and(|share| share > so_far)
        };
        let neighbours = &beside[&at];
        if at != a && neighbours.contains(&b) {
            return path.first().copied();
        }
        at = *neighbours.iter().find(ahead)?;
        so_far = share(mesh.at(at) - from, way)?;
        path.push(at);
    }
}

/// Which part of a way a place is at, if it lies on it.
fn share(place: DVec3, way: DVec3) -> Option<f64> {
    let share = place.dot(way) / way.length_squared();
    let aside = (place - way * share).length();
    (share > 0.0 && share < 1.0 && aside <= NEAR * way.length()).then_some(share)
}
