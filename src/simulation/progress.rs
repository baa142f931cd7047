//! A cloth's state after its last tick: the count of ticks, the last report, whether it has diverged.

use bevy::prelude::*;

use crate::solver::TickReport;

/// The ticks of a cloth so far, and how they ended.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Debug, PartialEq, Clone)]
pub(crate) struct Progress {
    /// Measurements of the last tick; `None` before the first one.
    #[reflect(ignore)]
    pub(crate) last_tick: Option<TickReport>,
    pub(crate) tick_count: u64,
    /// The cloth diverged, and waits for other numbers.
    pub(crate) quarantined: bool,
}

impl Progress {
    /// A tick was taken.
    pub fn note(&mut self, report: TickReport) {
        self.last_tick = Some(report);
        self.tick_count += 1;
    }
}
