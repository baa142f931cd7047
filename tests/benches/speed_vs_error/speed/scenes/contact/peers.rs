//! What other solvers reached in the same scenes, as recorded in a file of `tests/data`.

use super::super::super::{Job, Measured, Outcome};
use examples_common::repository;

/// The records of a scene in a file as jobs: their errors are the columns of these names.
pub fn jobs(file: &str, scene: &str, n: usize, errors: &[&str]) -> Outcome<Vec<Job<'static>>> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(repository(&format!("tests/data/{file}")))?;
    let heads = reader.headers()?.clone();
    let column = |name: &str| heads.iter().position(|head| head == name).ok_or(name.to_owned());
    let [is_of, case, peer, ms] =
        [column("scene")?, column("case")?, column("peer")?, column("ms")?];
    // Nothing is known of what has no name.
    let find = |name: &&str| if name.is_empty() { Ok(None) } else { column(name).map(Some) };
    let errors: Vec<_> = errors.iter().map(find).collect::<Result<_, _>>()?;
    let mut jobs = Vec::new();
    for row in reader.records() {
        let row = row?;
        if &row[is_of] != scene {
            continue;
        }
        let number = |at: usize| row[at].parse().unwrap_or(f64::NAN);
        let measured = Measured {
            frames: vec![number(ms)],
            errors: errors.iter().map(|at| at.map_or(f64::NAN, number)).collect(),
            allocations: f64::NAN,
            ..Measured::default()
        };
        jobs.push(Job {
            method: format!("{}, {}", &row[case], &row[peer]),
            n,
            knob: "as recorded".into(),
            run: Box::new(move || Ok(measured.clone())),
        });
    }
    Ok(jobs)
}
