//! What is measured, printed beside what it ought to be.

/// Prints a measurement beside what it ought to be, and fails beyond the tolerance.
#[track_caller]
#[allow(clippy::print_stdout)]
pub fn check(what: &str, measured: f64, reference: f64, tolerance: f64) {
    println!("{what}: {measured:.6e}, reference {reference:.6e}, tolerance {tolerance:.1e}");
    let error = (measured - reference).abs();
    assert!(error <= tolerance, "{what}: {measured} is {error} from {reference}");
}

/// Prints a measurement beside its bound, and fails above it.
#[track_caller]
#[allow(clippy::print_stdout)]
pub fn check_at_most(what: &str, measured: f64, bound: f64) {
    println!("{what}: {measured:.6e}, at most {bound:.1e}");
    assert!(measured <= bound, "{what}: {measured} is above {bound}");
}
