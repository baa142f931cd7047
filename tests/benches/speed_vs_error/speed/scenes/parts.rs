//! What each optional part costs: a cloth that hangs or lies, with and without it, and with it where it
//! has nothing to do.

use std::sync::Arc;

use bevy::math::{
    Vec3,
    primitives::{Cuboid, Sphere},
};
use bevy_drape::{
    sdf::{BakeSettings, DistanceField, SignedDistance},
    solver::{
        Air, ClothSolver, Collider, DampingForm, MassLumping, Material, PinMotion, Pose, Settings,
        SoftPin, Wind,
    },
};

use super::super::run::{self, Method, Run, cloth, still};
use super::super::{Extent, Job, Measured, Metric, Outcome, Scene};
use super::{Sheet, ball};

const N: usize = 64;
const SUBSTEPS: u32 = 20;

/// A cloth of 64 x 64 and what surrounds it.
struct Setup {
    cloth: ClothSolver,
    pins: Vec<PinMotion>,
    /// Shapes, where they are, and whether their impulses are asked for.
    solids: Vec<(Arc<dyn SignedDistance>, Pose, bool)>,
    wind: Wind<'static>,
}

/// Nothing but threads and shear, under gravity.
fn bare() -> Material {
    Material {
        flexural_rigidity: 0.0,
        damping: 0.0,
        max_strain: 10.0,
        ..run::material(1.0 / (N - 1) as f64)
    }
}

impl Setup {
    fn new(material: Material, method: Method) -> Outcome<Self> {
        let settings = method.settings(SUBSTEPS, MassLumping::Lumped);
        let mut cloth = cloth(&Sheet::upright(N, 1.0), &method, material, settings)?;
        cloth.set_pins(&[0, N as u32 - 1])?;
        let pins = still(&cloth);
        Ok(Self { cloth, pins, solids: Vec::new(), wind: Wind::default() })
    }

    /// The cloth lies on a ball, held by nothing.
    fn lying(solid: Option<Arc<dyn SignedDistance>>) -> Outcome<Self> {
        let (method, material) = (Method::THREADS, bare());
        let settings = method.settings(SUBSTEPS, MassLumping::Lumped);
        let cloth = cloth(&Sheet::flat(N, 1.0, 0.006), &method, material, settings)?;
        let place = Pose::from_translation(Vec3::NEG_Y * 0.5);
        let solids = solid.into_iter().map(|solid| (solid, place, false)).collect();
        Ok(Self { cloth, pins: Vec::new(), solids, wind: Wind::default() })
    }

    fn with(material: Material) -> Outcome<Self> {
        Self::new(material, Method::THREADS)
    }

    fn measured(self, frames: usize) -> Outcome<Measured> {
        let colliders: Vec<_> = self
            .solids
            .iter()
            .map(|(shape, pose, measured)| Collider {
                measured: *measured,
                ..Collider::new(&**shape, *pose)
            })
            .collect();
        let mut run = Run::new(self.cloth, &colliders);
        (run.pins, run.wind) = (self.pins, self.wind);
        run.frames(frames);
        let measured = run.measured(Vec::new());
        measured.failed.clone().map_or(Ok(measured), |why| Err(why.into()))
    }
}

/// A part: what it is measured against, and with it.
type Pair = (&'static str, fn() -> Outcome<Setup>, fn() -> Outcome<Setup>);

fn sphere() -> Arc<dyn SignedDistance> {
    Arc::new(Sphere::new(0.5))
}

/// The same ball as a field of 64 cells.
fn field() -> Outcome<Arc<dyn SignedDistance>> {
    let (positions, indices) = ball::triangles(24);
    let settings = BakeSettings::for_mesh(&positions, 64);
    Ok(Arc::new(DistanceField::bake(&positions, &indices, &settings)?))
}

fn beside(solid: Arc<dyn SignedDistance>, distance: f32) -> Outcome<Setup> {
    let mut setup = Setup::with(bare())?;
    setup.solids = vec![(solid, Pose::from_translation(Vec3::Z * distance), false)];
    Ok(setup)
}

const PAIRS: [Pair; 20] = [
    ("a strain limit of 50 %, never reached", plain, || {
        Setup::with(Material { max_strain: 0.5, ..bare() })
    }),
    ("a strain limit of 5 %, at work", plain, || {
        Setup::with(Material { max_strain: 0.05, ..bare() })
    }),
    ("shear springs", || Setup::with(Material { shear_stiffness: 0.0, ..bare() }), plain),
    ("bending, second differences", plain, || {
        Setup::with(Material { flexural_rigidity: 1e-5, ..bare() })
    }),
    ("damping, axial", plain, || {
        Setup::with(Material { damping: run::damping(1.0 / (N - 1) as f64) as f32, ..bare() })
    }),
    ("damping, relative", plain, || {
        let damping = run::damping(1.0 / (N - 1) as f64) as f32;
        Setup::with(Material { damping, damping_form: DampingForm::Relative, ..bare() })
    }),
    ("drag, linear", plain, || Setup::with(Material { drag: 0.5, ..bare() })),
    ("tethers to two pins", || Setup::new(bare(), Method::UNTETHERED), plain),
    (
        "tethers, of a cloth without pins",
        || {
            let mut setup = Setup::lying(Some(sphere()))?;
            let settings = *setup.cloth.settings();
            setup.cloth.set_settings(Settings { tethers: false, ..settings })?;
            Ok(setup)
        },
        || Setup::lying(Some(sphere())),
    ),
    ("air, still", plain, || {
        let mut setup = Setup::with(bare())?;
        setup.cloth.set_air(Some(Air::default()))?;
        Ok(setup)
    }),
    ("wind, for a cloth without air", plain, || {
        let mut setup = Setup::with(bare())?;
        setup.wind.velocity = Vec3::new(1.0, 0.0, 6.0);
        Ok(setup)
    }),
    ("a ball far away", plain, || beside(sphere(), 50.0)),
    ("a ball near, that nothing touches", plain, || beside(sphere(), 0.9)),
    ("a field near, that nothing touches", plain, || beside(field()?, 0.9)),
    ("a ball that it lies on", || Setup::lying(None), || Setup::lying(Some(sphere()))),
    (
        "a field in place of the ball",
        || Setup::lying(Some(sphere())),
        || Setup::lying(Some(field()?)),
    ),
    ("edges, on a cube", || on_a_cube(false), || on_a_cube(true)),
    (
        "an impulse asked for",
        || Setup::lying(Some(sphere())),
        || {
            let mut setup = Setup::lying(Some(sphere()))?;
            setup.solids[0].2 = true;
            Ok(setup)
        },
    ),
    ("64 soft pins", plain, || {
        let mut setup = Setup::with(bare())?;
        let last = (N * (N - 1)) as u32..(N * N) as u32;
        let spring = |particle| SoftPin { particle, stiffness: 1.0, damping: 0.01 };
        setup.cloth.set_soft_pins(&last.clone().map(spring).collect::<Vec<_>>())?;
        let target = |particle| PinMotion::still(setup.cloth.position(particle as usize));
        setup.pins.extend(last.map(target));
        Ok(setup)
    }),
    ("a mesh in place of a sheet", plain, || Setup::new(bare(), Method::GRAPH)),
];

fn plain() -> Outcome<Setup> {
    Setup::with(bare())
}

/// A usual cloth that has come to lie on a cube, whose edges are held or not.
fn on_a_cube(edges: bool) -> Outcome<Setup> {
    const SETTLING: usize = 128;
    let (method, material) = (Method::THREADS, Material::USUAL);
    let settings = Settings { edges, ..method.settings(SUBSTEPS, MassLumping::Lumped) };
    let cloth = cloth(&Sheet::flat(N, 1.6, 0.41), &method, material, settings)?;
    let cube: Arc<dyn SignedDistance> = Arc::new(Cuboid::new(0.8, 0.8, 0.8));
    let mut setup = Setup { cloth, pins: Vec::new(), solids: Vec::new(), wind: Wind::default() };
    let collider = Collider::new(&*cube, Pose::IDENTITY);
    let mut run = Run::new(setup.cloth, core::slice::from_ref(&collider));
    run.frames(SETTLING);
    setup.cloth = run.cloth;
    setup.solids = vec![(cube, Pose::IDENTITY, false)];
    Ok(setup)
}

/// Runs both in turns, several times anew, as where a cloth lies in memory counts too.
fn compare(pair: &Pair, rounds: usize) -> Outcome<Measured> {
    const FRAMES: usize = 40;
    let (_, without, with) = pair;
    let (mut without_times, mut with_times) = (Vec::new(), Vec::new());
    let (mut work, mut allocations) = (0, 0.0_f64);
    for round in 0..rounds {
        let (a, b) = if round % 2 == 0 {
            let first = without()?.measured(FRAMES)?;
            (first, with()?.measured(FRAMES)?)
        } else {
            let second = with()?.measured(FRAMES)?;
            (without()?.measured(FRAMES)?, second)
        };
        without_times.extend(a.frames);
        with_times.extend(b.frames);
        (work, allocations) = (b.work, allocations.max(b.allocations));
    }
    let median = |times: &[f64]| {
        let mut times = times.to_vec();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    let (before, after) = (median(&without_times), median(&with_times));
    // Not errors, and so not the same in every run: see `scene`.
    let errors = vec![before, after, 100.0 * (after / before - 1.0)];
    Ok(Measured { frames: with_times, errors, work, allocations, failed: None, varies: true })
}

pub fn scene(extent: Extent) -> Outcome<Scene<'static>> {
    let rounds = if extent.quick { 2 } else { 8 };
    let job = |pair: &'static Pair| Job {
        method: pair.0.into(),
        n: N,
        knob: format!("{SUBSTEPS} substeps"),
        run: Box::new(move || compare(pair, rounds)),
    };
    Ok(Scene {
        name: "parts",
        title: "What each optional part costs",
        about: "64 x 64 particles, 20 substeps, threads and shear: a curtain that hangs from two corners, or (contact) a sheet on a ball of \
                radius 0.5 m; medians of frames with and without the part, in turns, each pair set up anew eight times."
            .into(),
        errors: vec![
            Metric::new("without", "ms"),
            Metric::new("with", "ms"),
            Metric::new("more", "%"),
        ],
        jobs: PAIRS.iter().map(job).collect(),
        plots: Vec::new(),
    })
}
