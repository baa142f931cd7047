//! Which cloths may touch each other in a tick.

use bevy::prelude::*;

use crate::simulation::ClothSimulation;
use crate::simulation::tick_state::ClothStep;
use crate::solver::Island;
use crate::step::islands::Islands;

/// A cloth that collides with others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    pub entity: Entity,
    layers: u32,
    low: Vec3,
    high: Vec3,
    /// How far from there it may touch others in the tick \[m\].
    reach: f32,
    /// Whether it takes the tick.
    pub runs: bool,
    /// Whether it did not take the last one.
    begins: bool,
    /// The first of the cloths that it is together with, by their places.
    pub root: usize,
}

impl Candidate {
    pub fn new(entity: Entity, cloth: &ClothSimulation) -> Option<Self> {
        let layers = cloth.solver.inter_collision()?.layers;
        if cloth.is_hanging() {
            return None;
        }
        let (low, high) = cloth.solver.bounds();
        let ClothStep { runs, begins, .. } = cloth.tick.step;
        Some(Self { entity, layers, low, high, reach: 0.0, runs, begins, root: 0 })
    }

    /// The same, of a group that begins with one.
    pub fn with_root(self, root: usize) -> Self {
        Self { root, ..self }
    }

    /// Whether it may touch another.
    fn is_near(&self, other: &Self) -> bool {
        let reach = self.reach + other.reach;
        let gap = (self.low - other.high).max(other.low - self.high).max_element();
        self.layers & other.layers != 0 && gap <= reach
    }

    /// Whether it is where, and how, it was.
    fn is_like(&self, other: &Self) -> bool {
        (self.layers, self.low, self.high) == (other.layers, other.low, other.high)
    }
}

/// Finds out which cloths may touch others in this tick. Wakes what sleeps where one has gone, come or been put elsewhere since
/// the last tick.
pub(crate) fn form_islands(
    mut cloths: Query<(Entity, &mut ClothSimulation)>,
    mut islands: ResMut<Islands>,
) {
    let Islands { islands, members, count, near, left } = &mut *islands;
    near.clear();
    for (entity, cloth) in &cloths {
        if let Some(found) = Candidate::new(entity, cloth) {
            let ClothStep { dt, gravity, .. } = cloth.tick.step;
            // What stands still has its balls alone.
            let dt = if found.runs { dt } else { 0.0 };
            let reach = cloth.solver.reach_of_tick(dt, gravity).unwrap_or_default();
            let led = if found.runs { cloth.tick.way_of_pins() } else { 0.0 };
            let ride = cloth.frame.drift(0.5 * (found.low + found.high)).length();
            near.push(Candidate { reach: reach + led + ride, ..found });
        }
    }
    members.clear();
    *count = 0;
    if near.len() < 2 && left.len() < 2 {
        left.clear();
        return;
    }
    wake_neighbours(&mut cloths, near, left);
    join(near);
    members.extend(near.iter().map(|cloth| (cloth.root as u32, cloth.entity)));
    members.sort_unstable();
    *count = number(members);
    if islands.len() < *count as usize {
        islands.resize_with(*count as usize, Island::default);
    }
    for &(island, entity) in &*members {
        if let Ok((_, mut cloth)) = cloths.get_mut(entity) {
            cloth.tick.step.island = Some(island);
        }
    }
}

/// Joins cloths that may touch, where one of both moves: each knows the first of those that it is together with.
fn join(near: &mut [Candidate]) {
    near.sort_unstable_by(|a, b| {
        (a.low.x - a.reach).total_cmp(&(b.low.x - b.reach)).then(a.entity.cmp(&b.entity))
    });
    for (place, cloth) in near.iter_mut().enumerate() {
        cloth.root = place;
    }
    for a in 0..near.len() {
        let end = near[a].high.x + near[a].reach;
        for b in a + 1..near.len() {
            if near[b].low.x - near[b].reach > end {
                break;
            }
            if (near[a].runs || near[b].runs) && near[a].is_near(&near[b]) {
                let (one, other) = (root(near, a), root(near, b));
                near[one.max(other)].root = one.min(other);
            }
        }
    }
    for place in 0..near.len() {
        near[place].root = root(near, place);
    }
}

pub(super) fn root(near: &[Candidate], mut place: usize) -> usize {
    while near[place].root != place {
        place = near[place].root;
    }
    place
}

/// Numbers islands in the order of their roots, and leaves out cloths that are alone. Tells how many islands there are.
fn number(members: &mut Vec<(u32, Entity)>) -> u32 {
    let (mut count, mut kept, mut begin) = (0, 0, 0);
    while begin < members.len() {
        let root = members[begin].0;
        let end = begin + members[begin..].partition_point(|&(of, _)| of == root);
        if end - begin > 1 {
            for at in begin..end {
                members[kept] = (count, members[at].1);
                kept += 1;
            }
            count += 1;
        }
        begin = end;
    }
    members.truncate(kept);
    count
}

/// Wakes cloths that sleep near where another has come or gone without a tick, or begins to take ticks.
fn wake_neighbours(
    cloths: &mut Query<(Entity, &mut ClothSimulation)>,
    near: &mut [Candidate],
    left: &[Candidate],
) {
    near.sort_unstable_by_key(|cloth| cloth.entity);
    let place = |all: &[Candidate], of: Entity| all.binary_search_by_key(&of, |it| it.entity).ok();
    let moved = near.iter().filter_map(|now| {
        let was = &left[place(left, now.entity)?];
        (!was.is_like(now)).then_some([was, now])
    });
    let gone = left.iter().filter(|was| place(near, was.entity).is_none());
    // What wakes, or is let go, takes with it what lay on it.
    let begin = near.iter().filter(|now| now.begins);
    for happened in moved.flatten().chain(gone).chain(begin) {
        for sleeper in near.iter().filter(|it| !it.runs && it.entity != happened.entity) {
            let grown = Candidate { reach: sleeper.reach + ROOM, ..*sleeper };
            if grown.is_near(happened)
                && let Ok((_, mut cloth)) = cloths.get_mut(sleeper.entity)
            {
                cloth.sleep.disturb();
            }
        }
    }
}

/// How near something has to happen to a cloth that sleeps for it to wake, beside its reach \[m\].
const ROOM: f32 = 0.05;
