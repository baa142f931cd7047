//! The last frames, measured, for the plots.

use std::collections::VecDeque;

/// The measurements of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PanelSample {
    /// When: seconds of the fixed clock \[s\].
    pub time: f64,
    /// Largest strain of a thread \[1\].
    pub max_strain: f64,
    /// Mean strain of all threads \[1\].
    pub mean_strain: f64,
    /// Energy of its motion \[J\].
    pub kinetic: f64,
    /// Energy of its height: how much more than where it was first measured \[J\].
    pub height: f64,
    /// How deep its deepest particle is in a collider \[m\].
    pub depth: f64,
    /// A tick of all cloths, smoothed \[ms\].
    pub milliseconds: f64,
}

/// The last frames of one cloth.
#[derive(Clone, Debug, Default)]
pub struct PanelHistory {
    samples: VecDeque<PanelSample>,
}

impl PanelHistory {
    /// Most samples that are kept.
    pub const LENGTH: usize = 600;

    /// The samples, the oldest first.
    pub fn samples(&self) -> impl ExactSizeIterator<Item = &PanelSample> {
        self.samples.iter()
    }

    /// The last one.
    pub fn last(&self) -> Option<&PanelSample> {
        self.samples.back()
    }

    pub(super) fn push(&mut self, sample: PanelSample) {
        if self.samples.len() == Self::LENGTH {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
    }

    pub(super) fn clear(&mut self) {
        self.samples.clear();
    }
}
