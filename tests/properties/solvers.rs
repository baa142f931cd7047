//! Solvers: sheets and soups of triangles, of any material, pinned anyhow, in any surroundings.

use super::{choices::*, hold};
use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{
    Air, ClothSolver, Collider, Graph, Lattice, MassLumping, Material, PinMotion, Settings,
    SoftPin, SolverError, StepInput, Topology, Wind, Zone,
};
use proptest::{prelude::*, test_runner::TestCaseResult};
use std::sync::Arc;

/// A rest shape to be tried.
#[derive(Clone, Debug)]
enum Shape {
    /// Flat, of this size.
    Sheet(Vec2, usize, usize),
    /// Each particle off its place by a part of a cell.
    Uneven(f32, usize, usize, Vec<Vec3>),
    /// Corners, and triangles between them.
    Soup(Vec<Vec3>, Vec<[u32; 3]>),
}

fn shape() -> impl Strategy<Value = Shape> {
    let counts = || (2_usize..19, 2_usize..19);
    let size = (logarithmic(-4, 4), logarithmic(-4, 4)).prop_map(|(x, y)| Vec2::new(x, y));
    // Usual sizes more often than odd ones.
    let size = prop_oneof![2 => size, 3 => Just(Vec2::new(1.0, 0.8))];
    let uneven = (logarithmic(-2, 1), counts()).prop_flat_map(|(cell, (rows, columns))| {
        let off = prop::collection::vec(vector(0.45), rows * columns);
        off.prop_map(move |off| Shape::Uneven(cell, rows, columns, off))
    });
    let soup = (3_usize..24, logarithmic(-3, 3)).prop_flat_map(|(count, size)| {
        let corners = prop::collection::vec(vector(size), count);
        let index = 0..count as u32;
        let triangles = prop::collection::vec([index.clone(), index.clone(), index], 2..40);
        (corners, triangles).prop_map(|(corners, triangles)| Shape::Soup(corners, triangles))
    });
    prop_oneof![
        3 => (size, counts()).prop_map(|(size, (r, c))| Shape::Sheet(size, r, c)),
        2 => uneven,
        3 => soup,
    ]
}

impl Shape {
    fn topology(&self, lumping: MassLumping) -> Result<Topology, SolverError> {
        Ok(match self {
            Self::Sheet(size, rows, columns) => {
                Arc::new(Lattice::sheet(*size, *rows, *columns, lumping)?).into()
            }
            Self::Uneven(cell, rows, columns, off) => {
                let place =
                    |i: usize| Vec3::new((i % columns) as f32, 0.0, (i / columns) as f32) + off[i];
                let places: Vec<_> = (0..rows * columns).map(|i| place(i) * *cell).collect();
                Arc::new(Lattice::new(*rows, *columns, &places, lumping)?).into()
            }
            Self::Soup(corners, triangles) => {
                Arc::new(Graph::new(corners, &without_waste(triangles), lumping)?).into()
            }
        })
    }
}

/// Triangles of three corners, each once: most soups would be refused for the first that is none.
fn without_waste(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut known = std::collections::BTreeSet::new();
    let is_new = |t: &&[u32; 3]| {
        let mut sorted = **t;
        sorted.sort_unstable();
        sorted[0] != sorted[1] && sorted[1] != sorted[2] && known.insert(sorted)
    };
    triangles.iter().filter(is_new).copied().collect()
}

/// All that a solver is given, in a number of ticks.
#[derive(Clone, Debug)]
struct Case {
    shape: Shape,
    material: Material,
    settings: Settings,
    air: Option<Air>,
    place: Vec3,
    pins: Vec<u32>,
    soft: Vec<SoftPin>,
    velocity: Vec3,
    ticks: Vec<Tick>,
}

#[derive(Clone, Debug)]
struct Tick {
    dt: f32,
    gravity: Vec3,
    solids: Vec<Solid>,
    wind: Wind<'static>,
    zones: Vec<Zone>,
    /// Ways of the pins, from where they are.
    ways: Vec<Vec3>,
    /// What is put elsewhere, or given a velocity.
    put: Option<(u32, Vec3, bool)>,
    /// What it is made of from now on.
    material: Option<Material>,
}

fn tick() -> impl Strategy<Value = Tick> {
    let dt = prop_oneof![
        20 => Just(1.0 / 60.0),
        4 => logarithmic(-5, 0),
        1 => prop::sample::select(&[0.0, -0.01, f32::NAN, 2.0][..])
    ];
    let gravity = prop_oneof![3 => Just(Vec3::NEG_Y * 9.81), 1 => wild_vector(5)];
    let put = prop::option::weighted(0.2, (any::<u32>(), wild_vector(4), any::<bool>()));
    (
        dt,
        gravity,
        prop::collection::vec(solid(), 0..3),
        wind(),
        prop::collection::vec(zone(), 0..2),
        prop::collection::vec(wild_vector(2), 1..4),
        put,
        prop::option::weighted(0.1, material()),
    )
        .prop_map(|(dt, gravity, solids, wind, zones, ways, put, material)| Tick {
            dt,
            gravity,
            solids,
            wind,
            zones,
            ways,
            put,
            material,
        })
}

fn case() -> impl Strategy<Value = Case> {
    let held = (prop::collection::vec(any::<u32>(), 0..5), prop::collection::vec(soft_pin(), 0..3));
    let place = prop_oneof![4 => Just(Vec3::ZERO), 1 => any_vector(6)];
    (
        shape(),
        material(),
        settings(),
        air(),
        place,
        held,
        any_vector(3),
        prop::collection::vec(tick(), 1..5),
    )
        .prop_map(|(shape, material, settings, air, place, (pins, soft), velocity, ticks)| {
            Case { shape, material, settings, air, place, pins, soft, velocity, ticks }
        })
}

/// Everything that can be read is a number.
fn is_finite(solver: &ClothSolver) -> bool {
    let count = solver.topology().particle_count();
    let (low, high) = solver.bounds();
    let strain = solver.strain();
    let plan = solver.plan();
    (0..count).all(|i| solver.position(i).is_finite() && solver.velocity(i).is_finite())
        && low.is_finite()
        && high.is_finite()
        && strain.max.is_finite()
        && strain.mean.is_finite()
        && solver.largest_move().is_finite()
        && plan.margin >= 0.0
        && plan.margin <= 0.91
        && [plan.thread_stiffness, plan.shear_stiffness, plan.flexural_rigidity, plan.damping]
            .iter()
            .all(|constant| *constant >= 0.0 && constant.is_finite())
}

/// Makes the solver; what it refuses, it refuses.
fn make(case: &Case) -> Result<ClothSolver, SolverError> {
    let topology = case.shape.topology(case.settings.lumping)?;
    let count = topology.particle_count() as u32;
    let start: Vec<_> = topology.rest_positions().iter().map(|&p| p + case.place).collect();
    let mut solver = ClothSolver::new(topology, &start, case.material, case.settings)?;
    solver.set_pins(&case.pins.iter().map(|pin| pin % count).collect::<Vec<_>>())?;
    let soft = case.soft.iter().map(|pin| SoftPin { particle: pin.particle % count, ..*pin });
    solver.set_soft_pins(&soft.collect::<Vec<_>>())?;
    solver.set_air(case.air)?;
    for particle in 0..count as usize {
        solver.set_velocity(particle, case.velocity * (particle % 3) as f32)?;
    }
    Ok(solver)
}

/// Takes a tick. What it refuses leaves everything as it was, or the cloth where the tick began.
fn take(solver: &mut ClothSolver, tick: &Tick, home: &mut [Vec3]) -> TestCaseResult {
    let count = solver.topology().particle_count() as u32;
    if let Some((particle, to, moved)) = tick.put {
        let particle = (particle % count) as usize;
        let done = if moved {
            solver.set_position(particle, to)
        } else {
            solver.set_velocity(particle, to)
        };
        let refused = matches!(done, Err(SolverError::NonFinite { .. }));
        prop_assert!(done.is_ok() || refused, "{:?}", done);
    }
    if let Some(material) = tick.material {
        prop_assert_eq!(solver.set_material(material), Ok(()));
    }
    let ends: Vec<_> =
        home.iter().enumerate().map(|(i, &p)| p + tick.ways[i % tick.ways.len()]).collect();
    let pins: Vec<_> =
        home.iter().zip(&ends).map(|(&start, &end)| PinMotion { start, end }).collect();
    let colliders: Vec<_> = tick
        .solids
        .iter()
        .map(|solid| {
            let collider = Collider::new(&*solid.shape, solid.start).moving_to(solid.end);
            let collider = collider.with_friction(solid.friction);
            if solid.measured { collider.measured() } else { collider }
        })
        .collect();
    let wind = Wind { zones: &tick.zones, ..tick.wind };
    let input = StepInput {
        dt: tick.dt,
        gravity: tick.gravity,
        pins: &pins,
        colliders: &colliders,
        wind,
        ..StepInput::default()
    };
    match solver.tick(&input) {
        Ok(_) => home.copy_from_slice(&ends),
        Err(error) => {
            prop_assert!(!error.to_string().is_empty());
            // Only what is no length in any scene may come to what is no number.
            let huge = tick.solids.iter().any(|solid| {
                [solid.start, solid.end].iter().any(|pose| pose.translation.length() > 1e7)
            });
            prop_assert!(error != SolverError::Diverged || huge, "diverged, {}", solver.plan());
        }
    }
    for i in 0..colliders.len() {
        let given = solver.impulse(i);
        prop_assert!(given.linear.is_finite() && given.angular.is_finite(), "impulse {given:?}");
    }
    prop_assert!(is_finite(solver), "{}, strain {:?}", solver.plan(), solver.strain());
    Ok(())
}

#[test]
fn no_cloth_panics_or_stops_being_one() {
    let made = std::cell::Cell::new(0);
    hold(6000, &case(), |case| {
        let Ok(mut solver) = make(&case) else { return Ok(()) };
        made.set(made.get() + 1);
        prop_assert!(is_finite(&solver), "at first, {}", solver.plan());
        let held = solver.pins().iter().copied().chain(solver.soft_pins().map(|p| p.particle));
        let mut home: Vec<_> = held.map(|p| solver.position(p as usize)).collect();
        case.ticks.iter().try_for_each(|tick| take(&mut solver, tick, &mut home))
    });
    assert!(made.get() > 2000, "only {} cloths were made", made.get());
}
