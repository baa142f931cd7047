//! Bodies that come to a cloth fast, and the substeps that they ask for.
//!
//! Threads tell the cloth of a strike on a few of its particles, further away with each substep. A body that goes a good part of the way between
//! particles in a substep has stretched the threads that it meets by twice their length before the cloth about them yields, and is through: of
//! bodies of 8 to 30 cm and at most 5 kg, dropped by 2 m onto a hammock of 0.2 kg, one in six with eight substeps in 1/60 s, and none with sixteen.
//! So a body that approaches asks for substeps in which it does not go as far, and for these until the cloth has caught it.

/// Way of a body in a substep, over the distance between particles.
const MOST_WAY: f32 = 0.15;
/// Substeps in 1/60 s that bodies ask for at most: a multiple of [`STEPS`].
const MOST: u32 = 40;
/// Time in which a cloth catches what has struck it \[s\].
const CATCHING: f32 = 0.25;
/// Numbers of substeps that are asked for are multiples of this: a plan is not made anew in every tick.
const STEPS: u32 = 4;

/// Substeps that the bodies which strike a cloth ask for, as far as that goes on from tick to tick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Striking {
    /// Substeps in 1/60 s; 0 where nothing strikes.
    pub substeps: u32,
    /// Time for which they are kept \[s\].
    left: f32,
    /// Whether the cloth met any body in the last tick.
    pub has_met: bool,
}

impl Striking {
    pub const NONE: Self = Self { substeps: 0, left: 0.0, has_met: false };

    /// Follows the fastest body that is near in a tick \[s\], by its speed relative to what holds the cloth \[m/s\], and the distance
    /// between particles \[m\]. Only what the cloth has met is caught.
    pub fn follow(&mut self, speed: f32, spacing: f32, tick: f32) {
        let needed = (speed / (60.0 * MOST_WAY * spacing)).min(MOST as f32) as u32;
        let asked = needed.next_multiple_of(STEPS);
        (self.substeps, self.left) = if asked > 0 && asked >= self.substeps {
            (asked, CATCHING)
        } else if self.has_met && self.left > tick {
            (self.substeps, self.left - tick)
        } else {
            (asked, 0.0)
        };
    }

    /// Whether it can have been.
    pub fn is_good(&self) -> bool {
        self.substeps <= MOST && (0.0..=CATCHING).contains(&self.left)
    }
}
