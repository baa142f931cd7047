//! Cloths that are worn: where the skeleton would move their particles, through a tick.
//!
//! | file | what it does |
//! | --- | --- |
//! | here | data: the skin of a running cloth, and its way through a tick |
//! | `track` | data: the joints from tick to tick |
//! | `drawn` | data: the skin of a drawn shape that another carries |
//! | `make` | makes the skin of a cloth from its components and its mesh |
//! | `taken` | component and observers: the skin that was taken off an entity, and is given back |
//! | `wear` | system: applies changed limits and changed sizes, and puts cloths that have not begun where their skins are |

pub(crate) mod drawn;
pub(crate) mod make;
pub(crate) mod taken;
pub(crate) mod track;
pub(crate) mod wear;

use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_drape_core::surface::{skin, skin_with_normals};

use crate::error::skin::SkinProblem;
use crate::mesh::skinned::SkinnedShape;
use crate::pose::frames::FrameTicks;
use crate::pose::root::Root;
use crate::pose::skeleton::{Joints, Seen, Skeleton};
use crate::simulation::skin::drawn::DrawnSkin;
use crate::simulation::skin::track::SkinTrack;
use crate::solver::{ClothSolver, RigidMotion, SkinLimit, SkinMotion};

/// The skin of a running cloth.
pub(crate) struct Skin {
    pub(crate) skeleton: Skeleton,
    pub(crate) shape: SkinnedShape,
    /// Of the shape that is drawn, where it is another.
    pub(crate) drawn: Option<Box<DrawnSkin>>,
    /// The joint that leads the cloth: the one that moves most of it.
    pub(crate) leader: u16,
    /// Particles whose max distance is 0, ascending.
    pub(crate) at_zero: Vec<u32>,
    /// Whether any particle has a backstop.
    pub(crate) has_backstops: bool,
    pub(crate) state: SkinState,
    /// Places on the skin at the tick's start, and at its end \[m\]; normals, where there are backstops.
    starts: Vec<Vec3>,
    ends: Vec<Vec3>,
    normals: [Vec<Vec3>; 2],
    /// Where joints are now.
    now: Seen,
}

/// The limits of a skin.
pub(crate) struct Limits {
    pub of_particles: Vec<SkinLimit>,
    /// Which particles of the drawn shape have a max distance of 0, where it is another.
    pub at_zero: Vec<bool>,
}

/// What later ticks depend on.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct SkinState {
    pub(crate) track: SkinTrack,
    /// Particles that pins without an anchor hold to their places, ascending.
    pub(crate) pinned: Vec<u32>,
    /// Particles that are held to their places, ascending: those, and those of max distance 0, but for those that other pins hold.
    pub(crate) held: Vec<u32>,
    /// What is held has not been held through a tick: it starts from where it is.
    pub(crate) fresh: bool,
}

impl SkinState {
    /// Whether it could be that of a cloth of so many particles and joints.
    pub fn is_sound(&self, particles: usize, joints: usize) -> bool {
        let sound = |list: &[u32]| {
            list.is_sorted_by(|a, b| a < b) && list.iter().all(|it| (*it as usize) < particles)
        };
        self.track.is_sound(joints) && sound(&self.pinned) && sound(&self.held)
    }
}

impl Skin {
    /// Of a cloth that has not begun.
    fn new(
        skeleton: Skeleton,
        shape: SkinnedShape,
        drawn: Option<SkinnedShape>,
        leader: u16,
        (now, root): (Seen, Root),
    ) -> Self {
        let count = shape.points.len();
        let matrices = now.matrices.clone();
        let mut skin = Self {
            skeleton,
            shape,
            drawn: drawn.map(DrawnSkin::new).map(Box::new),
            leader,
            at_zero: Vec::new(),
            has_backstops: false,
            state: SkinState {
                track: SkinTrack::new(matrices, root),
                pinned: Vec::new(),
                held: Vec::new(),
                fresh: true,
            },
            starts: vec![Vec3::ZERO; count],
            ends: vec![Vec3::ZERO; count],
            normals: [Vec::new(), Vec::new()],
            now,
        };
        skin.stand();
        skin
    }

    /// Goes on from a state that was saved.
    pub fn restore(&mut self, state: SkinState) {
        self.state = state;
        self.stand();
    }

    /// The entity that leads the cloth.
    pub fn leader(&self) -> Entity {
        self.skeleton.joints[self.leader as usize]
    }

    /// Takes over limits, one a particle, and which particles of a drawn shape have none of the way. What they hold is held by
    /// [`Skin::hold`] from then on.
    fn limit(&mut self, Limits { of_particles: limits, at_zero }: &Limits) {
        if let Some(drawn) = &mut self.drawn {
            drawn.at_zero.clone_from(at_zero);
        }
        let at_zero = (0_u32..).zip(limits).filter(|(_, limit)| limit.max_distance == 0.0);
        self.at_zero = at_zero.map(|(particle, _)| particle).collect();
        self.has_backstops = limits.iter().any(|limit| limit.backstop.is_some());
        self.stand();
    }

    /// Holds to their places what is to be held, but for those particles that are attached to something else.
    pub fn hold(&mut self, is_attached: impl Fn(u32) -> bool) {
        let SkinState { pinned, held, .. } = &mut self.state;
        held.clear();
        held.extend(self.at_zero.iter().chain(&*pinned));
        held.sort_unstable();
        held.dedup();
        held.retain(|particle| !is_attached(*particle));
    }

    /// Notes where joints are before the ticks of a frame; `at_once` where they have jumped.
    pub fn begin_frame(&mut self, joints: &Joints, ticks: FrameTicks, at_once: bool) {
        // Told in the tick.
        let _ = joints.look(&self.skeleton, &mut self.now);
        self.state.track.begin_frame(&self.now.matrices, joints.root(self.leader()), ticks);
        if at_once {
            self.state.track.at_once();
        }
    }

    /// Goes on by a tick; `at_once` takes the whole way of the last frame. Tells whether anything moves, and the first joint that is
    /// gone: what follows it stays.
    pub fn advance(&mut self, joints: &Joints, at_once: bool) -> (bool, Result<(), SkinProblem>) {
        let outcome = joints.look(&self.skeleton, &mut self.now);
        if at_once {
            self.state.track.at_once();
        }
        let moves = self.state.track.advance(&self.now.matrices, joints.root(self.leader()));
        core::mem::swap(&mut self.starts, &mut self.ends);
        let [before, after] = &mut self.normals;
        core::mem::swap(before, after);
        if moves {
            self.place_ends();
        } else {
            self.ends.copy_from_slice(&self.starts);
            let [before, after] = &mut self.normals;
            after.copy_from_slice(before);
        }
        (moves, outcome.map_err(SkinProblem::JointGone))
    }

    /// Follows the joints of a cloth that has not begun. Tells whether they are elsewhere.
    pub fn start_anew(&mut self, joints: &Joints) -> bool {
        // Told in the first tick.
        let _ = joints.look(&self.skeleton, &mut self.now);
        let moved = self.now.matrices != self.state.track.end();
        if moved {
            let root = joints.root(self.leader());
            self.state.track = SkinTrack::new(self.now.matrices.clone(), root);
            self.stand();
        }
        moved
    }

    /// Works out where the tick ends.
    fn place_ends(&mut self) {
        let Self { shape, state, ends, normals: [_, normals], .. } = self;
        let SkinnedShape { points, normals: rest, influences } = shape;
        let matrices = state.track.end();
        if normals.is_empty() {
            skin(points, influences, matrices, |i, place| ends[i] = place);
        } else {
            skin_with_normals(points, rest, influences, matrices, |i, place, normal| {
                (ends[i], normals[i]) = (place, normal);
            });
        }
    }

    /// Nothing moves until the next tick.
    fn stand(&mut self) {
        let count = if self.has_backstops { self.shape.points.len() } else { 0 };
        self.normals.iter_mut().for_each(|normals| normals.resize(count, Vec3::ZERO));
        self.place_ends();
        self.starts.copy_from_slice(&self.ends);
        let [before, after] = &mut self.normals;
        before.copy_from_slice(after);
    }

    /// Where all particles are on the skin at the tick's end \[m\].
    pub fn places(&self) -> &[Vec3] {
        &self.ends
    }

    /// Goes on from the track of another skin of the same skeleton, whose places at the tick's start were these.
    pub fn go_on_from(&mut self, before: &Self, starts: Vec<Vec3>) {
        self.state.track = before.state.track.clone();
        self.stand();
        self.starts = starts;
    }

    /// Where all particles were on the skin at the tick's start \[m\].
    pub fn starts(&self) -> &[Vec3] {
        &self.starts
    }

    /// Lets the skin have come from elsewhere in this tick.
    pub fn carry(&mut self, motion: &RigidMotion) {
        self.starts.iter_mut().for_each(|place| *place = motion.apply(*place));
        for normal in &mut self.normals[0] {
            *normal = motion.rotation * *normal;
        }
    }

    /// Where particles are that have gone along with the skin, each with its own place and turned with the normal there, from the
    /// tick's start to its end \[m\]. Then the skin has been at the end all the time.
    pub fn arrive(&mut self, solver: &ClothSolver) -> Vec<Vec3> {
        let [before, after] = &self.normals;
        let ways = self.starts.iter().zip(&self.ends).enumerate();
        let arrived = ways.map(|(i, (start, end))| {
            let beside = solver.position(i) - start;
            *end + turned(beside, before.get(i), after.get(i))
        });
        let arrived = arrived.collect();
        self.starts.copy_from_slice(&self.ends);
        let [before, after] = &mut self.normals;
        before.copy_from_slice(after);
        arrived
    }

    /// Shows a cloth that is culled as [`Skin::arrive`] will have it: where the skin is that these matrices move, after `along` has
    /// carried all. Calls `put` with each particle and its place in the world.
    pub fn draw_culled(
        &self,
        solver: &ClothSolver,
        matrices: &[Affine3A],
        along: &RigidMotion,
        mut put: impl FnMut(usize, Vec3),
    ) {
        let SkinnedShape { points, normals: rest, influences } = &self.shape;
        let [_, before] = &self.normals;
        skin_with_normals(points, rest, influences, matrices, |i, now, normal| {
            let beside = along.rotation * (solver.position(i) - self.ends[i]);
            let before = before.get(i).map(|before| along.rotation * *before);
            put(i, now + turned(beside, before.as_ref(), Some(&normal)));
        });
    }

    /// The particles that are held, and where they are led from the tick's start to its end \[m\].
    pub fn ways<'a>(
        &'a self,
        solver: &'a ClothSolver,
    ) -> impl Iterator<Item = (u32, Vec3, Vec3)> + 'a {
        let fresh = self.state.fresh;
        let way = move |&held: &u32| {
            let particle = held as usize;
            let start = if fresh { solver.position(particle) } else { self.starts[particle] };
            (held, start, self.ends[particle])
        };
        self.state.held.iter().map(way)
    }

    /// The motions of all places through the tick, as they are seen in a ride.
    pub fn gather_motions(&mut self, ride: Option<RigidMotion>, motions: &mut Vec<SkinMotion>) {
        self.state.fresh = false;
        let back = ride.map(|ride| ride.inverse());
        let place = |end: Vec3| back.map_or(end, |back| back.apply(end));
        let turned = |end: Vec3| back.map_or(end, |back| back.rotation * end);
        let [before, after] = &self.normals;
        motions.clear();
        motions.extend(self.starts.iter().zip(&self.ends).enumerate().map(|(i, (start, end))| {
            let normal = match (before.get(i), after.get(i)) {
                (Some(before), Some(after)) => [*before, turned(*after)],
                _ => [Vec3::ZERO; 2],
            };
            SkinMotion { place: [*start, place(*end)], normal }
        }));
    }

    /// Moves what is drawn at a part of the tick along with the skin, which is where these matrices put it now: what is held to its
    /// place there, the rest by as much as its place has moved. `to_frame` takes a vector of the world, from `origin` on, into the frame of
    /// the points.
    pub fn draw(
        &self,
        matrices: &[Affine3A],
        blend: f32,
        origin: Vec3,
        to_frame: impl Fn(Vec3) -> Vec3,
        points: &mut [Vec3],
    ) {
        let mut held = self.state.held.iter().copied().peekable();
        let SkinnedShape { points: rest, influences, .. } = &self.shape;
        skin(rest, influences, matrices, |i, now| {
            points[i] = if held.next_if_eq(&(i as u32)).is_some() {
                to_frame(now - origin)
            } else {
                let drawn = self.starts[i].lerp(self.ends[i], blend);
                points[i] + to_frame(now - drawn)
            };
        });
    }
}

/// A vector that is turned by as much as a normal has turned; as it is where there is none.
fn turned(vector: Vec3, before: Option<&Vec3>, after: Option<&Vec3>) -> Vec3 {
    match (before, after) {
        (Some(before), Some(after)) if before.is_normalized() && after.is_normalized() => {
            Quat::from_rotation_arc(*before, *after) * vector
        }
        _ => vector,
    }
}
