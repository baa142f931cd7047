//! The sleep of cloths that touched each other.

use bevy::prelude::*;

use crate::simulation::ClothSimulation;
use crate::solver::Island;
use crate::step::islands::Islands;
use crate::step::islands::form::{Candidate, root};

/// Notes, after a tick, who lies on whom: what touched a cloth that slept wakes it, and none sleeps before those that it
/// touches are ready.
pub(crate) fn settle_islands(
    mut cloths: Query<(Entity, &mut ClothSimulation)>,
    mut islands: ResMut<Islands>,
) {
    let Islands { islands, members, count, near, left } = &mut *islands;
    for (_, mut cloth) in &mut cloths {
        if cloth.tick.step.runs {
            cloth.sleep.keep_awake(false);
        }
    }
    let mut begin = 0;
    for (index, island) in islands[..*count as usize].iter().enumerate() {
        let end = members.partition_point(|&(of, _)| of as usize <= index);
        settle(island, &members[begin..end], &mut cloths, near);
        begin = end;
    }
    left.clear();
    left.extend(cloths.iter().filter_map(|(entity, cloth)| Candidate::new(entity, cloth)));
    left.sort_unstable_by_key(|cloth| cloth.entity);
}

fn settle(
    island: &Island,
    members: &[(u32, Entity)],
    cloths: &mut Query<(Entity, &mut ClothSimulation)>,
    groups: &mut Vec<Candidate>,
) {
    if island.touched().next().is_none() {
        return;
    }
    groups.clear();
    for &(_, entity) in members {
        let found = cloths.get(entity).ok().and_then(|(_, cloth)| Candidate::new(entity, cloth));
        let Some(found) = found else { return };
        groups.push(found.with_root(groups.len()));
    }
    for [a, b] in island.touched() {
        match (groups[a].runs, groups[b].runs) {
            (true, true) => {
                let (one, other) = (root(groups, a), root(groups, b));
                groups[one.max(other)].root = one.min(other);
            }
            (moves, _) => {
                let still = groups[if moves { b } else { a }].entity;
                if let Ok((_, mut cloth)) = cloths.get_mut(still)
                    && cloth.is_asleep()
                {
                    cloth.sleep.disturb();
                }
            }
        }
    }
    for place in 0..groups.len() {
        let of = root(groups, place);
        let is_ready = |it: &Candidate| cloths.get(it.entity).is_ok_and(|it| it.1.sleep.is_ready());
        let mates = (0..groups.len()).filter(|&other| root(groups, other) == of);
        let kept_awake = mates.map(|mate| &groups[mate]).any(|mate| mate.runs && !is_ready(mate));
        if let Ok((_, mut cloth)) = cloths.get_mut(groups[place].entity) {
            cloth.sleep.keep_awake(kept_awake);
        }
    }
}
