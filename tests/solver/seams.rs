//! Features together, on a lattice and on a mesh that is no grid. Truths: bit equality (stages, instruction
//! sets), closed forms (terminal speed, weight over stiffness), kept momentum, and that no particle goes
//! through.

use bevy::math::{DVec3, Quat, Vec3, primitives::Sphere};
use bevy_drape::solver::{
    Air, Bending, ClothSolver, Collider, Gusts, Isa, Material, PinMotion, Pose, Settings, SoftPin,
    StepInput, StretchMethod, Topology, Wind, WindFlow, WindShape, Zone,
};

use super::fast::deepest_way;
use crate::support::solver::*;

/// Both kinds of a sheet of 33 x 33 particles and a metre, the mesh irregular.
fn both() -> [Topology; 2] {
    lattice_and_mesh(1.0, 33).map(|(_, topology)| topology)
}

/// In its rest shape, its middle at a place.
fn laid(topology: &Topology, at: Vec3, material: Material, settings: Settings) -> ClothSolver {
    at_rest(topology, at - middle(topology), material, settings)
}

/// The four corners on springs.
fn soft_corners() -> [SoftPin; 4] {
    [0, 32, 32 * 33, 33 * 33 - 1].map(|particle| SoftPin {
        particle,
        stiffness: 200.0,
        damping: 1.0,
    })
}

fn momentum(solver: &ClothSolver) -> DVec3 {
    momenta(solver).0
}

#[test]
fn a_level_mesh_falls_by_the_law_of_drag_as_a_sheet_does() {
    for topology in both() {
        for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
            let mut solver = laid(&topology, Vec3::ZERO, plain(), settings(form, 8));
            let air = Air { lift: 0.0, ..Air::default() };
            solver.set_air(Some(air)).unwrap();
            // Not for longer: a limp sheet that falls face down crumples, soonest an irregular one.
            let ticks = 30;
            run(&mut solver, ticks, GRAVITY, &[]);
            let terminal = (2.0 * 0.2 * 9.81 / (1.225 * 1.2_f64)).sqrt();
            let exact = terminal * (9.81 * ticks as f64 * f64::from(TICK) / terminal).tanh();
            let speed = -(0..33 * 33).map(|i| f64::from(solver.velocity(i).y)).sum::<f64>();
            let what = format!("{form:?}, graph {}: speed", topology.as_graph().is_some());
            check(&what, speed / f64::from(33 * 33), exact, 0.01 * exact);
        }
    }
}

#[test]
fn a_mesh_goes_with_the_wind_of_its_zone_and_no_faster() {
    for topology in both() {
        for (inside, flow) in [
            (true, WindFlow::Directional(Vec3::Y * 3.0)),
            (false, WindFlow::Directional(Vec3::Y * 3.0)),
        ] {
            let film = Material { area_density: 1e-3, ..plain() };
            let mut solver = laid(&topology, Vec3::ZERO, film, Settings::default());
            solver.set_air(Some(Air::default())).unwrap();
            let place = if inside { Vec3::Y } else { Vec3::Y * 9.0 };
            let zones = [Zone {
                shape: WindShape::Sphere(Sphere::new(4.0)),
                flow,
                falloff: 0.2,
                pose: Pose::from_translation(place),
            }];
            let wind = Wind { zones: &zones, ..Wind::default() };
            let input = StepInput { dt: TICK, wind, ..StepInput::default() };
            for _ in 0..20 {
                solver.tick(&input).unwrap();
            }
            let speed = velocities(&solver).iter().map(|v| f64::from(v.y)).sum::<f64>() / 1089.0;
            let expected = if inside { 3.0 } else { 0.0 };
            check(&format!("inside {inside}: speed [m/s]"), speed, expected, 0.1);
        }
    }
}

/// Everything on, and changed on the way: what is left of it.
fn busy(topology: &Topology, form: StretchMethod, isa: Isa, staged: bool) -> Vec<[u32; 6]> {
    let material = Material {
        shear_stiffness: 30.0,
        flexural_rigidity: 1e-5,
        damping: 0.001,
        max_strain: 0.05,
        friction: 0.4,
        ..plain()
    };
    let own = settings(form, 7);
    let mut solver = laid(topology, Vec3::new(3.3, 0.4, -8.1), material, own);
    solver.set_isa(isa);
    solver.set_air(Some(Air::default())).unwrap();
    solver.set_pins(&[5, 700]).unwrap();
    solver.set_soft_pins(&soft_corners()).unwrap();
    let start = still(&solver);
    let ball = Sphere::new(0.2);
    for tick in 0..40 {
        match tick {
            8 => solver.set_material(Material { area_density: 0.1, ..material }).unwrap(),
            12 => solver.set_soft_pins(&soft_corners()[..2]).unwrap(),
            16 => solver.set_settings(Settings { bending: Bending::Flexion, ..own }).unwrap(),
            20 => solver.set_pins(&[5]).unwrap(),
            24 => solver.set_air(Some(Air { lift: 0.1, ..Air::default() })).unwrap(),
            28 => {
                let turned = Pose { rotation: Quat::from_rotation_x(0.7), ..Pose::IDENTITY };
                solver.carry(&Pose::IDENTITY, &turned).unwrap();
            }
            32 => solver.set_pins(&[5, 900]).unwrap(),
            _ => {}
        }
        let held = solver.pins().len() + solver.soft_pins().len();
        let shift = Vec3::new(0.004, -0.002, 0.003) * tick as f32;
        let pins: Vec<_> = start
            .iter()
            .cycle()
            .take(held)
            .map(|p| PinMotion { start: p.start + shift, end: p.end + shift * 1.1 })
            .collect();
        let at = |tick: f32| Pose {
            translation: Vec3::new(3.3, 1.4 - 0.9 * (tick % 4.0), -8.1),
            rotation: Quat::from_rotation_z(0.3 * tick),
            scale: 1.0,
        };
        let from = (tick % 4) as f32;
        let collider = Collider::new(&ball, at(from)).moving_to(at(from + 1.0)).measured();
        let colliders = [collider];
        let zones = [Zone {
            shape: WindShape::Sphere(Sphere::new(0.8)),
            flow: WindFlow::Radial(5.0),
            falloff: 0.1,
            pose: Pose::from_translation(Vec3::new(3.0, 0.2, -8.0)),
        }];
        let wind = Wind {
            velocity: Vec3::new(1.0, 0.3, -2.0),
            gusts: Gusts { strength: 2.0, scale: 0.3, seed: 3, ..Gusts::default() },
            time: f64::from(tick) / 64.0,
            zones: &zones,
        };
        let input = StepInput {
            dt: TICK,
            gravity: GRAVITY,
            pins: &pins,
            colliders: &colliders,
            wind,
            ..StepInput::default()
        };
        if staged {
            for _ in 0..solver.begin_tick(&input).unwrap() {
                solver.accumulate_forces(&input);
                solver.integrate(&input);
                solver.correct();
                solver.collide(&input);
            }
            solver.end_tick().unwrap();
        } else {
            solver.tick(&input).unwrap();
        }
    }
    let mut bits = bits(&solver);
    let given = solver.impulse(0).linear.to_array().map(f32::to_bits);
    bits.push([given[0], given[1], given[2], 0, 0, 0]);
    bits
}

#[test]
fn all_features_at_once_give_the_same_bits_on_every_instruction_set() {
    for topology in both() {
        for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
            let reference = busy(&topology, form, Isa::Baseline, false);
            assert!(reference.iter().flatten().all(|bits| f32::from_bits(*bits).is_finite()));
            for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
                for staged in [false, true] {
                    let what = format!("{form:?} {isa:?}, staged {staged}");
                    assert!(reference == busy(&topology, form, isa, staged), "{what}");
                }
            }
        }
    }
}

#[test]
fn a_fast_sphere_goes_through_no_particle_of_a_mesh_however_it_is_held() {
    let ball = Sphere::new(0.2);
    let [_, topology] = both();
    for speed in [50.0_f32, 250.0] {
        for hold in ["free", "pins", "soft pins", "air"] {
            let material =
                Material { shear_stiffness: 100.0, max_strain: 0.1, friction: 0.5, ..plain() };
            let mut solver = laid(&topology, Vec3::ZERO, material, Settings::default());
            match hold {
                "pins" => solver.set_pins(&soft_corners().map(|pin| pin.particle)).unwrap(),
                "soft pins" => solver.set_soft_pins(&soft_corners()).unwrap(),
                "air" => solver.set_air(Some(Air::default())).unwrap(),
                _ => {}
            }
            let path = |t: f32| Pose::from_translation(Vec3::Y * (1.0 - speed * t));
            let ticks = (4.0 / (speed * TICK)).ceil() as usize;
            let deepest = deepest_way(&mut solver, &ball, &path, ticks);
            let substeps = solver.plan().substeps as f32;
            // A straight way along the sphere is a chord, s^2 / 8 r deep.
            let chord = (speed * TICK / substeps).powi(2) / (8.0 * 0.2);
            check_at_most(
                &format!("{speed} m/s, {hold}: deepest way [m]"),
                deepest.into(),
                f64::from(chord) + 1e-3,
            );
            assert!(solver.strain().max.is_finite());
        }
    }
}

#[test]
fn what_a_mesh_loses_the_collider_is_given() {
    let ball = Sphere::new(0.3);
    let [_, topology] = both();
    for speed in [2.0, 40.0] {
        let material =
            Material { shear_stiffness: 100.0, max_strain: 0.1, friction: 0.5, ..plain() };
        let mut solver = laid(&topology, Vec3::ZERO, material, Settings::default());
        for i in 0..33 * 33 {
            solver.set_velocity(i, Vec3::new(0.3, -1.0, 0.1) * speed).unwrap();
        }
        let before = momentum(&solver);
        let pose = Pose::from_translation(Vec3::new(0.05, -0.35, 0.02));
        let colliders = [Collider::new(&ball, pose).measured()];
        let mut given = Vec3::ZERO;
        for _ in 0..32 {
            run(&mut solver, 1, Vec3::ZERO, &colliders);
            given += solver.impulse(0).linear;
        }
        let lost = before - momentum(&solver);
        assert!(lost.length() > 0.1 * before.length(), "hardly touched: {lost}");
        check_at_most(
            &format!("{speed} m/s: momentum lost less impulse, relative"),
            lost.distance(given.as_dvec3()) / before.length(),
            1e-4,
        );
    }
}

#[test]
fn a_mesh_on_soft_pins_hangs_by_its_weight_over_their_stiffness() {
    for topology in both() {
        for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
            let material = Material { drag: 4.0, max_strain: 0.1, ..plain() };
            let mut solver = laid(&topology, Vec3::ZERO, material, settings(form, 16));
            let pins: Vec<_> = (0..33)
                .map(|particle| SoftPin { particle, stiffness: 2.0, damping: 0.6 })
                .collect();
            solver.set_soft_pins(&pins).unwrap();
            let targets = still(&solver);
            // Downhill, away from the row that is held.
            let gravity = Vec3::Z * 9.81;
            let input = StepInput { dt: TICK, gravity, pins: &targets, ..StepInput::default() };
            for _ in 0..500 {
                solver.tick(&input).unwrap();
            }
            let weight = 9.81 * (0..33 * 33).map(|i| f64::from(solver.mass(i))).sum::<f64>();
            let given = (0..33).map(|i| f64::from(solver.position(i).z - targets[i].end.z));
            let what = format!("{form:?}, graph {}: given [m]", topology.as_graph().is_some());
            check(&what, given.sum::<f64>() / 33.0, weight / 66.0, 0.01 * weight / 66.0);
        }
    }
}
