//! A smooth skin over bones, for a character that needs no file: one mesh, bound to its joints.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
};

/// A capsule of the body, in the pose that the mesh is bound in: from, to and radius \[m\].
pub(crate) type Bone = (Vec3, Vec3, f32);

/// How far apart two bones still flow into each other \[m\].
const BLEND: f32 = 0.05;

/// The skin of some bones, each moved by the joint of its number; `parents` tells which hang together. Vertices are a `cell` apart \[m\].
///
/// Surface nets: a vertex for each cell of a grid that the surface goes through, a quad for each edge.
pub(crate) fn body(bones: &[Bone], parents: &[Option<usize>], cell: f32) -> Mesh {
    let reach = |(from, to, radius): &Bone| {
        let around = Vec3::splat(radius + 3.0 * cell);
        (from.min(*to) - around, from.max(*to) + around)
    };
    let (low, high) = bones.iter().map(reach).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap();
    let counts = ((high - low) / cell).as_usizevec3() + 1;
    let steps = [1, counts.x, counts.x * counts.y];
    let place = |node: usize| {
        let (x, y, z) = (node % counts.x, node / counts.x % counts.y, node / steps[2]);
        low + cell * Vec3::new(x as f32, y as f32, z as f32)
    };
    let nodes = steps[2] * counts.z;
    let inside: Vec<bool> = (0..nodes).map(|node| distance(place(node), bones) < 0.0).collect();

    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    let mut vertices = vec![0; nodes];
    let corners = |node: usize| {
        (0..8).map(move |c| node + (0..3).map(|a| (c >> a & 1) * steps[a]).sum::<usize>())
    };
    let cells = nodes - steps.iter().sum::<usize>();
    for (node, vertex) in vertices.iter_mut().enumerate().take(cells) {
        let within = corners(node).filter(|&corner| inside[corner]).count();
        if within % 8 != 0 {
            let mut point = place(node) + 0.5 * cell;
            for _ in 0..4 {
                point -= distance(point, bones) * outwards(point, bones);
            }
            *vertex = positions.len() as u32;
            positions.push(point);
            normals.push(outwards(point, bones));
        }
    }
    let mut indices = Vec::new();
    for node in 0..nodes - steps[2] {
        for axis in 0..3 {
            let (b, c) = (steps[(axis + 1) % 3], steps[(axis + 2) % 3]);
            if inside[node] != inside[node + steps[axis]] {
                let around = [node - b - c, node - c, node, node - b].map(|cell| vertices[cell]);
                let order = if inside[node] { [0, 1, 2, 0, 2, 3] } else { [0, 2, 1, 0, 3, 2] };
                indices.extend(order.map(|i| around[i]));
            }
        }
    }
    let (joints, weights) = positions.iter().map(|p| bind(*p, bones, parents)).unzip();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_JOINT_INDEX,
            VertexAttributeValues::Uint16x4(joints),
        )
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_JOINT_WEIGHT,
            VertexAttributeValues::Float32x4(weights),
        )
        .with_inserted_indices(Indices::U32(indices))
}

/// Distance to the surface of a bone \[m\], negative inside.
fn to_bone(point: Vec3, (from, to, radius): Bone) -> f32 {
    let along = to - from;
    let part = ((point - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    point.distance(from + part * along) - radius
}

/// Distance to all, with the corners between them filled (a smooth minimum).
fn distance(point: Vec3, bones: &[Bone]) -> f32 {
    bones.iter().map(|bone| to_bone(point, *bone)).fold(f32::MAX, |a, b| {
        let both = (1.0 - (a - b).abs() / BLEND).max(0.0);
        a.min(b) - 0.25 * BLEND * both * both
    })
}

/// Where the distance grows.
fn outwards(point: Vec3, bones: &[Bone]) -> Vec3 {
    let slope = |axis| distance(point + 1e-3 * axis, bones) - distance(point - 1e-3 * axis, bones);
    Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z)).normalize_or_zero()
}

/// The joints that move a point, and how much: that of the nearest bone, and those next to it.
fn bind(point: Vec3, bones: &[Bone], parents: &[Option<usize>]) -> ([u16; 4], [f32; 4]) {
    let far: Vec<f32> = bones.iter().map(|bone| to_bone(point, *bone)).collect();
    let nearest = (0..far.len()).min_by(|&a, &b| far[a].total_cmp(&far[b])).unwrap_or(0);
    let mut bound: Vec<(f32, usize)> = (0..far.len())
        .filter(|&i| i == nearest || parents[i] == Some(nearest) || parents[nearest] == Some(i))
        .map(|i| ((1.0 - (far[i] - far[nearest]) / BLEND).max(0.0), i))
        .collect();
    bound.sort_by(|a, b| b.0.total_cmp(&a.0));
    bound.resize(4, (0.0, 0));
    let sum: f32 = bound.iter().map(|(weight, _)| weight).sum();
    ([0, 1, 2, 3].map(|i| bound[i].1 as u16), [0, 1, 2, 3].map(|i| bound[i].0 / sum))
}
