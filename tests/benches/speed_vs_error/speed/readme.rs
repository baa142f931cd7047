//! The report in short: what a time buys, and what a bound costs, beside the best peer.

use std::{fs, path::Path};

use super::{
    Outcome, Point, Results,
    peers::Level,
    tables::{markdown_table, short},
};

/// Times that are asked about \[ms a frame\].
const BUDGETS: [f64; 3] = [0.1, 0.3, 1.0];

/// A bound on a scene's errors, and the times aimed at for 32, 64 and 128 particles a side where the peers were
/// measured \[ms\].
struct Bound {
    scene: &'static str,
    what: &'static str,
    /// Largest first and second error of the scene.
    most: [f64; 2],
    targets: [f64; 3],
}

const BOUNDS: [Bound; 5] = [
    Bound {
        scene: "hang",
        what: "HANG, RMS at most 30 mm",
        most: [30.0, f64::INFINITY],
        targets: [0.013, 0.065, 0.5],
    },
    Bound {
        scene: "hang",
        what: "HANG, RMS at most 10 mm",
        most: [10.0, f64::INFINITY],
        targets: [0.018, 0.09, 0.75],
    },
    Bound {
        scene: "hang",
        what: "HANG, p99 strain at most 1 %",
        most: [f64::INFINITY, 1.0],
        targets: [0.018, 0.09, 0.75],
    },
    Bound {
        scene: "drape",
        what: "DRAPE, p99 strain at most 3 %, depth at most 5 mm",
        most: [5.0, 3.0],
        targets: [0.02, 0.09, 0.75],
    },
    Bound {
        scene: "drape",
        what: "DRAPE, p99 strain at most 1 %, depth at most 1 mm",
        most: [1.0, 1.0],
        targets: [0.03, 0.15, 0.95],
    },
];

fn points<'a>(all: &'a [Results<'_>], scene: &'a str) -> impl Iterator<Item = &'a Point> {
    let of = move |results: &&Results<'_>| results.scene.name == scene;
    all.iter().filter(of).flat_map(|results| &results.points).filter(|p| p.failed.is_none())
}

fn peers<'a>(levels: &'a [Level], scene: &'a str, n: usize) -> impl Iterator<Item = &'a Level> {
    levels.iter().filter(move |level| level.scene == scene && level.n == n && !level.failed)
}

/// What a time buys, for the README, and what a bound costs, for the guide; nothing where either scene was not run.
pub fn summary(all: &[Results<'_>], levels: &[Level], factor: f64) -> [String; 2] {
    if points(all, "hang").next().is_none() || points(all, "drape").next().is_none() {
        return Default::default();
    }
    let buys = "What a time buys for 64 x 64 particles, one core, and the best that any peer reaches in that time:";
    let takes = "What a bound costs, in ms a frame; targets and peers scaled by the yardstick to this machine:";
    [
        format!("{buys}\n\n{}", markdown_table(&bought(all, levels, factor))),
        format!("{takes}\n\n{}", markdown_table(&costs(all, levels, factor))),
    ]
}

/// What the default settings are held to: the bounds of 10 mm, of 1 % and of 1 mm.
///
/// # Errors
/// Where one does not hold.
pub fn check(all: &[Results<'_>]) -> Outcome<()> {
    for Results { scene, points } in all {
        for point in points.iter().filter(|point| point.method == "automatic") {
            for Bound { what, most, .. } in BOUNDS.iter().filter(|b| b.scene == scene.name) {
                let holds = point.errors.iter().zip(most).all(|(error, most)| error <= most);
                if !holds || point.failed.is_some() {
                    return Err(format!("the default misses: {what}, n = {}", point.n).into());
                }
            }
        }
    }
    Ok(())
}

fn bought(all: &[Results<'_>], levels: &[Level], factor: f64) -> Vec<Vec<String>> {
    let mut rows = vec![
        ["ms a frame", "HANG: RMS error", "HANG: p99 strain", "DRAPE: p99 strain"]
            .map(Into::into)
            .to_vec(),
    ];
    for budget in BUDGETS {
        let cell = |scene: &str, error: usize, unit: &str| {
            let own = points(all, scene)
                .filter(|p| p.n == 64 && p.time.median <= budget)
                .min_by(|a, b| a.errors[error].total_cmp(&b.errors[error]));
            let theirs = peers(levels, scene, 64)
                .filter(|level| {
                    level.time * factor <= budget && (scene == "hang" || level.depth <= 5.0)
                })
                .map(|level| if error == 0 { level.rms } else { level.strain })
                .filter(|error| error.is_finite())
                .reduce(f64::min);
            let own = own.map_or("-".into(), |p| {
                format!("{} {unit} ({}, {})", short(p.errors[error]), p.method, p.knob)
            });
            let theirs =
                theirs.map_or("nothing".into(), |error| format!("{} {unit}", short(error)));
            format!("{own}; peers {theirs}")
        };
        let cells = [("hang", 0, "mm"), ("hang", 1, "%"), ("drape", 1, "%")];
        let cells = cells.map(|(scene, error, unit)| cell(scene, error, unit));
        rows.push([vec![budget.to_string()], cells.to_vec()].concat());
    }
    rows
}

fn costs(all: &[Results<'_>], levels: &[Level], factor: f64) -> Vec<Vec<String>> {
    let mut rows = vec![
        ["bound", "n", "own best setting", "the default", "target", "best peer"]
            .map(Into::into)
            .to_vec(),
    ];
    for Bound { scene, what, most, targets } in BOUNDS {
        for (n, target) in [32, 64, 128].into_iter().zip(targets) {
            let holds =
                |errors: &[f64]| errors.iter().zip(most).all(|(error, most)| *error <= most);
            let own = points(all, scene)
                .filter(|p| p.n == n && holds(&p.errors))
                .min_by(|a, b| a.time.median.total_cmp(&b.time.median));
            let default = points(all, scene).find(|p| p.n == n && p.method == "automatic");
            let peer = peers(levels, scene, n)
                .filter(|level| {
                    let first = if scene == "hang" { level.rms } else { level.depth };
                    holds(&[first, level.strain])
                })
                .map(|level| level.time * factor)
                .reduce(f64::min);
            let own = own.map_or("none".into(), |p| {
                format!("{} ({}, {})", short(p.time.median), p.method, p.knob)
            });
            let default = default.map_or("-".into(), |p| {
                let missed = if holds(&p.errors) { "" } else { ", misses" };
                format!("{}{missed}", short(p.time.median))
            });
            let peer = peer.map_or("none".into(), short);
            rows.push(vec![what.into(), n.to_string(), own, default, short(target * factor), peer]);
        }
    }
    rows
}

const BEGIN: &str = "<!-- speed_vs_error: begin -->";
const END: &str = "<!-- speed_vs_error: end -->";

/// Puts a text between the marks of a page.
pub fn insert(path: &Path, text: &str) -> Outcome<()> {
    let before = fs::read_to_string(path)?;
    let (Some(begin), Some(end)) = (before.find(BEGIN), before.find(END)) else {
        return Err(format!("{}: the marks `{BEGIN}` and `{END}` are gone", path.display()).into());
    };
    let head = &before[..begin + BEGIN.len()];
    fs::write(path, format!("{head}\n{}\n{}", text.trim_end(), &before[end..]))?;
    Ok(())
}
