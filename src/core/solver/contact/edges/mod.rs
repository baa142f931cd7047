//! Edges and faces of the cloth are held out of colliders that are thin or sharp at the scale of its particles.
//!
//! The distance to a solid changes by at most a metre in a metre. So an edge of length l, whose ends have the gaps g0 and g1
//! to what is held, is held itself as long as g0 + g1 >= l. Of the others, those are left out whose ends see the surface face
//! nearly the same way: a flat or gently curved side. What is left lies around a rim, a tip, a rod (`candidates`). There the
//! place of an edge that is nearest to the solid is found (`search`; for contact with distance fields: Macklin et al. 2020,
//! *Local Optimization for Robust Signed Distance Field Collision*), and moved out with both ends, each by its
//! share and its inverse mass (`contact_point`). Where the three corners of a face see three sides of a solid, whose vertex may be in their
//! midst, the face is searched and held in the same way; but not on a solid so gently curved that it cannot reach in between edges.
//!
//! An edge is held at half the distance of the particles, so that on a smooth solid these touch first, and edges cost nothing.
//!
//! Edges that meet at a particle hold each other, and so they are solved together, with Coulomb's friction and the strain limit
//! of the threads beside them (`solve`). What they were pressed by is expected again in the next substep, and given to
//! the displacements before the corrections (`memory`): threads that pull an edge over a rim find it held, and so they
//! are stretched no further there, and nothing trembles. Threads that a collider is hooked in are let through (`release`).

mod body;
pub(super) mod candidates;
mod contact_point;
mod list;
mod look;
pub(super) mod memory;
mod place;
mod release;
mod search;
mod solve;

use bevy_math::Vec3;

pub(crate) use crate::solver::contact::edges::list::Edges;
pub(crate) use crate::solver::contact::edges::memory::{EdgeMemory, Freed, WarmStart};

pub(super) use crate::solver::contact::edges::candidates::{Nearby, NearbyMut, Until};

use crate::solver::contact::ContactSettings;
use crate::solver::contact::active_set::ActiveSet;
use crate::solver::contact::collider::Motion;
use crate::solver::contact::edges::candidates::FindClose;
use crate::solver::contact::edges::search::{SearchEdges, SearchFaces};
use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::mobility::Mobility;
use crate::solver::simd::block::larger;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::soa::Soa;

/// Part of the particles' distance at which edges are held.
const HELD: f32 = 0.5;
/// Part of its length by which an edge may sink into a curved side, where that is more. Normals at the ends of such an edge
/// differ by eight times as much: a fifth of a radian.
const SAGITTA: f32 = 0.0256;
/// Multiple of epsilon by which an end is nearer than that where it is inside, and did not only begin to touch.
const INSIDE: f32 = 2.0;
/// Least distance, as a part of an edge, that stands for epsilon there. Of a cloth without thickness, rounding would put every
/// end inside that lies on a surface: its edges would be held in one substep and not in the next, which throws the cloth.
const LEAST_INSIDE: f32 = 0.01;
/// Part of an edge by which a collider may go in a substep and count as slow.
const SLOW: f32 = 0.125;
/// Part of an edge from which on a collider passes edges within a substep, and only particles are held.
const FAST: f32 = 0.75;

/// The rule for which edges are looked at closely.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rule {
    /// Sum of the gaps of both ends from which on an edge is held anyway \[m\].
    pub reach: f32,
    /// Whether the collider hardly moves in the substep: its pressed edges are solved for in several rounds, and remembered.
    pub is_slow: bool,
    /// Gap below which an end is inside: it comes out by itself, before its edges are held.
    inside: f32,
    /// Least cosine between normals of a side that is gently curved.
    alike: f32,
    /// Whether faces are searched too.
    pub has_faces: bool,
}

impl Rule {
    /// For edges of a cloth and a collider; `None` where none is ever to be looked at, as the whole solid is gently
    /// curved. Edges may be longer than at rest by `stretch`.
    pub fn new(
        edges: &Edges,
        motion: &Motion<'_>,
        settings: &ContactSettings,
        stretch: f32,
    ) -> Option<Self> {
        let length = edges.longest * stretch;
        // An arc over a chord, and the angle between its normals: the sagitta is an eighth of their product.
        let sagitta = larger(HELD * settings.epsilon, SAGITTA * length);
        // What is fast stretches edges, and then passes between particles whatever its curvature.
        if motion.reach > FAST * length {
            return None;
        }
        let is_slow = motion.reach <= SLOW * edges.longest;
        if is_slow && length * length <= 8.0 * sagitta * motion.least_radius {
            return None;
        }
        // Between edges that touch, a solid reaches into a face by the sagitta of a chord as long as the face's inscribed circle is wide.
        let across = edges.joined.widest_inscribed() * length;
        let has_faces = !is_slow || across * across > 8.0 * sagitta * motion.least_radius;
        let angle = 8.0 * sagitta / length;
        let less = 2.0 * (HELD - 1.0) * settings.epsilon + motion.reach;
        let reach = length + less;
        (reach > 0.0).then_some(Self {
            reach,
            is_slow,
            inside: -INSIDE * larger(settings.epsilon, LEAST_INSIDE * edges.longest) - motion.reach,
            alike: 1.0 - 0.5 * angle * angle,
            has_faces,
        })
    }
}

/// Holds the edges of a cloth out of one collider.
pub(super) struct HoldEdges<'a> {
    pub edges: &'a Edges,
    pub nearby: &'a mut Nearby,
    pub rule: Rule,
    pub until: Until<'a>,
    pub motion: &'a Motion<'a>,
    /// What it moves by, where it is a body.
    pub mobility: Option<Mobility>,
    pub settings: &'a ContactSettings,
    /// Strain that threads are limited to, and whether threads beside pressed edges are held to it.
    pub max_strain: f32,
    pub limits: bool,
    pub inverse_mass: &'a [f32],
    pub x: &'a mut Soa,
    pub d: &'a mut Soa,
    /// Pulls noted from before the corrections on (`integrate::houbolt`), of which contact is none.
    pub pull: Option<&'a mut Soa>,
    pub set: &'a mut ActiveSet,
    /// Index of the collider.
    pub collider: usize,
}

/// Edges of a collider, once they are held.
#[derive(Default)]
pub(super) struct EdgesHeld {
    /// How far any particle was moved at most \[m\].
    pub pushed: f32,
    /// What the collider is given, times the substep.
    pub given: Impulse,
    /// How many ends of edges are held that do not lie on the collider by themselves.
    pub touching: u32,
}

impl HoldEdges<'_> {
    pub fn run(mut self, isa: Isa) -> EdgesHeld {
        let slowed = self.keep_passing();
        isa.run_transposing(FindClose {
            edges: self.edges,
            nearby: self.nearby,
            rule: self.rule,
            until: &self.until,
        });
        // All are searched before any is moved: what is passed over as it is too far changes no bit of the others.
        let Nearby { close, faces, places, .. } = &mut *self.nearby;
        let (x, d, motion) = (&*self.x, &*self.d, self.motion);
        let held = HELD * self.settings.epsilon;
        isa.run(SearchEdges {
            edges: self.edges,
            close,
            x,
            d,
            motion,
            held,
            until: &mut self.until,
            places,
        });
        isa.run(SearchFaces { faces, x, d, motion, held, until: &mut self.until, places });
        let mut system = core::mem::take(&mut self.nearby.system);
        self.find_pressed(isa, &mut system.presses);
        let mut held =
            if system.presses.is_empty() { EdgesHeld::default() } else { self.solve(&mut system) };
        held.given += slowed;
        self.nearby.system = system;
        self.nearby.clear();
        held
    }

    /// Changes the displacement of a slot's particle. What contact does is no pull of the cloth.
    fn displace(&mut self, slot: usize, by: Vec3) {
        self.d.set(slot, self.d.get(slot) + by);
        self.set.unpulled.set(slot, self.set.unpulled.get(slot) + by);
        if let Some(pull) = &mut self.pull {
            pull.set(slot, pull.get(slot) - by);
        }
    }
}
