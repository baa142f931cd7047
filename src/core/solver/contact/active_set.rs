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
//! go what is pulled off. A particle that begins or ceases to touch is so corrected once as what it was. That
//! does no work, as a particle that is held does none.
//!
//! Friction is applied after the corrections, too, and undoes what a correction that knows nothing of it does to a particle that
//! sticks: the springs beside it are left stretched. So along the surface the mobility is `w s`, where the slip `s` is less
//! than one for a particle that carries a load and sticks (`Pushed::slip`, `friction`). Two states, one that sticks and one that slides,
//! would not do: the corrections come to another end in each, particles at Coulomb's limit change from one to the other in
//! every substep, and the cloth trembles. For the same reason slips follow with a delay.
//!
//! What corrections pull at a particle and do not move is a pull all the same, and is carried on (`integrate::houbolt`) with the mobility
//! that it was followed with. Momentum is accounted for to the last part: `impulses`.

use bevy_math::Vec3;

use crate::solver::contact::collider::Collider;
use crate::solver::contact::edges::EdgeMemory;
use crate::solver::contact::impulses::{Impulses, Share};
use crate::solver::contact::keys::Keys;
use crate::solver::simd::block::{
    Block, Block3, Blocks, Blocks3, Blocks3Mut, BlocksMut, LANES, larger,
};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::slots::CutAt;
use crate::solver::simd::soa::{Array, Soa, ValuesMut};

/// Least part of the inverse masses of a spring's ends that a correction divides by: what holds both ends would else
/// be pulled at without bound.
pub(crate) const LEAST_MOBILITY: f32 = 0.2;

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
    /// A particle's displacement before anything pulled at it, by slot \[m\].
    pub unpulled: Soa,
    /// What of the pulls that were carried on has been left out for good, by slot \[m\]; known where a
    /// collider is measured.
    pub dropped: Soa,
    /// What the cloth gives to colliders.
    pub impulses: Impulses,
    /// What a particle's displacement lost along the normal before the corrections, by slot \[m\].
    pub lost: Array,
    /// What pulls at a particle along the normal without moving it, as the correction of one of inverse mass one, by
    /// slot \[m kg\].
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
}

impl Normals {
    fn new(slots: usize) -> Self {
        let mut slip = Array::zeros(slots);
        slip.fill(1.0);
        Self { any: false, blocks: vec![false; slots / LANES], normal: Soa::zeros(slots), slip }
    }

    /// Forgets all of them.
    pub fn clear(&mut self) {
        for (block, touches) in self.blocks.iter_mut().enumerate() {
            if core::mem::take(touches) {
                Block3::ZERO.store(&mut self.normal, block * LANES);
                Block::splat(1.0).store(&mut self.slip, block * LANES);
            }
        }
        self.any = false;
    }

    /// Makes all of them give way: a particle that lay on a surface is held by none, and is heavy instead.
    pub fn give_way(&mut self) {
        for (block, &touches) in self.blocks.iter().enumerate() {
            if !touches {
                continue;
            }
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
            unpulled: Soa::zeros(slots),
            dropped: Soa::zeros(slots),
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

    /// Begins a tick with these colliders: what is known of those of the last one goes with them to their places.
    pub fn begin_tick(&mut self, colliders: &[Collider<'_>]) {
        if self.keys.go_on(colliders) {
            let place = |collider| self.keys.place(collider);
            self.edges.renumber(place);
            self.impulses.renumber(colliders.len(), place);
            for holder in &mut *self.holder {
                *holder = place(*holder as usize).unwrap_or(usize::MAX) as f32;
            }
        }
        self.impulses.begin_tick(colliders);
    }

    /// Forgets what the particle of a slot lies on.
    pub fn forget(&mut self, slot: usize) {
        for normals in [&mut self.now, &mut self.before] {
            normals.normal.set(slot, Vec3::ZERO);
            normals.slip[slot] = 1.0;
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

    /// What corrections need to know of it, and where they put its load; `None` where nothing touches.
    pub fn contacts(&mut self) -> Option<Contacts<'_>> {
        self.now.any.then(|| Contacts { normals: &self.now, load: ValuesMut::all(&mut self.load) })
    }
}

/// The active set as corrections see it.
pub(crate) struct Contacts<'a> {
    pub normals: &'a Normals,
    /// Of the slots that a band corrects.
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

/// What of the pulls at particles moves them, and their load, for normals `n`.
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

/// Begins the corrections of a substep: lets the particles of the active set go only where they can, with their
/// surface.
pub(crate) struct HoldOnto<'a> {
    pub set: &'a mut ActiveSet,
    pub inverse_mass: &'a [f32],
    /// Length of the substep \[s\].
    pub step: f32,
    pub d: &'a mut Soa,
    /// What is carried on of the pulls in the substep before (`integrate::houbolt`), less the displacements; `None` where nothing
    /// is.
    pub carried: Option<&'a Soa>,
}

impl Kernel for HoldOnto<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { set, inverse_mass, step, d, carried } = self;
        let measures = set.impulses.are_measured();
        let ActiveSet { now, before, velocity, unpulled, dropped, lost, load, .. } = set;
        let count = now.blocks.len();
        let (normals, slips) =
            (Blocks3::new(&now.normal, 0, count), Blocks::new(&now.slip, 0, count));
        let (normals_before, slips_before) =
            (Blocks3::new(&before.normal, 0, count), Blocks::new(&before.slip, 0, count));
        let velocities = Blocks3::new(velocity, 0, count);
        let masses = Blocks::new(inverse_mass, 0, count);
        let mut ds = Blocks3Mut::new(d, 0, count);
        let mut unpulleds = Blocks3Mut::new(unpulled, 0, count);
        let mut losts = BlocksMut::new(lost, 0, count);
        let mut loads = BlocksMut::new(load, 0, count);
        #[expect(
            clippy::manual_map,
            reason = "a closure that is not inlined keeps the baseline's instructions"
        )]
        let carried = match carried {
            Some(carried) => Some(Blocks3::new(carried, 0, count)),
            None => None,
        };
        for (block, &touches) in now.blocks.iter().enumerate() {
            if !touches {
                continue;
            }
            let (n, before) = (normals.at(block), normals_before.at(block));
            let (w, velocity) = (masses.at(block), velocities.at(block));
            let (slip, slip_before) = (slips.at(block), slips_before.at(block));
            let mut moved = ds.at(block);
            let carried = match &carried {
                Some(carried) => carried.at(block).plus(&moved),
                None => Block3::ZERO,
            };
            let (mut lost, mut load) = (Block::ZERO, Block::ZERO);
            let (mut goes, mut unpulled) = (Block3::ZERO, Block3::ZERO);
            for i in 0..LANES {
                // What did not follow a pull in the substep before is not moved by what is carried on of it. That is
                // a load all the same.
                let (before, carried) = (before.at(i), carried.at(i));
                let borne = before.dot(carried);
                let held = slip_before.0[i] / slip.0[i];
                let held = if held < 1.0 { held } else { 1.0 };
                load.0[i] = borne / w.0[i];
                goes.set(i, (carried - before * borne) * held);
            }
            if measures {
                let mut left_out = Block3::ZERO;
                for i in 0..LANES {
                    let borne = before.at(i).dot(carried.at(i));
                    left_out.set(i, carried.at(i) - goes.at(i) - n.at(i) * borne);
                }
                left_out.store(dropped, block * LANES);
            }
            for i in 0..LANES {
                let (n, along) = (n.at(i), goes.at(i));
                let is_free = n.dot(n) == 0.0 || w.0[i] == 0.0;
                let own = moved.at(i) - carried.at(i);
                let surface = velocity.at(i) * step;
                lost.0[i] = if is_free { 0.0 } else { n.dot(own + along - surface) };
                load.0[i] = if is_free { 0.0 } else { load.0[i] };
                let along = along - n * n.dot(along);
                let own = own + n * n.dot(surface - own);
                unpulled.set(i, own);
                moved.set(i, if is_free { moved.at(i) } else { own + along * slip.0[i] });
            }
            ds.set(block, moved);
            losts.set(block, lost);
            loads.set(block, load);
            unpulleds.set(block, unpulled);
        }
    }
}

/// Adds what pulled at the particles of the active set without moving them to the pulls, or takes it away.
pub(crate) struct NoteUnfollowed<'a> {
    pub set: &'a ActiveSet,
    pub inverse_mass: &'a [f32],
    pub d: &'a Soa,
    /// One or minus one.
    pub part: f32,
    pub pull: &'a mut Soa,
}

impl Kernel for NoteUnfollowed<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { set, inverse_mass, d, part, pull } = self;
        for (block, &touches) in set.now.blocks.iter().enumerate() {
            if !touches {
                continue;
            }
            let slot = block * LANES;
            let (n, w) = (Block3::load(&set.now.normal, slot), Block::load(inverse_mass, slot));
            let (load, slip) = (Block::load(&set.load, slot), Block::load(&set.now.slip, slot));
            let (d, unpulled) = (Block3::load(d, slot), Block3::load(&set.unpulled, slot));
            let mut noted = Block3::load(&*pull, slot);
            for i in 0..LANES {
                let n = n.at(i);
                let pulled = d.at(i) - unpulled.at(i);
                let slid = pulled - n * n.dot(pulled);
                let unfollowed = n * (load.0[i] * w.0[i]) + slid * (1.0 / slip.0[i] - 1.0);
                let unfollowed = if n.dot(n) > 0.0 { unfollowed } else { Vec3::ZERO };
                noted.set(i, noted.at(i) + unfollowed * part);
            }
            noted.store(pull, slot);
        }
    }
}

/// How far what is let go follows what pulled it onto its surface, where it leaves that by itself: no further than back \[m\].
#[inline(always)]
fn followed(lost: f32, pulled: f32) -> f32 {
    let back = -larger(lost, 0.0);
    let onto = if pulled < 0.0 { pulled } else { 0.0 };
    larger(onto, back)
}

/// Ends contact: lets go what lay on a collider and was found to touch none any more. It goes on without what pulled at
/// it while it was held.
pub(crate) struct LetGo<'a> {
    pub set: &'a ActiveSet,
    pub inverse_mass: &'a [f32],
    pub d: &'a mut Soa,
    /// Pulls noted in the substep, where any are.
    pub pull: Option<&'a mut Soa>,
}

impl Kernel for LetGo<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { set, inverse_mass, d, mut pull } = self;
        let count = set.now.blocks.len();
        let (losts, loads) = (Blocks::new(&set.lost, 0, count), Blocks::new(&set.load, 0, count));
        for (block, &touched) in set.now.blocks.iter().enumerate() {
            if !touched {
                continue;
            }
            let (lost, load) = (losts.at(block), loads.at(block));
            // What goes on touching has been let go by what met it.
            if !lost.is_any() && !load.is_any() {
                continue;
            }
            let slot = block * LANES;
            let (n, w) = (Block3::load(&set.now.normal, slot), Block::load(inverse_mass, slot));
            let mut moved = Block3::load(d, slot);
            for i in 0..LANES {
                // What is pulled off does not fall back.
                let leaves = larger(lost.0[i], 0.0);
                let followed = followed(lost.0[i], load.0[i] * w.0[i]);
                moved.set(i, moved.at(i) + n.at(i) * (leaves + followed));
            }
            moved.store(d, slot);
            if let Some(pull) = &mut pull {
                // That it did not fall through its surface was no pull.
                let mut noted = Block3::load(&**pull, slot);
                for i in 0..LANES {
                    let fallen = if lost.0[i] < 0.0 { lost.0[i] } else { 0.0 };
                    noted.set(i, noted.at(i) + n.at(i) * fallen);
                }
                noted.store(&mut **pull, slot);
            }
        }
    }
}

impl ActiveSet {
    /// Gives colliders what they took of pulls that [`HoldOnto`] left out, in a substep of length `step`.
    pub fn give_left_out(&mut self, inverse_mass: &[f32], step: f32) {
        let mut impulses = core::mem::take(&mut self.impulses);
        impulses.give(self.left_out(inverse_mass), step);
        self.impulses = impulses;
    }

    fn left_out<'a>(&'a self, inverse_mass: &'a [f32]) -> impl Iterator<Item = Share> + 'a {
        self.held_slots(inverse_mass).map(|(slot, w)| {
            let dropped = self.dropped.get(slot) / w;
            Share { collider: self.holder[slot] as usize, given: dropped, owed: dropped }
        })
    }

    /// Gives colliders what they took of what they have let go, in a substep of length `step`. Where pulls are noted, those
    /// that did not move it are not.
    pub fn give_taken(&mut self, inverse_mass: &[f32], d: &Soa, notes: bool, step: f32) {
        let mut impulses = core::mem::take(&mut self.impulses);
        impulses.give(self.taken(inverse_mass, d, notes), step);
        self.impulses = impulses;
    }

    fn taken<'a>(
        &'a self,
        inverse_mass: &'a [f32],
        d: &'a Soa,
        notes: bool,
    ) -> impl Iterator<Item = Share> + 'a {
        self.held_slots(inverse_mass).filter_map(move |(slot, w)| {
            let (load, lost, n) = (self.load[slot], self.lost[slot], self.now.normal.get(slot));
            let is_let_go = load != 0.0 || lost != 0.0;
            let fallen = if lost < 0.0 { lost } else { 0.0 };
            let pulled = d.get(slot) - self.unpulled.get(slot);
            let slid = pulled - n * n.dot(pulled);
            let unslipped = slid * (1.0 / self.now.slip[slot] - 1.0);
            let unfollowed = n * (load - followed(lost, load * w) / w) + unslipped / w;
            let owed = if notes { unfollowed } else { Vec3::ZERO };
            let given = unfollowed + n * (fallen / w);
            is_let_go.then(|| Share { collider: self.holder[slot] as usize, given, owed })
        })
    }

    /// Slots of the particles that are held, and their inverse masses.
    fn held_slots<'a>(
        &'a self,
        inverse_mass: &'a [f32],
    ) -> impl Iterator<Item = (usize, f32)> + 'a {
        let blocks = self.now.blocks.iter().enumerate().filter(|&(_, &touched)| touched);
        let slots = blocks.flat_map(|(block, _)| block * LANES..(block + 1) * LANES);
        let all = slots.map(|slot| (slot, inverse_mass[slot]));
        all.filter(|&(slot, w)| w > 0.0 && self.now.normal.get(slot) != Vec3::ZERO)
    }
}
