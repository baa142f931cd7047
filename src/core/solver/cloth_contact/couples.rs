//! Contact of cloths that are stepped together, couple by couple.
//!
//! Nothing of it outlives a tick but what each cloth keeps (`others`, `history`), so that cloths may come together and part between any
//! two ticks.

use bevy_math::Vec3;

use crate::solver::cloth_contact::MARGIN;
use crate::solver::cloth_contact::couple::{Couple, Found};
use crate::solver::cloth_contact::find::FindPairs;
use crate::solver::cloth_contact::grid::Grid;
use crate::solver::cloth_contact::many::{ManyCloths, NONE};
use crate::solver::cloth_contact::parts::Body;
use crate::solver::cloth_contact::regions::{AddUp, Extent, Since};
use crate::solver::cloth_contact::respond::Touched;
use crate::solver::cloth_contact::travel::{Moved, Travelled};
use crate::solver::simd::block::{larger, smaller};
use crate::solver::simd::isa::Isa;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::{Array, Soa};

/// The owner of a place that holds no particle.
const NOBODY: u32 = u32::MAX;

/// Least gap up to which pairs are kept, in diameters of the largest ball.
const LEAST_MARGIN: f32 = 0.15;
/// How much further particles may move in a tick than their speeds let expect.
const SLACK: f32 = 1.5;

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
    /// The same in the last substep.
    last: Soa,
    radius: Array,
    base: Vec3,
    /// Largest distance at which two particles touch \[m\].
    widest: f32,
    /// Gap up to which pairs are kept \[m\].
    margin: f32,
    is_found: bool,
    /// Boxes of all regions, of their motion, and the first of each cloth, then their end.
    boxes: Vec<Extent>,
    moved: Vec<Extent>,
    first_box: Vec<usize>,
    /// Slots in `at` of particles that are near another cloth.
    near: Vec<u32>,
    grid: Grid,
    /// The instructions of the first cloth; all of them choose the same, but where a game compares.
    isa: Option<Isa>,
    /// The cloth of the particle at each place of the grid.
    owner: Vec<u32>,
    /// Displacements of what does not move.
    still: Soa,
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
                if slots == len as u32 {
                    (self.isa, self.base) = (Some(parts.isa), parts.origin);
                }
            }
        }
        self.first.push(slots);
        self.widest = widest;
        for b in 0..members {
            for a in 0..b {
                if let Ok([one, other]) = bodies.get_disjoint_mut([a, b])
                    && let (Some(one), Some(other)) = (one.parts(), other.parts())
                    && (one.moves || other.moves)
                    && one.others.settings.layers & other.others.settings.layers != 0
                {
                    let [mu, nu] = [one.others.settings.friction, other.others.settings.friction];
                    let couple = self.add_couple([a, b], (mu * nu).sqrt(), members);
                    couple.recall([one.others, other.others], one.inverse_mass.len());
                }
            }
        }
        // Halves that are left of those that move are of cloths that they have parted from.
        for parts in bodies.iter_mut().filter_map(Body::parts).filter(|parts| parts.moves) {
            parts.others.histories.clear();
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

    fn add_couple(&mut self, of: [usize; 2], friction: f32, members: usize) -> &mut Couple {
        if self.count == self.couples.len() {
            self.couples.push(Couple::default());
        }
        let place = self.count;
        let couple = &mut self.couples[place];
        couple.pairs.clear();
        (couple.of, couple.friction) = (of, friction);
        (couple.has_touched, couple.touched) = (false, Touched::default());
        let [a, b] = of;
        self.table[a * members + b] = place as u32;
        self.table[b * members + a] = place as u32;
        self.count += 1;
        &mut self.couples[place]
    }

    fn make_room(&mut self, slots: usize, longest: usize) {
        if self.radius.len() < slots {
            (self.at, self.last) = (Soa::zeros(slots), Soa::zeros(slots));
            self.radius = Array::zeros(slots);
        }
        if self.still.x.len() < longest {
            self.still = Soa::zeros(longest);
        }
    }

    /// The couples that have touched in the tick.
    pub fn touched(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.couples[..self.count]
            .iter()
            .filter(|couple| couple.has_touched)
            .map(|couple| couple.of)
    }

    /// Pairs of a cloth that touched in the last substep.
    pub fn touching(&self, member: usize) -> u32 {
        let couples = self.couples[..self.count].iter();
        couples
            .filter(|couple| couple.of.contains(&member))
            .map(|couple| couple.touched.count)
            .sum()
    }

    /// Moves apart what touches, in a substep after which the tick has so many `left`.
    pub fn meet(&mut self, bodies: &mut [impl Body], left: u32) {
        if self.count == 0 {
            return;
        }
        if !self.is_found || self.measure(bodies) {
            self.find(bodies, left);
        }
        if self.couples[..self.count].iter().all(|couple| couple.pairs.is_empty()) {
            return;
        }
        self.search_tangles(bodies);
        take_in(bodies);
        let found = Found { at: &self.at, first: &self.first };
        let couples = &mut self.couples[..self.count];
        for couple in couples.iter_mut().filter(|couple| !couple.pairs.is_empty()) {
            couple.look(bodies);
        }
        for couple in couples.iter_mut().filter(|couple| !couple.pairs.is_empty()) {
            couple.meet(bodies, found);
        }
        if couples.iter().any(|couple| couple.touched.count > 0) {
            put_back(bodies);
        }
    }

    /// Keeps apart what the strain limits have pulled together, after it met in the same substep.
    pub fn keep_apart(&mut self, bodies: &mut [impl Body]) {
        let couples = &mut self.couples[..self.count];
        if !couples.iter().any(Couple::is_pressed) {
            return;
        }
        take_in(bodies);
        let found = Found { at: &self.at, first: &self.first };
        for couple in couples.iter_mut().filter(|couple| couple.is_pressed()) {
            couple.keep_apart(bodies, found);
        }
        put_back(bodies);
    }

    /// Ends a tick: cloths keep what touches.
    pub fn end_tick(&mut self, bodies: &mut [impl Body]) {
        // Where no pairs have been looked for, batches are of another tick.
        let count = if self.is_found { self.count } else { 0 };
        for couple in &mut self.couples[..count] {
            couple.remember(bodies);
        }
    }

    fn isa(&self) -> Isa {
        self.isa.unwrap_or(Isa::Baseline)
    }

    /// Measures how far particles have moved since pairs were found. Tells whether some may touch that are no pair.
    fn measure(&mut self, bodies: &mut [impl Body]) -> bool {
        self.boxes.clear();
        self.moved.clear();
        for (body, &first) in bodies.iter_mut().zip(&self.first) {
            let Some(parts) = body.parts() else { continue };
            let (regions, shift) = (&mut parts.others.regions, parts.origin - self.base);
            if parts.moves {
                let (from, last) = (&self.at, Some(&mut self.last));
                let since = Since { from, last, first: first as usize };
                regions.measure(parts.isa, (parts.x, parts.d, shift), since);
                self.boxes.extend(&regions.extents);
                self.moved.extend(&regions.steps);
            } else {
                let none = regions.extents.iter().map(|_| Extent::ZERO);
                self.boxes.extend(none.clone());
                self.moved.extend(none);
            }
        }
        let mut is_too_far = false;
        for couple in &mut self.couples[..self.count] {
            let moved = couple.of.map(|of| {
                let regions = self.first_box[of]..self.first_box[of + 1];
                Moved { all: &self.boxes[regions.clone()], step: &self.moved[regions] }
            });
            couple.travelled = couple.allowance.measure(moved);
            is_too_far |= couple.travelled.is_too_far;
        }
        is_too_far
    }

    /// Finds the pairs of particles, where they are now.
    fn find(&mut self, bodies: &mut [impl Body], left: u32) {
        self.take_places(bodies);
        self.choose_margin(left as f32 + 1.0);
        self.take_near(bodies);
        let isa = self.isa();
        let Self { grid, near, at, radius, owner, first, .. } = self;
        grid.make_room(near.len());
        grid.begin(self.widest + self.margin);
        grid.take(at, near.iter().map(|&slot| slot as usize));
        grid.sort(isa, at, radius);
        owner.clear();
        let of = |&slot: &u32| first.partition_point(|&first| first <= slot) as u32 - 1;
        owner.extend(grid.slots.iter().map(of));
        owner.resize(owner.len() + LANES, NOBODY);
        let couples = &mut self.couples[..self.count];
        for couple in couples.iter_mut() {
            if self.is_found {
                let [one, next] = [0, 1].map(|side| first[couple.of[0] + side] as usize);
                couple.batches.keep_anchors(next - one);
            }
            couple.pairs.clear();
            couple.travelled = Travelled::NOTHING;
            // What has no pairs is not met, and touches nothing.
            couple.touched = Touched::default();
        }
        let members = first.len() - 1;
        let some_do_not_meet = couples.len() < members * (members - 1) / 2;
        let company = ManyCloths { owner, first, table: &self.table, couples, some_do_not_meet };
        isa.run(FindPairs { grid, margin: self.margin, company });
        for body in bodies.iter_mut() {
            if let Some(parts) = body.parts() {
                parts.others.beads.forget_pairs();
            }
        }
        for couple in &mut self.couples[..self.count] {
            let slots = couple.of.map(|of| (self.first[of + 1] - self.first[of]) as usize);
            couple.begin(bodies, self.margin, slots);
        }
        self.is_found = true;
    }

    /// Notes where all particles are, and the boxes of their regions.
    fn take_places(&mut self, bodies: &mut [impl Body]) {
        self.boxes.clear();
        self.moved.clear();
        self.first_box.clear();
        for (body, &first) in bodies.iter_mut().zip(&self.first) {
            self.first_box.push(self.boxes.len());
            let Some(parts) = body.parts() else { continue };
            let d = if parts.moves { &*parts.d } else { &self.still };
            let (shift, first) = (parts.origin - self.base, first as usize);
            parts.isa.run(AddUp { x: parts.x, d, shift, to: &mut self.at, first });
            let regions = &mut parts.others.regions;
            regions.look(parts.isa, d, 0);
            self.moved.extend(&regions.extents);
            regions.look(parts.isa, &self.at, first);
            self.boxes.extend(&regions.extents);
        }
        self.first_box.push(self.boxes.len());
        self.last.copy_from(&self.at);
    }

    /// Chooses a margin by how far particles are to move in some substeps, and how far they may move before pairs are found anew.
    fn choose_margin(&mut self, substeps: f32) {
        let (mut fastest, most) = (0.0, self.widest * MARGIN);
        for couple in &self.couples[..self.count] {
            let [some, others] = couple.of.map(|of| self.first_box[of]..self.first_box[of + 1]);
            for a in some {
                for b in others.clone() {
                    if self.boxes[a].gap(&self.boxes[b]) < self.widest + most {
                        fastest = larger(self.moved[a].difference(&self.moved[b]), fastest);
                    }
                }
            }
        }
        let expected = fastest.sqrt() * substeps * SLACK;
        self.margin = smaller(larger(expected, self.widest * LEAST_MARGIN), most);
        let (margin, reach) = (self.margin, self.widest + self.margin);
        for couple in &mut self.couples[..self.count] {
            let regions =
                couple.of.map(|of| &self.boxes[self.first_box[of]..self.first_box[of + 1]]);
            couple.allowance.begin(regions, margin, reach);
        }
    }

    /// Lists the particles that are where another cloth may be.
    fn take_near(&mut self, bodies: &mut [impl Body]) {
        self.near.clear();
        let reach = self.widest + self.margin;
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
                        let near = theirs.iter().filter(|other| own.gap(other) < reach);
                        around = near.fold(around, Extent::with);
                    }
                }
                let around = around.grown(reach);
                let slots = parts.others.regions.slots(region).map(|slot| first + slot as u32);
                self.near.extend(slots.filter(|&slot| around.contains(self.at.get(slot as usize))));
            }
        }
    }

    /// Looks which particles are tangled with another cloth, where it is time.
    fn search_tangles(&mut self, bodies: &mut [impl Body]) {
        let mut parts = bodies.iter_mut().filter_map(Body::parts);
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

/// Takes in the particles of all cloths that are in pairs.
fn take_in(bodies: &mut [impl Body]) {
    bodies.iter_mut().filter_map(Body::parts).for_each(|mut parts| parts.take_in());
}

/// Puts back where they have come to.
fn put_back(bodies: &mut [impl Body]) {
    bodies.iter_mut().filter_map(Body::parts).for_each(|mut parts| parts.put_back());
}
