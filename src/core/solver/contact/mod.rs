//! Contact with signed distance fields: particles are held `epsilon` outside, with friction.
//!
//! A particle nearer than epsilon is moved out along the gradient. Its displacement, and so its
//! velocity, loses the approach that this undoes and no more: being moved out of a collider gives no
//! speed. Coulomb's friction acts on the displacement relative to the collider's surface, with the
//! impulse of that same undoing.
//!
//! Particles meet one collider after the other (`ResolveContacts`), and after them the edges between them.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `pose` | where a rigid thing is |
//! | `collider` | a collider, and its motion through a tick and in a substep |
//! | `keys` | the keys by which colliders are known from tick to tick |
//! | `broad_phase` | the colliders that may be touched, and the blocks of particles that may touch them |
//! | `response` | a band of particles meets one collider: swept, then pushed out |
//! | `swept` | fast particles and colliders, which pass each other by more than epsilon in a substep |
//! | `push_out` | a block of particles at a collider: its gaps, its push, its slip |
//! | `friction` | Coulomb's friction of a particle that lies on a collider |
//! | `active_set` | the particles that lie on colliders, with normal, slip and load, as corrections know them |
//! | `calm` | the cloth around what is deep inside a collider does not get fast |
//! | `hold_onto` | before the corrections: particles of the active set go only where their surface lets them |
//! | `hold` | after the corrections: how those particles were held |
//! | `found` | during contact: the active set of the next substep |
//! | `hold_out` | at the end of a worn cloth's tick: what passes of the strain limit moved into colliders |
//! | `let_go` | after contact: particles of the active set that touch nothing any more |
//! | `impulse`, `impulses`, `account`, `ledger` | momentum given to the colliders that are measured |
//! | `mobility` | bodies that the cloth moves, and how far they are from their planned way |
//! | `easy_turns` | bodies that turn easily about an axis, as a cloth takes them |
//! | `coupling` | what is remembered of such a body from tick to tick, and what its engine is given |
//! | `answer`, `touching`, `together` | after contact: a body and the particles that lie on it go on together |
//! | `edges` | edges and faces: near a rim or tip (`candidates`), nearest place (`search`), solved together (`solve`) |
//!
//! Friction is in four places. `friction` brakes a particle that rests or slides. `Pushed::slip` in `push_out` tells
//! corrections which part of its inverse mass moves it along the surface in the next substep. `swept` has a friction of
//! its own, at the impact. So has `edges/solve`, for pressed edges and faces.

mod account;
mod active_set;
mod answer;
mod broad_phase;
mod calm;
mod collider;
mod coupling;
mod easy_turns;
mod edges;
mod found;
mod friction;
mod hold;
mod hold_onto;
mod hold_out;
mod impulse;
mod impulses;
mod keys;
mod ledger;
mod let_go;
mod mobility;
mod pose;
mod push_out;
mod response;
mod swept;
mod together;
mod touching;

use bevy_math::Vec3;

pub use crate::solver::contact::collider::{Collider, ColliderMotion};
pub use crate::solver::contact::impulse::Impulse;
pub use crate::solver::contact::mobility::Mobility;
pub use crate::solver::contact::pose::Pose;

pub(super) use crate::solver::contact::coupling::Coupling;
pub(super) use crate::solver::contact::impulses::Share;

pub(super) use crate::solver::contact::active_set::{
    ActiveSet, Contacts, LEAST_MOBILITY, Normals, divide,
};
pub(super) use crate::solver::contact::broad_phase::{BroadPhase, box_gap};
pub(super) use crate::solver::contact::edges::{EdgeMemory, Edges, Freed, WarmStart};
pub(super) use crate::solver::contact::hold_onto::{HoldOnto, NoteUnfollowed};
pub(super) use crate::solver::contact::response::FurthestWay;

use crate::solver::contact::answer::Answer;
use crate::solver::contact::broad_phase::{Awake, of_place};
use crate::solver::contact::collider::Motion;
use crate::solver::contact::edges::{HoldEdges, Nearby, Rule, Until};
use crate::solver::contact::found::Found;
use crate::solver::contact::hold::Held;
use crate::solver::contact::let_go::LetGo;
use crate::solver::contact::push_out::Tally;
use crate::solver::contact::response::MeetCollider;
use crate::solver::simd::block::larger;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::parallel::{self, Bands};
use crate::solver::simd::slots::ByBlock;
use crate::solver::simd::soa::{Soa, ValuesMut};

/// Least way of sliding that has a direction \[m\].
const LEAST_SLIDING: f32 = 1e-20;
/// Depths of the deepest particle within which a collider calms the cloth while it lets it out.
const CALMED: f32 = 8.0;
/// Normal load, in particle weights: up to `LIGHT` corrections ignore friction, from `HEAVY` they take it fully into
/// account. A cloth that lies in a few layers, or over a smooth edge, stays below both.
const LIGHT: f32 = 8.0;
const HEAVY: f32 = 32.0;
/// The least part of its inverse mass that corrections see of what friction holds.
const LEAST_SLIP: f32 = 0.2;
/// Time over which the mean is taken of how far a particle slips \[s\]: a mobility that followed each substep's would
/// shake the cloth.
pub(super) const FOLLOWING: f32 = 0.01;
/// Approach of a blow, in displacements that gravity makes in a substep. What trembles stays below it.
const BLOW: f32 = 32.0;
/// Makes up for what rounding takes off the sum of many small ways.
const ROUNDED_UP: f32 = 1.0 + 1e-5;

/// The part of a tick that a substep covers, from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub from: f32,
    pub to: f32,
}

/// Thickness, friction and layers of the cloth, and the substep's limits, as contact takes them.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactSettings {
    /// Distance at which particles are held \[m\].
    pub epsilon: f32,
    /// The cloth's coefficient of friction.
    pub friction: f32,
    /// The layers that it is in, a bit each.
    pub layers: u32,
    /// How far a particle that is inside a collider is pushed out in the substep at most \[m\].
    pub most_push: f32,
    /// 1 / displacement that gravity makes in the substep \[1/m\].
    pub per_weight: f32,
    /// Part of the substep in the mean of how far particles slip.
    pub following: f32,
    /// Length of the substep \[s\].
    pub step: f32,
    /// Whether pulls are noted.
    pub notes: bool,
}

/// Moves particles out of all colliders, in their order, and returns how many touched one.
pub(super) struct ResolveContacts<'a> {
    pub bands: &'a Bands,
    pub colliders: &'a [Collider<'a>],
    pub origin: Vec3,
    pub span: Span,
    pub settings: ContactSettings,
    pub inverse_mass: &'a mut [f32],
    pub x: &'a mut Soa,
    pub d: &'a mut Soa,
    /// Pulls noted from before the corrections on (`integrate::houbolt`): what touches a collider has none.
    pub pull: Option<&'a mut Soa>,
    pub broad_phase: &'a mut BroadPhase,
    /// The cloth's edges, where they are to be held out too.
    pub edges: Option<&'a Edges>,
    /// Strain that threads are limited to, and the largest that any has.
    pub max_strain: f32,
    pub strain: f32,
    /// Whether threads are held to that limit.
    pub limits: bool,
    pub set: &'a mut ActiveSet,
}

impl<'c> ResolveContacts<'c> {
    /// Meets one collider after the other.
    pub fn run(mut self, isa: Isa) -> u32 {
        let way = parallel::run(
            isa,
            FurthestWay { band: self.bands.rows.clone(), d: self.d, from: None },
        )
        .0
        .sqrt();
        let ContactSettings { epsilon, layers, step, .. } = self.settings;
        let layout = self.bands.rows.layout;
        let notes = self.pull.is_some();
        self.set.give_yielding(isa, self.inverse_mass, [self.x, self.d], notes, step);
        self.broad_phase.begin_substep();
        self.broad_phase.wake(
            isa,
            way,
            epsilon,
            layers,
            self.x,
            layout,
            self.origin,
            self.colliders,
        );
        let mut touching = 0;
        for k in 0..self.broad_phase.awake.len() {
            touching += self.meet(isa, k, way);
        }
        self.calm_all();
        if self.set.now.any {
            let pull = self.pull.as_deref_mut();
            isa.run(LetGo { set: self.set, inverse_mass: self.inverse_mass, d: self.d, pull });
            self.set.give_taken(isa, self.inverse_mass, [self.x, self.d], notes, step);
        }
        self.set.impulses.end_substep(
            self.colliders,
            self.origin,
            self.span.to,
            self.settings.step,
        );
        self.set.turn();
        touching
    }

    /// Holds all particles out of one collider, and returns how many touched it. `way` is what the
    /// fastest particle goes in this substep \[m\].
    fn meet(&mut self, isa: Isa, k: usize, way: f32) -> u32 {
        let (broad_phase, set) = (&mut *self.broad_phase, &mut *self.set);
        let Awake { collider, first, gone, .. } = broad_phase.awake[k];
        if set.impulses.passes(collider) {
            return 0;
        }
        set.impulses.meet(collider, self.colliders, self.origin, self.span.from);
        let before = set.impulses.of(collider);
        let motion = self.motion(collider);
        let (broad_phase, set) = (&mut *self.broad_phase, &mut *self.set);
        broad_phase.awake[k].gone = gone + motion.reach;
        // Particles that another collider has pushed have gone further.
        let way = way + broad_phase.pushed + motion.reach;
        let gone = (broad_phase.gone + broad_phase.pushed + gone + motion.reach) * ROUNDED_UP;
        let settings = &self.settings;
        let stretch = 1.0 + larger(self.max_strain, self.strain);
        let rule = |edges| Some((edges, Rule::new(edges, &motion, settings, stretch)?));
        let rule = self.edges.and_then(rule);
        if let Some((edges, _)) = rule {
            let slots = self.bands.rows.layout.len();
            broad_phase.nearby.get_or_insert_with(|| Nearby::new(slots, edges));
        }
        // What passes through the collider is not met: it is shown as what nothing moves.
        let freed = set.edges.freed.iter().filter(|freed| freed.collider as usize == collider);
        let freed: Vec<_> =
            freed.map(|it| (it.slot as usize, self.inverse_mass[it.slot as usize])).collect();
        for &(slot, _) in &freed {
            self.inverse_mass[slot] = 0.0;
        }
        let met = parallel::run(
            isa,
            MeetCollider {
                band: self.bands.sums.clone(),
                motion: &motion,
                collider,
                settings: self.settings,
                is_fast: way > self.settings.epsilon + motion.fast,
                gone,
                inverse_mass: self.inverse_mass,
                x: self.x.part_mut(),
                d: self.d.part_mut(),
                pull: self.pull.as_deref_mut().map(Soa::part_mut),
                until: ByBlock::all(&mut broad_phase.until[first..]),
                edge_reach: rule.map_or(0.0, |(_, rule)| rule.reach),
                nearby: rule.and_then(|_| Some(broad_phase.nearby.as_mut()?.part_mut())),
                held: Held {
                    set: &set.now,
                    unpulled: &set.unpulled,
                    lost: ValuesMut::all(&mut set.lost),
                    load: ValuesMut::all(&mut set.load),
                },
                found: Found {
                    blocks: ByBlock::all(&mut set.next.blocks),
                    normal: set.next.normal.part_mut(),
                    slip: ValuesMut::all(&mut set.next.slip),
                    loose: ValuesMut::all(&mut set.next.loose),
                    velocity: set.velocity.part_mut(),
                    holder: ValuesMut::all(&mut set.holder),
                    pressed: set.pressed.part_mut(),
                },
            },
        );
        for &(slot, w) in freed.iter().rev() {
            self.inverse_mass[slot] = w;
        }
        broad_phase.struck |= met.struck;
        broad_phase.pushed += met.deepest;
        let Tally { left, touching, .. } = &met.tally;
        if motion.measured {
            let (given, owed) = (met.tally.given(), met.tally.owed());
            set.impulses.give_sum(collider, given, owed, self.settings.step);
        }
        let (is_left, deepest) = (left.largest() > 0.0, met.deepest);
        let mut touching = touching.iter().sum();
        if let (Some((edges, rule)), Some(nearby)) = (rule, &mut broad_phase.nearby) {
            let faces = if rule.has_faces { edges.face_count() } else { 0 };
            let until = Until {
                edges: of_place(&mut broad_phase.edge_until, k, edges.count()),
                faces: of_place(&mut broad_phase.face_until, k, faces),
                gone,
            };
            let held = HoldEdges {
                edges,
                nearby,
                rule,
                until,
                motion: &motion,
                mobility: set.impulses.mobility(collider),
                settings,
                max_strain: self.max_strain,
                limits: self.limits,
                inverse_mass: self.inverse_mass,
                x: self.x,
                d: self.d,
                pull: self.pull.as_deref_mut(),
                set,
                collider,
            };
            let held = held.run(isa);
            broad_phase.pushed += held.pushed;
            touching += held.touching;
            if motion.measured {
                set.impulses.give_sum(collider, held.given, Impulse::ZERO, self.settings.step);
            }
        }
        self.broad_phase.awake[k].left = if is_left { deepest } else { 0.0 };
        if let Some(mobility) = self.set.impulses.mobility(collider) {
            self.calm(k, gone, &motion);
            self.answer(isa, k, gone, &motion, mobility, before);
        }
        touching
    }

    /// The motion of a collider through the substep.
    fn motion(&self, collider: usize) -> Motion<'c> {
        let span = [self.span.from, self.span.to];
        let impulses = &self.set.impulses;
        let moved = impulses.deviation(collider);
        let moves = impulses.velocity(collider, span[1]);
        let moved = [moved, moved.after(&moves, self.settings.step)];
        let apart = [0, 1].map(|i| impulses.apart(collider, span[i], &moved[i]));
        let colliders = self.colliders;
        Motion::new(&colliders[collider], self.origin, self.settings.friction, span, apart)
    }

    /// Lets a body and what lies on it share what it was given since `before`.
    fn answer(
        &mut self,
        isa: Isa,
        k: usize,
        gone: f32,
        motion: &Motion<'_>,
        mobility: Mobility,
        before: Impulse,
    ) {
        let Awake { collider, first, .. } = self.broad_phase.awake[k];
        let until = &self.broad_phase.until[first..];
        let (set, step) = (&mut *self.set, self.settings.step);
        let given = set.impulses.of(collider) - before;
        let (inverse_mass, x) = (&*self.inverse_mass, &*self.x);
        let (d, pull) = (&mut *self.d, self.pull.as_deref_mut());
        let answer = Answer {
            collider,
            mobility,
            motion,
            given,
            step,
            inverse_mass,
            x,
            d,
            pull,
            set,
            until,
            gone,
        };
        let taken = isa.run(answer);
        self.set.impulses.give_sum(collider, taken * step, Impulse::ZERO, step);
    }
}
