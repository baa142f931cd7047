//! The places of edges that are nearest to a solid, and those of faces: 16 at a time.

use bevy_math::Vec3;

use crate::sdf::{NearestBlock, PointBlock, SampleBlock, SegmentBlock};
use crate::solver::contact::collider::{Frame, Motion};
use crate::solver::contact::edges::candidates::{CloseFace, Until};
use crate::solver::contact::edges::list::Edges;
use crate::solver::contact::edges::place::Place;
use crate::solver::simd::block::{larger, smaller};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

/// Part of each corner in a place that is within a face.
const WITHIN: f32 = 0.05;
/// Part of a face's side that stands for what distances are rounded by.
const ROUNDED: f32 = 1e-3;

/// Searches edges, and notes the places of those that are to be moved out.
pub(super) struct SearchEdges<'a, 'u> {
    pub edges: &'a Edges,
    /// Those that are searched, by their places in the list.
    pub close: &'a [u32],
    pub x: &'a Soa,
    pub d: &'a Soa,
    pub motion: &'a Motion<'a>,
    /// Distance at which edges are held \[m\].
    pub held: f32,
    pub until: &'a mut Until<'u>,
    pub places: &'a mut Vec<Place>,
}

impl Kernel for SearchEdges<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { edges, x, d, motion, .. } = self;
        for close in self.close.chunks(LANES) {
            let mut ends = [[0; 2]; LANES];
            for (lane, ends) in ends.iter_mut().enumerate() {
                // Unused lanes look for what the last one does.
                *ends = edges.ends(close[lane.min(close.len() - 1)]);
            }
            let from = corner(&ends, 0, x, d, &motion.after);
            let to = corner(&ends, 1, x, d, &motion.after);
            let segments = SegmentBlock::between(&from, &to);
            let mut found = NearestBlock::default();
            motion.nearest_on_segments(&segments, &mut found);
            let NearestBlock { at, distance, least } = found;
            for (lane, &edge) in close.iter().enumerate() {
                let gap = distance[lane] * motion.after.scale - self.held;
                if gap < 0.0 {
                    self.places.push(Place::on_edge(edge, ends[lane], at[lane]));
                } else {
                    let gap = least[lane] * motion.after.scale - motion.overestimate - self.held;
                    self.until.set_edge(edge, gap);
                }
            }
        }
    }
}

/// Searches faces, which are few, and notes the places of those that are to be moved out.
pub(super) struct SearchFaces<'a, 'u> {
    pub faces: &'a [CloseFace],
    pub x: &'a Soa,
    pub d: &'a Soa,
    pub motion: &'a Motion<'a>,
    /// Distance at which faces are held \[m\].
    pub held: f32,
    pub until: &'a mut Until<'u>,
    pub places: &'a mut Vec<Place>,
}

impl Kernel for SearchFaces<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { x, d, motion, .. } = self;
        for faces in self.faces.chunks(LANES) {
            let mut corners = [[0; 3]; LANES];
            for (lane, corners) in corners.iter_mut().enumerate() {
                *corners = faces[lane.min(faces.len() - 1)].corners.map(|slot| slot as usize);
            }
            let FaceBlock { parts, distance, least } = nearest_on_faces(&corners, x, d, motion);
            for (lane, &CloseFace { face, corners }) in faces.iter().enumerate() {
                let parts = parts[lane];
                let gap = distance[lane] * motion.after.scale - self.held;
                if gap >= 0.0 {
                    let gap = least[lane] * motion.after.scale - motion.overestimate - self.held;
                    self.until.set_face(face, gap);
                } else if parts.iter().all(|&part| part > WITHIN) {
                    // What is nearest at a side of it is left to that edge.
                    self.places.push(Place { corners, parts, edge: None });
                }
            }
        }
    }
}

/// The places of [`LANES`] faces that are nearest.
struct FaceBlock {
    /// Parts of the corners in them.
    parts: [[f32; 3]; LANES],
    /// Distances there, in the collider's frame \[m\].
    distance: [f32; LANES],
    /// No place of a face is nearer than this, if the solid is convex \[m\].
    least: [f32; LANES],
}

/// Where corners are to be, in a collider's frame.
#[inline(always)]
fn corner<const N: usize>(
    corners: &[[usize; N]; LANES],
    which: usize,
    x: &Soa,
    d: &Soa,
    frame: &Frame,
) -> PointBlock {
    let mut points = PointBlock::default();
    for (lane, slots) in corners.iter().enumerate() {
        let slot = slots[which];
        points.set(lane, x.get(slot) + d.get(slot));
    }
    for lane in 0..LANES {
        points.set(lane, frame.to_local(points.point(lane)));
    }
    points
}

/// The places of faces that are nearest. The distance to a convex solid is a convex function: along a line from a corner, along one
/// beside the opposite side, and along the first again. So it lies above its tangent plane at any place.
#[inline(always)]
fn nearest_on_faces(
    corners: &[[usize; 3]; LANES],
    x: &Soa,
    d: &Soa,
    motion: &Motion<'_>,
) -> FaceBlock {
    let a = corner(corners, 0, x, d, &motion.after);
    let b = corner(corners, 1, x, d, &motion.after);
    let c = corner(corners, 2, x, d, &motion.after);
    let (to_b, to_c) = (SegmentBlock::between(&a, &b), SegmentBlock::between(&a, &c));
    let across = SegmentBlock::between(&b, &c);
    // How far from the first corner to the opposite side, and how far along that.
    let (mut out, mut beside) = (NearestBlock::default(), NearestBlock::default());
    beside.at = [0.5; LANES];
    for is_beside in [false, true, false] {
        let segments = if is_beside {
            // At the corner itself there is nothing beside it.
            let far = out.at.map(|out| larger(out, WITHIN));
            SegmentBlock::between(&to_b.at(&far), &to_c.at(&far))
        } else {
            SegmentBlock::between(&a, &across.at(&beside.at))
        };
        let mut found = NearestBlock::default();
        motion.nearest_on_segments(&segments, &mut found);
        *(if is_beside { &mut beside } else { &mut out }) = found;
    }
    let mut parts = [[0.0; 3]; LANES];
    for (parts, (out, beside)) in parts.iter_mut().zip(out.at.iter().zip(beside.at)) {
        *parts = [1.0 - out, out * (1.0 - beside), out * beside];
    }
    let places = SegmentBlock::between(&a, &across.at(&beside.at)).at(&out.at);
    let mut there = SampleBlock::default();
    motion.sample_block(&places, &mut there);
    let mut least = [0.0; LANES];
    for (lane, least) in least.iter_mut().enumerate() {
        let outward = Vec3::new(there.nx[lane], there.ny[lane], there.nz[lane]);
        let place = places.point(lane);
        let out_to = |corner: &PointBlock| outward.dot(corner.point(lane) - place);
        let lowest = smaller(smaller(out_to(&a), out_to(&b)), out_to(&c));
        let way = to_b.way.point(lane);
        *least = there.distance[lane] + lowest - ROUNDED * way.dot(way).sqrt();
    }
    FaceBlock { parts, distance: out.distance, least }
}
