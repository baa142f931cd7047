//! The cloths that the cases are run with, and what is looked at in each tick.

use super::solver::*;
use bevy::math::{Quat, Vec3};
use bevy_drape::solver::{
    ClothSolver, Collider, MassLumping, Material, PinMotion, Settings, StepInput, StretchMethod,
    Topology,
};
use std::sync::Arc;

/// Ticks of ten seconds.
pub const TEN_SECONDS: usize = 640;
/// Ticks of a second.
pub const SECOND: usize = 64;

/// A cloth to be made.
#[derive(Clone)]
pub struct Kind {
    pub what: String,
    pub topology: Topology,
    pub material: Material,
    pub settings: Settings,
}

/// A square of `side` metres and `n` x `n` particles in the xz plane, its middle at the origin, as a lattice
/// and as a mesh that is no grid; particles of the border have the same numbers and places in both.
pub fn squares(side: f32, n: usize) -> [(&'static str, Topology); 2] {
    let cell = side / (n - 1) as f32;
    let lattice = sheet(bevy::math::Vec2::splat(side), n, n, MassLumping::Lumped);
    let (positions, triangles) = jittered(n, n, cell, 0.25, 7);
    let half = Vec3::new(0.5, 0.0, 0.5) * side;
    let positions: Vec<_> = positions.iter().map(|&p| p - half).collect();
    let graph = bevy_drape::solver::Graph::new(&positions, &triangles, MassLumping::Lumped);
    [("lattice", lattice.into()), ("graph", Arc::new(graph.unwrap()).into())]
}

/// Lattice and mesh, at the automatic setting and at the stiffest.
pub fn kinds(side: f32, n: usize) -> Vec<Kind> {
    kinds_of(side, n, &[("automatic", usual()), ("stiffest", stiffest())])
}

/// Lattice and mesh of some materials.
pub fn kinds_of(side: f32, n: usize, materials: &[(&str, Material)]) -> Vec<Kind> {
    let mut kinds = Vec::new();
    for (name, topology) in squares(side, n) {
        for &(what, material) in materials {
            let (topology, settings) = (topology.clone(), Settings::default());
            kinds.push(Kind { what: format!("{name}, {what}"), topology, material, settings });
        }
    }
    kinds
}

impl Kind {
    pub fn with_form(mut self, form: StretchMethod) -> Self {
        self.what += &format!(", {form:?}");
        self.settings.stretch_method = form;
        self
    }

    /// The cloth in its rest shape, turned and moved.
    pub fn solver(&self, turned: Quat, moved: Vec3) -> ClothSolver {
        let rest = self.topology.rest_positions();
        let start: Vec<_> = rest.iter().map(|&p| turned * p + moved).collect();
        ClothSolver::new(self.topology.clone(), &start, self.material, self.settings).unwrap()
    }

    /// Hanging down from its first row at y = 0, a hundredth out of the xy plane: what crumples within a plane
    /// to the bit cannot unfold.
    pub fn hanging(&self) -> ClothSolver {
        let turn = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2 - 0.01);
        let top = self.topology.rest_positions()[0].z;
        self.solver(turn, Vec3::Y * top)
    }
}

/// Where pins are to be: those of the solver, from where they are at first, by a path of their home and the
/// time \[s\].
pub struct Led<'a> {
    home: Vec<Vec3>,
    path: &'a dyn Fn(Vec3, f32) -> Vec3,
}

impl<'a> Led<'a> {
    pub fn new(solver: &ClothSolver, path: &'a dyn Fn(Vec3, f32) -> Vec3) -> Self {
        Self { home: still(solver).iter().map(|pin| pin.start).collect(), path }
    }

    /// Their motions in a tick.
    pub fn motions(&self, tick: usize) -> Vec<PinMotion> {
        let at = |p: Vec3, tick: usize| (self.path)(p, tick as f32 * TICK);
        self.home.iter().map(|&p| PinMotion { start: at(p, tick), end: at(p, tick + 1) }).collect()
    }
}

/// A box that a cloth must stay in.
#[derive(Clone, Copy)]
pub struct Within(pub Vec3, pub Vec3);

impl Within {
    /// A cube.
    pub fn cube(half: f32) -> Self {
        Self(Vec3::splat(-half), Vec3::splat(half))
    }
}

/// Looks at every particle: its place and its velocity are finite, and it is in the box.
#[track_caller]
pub fn look(solver: &ClothSolver, what: &str, within: Within) {
    for i in 0..solver.topology().particle_count() {
        let (p, v) = (solver.position(i), solver.velocity(i));
        assert!(p.is_finite() && v.is_finite(), "{what}: particle {i} at {p}, {v} m/s");
        let inside = p.cmpge(within.0) & p.cmple(within.1);
        assert!(inside.all(), "{what}: particle {i} at {p}, {v} m/s, {}", solver.plan());
    }
}

/// Takes a tick under gravity, and looks.
#[track_caller]
pub fn step(
    solver: &mut ClothSolver,
    what: &str,
    within: Within,
    gravity: Vec3,
    pins: &[PinMotion],
    colliders: &[Collider<'_>],
) {
    let input = StepInput { dt: TICK, gravity, pins, colliders, ..StepInput::default() };
    solver.tick(&input).unwrap_or_else(|error| panic!("{what}: {error}, {}", solver.plan()));
    look(solver, what, within);
}

/// Takes ticks with the pins where they are, and looks at each.
#[track_caller]
pub fn steps(
    solver: &mut ClothSolver,
    what: &str,
    ticks: usize,
    within: Within,
    gravity: Vec3,
    colliders: &[Collider<'_>],
) {
    let pins = still(solver);
    for _ in 0..ticks {
        step(solver, what, within, gravity, &pins, colliders);
    }
}

/// The largest strain of a thread.
pub fn strain(solver: &ClothSolver) -> f64 {
    solver.strain().max.into()
}
