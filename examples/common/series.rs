//! Systems one after another: for the tests too.

use bevy::{ecs::schedule::SingleThreadedExecutor, prelude::*};

/// Runs the systems of every schedule so far one after another, on the thread that updates the app: to hand each
/// to a pool's thread would cost more than most of them do. What a system shares out itself it still does.
pub fn run_in_series(app: &mut App) {
    for (_, schedule) in app.world_mut().resource_mut::<Schedules>().iter_mut() {
        schedule.set_executor(SingleThreadedExecutor::new());
    }
}
