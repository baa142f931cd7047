//! How a solid lies at places that it may press on: 16 at a time.

use bevy_math::Vec3;

use crate::sdf::{PointBlock, SampleBlock};
use crate::solver::contact::collider::Motion;
use crate::solver::contact::edges::place::Place;
use crate::solver::contact::edges::{HELD, WarmStart};
use crate::solver::contact::mobility::Mobility;
use crate::solver::contact::{ContactSettings, LEAST_SLIDING};
use crate::solver::simd::block::{Block, Block3, larger, smaller};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

/// An end goes at most this many times as far as the place of its edge that is moved.
const MOST_SHARE: f32 = 2.0;

/// A place that is looked at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    pub place: Place,
    /// What was expected there, by its place in the list.
    pub warm: Option<u32>,
    /// Whether it was found to be inside.
    pub is_found: bool,
}

impl Look {
    /// At where something was expected that is not inside any more.
    pub fn expected((at, warm): (u32, &WarmStart)) -> Self {
        Self { place: Place::of(warm), warm: Some(at), is_found: false }
    }
}

/// Looks at up to [`LANES`] places.
pub(super) struct LookAt<'a> {
    pub looks: &'a [Look],
    pub motion: &'a Motion<'a>,
    /// What the collider moves by, where it is a body.
    pub mobility: Option<&'a Mobility>,
    pub settings: &'a ContactSettings,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub d: &'a Soa,
    /// Outward normals at particles that are near, by slot.
    pub normals: &'a Soa,
}

/// What is seen of places, before anything is moved: see [`Press`](crate::solver::contact::edges::contact_point::Press).
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Inverse masses of the places \[1/kg\]: zero where all corners are held.
    pub inverse_mass: Block,
    pub mass: Block,
    pub shares: [Block; 3],
    pub arm: Block3,
    pub normal: Block3,
    pub planned: Block3,
    pub from: Block3,
    pub depth: Block,
    pub least: Block,
    pub most: Block,
    /// Distances of the first two corners \[m\].
    pub length: Block,
    /// Least cosines between a corner's normal and the place's.
    pub faces: Block,
}

/// A corner of each place.
#[derive(Clone, Copy)]
struct Corner {
    /// Its part in the place.
    part: Block,
    inverse_mass: Block,
    x: Block3,
    d: Block3,
    /// Outward normals there.
    normal: Block3,
}

impl LookAt<'_> {
    /// Gathers the corners, and where places are on edges.
    #[inline(always)]
    fn corners(&self) -> ([Corner; 3], Block) {
        let (mut is_on_edge, mut all_are) = (Block::ZERO, true);
        for (lane, is_on_edge) in is_on_edge.0.iter_mut().enumerate() {
            let is_edge = self.place(lane).is_on_edge();
            *is_on_edge = if is_edge { 1.0 } else { 0.0 };
            all_are &= is_edge;
        }
        let (first, second) = (self.corner(0), self.corner(1));
        // The last corner of an edge is its first.
        let third = if all_are { Corner { part: Block::ZERO, ..first } } else { self.corner(2) };
        ([first, second, third], is_on_edge)
    }

    /// The place of a lane. Lanes without one take the last one's.
    #[inline(always)]
    fn place(&self, lane: usize) -> &Place {
        &self.looks[lane.min(self.looks.len() - 1)].place
    }

    #[inline(always)]
    fn corner(&self, which: usize) -> Corner {
        let (mut part, mut inverse_mass) = (Block::ZERO, Block::ZERO);
        let (mut x, mut d, mut normal) = (Block3::ZERO, Block3::ZERO, Block3::ZERO);
        for lane in 0..LANES {
            let place = self.place(lane);
            let slot = place.corners[which] as usize;
            part.0[lane] = place.parts[which];
            inverse_mass.0[lane] = self.inverse_mass[slot];
            x.set(lane, self.x.get(slot));
            d.set(lane, self.d.get(slot));
            normal.set(lane, self.normals.get(slot));
        }
        Corner { part, inverse_mass, x, d, normal }
    }

    /// Finds the normals across edges and faces that are on the side of the outward ones, and the distances of the first two corners. At
    /// the nearest place the outward normal is across it, but for an end, where the way out is across it too. What a search is off
    /// by would drive it along.
    #[inline(always)]
    fn look_across(
        [one, two, three]: &[Corner; 3],
        is_on_edge: &Block,
        outward: &Block3,
    ) -> (Block3, Block) {
        let (mut normals, mut lengths) = (Block3::ZERO, Block::ZERO);
        for i in 0..LANES {
            let (a, b) = (one.x.at(i) + one.d.at(i), two.x.at(i) + two.d.at(i));
            let c = three.x.at(i) + three.d.at(i);
            let (along, outward) = (b - a, outward.at(i));
            let squared = along.dot(along);
            let beside = outward - along * (outward.dot(along) / larger(squared, LEAST_SLIDING));
            let across = along.cross(c - a);
            let across = across * outward.dot(across);
            let across = pick(is_on_edge.0[i] > 0.0, beside, across);
            normals.set(i, normalized_or(across, outward));
            lengths.0[i] = squared.sqrt();
        }
        (normals, lengths)
    }
}

impl Kernel for LookAt<'_> {
    type Output = Seen;

    #[inline(always)]
    fn run(self) -> Seen {
        let (corners, is_on_edge) = self.corners();
        let [one, two, three] = &corners;
        let (motion, settings) = (self.motion, self.settings);
        let mut points = PointBlock::default();
        let (mut start, mut moved, mut from) = (Block3::ZERO, Block3::ZERO, Block3::ZERO);
        for i in 0..LANES {
            let (p, q, r) = (one.part.0[i], two.part.0[i], three.part.0[i]);
            start.set(i, one.x.at(i) * p + two.x.at(i) * q + three.x.at(i) * r);
            moved.set(i, one.d.at(i) * p + two.d.at(i) * q + three.d.at(i) * r);
            from.set(i, start.at(i) + moved.at(i));
            points.set(i, motion.after.to_local(from.at(i)));
        }
        let mut samples = SampleBlock::default();
        motion.sample_block(&points, &mut samples);
        let (mut outward, mut depth) = (Block3::ZERO, Block::ZERO);
        let (mut arm, mut planned) = (Block3::ZERO, Block3::ZERO);
        for i in 0..LANES {
            let normal = Vec3::new(samples.nx[i], samples.ny[i], samples.nz[i]);
            outward.set(i, motion.after.rotate(normal));
            depth.0[i] = HELD * settings.epsilon - samples.distance[i] * motion.after.scale;
            arm.set(i, start.at(i) - motion.centre[0]);
        }
        if motion.moves {
            for i in 0..LANES {
                planned.set(i, from.at(i) - motion.before.to_world(points.point(i)));
            }
        }
        let (normal, length) = Self::look_across(&corners, &is_on_edge, &outward);
        let mut yields = Block::ZERO;
        if let Some(body) = self.mobility {
            for i in 0..LANES {
                yields.0[i] = body.along(arm.at(i), normal.at(i));
            }
        }
        let (mut inverse_mass, mut mass, mut faces) = (Block::ZERO, Block::ZERO, Block::ZERO);
        let (mut least, mut most) = (Block::ZERO, Block::ZERO);
        let mut shares = [Block::ZERO; 3];
        for i in 0..LANES {
            let (p, q, r) = (one.part.0[i], two.part.0[i], three.part.0[i]);
            let (u, v, w) = (one.inverse_mass.0[i], two.inverse_mass.0[i], three.inverse_mass.0[i]);
            let free = p * p * u + q * q * v + r * r * w;
            inverse_mass.0[i] = free;
            // A body yields to a push as well as the place does.
            let mobility = free + yields.0[i];
            let (p, q, r) = (p * u / mobility, q * v / mobility, r * w / mobility);
            // Next to an end that is held, the other would be thrown about.
            let share = larger(larger(larger(0.0, p), q), r);
            let is_held = share > MOST_SHARE;
            let part = if is_held { MOST_SHARE / share } else { 1.0 };
            shares[0].0[i] = p * part;
            shares[1].0[i] = q * part;
            shares[2].0[i] = r * part;
            mass.0[i] = part / mobility;
            let goes = (moved.at(i) - planned.at(i)).dot(normal.at(i));
            least.0[i] = -larger(-depth.0[i] - goes, 0.0);
            // A push that moves the place by less is not to be made up for.
            most.0[i] = if is_held { larger(least.0[i] - goes, 0.0) } else { f32::INFINITY };
        }
        for i in 0..LANES {
            let normal = normal.at(i);
            let (p, q) = (one.normal.at(i).dot(normal), two.normal.at(i).dot(normal));
            faces.0[i] = smaller(smaller(p, q), three.normal.at(i).dot(normal));
        }
        Seen {
            inverse_mass,
            mass,
            shares,
            arm,
            normal,
            planned,
            from,
            depth,
            least,
            most,
            length,
            faces,
        }
    }
}

/// One vector or the other, number by number: so it is done in lanes.
#[inline(always)]
fn pick(first: bool, a: Vec3, b: Vec3) -> Vec3 {
    let pick = |a: f32, b: f32| if first { a } else { b };
    Vec3::new(pick(a.x, b.x), pick(a.y, b.y), pick(a.z, b.z))
}

/// A vector at length one, or another where it has no direction.
#[inline(always)]
fn normalized_or(v: Vec3, other: Vec3) -> Vec3 {
    let recip = 1.0 / v.dot(v).sqrt();
    pick(recip < 1.0 / LEAST_SLIDING, v * recip, other)
}
