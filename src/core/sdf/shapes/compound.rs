//! Several solids as one.

use super::larger;
use crate::sdf::{LANES, PointBlock, SampleBlock, SdfSample, SignedDistance};
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
/// A part whose box is further from a point than a part found already is passed over. The boxes are looked
/// at one after the other, which is quick for some dozens of parts.
#[derive(Clone, Debug)]
pub struct Compound {
    parts: Box<[Placed]>,
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
        Ok(Self {
            bounds: boxes.and_then(|boxes| boxes.into_iter().reduce(union)),
            least_radius: solids().map(|s| s.least_radius()).fold(f32::INFINITY, f32::min),
            overestimate: solids().map(|s| s.overestimate()).fold(0.0, f32::max),
            parts,
        })
    }

    /// Number of parts, at least one.
    pub fn part_count(&self) -> usize {
        self.parts.len()
    }

    /// The parts in turn that may be nearest to a point: the one with the nearest box, which mostly is, then
    /// the others in their order unless they are known to be further.
    fn nearest<T>(
        &self,
        point: Vec3,
        measure: impl Fn(&Placed, Vec3) -> (f32, T),
    ) -> (f32, T, &Placed) {
        let (mut first, mut lowest) = (0, self.parts[0].gap(point));
        for (index, part) in self.parts.iter().enumerate().skip(1) {
            let gap = part.gap(point);
            if gap < lowest {
                (first, lowest) = (index, gap);
            }
        }
        let mut nearest = &self.parts[first];
        let (mut least, mut found) = measure(nearest, nearest.local(point));
        for (index, part) in self.parts.iter().enumerate() {
            if index == first || part.gap(point) >= least {
                continue;
            }
            let (distance, other) = measure(part, part.local(point));
            if distance < least {
                (least, found, nearest) = (distance, other, part);
            }
        }
        (least, found, nearest)
    }

    /// [`nearest`](Self::nearest) for a block: each lane takes from the same parts in the same order, and so
    /// has the same bits. `measure` samples a part and is told which lanes have to take it, and which may if
    /// it is nearer; it keeps the least distances.
    fn nearest_block(
        &self,
        points: &PointBlock,
        least: &mut [f32; LANES],
        mut measure: impl FnMut(&Placed, &PointBlock, Lanes, &mut [f32; LANES]),
    ) {
        let mut first = [0; LANES];
        let mut lowest = self.parts[0].gaps(points);
        for (index, part) in self.parts.iter().enumerate().skip(1) {
            let gaps = part.gaps(points);
            for lane in 0..LANES {
                if gaps[lane] < lowest[lane] {
                    (first[lane], lowest[lane]) = (index, gaps[lane]);
                }
            }
        }
        for (index, part) in self.parts.iter().enumerate() {
            let takes = first.map(|first| first == index);
            if takes.contains(&true) {
                measure(part, &part.local_block(points), Lanes::Take(takes), least);
            }
        }
        for (index, part) in self.parts.iter().enumerate() {
            let gaps = part.gaps(points);
            let mut may = [false; LANES];
            for lane in 0..LANES {
                let is_further = gaps[lane] >= least[lane];
                may[lane] = first[lane] != index && !is_further;
            }
            if may.contains(&true) {
                measure(part, &part.local_block(points), Lanes::TakeIfNearer(may), least);
            }
        }
    }
}

/// Which lanes of a block take what a part says.
#[derive(Clone, Copy)]
enum Lanes {
    Take([bool; LANES]),
    TakeIfNearer([bool; LANES]),
}

impl Lanes {
    /// Whether a lane takes this distance.
    #[inline(always)]
    fn takes(&self, lane: usize, distance: f32, least: f32) -> bool {
        match self {
            Self::Take(lanes) => lanes[lane],
            Self::TakeIfNearer(lanes) => lanes[lane] && distance < least,
        }
    }
}

impl SignedDistance for Compound {
    fn sample(&self, point: Vec3) -> SdfSample {
        let (distance, normal, part) = self.nearest(point, |part, local| {
            let SdfSample { distance, normal } = part.solid.sample(local);
            (distance, normal)
        });
        SdfSample { distance, normal: part.outward(normal.to_array()).into() }
    }

    fn distance(&self, point: Vec3) -> f32 {
        self.nearest(point, |part, local| (part.solid.distance(local), ())).0
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        let mut sampled = SampleBlock::default();
        let mut least = [0.0; LANES];
        self.nearest_block(points, &mut least, |part, local, lanes, least| {
            part.solid.sample_block(local, &mut sampled);
            for (lane, least) in least.iter_mut().enumerate() {
                let distance = sampled.distance[lane];
                if lanes.takes(lane, distance, *least) {
                    *least = distance;
                    let normal = [sampled.nx[lane], sampled.ny[lane], sampled.nz[lane]];
                    out.set(lane, distance, part.outward(normal));
                }
            }
        });
    }

    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        let mut sampled = [0.0; LANES];
        self.nearest_block(points, out, |part, local, lanes, least| {
            part.solid.distance_block(local, &mut sampled);
            for (lane, least) in least.iter_mut().enumerate() {
                if lanes.takes(lane, sampled[lane], *least) {
                    *least = sampled[lane];
                }
            }
        });
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
    /// The same with room for rounding, or all of space.
    low: [f32; 3],
    high: [f32; 3],
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
        let (mut low, mut high) = (Vec3A::NEG_INFINITY, Vec3A::INFINITY);
        if let Some(Aabb3d { min, max }) = bounds {
            // A few roundings of the largest number on the way.
            let room = 1e-6 * (min.abs().max(max.abs()).max_element() + translation.length());
            (low, high) = (min - room, max + room);
        }
        Ok(Self {
            solid,
            translation: translation.to_array(),
            axes: turn.to_cols_array_2d(),
            bounds,
            low: low.to_array(),
            high: high.to_array(),
        })
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

    /// What the distance to the part is at least: that to its box, and of a point in the box nothing is known.
    #[inline(always)]
    fn gap_at(&self, point: [f32; 3]) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| {
            larger(larger(self.low[axis] - point[axis], point[axis] - self.high[axis]), 0.0)
        });
        let gap = (x * x + y * y + z * z).sqrt();
        if gap == 0.0 { f32::NEG_INFINITY } else { gap }
    }

    fn gap(&self, point: Vec3) -> f32 {
        self.gap_at(point.to_array())
    }

    fn gaps(&self, points: &PointBlock) -> [f32; LANES] {
        let mut gaps = [0.0; LANES];
        for (lane, gap) in gaps.iter_mut().enumerate() {
            *gap = self.gap_at([points.x[lane], points.y[lane], points.z[lane]]);
        }
        gaps
    }
}
