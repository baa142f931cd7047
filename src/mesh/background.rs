//! Work on large meshes that goes on in the background, while the game goes on.

use std::hash::Hash;

use bevy::platform::collections::HashMap;
use bevy::tasks::futures_lite::future::poll_once;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on};

/// Vertices of a mesh from which on it is worked on in the background: some 0.1 s.
pub(crate) const LARGE: usize = 8_000;

/// Tasks by what they are to make.
pub(crate) struct Background<K, T>(HashMap<K, Job<T>>);

struct Job<T> {
    task: Task<T>,
    /// Whether anybody has asked for it since the last look.
    is_asked: bool,
}

impl<K, T> Default for Background<K, T> {
    fn default() -> Self {
        Self(HashMap::default())
    }
}

impl<K: Eq + Hash, T: Send + 'static> Background<K, T> {
    /// What is to be made; `None` while it is. It is begun when it is first asked for.
    pub fn ask<W: FnOnce() -> T + Send + 'static>(
        &mut self,
        key: K,
        begin: impl FnOnce() -> W,
    ) -> Option<T> {
        if !self.0.contains_key(&key) {
            let work = begin();
            let pool = AsyncComputeTaskPool::get_or_init(TaskPool::default);
            let task = pool.spawn(async move { work() });
            self.0.insert(key, Job { task, is_asked: true });
            return None;
        }
        let job = self.0.get_mut(&key)?;
        job.is_asked = true;
        let made = block_on(poll_once(&mut job.task))?;
        self.0.remove(&key);
        Some(made)
    }

    /// Stops what nobody has asked for since the last call.
    pub fn stop_forgotten(&mut self) {
        self.0.retain(|_, job| core::mem::take(&mut job.is_asked));
    }
}
