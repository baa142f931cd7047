//! Random cloths in random surroundings. Truth: nothing panics, nothing becomes what is no number, and what is
//! refused is refused by a typed error that leaves everything finite.
//!
//! The cases are the same in every run; `BEVY_DRAPE_TEST_CASES` multiplies their number, and
//! `BEVY_DRAPE_TEST_SEED` chooses others. What failed once is kept in `proptest-regressions` beside this
//! file and run first.

mod choices;
mod corpus;
mod decode;
mod field;
mod games;
mod meshes;
mod solvers;
mod soup;
// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "../support/mod.rs"]
mod support;

use proptest::{
    strategy::Strategy,
    test_runner::{
        Config, FileFailurePersistence, RngAlgorithm, TestCaseResult, TestRng, TestRunner,
    },
};

/// What failed once. Cargo runs tests in the repository's folder.
const REGRESSIONS: &str = "tests/properties/proptest-regressions";

fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Runs so many cases of a property, times what is asked for.
#[track_caller]
fn hold<S: Strategy>(cases: u32, strategy: &S, property: impl Fn(S::Value) -> TestCaseResult) {
    let times = number("BEVY_DRAPE_TEST_CASES", 1);
    let config = Config {
        cases: cases.saturating_mul(times as u32),
        failure_persistence: Some(Box::new(FileFailurePersistence::Direct(REGRESSIONS))),
        max_shrink_iters: 400,
        ..Config::default()
    };
    let mut seed = [0; 32];
    seed[..8].copy_from_slice(&number("BEVY_DRAPE_TEST_SEED", 1).to_le_bytes());
    let random = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
    let outcome = TestRunner::new_with_rng(config, random).run(strategy, property);
    outcome.unwrap_or_else(|error| panic!("{error}"));
}
