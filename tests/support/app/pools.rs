//! Apps in pools of several sizes.

use std::process::Command;

use bevy::{
    app::{TaskPoolOptions, TaskPoolPlugin, TaskPoolThreadAssignmentPolicy},
    prelude::*,
    tasks::ComputeTaskPool,
};
use bevy_drape::ClothExecution;

/// Set in the processes that [`in_pools`] starts.
pub const POOL: &str = "BEVY_DRAPE_TEST_POOL";

/// What a scene comes to in compute pools of each size. A process has one pool for good, so each size has a
/// process of its own: the test of this name again, with a variable set. There it is `None`.
#[allow(clippy::print_stdout)]
pub fn in_pools(
    name: &str,
    sizes: &[usize],
    plugins: impl Fn(&mut App),
    scene: impl Fn(&mut App) -> String,
) -> Option<Vec<String>> {
    if let Ok(size) = std::env::var(POOL) {
        let size = size.parse().unwrap();
        let mut app = app_of_pool(size);
        plugins(&mut app);
        app.insert_resource(ClothExecution::Fused);
        app.finish();
        app.cleanup();
        app.update();
        assert_eq!(ComputeTaskPool::get().thread_num(), size);
        println!("bits {}", scene(&mut app));
        return None;
    }
    let bits = sizes.iter().map(|size| {
        let output = Command::new(std::env::current_exe().unwrap())
            .args([name, "--exact", "--nocapture"])
            .env(POOL, size.to_string())
            .output()
            .unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let line =
            text.lines().find_map(|line| line.split_once("bits ")).map(|(_, bits)| bits.to_owned());
        line.unwrap_or_else(|| panic!("{text}"))
    });
    Some(bits.collect())
}

fn app_of_pool(size: usize) -> App {
    let exactly = TaskPoolThreadAssignmentPolicy {
        min_threads: size,
        max_threads: size,
        percent: 1.0,
        on_thread_spawn: None,
        on_thread_destroy: None,
    };
    let task_pool_options =
        TaskPoolOptions { max_total_threads: 16, compute: exactly, ..default() };
    let mut app = App::new();
    app.add_plugins(MinimalPlugins.set(TaskPoolPlugin { task_pool_options }));
    app
}
