//! An edge or a face that a collider presses on.

use bevy_math::{Vec3, Vec3A};

use crate::solver::contact::edges::body::Body;
use crate::solver::contact::edges::look::{Look, LookAt, Seen};
use crate::solver::contact::edges::place::Place;
use crate::solver::contact::edges::{HoldEdges, WarmStart};
use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::mobility::Twist;
use crate::solver::simd::block::larger;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::lanes::LANES;

/// Cosine between the normal of an end and the way in, from which on it lies beyond the solid.
const BEYOND: f32 = 0.25;
/// Places that are looked at on a way of an end that is pushed by what is fast.
const LOOKS: u32 = 8;

/// An edge or a face that a collider presses on. Ways are those of its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Press {
    pub place: Place,
    /// The corners' places among the bodies.
    pub bodies: [u32; 3],
    /// How far the corners go for a push of one.
    shares: [f32; 3],
    /// Impulse for a push of one \[kg\].
    pub mass: f32,
    /// How far the place is from the collider's centre, as the substep begins \[m\].
    pub arm: Vec3,
    /// Outward, of length one.
    pub normal: Vec3A,
    /// How far the collider was planned to move there in the substep \[m\].
    planned: Vec3A,
    /// How far it moves there, with what it has yielded up to now \[m\].
    surface: Vec3A,
    /// Where the place is, before anything is moved \[m\].
    from: Vec3A,
    /// How far it is to come out from there \[m\].
    pub depth: f32,
    /// Least way that it may go along the normal, beside the collider: what is left of the gap \[m\].
    pub least: f32,
    /// Longest push along the normal \[m\].
    pub most: f32,
    /// The push along the normal, up to now \[m\].
    pub push: f32,
    /// The push of friction, up to now \[m\].
    pub brake: Vec3A,
    /// The push that it began with \[m\].
    began: Vec3A,
    /// Whether it was expected.
    pub was_expected: bool,
}

impl Press {
    /// What [`visit_corners`](Self::visit_corners) visits, one after the other: slower, where it is not spread out.
    #[inline(always)]
    pub fn corners(&self) -> impl Iterator<Item = (usize, f32, f32)> {
        let count = self.place.corners().len();
        (0..3).take(count).map(|i| (self.bodies[i] as usize, self.place.parts[i], self.shares[i]))
    }

    /// Visits the corners: their places among the bodies, their parts, and how far they go for a push of one.
    #[inline(always)]
    pub fn visit_corners(&self, mut visit: impl FnMut(usize, f32, f32)) {
        let [a, b, c] = self.bodies.map(|body| body as usize);
        visit(a, self.place.parts[0], self.shares[0]);
        visit(b, self.place.parts[1], self.shares[1]);
        if !self.place.is_on_edge() {
            visit(c, self.place.parts[2], self.shares[2]);
        }
    }

    /// Notes how far the collider has yielded in the substep.
    #[inline(always)]
    pub fn follow(&mut self, yielded: &Twist) {
        self.surface = self.planned + Vec3A::from(yielded.at(self.arm));
    }

    /// How far the place goes in the substep, beside the collider \[m\].
    #[inline(always)]
    pub fn goes(&self, bodies: &[Body]) -> Vec3A {
        let mut goes = -self.surface;
        self.visit_corners(
            #[inline(always)]
            |body, part, _| goes += bodies[body].d * part,
        );
        goes
    }

    /// How far it is still inside \[m\].
    #[inline(always)]
    pub fn depth(&self, bodies: &[Body]) -> f32 {
        let mut goes = self.planned - self.surface - self.from;
        self.visit_corners(
            #[inline(always)]
            |body, part, _| goes += bodies[body].at() * part,
        );
        self.depth - goes.dot(self.normal)
    }

    /// The impulse that it has given the collider about its centre, times the substep.
    pub fn given(&self) -> Impulse {
        let by = self.began - self.normal * self.push - self.brake;
        Impulse::at(self.arm, (by * self.mass).into())
    }

    /// Begins with the push that was expected, which the displacements have been given.
    fn begin_with(mut self, warm: &WarmStart) -> Self {
        let push = Vec3A::from(warm.impulse / self.mass);
        self.push = push.dot(self.normal);
        self.brake = push - self.normal * self.push;
        self.began = push;
        self.was_expected = true;
        self
    }
}

impl HoldEdges<'_> {
    /// Finds what the collider presses on, or was expected to, in the order of their corners.
    pub(super) fn find_pressed(&mut self, isa: Isa, presses: &mut Vec<Press>) {
        presses.clear();
        let mut looks = core::mem::take(&mut self.nearby.looks);
        self.nearby.places.sort_unstable_by_key(|place| place.corners);
        self.list_looks(&mut looks);
        for looks in looks.chunks(LANES) {
            let seen = self.look_at(isa, looks);
            for (lane, look) in looks.iter().enumerate() {
                let warm = look.warm.map(|at| self.set.edges.warm[at as usize]);
                let press = self.press(look, &seen, lane);
                presses.extend(match (press, warm) {
                    (Some(press), Some(warm)) => Some(press.begin_with(&warm)),
                    (None, Some(warm)) if look.is_found => self.take_back(isa, &warm),
                    (press, _) => press,
                });
            }
        }
        looks.clear();
        self.nearby.places.clear();
        self.nearby.looks = looks;
    }

    /// Lists the places that were found, and those where something was expected of the collider, in the order of their corners.
    fn list_looks(&self, looks: &mut Vec<Look>) {
        let warm = &self.set.edges.warm;
        let first = warm.partition_point(|warm| (warm.collider as usize) < self.collider);
        let mine = |(_, warm): &(u32, &WarmStart)| warm.collider as usize == self.collider;
        let mut expected = (first as u32..).zip(&warm[first..]).take_while(mine).peekable();
        for &place in &self.nearby.places {
            // Those that have left it since.
            while let Some(left) = expected.next_if(|(_, warm)| warm.corners < place.corners) {
                looks.push(Look::expected(left));
            }
            let warm = expected.next_if(|(_, warm)| warm.corners == place.corners);
            looks.push(Look { place, warm: warm.map(|(at, _)| at), is_found: true });
        }
        looks.extend(expected.map(Look::expected));
    }

    fn look_at(&self, isa: Isa, looks: &[Look]) -> Seen {
        isa.run(LookAt {
            looks,
            motion: self.motion,
            mobility: self.mobility.as_ref(),
            settings: self.settings,
            inverse_mass: self.inverse_mass,
            x: self.x,
            d: self.d,
            normals: &self.nearby.normal,
        })
    }

    /// Takes back the push that was expected at a place that is not pressed any more, as far as it is too much.
    fn take_back(&mut self, isa: Isa, warm: &WarmStart) -> Option<Press> {
        let look = Look::expected((0, warm));
        let seen = self.look_at(isa, &[look]);
        Some(self.press(&look, &seen, 0)?.begin_with(warm))
    }

    /// What presses on a place that has been looked at; `None` where it is not to be moved. It is inside, unless it was expected to be.
    fn press(&mut self, look: &Look, seen: &Seen, lane: usize) -> Option<Press> {
        let Look { place, is_found, .. } = *look;
        let depth = seen.depth.0[lane];
        let is_held = seen.inverse_mass.0[lane] <= 0.0;
        if is_held || depth.is_nan() || (depth <= 0.0 && is_found) {
            return None;
        }
        let memory = &self.set.edges;
        let passes = place.corners.iter().any(|&slot| memory.is_freed(slot, self.collider));
        // An end beyond the solid would be moved into it.
        let is_beyond = seen.faces.0[lane] < -BEYOND;
        let length = seen.length.0[lane];
        let is_hooked =
            place.edge.is_some_and(|edge| self.is_hooked(edge, depth, length, is_beyond));
        if is_hooked || passes || is_beyond {
            return None;
        }
        let planned = Vec3A::from(seen.planned.at(lane));
        Some(Press {
            place,
            bodies: [0; 3],
            shares: [0, 1, 2].map(|corner: usize| seen.shares[corner].0[lane]),
            mass: seen.mass.0[lane],
            arm: seen.arm.at(lane),
            normal: seen.normal.at(lane).into(),
            planned,
            surface: planned,
            from: seen.from.at(lane).into(),
            depth,
            least: seen.least.0[lane],
            most: seen.most.0[lane],
            push: 0.0,
            brake: Vec3A::ZERO,
            began: Vec3A::ZERO,
            was_expected: false,
        })
    }

    /// Whether what is fast would push a corner through itself, on a way that nothing looks at any more: by `push`, and out as far as
    /// it is then inside.
    pub(super) fn goes_through(&self, press: &Press, push: Vec3A, bodies: &[Body]) -> bool {
        let motion = self.motion;
        // As far as where the collider is looked at, which has not yielded.
        let yielded = (press.surface - press.planned).dot(press.normal);
        let left = press.depth(bodies) - yielded - push.dot(press.normal);
        let push = push + press.normal * larger(left, 0.0);
        press.corners().any(|(body, _, share)| {
            let (from, way) = (bodies[body].x, bodies[body].d + push * share);
            let (from, to) =
                (motion.before.to_local(from.into()), motion.after.to_local((from + way).into()));
            let looks = (1..=LOOKS).map(|i| from.lerp(to, i as f32 / LOOKS as f32));
            looks.fold(f32::INFINITY, |least, at| least.min(motion.shape.distance(at))) < 0.0
        })
    }
}
