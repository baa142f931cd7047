//! No allocation in a tick, nor in any of its stages: counted by the allocator itself.

#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

use bevy::math::{
    Mat3, Quat, Vec2, Vec3,
    primitives::{InfinitePlane3d, Sphere},
};
use bevy_drape::solver::{
    Air, Bending, ClothSolver, Collider, DampingForm, Graph, Gusts, Lattice, MassLumping, Material,
    Mobility, PinMotion, PinPull, Pose, PushOn, PushWith, RigidMotion, Settings, SoftPin,
    StepInput, StretchMethod, Substeps, Topology, Wind, WindFlow, WindShape, Zone,
};

thread_local! {
    /// Allocations of this thread: tests run side by side.
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call goes to the system's allocator as it came; counting touches no memory of
// theirs.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller keeps the contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract.
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller keeps the contract.
        unsafe { System.realloc(at, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations<T>(act: impl FnOnce() -> T) -> usize {
    let before = COUNT.with(Cell::get);
    std::hint::black_box(act());
    COUNT.with(Cell::get) - before
}

/// A cloth with everything on, pins enough for all tethers, and a motion for each.
fn busy(
    topology: Topology,
    form: StretchMethod,
    bending: Bending,
) -> (ClothSolver, Vec<PinMotion>) {
    let material = Material {
        area_density: 0.2,
        thread_stiffness: 300.0,
        shear_stiffness: 20.0,
        flexural_rigidity: 1e-5,
        bending_friction: 1e-4,
        damping: 0.002,
        damping_form: DampingForm::Axial,
        drag: 0.3,
        max_strain: 0.01,
        friction: 0.4,
        thickness: 0.005,
    };
    let settings = Settings {
        stretch_method: form,
        bending,
        substeps: Substeps::Fixed(5),
        ..Settings::default()
    };
    let start = topology.rest_positions().to_vec();
    let mut solver = ClothSolver::new(topology, &start, material, settings).unwrap();
    solver.set_pins(&[0, 34, 300, 350, 400, 664]).unwrap();
    let soft = [20, 90, 500].map(|particle| SoftPin { particle, stiffness: 9.0, damping: 0.1 });
    solver.set_soft_pins(&soft).unwrap();
    let soft = soft.map(|pin| pin.particle);
    solver.set_air(Some(Air::default())).unwrap();
    let pins = solver
        .pins()
        .iter()
        .chain(&soft)
        .map(|&p| PinMotion { start: start[p as usize], end: start[p as usize] + Vec3::Y * 0.001 })
        .collect();
    (solver, pins)
}

fn sheet() -> Topology {
    Arc::new(Lattice::sheet(Vec2::ONE, 19, 35, MassLumping::Lumped).unwrap()).into()
}

/// The same particles as a mesh: rectangles on one half, parallelograms on the other.
fn mesh() -> Topology {
    let mut positions = sheet().rest_positions().to_vec();
    for p in &mut positions {
        p.x += 0.4 * p.z.max(0.0);
    }
    let triangles: Vec<_> = (0..18 * 35)
        .filter(|at| at % 35 != 34)
        .flat_map(|at| [[at, at + 35, at + 36], [at, at + 36, at + 1]])
        .collect();
    Arc::new(Graph::new(&positions, &triangles, MassLumping::Lumped).unwrap()).into()
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| Vec::<u8>::with_capacity(10)), 1);
    assert_eq!(allocations(|| 1 + 1), 0);
}

#[test]
fn bodies_take_room_once() {
    let ball = Sphere::new(0.3);
    let (from, to) =
        (Pose::from_translation(Vec3::Y * -0.301), Pose::from_translation(Vec3::Y * -0.3));
    let mobility = Mobility { inverse_mass: 2.0, inverse_inertia: Mat3::IDENTITY, informed: true };
    let body = Collider::new(&ball, from).moving_to(to).moved_by(mobility, Vec3::ZERO);
    // Two of one body, and one that pins pull at.
    let with = |key, body_key| Collider { key, body: body_key, ..body };
    let colliders = [with(1, 5), with(2, 5), with(3, 6).in_layers(0)];
    let pulls = [PinPull { pin: 0, body: 6 }, PinPull { pin: 1, body: 6 }];
    for topology in [sheet(), mesh()] {
        let threads = StretchMethod::ImplicitThreads;
        let (mut solver, pins) = busy(topology, threads, Bending::SecondDifference);
        let gravity = Vec3::NEG_Y * 9.81;
        let input = StepInput {
            dt: 1.0 / 64.0,
            gravity,
            pins: &pins,
            pulls: &pulls,
            colliders: &colliders,
            ..StepInput::default()
        };
        solver.tick(&input).unwrap();
        for tick in 0..20 {
            assert_eq!(allocations(|| solver.tick(&input).unwrap()), 0, "tick {tick}");
        }
        assert!(solver.impulse(0).linear.length() > 0.0 && solver.impulse(2).linear.length() > 0.0);
    }
}

#[test]
fn a_tick_and_its_stages_do_not_allocate() {
    let ball = Sphere::new(0.3);
    let (from, to) =
        (Pose::from_translation(Vec3::Y * -0.301), Pose::from_translation(Vec3::Y * -0.3));
    let colliders = [Collider::new(&ball, from).moving_to(to); 2];
    let zones = [Zone {
        shape: WindShape::from(ball),
        flow: WindFlow::Radial(3.0),
        falloff: 0.1,
        pose: from,
    }];
    let gusts = Gusts { strength: 2.0, ..Gusts::default() };
    let wind = Wind { velocity: Vec3::X, gusts, time: 0.3, zones: &zones };
    let forms = [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads];
    for (topology, form) in [sheet(), mesh()].iter().flat_map(|t| forms.map(|form| (t, form))) {
        for bending in [Bending::SecondDifference, Bending::Flexion] {
            let (mut solver, pins) = busy(topology.clone(), form, bending);
            let gravity = Vec3::NEG_Y * 9.81;
            let input = StepInput {
                dt: 1.0 / 64.0,
                gravity,
                pins: &pins,
                colliders: &colliders,
                wind,
                ..StepInput::default()
            };
            // The first tick too, another length of tick, another gravity and wind.
            assert_eq!(allocations(|| solver.tick(&input)), 0, "{form:?} {bending:?}, first tick");
            for _ in 0..20 {
                assert_eq!(allocations(|| solver.tick(&input)), 0, "{form:?} {bending:?}");
            }
            let other =
                StepInput { dt: 1.0 / 50.0, gravity: Vec3::X, wind: Wind::default(), ..input };
            assert_eq!(allocations(|| solver.tick(&other)), 0, "{form:?} {bending:?}, other tick");
            let force = PushWith::Force(Vec3::X);
            solver.push(PushOn::All, force).unwrap();
            assert_eq!(allocations(|| solver.tick(&input)), 0, "{form:?} {bending:?}, pushed");
            // Once there is room.
            assert_eq!(allocations(|| solver.push(PushOn::Particle(7), force)), 0);
            assert_eq!(allocations(|| solver.tick(&input)), 0, "{form:?} {bending:?}, pushed");
            let ride = RigidMotion { pivot: Vec3::X, rotation: Quat::IDENTITY, shift: Vec3::Y };
            assert_eq!(allocations(|| solver.ride(&ride)), 0);
            assert_eq!(allocations(|| solver.carry(&Pose::IDENTITY, &from)), 0);
            assert_eq!(allocations(|| (solver.mark(), solver.distance_from_mark())), 0);
            assert_eq!(allocations(|| solver.reset(&from)), 0);
            assert_eq!(allocations(|| solver.begin_tick(&input)), 0);
            for _ in 0..5 {
                assert_eq!(allocations(|| solver.accumulate_forces(&input)), 0);
                assert_eq!(allocations(|| solver.integrate(&input)), 0);
                assert_eq!(allocations(|| solver.correct()), 0);
                assert_eq!(allocations(|| solver.collide(&input)), 0);
            }
            assert_eq!(allocations(|| solver.end_tick()), 0);
        }
    }
}

#[test]
fn sharing_a_large_sheet_does_not_allocate() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let counts = || pool.broadcast(|_| COUNT.with(Cell::get));
    let floor = InfinitePlane3d::new(Vec3::Y);
    let colliders = [Collider::new(&floor, Pose::from_translation(Vec3::Y * -0.03))];
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        let sheet = Lattice::sheet(Vec2::ONE, 210, 210, MassLumping::Lumped).unwrap();
        let sheet = Topology::from(Arc::new(sheet));
        let (mut first, _) = busy(sheet.clone(), form, Bending::default());
        let (mut solver, pins) = busy(sheet, form, Bending::default());
        // All bands fall onto the floor, and are pressed onto it.
        (0..210 * 210)
            .for_each(|particle| solver.set_velocity(particle, Vec3::NEG_Y * 5.0).unwrap());
        let gravity = Vec3::NEG_Y * 9.81;
        let (dt, pins, colliders) = (1.0 / 64.0, &pins[..], &colliders[..]);
        let input = StepInput { dt, gravity, pins, colliders, ..StepInput::default() };
        // Of its own queues the pool makes more where it has to.
        pool.install(|| first.tick(&input)).unwrap();
        let before = counts();
        pool.install(|| (0..8).for_each(|_| assert!(solver.tick(&input).is_ok())));
        assert_eq!(counts(), before, "{form:?}");
    }
}
