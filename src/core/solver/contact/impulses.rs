//! Momentum that the cloth gives to the colliders that are measured, and where it has moved those of them that are bodies.
//!
//! The pulls of a cloth sum up to none, and so does what is carried on of them (`integrate::houbolt`). Where a collider bears
//! a pull that is not noted, what is carried on of the opposite pulls has no counterpart: a part of it moves the cloth in the
//! next substep, less in the one after. The collider gives that momentum, or takes it, for as long as pulls are
//! carried on.

use bevy_math::{Mat3, Vec3};

use crate::solver::contact::account::Account;
use crate::solver::contact::collider::Collider;
use crate::solver::contact::coupling::Coupling;
use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::mobility::{Deviation, Mobility, Twist};
use crate::solver::simd::block::larger;

/// The impulses of a tick.
#[derive(Clone, Debug, Default)]
pub(crate) struct Impulses {
    /// By collider; `None` where it is not measured. Empty where none is.
    colliders: Vec<Option<Account>>,
    /// By collider, the first one of its body, which has the account of all of them. Empty where each is a body by itself.
    first: Vec<usize>,
    /// Room to find them in: colliders by their bodies.
    by_body: Vec<(u64, usize)>,
    /// Colliders in whose accounts anything is, or comes to be. There may be many more that are far away.
    live: Vec<usize>,
    /// Length of the tick \[s\].
    dt: f32,
    /// Where cloth and bodies are to keep their angular momentum: the velocity that bodies fall by in a tick, as their engine has it
    /// \[m/s\]. `None` where pins hold the cloth, and take of it what they like; what made up for the rest would be a spin from nothing.
    pub falls: Option<Vec3>,
}

/// A body that the cloth carries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CarriedBody {
    pub collider: usize,
    /// Its mass \[kg\].
    pub mass: f64,
}

/// Momentum that a collider is given at a place in a substep, times the substep \[kg m\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Share {
    pub collider: usize,
    /// In the cloth's coordinates \[m\].
    pub at: Vec3,
    pub given: Vec3,
    pub owed: Vec3,
}

impl Impulses {
    /// Puts what is known of colliders at their new `place`s, of which there are so many; `None` is none.
    pub fn renumber(&mut self, count: usize, place: impl Fn(usize) -> Option<usize>) {
        if self.colliders.is_empty() {
            return;
        }
        let mut colliders = vec![None; count.max(self.colliders.len())];
        for (collider, account) in self.colliders.iter().enumerate() {
            if let Some(to) = place(collider).and_then(|place| colliders.get_mut(place)) {
                *to = *account;
            }
        }
        self.colliders = colliders;
    }

    /// Begins a tick with these colliders, which are those of the last one as far as they are at the same places.
    /// The cloth passes through a body of less than `least` \[kg\]. The tick takes `dt` \[s\].
    pub fn begin_tick(&mut self, colliders: &[Collider<'_>], origin: Vec3, least: f32, dt: f32) {
        let is_asked = |collider: &Collider<'_>| collider.measured || collider.mobility.is_some();
        let is_light = |mobility: &Mobility| mobility.inverse_mass * least > 1.0;
        let count = if colliders.iter().any(is_asked) { colliders.len() } else { 0 };
        self.colliders.resize(count, None);
        self.join_bodies(colliders);
        self.dt = dt;
        self.live.clear();
        self.live.reserve(count);
        for (place, collider) in colliders.iter().enumerate().take(count) {
            let account = &mut self.colliders[place];
            let before = account.take();
            let live = before.is_none_or(|account| !account.rests());
            let owed = before.map_or(Impulse::ZERO, |account| account.owed);
            let mut coupling = before.map_or(Coupling::NONE, |account| account.coupling);
            match collider.mobility {
                None => coupling = Coupling::NONE,
                Some(Mobility { informed: false, .. }) => coupling.expected = Impulse::ZERO,
                Some(_) => (),
            }
            if !is_asked(collider) {
                continue;
            }
            if live {
                self.live.push(place);
            }
            let ways = [0.0, 1.0].map(|part| collider.centre_at(part) - origin);
            let mobility = collider.mobility;
            let known = Account::owing(owed, coupling);
            let passed = mobility.as_ref().is_some_and(is_light);
            let known = Account { passed, ..known };
            let account = account.insert(Account { about: ways[0], ways, mobility, ..known });
            if live {
                account.come_alive(dt);
            }
        }
    }

    /// Finds which colliders are of one body.
    fn join_bodies(&mut self, colliders: &[Collider<'_>]) {
        let Self { first, by_body, .. } = self;
        first.clear();
        by_body.clear();
        let bodies = colliders.iter().map(|collider| collider.body);
        by_body.extend(bodies.zip(0..).filter(|&(body, _)| body != 0));
        by_body.sort_unstable();
        if by_body.len() < 2 {
            return;
        }
        first.extend(0..colliders.len());
        for pair in 1..by_body.len() {
            let ((before, at), (body, collider)) = (by_body[pair - 1], by_body[pair]);
            if body == before {
                first[collider] = first[at];
            }
        }
    }

    /// The collider that has the account of a body; `None` where it has none.
    pub fn of_body(&self, body: u64) -> Option<usize> {
        let at = self.by_body.partition_point(|&(known, _)| known < body);
        let &(known, collider) = self.by_body.get(at)?;
        (known == body && self.account(collider).is_some()).then_some(collider)
    }

    /// The collider that has a collider's account.
    fn first(&self, collider: usize) -> usize {
        self.first.get(collider).copied().unwrap_or(collider)
    }

    /// Moves bodies as far as they go in a substep of length `step` that ends at part `to` of the tick.
    pub fn end_substep(&mut self, colliders: &[Collider<'_>], origin: Vec3, to: f32, step: f32) {
        for &place in &self.live {
            let Some(account) = &mut self.colliders[place] else { continue };
            let mut at = colliders[place].centre_at(to) - origin;
            if account.met && account.mobility.is_some() {
                account.deviation = account.deviation.after(&account.velocity(to), step);
                at += account.coupling.ahead_at(to).and(&account.deviation).shift;
            }
            account.go_to(at);
        }
    }

    /// Ends the tick.
    pub fn end_tick(&mut self) {
        for &place in &self.live {
            let Some(account) = &mut self.colliders[place] else { continue };
            account.drop_what_is_no_number();
            let Account { given, deviation, .. } = *account;
            let lacking = self.falls.map_or(Vec3::ZERO, |falls| account.lacking(falls));
            account.answer = match account.mobility {
                Some(Mobility { inverse_mass, .. }) => {
                    let coupling = &mut account.coupling;
                    let answer =
                        coupling.end_tick(given, &deviation, inverse_mass, account.is_sprung);
                    account.as_told(Impulse { angular: answer.angular + lacking, ..answer })
                }
                None => given,
            };
        }
    }

    /// Finds the bodies that the cloth is expected to change the speed of by more than `least` \[m/s\] in the direction `up` in a tick, as it
    /// did in the last one.
    pub fn carried(&self, up: Vec3, least: f32) -> impl Iterator<Item = CarriedBody> {
        self.bodies(move |account| account.is_carried(up, least))
    }

    /// Finds the bodies that the cloth has changed the speed of by more than `least` \[m/s\] in the direction `up` in this tick.
    pub fn pushed(&self, up: Vec3, least: f32) -> impl Iterator<Item = CarriedBody> {
        self.bodies(move |account| account.is_pushed(up, least))
    }

    /// Bodies that the cloth may have come to, but those that it passes through, as far as their accounts are `asked` for.
    fn bodies(&self, asked: impl Fn(&Account) -> bool) -> impl Iterator<Item = CarriedBody> {
        self.live.iter().filter_map(move |&collider| {
            let account = self.colliders[collider].as_ref().filter(|account| !account.passed)?;
            let mass = 1.0 / f64::from(account.mobility?.inverse_mass);
            asked(account).then_some(CarriedBody { collider, mass })
        })
    }

    /// Whether the cloth has come near any body that it can move.
    pub fn meet_bodies(&self) -> bool {
        let is_body = |account: &Account| {
            let can_move = |mobility: Mobility| mobility.inverse_mass > 0.0;
            !account.rests() && account.mobility.is_some_and(can_move)
        };
        self.live.iter().any(|&place| self.colliders[place].as_ref().is_some_and(is_body))
    }

    /// Whether any collider is measured.
    pub fn are_measured(&self) -> bool {
        !self.colliders.is_empty()
    }

    /// Begins a substep that keeps a part of the pulls, of which a part moves the particles.
    pub fn carry_on(&mut self, keeps: f32, moves: f32) {
        for &place in &self.live {
            let Some(account) = &mut self.colliders[place] else { continue };
            account.owed = account.owed * keeps;
            account.given += account.owed * moves;
        }
    }

    /// Gives shares of a substep of length `step`.
    pub fn give(&mut self, shares: impl IntoIterator<Item = Share>, step: f32) {
        if !self.are_measured() {
            return;
        }
        for Share { collider, at, given, owed } in shares {
            let arm = at - self.about(collider);
            self.give_sum(collider, Impulse::at(arm, given), Impulse::at(arm, owed), step);
        }
    }

    /// The place of a collider that sums for it are about.
    #[inline(always)]
    pub fn about(&self, collider: usize) -> Vec3 {
        self.account(collider).map_or(Vec3::ZERO, |account| account.about)
    }

    /// Gives a collider what has been summed up about its place in a substep of length `step`, times the substep.
    pub fn give_sum(&mut self, collider: usize, given: Impulse, owed: Impulse, step: f32) {
        if let Some(account) = self.account_mut(collider) {
            account.given += given * (1.0 / step);
            account.owed += owed * (1.0 / step);
        }
    }

    /// Notes that the cloth may have come to a collider, in a substep that begins at part `from` of the tick.
    pub fn meet(&mut self, collider: usize, colliders: &[Collider<'_>], origin: Vec3, from: f32) {
        let first = self.first(collider);
        let Some(Some(account)) = self.colliders.get_mut(first) else { return };
        account.met = true;
        if !account.live {
            account.about = colliders[first].centre_at(from) - origin;
            account.come_alive(self.dt);
            self.live.push(first);
        }
    }

    /// Notes that a pin pulls at a body, by a spring or not.
    pub fn pin_to(&mut self, collider: usize, by_spring: bool) {
        if let Some(account) = self.account_mut(collider) {
            account.met = true;
            account.pins += 1;
            account.is_sprung |= by_spring;
        }
    }

    /// Lets the cloth pass through a body in this tick.
    pub fn pass(&mut self, collider: usize) {
        if let Some(account) = self.account_mut(collider) {
            account.passed = true;
        }
    }

    /// Whether the cloth passes through a collider.
    pub fn passes(&self, collider: usize) -> bool {
        self.account(collider).is_some_and(|account| account.passed)
    }

    /// How much a pin yields at a place, each of those that pull at the body with a part of its mass \[1/kg\]. One that does not
    /// move yields by `least`, so that what pulls at it is known.
    pub fn yielding(&self, collider: usize, at: Vec3, least: f32) -> f32 {
        let of = |account: &Account| {
            let Some(mobility) = account.mobility else { return 0.0 };
            account.pins as f32 * mobility.most_along(at - account.about)
        };
        self.account(collider).map_or(0.0, |account| larger(of(account), least))
    }

    /// Where a place of a body is at part `to` of the tick that is planned to be at `place` then, at the end of a substep of length
    /// `step` \[m\].
    pub fn led(&self, collider: usize, place: Vec3, to: f32, step: f32) -> Vec3 {
        self.expected_to_carry(collider, place, [to, to], step)
    }

    /// [`led`](Self::led) by what the cloth is expected to give the body in the substep, which begins at part `from`.
    pub fn expected_to_carry(
        &self,
        collider: usize,
        place: Vec3,
        [from, to]: [f32; 2],
        step: f32,
    ) -> Vec3 {
        let Some(account) = self.account(collider) else { return place };
        let centre = account.ways[0] + (account.ways[1] - account.ways[0]) * to;
        let moved = account.deviation.after(&account.velocity(from), step);
        account.coupling.ahead_at(to).and(&moved).apply_to(place, centre)
    }

    /// What moves a collider that is a body; `None` where it is none.
    pub fn mobility(&self, collider: usize) -> Option<Mobility> {
        self.account(collider)?.mobility
    }

    /// How far the cloth has moved a body from its planned way, up to now.
    pub fn deviation(&self, collider: usize) -> Deviation {
        self.account(collider).map_or(Deviation::NONE, |account| account.deviation)
    }

    /// How far it is from where its engine has it after a part of the tick, if the cloth has `moved` it so far.
    pub fn apart(&self, collider: usize, part: f32, moved: &Deviation) -> Deviation {
        self.account(collider)
            .map_or(Deviation::NONE, |account| account.coupling.ahead_at(part).and(moved))
    }

    /// Velocity that a body has beside the planned one, after a part of the tick.
    pub(super) fn velocity(&self, collider: usize, part: f32) -> Twist {
        self.account(collider).map_or(Twist::default(), |account| account.velocity(part))
    }

    fn account(&self, collider: usize) -> Option<&Account> {
        self.colliders.get(self.first(collider))?.as_ref()
    }

    #[inline(always)]
    fn account_mut(&mut self, collider: usize) -> Option<&mut Account> {
        let first = self.first(collider);
        let account = self.colliders.get_mut(first)?.as_mut()?;
        if !account.live {
            account.come_alive(self.dt);
            self.live.push(first);
        }
        Some(account)
    }

    /// Turns what is owed with the cloth.
    pub fn turn(&mut self, turn: Mat3) {
        for account in self.colliders.iter_mut().flatten() {
            account.owed = account.owed.turned(turn);
            account.coupling.expected = account.coupling.expected.turned(turn);
            account.told_part = account.told_part.map(|part| turn * part * turn.transpose());
            account.coupling.ahead.shift = turn * account.coupling.ahead.shift;
        }
    }

    /// What is owed and remembered, to be kept with the rest of the state.
    pub fn kept(&self) -> Vec<Option<(Impulse, Coupling)>> {
        let kept = |account: Account| (account.owed, account.coupling);
        self.colliders.iter().map(|account| account.map(kept)).collect()
    }

    /// Puts back what was kept.
    pub fn put_back(&mut self, kept: &[Option<(Impulse, Coupling)>]) {
        // The cloth may lie on any of them.
        let account = |(owed, coupling)| Account { met: true, ..Account::owing(owed, coupling) };
        self.colliders = kept.iter().map(|kept| kept.map(account)).collect();
    }

    pub fn clear(&mut self) {
        self.colliders.clear();
        self.live.clear();
    }

    /// What a collider was given in the tick, with the others of its body; none where it is not measured.
    pub fn of(&self, collider: usize) -> Impulse {
        self.account(collider).map_or(Impulse::ZERO, |account| account.given)
    }

    /// What a body was given in the tick. The first collider of the body has it, the others have none.
    pub fn of_whole(&self, collider: usize) -> Impulse {
        if self.first(collider) == collider { self.of(collider) } else { Impulse::ZERO }
    }

    /// [`of_whole`](Self::of_whole) as the engine of a body is to be given it.
    pub fn of_whole_as_told(&self, collider: usize) -> Impulse {
        let told = |account: &Account| account.as_told(self.of_whole(collider));
        self.account(collider).map_or(Impulse::ZERO, told)
    }

    /// What the engine of a body is to be given of the last tick. The first collider of the body has it, the others have none.
    pub fn answer(&self, collider: usize) -> Impulse {
        let account = self.account(collider).filter(|_| self.first(collider) == collider);
        account.map_or(Impulse::ZERO, |account| account.answer)
    }

    /// What it is to be given in a tick that the cloth does not take, as it sleeps: as much as in the last one.
    pub fn expected(&self, collider: usize) -> Impulse {
        let account = self.account(collider).filter(|_| self.first(collider) == collider);
        account.map_or(Impulse::ZERO, |account| account.as_told(account.coupling.expected))
    }
}
