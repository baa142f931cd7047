//! The report of speed against error: scenes, each with jobs that are points of its curves, run one after
//! another, timed, and written as tables and plots.

pub mod machine;
pub mod peers;
pub mod plot;
pub mod readme;
pub mod run;
pub mod scenes;
pub mod tables;

use std::{alloc::System, error::Error};

use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};

pub type Outcome<T> = Result<T, Box<dyn Error>>;

/// Counts allocations, of all threads.
#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// How much is measured.
#[derive(Clone, Copy)]
pub struct Extent {
    /// Fewer sizes and settings.
    pub quick: bool,
    /// Times that each job is run; less often where one takes long.
    pub runs: usize,
}

/// One scene: what it is, what is measured, and with what.
pub struct Scene<'a> {
    /// As it is asked for, and as its files are called.
    pub name: &'static str,
    pub title: &'static str,
    /// Constants, horizon, reference and its own error.
    pub about: String,
    pub errors: Vec<Metric>,
    pub jobs: Vec<Job<'a>>,
    pub plots: Vec<Plot>,
}

/// An error that a scene is measured by.
#[derive(Clone)]
pub struct Metric {
    pub name: &'static str,
    pub unit: &'static str,
}

impl Metric {
    pub const fn new(name: &'static str, unit: &'static str) -> Self {
        Self { name, unit }
    }

    /// With its unit, as tables and axes are headed.
    pub fn label(&self) -> String {
        if self.unit.is_empty() {
            self.name.into()
        } else {
            format!("{} [{}]", self.name, self.unit)
        }
    }
}

/// One setting of one method.
pub struct Job<'a> {
    /// The curve that it is a point of.
    pub method: String,
    /// Particles a side, or cells along a strip.
    pub n: usize,
    /// What is turned, in words.
    pub knob: String,
    pub run: Box<dyn Fn() -> Outcome<Measured> + 'a>,
}

/// What one run of a job came to.
#[derive(Clone, Default)]
pub struct Measured {
    /// Time of each frame of 1/60 s \[ms\].
    pub frames: Vec<f64>,
    /// In the order of the scene's metrics; NaN where one does not apply.
    pub errors: Vec<f64>,
    /// Particles times substeps in a frame; 0 where there are several cloths.
    pub work: usize,
    /// Allocations in a frame but the first; NaN where more than ticks is run.
    pub allocations: f64,
    /// Why the run is no success: drawn as a failure.
    pub failed: Option<String>,
    /// Its errors are themselves times, taken over as many runs as they need.
    pub varies: bool,
}

/// What a scene is drawn as.
pub struct Plot {
    /// The error drawn, of the scene's metrics.
    pub metric: usize,
    /// Only points of this size, if any.
    pub n: Option<usize>,
    /// Below this, `f32` rounds.
    pub floor: Option<f64>,
    /// What differs by less is chance: a disturbed start does as much.
    pub chaos: Option<f64>,
    /// Which error of the peers is the same, if they ran this scene.
    pub peers: Option<peers::Error>,
    pub against: Against,
}

/// What an error is drawn against.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Against {
    /// Milliseconds a frame.
    Time,
    /// Substeps a frame.
    Substeps,
    /// Particles a side.
    Resolution,
}

impl Against {
    /// As files are called and axes are headed.
    pub fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Time => ("", "milliseconds a frame of 1/60 s, one core"),
            Self::Substeps => ("_by_substeps", "substeps a frame of 1/60 s"),
            Self::Resolution => ("_by_resolution", "particles a side"),
        }
    }

    /// The place of a point; NaN where it has none, as what others took has no substeps.
    pub fn place(self, point: &Point) -> f64 {
        let substeps = || point.knob.strip_suffix(" substeps")?.parse().ok();
        let place = match self {
            Self::Time => Some(point.time.median),
            Self::Substeps => substeps(),
            Self::Resolution => substeps().map(|_| point.n as f64),
        };
        place.unwrap_or(f64::NAN)
    }
}

impl Plot {
    pub fn of(metric: usize) -> Self {
        Self { metric, n: None, floor: None, chaos: None, peers: None, against: Against::Time }
    }
}

/// A job's result over all its runs.
pub struct Point {
    pub method: String,
    pub n: usize,
    pub knob: String,
    pub time: Times,
    pub errors: Vec<f64>,
    /// Allocations in a frame; NaN where more than ticks is run.
    pub allocations: f64,
    pub failed: Option<String>,
}

/// Milliseconds a frame: the median frame and the 99th percentile of the median run, and the median frames
/// of the fastest and of the slowest run.
#[derive(Clone, Copy)]
pub struct Times {
    pub median: f64,
    pub p99: f64,
    pub least: f64,
    pub most: f64,
    /// Nanoseconds a particle and substep.
    pub each: f64,
}

/// A scene and its points.
pub struct Results<'a> {
    pub scene: Scene<'a>,
    pub points: Vec<Point>,
}

/// The runs of a job so far.
pub struct Runs<'a> {
    job: &'a Job<'a>,
    /// Median frame and 99th percentile of each \[ms\].
    times: Vec<(f64, f64)>,
    first: Option<Measured>,
    /// Milliseconds that they took.
    spent: f64,
}

impl<'a> Runs<'a> {
    pub fn new(job: &'a Job<'a>) -> Self {
        Self { job, times: Vec::new(), first: None, spent: 0.0 }
    }

    /// Whether no more runs are needed: what takes long is run less often.
    pub fn is_done(&self) -> bool {
        const LONG: f64 = 1500.0;
        self.spent > LONG || self.first.as_ref().is_some_and(|first| first.varies)
    }

    /// Runs it once more, which must come to the same errors.
    pub fn once(&mut self) -> Outcome<()> {
        let Job { method, knob, run, .. } = self.job;
        let run = run().map_err(|error| format!("{method}, {knob}: {error}"))?;
        self.spent += run.frames.iter().sum::<f64>();
        let mut frames = run.frames.clone();
        frames.sort_by(f64::total_cmp);
        let quantile = |part: f64| {
            let at = (part * frames.len() as f64) as usize;
            frames.get(at.min(frames.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
        };
        self.times.push((quantile(0.5), quantile(0.99)));
        let first =
            self.first.get_or_insert_with(|| Measured { frames: Vec::new(), ..run.clone() });
        let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
        if !first.errors.iter().zip(&run.errors).all(same) {
            return Err(format!("{method}, {knob}: another run, other errors").into());
        }
        Ok(())
    }

    /// What they came to; there is one at least.
    pub fn point(mut self) -> Point {
        let Measured { errors, work, allocations, failed, .. } = self.first.unwrap_or_default();
        self.times.sort_by(|a, b| a.0.total_cmp(&b.0));
        let none = (f64::NAN, f64::NAN);
        let (median, p99) = self.times.get(self.times.len() / 2).copied().unwrap_or(none);
        let [least, most] = [self.times.first(), self.times.last()].map(|t| t.unwrap_or(&none).0);
        let each = if work > 0 { median * 1e6 / work as f64 } else { f64::NAN };
        let time = Times { median, p99, least, most, each };
        let Job { method, n, knob, .. } = self.job;
        let (method, knob) = (method.clone(), knob.clone());
        Point { method, n: *n, knob, time, errors, allocations, failed }
    }
}
