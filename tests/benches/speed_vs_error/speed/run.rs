//! Running a solver frame by frame, timed.

use std::time::Instant;

use bevy::math::{DVec3, Vec3};
use bevy_drape::solver::{
    ClothSolver, Collider, DampingForm, MassLumping, Material, PinMotion, Settings, StepInput,
    StretchMethod, Substeps, Wind,
};
use stats_alloc::Region;

use super::{ALLOCATOR, Measured, Outcome};

pub const FRAME: f32 = 1.0 / 60.0;
pub const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);

/// The constants of all scenes that do not say otherwise.
pub const THREAD: f64 = 1000.0;
pub const SHEAR: f64 = 300.0;
pub const RIGIDITY: f64 = 1e-5;
pub const DENSITY: f64 = 0.2;

/// `C = 0.02 sqrt(ks m)` of an inner particle of a square cell \[N s/m\].
pub fn damping(cell: f64) -> f64 {
    0.02 * (THREAD * DENSITY * cell * cell).sqrt()
}

/// The material of all scenes that do not say otherwise, for cells of this size \[m\].
pub fn material(cell: f64) -> Material {
    Material {
        area_density: DENSITY as f32,
        thread_stiffness: THREAD as f32,
        shear_stiffness: SHEAR as f32,
        flexural_rigidity: RIGIDITY as f32,
        bending_friction: 0.0,
        damping: damping(cell) as f32,
        damping_form: DampingForm::Axial,
        drag: 0.0,
        max_strain: 0.1,
        friction: 0.5,
        thickness: 0.005,
    }
}

/// How a cloth is solved: what the curves of a plot differ by.
#[derive(Clone, Copy, PartialEq)]
pub struct Method {
    pub name: &'static str,
    pub form: StretchMethod,
    pub passes: u32,
    pub tethers: bool,
    pub graph: bool,
}

impl Method {
    pub const THREADS: Self = Self {
        name: "threads",
        form: StretchMethod::ImplicitThreads,
        passes: 1,
        tethers: true,
        graph: false,
    };
    pub const UNTETHERED: Self =
        Self { name: "threads, no tethers", tethers: false, ..Self::THREADS };
    pub const GRAPH: Self = Self { name: "mesh", graph: true, ..Self::THREADS };
    pub const SPRINGS: Self =
        Self { name: "springs", form: StretchMethod::ExplicitSprings, ..Self::THREADS };

    pub fn settings(&self, substeps: u32, lumping: MassLumping) -> Settings {
        Settings {
            substeps: Substeps::Fixed(substeps),
            stretch_method: self.form,
            provot_passes: self.passes,
            tethers: self.tethers,
            lumping,
            ..Settings::default()
        }
    }
}

/// Pins that stay where their particles are.
pub fn still(cloth: &ClothSolver) -> Vec<PinMotion> {
    cloth.pins().iter().map(|&p| PinMotion::still(cloth.position(p as usize))).collect()
}

pub fn places(cloth: &ClothSolver) -> Vec<DVec3> {
    (0..cloth.topology().particle_count()).map(|i| cloth.position(i).as_dvec3()).collect()
}

/// A cloth that is run, and what came of it so far.
pub struct Run<'a> {
    pub cloth: ClothSolver,
    pub pins: Vec<PinMotion>,
    pub colliders: &'a [Collider<'a>],
    pub gravity: Vec3,
    pub wind: Wind<'a>,
    times: Vec<f64>,
    /// Allocations since the first frame, in which a pool of threads may yet make room for itself.
    allocations: usize,
    failed: Option<String>,
}

impl<'a> Run<'a> {
    pub fn new(cloth: ClothSolver, colliders: &'a [Collider<'a>]) -> Self {
        let pins = still(&cloth);
        Self {
            cloth,
            pins,
            colliders,
            gravity: GRAVITY,
            wind: Wind::default(),
            times: Vec::new(),
            allocations: 0,
            failed: None,
        }
    }

    /// One frame. Once it failed, nothing.
    pub fn frame(&mut self) {
        let Self { cloth, pins, colliders, gravity, wind, times, allocations, failed } = self;
        if failed.is_some() {
            return;
        }
        let (gravity, wind) = (*gravity, *wind);
        let input = StepInput { dt: FRAME, gravity, pins, colliders, wind, ..StepInput::default() };
        let region = Region::new(ALLOCATOR);
        let before = Instant::now();
        let done = cloth.tick(&input);
        let time = before.elapsed();
        let made = region.change();
        if !times.is_empty() {
            *allocations += made.allocations + made.reallocations;
        }
        times.push(time.as_secs_f64() * 1e3);
        *failed = done.err().map(|error| error.to_string());
    }

    pub fn frames(&mut self, count: usize) {
        (0..count).for_each(|_| self.frame());
    }

    /// Runs until no particle is faster than 1e-4 m/s, for `most` frames at most and 360 at least: as
    /// many as a time is taken of.
    pub fn settle(&mut self, most: usize) {
        for frame in 0..most {
            self.frame();
            if frame >= 360 && frame % 15 == 0 && self.fastest() < 1e-4 {
                break;
            }
        }
    }

    pub fn fastest(&self) -> f64 {
        let count = self.cloth.topology().particle_count();
        (0..count).map(|i| f64::from(self.cloth.velocity(i).length())).fold(0.0, f64::max)
    }

    pub fn has_failed(&self) -> bool {
        self.failed.is_some()
    }

    /// What is measured, without the first second of a long run, while caches and branches warm up.
    pub fn measured(self, errors: Vec<f64>) -> Measured {
        const WARM: usize = 60;
        let warm = if self.times.len() > 3 * WARM { WARM } else { 0 };
        let work = self.cloth.topology().particle_count() * self.cloth.plan().substeps as usize;
        let broken = !errors.iter().all(|e| e.is_finite() || e.is_nan());
        let failed = self.failed.or(broken.then(|| "an error is not finite".into()));
        let allocations = self.allocations as f64 / self.times.len().saturating_sub(1) as f64;
        let frames = self.times[warm..].to_vec();
        Measured { frames, errors, work, allocations, failed, varies: false }
    }
}

/// Root of the mean square distance.
pub fn rms(a: &[DVec3], b: &[DVec3]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)).sum();
    (sum / a.len().max(1) as f64).sqrt()
}

/// A cloth, over any of the two topologies, that starts at rest where it is; on one core.
pub fn cloth(
    sheet: &super::scenes::Sheet,
    method: &Method,
    material: Material,
    settings: Settings,
) -> Outcome<ClothSolver> {
    let topology = sheet.topology(method.graph, settings.lumping)?;
    let mut cloth = ClothSolver::new(topology, &sheet.start(), material, settings)?;
    cloth.set_shared(false);
    Ok(cloth)
}

/// Numbers from -1 to 1 that are the same everywhere (an LCG of Knuth's).
pub fn dice(seed: u64) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
    }
}
