//! The active set of contact: which particles lie on a collider, and which way its surface faces there.
//!
//! A correction that knows nothing of a contact moves the particle into the collider, contact moves it out again, and
//! what the correction was to do for the springs is lost: around a point that carries a whole cloth they would
//! stretch without end. So corrections see a particle of the active set with the mobility that it has on its
//! surface, `w (1 - n n^T)` in place of its inverse mass `w`, where `n` is the normal (Baraff and Witkin 1998, *Large
//! Steps in Cloth Simulation*, section 5.1). Threads and contact are solved together in this way.
//!
//! The set is that of the substep before. What corrections pull at its particles along the normal moves nothing, and
//! is summed up as their load. At the substep's end contact uses it with what contact itself undoes: for friction, and to let
//! go what is pulled off. The active set lags by one substep: a particle that has just
//! made or lost contact is corrected once with its mobility of before. That does no work, as a particle that is held does none.
//!
//! Friction is applied after the corrections, too, and undoes what a correction that knows nothing of it does to a particle that
//! sticks: the springs beside it are left stretched. So along the surface the mobility is `w s`, where the slip `s` is less
//! than one for a particle that carries a load and sticks (`Pushed::slip`, `friction`). Two states, one that sticks and one that slides,
//! would not do: the corrections come to another end in each, particles at Coulomb's limit change from one to the other in
//! every substep, and the cloth trembles. For the same reason slips follow with a delay.
//!
//! A pull of corrections that does not move its particle is a pull all the same, and is carried on (`integrate::houbolt`)
//! with the mobility that it was followed with. Momentum is accounted for to the last part: `impulses`.

use bevy_math::Vec3;

use crate::solver::contact::collider::Collider;
use crate::solver::contact::edges::memory::EdgeMemory;
use crate::solver::contact::impulses::Impulses;
use crate::solver::contact::keys::Keys;
use crate::solver::contact::touching::Touching;
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::flags::raised;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::slots::CutAt;
use crate::solver::simd::soa::{Array, Soa, ValuesMut};

/// Least part of the inverse masses of a spring's ends that a correction divides by: what holds both ends would else
/// be pulled at without bound.
pub(crate) const LEAST_MOBILITY: f32 = 0.2;
/// Square of a normal's length below which it is that of a body which yields.
const YIELDS: f32 = 0.9999;
/// Mass of the lightest body that a cloth meets, beside that of one of its particles: it would only be thrown about by one.
const LIGHTEST: f32 = 0.5;
/// Part of its inverse mass that moves what is pushed out of a collider for more than a substep.
const GIVING: f32 = 0.1;

/// Particles that lie on colliders, from substep to substep.
#[derive(Clone, Debug)]
pub(crate) struct ActiveSet {
    /// As the present corrections see it.
    pub now: Normals,
    /// As those of the substep before saw it.
    pub before: Normals,
    /// As those of the next substep are to see it.
    pub next: Normals,
    /// The memory of contact of edges.
    pub edges: EdgeMemory,
    /// The colliders of the tick.
    pub keys: Keys,
    /// Velocity of the surface that a particle lies on, by slot \[m/s\].
    pub velocity: Soa,
    /// The collider that a particle lies on, by slot: its index.
    pub holder: Array,
    /// Approach to a body that contact has undone in this substep, outward, by slot \[m\]; zero once it has answered.
    pub pressed: Soa,
    /// Room for the particles that a body answers to.
    pub answering: Vec<Touching>,
    /// A particle's displacement before any correction, by slot \[m\].
    pub unpulled: Soa,
    /// Part of the pulls carried on that was left out for good, by slot \[m\]; known where a collider is measured.
    pub dropped: Soa,
    /// Displacement of a particle in this substep by corrections that are no pulls, by slot \[m\]; known where a collider is measured.
    pub mended: Soa,
    /// Momentum that the cloth gives to colliders.
    pub impulses: Impulses,
    /// Displacement along the normal that was taken before the corrections, by slot \[m\].
    pub lost: Array,
    /// Pull at a particle along the normal that does not move it, as the correction of a particle of inverse mass one,
    /// by slot \[m kg\].
    pub load: Array,
}

/// Normals of the surfaces that particles lie on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Normals {
    /// Whether there are any.
    pub any: bool,
    /// Whether a block has any, or particles that give way.
    pub blocks: Vec<bool>,
    /// By slot, of length one; zero where a particle lies on none.
    pub normal: Soa,
    /// By slot, the part of its inverse mass that moves a particle along the surface; less than one where friction holds
    /// it.
    pub slip: Array,
    /// By slot, the part of its way along the surface that friction left a particle, 0 where it stuck; 1 where it lies on none.
    pub loose: Array,
}

impl Normals {
    fn new(slots: usize) -> Self {
        let mut slip = Array::zeros(slots);
        slip.fill(1.0);
        let loose = slip.clone();
        let blocks = vec![false; slots / LANES];
        Self { any: false, blocks, normal: Soa::zeros(slots), slip, loose }
    }

    /// Forgets all of them.
    pub fn clear(&mut self) {
        for block in raised(&self.blocks) {
            Block3::ZERO.store(&mut self.normal, block * LANES);
            Block::splat(1.0).store(&mut self.slip, block * LANES);
            Block::splat(1.0).store(&mut self.loose, block * LANES);
        }
        self.blocks.fill(false);
        self.any = false;
    }

    /// Makes all of them give way: a particle that lay on a surface is held by none, and is heavy instead.
    pub fn give_way(&mut self) {
        for block in raised(&self.blocks) {
            let slot = block * LANES;
            let normal = Block3::load(&self.normal, slot);
            let mut slip = Block::load(&self.slip, slot);
            for i in 0..LANES {
                slip.0[i] = if normal.at(i) != Vec3::ZERO { GIVING } else { slip.0[i] };
            }
            slip.store(&mut self.slip, slot);
            Block3::ZERO.store(&mut self.normal, slot);
        }
    }

    /// Says which blocks have any, where the normals have been set otherwise.
    pub fn find(&mut self) {
        for (block, touches) in self.blocks.iter_mut().enumerate() {
            let normal = Block3::load(&self.normal, block * LANES);
            let slip = Block::load(&self.slip, block * LANES);
            *touches = (0..LANES).any(|i| normal.at(i) != Vec3::ZERO || slip.0[i] != 1.0);
        }
        self.any = self.blocks.contains(&true);
    }

    /// Whether any of some blocks has any.
    #[inline(always)]
    pub fn touch(&self, first: usize, count: usize, hop: usize) -> bool {
        self.any && self.blocks[first..first + count].iter().step_by(hop).any(|&touches| touches)
    }
}

impl ActiveSet {
    pub fn new(slots: usize) -> Self {
        let normals = Normals::new(slots);
        Self {
            now: normals.clone(),
            before: normals.clone(),
            next: normals,
            edges: EdgeMemory::new(),
            keys: Keys::default(),
            velocity: Soa::zeros(slots),
            pressed: Soa::zeros(slots),
            answering: Vec::new(),
            unpulled: Soa::zeros(slots),
            dropped: Soa::zeros(slots),
            mended: Soa::zeros(slots),
            impulses: Impulses::default(),
            holder: Array::zeros(slots),
            lost: Array::zeros(slots),
            load: Array::zeros(slots),
        }
    }

    /// Forgets all contact.
    pub fn clear(&mut self) {
        self.now.clear();
        self.before.clear();
        self.next.clear();
        self.edges.clear();
    }

    /// Begins a tick with these colliders: what is known of those of the last one goes with them to their places. `particle` is the
    /// mass of a particle in the mean \[kg\]. The tick takes `dt` \[s\].
    pub fn begin_tick(&mut self, colliders: &[Collider<'_>], origin: Vec3, particle: f32, dt: f32) {
        if self.keys.go_on(colliders) {
            let place = |collider| self.keys.place(collider);
            self.edges.renumber(place);
            self.impulses.renumber(colliders.len(), place);
            for holder in &mut *self.holder {
                *holder = place(*holder as usize).unwrap_or(usize::MAX) as f32;
            }
        }
        self.impulses.begin_tick(colliders, origin, LIGHTEST * particle, dt);
        if colliders.iter().any(|collider| collider.mobility.is_some()) {
            self.answering.clear();
            self.answering.reserve(self.now.blocks.len());
        }
    }

    /// Whether nothing lies on any collider.
    pub fn is_empty(&self) -> bool {
        !self.now.any && self.edges.warm.is_empty()
    }

    /// Whether any particle, edge or face lies on such a collider.
    pub fn touches(&self, layout: Layout, is_it: impl Fn(usize) -> bool) -> bool {
        let lies = |slot: usize| {
            self.now.normal.get(slot) != Vec3::ZERO && is_it(self.holder[slot] as usize)
        };
        layout.slots().any(lies) || self.edges.warm.iter().any(|edge| is_it(edge.collider as usize))
    }

    /// Forgets what the particle of a slot lies on.
    pub fn forget(&mut self, slot: usize) {
        for normals in [&mut self.now, &mut self.before] {
            normals.normal.set(slot, Vec3::ZERO);
            normals.slip[slot] = 1.0;
            normals.loose[slot] = 1.0;
        }
    }

    /// Goes on to the next substep.
    pub fn turn(&mut self) {
        self.edges.end_substep();
        core::mem::swap(&mut self.before, &mut self.now);
        core::mem::swap(&mut self.now, &mut self.next);
        self.now.any = self.now.blocks.contains(&true);
        self.next.clear();
    }

    /// The active set as corrections read it, and the array of loads that they write; `None` where nothing touches.
    pub fn contacts(&mut self) -> Option<Contacts<'_>> {
        self.now.any.then(|| Contacts { normals: &self.now, load: ValuesMut::all(&mut self.load) })
    }
}

/// The active set as corrections see it.
pub(crate) struct Contacts<'a> {
    pub normals: &'a Normals,
    /// Loads of the slots that a band corrects.
    pub load: ValuesMut<'a>,
}

impl CutAt for Contacts<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        let (load, below) = self.load.cut(slot);
        (Self { normals: self.normals, load }, Self { normals: self.normals, load: below })
    }
}

impl Contacts<'_> {
    /// The same, for a while.
    pub fn reborrow(&mut self) -> Contacts<'_> {
        Contacts { normals: self.normals, load: self.load.reborrow() }
    }

    /// Adds the load of pulls to a block.
    #[inline(always)]
    pub fn add(&mut self, slot: usize, load: &Block) {
        self.load.add(slot, load);
    }
}

/// The part of what corrections moved a particle by that its slip is about, where the normal `n` is that of its surface: the part
/// along the surface. On a body that yields, which has a shorter normal, they move it across the surface too.
#[inline(always)]
pub(crate) fn slipped(pulled: Vec3, n: Vec3) -> Vec3 {
    let along = pulled - n * n.dot(pulled);
    if n.dot(n) < YIELDS { pulled } else { along }
}

/// Divides pulls at particles into the part along their surfaces of normals `n`, which moves them, and the load.
#[inline(always)]
pub(crate) fn divide(pull: &Block3, n: &Block3) -> (Block3, Block) {
    let (mut along, mut load) = (Block3::ZERO, Block::ZERO);
    for i in 0..LANES {
        let (pull, n) = (pull.at(i), n.at(i));
        load.0[i] = n.dot(pull);
        along.set(i, pull - n * load.0[i]);
    }
    (along, load)
}
