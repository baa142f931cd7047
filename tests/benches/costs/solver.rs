//! Costs in the solver: graphs, wind, and what contact and pins offer.

use std::{error::Error, sync::Arc, time::Instant};

use crate::turns::{Bound, Turns, Wrong, heading, in_turns, line};
use bevy::math::{Vec2, Vec3, bounding::Aabb3d, primitives::Sphere};
use bevy_drape::{
    sdf::{KnownShape, SdfSample, SignedDistance},
    solver::{
        Air, Backstop, ClothSolver, Collider, Graph, Gusts, Lattice, MassLumping, Material,
        PinMotion, Pose, Settings, SkinLimit, SkinMotion, SoftPin, StepInput, StretchMethod,
        Substeps, Topology, Wind, WindFlow, WindShape, Zone,
    },
};

const SUBSTEPS: u32 = 20;
const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);

/// A cloth of 2 m and what surrounds it.
#[derive(Clone)]
pub struct Scene<'a> {
    cloth: ClothSolver,
    pins: Vec<PinMotion>,
    skin: Vec<SkinMotion>,
    colliders: &'a [Collider<'a>],
    wind: Wind<'a>,
    ticks: u32,
}

impl<'a> Scene<'a> {
    pub fn new(topology: Topology, rigidity: f32) -> Result<Self, Box<dyn Error>> {
        let material = Material {
            area_density: 0.2,
            thread_stiffness: 2000.0,
            shear_stiffness: 20.0,
            flexural_rigidity: rigidity,
            bending_friction: 0.0,
            damping: 0.0,
            damping_form: Default::default(),
            drag: 0.2,
            max_strain: 0.1,
            friction: 0.5,
            thickness: 0.005,
        };
        let settings = Settings {
            stretch_method: StretchMethod::ImplicitThreads,
            substeps: Substeps::Fixed(SUBSTEPS),
            ..Settings::default()
        };
        let start = topology.rest_positions().to_vec();
        let cloth = ClothSolver::new(topology, &start, material, settings)?;
        let (wind, colliders) = (Wind::default(), &[][..]);
        Ok(Self { cloth, pins: Vec::new(), skin: Vec::new(), colliders, wind, ticks: 0 })
    }

    /// The same, whose particles alone are held.
    pub fn without_edges(mut self) -> Result<Self, Box<dyn Error>> {
        let settings = Settings { edges: false, ..*self.cloth.settings() };
        self.cloth.set_settings(settings)?;
        Ok(self)
    }

    /// The same, among these.
    pub fn among(self, colliders: &'a [Collider<'a>]) -> Self {
        Self { colliders, ..self }
    }

    /// The same, held by the corners of the first row.
    fn hung(mut self, n: usize) -> Result<Self, Box<dyn Error>> {
        self.cloth.set_pins(&[0, n as u32 - 1])?;
        self.pins = [0, n - 1].map(|p| PinMotion::still(self.cloth.position(p))).to_vec();
        Ok(self)
    }

    fn in_air(mut self, air: Air, wind: Wind<'a>) -> Result<Self, Box<dyn Error>> {
        self.cloth.set_air(Some(air))?;
        self.wind = wind;
        Ok(self)
    }

    /// Takes a tick, and tells its time \[us\]. One that fails leaves it where it is, and is found out
    /// at the end.
    fn tick(&mut self) -> f64 {
        let Self { pins, skin, colliders, .. } = self;
        let wind = Wind { time: f64::from(self.ticks) / 64.0, ..self.wind };
        let dt = 1.0 / 64.0;
        let input =
            StepInput { dt, gravity: GRAVITY, pins, skin, colliders, wind, ..StepInput::default() };
        let before = Instant::now();
        let done = self.cloth.tick(&input);
        self.ticks += u32::from(done.is_ok());
        before.elapsed().as_secs_f64() * 1e6
    }

    fn places(&self) -> Vec<Vec3> {
        (0..self.cloth.topology().particle_count()).map(|p| self.cloth.position(p)).collect()
    }
}

/// Times two scenes, which must go well, and to the same bits where they have to be `same`.
pub fn compare(
    name: &str,
    rounds: usize,
    (without, with): (&Scene, Scene),
    same: bool,
    wrong: &mut Wrong,
) -> Turns {
    let (mut without, mut with) = (without.clone(), with);
    let turns = in_turns(rounds, || without.tick(), || with.tick());
    for scene in [&without, &with] {
        let places = scene.places();
        let near = places.iter().all(|p| p.abs().max_element() < 30.0);
        wrong.unless(scene.ticks as usize == rounds && near, name, "a tick failed, or it left");
        let strain = scene.cloth.strain().p99;
        wrong.unless(strain < 0.1, name, &format!("strained by {strain}"));
    }
    wrong.unless(!same || without.places() == with.places(), name, "other bits");
    turns
}

/// A sheet as a graph; its inner vertices shifted by up to a quarter of a cell, and its diagonals mixed, where
/// it is `irregular`.
fn graph(lattice: &Lattice, n: usize, irregular: bool) -> Result<Topology, Box<dyn Error>> {
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 24) as f32
    };
    let mut places = lattice.rest_positions().to_vec();
    let mut triangles = Vec::new();
    for (at, place) in places.iter_mut().enumerate() {
        let (r, c) = (at / n, at % n);
        if irregular && r % (n - 1) > 0 && c % (n - 1) > 0 {
            let most = 0.5 * 2.0 / (n - 1) as f32;
            *place += Vec3::new(random() - 0.5, 0.0, random() - 0.5) * most;
        }
        if r + 1 < n && c + 1 < n {
            let [a, b, c, d] = [at, at + 1, at + n, at + n + 1].map(|p| p as u32);
            let other = irregular && random() < 0.5;
            triangles.extend(if other { [[a, c, b], [b, c, d]] } else { [[a, c, d], [a, d, b]] });
        }
    }
    Ok(Arc::new(Graph::new(&places, &triangles, MassLumping::Lumped)?).into())
}

pub fn graphs(n: usize, rounds: usize, wrong: &mut Wrong) -> Result<(), Box<dyn Error>> {
    let lattice = Arc::new(Lattice::sheet(Vec2::splat(2.0), n, n, MassLumping::Lumped)?);
    let meshes = [("its grid", false), ("an irregular mesh", true)]
        .map(|(name, irregular)| graph(&lattice, n, irregular).map(|graph| (name, graph)));
    heading(&format!("a graph, us a tick of {SUBSTEPS} substeps"), "lattice", "graph");
    for mesh in meshes {
        let (name, graph) = mesh?;
        for (bending, rigidity) in [("", 0.0), (", with bending", 1e-5)] {
            let without = Scene::new(lattice.clone().into(), rigidity)?.hung(n)?;
            let with = Scene::new(graph.clone(), rigidity)?.hung(n)?;
            let name = format!("{name}{bending}");
            let turns = compare(&name, rounds, (&without, with), false, wrong);
            line(&name, &turns, Bound::Times(3.0));
        }
    }
    Ok(())
}

pub fn wind(n: usize, rounds: usize, wrong: &mut Wrong) -> Result<(), Box<dyn Error>> {
    let lattice = Arc::new(Lattice::sheet(Vec2::splat(2.0), n, n, MassLumping::Lumped)?);
    let still = Scene::new(lattice.into(), 0.0)?.hung(n)?;
    let zone = |distance: f32| Zone {
        shape: WindShape::from(Sphere::new(1.5)),
        flow: WindFlow::Radial(5.0),
        falloff: 0.3,
        pose: Pose::from_translation(Vec3::new(distance, -0.5, -0.5)),
    };
    let (near, far) = ([zone(0.0)], vec![zone(100.0); 1000]);
    let air = Air::default();
    let steady = Wind { velocity: Vec3::new(1.0, 0.0, 6.0), ..Wind::default() };
    let gusts = Wind { gusts: Gusts { strength: 3.0, ..Gusts::default() }, ..steady };
    let zones = Wind { zones: &far, ..steady };
    let no_air = Scene { wind: zones, ..still.clone() };
    heading(&format!("wind, us a tick of {SUBSTEPS} substeps"), "without", "with");
    let in_wind = still.clone().in_air(air, steady)?;
    let far_zones = Scene { wind: zones, ..in_wind.clone() };
    for (name, without, with, same) in [
        ("wind and 1000 zones, for a cloth without air", &still, no_air, true),
        ("still air", &still, still.clone().in_air(air, Wind::default())?, false),
        ("a steady wind", &still, in_wind.clone(), false),
        ("gusts", &still, still.clone().in_air(air, gusts)?, false),
        ("a near zone", &still, still.clone().in_air(air, Wind { zones: &near, ..steady })?, false),
        ("1000 far zones, on top of a steady wind", &in_wind, far_zones, true),
    ] {
        let turns = compare(name, rounds, (without, with), same, wrong);
        line(name, &turns, Bound::None);
    }
    Ok(())
}

/// A ball whose sides no way is ever looked at for.
#[derive(Debug)]
struct Unswept(Sphere);

impl SignedDistance for Unswept {
    fn sample(&self, point: Vec3) -> SdfSample {
        self.0.sample(point)
    }

    fn bounds(&self) -> Option<Aabb3d> {
        self.0.bounds()
    }

    fn core_depth(&self) -> f32 {
        f32::INFINITY
    }

    fn known(&self) -> Option<KnownShape<'_>> {
        self.0.known()
    }
}

pub fn contact(n: usize, rounds: usize, wrong: &mut Wrong) -> Result<(), Box<dyn Error>> {
    let lattice = Arc::new(Lattice::sheet(Vec2::splat(2.0), n, n, MassLumping::Lumped)?);
    let (ball, unswept) = (Sphere::new(0.5), Unswept(Sphere::new(0.5)));
    let place = Pose::from_translation(Vec3::NEG_Y * 0.51);
    let (plain, measured) =
        ([Collider::new(&ball, place)], [Collider::new(&ball, place).measured()]);
    let unswept = [Collider::new(&unswept, place)];
    let free = Scene::new(lattice.clone().into(), 0.0)?;
    let on = |colliders| free.clone().among(colliders);
    heading("contact and pins, us a tick, draped on a ball", "without", "with");
    // Friction holds it on the ball for so long.
    let few = rounds.min(90);
    let name = "swept contact, of what is slow";
    let turns = compare(name, few, (&on(&unswept), on(&plain)), true, wrong);
    line(name, &turns, Bound::None);
    let name = "an impulse asked for";
    let turns = compare(name, few, (&on(&plain), on(&measured)), true, wrong);
    line(name, &turns, Bound::None);

    let hung = Scene::new(lattice.into(), 0.0)?.hung(n)?;
    let mut soft = hung.clone();
    let last_row = (n * (n - 1)) as u32..(n * n) as u32;
    let spring = |particle| SoftPin { particle, stiffness: 1.0, damping: 0.01 };
    soft.cloth.set_soft_pins(&last_row.clone().map(spring).collect::<Vec<_>>())?;
    let still = |particle| PinMotion::still(soft.cloth.position(particle as usize));
    soft.pins.extend(last_row.map(still));
    let name = format!("{n} soft pins, on a cloth that hangs");
    let turns = compare(&name, rounds, (&hung, soft), false, wrong);
    line(&name, &turns, Bound::None);
    Ok(())
}

/// A cloth that hangs, and the same held near where it hangs.
pub fn skin(n: usize, rounds: usize, wrong: &mut Wrong) -> Result<(), Box<dyn Error>> {
    let lattice = Arc::new(Lattice::sheet(Vec2::splat(2.0), n, n, MassLumping::Lumped)?);
    let bare = Scene::new(lattice.into(), 0.0)?.hung(n)?;
    let worn = |limit: SkinLimit| -> Result<Scene<'_>, Box<dyn Error>> {
        let mut worn = bare.clone();
        let count = n * n;
        worn.cloth.set_skin(Some(&vec![limit; count]))?;
        let still = |particle| SkinMotion {
            place: [bare.cloth.position(particle); 2],
            normal: [Vec3::Y; 2],
        };
        worn.skin = (0..count).map(still).collect();
        Ok(worn)
    };
    heading("skin, us a tick, a cloth that swings", "without", "with");
    let far = SkinLimit { max_distance: 10.0, ..SkinLimit::default() };
    let all =
        SkinLimit { backstop: Some(Backstop { distance: 10.0, radius: 20.0 }), drive: 0.1, ..far };
    for (name, limit, bound) in [
        ("a max distance", far, Bound::Percent(10.0)),
        ("max distance, backstop, drive", all, Bound::Percent(10.0)),
    ] {
        let turns = compare(name, rounds, (&bare, worn(limit)?), false, wrong);
        line(name, &turns, bound);
    }
    Ok(())
}
