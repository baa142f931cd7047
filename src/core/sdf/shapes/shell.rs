//! A surface of triangles with a thickness.

use super::face::{Face, NearestFaces};
use super::length_and_direction;
use super::tree::{Bounds, BoxTree, Walk};
use crate::sdf::segments::{self, NearestBlock, SegmentBlock};
use crate::sdf::{KnownShape, LANES, PointBlock, SampleBlock, SdfSample, SignedDistance};
use bevy_math::{Vec3, bounding::Aabb3d};
use core::fmt;

/// Most triangles in a leaf of the tree.
const LEAF: usize = 4;
/// What makes up for rounding of the distance that a place has at most.
const ROUNDED_UP: f32 = 1.0 + 1e-4;
/// Furthest that a corner may be from the origin along an axis \[m\].
const FURTHEST: f32 = 1e7;

/// Everything within a distance of triangles: the floors and walls of a level, a sail of wood, a bowl. The surface
/// may be open, and need not be one piece.
///
/// It is solid on both sides of the triangles and has no inside besides, so that what has come through is pushed away to
/// the other side. What is fast is looked at along its whole way, and does not come through.
///
/// Outside, the distance is exact up to the rounding of `f32`. Inside, it is that to the nearest triangle less the radius: where
/// triangles meet, a point is taken for less deep than it is, never for deeper. A point looks at a few triangles near it through a
/// tree of boxes, however many there are.
pub struct Shell {
    /// In the order of the tree's leaves.
    faces: Box<[Face]>,
    /// Whose triangles they are.
    tree: BoxTree,
    radius: f32,
    bounds: Aabb3d,
}

/// Why triangles make no [`Shell`].
#[derive(thiserror::Error, Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ShellError {
    /// There is nothing to be near to.
    #[error("a shell needs at least one triangle")]
    NoTriangles,
    /// Indices are in threes.
    #[error("a shell's {indices} indices are not in threes: give three for each triangle")]
    NotTriangles {
        /// How many there are.
        indices: usize,
    },
    /// An index is of no vertex.
    #[error(
        "triangle {triangle} of a shell has vertex {index} of {vertices}: let its indices be below that"
    )]
    Index {
        /// Number of the triangle, from zero.
        triangle: usize,
        /// The index that it has.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A corner is nowhere.
    #[error("vertex {vertex} of a shell is at {position}: give it finite numbers, within 1e7 m")]
    Position {
        /// Number of the vertex, from zero.
        vertex: u32,
        /// Where it was put \[m\].
        position: Vec3,
    },
    /// The radius is none.
    #[error(
        "a shell's radius, half its thickness, is {radius}: give it a number above 0, up to 1e7 m"
    )]
    Radius {
        /// The radius that was given \[m\].
        radius: f32,
    },
}

impl Shell {
    /// All that is within `radius` \[m\] of triangles: of vertices \[m\], and three indices each.
    ///
    /// Triangles without an area count as the line or the point that they are. Half a million triangles take some 0.3 s.
    ///
    /// # Errors
    ///
    /// If there are no triangles, an index is of no vertex, or a number is not what it has to be.
    pub fn new(vertices: &[Vec3], indices: &[u32], radius: f32) -> Result<Self, ShellError> {
        if !(radius > 0.0 && radius <= FURTHEST) {
            return Err(ShellError::Radius { radius });
        }
        let (triangles, rest) = indices.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(ShellError::NotTriangles { indices: indices.len() });
        }
        if triangles.is_empty() {
            return Err(ShellError::NoTriangles);
        }
        let corner = |triangle: usize, index: u32| {
            let Some(&position) = vertices.get(index as usize) else {
                return Err(ShellError::Index { triangle, index, vertices: vertices.len() });
            };
            let is_somewhere = position.is_finite() && position.abs().max_element() <= FURTHEST;
            is_somewhere.then_some(position).ok_or(ShellError::Position { vertex: index, position })
        };
        let mut corners = Vec::with_capacity(triangles.len());
        for (triangle, &[a, b, c]) in triangles.iter().enumerate() {
            corners.push([corner(triangle, a)?, corner(triangle, b)?, corner(triangle, c)?]);
        }
        let boxes: Vec<Bounds> = corners.iter().map(bounds_of).collect();
        let (tree, order) = BoxTree::new(&boxes, LEAF);
        let face = |&number: &u32| Face::new(corners[number as usize]);
        let whole = tree.bounds();
        let (low, high) = (Vec3::from(whole.low) - radius, Vec3::from(whole.high) + radius);
        Ok(Self {
            faces: order.iter().map(face).collect(),
            tree,
            radius,
            bounds: Aabb3d { min: low.into(), max: high.into() },
        })
    }

    /// Number of triangles, at least one.
    pub fn triangle_count(&self) -> usize {
        self.faces.len()
    }

    /// Distance of the surface from the triangles \[m\].
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Memory that the shell takes \[B\].
    pub fn memory_bytes(&self) -> usize {
        size_of::<Self>() + size_of_val::<[Face]>(&self.faces) + self.tree.memory_bytes()
    }

    /// The nearest triangle's squared distance, the way from its nearest place, and its place in the list.
    fn nearest(&self, point: Vec3) -> (f32, Vec3, usize) {
        let (mut least, mut away, mut found) = (f32::INFINITY, Vec3::ZERO, 0);
        let mut walk = Walk::to_point(point.to_array());
        while let Some(places) = walk.next(&self.tree, least) {
            for place in places {
                let (squared, other) = self.faces[place].away(point);
                if squared < least || squared == least && place < found {
                    (least, away, found) = (squared, other, place);
                }
            }
        }
        (least, away, found)
    }

    #[inline(always)]
    fn nearest_block(&self, points: &PointBlock) -> NearestFaces {
        self.nearest_block_within(points, &[f32::INFINITY; LANES])
    }

    /// The nearest triangles of points for each of which one is nearer than a squared distance.
    #[inline(always)]
    fn nearest_block_within(&self, points: &PointBlock, within: &[f32; LANES]) -> NearestFaces {
        let mut nearest = NearestFaces::within(within);
        let mut walk = Walk::to_block(points);
        while let Some(places) = walk.next_of_block(&self.tree, points, &nearest.squared) {
            for place in places {
                nearest.take(&self.faces[place], place as i32, points);
            }
        }
        nearest
    }

    /// The direction out of the shell, on the side where the point is. On a triangle both its sides are as near.
    #[inline(always)]
    fn outward(&self, away: Vec3, found: usize) -> [f32; 3] {
        let across = self.faces[found].normal;
        let across = if across == Vec3::ZERO { Vec3::Y } else { across };
        length_and_direction(away.into(), across.into()).1
    }
}

impl SignedDistance for Shell {
    fn sample(&self, point: Vec3) -> SdfSample {
        let (squared, away, found) = self.nearest(point);
        SdfSample {
            distance: squared.sqrt() - self.radius,
            normal: self.outward(away, found).into(),
        }
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        shell_block(self, points, out);
    }

    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        shell_distance_block(self, points, out);
    }

    fn nearest_on_segments(&self, segments: &SegmentBlock, out: &mut NearestBlock) {
        nearest_to_shell(self, segments, out);
    }

    fn bounds(&self) -> Option<Aabb3d> {
        Some(self.bounds)
    }

    fn known(&self) -> Option<KnownShape<'_>> {
        Some(KnownShape::Shell(self))
    }

    /// Zero. Where triangles meet, the nearest way out of one may lead into another, and what goes further
    /// than the radius may come out on the other side.
    fn core_depth(&self) -> f32 {
        0.0
    }

    /// The radius: borders and ridges are as round as that.
    fn least_radius(&self) -> f32 {
        self.radius
    }
}

/// Samples of a shell, inlined where it is called.
#[inline(always)]
pub fn shell_block(shell: &Shell, points: &PointBlock, out: &mut SampleBlock) {
    let NearestFaces { squared, away, face } = shell.nearest_block(points);
    for lane in 0..LANES {
        let normal = shell.outward(away.point(lane), face[lane] as usize);
        out.set(lane, squared[lane].sqrt() - shell.radius, normal);
    }
}

/// Distances alone \[m\] of a shell, inlined where it is called.
#[inline(always)]
pub fn shell_distance_block(shell: &Shell, points: &PointBlock, out: &mut [f32; LANES]) {
    let NearestFaces { squared, .. } = shell.nearest_block(points);
    for lane in 0..LANES {
        out[lane] = squared[lane].sqrt() - shell.radius;
    }
}

/// Places of segments that are nearest to a shell, inlined where it is called. Each place that is looked at tells how near the surface is to the
/// next one at most.
#[inline(always)]
pub fn nearest_to_shell(shell: &Shell, segments: &SegmentBlock, out: &mut NearestBlock) {
    let mut last = PointBlock::default();
    let mut away = [f32::INFINITY; LANES];
    segments::search(
        segments,
        out,
        #[inline(always)]
        |points, distances| {
            let mut within = [0.0; LANES];
            for lane in 0..LANES {
                let way = points.point(lane) - last.point(lane);
                let most = (away[lane] + way.dot(way).sqrt()) * ROUNDED_UP;
                within[lane] = most * most + f32::MIN_POSITIVE;
            }
            let NearestFaces { squared, .. } = shell.nearest_block_within(points, &within);
            for lane in 0..LANES {
                away[lane] = squared[lane].sqrt();
                distances[lane] = away[lane] - shell.radius;
            }
            last = *points;
        },
    );
}

/// Without the triangles, which are many.
impl fmt::Debug for Shell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Shell")
            .field("triangles", &self.faces.len())
            .field("radius", &self.radius)
            .field("bounds", &self.bounds)
            .finish_non_exhaustive()
    }
}

fn bounds_of(corners: &[Vec3; 3]) -> Bounds {
    let [a, b, c] = *corners;
    Bounds { low: a.min(b).min(c).to_array(), high: a.max(b).max(c).to_array() }
}
