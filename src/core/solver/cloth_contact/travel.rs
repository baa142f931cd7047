//! How far particles have moved relative to each other since pairs were found.
//!
//! One number for the whole cloth would be large wherever it swings or turns, though what is near each other hardly moves apart. So
//! a cloth has some regions, each with the box of its displacements. No two particles of two regions have moved relative to each
//! other by more than their boxes are wide together. Regions that were far from each other may move further than those that were
//! near before one of their particles can touch.
//!
//! Where there are many pairs, the same is measured from substep to substep. Summed up, it is the length of a path, by which pairs
//! sleep that were not near enough when they were looked at last.

use crate::solver::cloth_contact::regions::Extent;
use crate::solver::simd::block::{larger, smaller};

/// How far particles have moved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Travelled {
    /// Relative to each other, of regions that were near each other when pairs were found \[m\].
    pub most: f32,
    /// The same since they were measured before \[m\].
    pub step: f32,
    /// Whether particles may touch that are no pair.
    pub is_too_far: bool,
}

impl Travelled {
    pub const NOTHING: Self = Self { most: 0.0, step: 0.0, is_too_far: false };
}

/// The boxes of how far the particles of a cloth's regions have moved, since pairs were found and in the last step.
#[derive(Clone, Copy)]
pub(super) struct Moved<'a> {
    pub all: &'a [Extent],
    /// Empty where the last step is not measured.
    pub step: &'a [Extent],
}

/// Two regions that are far from each other, and how far they may move relative to each other \[m\].
#[derive(Clone, Copy, Debug)]
struct Far {
    regions: [u16; 2],
    allowed: f32,
}

/// How far the regions of two cloths, or of one, may move relative to each other before particles that are no pair may touch.
#[derive(Clone, Debug, Default)]
pub(super) struct Allowance {
    /// Regions that were near each other when pairs were found, two by two, which may move by the margin \[m\].
    near: Vec<[u16; 2]>,
    margin: f32,
    /// The others, and the least that any of them may move \[m\].
    far: Vec<Far>,
    least: f32,
}

impl Allowance {
    /// With room for the regions of one cloth, of which there are so many.
    pub fn with_room(regions: usize) -> Self {
        let room = regions * (regions + 1) / 2;
        let (near, far) = (Vec::with_capacity(room), Vec::with_capacity(room));
        Self { near, margin: 0.0, far, least: 0.0 }
    }

    /// Begins anew with the regions of one cloth that are in these boxes, where particles are pairs that are up to `margin` further apart
    /// than they touch, `reach` apart at most.
    pub fn begin_with_one(&mut self, regions: &[Extent], margin: f32, reach: f32) {
        self.clear(margin);
        for (i, a) in regions.iter().enumerate() {
            for (j, b) in regions[..=i].iter().enumerate() {
                self.add([i, j], a.gap(b), reach);
            }
        }
    }

    /// Begins anew with the regions of two cloths, in the same way.
    pub fn begin(&mut self, [some, others]: [&[Extent]; 2], margin: f32, reach: f32) {
        self.clear(margin);
        for (i, a) in some.iter().enumerate() {
            for (j, b) in others.iter().enumerate() {
                self.add([i, j], a.gap(b), reach);
            }
        }
    }

    fn clear(&mut self, margin: f32) {
        self.near.clear();
        self.far.clear();
        (self.margin, self.least) = (margin, f32::INFINITY);
    }

    fn add(&mut self, regions: [usize; 2], gap: f32, reach: f32) {
        // The last page of a mesh may hold no particle.
        if gap == f32::INFINITY {
            return;
        }
        let regions = regions.map(|region| region as u16);
        let allowed = larger(gap - reach, 0.0) + self.margin;
        if allowed <= self.margin {
            self.near.push(regions);
        } else {
            self.far.push(Far { regions, allowed });
            self.least = smaller(allowed, self.least);
        }
    }

    /// Measures how far particles have moved, by the boxes of the regions of both cloths, or twice of one.
    pub fn measure(&self, [some, others]: [Moved<'_>; 2]) -> Travelled {
        let (mut most, mut step) = (0.0, 0.0);
        for regions in &self.near {
            let [a, b] = regions.map(usize::from);
            most = larger(some.all[a].difference(&others.all[b]), most);
            if let (Some(a), Some(b)) = (some.step.get(a), others.step.get(b)) {
                step = larger(a.difference(b), step);
            }
        }
        let mut is_too_far = most >= self.margin * self.margin;
        // What is far need not be looked at one by one, unless the whole cloths have moved as far.
        let whole = |moved: Moved<'_>| moved.all.iter().fold(Extent::NOTHING, Extent::with);
        if whole(some).difference(&whole(others)) >= self.least * self.least {
            is_too_far |= self.far.iter().any(|Far { regions, allowed }| {
                let [a, b] = regions.map(usize::from);
                some.all[a].difference(&others.all[b]) >= allowed * allowed
            });
        }
        Travelled { most: f32::sqrt(most), step: f32::sqrt(step), is_too_far }
    }
}

#[cfg(test)]
mod tests {
    use bevy_math::Vec3;

    use super::*;

    /// Some boxes of a size along a line, so far from each other.
    fn boxes(count: usize, step: f32, size: f32, shift: Vec3) -> Vec<Extent> {
        let low = |i: usize| shift + Vec3::X * step * i as f32;
        (0..count).map(|i| Extent { low: low(i), high: low(i) + size }).collect()
    }

    #[test]
    fn what_is_far_may_move_further_and_no_further_than_that() {
        let [some, others] = [0.0, 2.0].map(|up| boxes(6, 1.0, 0.5, Vec3::Y * up));
        let (margin, reach) = (0.1, 0.2);
        let mut allowance = Allowance::default();
        allowance.begin([&some, &others], margin, reach);
        let still = vec![Extent::ZERO; 6];
        // All are 1.5 m apart at least, and may move by that without the reach.
        let least = 1.5 - reach + margin;
        for (place, by, is_too_far) in [(0, least - 0.01, false), (5, least + 0.01, true)] {
            let mut moved = still.clone();
            moved[place] = moved[place].with(&Extent { low: Vec3::ZERO, high: Vec3::Y * by });
            let sides = [&moved, &still].map(|all| Moved { all, step: &still });
            let travelled = allowance.measure(sides);
            assert_eq!(
                travelled,
                Travelled { is_too_far, ..Travelled::NOTHING },
                "{place} by {by}"
            );
        }
    }

    #[test]
    fn what_is_empty_goes_nowhere() {
        let mut regions = boxes(3, 2.0, 0.5, Vec3::ZERO);
        regions.push(Extent::NOTHING);
        let mut allowance = Allowance::default();
        allowance.begin_with_one(&regions, 0.1, 0.2);
        // Further than neighbours may, but not than what is at the other end.
        let still = [Extent::ZERO, Extent::ZERO, Extent::ZERO, Extent::NOTHING];
        let mut moved = still;
        moved[1] = Extent { low: Vec3::X * 0.8, high: Vec3::X * 0.8 };
        moved[2] = Extent { low: Vec3::X * 1.6, high: Vec3::X * 1.6 };
        let travelled = allowance.measure([Moved { all: &moved, step: &still }; 2]);
        assert_eq!(travelled, Travelled::NOTHING);
    }

    #[test]
    fn what_is_near_is_measured_and_held_to_the_margin() {
        let regions = boxes(4, 1.0, 0.5, Vec3::ZERO);
        let (margin, reach) = (0.1, 0.6);
        let mut allowance = Allowance::default();
        allowance.begin_with_one(&regions, margin, reach);
        let still = vec![Extent::ZERO; 4];
        for (by, is_too_far) in [(0.09, false), (0.11, true)] {
            let moved = vec![
                still[0],
                still[1],
                Extent { low: Vec3::Z * by, high: Vec3::Z * by },
                still[3],
            ];
            let travelled = allowance.measure([Moved { all: &moved, step: &still }; 2]);
            assert!((travelled.most - by).abs() < 1e-6, "{travelled:?}");
            assert_eq!((travelled.step, travelled.is_too_far), (0.0, is_too_far));
        }
    }
}
