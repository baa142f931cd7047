//! Several solids as one.

use super::tree::{Bounds, BoxTree, Walk};
use super::{larger, smaller};
use crate::sdf::{
    LANES, NearestBlock, PointBlock, SampleBlock, SdfSample, SegmentBlock, SignedDistance,
};
use bevy_math::{Mat3, Quat, Vec3, Vec3A, bounding::Aabb3d};
use std::sync::Arc;

/// A solid of a [`Compound`], and where it is.
#[derive(Clone, Debug)]
pub struct Part {
    /// The solid, in its own frame.
    pub solid: Arc<dyn SignedDistance>,
    /// Where its origin is in the compound's frame \[m\].
    pub translation: Vec3,
    /// How it is turned about its origin. Of unit length.
    pub rotation: Quat,
}

impl Part {
    /// A solid at a place. One that is in an `Arc` already goes into the fields as it is.
    pub fn new(solid: impl SignedDistance, translation: Vec3, rotation: Quat) -> Self {
        Self { solid: Arc::new(solid), translation, rotation }
    }
}

/// Why parts make no [`Compound`].
#[derive(thiserror::Error, Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CompoundError {
    /// There is nothing to be near to.
    #[error("a compound needs at least one part")]
    NoParts,
    /// A part is nowhere.
    #[error(
        "part {part} of a compound is at {translation}: give it a translation of finite numbers, within 1e7 m"
    )]
    Translation {
        /// Which one, from zero.
        part: usize,
        /// Where it was put \[m\].
        translation: Vec3,
    },
    /// A part is turned by what is no rotation.
    #[error(
        "part {part} of a compound is turned by a quaternion of length {length}: normalise it, its length has to be 1"
    )]
    Rotation {
        /// Which one, from zero.
        part: usize,
        /// Length of the quaternion.
        length: f32,
    },
}

/// Several solids as one, each at a place of its own.
///
/// The distance is the least of the parts', and the normal that of the nearest part. Outside, that is as
/// exact as the parts are. Inside, it is exact where parts do not meet; where they overlap or touch, the
/// surface of each goes on inside the others, and a point is taken for less deep than it is, never for
/// deeper.
///
/// A part whose box is further from a point than a part found already is passed over, through a tree of boxes: of thousands of
/// parts, a point looks at a few.
#[derive(Clone, Debug)]
pub struct Compound {
    /// In the order of the tree's leaves.
    parts: Box<[Placed]>,
    tree: BoxTree,
    bounds: Option<Aabb3d>,
    least_radius: f32,
    overestimate: f32,
}

impl Compound {
    /// Puts parts together.
    ///
    /// # Errors
    ///
    /// If there are none, or one has a translation or a rotation that is none.
    pub fn new(parts: impl IntoIterator<Item = Part>) -> Result<Self, CompoundError> {
        let placed = |(index, part)| Placed::new(index, part);
        let parts: Box<[Placed]> =
            parts.into_iter().enumerate().map(placed).collect::<Result<_, _>>()?;
        if parts.is_empty() {
            return Err(CompoundError::NoParts);
        }
        let union = |a: Aabb3d, b: Aabb3d| Aabb3d { min: a.min.min(b.min), max: a.max.max(b.max) };
        let boxes = parts.iter().map(|part| part.bounds).collect::<Option<Vec<_>>>();
        let solids = || parts.iter().map(|part| &part.solid);
        let roomy: Vec<Bounds> = parts.iter().map(Placed::roomy_bounds).collect();
        let (tree, order) = BoxTree::new(&roomy, 1);
        Ok(Self {
            tree,
            bounds: boxes.and_then(|boxes| boxes.into_iter().reduce(union)),
            least_radius: solids().map(|s| s.least_radius()).fold(f32::INFINITY, f32::min),
            overestimate: solids().map(|s| s.overestimate()).fold(0.0, f32::max),
            parts: order.iter().map(|&part| parts[part as usize].clone()).collect(),
        })
    }

    /// Number of parts, at least one.
    pub fn part_count(&self) -> usize {
        self.parts.len()
    }

    /// The nearest part, and what is measured of it. Of parts that tie, the first.
    fn nearest<T: Default>(
        &self,
        point: Vec3,
        measure: impl Fn(&Placed, Vec3) -> (f32, T),
    ) -> (f32, T, usize) {
        let (mut least, mut found, mut nearest) = (f32::INFINITY, T::default(), 0);
        let mut walk = Walk::to_point(point.to_array());
        while let Some(places) = walk.next(&self.tree, limit_of(least)) {
            for index in places {
                let part = &self.parts[index];
                let (distance, other) = measure(part, part.local(point));
                if distance < least || distance == least && index < nearest {
                    (least, found, nearest) = (distance, other, index);
                }
            }
        }
        (least, found, nearest)
    }

    /// [`nearest`](Self::nearest) for a block: to anything within `reach` of each point \[m\]. `measure` samples a part, and is told what is
    /// known: it takes what is nearer.
    fn nearest_block(
        &self,
        points: &PointBlock,
        reach: &[f32; LANES],
        mut measure: impl FnMut(&Placed, &mut Known),
    ) -> Known {
        let mut known = Known { index: 0, least: [f32::INFINITY; LANES], nearest: [0; LANES] };
        let mut walk = Walk::to_block(points);
        let mut limits = [f32::INFINITY; LANES];
        while let Some(places) = walk.next_of_block(&self.tree, points, &limits) {
            for index in places {
                known.index = index as u32;
                measure(&self.parts[index], &mut known);
                for (limit, (least, reach)) in limits.iter_mut().zip(known.least.iter().zip(reach))
                {
                    *limit = limit_of(least + reach);
                }
            }
        }
        known
    }
}

/// Square of how far away a part's box may be where another part is this near \[m2\]: what is in a part is in its box.
#[inline(always)]
fn limit_of(least: f32) -> f32 {
    let least = larger(least, 0.0);
    least * least
}

/// The nearest parts of a block of points, as far as they are known.
struct Known {
    /// The part that is measured.
    index: u32,
    least: [f32; LANES],
    nearest: [u32; LANES],
}

impl Known {
    /// Takes a lane's distance, if it is nearer than what is known.
    #[inline(always)]
    fn take(&mut self, lane: usize, distance: f32) -> bool {
        let (least, nearest) = (self.least[lane], self.nearest[lane]);
        let takes = (distance < least) | ((distance == least) & (self.index < nearest));
        self.least[lane] = if takes { distance } else { least };
        self.nearest[lane] = if takes { self.index } else { nearest };
        takes
    }
}

impl SignedDistance for Compound {
    fn sample(&self, point: Vec3) -> SdfSample {
        let (distance, normal, nearest) = self.nearest(point, |part, local| {
            let SdfSample { distance, normal } = part.solid.sample(local);
            (distance, Some(normal))
        });
        // Only what is nowhere is near to nothing.
        let outward = |normal: Vec3| self.parts[nearest].outward(normal.to_array()).into();
        SdfSample { distance, normal: normal.map_or(Vec3::Y, outward) }
    }

    fn distance(&self, point: Vec3) -> f32 {
        self.nearest(point, |part, local| (part.solid.distance(local), ())).0
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        let mut sampled = SampleBlock::default();
        out.ny = [1.0; LANES];
        (out.nx, out.nz) = ([0.0; LANES], [0.0; LANES]);
        let known = self.nearest_block(points, &[0.0; LANES], |part, known| {
            part.solid.sample_block(&part.local_block(points), &mut sampled);
            for lane in 0..LANES {
                let distance = sampled.distance[lane];
                if known.take(lane, distance) {
                    let normal = [sampled.nx[lane], sampled.ny[lane], sampled.nz[lane]];
                    out.set(lane, distance, part.outward(normal));
                }
            }
        });
        out.distance = known.least;
    }

    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        let mut sampled = [0.0; LANES];
        let known = self.nearest_block(points, &[0.0; LANES], |part, known| {
            part.solid.distance_block(&part.local_block(points), &mut sampled);
            for (lane, distance) in sampled.into_iter().enumerate() {
                known.take(lane, distance);
            }
        });
        *out = known.least;
    }

    fn nearest_on_segments(&self, segments: &SegmentBlock, out: &mut NearestBlock) {
        let [middles, ends] = [0.5, 1.0].map(|part| segments.at(&[part; LANES]));
        let mut reach = [0.0; LANES];
        for (lane, reach) in reach.iter_mut().enumerate() {
            *reach = 0.5 * segments.way.point(lane).length();
        }
        (out.at, out.least) = ([0.0; LANES], [f32::INFINITY; LANES]);
        let mut found = NearestBlock::default();
        let known = self.nearest_block(&middles, &reach, |part, known| {
            let [from, to] = [&segments.from, &ends].map(|points| part.local_block(points));
            part.solid.nearest_on_segments(&SegmentBlock::between(&from, &to), &mut found);
            for lane in 0..LANES {
                out.least[lane] = smaller(out.least[lane], found.least[lane]);
                if known.take(lane, found.distance[lane]) {
                    out.at[lane] = found.at[lane];
                }
            }
        });
        out.distance = known.least;
    }

    /// A box around the parts' own boxes: a little more than the smallest where a part is turned.
    fn bounds(&self) -> Option<Aabb3d> {
        self.bounds
    }

    /// Zero. Next to where parts meet, the nearest way out of one leads into the other, however
    /// shallow the point is.
    fn core_depth(&self) -> f32 {
        0.0
    }

    /// The least of the parts': where their surfaces cross they make a hollow, which is not convex.
    fn least_radius(&self) -> f32 {
        self.least_radius
    }

    fn overestimate(&self) -> f32 {
        self.overestimate
    }
}

/// A part ready to be asked.
#[derive(Clone, Debug)]
struct Placed {
    solid: Arc<dyn SignedDistance>,
    translation: [f32; 3],
    /// The solid's axes in the compound's frame.
    axes: [[f32; 3]; 3],
    /// A box around it in the compound's frame.
    bounds: Option<Aabb3d>,
}

impl Placed {
    fn new(index: usize, part: Part) -> Result<Self, CompoundError> {
        let Part { solid, translation, rotation } = part;
        if !(translation.abs().max_element() <= 1e7 && translation.is_finite()) {
            return Err(CompoundError::Translation { part: index, translation });
        }
        let length = rotation.length();
        let is_unit = (length - 1.0).abs() < 1e-3;
        if !is_unit {
            return Err(CompoundError::Rotation { part: index, length });
        }
        let turn = Mat3::from_quat(rotation.normalize());
        let bounds = solid.bounds().map(|Aabb3d { min, max }| {
            let (centre, half) = (0.5 * (min + max), 0.5 * (max - min));
            let centre = Vec3A::from(turn * Vec3::from(centre) + translation);
            let half = Vec3A::from(turn.abs() * Vec3::from(half));
            Aabb3d { min: centre - half, max: centre + half }
        });
        Ok(Self {
            solid,
            translation: translation.to_array(),
            axes: turn.to_cols_array_2d(),
            bounds,
        })
    }

    /// Its box with room for a few roundings of the largest number on the way, or all of space.
    fn roomy_bounds(&self) -> Bounds {
        let Some(Aabb3d { min, max }) = self.bounds else {
            return Bounds { low: [f32::NEG_INFINITY; 3], high: [f32::INFINITY; 3] };
        };
        let largest = min.abs().max(max.abs()).max_element();
        let room = 1e-6 * (largest + Vec3::from(self.translation).length());
        Bounds { low: (min - room).to_array(), high: (max + room).to_array() }
    }

    /// A point in the solid's own frame. Written out, so that nothing is fused.
    #[inline(always)]
    fn to_local(&self, point: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = [0, 1, 2].map(|axis| point[axis] - self.translation[axis]);
        self.axes.map(|axis| axis[0] * x + axis[1] * y + axis[2] * z)
    }

    fn local(&self, point: Vec3) -> Vec3 {
        self.to_local(point.to_array()).into()
    }

    fn local_block(&self, points: &PointBlock) -> PointBlock {
        let mut local = PointBlock::default();
        for lane in 0..LANES {
            let [x, y, z] = self.to_local([points.x[lane], points.y[lane], points.z[lane]]);
            (local.x[lane], local.y[lane], local.z[lane]) = (x, y, z);
        }
        local
    }

    /// A direction of the solid's own frame in the compound's.
    #[inline(always)]
    fn outward(&self, normal: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = &self.axes;
        [0, 1, 2].map(|i| x[i] * normal[0] + y[i] * normal[1] + z[i] * normal[2])
    }
}
