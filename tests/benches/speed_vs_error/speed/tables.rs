//! The report as text, Markdown and CSV.

use std::{fmt::Write as _, fs, path::Path};

use super::{Metric, Outcome, Point, Results, Times, machine::Machine};

/// Prints a scene's points as a table.
pub fn print(results: &Results<'_>) {
    println!("\n{}\n{}\n", results.scene.title, results.scene.about);
    let rows = rows(results);
    let widths: Vec<_> = (0..rows[0].len())
        .map(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0))
        .collect();
    for row in &rows {
        let cells = row.iter().zip(&widths).enumerate().map(|(at, (cell, &width))| {
            if at == 0 { format!("{cell:width$}") } else { format!("{cell:>width$}") }
        });
        println!("{}", cells.collect::<Vec<_>>().join("  ").trim_end());
    }
}

/// A scene's points as rows of cells, the heads first.
fn rows(results: &Results<'_>) -> Vec<Vec<String>> {
    let errors = &results.scene.errors;
    let mut heads: Vec<String> =
        ["method", "n", "setting", "ms a frame", "p99 ms", "ns each", "allocations"]
            .map(Into::into)
            .into();
    heads.extend(errors.iter().map(Metric::label));
    heads.push("remark".into());
    let mut rows = vec![heads];
    for Point { method, n, knob, time, errors, allocations, failed } in &results.points {
        let Times { median, p99, least, most, each } = time;
        // Some of what is recorded has no time.
        let is_timed = !median.is_nan();
        let spread = format!("{median:.3} ({least:.3} to {most:.3})");
        let spread = if is_timed { spread } else { "-".into() };
        let mut row = vec![
            method.clone(),
            n.to_string(),
            knob.clone(),
            spread,
            if is_timed { format!("{p99:.3}") } else { "-".into() },
            short(*each),
            short(*allocations),
        ];
        row.extend(errors.iter().map(|error| short(*error)));
        row.resize(rows[0].len() - 1, String::new());
        row.push(failed.clone().map_or(String::new(), |why| format!("failed: {why}")));
        rows.push(row);
    }
    rows
}

/// Three digits.
pub fn short(value: f64) -> String {
    if value.is_nan() {
        "-".into()
    } else if value == 0.0 {
        "0".into()
    } else if !(1e-2..1e5).contains(&value.abs()) {
        format!("{value:.2e}")
    } else {
        let digits = (2 - value.abs().log10().floor() as i32).clamp(0, 4) as usize;
        format!("{value:.digits$}")
    }
}

/// A table in Markdown.
pub fn markdown_table(rows: &[Vec<String>]) -> String {
    let mut text = String::new();
    for (at, row) in rows.iter().enumerate() {
        let _ = writeln!(text, "| {} |", row.join(" | "));
        if at == 0 {
            let _ = writeln!(text, "|{}", " --- |".repeat(row.len()));
        }
    }
    text
}

/// The whole report in Markdown.
pub fn write_markdown(
    path: &Path,
    machine: &Machine,
    all: &[Results<'_>],
    extra: &str,
    plots: &[Vec<String>],
) -> Outcome<()> {
    let mut text = String::from("# Speed against error\n\n");
    let _ = writeln!(
        text,
        "Written by `cargo run --release --example speed_vs_error`. {machine} One thread, the simulation's call alone, no drawing. \
         Milliseconds a frame of 1/60 s: the median frame of the median run (medians of the fastest and of the slowest run), the \
         99th percentile of that run's frames, nanoseconds a particle and substep, and allocations a frame. Threads 1000 N/m, shear 300 N/m, bending \
         1e-5 N m, 0.2 kg/m2, lumped masses, strain limit 10 %, statics under a drag of 2 /s, unless a scene says otherwise. What \
         failed is listed and drawn as a failure. Differences within the spread are none.\n"
    );
    text += extra;
    for (results, plots) in all.iter().zip(plots) {
        let _ = writeln!(text, "## {}\n\n{}\n", results.scene.title, results.scene.about);
        for plot in plots {
            let _ = writeln!(text, "![{}]({plot})\n", results.scene.title);
        }
        text += &markdown_table(&rows(results));
        text.push('\n');
    }
    fs::write(path, text)?;
    Ok(())
}

/// All points, a row an error.
pub fn write_csv(path: &Path, all: &[Results<'_>]) -> Outcome<()> {
    let mut file = csv::Writer::from_path(path)?;
    file.write_record([
        "scene",
        "method",
        "n",
        "setting",
        "ms_median",
        "ms_p99",
        "ms_least",
        "ms_most",
        "ns_a_particle_and_substep",
        "allocations_a_frame",
        "error",
        "unit",
        "value",
        "failed",
    ])?;
    for results in all {
        for point in &results.points {
            for (metric, error) in results.scene.errors.iter().zip(&point.errors) {
                let Times { median, p99, least, most, each } = point.time;
                let times = [median, p99, least, most, each].map(|time| format!("{time:.6}"));
                let mut row = vec![
                    results.scene.name.to_owned(),
                    point.method.clone(),
                    point.n.to_string(),
                    point.knob.clone(),
                ];
                row.extend(times);
                row.push(format!("{}", point.allocations));
                row.extend([metric.name.to_owned(), metric.unit.to_owned(), format!("{error:e}")]);
                row.push(point.failed.clone().unwrap_or_default());
                file.write_record(&row)?;
            }
        }
    }
    file.flush()?;
    Ok(())
}
