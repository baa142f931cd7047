//! Cloths that hard things happen to, and what must hold of them in every frame.

use std::{fmt, sync::Arc};

use bevy::math::{DVec3, Vec2, Vec3};
use bevy_drape::solver::{
    ClothSolver, Collider, Graph, Lattice, MassLumping, Material, PinMotion, Settings, StepInput,
    StretchMethod, Topology, Weights,
};

use crate::support::solver::*;

/// A frame, and a tick \[s\].
pub const FRAME: f32 = 1.0 / 60.0;
/// Frames of a scene: ten seconds.
pub const SCENE: usize = 600;
/// The limit of strain that all cloths have here.
pub const LIMIT: f32 = 0.1;

/// What a case is run with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stuff {
    /// The default material, which takes the thread form.
    Automatic,
    /// The same in the form of explicit springs, whose constants the substeps do not carry.
    Springs,
    /// Every stiffness as high as is accepted.
    Stiffest,
}

/// Frames in which strain is to be back under twice its limit, for each of [`Stuff`] in its order.
pub type Within = [usize; 3];

/// A cloth in one of the ways in which each case is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// Whether it is made from a mesh.
    pub mesh: bool,
    pub stuff: Stuff,
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:?}", if self.mesh { "mesh" } else { "lattice" }, self.stuff)
    }
}

impl Variant {
    /// Lattice and mesh, each of all stuffs.
    pub fn all() -> impl Iterator<Item = Self> {
        [Stuff::Automatic, Stuff::Springs, Stuff::Stiffest]
            .into_iter()
            .flat_map(|stuff| [false, true].map(|mesh| Self { mesh, stuff }))
    }

    /// The entry that is of its stuff.
    pub fn of<T: Copy>(self, each: [T; 3]) -> T {
        each[self.stuff as usize]
    }

    pub fn material(self) -> Material {
        let usual = Material { max_strain: LIMIT, ..Material::USUAL };
        match self.stuff {
            Stuff::Automatic | Stuff::Springs => usual,
            Stuff::Stiffest => Material {
                thread_stiffness: 1e15,
                shear_stiffness: 1e15,
                flexural_rigidity: 1e9,
                ..usual
            },
        }
    }

    pub fn settings(self) -> Settings {
        let form = match self.stuff {
            Stuff::Springs => StretchMethod::ExplicitSprings,
            _ => StretchMethod::Automatic,
        };
        Settings { stretch_method: form, ..Settings::default() }
    }

    /// A sheet in the xz plane around the origin, `size` along x and z.
    pub fn sheet(self, size: Vec2, rows: usize, columns: usize) -> Topology {
        self.weighted(size, rows, columns, |_| 1.0, |_| 1.0)
    }

    /// The same, with factors of mass and stiffness by particle. A mesh has its inner particles a little
    /// off the grid, and diagonals at random.
    pub fn weighted(
        self,
        size: Vec2,
        rows: usize,
        columns: usize,
        mass: impl Fn(usize) -> f32,
        stiffness: impl Fn(usize) -> f32,
    ) -> Topology {
        let lattice = Lattice::sheet(size, rows, columns, MassLumping::Lumped).unwrap();
        let count = rows * columns;
        let mass: Vec<_> = (0..count).map(mass).collect();
        let stiffness: Vec<_> = (0..count).map(stiffness).collect();
        let even = mass.iter().chain(&stiffness).all(|&factor| factor == 1.0);
        if !self.mesh {
            let weighted = || lattice.clone().with_weights(&mass, &stiffness).unwrap();
            return Arc::new(if even { lattice } else { weighted() }).into();
        }
        let mut dice = Dice(7);
        let cell = size / Vec2::new((columns - 1) as f32, (rows - 1) as f32);
        let mut positions = lattice.rest_positions().to_vec();
        let mut triangles = Vec::new();
        for r in 0..rows - 1 {
            for c in 0..columns - 1 {
                let at = (r * columns + c) as u32;
                if r > 0 && c > 0 {
                    let off = dice.vector() * 0.2;
                    positions[at as usize] += Vec3::new(off.x * cell.x, 0.0, off.z * cell.y);
                }
                triangles.extend(halves(at, columns, dice.roll() > 0.0));
            }
        }
        let weights = Weights { mass: &mass, stiffness: &stiffness };
        let lumping = MassLumping::Lumped;
        Arc::new(Graph::with_weights(&positions, &triangles, lumping, weights).unwrap()).into()
    }
}

/// A cloth that is being watched.
pub struct Trial {
    pub name: String,
    variant: Variant,
    pub solver: ClothSolver,
    pub gravity: Vec3,
    pub pins: Vec<PinMotion>,
    /// Frames taken.
    pub frames: usize,
    springs: Vec<(usize, usize, f32)>,
    /// Corners of the box that all particles are to stay in.
    low: Vec3,
    high: Vec3,
    /// Counts frames from here, and forgets what was before.
    since: usize,
    pub worst: f32,
    pub strain: f32,
    /// The last frame in which strain was beyond twice its limit.
    strained: usize,
    pub fastest: f32,
    pub failures: Vec<String>,
}

impl Trial {
    /// A cloth with these pins at these places, that starts at others. Where it is pinned it may not leave
    /// what all its pins let it reach; elsewhere a case says where it is to stay.
    pub fn new(
        name: &str,
        variant: Variant,
        topology: Topology,
        pins: &[u32],
        start: impl Fn(usize, Vec3) -> Vec3,
    ) -> Self {
        Self::with(name, variant, topology, variant.material(), variant.settings(), pins, start)
    }

    pub fn with(
        name: &str,
        variant: Variant,
        topology: Topology,
        material: Material,
        settings: Settings,
        pins: &[u32],
        start: impl Fn(usize, Vec3) -> Vec3,
    ) -> Self {
        let rest = topology.rest_positions().to_vec();
        let places: Vec<_> = rest
            .iter()
            .enumerate()
            .map(|(i, &p)| if pins.contains(&(i as u32)) { p } else { start(i, p) })
            .collect();
        let springs = topology.structural_springs().collect();
        let mut solver = ClothSolver::new(topology, &places, material, settings).unwrap();
        solver.set_pins(pins).unwrap();
        let pins: Vec<_> =
            solver.pins().iter().map(|&p| PinMotion::still(rest[p as usize])).collect();
        let mut trial = Self {
            name: format!("{name}, {variant}"),
            variant,
            solver,
            gravity: GRAVITY,
            pins,
            frames: 0,
            springs,
            low: Vec3::splat(f32::NEG_INFINITY),
            high: Vec3::splat(f32::INFINITY),
            since: 0,
            worst: 0.0,
            strain: 0.0,
            strained: 0,
            fastest: 0.0,
            failures: Vec::new(),
        };
        trial.bound_by_pins();
        trial
    }

    /// Takes what the pins let the cloth reach, where they are to go in the next frame and where they are,
    /// and where it is now, as its bounds.
    pub fn bound_by_pins(&mut self) {
        let rest = self.solver.topology().rest_positions();
        let (mut low, mut high) = (Vec3::splat(f32::NEG_INFINITY), Vec3::splat(f32::INFINITY));
        for (&pin, motion) in self.solver.pins().iter().zip(&self.pins) {
            // Along the threads: a cloth may shear flat.
            let way = |p: &Vec3| (*p - rest[pin as usize]).abs().element_sum();
            let reach = rest.iter().map(way).fold(0.0, f32::max) * (1.0 + 2.0 * LIMIT);
            low = low.max(motion.start.min(motion.end) - reach);
            high = high.min(motion.start.max(motion.end) + reach);
        }
        let (least, most) = extent(&self.places());
        (self.low, self.high) = (low.min(least), high.max(most));
    }

    /// Asks it to stay in a box.
    pub fn keep_in(&mut self, low: Vec3, high: Vec3) {
        (self.low, self.high) = (low, high);
    }

    pub fn places(&self) -> Vec<Vec3> {
        positions(&self.solver)
    }

    /// Centre of mass, and its velocity.
    pub fn centre(&self) -> (DVec3, DVec3) {
        (centre(&self.solver), mean_velocity(&self.solver))
    }

    /// The largest strain of a structural spring.
    pub fn largest_strain(&self) -> f32 {
        let strain = |&(a, b, rest): &(usize, usize, f32)| {
            self.solver.position(a).distance(self.solver.position(b)) / rest - 1.0
        };
        self.springs.iter().map(strain).fold(-1.0, f32::max)
    }

    /// Measures from here on.
    pub fn measure_anew(&mut self) {
        self.since = self.frames;
        self.strained = self.frames;
        (self.worst, self.fastest) = (0.0, 0.0);
    }

    /// Takes a frame, and looks at every particle. Pins are from then on where they went.
    pub fn frame(&mut self, colliders: &[Collider<'_>]) {
        self.frames += 1;
        let frame = self.frames;
        let input = StepInput {
            dt: FRAME,
            gravity: self.gravity,
            pins: &self.pins,
            colliders,
            ..StepInput::default()
        };
        if let Err(error) = self.solver.tick(&input) {
            self.fail(format!("frame {frame}: {error}"));
        }
        for pin in &mut self.pins {
            pin.start = pin.end;
        }
        let places = self.places();
        let velocities = velocities(&self.solver);
        if !places.iter().chain(&velocities).all(|p| p.is_finite()) {
            return self.fail(format!("frame {frame}: not finite"));
        }
        let (low, high) = extent(&places);
        if low.cmplt(self.low).any() || high.cmpgt(self.high).any() {
            let (from, to) = (self.low, self.high);
            self.fail(format!("frame {frame}: {low} to {high} is out of {from} to {to}"));
        }
        self.fastest = velocities.iter().map(|v| v.length()).fold(self.fastest, f32::max);
        self.strain = self.largest_strain();
        self.worst = self.worst.max(self.strain);
        if self.strain > 2.0 * LIMIT {
            self.strained = frame;
        }
    }

    pub fn run(&mut self, frames: usize, colliders: &[Collider<'_>]) {
        for _ in 0..frames {
            self.frame(colliders);
        }
    }

    /// The rest of the ten seconds.
    pub fn run_on(&mut self) {
        self.run(SCENE - self.frames, &[]);
    }

    #[track_caller]
    pub fn fail(&mut self, what: String) {
        // One tells what is wrong; six hundred do not tell more.
        if self.failures.len() < 3 {
            self.failures.push(format!("{}: {what}", self.name));
        }
    }

    pub fn require(&mut self, holds: bool, what: impl FnOnce(&Self) -> String) {
        if !holds {
            let what = what(self);
            self.fail(what);
        }
    }

    /// Frames until strain was back under twice its limit for good.
    pub fn recovery(&self) -> usize {
        self.strained - self.since
    }

    /// Ends the measurement: strain is to have been back within so many frames, and to have stayed.
    pub fn recovers_within(&mut self, within: Within) {
        let most = self.variant.of(within);
        self.print(&format!("after {} frames of {most}", self.recovery()));
        self.require(self.recovery() <= most, |t| {
            format!("recovered after {} frames, more than {most}", t.recovery())
        });
    }

    /// Ends the measurement of what does not recover: strain is never to have been beyond a bound, nor at
    /// the end beyond another.
    pub fn strains_at_most(&mut self, ever: [f32; 3], at_last: [f32; 3]) {
        let (ever, at_last) = (self.variant.of(ever), self.variant.of(at_last));
        let percent = |part: f32| part * 100.0;
        self.print(&format!("at most {} %, in the end {} %", percent(ever), percent(at_last)));
        self.require(self.worst <= ever, |t| format!("strain of {}, more than {ever}", t.worst));
        self.require(self.strain <= at_last, |t| {
            format!("strain of {} in the end, more than {at_last}", t.strain)
        });
    }

    #[allow(clippy::print_stdout)]
    fn print(&self, asked: &str) {
        let [worst, now, twice] = [self.worst, self.strain, 2.0 * LIMIT].map(|part| part * 100.0);
        println!(
            "{}: strain {worst:.1} %, in the end {now:.2} %; under {twice} % after {} frames; {:.1} m/s; asked: {asked}",
            self.name,
            self.recovery(),
            self.fastest
        );
    }
}

/// Fails with all that the trials found.
#[track_caller]
pub fn verdict(trials: impl IntoIterator<Item = Trial>) {
    let failures: Vec<_> = trials.into_iter().flat_map(|trial| trial.failures).collect();
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

/// Both corners of the first row.
pub fn corners(columns: usize) -> [u32; 2] {
    [0, columns as u32 - 1]
}
