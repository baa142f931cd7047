//! Which level of detail each cloth is at, and whether all of them together take too long.

use bevy::math::FloatOrd;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy::time::Virtual;

use crate::cloth::lod::{ClothBudget, ClothLevel, ClothLod};
use crate::cloth::proxy::ClothProxy;
use crate::cloth::settings::ClothSettings;
use crate::error::ClothComponent;
use crate::error::failures::Failures;
use crate::pose::pose_now;
use crate::simulation::ClothSimulation;
use crate::simulation::attachments::Anchor;

/// The part of its distance at which a level is left for a lower one.
const BACK: f32 = 0.85;
/// The part of the budget below which levels come back.
const EASE: f32 = 0.8;
/// Time between two changes of what the budget raises \[s\].
const PATIENCE: f32 = 0.25;
/// The weight of a frame in what is measured.
const FRESH: f32 = 0.1;

/// The level of a cloth.
#[derive(Clone, Default)]
pub(crate) struct Lod {
    in_force: Option<ClothLod>,
    /// 0 is all of it; else one more than the index in the list.
    level: usize,
    /// Has changed, and has not been applied.
    changed: bool,
}

/// The clock of the budget.
#[derive(Default)]
pub(crate) struct Clock {
    /// Since the last change \[s\].
    since: f32,
    /// A time that cannot be used has been told of.
    is_told: bool,
    /// Room to order the cloths in.
    order: Vec<(FloatOrd, Entity)>,
}

/// When this frame's ticks began, and how long they have taken.
#[derive(Resource, Default)]
pub(crate) struct Spent {
    start: Option<Instant>,
    seconds: f32,
}

impl Lod {
    fn of_level(&self) -> Option<&ClothLevel> {
        self.in_force.as_ref()?.levels.get(self.level.checked_sub(1)?)
    }

    /// The proxy of the level, or the component's.
    pub fn proxy<'a>(&'a self, own: Option<&'a ClothProxy>) -> Option<&'a ClothProxy> {
        self.of_level().and_then(|level| level.proxy.as_ref()).or(own)
    }

    /// The component's settings, as the level has them.
    pub fn settings(&self, own: ClothSettings) -> ClothSettings {
        let substeps = self.of_level().and_then(|level| level.substeps);
        ClothSettings { substeps: substeps.unwrap_or(own.substeps), ..own }
    }

    /// Whether it has changed since it was last asked.
    pub fn take_changed(&mut self) -> bool {
        core::mem::take(&mut self.changed)
    }

    /// The level that a cloth is given before it is set up; all of it where none is.
    pub fn given(asked: Option<&ClothLod>) -> Self {
        let mut lod = Self::default();
        if let Some(asked) = asked.filter(|asked| asked.validate().is_ok()) {
            lod.set(asked);
            lod.go_to_given();
        }
        lod
    }

    /// The same level for a cloth that is made anew.
    pub fn anew(&self) -> Self {
        Self { changed: self.in_force.is_some(), ..self.clone() }
    }

    /// The level by a distance, with the present one in mind.
    fn by_distance(&self, distance: f32) -> usize {
        let Some(ClothLod { levels, .. }) = &self.in_force else { return 0 };
        let mut level = self.level.min(levels.len());
        while levels.get(level).is_some_and(|next| distance > next.distance) {
            level += 1;
        }
        while level > 0 && distance < BACK * levels[level - 1].distance {
            level -= 1;
        }
        level
    }

    fn set(&mut self, asked: &ClothLod) {
        if self.in_force.as_ref() != Some(asked) {
            self.in_force = Some(asked.clone());
            self.changed = true;
        }
    }

    /// Whether another shape would be simulated at this level.
    fn has_other_proxy(&self, level: usize) -> bool {
        let levels = self.in_force.as_ref().map_or(&[][..], |lod| &lod.levels);
        let proxy = |level: usize| levels.get(level.checked_sub(1)?)?.proxy.as_ref();
        proxy(level) != proxy(self.level)
    }

    /// The level nearest to another one at which the same shape is simulated as at the present.
    fn nearest_of_this_shape(&self, wanted: usize) -> usize {
        let most = self.in_force.as_ref().map_or(0, |lod| lod.levels.len());
        let same = (0..=most).filter(|level| !self.has_other_proxy(*level));
        same.min_by_key(|level| level.abs_diff(wanted)).unwrap_or(self.level)
    }

    fn go_to_given(&mut self) {
        if let Some(ClothLod { given: Some(given), levels }) = &self.in_force {
            self.go_to((*given as usize).min(levels.len()));
        }
    }

    fn go_to(&mut self, level: usize) {
        self.changed |= level != self.level;
        self.level = level;
    }
}

/// Takes over what is asked for, and the levels that are given: in a tick, so that they are in force from that tick on.
pub(crate) fn take_levels(
    mut cloths: Query<(Entity, &mut ClothSimulation, Option<&ClothLod>)>,
    mut failures: Failures,
) {
    for (entity, mut cloth, asked) in &mut cloths {
        let Some(asked) = asked else {
            if cloth.lod.in_force.is_some() {
                cloth.lod = Lod { changed: true, ..default() };
            }
            continue;
        };
        let outcome = asked.validate().map(|()| cloth.lod.set(asked));
        failures.tell_numbers(entity, ClothComponent::ClothLod, outcome);
        cloth.lod.go_to_given();
    }
}

/// Chooses the levels that go by distance, once a frame and before its ticks.
pub(crate) fn choose_levels(
    mut cloths: Query<(Entity, &mut ClothSimulation, &ClothLod)>,
    transforms: TransformHelper,
    views: Query<(&Camera, &GlobalTransform)>,
    mut budget: Option<ResMut<ClothBudget>>,
    mut spent: ResMut<Spent>,
    time: Option<Res<Time<Virtual>>>,
    mut clock: Local<Clock>,
) {
    let seconds = core::mem::take(&mut spent.seconds);
    clock.order.clear();
    let active = views.iter().filter(|(camera, _)| camera.is_active);
    let eyes: Vec<_> = active.map(|(_, place)| place.translation()).collect();
    for (entity, cloth, asked) in &cloths {
        if asked.given.is_none() {
            let place = cloth.place_of_leader(&transforms);
            let far = |eye: &Vec3| eye.distance(place);
            let distance = eyes.iter().map(far).reduce(f32::min).unwrap_or(0.0);
            clock.order.push((FloatOrd(-distance), entity));
        }
    }
    // The furthest first, and of equal ones always the same.
    clock.order.sort_unstable();
    if let Some(budget) = &mut budget {
        let passed = time.map_or(0.0, |time| time.delta_secs());
        let count = clock.order.len();
        let is_bad = budget.time().is_none();
        if is_bad && !clock.is_told {
            tracing::error!(
                "`ClothBudget::milliseconds` is {}, but must be above 0: no level is raised until it is",
                budget.milliseconds
            );
        }
        clock.is_told = is_bad;
        adapt(budget, &mut clock.since, seconds, passed, count);
    }
    // Another shape takes milliseconds to make: one a frame is not felt.
    let mut has_other_shape = false;
    let mut left = budget.as_ref().map_or(0, |budget| budget.raised as usize);
    for (FloatOrd(distance), entity) in &clock.order {
        let Ok((_, mut cloth, _)) = cloths.get_mut(*entity) else { continue };
        let level = cloth.lod.by_distance(-distance);
        let most = cloth.lod.in_force.as_ref().map_or(0, |lod| lod.levels.len());
        let raised = left.min(most.saturating_sub(level));
        left -= raised;
        let level = level + raised;
        let waits =
            cloth.lod.has_other_proxy(level) && core::mem::replace(&mut has_other_shape, true);
        let level = if waits { cloth.lod.nearest_of_this_shape(level) } else { level };
        cloth.lod.go_to(level);
    }
    if let Some(budget) = &mut budget {
        // More than there is to raise is no use.
        budget.raised -= left as u32;
        count(budget, cloths.iter().map(|(_, cloth, _)| (cloth.is_culled(), cloth.lod.level)));
    }
}

/// Measures, and raises or lowers what is raised.
fn adapt(budget: &mut ClothBudget, since: &mut f32, seconds: f32, passed: f32, cloths: usize) {
    budget.measured += FRESH * (1e3 * seconds - budget.measured);
    *since += passed;
    let Some(time) = budget.time() else {
        budget.raised = 0;
        return;
    };
    if *since < PATIENCE {
        return;
    }
    let step = cloths.div_ceil(10) as u32;
    if budget.measured > time {
        budget.raised += step;
        *since = 0.0;
    } else if budget.measured < EASE * time && budget.raised > 0 {
        budget.raised = budget.raised.saturating_sub(step);
        *since = 0.0;
    }
}

fn count(budget: &mut ClothBudget, cloths: impl Iterator<Item = (bool, usize)>) {
    let mut culled = 0;
    budget.cloths.clear();
    for (is_culled, level) in cloths {
        if is_culled {
            culled += 1;
        } else {
            let most = budget.cloths.len().max(level + 1);
            budget.cloths.resize(most, 0);
            budget.cloths[level] += 1;
        }
    }
    budget.cloths.push(culled);
}

/// A tick begins.
pub(crate) fn start_clock(mut spent: ResMut<Spent>) {
    spent.start = Some(Instant::now());
}

/// A tick ends.
pub(crate) fn stop_clock(mut spent: ResMut<Spent>) {
    if let Some(start) = spent.start.take() {
        spent.seconds += start.elapsed().as_secs_f32();
    }
}

impl ClothSimulation {
    /// Where what leads the cloth is; the middle of the cloth, where nothing holds it.
    fn place_of_leader(&self, transforms: &TransformHelper) -> Vec3 {
        let attachments = &self.held.attachments;
        let leader = attachments.reference().map(|leader| &attachments.anchors[leader]);
        let holds = |leader: &&Anchor| leader.holds + leader.pulls > 0 || self.skin.is_some();
        let pose = leader.filter(holds).and_then(|it| pose_now(transforms, it.entity).ok());
        pose.map_or_else(
            || {
                let (min, max) = self.solver.bounds();
                (min + max) * 0.5
            },
            |pose| pose.translation,
        )
    }

    /// The level of detail in force, see [`ClothLod`]: 0 is all of it.
    pub fn level(&self) -> usize {
        self.lod.level
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_border_has_two_sides() {
        let mut lod = Lod::default();
        lod.set(&ClothLod::default());
        for (distance, level) in [
            (9.9, 0),
            (10.1, 1),
            (9.9, 1),
            (8.6, 1),
            (8.4, 0),
            (30.0, 2),
            (22.0, 2),
            (21.0, 1),
            (0.0, 0),
        ] {
            let found = lod.by_distance(distance);
            lod.go_to(found);
            assert_eq!(lod.level, level, "{distance}");
        }
    }

    #[test]
    fn what_waits_for_another_shape_goes_as_far_as_it_can() {
        let mut lod = Lod::default();
        let coarse = |at| ClothLevel::at(at).proxy(ClothProxy::ratio(0.5));
        let levels = vec![ClothLevel::at(1.0), ClothLevel::at(2.0), coarse(3.0), coarse(4.0)];
        lod.set(&ClothLod { levels, given: None });
        for (at, wanted, reached) in [(0, 4, 2), (1, 3, 2), (0, 1, 1), (4, 0, 3), (3, 4, 4)] {
            lod.go_to(at);
            assert_eq!(lod.nearest_of_this_shape(wanted), reached, "{at} to {wanted}");
        }
    }

    #[test]
    fn what_takes_too_long_is_raised_until_it_does_not() {
        let (mut budget, mut since) = (ClothBudget::new(2.0), 0.0);
        // 50 cloths, of which each level that is raised spares 40 us of 4 ms.
        let mut raised = Vec::new();
        for _ in 0..600 {
            let seconds = 0.004 - 40e-6 * budget.raised as f32;
            adapt(&mut budget, &mut since, seconds, 1.0 / 60.0, 50);
            raised.push(budget.raised);
        }
        assert!(budget.measured <= 2.0, "{}", budget.measured);
        assert!(raised.windows(2).all(|two| two[1] <= two[0] + 5), "slowly");
        assert_eq!(raised[300..].iter().min(), raised[300..].iter().max(), "steadily");
        // They become cheap: all come back.
        for _ in 0..600 {
            adapt(&mut budget, &mut since, 0.0005, 1.0 / 60.0, 50);
        }
        assert_eq!(budget.raised, 0);
        // A time that cannot be used raises nothing.
        budget.milliseconds = f32::NAN;
        adapt(&mut budget, &mut since, 1.0, 1.0, 50);
        assert_eq!(budget.raised, 0);
    }
}
