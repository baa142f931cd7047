//! What the report was measured on, and how fast that is.

use std::{env, fmt, fs, process::Command, thread};

use bevy_drape::solver::Isa;
use examples_common::repository;

/// What the yardstick takes where the peers were measured \[ms\].
pub const PEERS_YARDSTICK: f64 = 0.42;

/// A machine, a state of the source, and the yardstick's time.
pub struct Machine {
    cpu: String,
    threads: usize,
    commit: String,
    compiler: String,
    /// Milliseconds a frame of 64 x 64 particles at 20 substeps; `None` without a C++ compiler.
    yardstick: Option<f64>,
}

impl Machine {
    pub fn look() -> Self {
        let cpu = fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        });
        let commit = said("git", &["rev-parse", "--short", "HEAD"]);
        // What is written by the report itself is no change of what is measured.
        let only = ["status", "--porcelain", "--", "src", "examples", "tests", "Cargo.toml"];
        let changed = said("git", &only).is_some_and(|files| !files.is_empty());
        let commit = commit.map_or("unknown commit".into(), |commit| {
            format!("commit {commit}{}", if changed { ", with changes" } else { "" })
        });
        Self {
            cpu: cpu.unwrap_or_else(|| env::consts::ARCH.into()),
            threads: thread::available_parallelism().map_or(1, usize::from),
            commit,
            compiler: said("rustc", &["--version"]).unwrap_or_default(),
            yardstick: yardstick(),
        }
    }

    /// How many times as long this machine takes as that of the peers, by the yardstick.
    pub fn factor(&self) -> f64 {
        self.yardstick.map_or(1.0, |time| time / PEERS_YARDSTICK)
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cpu, threads, commit, compiler, .. } = self;
        write!(f, "{cpu}, {:?}, one of {threads} threads; {compiler}; {commit}. ", Isa::detect())?;
        match self.yardstick {
            Some(time) => write!(
                f,
                "The yardstick takes {time:.2} ms here against {PEERS_YARDSTICK} ms where the peers were measured: their times are scaled by {:.2}.",
                self.factor()
            ),
            None => write!(
                f,
                "No C++ compiler (c++) here to build the yardstick with: the peers' times are as recorded, on another machine."
            ),
        }
    }
}

/// What a command says.
fn said(program: &str, arguments: &[&str]) -> Option<String> {
    let folder = repository("");
    let done = Command::new(program).args(arguments).current_dir(folder).output().ok()?;
    done.status.success().then(|| String::from_utf8_lossy(&done.stdout).trim().to_owned())
}

/// Builds the yardstick and runs it: the best of three runs, as others on the machine only make it slower.
fn yardstick() -> Option<f64> {
    let source = repository("tests/benches/peers/yardstick.cpp");
    let binary = env::temp_dir().join(format!("bevy_drape_yardstick_{}", std::process::id()));
    let [source, output] = [&source, &binary].map(|path| path.to_string_lossy().into_owned());
    said("c++", &["-O3", "-march=native", "-ffast-math", "-o", &output, &source])?;
    let run = || {
        let text = said(&output, &[])?;
        let line = text.lines().find(|line| line.starts_with("n 64 substeps 20"))?;
        line.split(": ").nth(1)?.split(' ').next()?.parse::<f64>().ok()
    };
    let best = (0..3).filter_map(|_| run()).reduce(f64::min);
    // It is of no use any more, and in nobody's way if it stays.
    let _ = fs::remove_file(&binary);
    best
}
