//! Cloths that may touch each other in a tick are stepped together, in *islands*.
//!
//! Each tick anew: who is near whom (`form`), the substeps in lockstep (here), and what followed for the sleep of those that touched
//! (`settle`). Islands keep nothing but room from tick to tick. Cloths that begin within each other are told of (`tell`).

pub(crate) mod form;
pub(crate) mod settle;
pub(crate) mod tell;

use bevy::prelude::*;
use bevy::tasks::ComputeTaskPool;

use crate::collider::tick_colliders::ColliderRoom;
use crate::simulation::ClothSimulation;
use crate::simulation::stage_times::{StageTimes, Timing};
use crate::simulation::tick_state::input;
use crate::solver::{Collider, Island, Member, StepInput, Zone};
use crate::step::Stepped;
use crate::step::islands::form::Candidate;

/// The islands of the tick.
#[derive(Resource, Default)]
pub(crate) struct Islands {
    /// Room for each of them, used or not.
    islands: Vec<Island>,
    /// Their cloths, island by island, each in the order of the entities.
    members: Vec<(u32, Entity)>,
    count: u32,
    /// Cloths that collide with others.
    near: Vec<Candidate>,
    /// Where these were at the end of the last tick, in the order of their entities.
    left: Vec<Candidate>,
}

impl Islands {
    /// Takes the tick of all cloths in islands, islands side by side.
    pub fn tick(&mut self, cloths: &mut Query<Stepped>, colliders: &[Collider], zones: &[Zone]) {
        let Self { islands, count, .. } = self;
        if *count == 0 {
            return;
        }
        let mut cloths = in_islands(cloths);
        let mut islands = with_mates(&mut islands[..*count as usize], &mut cloths);
        if let [island] = &mut *islands {
            return tick(island.0, island.1, colliders, zones);
        }
        ComputeTaskPool::get().scope(|scope| {
            for (island, mates) in islands {
                scope.spawn(async move { tick(island, mates, colliders, zones) });
            }
        });
    }

    /// Calls `act` with each island and its members, one after the other, without colliders.
    fn for_each(
        &mut self,
        cloths: &mut Query<Stepped>,
        mut act: impl FnMut(&mut Island, &mut [Mate]),
    ) {
        if self.count == 0 {
            return;
        }
        let mut cloths = in_islands(cloths);
        for (island, mates) in with_mates(&mut self.islands[..self.count as usize], &mut cloths) {
            act(island, mates);
        }
    }

    /// Begins the tick of all cloths in islands, for the staged form. Tells how many substeps it has at most.
    pub fn begin(
        &mut self,
        cloths: &mut Query<Stepped>,
        colliders: &[Collider],
        zones: &[Zone],
    ) -> u32 {
        let mut rounds = 0;
        self.for_each(cloths, |island, mates| {
            let substeps =
                with_members(mates, colliders, zones, |members| island.begin_tick(members));
            for mate in mates.iter_mut() {
                let tick = &mut mate.cloth.tick;
                tick.step.rounds =
                    if tick.step.runs && tick.outcome.is_none() { substeps } else { 0 };
            }
            rounds = rounds.max(substeps);
        });
        rounds
    }

    /// The third stage of all cloths in islands, for the staged form.
    pub fn correct(&mut self, cloths: &mut Query<Stepped>) {
        self.for_each(cloths, |island, mates| {
            let mut members: Vec<_> = mates
                .iter_mut()
                .map(|mate| {
                    let ClothSimulation { solver, tick, .. } = &mut *mate.cloth;
                    let mut member = Member::new(solver, StepInput::default());
                    member.moves = tick.step.rounds > 0;
                    member
                })
                .collect();
            island.correct(&mut members);
        });
    }
}

/// A cloth in an island.
struct Mate<'w> {
    island: u32,
    entity: Entity,
    cloth: Mut<'w, ClothSimulation>,
    times: Option<Mut<'w, StageTimes>>,
    /// The colliders as it meets them, where it does not meet them as they are.
    room: ColliderRoom,
}

/// The cloths in islands, island by island, each in the order of the entities.
fn in_islands<'w>(cloths: &'w mut Query<Stepped>) -> Vec<Mate<'w>> {
    let mut mates: Vec<_> = cloths
        .iter_mut()
        .filter_map(|(entity, mut cloth, times)| {
            let island = cloth.tick.step.island?;
            let room = core::mem::take(&mut cloth.tick.room);
            Some(Mate { island, entity, cloth, times, room })
        })
        .collect();
    mates.sort_unstable_by_key(|mate| (mate.island, mate.entity));
    mates
}

/// Each island with its cloths.
fn with_mates<'a, 'w>(
    islands: &'a mut [Island],
    mates: &'a mut [Mate<'w>],
) -> Vec<(&'a mut Island, &'a mut [Mate<'w>])> {
    islands.iter_mut().zip(mates.chunk_by_mut(|a, b| a.island == b.island)).collect()
}

/// Takes the tick of an island.
fn tick(island: &mut Island, mates: &mut [Mate], colliders: &[Collider], zones: &[Zone]) {
    let mut times: Vec<_> = mates.iter_mut().map(|mate| mate.times.take()).collect();
    with_members(mates, colliders, zones, |members| {
        if times.iter().all(Option::is_none) {
            return island.tick(members);
        }
        let mut timing = Timing::new();
        island.tick_observed(members, |member, stage| {
            let spent = timing.lap();
            if let Some(times) = &mut times[member] {
                times.note(stage, spent);
            }
        });
    });
    for mate in mates {
        let ClothSimulation { solver, frame, tick, .. } = &mut *mate.cloth;
        if tick.step.runs {
            frame.end_ride(solver, &tick.outcome);
        }
    }
}

/// Calls `act` with the cloths as members of an island, and keeps what came of their ticks.
fn with_members<T>(
    mates: &mut [Mate],
    colliders: &[Collider],
    zones: &[Zone],
    act: impl FnOnce(&mut [Member]) -> T,
) -> T {
    let seen: Vec<_> = mates
        .iter_mut()
        .map(|Mate { cloth, room, .. }| cloth.frame.colliders(room, colliders))
        .collect();
    let mut members = Vec::with_capacity(mates.len());
    let mut outcomes = Vec::with_capacity(mates.len());
    for (mate, seen) in mates.iter_mut().zip(&seen) {
        let ClothSimulation { solver, frame, tick, .. } = &mut *mate.cloth;
        let colliders = seen.as_deref().unwrap_or(colliders);
        let (low, high) = solver.bounds();
        let drift = frame.drift(0.5 * (low + high));
        let mut member = Member::new(solver, input(tick.step, &tick.motions, colliders, zones));
        (member.moves, member.drift) = (tick.step.runs, drift);
        members.push(member);
        outcomes.push(&mut tick.outcome);
    }
    let result = act(&mut members);
    for (member, outcome) in members.into_iter().zip(outcomes) {
        *outcome = member.outcome;
    }
    for (mate, seen) in mates.iter_mut().zip(seen) {
        mate.cloth.tick.room = match seen {
            Some(seen) => ColliderRoom::keep(seen),
            None => core::mem::take(&mut mate.room),
        };
    }
    result
}
