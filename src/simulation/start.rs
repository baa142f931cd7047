//! How a cloth starts: where it is, or hung from its pins.

use crate::simulation::hanging::Hanging;

/// The start of a cloth, before its first tick.
#[derive(Default)]
pub(crate) struct Start {
    /// The shape that the cloth is brought to first, with [`HangOnStart`](crate::HangOnStart).
    pub(crate) hanging: Option<Box<Hanging>>,
    /// `ClothReady` has been told.
    pub(crate) told_ready: bool,
    /// Goes on where another was: pins have to take hold.
    pub(crate) takes_hold: bool,
    /// All pins have taken hold since the cloth was set up where it is.
    pub(crate) is_held: bool,
}

impl Start {
    /// Whether the cloth waits until it is at rest.
    pub fn is_pending(&self) -> bool {
        self.hanging.as_ref().is_some_and(|hanging| hanging.is_pending())
    }

    /// Whether the first tick has come for a cloth that is hung: it no longer starts anew elsewhere.
    pub fn has_begun(&self) -> bool {
        self.hanging.as_ref().is_some_and(|hanging| hanging.has_begun())
    }
}
