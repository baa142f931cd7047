//! A fingerprint of each of a list of scenes: what a change that should change nothing is compared by.
//!
//! Truth: bit equality. Each scene has one fingerprint, whatever the instruction set and the number of threads. The
//! fingerprints themselves are printed, not held to: a change of the numerics changes them. Before and after one that does not,
//!
//! ```sh
//! cargo test --test solver fingerprints -- --nocapture
//! ```
//!
//! prints the same lines.

use std::{collections::BTreeSet, sync::Arc};

use bevy::math::{
    Vec2, Vec3,
    primitives::{Cone, Cuboid, Cylinder, InfinitePlane3d, Sphere},
};
use bevy_drape::{
    hang::{Relaxation, relax},
    sdf::{
        BakeSettings, DistanceField, SignedDistance,
        shapes::{CapsuleBetween, HeightField, Shell},
    },
    solver::{
        Air, Bending, ClothSolver, Collider, DampingForm, Gusts, Integrator, Isa, Lattice,
        MassLumping, Material, PinMotion, Pose, PushOn, PushWith, Settings, SoftPin, StepInput,
        StretchMethod, Topology, Wind, WindFlow, WindShape, Zone,
    },
};

use crate::support::solver::*;

/// One of the scenes: a cloth, and what surrounds it.
struct Scene {
    name: &'static str,
    solver: fn() -> ClothSolver,
    ticks: usize,
    solids: &'static [Solid],
    /// The pins, and the targets of soft pins, move along [m/s].
    drawn: Vec3,
    /// A wind blows, in gusts and from a zone.
    windy: bool,
    /// Particles are pushed in every fourth tick.
    pushed: bool,
}

/// A collider, and how it moves [m/s].
struct Solid {
    shape: Shape,
    at: Vec3,
    velocity: Vec3,
}

enum Shape {
    Ground,
    Ball(f32),
    Cube(f32),
    Limb,
    Post,
    Spike,
    Surface,
    Baked,
    Hills,
}

const GROUND: Solid = Solid { shape: Shape::Ground, at: Vec3::ZERO, velocity: Vec3::ZERO };
const CUBE: Solid =
    Solid { shape: Shape::Cube(0.4), at: Vec3::new(0.03, 0.2, 0.0), velocity: Vec3::ZERO };
const BALL: Solid = Solid {
    shape: Shape::Ball(0.25),
    at: Vec3::new(0.0, -0.6, 0.6),
    velocity: Vec3::new(0.0, 0.0, -2.0),
};

const STILL: Scene = Scene {
    name: "",
    solver: || unreachable!(),
    ticks: 40,
    solids: &[],
    drawn: Vec3::ZERO,
    windy: false,
    pushed: false,
};

/// Particles that are far apart beside what they lie on: edges and faces are held.
const COARSE: Scene = Scene {
    solver: || above(&sheet(Vec2::splat(1.0), 16, 16, MassLumping::Lumped), 0.33),
    ticks: 48,
    ..STILL
};
const LIMB: Solid =
    Solid { shape: Shape::Limb, at: Vec3::new(0.0, 0.2, 0.0), velocity: Vec3::new(0.05, 0.0, 0.0) };
const POST: Solid =
    Solid { shape: Shape::Post, at: Vec3::new(0.0, 0.2, 0.0), velocity: Vec3::ZERO };
const SPIKE: Solid =
    Solid { shape: Shape::Spike, at: Vec3::new(0.0, 0.2, 0.0), velocity: Vec3::ZERO };
const SURFACE: Solid =
    Solid { shape: Shape::Surface, at: Vec3::new(0.0, 0.15, 0.0), velocity: Vec3::ZERO };
const BAKED: Solid =
    Solid { shape: Shape::Baked, at: Vec3::new(0.0, 0.15, 0.0), velocity: Vec3::ZERO };

const HILLS: Solid =
    Solid { shape: Shape::Hills, at: Vec3::new(0.0, 0.1, 0.0), velocity: Vec3::ZERO };

/// The scenes: what they are and what they have beside it.
const SCENES: &[Scene] = &[
    Scene {
        name: "sheet, threads, two corners",
        solver: || hung_sheet(Settings::default()),
        ..STILL
    },
    Scene {
        name: "sheet, springs, two corners",
        solver: || hung_sheet(settings(StretchMethod::ExplicitSprings, 24)),
        ..STILL
    },
    Scene {
        name: "sheet, midpoint method",
        solver: || hung_sheet(of_midpoint()),
        ticks: 12,
        ..STILL
    },
    Scene { name: "sheet, flexion, damping, friction of bending", solver: busy_sheet, ..STILL },
    Scene { name: "sheet, heavier and stiffer in places", solver: weighted_sheet, ..STILL },
    Scene {
        name: "sheet on a cube on the ground",
        solver: || above(&square(), 0.5),
        ticks: 64,
        solids: &[GROUND, CUBE],
        ..STILL
    },
    Scene {
        name: "curtain that a ball strikes",
        solver: || hung_sheet(Settings::default()),
        solids: &[BALL],
        ..STILL
    },
    Scene {
        name: "sheet in the wind, pins drawn, pushed",
        solver: || in_air(hung_sheet(Settings::default())),
        drawn: Vec3::new(0.4, 0.1, 0.0),
        windy: true,
        pushed: true,
        ..STILL
    },
    Scene {
        name: "sheet, soft pins drawn",
        solver: || softly(hung_sheet(Settings::default())),
        drawn: Vec3::new(0.4, 0.1, 0.0),
        ..STILL
    },
    Scene { name: "sheet that starts hung", solver: hung_first, ticks: 8, ..STILL },
    Scene {
        name: "sheet of 40,602, shared",
        solver: large_sheet,
        ticks: 6,
        solids: &[GROUND],
        ..STILL
    },
    Scene {
        name: "mesh, threads, two corners",
        solver: || hung_mesh(Settings::default()),
        ..STILL
    },
    Scene {
        name: "mesh, springs, flexion, damping",
        solver: || {
            let bending = Bending::Flexion;
            hung_mesh(Settings { bending, ..settings(StretchMethod::ExplicitSprings, 24) })
        },
        ..STILL
    },
    Scene {
        name: "mesh on a cube on the ground",
        solver: || above(&mesh(24, 24, 0.04, 0.25), 0.5),
        ticks: 64,
        solids: &[GROUND, CUBE],
        ..STILL
    },
    Scene {
        name: "mesh in the wind, soft pins drawn, pushed",
        solver: || softly(in_air(hung_mesh(Settings::default()))),
        drawn: Vec3::new(0.4, 0.1, 0.0),
        windy: true,
        pushed: true,
        ..STILL
    },
    Scene { name: "coarse sheet on a limb", solids: &[LIMB], ..COARSE },
    Scene { name: "coarse sheet on a post", solids: &[POST], ..COARSE },
    Scene { name: "coarse sheet on a spike", solids: &[SPIKE], ..COARSE },
    Scene { name: "coarse sheet on the surface of a crate", solids: &[SURFACE], ..COARSE },
    Scene { name: "coarse sheet on a baked crate", solids: &[BAKED], ..COARSE },
    Scene { name: "coarse sheet on hills", solids: &[HILLS], ..COARSE },
    Scene { name: "sheet, saved in mid-air and restored", solver: restored, ..STILL },
];

fn square() -> Arc<Lattice> {
    sheet(Vec2::splat(1.0), 33, 33, MassLumping::Lumped)
}

/// The material with everything on.
fn busy() -> Material {
    Material { damping: 0.002, damping_form: DampingForm::Axial, drag: 0.3, ..Material::USUAL }
}

fn of_midpoint() -> Settings {
    Settings { integrator: Integrator::Midpoint, ..settings(StretchMethod::ExplicitSprings, 40) }
}

fn hung_sheet(settings: Settings) -> ClothSolver {
    let lattice = curtain(Vec2::splat(1.0), 33, 37, MassLumping::Lumped);
    let mut solver = at_rest(&lattice, Vec3::new(0.01, 0.0, 0.02), Material::USUAL, settings);
    solver.set_pins(&[0, 36]).unwrap();
    solver
}

fn busy_sheet() -> ClothSolver {
    let lattice = sheet(Vec2::new(1.3, 0.9), 29, 41, MassLumping::Equal);
    let lumping = MassLumping::Equal;
    let settings = Settings { bending: Bending::Flexion, lumping, ..Settings::default() };
    let material = Material { bending_friction: 1e-4, ..busy() };
    let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings);
    solver.set_pins(&[0, 20, 40, 600]).unwrap();
    solver
}

fn weighted_sheet() -> ClothSolver {
    let even = Lattice::sheet(Vec2::splat(1.0), 33, 33, MassLumping::Lumped).unwrap();
    let count = even.rest_positions().len();
    let mass: Vec<f32> = (0..count).map(|i| 1.0 + (i % 7) as f32 * 0.3).collect();
    let stiffness: Vec<f32> = (0..count).map(|i| 0.5 + (i % 5) as f32 * 0.4).collect();
    let lattice = Arc::new(even.with_weights(&mass, &stiffness).unwrap());
    let mut solver = at_rest(&lattice, Vec3::ZERO, busy(), Settings::default());
    solver.set_pins(&[0, 32]).unwrap();
    solver
}

fn above<T: Clone + Into<Topology>>(topology: &T, height: f32) -> ClothSolver {
    at_rest(topology, Vec3::new(0.0, height, 0.0), busy(), Settings::default())
}

fn in_air(mut solver: ClothSolver) -> ClothSolver {
    solver.set_air(Some(Air::default())).unwrap();
    solver
}

/// In place of the pins.
fn softly(mut solver: ClothSolver) -> ClothSolver {
    let pins: Vec<_> = solver
        .pins()
        .iter()
        .map(|&particle| SoftPin { particle, stiffness: 40.0, damping: 0.5 })
        .collect();
    solver.set_pins(&[]).unwrap();
    solver.set_soft_pins(&pins).unwrap();
    solver
}

fn hung_first() -> ClothSolver {
    let mut solver = hung_sheet(Settings::default());
    let pins = still(&solver);
    let input = StepInput { dt: TICK, gravity: GRAVITY, pins: &pins, ..StepInput::default() };
    relax(&mut solver, &input, Relaxation { longest: 1.0, ..Relaxation::default() }).unwrap();
    solver
}

fn large_sheet() -> ClothSolver {
    let lattice = sheet(Vec2::splat(2.0), 202, 201, MassLumping::Lumped);
    let mut solver = at_rest(&lattice, Vec3::Y * 0.006, Material::USUAL, Settings::default());
    solver.set_pins(&[0, 200]).unwrap();
    solver
}

fn hung_mesh(settings: Settings) -> ClothSolver {
    let material = Material { damping: 0.001, ..Material::USUAL };
    let mut solver = at_rest(&mesh(25, 27, 0.04, 0.25), Vec3::ZERO, material, settings);
    solver.set_pins(&[0, 26]).unwrap();
    solver
}

fn restored() -> ClothSolver {
    let mut first = hung_sheet(Settings::default());
    run(&mut first, 20, GRAVITY, &[]);
    let mut second = hung_sheet(Settings::default());
    second.restore(&first.save()).unwrap();
    second
}

impl Scene {
    /// The fingerprint of what the cloth is after every tick.
    fn run(&self, isa: Isa) -> u64 {
        let mut solver = (self.solver)();
        solver.set_isa(isa);
        let home: Vec<Vec3> = still(&solver).iter().map(|pin| pin.start).collect();
        let shapes: Vec<Box<dyn SignedDistance>> =
            self.solids.iter().map(|solid| solid.shape.field()).collect();
        let zones = [Zone {
            shape: WindShape::Sphere(Sphere::new(0.8)),
            flow: WindFlow::Radial(3.0),
            pose: Pose::IDENTITY,
            falloff: 0.2,
        }];
        let mut fingerprint = Fingerprint::default();
        for tick in 0..self.ticks {
            let [from, to] = [tick, tick + 1].map(|tick| tick as f32 * TICK);
            let pins: Vec<_> = home
                .iter()
                .map(|&at| PinMotion { start: at + self.drawn * from, end: at + self.drawn * to })
                .collect();
            let at = |solid: &Solid, time: f32| Pose {
                translation: solid.at + solid.velocity * time,
                ..Pose::IDENTITY
            };
            let colliders: Vec<_> = self
                .solids
                .iter()
                .zip(&shapes)
                .map(|(solid, shape)| {
                    Collider::new(&**shape, at(solid, from)).moving_to(at(solid, to))
                })
                .collect();
            let gusts = Gusts { strength: 2.0, ..Gusts::default() };
            let velocity = Vec3::new(1.0, 0.0, 3.0);
            let blowing = Wind { velocity, gusts, time: f64::from(from), zones: &zones };
            let wind = if self.windy { blowing } else { Wind::default() };
            let input = StepInput {
                dt: TICK,
                gravity: GRAVITY,
                pins: &pins,
                colliders: &colliders,
                wind,
                ..StepInput::default()
            };
            if self.pushed && tick % 4 == 0 {
                solver.push(PushOn::All, PushWith::Force(Vec3::new(0.0, 0.2, 0.3))).unwrap();
                solver.push(PushOn::Particle(99), PushWith::Impulse(Vec3::X * 1e-3)).unwrap();
            }
            solver.tick(&input).unwrap();
            fingerprint.add(&bits(&solver));
        }
        assert!(solver.has_moved(), "{}: nothing moves", self.name);
        fingerprint.0
    }
}

impl Shape {
    fn field(&self) -> Box<dyn SignedDistance> {
        match *self {
            Self::Ground => Box::new(InfinitePlane3d::default()),
            Self::Ball(radius) => Box::new(Sphere::new(radius)),
            Self::Cube(side) => Box::new(Cuboid::from_length(side)),
            Self::Limb => {
                let half = Vec3::new(0.3, 0.02, 0.08);
                Box::new(CapsuleBetween { from: -half, to: half, radius: 0.1 })
            }
            Self::Post => Box::new(Cylinder::new(0.1, 0.24)),
            Self::Spike => Box::new(Cone::new(0.15, 0.24)),
            Self::Surface => {
                let (corners, indices) = crate_of(0.15);
                Box::new(Shell::new(&corners, &indices, 0.01).unwrap())
            }
            Self::Baked => {
                let (corners, indices) = crate_of(0.15);
                let settings = BakeSettings::for_mesh(&corners, 12);
                Box::new(DistanceField::bake(&corners, &indices, &settings).unwrap())
            }
            Self::Hills => {
                let height = |i: usize| 0.08 * ((i / 17 * 5 + i % 17 * 3) % 7) as f32 / 6.0;
                let heights: Vec<f32> = (0..17 * 17).map(height).collect();
                Box::new(HeightField::new(17, 17, heights, Vec2::splat(1.6)).unwrap())
            }
        }
    }
}

/// Corners and triangles of a cube of so much on each side of the middle.
fn crate_of(half: f32) -> (Vec<Vec3>, Vec<u32>) {
    let along = |corner: u32, axis: u32| if corner >> axis & 1 == 0 { -half } else { half };
    let corners = (0..8).map(|i| Vec3::new(along(i, 0), along(i, 1), along(i, 2))).collect();
    let sides =
        [[0, 2, 1, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 6, 3, 7], [0, 4, 2, 6], [1, 3, 5, 7]];
    (corners, sides.map(|[a, b, c, d]| [a, b, c, b, d, c]).concat())
}

#[test]
#[allow(clippy::print_stdout)]
fn each_scene_has_one() {
    let isas: Vec<_> = Isa::ALL.into_iter().filter(|isa| isa.is_available()).collect();
    let several = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut all = BTreeSet::new();
    for scene in SCENES {
        let fingerprint = alone.install(|| scene.run(Isa::detect()));
        println!("{fingerprint:016x}  {}", scene.name);
        for &isa in &isas {
            let shared = several.install(|| scene.run(isa));
            assert!(shared == fingerprint, "{}: {isa:?}, three threads: {shared:016x}", scene.name);
        }
        assert!(all.insert(fingerprint), "{}: as another scene", scene.name);
    }
}
