//! Contact of cloths that are stepped together, couple by couple.
//!
//! Nothing of it outlives a tick but what each cloth keeps (`others`), so that cloths may come together and part between any two ticks.

use bevy_math::Vec3;

use crate::solver::cloth_contact::MARGIN;
use crate::solver::cloth_contact::find::{Company, FindPairs, Pair};
use crate::solver::cloth_contact::grid::Grid;
use crate::solver::cloth_contact::others::OthersContact;
use crate::solver::cloth_contact::respond::{Lying, Respond, Side, Two};
use crate::solver::cloth_contact::tangles::Tangles;
use crate::solver::cloth_contact::travel::{AddUp, Extent, Travelled, allowed};
use crate::solver::simd::block::smaller;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::{Array, Soa};

/// No couple, in the table of couples.
const NONE: u32 = u32::MAX;
/// The owner of a place that holds no particle.
const NOBODY: u32 = u32::MAX;

/// A cloth, as contact with others takes it in a substep.
pub(in crate::solver) struct Parts<'a> {
    pub isa: Isa,
    /// Whether it takes the tick. What does not is as hard to move as a wall.
    pub moves: bool,
    /// Where its coordinates begin \[m\].
    pub origin: Vec3,
    pub inverse_mass: &'a [f32],
    pub x: &'a mut Soa,
    pub d: &'a mut Soa,
    /// Where its particles lie on colliders, if any do.
    pub lying: Option<Lying<'a>>,
    /// How far a pair is moved apart in the substep at most, without speed \[m\].
    pub most_push: f32,
    pub others: &'a mut OthersContact,
}

impl<'a> Parts<'a> {
    /// As one that does not move, by displacements and inverse masses of zero.
    fn stand(&mut self, (d, inverse_mass): &'a mut (Soa, Array)) {
        (self.d, self.inverse_mass, self.lying) = (d, inverse_mass, None);
    }

    fn side(&mut self) -> Side<'_> {
        let OthersContact { normals, tangles, .. } = &*self.others;
        Side {
            normals,
            inverse_mass: self.inverse_mass,
            x: self.x,
            d: self.d,
            lying: self.lying.as_mut().map(Lying::reborrow),
            is_down: tangles.any.then_some(&tangles.is_down),
        }
    }

    /// Where its particles are at the substep's end, and which of them stand down.
    fn places(self) -> (Places<'a>, &'a mut Tangles) {
        let Self { x, d, moves, others, .. } = self;
        (Places { x, d: moves.then_some(d) }, &mut others.tangles)
    }
}

/// Where particles of a cloth are at a substep's end, in its own coordinates.
#[derive(Clone, Copy)]
struct Places<'a> {
    x: &'a Soa,
    /// Displacements, where it moves \[m\].
    d: Option<&'a Soa>,
}

impl Places<'_> {
    fn at(&self, slot: u32) -> Vec3 {
        let slot = slot as usize;
        self.x.get(slot) + self.d.map_or(Vec3::ZERO, |d| d.get(slot))
    }
}

/// What is stepped together with others.
pub(in crate::solver) trait Body {
    /// Its parts, where it collides with other cloths.
    fn parts(&mut self) -> Option<Parts<'_>>;
}

/// Two cloths that may touch.
#[derive(Debug, Default)]
struct Couple {
    /// Which they are, the first one first.
    of: [usize; 2],
    friction: f32,
    pairs: Vec<Pair>,
    /// How far each region of the one may move relative to each of the other \[m\].
    allowed: Vec<f32>,
    travelled: f32,
    /// Whether any pair has touched in the tick.
    has_touched: bool,
    /// Pairs that touched in the last substep.
    touching: u32,
}

/// The couples of some cloths, and the pairs of their particles that may touch.
#[derive(Debug, Default)]
pub(in crate::solver) struct Couples {
    couples: Vec<Couple>,
    /// How many of them there are in this tick; the rest is room.
    count: usize,
    /// The couple of two cloths, by both.
    table: Vec<u32>,
    /// The first slot of each cloth in `at`, then their end; one without contact has none.
    first: Vec<u32>,
    /// Positions of all particles when pairs were found, relative to the first cloth's origin \[m\].
    at: Soa,
    radius: Array,
    base: Vec3,
    /// Gap up to which pairs are kept, and distance at which particles may be one \[m\].
    margin: f32,
    reach: f32,
    is_found: bool,
    /// Boxes of all regions, and the first of each cloth, then their end.
    boxes: Vec<Extent>,
    first_box: Vec<usize>,
    /// Slots in `at` of particles that are near another cloth.
    near: Vec<u32>,
    grid: Grid,
    /// The cloth of the particle at each place of the grid.
    owner: Vec<u32>,
    /// Displacements and inverse masses of what does not move.
    still: (Soa, Array),
}

impl Couples {
    /// Begins a tick of some cloths.
    pub fn begin_tick(&mut self, bodies: &mut [impl Body]) {
        let members = bodies.len();
        (self.count, self.is_found) = (0, false);
        self.table.clear();
        self.table.resize(members * members, NONE);
        self.first.clear();
        let (mut slots, mut longest, mut widest) = (0, 0, 0.0_f32);
        for body in bodies.iter_mut() {
            self.first.push(slots);
            if let Some(parts) = body.parts() {
                let len = parts.inverse_mass.len();
                (slots, longest) = (slots + len as u32, longest.max(len));
                widest = widest.max(parts.others.widest());
            }
        }
        self.first.push(slots);
        (self.margin, self.reach) = (widest * MARGIN, widest * (1.0 + MARGIN));
        for b in 0..members {
            for a in 0..b {
                if let Ok([one, other]) = bodies.get_disjoint_mut([a, b])
                    && let (Some(one), Some(other)) = (one.parts(), other.parts())
                    && (one.moves || other.moves)
                    && one.others.settings.layers & other.others.settings.layers != 0
                {
                    let [mu, nu] = [one.others.settings.friction, other.others.settings.friction];
                    self.add_couple([a, b], (mu * nu).sqrt(), members);
                }
            }
        }
        if self.count > 0 {
            self.make_room(slots as usize, longest);
            for (body, &first) in bodies.iter_mut().zip(&self.first) {
                if let Some(parts) = body.parts() {
                    let radius = &parts.others.balls.radius;
                    self.radius[first as usize..][..radius.len()].copy_from_slice(radius);
                }
            }
        }
    }

    fn add_couple(&mut self, of: [usize; 2], friction: f32, members: usize) {
        if self.count == self.couples.len() {
            self.couples.push(Couple::default());
        }
        let couple = &mut self.couples[self.count];
        couple.pairs.clear();
        (couple.of, couple.friction) = (of, friction);
        (couple.has_touched, couple.touching) = (false, 0);
        let [a, b] = of;
        self.table[a * members + b] = self.count as u32;
        self.table[b * members + a] = self.count as u32;
        self.count += 1;
    }

    fn make_room(&mut self, slots: usize, longest: usize) {
        if self.radius.len() < slots {
            (self.at, self.radius) = (Soa::zeros(slots), Array::zeros(slots));
        }
        if self.still.1.len() < longest {
            self.still = (Soa::zeros(longest), Array::zeros(longest));
        }
    }

    /// The couples that have touched in the tick.
    pub fn touched(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.couples[..self.count].iter().filter(|couple| couple.has_touched).map(|couple| couple.of)
    }

    /// Pairs of a cloth that touched in the last substep.
    pub fn touching(&self, member: usize) -> u32 {
        let couples = self.couples[..self.count].iter();
        couples.filter(|couple| couple.of.contains(&member)).map(|couple| couple.touching).sum()
    }

    /// Moves apart what touches.
    pub fn meet(&mut self, bodies: &mut [impl Body]) {
        if self.count == 0 {
            return;
        }
        if !self.is_found || self.measure(bodies) {
            self.find(bodies);
        }
        self.search_tangles(bodies);
        for couple in &mut self.couples[..self.count] {
            if !couple.pairs.is_empty() {
                couple.meet(bodies, &mut self.still);
            }
        }
    }

    /// Measures how far particles have moved since pairs were found. Tells whether some may touch that are no pair.
    fn measure(&mut self, bodies: &mut [impl Body]) -> bool {
        self.boxes.clear();
        for (body, &first) in bodies.iter_mut().zip(&self.first) {
            let Some(parts) = body.parts() else { continue };
            let (regions, shift) = (&mut parts.others.regions, parts.origin - self.base);
            if parts.moves {
                regions.measure(parts.isa, parts.x, parts.d, &self.at, first as usize);
                self.boxes.extend(regions.extents.iter().map(|moved| moved.shifted(shift)));
            } else {
                self.boxes.extend(regions.extents.iter().map(|_| Extent::ZERO));
            }
        }
        let mut is_too_far = false;
        for couple in &mut self.couples[..self.count] {
            let [some, others] =
                couple.of.map(|of| &self.boxes[self.first_box[of]..self.first_box[of + 1]]);
            let mut travelled = Travelled::NOTHING;
            let mut allowed = couple.allowed.iter();
            for a in some {
                for (b, &allowed) in others.iter().zip(&mut allowed) {
                    travelled.add(a.difference(b), allowed, self.margin);
                }
            }
            couple.travelled = travelled.most.sqrt();
            is_too_far |= travelled.is_too_far;
        }
        is_too_far
    }

    /// Finds the pairs of particles, where they are now.
    fn find(&mut self, bodies: &mut [impl Body]) {
        self.take_places(bodies);
        self.take_near(bodies);
        let Self { grid, near, at, radius, owner, first, .. } = self;
        grid.make_room(near.len());
        grid.begin(self.reach);
        grid.take(at, near.iter().map(|&slot| slot as usize));
        // All of them choose the same instructions, but for a game that wants to compare.
        let isa = bodies.iter_mut().find_map(|body| Some(body.parts()?.isa));
        let isa = isa.unwrap_or_else(Isa::detect);
        grid.sort(isa, at, radius);
        owner.clear();
        let of = |&slot: &u32| first.partition_point(|&first| first <= slot) as u32 - 1;
        owner.extend(grid.slots.iter().map(of));
        owner.resize(owner.len() + LANES, NOBODY);
        let couples = &mut self.couples[..self.count];
        for couple in couples.iter_mut() {
            couple.pairs.clear();
            couple.travelled = 0.0;
        }
        let company = ManyCloths { owner, first, table: &self.table, couples };
        isa.run(FindPairs { grid, margin: self.margin, company });
        self.find_normals(bodies);
        self.is_found = true;
        FINDS.fetch_add(1, core::sync::atomic::Ordering::Relaxed); NEAR.fetch_add(self.near.len() as u64, core::sync::atomic::Ordering::Relaxed); PAIRS.fetch_add(self.couples[..self.count].iter().map(|c| c.pairs.len() as u64).sum(), core::sync::atomic::Ordering::Relaxed);
    }

    /// Notes where all particles are, and the boxes of their regions.
    fn take_places(&mut self, bodies: &mut [impl Body]) {
        self.base = bodies.iter_mut().find_map(|body| Some(body.parts()?.origin)).unwrap_or_default();
        self.boxes.clear();
        self.first_box.clear();
        for (body, &first) in bodies.iter_mut().zip(&self.first) {
            self.first_box.push(self.boxes.len());
            let Some(parts) = body.parts() else { continue };
            let d = if parts.moves { &*parts.d } else { &self.still.0 };
            let (shift, first) = (parts.origin - self.base, first as usize);
            parts.isa.run(AddUp { x: parts.x, d, shift, to: &mut self.at, first });
            let regions = &mut parts.others.regions;
            regions.look(parts.isa, &self.at, first);
            self.boxes.extend(&regions.extents);
        }
        self.first_box.push(self.boxes.len());
        let (margin, reach) = (self.margin, self.reach);
        for couple in &mut self.couples[..self.count] {
            let [some, others] =
                couple.of.map(|of| &self.boxes[self.first_box[of]..self.first_box[of + 1]]);
            couple.allowed.clear();
            for a in some {
                couple.allowed.extend(others.iter().map(|b| allowed(a, b, margin, reach)));
            }
        }
    }

    /// Lists the particles that are where another cloth may be.
    fn take_near(&mut self, bodies: &mut [impl Body]) {
        self.near.clear();
        let members = bodies.len();
        for (member, body) in bodies.iter_mut().enumerate() {
            let Some(parts) = body.parts() else { continue };
            let (boxes, first) = (self.first_box[member], self.first[member]);
            for region in 0..self.first_box[member + 1] - boxes {
                let own = self.boxes[boxes + region];
                let mut around = Extent::NOTHING;
                for other in 0..members {
                    if self.table[member * members + other] != NONE {
                        let theirs = &self.boxes[self.first_box[other]..self.first_box[other + 1]];
                        let near = theirs.iter().filter(|other| own.gap(other) < self.reach);
                        around = near.fold(around, |around, other| around.with(other));
                    }
                }
                let around = around.grown(self.reach);
                let slots = parts.others.regions.slots(region).map(|slot| first + slot as u32);
                self.near.extend(slots.filter(|&slot| around.contains(self.at.get(slot as usize))));
            }
        }
    }

    /// Works out the surface's normals at the particles of pairs.
    fn find_normals(&mut self, bodies: &mut [impl Body]) {
        for (member, (body, &first)) in bodies.iter_mut().zip(&self.first).enumerate() {
            let Some(parts) = body.parts() else { continue };
            let OthersContact { normals, tangles, .. } = parts.others;
            normals.forget();
            for couple in &self.couples[..self.count] {
                if let Some(side) = couple.of.iter().position(|&of| of == member) {
                    let slots = couple.pairs.iter().map(|pair| pair.slots[side]);
                    let at = |slot: u32| self.at.get((first + slot) as usize);
                    normals.find(slots, &tangles.faces, at);
                }
            }
        }
    }

    /// Looks which particles are tangled with another cloth, where it is time.
    fn search_tangles(&mut self, bodies: &mut [impl Body]) {
        let mut parts = bodies.iter_mut().filter_map(|body| body.parts());
        if !parts.any(|parts| parts.moves && parts.others.tangles.is_due()) {
            return;
        }
        for body in &mut *bodies {
            if let Some(parts) = body.parts() {
                parts.others.tangles.begin_search();
            }
        }
        for couple in &self.couples[..self.count] {
            couple.search_tangles(bodies);
        }
    }
}

impl Couple {
    /// Moves apart what touches.
    fn meet(&mut self, bodies: &mut [impl Body], still: &mut (Soa, Array)) {
        let Ok([one, other]) = bodies.get_disjoint_mut(self.of) else { return };
        let (Some(mut one), Some(mut other)) = (one.parts(), other.parts()) else { return };
        let shift = one.origin - other.origin;
        let most_push = smaller(one.most_push, other.most_push);
        // One of the two moves.
        if !one.moves {
            one.stand(still);
        } else if !other.moves {
            other.stand(still);
        }
        let respond = Respond {
            pairs: &self.pairs,
            sides: Two { first: one.side(), second: other.side(), shift },
            travelled: self.travelled,
            friction: self.friction,
            most_push,
        };
        let touched = respond.run();
        self.touching = touched.count;
        TOUCH.fetch_add(touched.count as u64, core::sync::atomic::Ordering::Relaxed); AWAKE.fetch_add(self.pairs.iter().filter(|p| p.gap<self.travelled.max(f32::MIN_POSITIVE)).count() as u64, core::sync::atomic::Ordering::Relaxed);
        if touched.count > 0 {
            self.has_touched = true;
            for others in [one.others, other.others] {
                others.since_touch = 0;
                others.tangles.is_suspected |= touched.is_deep;
            }
        }
    }

    fn search_tangles(&self, bodies: &mut [impl Body]) {
        let Ok([one, other]) = bodies.get_disjoint_mut(self.of) else { return };
        let (Some(one), Some(other)) = (one.parts(), other.parts()) else { return };
        let shift = one.origin - other.origin;
        let (here, tangles) = one.places();
        let (there, theirs) = other.places();
        tangles.search_with(theirs, &self.pairs, |slot| here.at(slot) + shift, |slot| there.at(slot));
    }
}

/// The particles of several cloths. Those of one cloth are no pair.
struct ManyCloths<'a> {
    owner: &'a [u32],
    first: &'a [u32],
    table: &'a [u32],
    couples: &'a mut [Couple],
}

impl ManyCloths<'_> {
    #[inline(always)]
    fn couple(&self, a: u32, b: u32) -> u32 {
        self.table[a as usize * (self.first.len() - 1) + b as usize]
    }
}

impl Company for ManyCloths<'_> {
    #[inline(always)]
    fn among(&self, mut lanes: u32, at: usize, place: usize) -> u32 {
        let own = self.owner[place];
        let mut meets = 0;
        while lanes != 0 {
            let lane = lanes.trailing_zeros();
            lanes &= lanes - 1;
            let other = self.owner[at + lane as usize];
            if other != own && self.couple(own, other) != NONE {
                meets |= 1 << lane;
            }
        }
        meets
    }

    #[inline(always)]
    fn take(&mut self, places: [usize; 2], pair: Pair) {
        let [a, b] = places.map(|place| self.owner[place]);
        let couple = self.couple(a, b) as usize;
        let [mut first, mut second] =
            [(a, pair.slots[0]), (b, pair.slots[1])].map(|(of, slot)| slot - self.first[of as usize]);
        if a > b {
            (first, second) = (second, first);
        }
        self.couples[couple].pairs.push(Pair { slots: [first, second], ..pair });
    }
}

pub static FINDS: core::sync::atomic::AtomicU64 = core::sync::atomic::AtomicU64::new(0);
pub static NEAR: core::sync::atomic::AtomicU64 = core::sync::atomic::AtomicU64::new(0);
pub static PAIRS: core::sync::atomic::AtomicU64 = core::sync::atomic::AtomicU64::new(0);
pub static TOUCH: core::sync::atomic::AtomicU64 = core::sync::atomic::AtomicU64::new(0);
pub static AWAKE: core::sync::atomic::AtomicU64 = core::sync::atomic::AtomicU64::new(0);
