//! Speed against error: every scene of the report, its knobs swept, as tables, CSV, Markdown and plots.
//!
//! `cargo run --release --example speed_vs_error` writes the whole report into `assets/report`; with
//! `--quick` or `--scenes` a part of it, into `target/speed_vs_error`.

// A program may print.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::{
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
    time::Instant,
};

use clap::{Parser, builder::PossibleValuesParser};
use indicatif::{ProgressBar, ProgressStyle};

mod exact;
#[allow(dead_code)]
#[path = "../../accuracy/reference.rs"]
mod reference;
mod speed;

use examples_common::repository;
use speed::{
    Extent, Outcome, Results, Runs, Scene, machine::Machine, peers, plot, readme, scenes, tables,
};

/// Measures speed against error, scene by scene.
#[derive(Parser)]
struct Options {
    /// Fewer sizes and settings, in under a minute.
    #[arg(short, long)]
    quick: bool,
    /// Only these scenes; all where none are named.
    #[arg(short, long, value_delimiter = ',', value_parser = names())]
    scenes: Vec<String>,
    /// Runs of each setting, unless they take long.
    #[arg(short, long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..100))]
    runs: u32,
    /// Where to write to.
    #[arg(short, long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Only time a crowd of cloths on so many threads.
    #[arg(long, hide = true, value_parser = clap::value_parser!(u16).range(1..1024))]
    crowd: Option<u16>,
    /// Put the report's short form (HANG and DRAPE) into the README and the guide as well, between their marks.
    #[arg(long)]
    readme: bool,
}

fn names() -> PossibleValuesParser {
    PossibleValuesParser::new(scenes::ALL.map(|(name, _)| name))
}

fn main() -> ExitCode {
    let options = Options::parse();
    if let Some(threads) = options.crowd {
        println!("{}", scenes::scaling::crowd(threads.into()));
        return ExitCode::SUCCESS;
    }
    match report(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn report(options: &Options) -> Outcome<()> {
    let begun = Instant::now();
    let whole = !options.quick && options.scenes.is_empty();
    let shown = ["hang", "drape"].map(|name| options.scenes.iter().any(|scene| scene == name));
    if options.readme && !(whole || shown == [true; 2] && !options.quick) {
        return Err(
            "the README shows HANG and DRAPE: leave out --quick, and name both scenes".into()
        );
    }
    let usual = if whole { "assets/report" } else { "target/speed_vs_error" };
    let folder = options.out.clone().unwrap_or_else(|| repository(usual));
    // Before minutes of work.
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let levels = peers::read()?;
    let machine = Machine::look();
    println!("{machine}");

    let extent = Extent {
        quick: options.quick,
        runs: if options.quick { 1 } else { options.runs as usize },
    };
    let all = measure(options, extent)?;
    let mut plots = Vec::new();
    for results in &all {
        plots.push(draw(&folder, results, &levels, machine.factor())?);
    }
    let short = readme::summary(&all, &levels, machine.factor());
    let extra = short.join("\n");
    tables::write_markdown(&folder.join("report.md"), &machine, &all, &extra, &plots)?;
    tables::write_csv(&folder.join("report.csv"), &all)?;
    if options.readme {
        for (page, table) in ["README.md", "src/guide/performance.md"].into_iter().zip(&short) {
            readme::insert(&repository(page), &format!("{machine}\n\n{table}"))?;
        }
    }
    println!("\n{extra}");
    println!("{} s; tables and plots are in {}", begun.elapsed().as_secs(), folder.display());
    readme::check(&all)
}

/// Runs all jobs of the scenes asked for behind a progress bar: all of them once, then all again. What else a
/// machine does comes and goes over minutes, and so meets a run or two of each job, not all runs of a few.
fn measure(options: &Options, extent: Extent) -> Outcome<Vec<Results<'static>>> {
    let asked = |(name, _): &&(&str, _)| {
        options.scenes.is_empty() || options.scenes.iter().any(|scene| scene == name)
    };
    let scenes: Vec<_> = scenes::ALL.iter().filter(asked).collect();
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} {elapsed} {msg:30!}")?;
    let bar = ProgressBar::new(0).with_style(style);
    let mut all = Vec::new();
    let built: Vec<(&str, Scene<'static>)> = scenes
        .iter()
        .map(|(name, build)| {
            bar.set_message(format!("{name}: its reference"));
            let scene = build(extent)?;
            bar.inc_length((scene.jobs.len() * extent.runs.max(1)) as u64);
            Ok((*name, scene))
        })
        .collect::<Outcome<_>>()?;
    let mut runs: Vec<Vec<Runs<'_>>> =
        built.iter().map(|(_, scene)| scene.jobs.iter().map(Runs::new).collect()).collect();
    for _ in 0..extent.runs.max(1) {
        for ((name, scene), runs) in built.iter().zip(&mut runs) {
            for (job, runs) in scene.jobs.iter().zip(runs) {
                bar.set_message(format!("{name}: {}", job.method));
                if !runs.is_done() {
                    runs.once()?;
                }
                bar.inc(1);
            }
        }
    }
    let points: Vec<Vec<_>> =
        runs.into_iter().map(|runs| runs.into_iter().map(Runs::point).collect()).collect();
    for ((_, scene), points) in built.into_iter().zip(points) {
        let results = Results { scene, points };
        bar.suspend(|| tables::print(&results));
        all.push(results);
    }
    bar.finish_and_clear();
    Ok(all)
}

/// Draws a scene's plots, and gives their files.
fn draw(
    folder: &Path,
    results: &Results<'_>,
    levels: &[peers::Level],
    factor: f64,
) -> Outcome<Vec<String>> {
    let mut files = Vec::new();
    for plot in &results.scene.plots {
        let metric = results.scene.errors[plot.metric].name.to_lowercase().replace([' ', '/'], "_");
        let file = format!("{}_{metric}{}.svg", results.scene.name, plot.against.names().0);
        plot::draw(&folder.join(&file), results, plot, levels, factor)?;
        files.push(file);
    }
    Ok(files)
}
