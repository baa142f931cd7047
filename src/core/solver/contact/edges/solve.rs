//! Pressed edges are solved together, by sequential impulses: each in turn is given what it lacks or has too much of, up to
//! now (Catto 2005, *Iterative Dynamics with Temporal Coherence*). The strain limit of the threads that meet at their ends
//! is solved with them: what is pulled over a tip has to lift the cloth, and must not be stretched over it.
//!
//! A body yields to each push. One that hardly yields to all of them together stands still until the end.

use bevy_math::{Vec3, Vec3A};

use crate::solver::contact::BLOW;
use crate::solver::contact::edges::body::Body;
use crate::solver::contact::edges::contact_point::Press;
use crate::solver::contact::edges::{EdgesHeld, HoldEdges, WarmStart};
use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::mobility::{Mobility, Twist};
use crate::solver::simd::block::larger;

/// Rounds of the solution.
const ROUNDS: usize = 6;
/// Part of an impulse that is expected again in the next substep.
const EXPECTED: f32 = 0.75;
/// Part of the strain limit that threads beside pressed edges are held to, as other corrections follow, and from which on
/// they are looked at.
const LIMIT: f32 = 0.75;
const STRAINED: f32 = 0.25;
/// Part of all pushes up to which a body may yield to them and stand still meanwhile.
const STILL: f32 = 0.1;
/// Part of Coulomb's limit up to which an edge is braked that turns about where it is held.
const TURNING: f32 = 0.6;
/// Inverse mass that stands for that of what is held \[1/kg\].
const LEAST_INVERSE_MASS: f32 = 1e-12;
/// Part of what gravity moves a particle by in a substep, by which all pushes of a round change less once the solution is found.
const FOUND: f32 = 0.005;

/// A thread that meets the end of a pressed edge, and is to be held to the strain limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limited {
    /// The thread's ends, among the bodies.
    ends: [u32; 2],
    /// Longest that it may be \[m\].
    longest: f32,
}

/// The pressed edges and faces, the particles that they may move, and the threads that hold these back.
#[derive(Clone, Debug, Default)]
pub(super) struct System {
    pub presses: Vec<Press>,
    bodies: Vec<Body>,
    limited: Vec<Limited>,
    /// Where a particle is among the bodies, by slot; [`NONE`] where it is not.
    place: Vec<u32>,
}

/// No place.
const NONE: u32 = u32::MAX;

impl System {
    /// For so many slots, with room for so many pressed edges.
    pub fn new(slots: usize, few: usize) -> Self {
        Self {
            presses: Vec::with_capacity(few),
            bodies: Vec::with_capacity(few),
            limited: Vec::with_capacity(few),
            place: vec![NONE; slots],
        }
    }

    /// Part of all pushes together by which a body yields to them at most, in any direction.
    fn yields(&self, body: &Mobility) -> f32 {
        self.presses.iter().map(|press| press.mass * body.most_along(press.arm)).sum()
    }

    /// Lets the collider yield by so much in the substep, up to now.
    fn follow(&mut self, yielded: &Twist) {
        for press in &mut self.presses {
            press.follow(yielded);
        }
    }

    /// The impulse that all pushes have given the collider about its centre, times the substep.
    fn given(&self) -> Impulse {
        self.presses.iter().map(Press::given).sum()
    }

    /// Holds a thread to its limit.
    fn limit(&mut self, Limited { ends, longest }: Limited) {
        let [a, b] = ends.map(|end| self.bodies[end as usize]);
        let way = b.at() - a.at();
        let length = way.length();
        let all = a.inverse_mass + b.inverse_mass;
        if length <= longest || all == 0.0 {
            return;
        }
        let by = way * ((length - longest) / (length * all));
        self.bodies[ends[0] as usize].d += by * a.inverse_mass;
        self.bodies[ends[1] as usize].d -= by * b.inverse_mass;
    }

    /// Moves what was pressed out as far as it is still inside, by `most_push` at most. It gets no speed by that.
    fn move_out(&mut self, most_push: f32) {
        let Self { presses, bodies, .. } = self;
        for press in presses {
            let depth = press.depth(bodies);
            let leaves = larger(press.goes(bodies).dot(press.normal), 0.0);
            let allowed = larger(most_push - leaves, 0.0);
            let by = press.normal * larger(if depth < allowed { depth } else { allowed }, 0.0);
            press.visit_corners(
                #[inline(always)]
                |body, _, share| bodies[body].x += by * share,
            );
        }
    }

    /// Brakes the turning of what is pressed about where it is held, which nothing else stops: half of what each corner goes
    /// beside the others, as far as `friction` does it. Returns what the collider is given by that about its `centre`, times the
    /// substep: it takes over the turning.
    fn brake_turning(&mut self, friction: f32, centre: Vec3) -> Impulse {
        let Self { presses, bodies, .. } = self;
        let mut given = Impulse::ZERO;
        for press in presses {
            let mass = |body: usize| 1.0 / larger(bodies[body].inverse_mass, LEAST_INVERSE_MASS);
            let along = |body: usize| press.normal.dot(bodies[body].d);
            let (mut all, mut momentum) = (0.0, 0.0);
            for (body, ..) in press.corners() {
                all += mass(body);
                momentum += mass(body) * along(body);
            }
            let mut turning = [0.0; 3];
            for (turning, (body, ..)) in turning.iter_mut().zip(press.corners()) {
                *turning = 0.5 * mass(body) * (along(body) - momentum / all);
            }
            let largest =
                turning.into_iter().fold(0.0, |most, turning| larger(turning.abs(), most));
            let most = TURNING * friction * press.push * press.mass;
            let part = if largest > most { most / largest } else { 1.0 };
            for ((body, ..), turning) in press.corners().zip(turning) {
                let body = &mut bodies[body];
                let by = part * turning * body.inverse_mass;
                body.d -= press.normal * by;
                if body.inverse_mass > 0.0 {
                    given += Impulse::at(
                        Vec3::from(body.x) - centre,
                        (press.normal * (part * turning)).into(),
                    );
                }
            }
        }
        given
    }
}

impl HoldEdges<'_> {
    /// Solves for all that is pressed, and remembers what is to be expected.
    pub(super) fn solve(&mut self, system: &mut System) -> EdgesHeld {
        let mut held = EdgesHeld::default();
        self.find_bodies(system);
        // What is fast is met once, as what moves is looked at on its way.
        let rounds = if self.rule.is_slow { ROUNDS } else { 1 };
        let found = FOUND / self.settings.per_weight;
        let yielding = self.mobility.filter(|body| system.yields(body) >= STILL);
        let mut yielded = Twist::default();
        for round in 0..rounds {
            // What the first pushes stretch is among them.
            if round == 1 && self.limits {
                self.find_limited(system);
            }
            for i in 0..system.limited.len() {
                system.limit(system.limited[i]);
            }
            let changed = match &yielding {
                Some(body) => self.push_yielding(system, body, &mut yielded),
                None => self.push_each(system),
            };
            if changed < found && system.limited.is_empty() {
                break;
            }
        }
        if self.motion.measured {
            let given = system.given();
            held.given += given;
            if let Some(body) = &self.mobility {
                system.follow(&body.motion(given));
            }
        }
        system.move_out(self.settings.most_push);
        if self.rule.is_slow {
            // Braked beside nothing, they would turn a body that rolls ever faster.
            if self.mobility.is_none_or(|body| body.is_immovable()) {
                held.given += system.brake_turning(self.motion.friction, self.motion.centre[0]);
            }
            for press in &system.presses {
                self.expect(press);
            }
        }
        held.touching = self.count_touching(system);
        held.pushed = self.put_back(system);
        held
    }

    /// The particle of a slot, as it is now.
    fn body(&self, slot: u32) -> Body {
        let at = slot as usize;
        let (x, d) = (self.x.get(at).into(), self.d.get(at).into());
        Body { slot, inverse_mass: self.inverse_mass[at], x, d, before: [x, d] }
    }

    /// Finds the corners of what is pressed.
    fn find_bodies(&self, system: &mut System) {
        let System { presses, bodies, place, .. } = system;
        for press in presses {
            for (body, slot) in press.bodies.iter_mut().zip(press.place.corners) {
                let place = &mut place[slot as usize];
                if *place == NONE {
                    *place = bodies.len() as u32;
                    bodies.push(self.body(slot));
                }
                *body = *place;
            }
        }
    }

    /// Finds the threads at them that the first pushes have stretched too far, and the particles that these lead to. No thread
    /// is to be shorter than it was before.
    fn find_limited(&self, system: &mut System) {
        let strained = 1.0 + STRAINED * self.max_strain;
        let limit = 1.0 + LIMIT * self.max_strain;
        let System { bodies, limited, place, .. } = system;
        let ends = bodies.len();
        for i in 0..ends {
            let end = bodies[i];
            self.edges.visit_threads(end.slot as usize, |other, rest| {
                let bound = strained * rest;
                let is_end = (place[other] as usize) < ends;
                // One between two ends is met twice.
                if is_end && (place[other] as usize) < i {
                    return;
                }
                let other_at = match place[other] {
                    NONE => Vec3A::from(self.x.get(other)) + Vec3A::from(self.d.get(other)),
                    place => bodies[place as usize].at(),
                };
                if end.at().distance_squared(other_at) <= bound * bound {
                    return;
                }
                if place[other] == NONE {
                    place[other] = bodies.len() as u32;
                    bodies.push(self.body(other as u32));
                }
                let before = end.was_at().distance(bodies[place[other] as usize].was_at());
                let longest = larger(limit * rest, before);
                limited.push(Limited { ends: [i as u32, place[other]], longest });
            });
        }
    }

    /// Gives each in turn what it lacks, of a collider that stands still. Returns the largest change of a push, along any axis \[m\].
    fn push_each(&self, system: &mut System) -> f32 {
        let mut changed = Vec3A::ZERO;
        for press in &mut system.presses {
            changed = changed.max(self.push(press, &mut system.bodies).abs());
        }
        changed.max_element()
    }

    /// Gives each in turn what it lacks, as [`push_each`](Self::push_each) does, of a body that yields to each at once.
    fn push_yielding(&self, system: &mut System, body: &Mobility, yielded: &mut Twist) -> f32 {
        let mut changed = Vec3A::ZERO;
        for press in &mut system.presses {
            press.follow(yielded);
            let by = self.push(press, &mut system.bodies);
            yielded.add(&body.motion(Impulse::at(press.arm, (by * -press.mass).into())));
            changed = changed.max(by.abs());
        }
        changed.max_element()
    }

    /// Gives an edge or a face what it lacks of the push along the normal and of friction, or takes back what it has too much
    /// of. Returns the push.
    #[inline(always)]
    fn push(&self, press: &mut Press, bodies: &mut [Body]) -> Vec3A {
        let goes = press.goes(bodies);
        let along = goes.dot(press.normal);
        let push = larger(press.push + press.least - along, 0.0);
        let push = if push < press.most { push } else { press.most };
        let most = self.motion.friction * push;
        let brake = press.brake - (goes - press.normal * along);
        let square = brake.dot(brake);
        let slides = square > most * most;
        let brake = if slides { brake * (most / square.sqrt()) } else { brake };
        let by = press.normal * (push - press.push) + (brake - press.brake);
        if !self.rule.is_slow && self.goes_through(press, by, bodies) {
            // It is left where it is.
            press.depth = f32::NEG_INFINITY;
            return Vec3A::ZERO;
        }
        (press.push, press.brake) = (push, brake);
        press.visit_corners(
            #[inline(always)]
            |body, _, share| bodies[body].d += by * share,
        );
        by
    }

    /// Remembers what is to be expected in the next substep. Of what is struck, nothing is.
    fn expect(&mut self, press: &Press) {
        if press.push <= 0.0 {
            return;
        }
        let blow = press.push * self.settings.per_weight * (1.0 / BLOW);
        let struck = if press.was_expected { 0.0 } else { blow * blow };
        let push = press.normal * press.push + press.brake;
        self.set.edges.next_warm.push(WarmStart {
            collider: self.collider as u32,
            corners: press.place.corners,
            parts: press.place.parts,
            impulse: Vec3::from(push) * (press.mass * EXPECTED / (1.0 + struck)),
        });
    }

    /// How many corners are held that do not lie on a collider by themselves.
    fn count_touching(&self, system: &mut System) -> u32 {
        let System { presses, place, .. } = system;
        let mut touching = 0;
        for press in presses.iter().filter(|press| press.push > 0.0) {
            for &slot in press.place.corners() {
                // Each is counted once.
                let is_new = core::mem::replace(&mut place[slot as usize], NONE) != NONE;
                let lies = self.set.next.normal.get(slot as usize) != Vec3::ZERO;
                touching += u32::from(is_new && !lies);
            }
        }
        touching
    }

    /// Puts the particles where they are found to be, and tells how far any was moved at most \[m\].
    fn put_back(&mut self, system: &mut System) -> f32 {
        let mut pushed = 0.0;
        for body in system.bodies.drain(..) {
            let slot = body.slot as usize;
            system.place[slot] = NONE;
            let [x, d] = body.before;
            let by = body.d - d;
            self.x.set(slot, body.x.into());
            self.displace(slot, by.into());
            pushed = larger((body.x - x + by).length(), pushed);
        }
        system.limited.clear();
        pushed
    }
}
