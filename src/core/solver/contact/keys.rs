//! Colliders are known from tick to tick by their keys.

use crate::solver::contact::collider::Collider;

/// The keys of a tick's colliders, and of those of the tick before.
#[derive(Clone, Debug, Default)]
pub(crate) struct Keys {
    now: Vec<u64>,
    before: Vec<u64>,
    /// The keys of now with their places, ascending.
    sorted: Vec<(u64, usize)>,
}

impl Keys {
    /// Goes on to a tick with these colliders, and tells whether any may be at another place. Allocates where there are more
    /// than ever before.
    pub fn go_on(&mut self, colliders: &[Collider<'_>]) -> bool {
        let keys = || colliders.iter().map(|collider| collider.key);
        let without = colliders.len() - colliders.len().min(self.now.len());
        let known = self.now.iter().copied().chain(core::iter::repeat_n(0, without));
        if keys().eq(known) {
            return false;
        }
        core::mem::swap(&mut self.now, &mut self.before);
        self.now.clear();
        self.now.extend(keys());
        self.sorted.clear();
        self.sorted.extend(keys().zip(0..));
        self.sorted.sort_unstable();
        true
    }

    /// Where the collider of a key is in this tick.
    pub fn position(&self, key: u64) -> Option<usize> {
        let at = self.sorted.partition_point(|&(known, _)| known < key);
        let &(known, place) = self.sorted.get(at)?;
        (known == key).then_some(place)
    }

    /// Where a collider of the tick before is now.
    pub fn place(&self, collider: usize) -> Option<usize> {
        match self.before.get(collider) {
            // It has no key, or was saved.
            None | Some(0) => Some(collider),
            Some(key) => {
                let found = self.sorted.binary_search_by_key(key, |&(key, _)| key);
                found.ok().map(|found| self.sorted[found].1)
            }
        }
    }
}
