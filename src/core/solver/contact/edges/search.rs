//! The places of edges that are nearest to a solid, and those of faces: 16 at a time.

use crate::sdf::{NearestBlock, PointBlock, SegmentBlock};
use crate::solver::contact::collider::{Frame, Motion};
use crate::solver::contact::edges::contact_point::Place;
use crate::solver::contact::edges::list::Edges;
use crate::solver::simd::block::larger;
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

/// Part of each corner in a place that is within a face.
const WITHIN: f32 = 0.05;

/// Searches edges, and notes the places of those that are to be moved out.
pub(super) struct SearchEdges<'a> {
    pub edges: &'a Edges,
    /// Those that are searched, by their places in the list.
    pub close: &'a [u32],
    pub x: &'a Soa,
    pub d: &'a Soa,
    pub motion: &'a Motion<'a>,
    /// Distance at which edges are held \[m\].
    pub held: f32,
    /// The ways at which edges may touch, and the way that has been gone \[m\].
    pub until: &'a mut [f32],
    pub gone: f32,
    pub places: &'a mut Vec<Place>,
}

impl Kernel for SearchEdges<'_> {
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
            nearest_on_segments(motion, &segments, &mut found);
            let NearestBlock { at, distance, least } = found;
            for (lane, &edge) in close.iter().enumerate() {
                let gap = distance[lane] * motion.after.scale - self.held;
                if gap < 0.0 {
                    self.places.push(Place::on_edge(edge, ends[lane], at[lane]));
                } else {
                    let gap = least[lane] * motion.after.scale - motion.overestimate - self.held;
                    self.until[edge as usize] = self.gone + larger(gap, 0.0);
                }
            }
        }
    }
}

/// Searches faces, which are few, and notes the places of those that are to be moved out.
pub(super) struct SearchFaces<'a> {
    /// Slots of the corners.
    pub faces: &'a [[u32; 3]],
    pub x: &'a Soa,
    pub d: &'a Soa,
    pub motion: &'a Motion<'a>,
    /// Distance at which faces are held \[m\].
    pub held: f32,
    pub places: &'a mut Vec<Place>,
}

impl Kernel for SearchFaces<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for faces in self.faces.chunks(LANES) {
            let mut corners = [[0; 3]; LANES];
            for (lane, corners) in corners.iter_mut().enumerate() {
                *corners = faces[lane.min(faces.len() - 1)].map(|slot| slot as usize);
            }
            let (parts, distance) = nearest_on_faces(&corners, self.x, self.d, self.motion);
            for (lane, &corners) in faces.iter().enumerate() {
                let parts = parts[lane];
                let gap = distance[lane] * self.motion.after.scale - self.held;
                // What is nearest at a side of it is left to that edge.
                if gap < 0.0 && parts.iter().all(|&part| part > WITHIN) {
                    self.places.push(Place { corners, parts, edge: None });
                }
            }
        }
    }
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

/// The places of segments that are nearest to a collider, in its frame; in the instructions around it where the solid is known.
#[inline(always)]
fn nearest_on_segments(motion: &Motion<'_>, segments: &SegmentBlock, out: &mut NearestBlock) {
    match motion.known {
        Some(known) => known.nearest_on_segments(segments, out),
        None => motion.shape.nearest_on_segments(segments, out),
    }
}

/// The places of faces that are nearest, as parts of their corners, and their distances. The distance to a convex solid is a
/// convex function: along a line from a corner, along one beside the opposite side, and along the first again.
#[inline(always)]
fn nearest_on_faces(
    corners: &[[usize; 3]; LANES],
    x: &Soa,
    d: &Soa,
    motion: &Motion<'_>,
) -> ([[f32; 3]; LANES], [f32; LANES]) {
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
        nearest_on_segments(motion, &segments, &mut found);
        *(if is_beside { &mut beside } else { &mut out }) = found;
    }
    let mut parts = [[0.0; 3]; LANES];
    for (parts, (out, beside)) in parts.iter_mut().zip(out.at.iter().zip(beside.at)) {
        *parts = [1.0 - out, out * (1.0 - beside), out * beside];
    }
    (parts, out.distance)
}
