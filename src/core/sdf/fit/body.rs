//! Shares a skinned surface out to its joints.

use bevy_math::{Affine3A, Vec3};
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::{SurfacePoint, fit_capsules};
use crate::sdf::shapes::CapsuleBetween;

/// Root mean square distance that is good enough, as a part of the square root of the body's area: 1 cm on an adult of 1.8 m^2.
const TOLERANCE: f32 = 0.0075;
/// Most capsules of a joint.
const MOST: usize = 4;
/// Part of the body's area below which a joint's skin goes to its parent: fingers go to the hand.
const SMALLEST: f32 = 0.004;

/// A skinned mesh of a body. Its points are in the mesh's own frame, as it was bound.
#[derive(Clone, Copy, Debug)]
pub struct BodySurface<'a> {
    /// Places of the vertices.
    pub points: &'a [Vec3],
    /// Triangles between them.
    pub triangles: &'a [[u32; 3]],
    /// For each vertex the joint that moves it most, by its place in `joints`.
    pub owners: &'a [u16],
    /// The joints that move the mesh, by their places in the skeleton.
    pub joints: &'a [usize],
    /// From the mesh's frame to that of each of `joints`.
    pub inverse_bindposes: &'a [Affine3A],
}

/// A capsule in the frame of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointCapsule {
    /// The joint, by its place in the skeleton.
    pub joint: usize,
    /// The capsule.
    pub capsule: CapsuleBetween,
}

/// The part of a joint in a surface: its vertices.
struct Share {
    surface: usize,
    /// Vertices and their areas in the mesh's frame.
    vertices: Vec<(u32, f32)>,
}

/// Capsules near all surfaces of a body, for a skeleton of which `parents` tells what hangs on what.
///
/// Each vertex goes to the joint that moves it most, and very small parts to the joint above. `fit_capsules` does the rest. Threads of
/// rayon's pool share the surfaces and the joints; the capsules are the same on any number of them.
pub fn fit_body(surfaces: &[BodySurface], parents: &[Option<usize>]) -> Vec<JointCapsule> {
    let mut shares = share_out(surfaces, parents.len());
    let areas = |shares: &[Share]| shares.iter().map(Share::area).sum::<f32>();
    // In the frames of joints, which are of one size in any skeleton that is not scaled joint by joint.
    let scaled = |joint: usize, shares: &[Share]| {
        let scale =
            |it: &Share| frame(&surfaces[it.surface], joint).map_or(0.0, |it| scale(&it).powi(2));
        shares.iter().map(|it| it.area() * scale(it)).sum::<f32>()
    };
    let total: f32 = shares.iter().map(|it| areas(it)).sum();
    for joint in deepest_first(parents) {
        let is_small = areas(&shares[joint]) < SMALLEST * total;
        if let Some(parent) = parents[joint].filter(|_| is_small) {
            let (go, stay): (Vec<_>, Vec<_>) = core::mem::take(&mut shares[joint])
                .into_iter()
                .partition(|it| frame(&surfaces[it.surface], parent).is_some());
            shares[parent].extend(go);
            shares[joint] = stay;
        }
    }
    let all: f32 = shares.iter().enumerate().map(|(joint, shares)| scaled(joint, shares)).sum();
    let tolerance = TOLERANCE * all.sqrt();
    let of_joint = |(joint, shares): (usize, &Vec<Share>)| {
        let points = in_frame(surfaces, joint, shares);
        let capsules = fit_capsules(&points, tolerance, MOST);
        capsules.into_iter().map(move |capsule| JointCapsule { joint, capsule })
    };
    shares.par_iter().enumerate().flat_map_iter(of_joint).collect()
}

impl Share {
    fn area(&self) -> f32 {
        self.vertices.iter().map(|(_, area)| area).sum()
    }
}

/// The vertices that each joint moves most.
fn share_out(surfaces: &[BodySurface], joints: usize) -> Vec<Vec<Share>> {
    let mut shares: Vec<Vec<Share>> = (0..joints).map(|_| Vec::new()).collect();
    let areas: Vec<_> = surfaces.par_iter().map(areas).collect();
    for (index, (surface, areas)) in surfaces.iter().zip(areas).enumerate() {
        for (vertex, area) in (0..).zip(areas) {
            let joint = surface.joints[surface.owners[vertex as usize] as usize];
            if area <= 0.0 {
                continue;
            }
            match shares[joint].last_mut() {
                Some(share) if share.surface == index => share.vertices.push((vertex, area)),
                _ => shares[joint].push(Share { surface: index, vertices: vec![(vertex, area)] }),
            }
        }
    }
    shares
}

/// A third of the triangles around each vertex.
fn areas(surface: &BodySurface) -> Vec<f32> {
    let mut areas = vec![0.0; surface.points.len()];
    for triangle in surface.triangles {
        let [a, b, c] = triangle.map(|vertex| surface.points[vertex as usize]);
        let area = (b - a).cross(c - a).length() / 6.0;
        for &vertex in triangle {
            areas[vertex as usize] += area;
        }
    }
    areas
}

/// Children before their parents.
fn deepest_first(parents: &[Option<usize>]) -> Vec<usize> {
    let depth = |joint: &usize| {
        let up = |joint: &usize| parents[*joint];
        // A circle ends as well.
        core::iter::successors(Some(*joint), up).take(parents.len()).count()
    };
    let mut order: Vec<usize> = (0..parents.len()).collect();
    order.sort_by_cached_key(|joint| core::cmp::Reverse(depth(joint)));
    order
}

/// From a surface's frame to that of a joint, where it has the joint.
fn frame(surface: &BodySurface, joint: usize) -> Option<Affine3A> {
    let place = surface.joints.iter().position(|it| *it == joint)?;
    Some(surface.inverse_bindposes[place])
}

fn scale(matrix: &Affine3A) -> f32 {
    matrix.matrix3.determinant().abs().cbrt()
}

fn in_frame(surfaces: &[BodySurface], joint: usize, shares: &[Share]) -> Vec<SurfacePoint> {
    let mut points = Vec::new();
    for Share { surface, vertices } in shares {
        let surface = &surfaces[*surface];
        let Some(frame) = frame(surface, joint) else { continue };
        let scale = scale(&frame).powi(2);
        points.extend(vertices.iter().map(|&(vertex, area)| SurfacePoint {
            point: frame.transform_point3(surface.points[vertex as usize]),
            area: area * scale,
        }));
    }
    points
}
