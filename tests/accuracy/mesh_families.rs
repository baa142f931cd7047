//! The families of `accuracy` on an irregular mesh beside a sheet: vertices off their places by up to 0.3 cells, diagonals at
//! random. Held to closed forms.
//!
//! What differs on an irregular mesh. Its moduli are other ones than a weave's, and its vertices go where forces balance: it is 2
//! to 4 % softer than asked along its rows, and a third softer on the bias. Tables of discrete chains have no irregular counterpart:
//! catenary, strip and axial mode are held to the continuum. Its cantilever (`cantilever`) has no order of its own, and its
//! chains turn it by 2e-4 of a spin in a second. Grid meshes are in the tables' own tests; the swing is in `mesh_swing`, Provot's
//! limit in `solver/graph` and `stability`. Distance fields and a single oscillator know no mesh.

use bevy::math::primitives::InfinitePlane3d;
use bevy::math::{DVec2, DVec3, Quat, Vec3};
use bevy_drape::solver::{
    ClothSolver, Collider, MassLumping, Material, Pose, StepInput, StretchMethod, Topology,
};

use super::moduli;
use super::reference::{Fabric, Method};
use super::scenes::*;
use crate::support::solver::*;

const FORMS: [StretchMethod; 2] = [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads];

fn kinds(sheet: &Sheet) -> [(&'static str, Topology); 2] {
    [
        ("sheet", sheet.lattice(MassLumping::Lumped).into()),
        ("mesh", sheet.irregular(MassLumping::Lumped).into()),
    ]
}

fn solver(topology: &Topology, fabric: &Fabric, form: StretchMethod, substeps: u32) -> ClothSolver {
    let settings = settings_for(fabric, Method::Verlet, settings(form, substeps));
    at_rest(topology, Vec3::ZERO, material(fabric), settings)
}

#[test]
fn free_fall_is_a_parabola_and_strains_nothing() {
    let sheet = Sheet::square(8, 1.0);
    let fabric = Fabric { thread: 500.0, shear: 100.0, damping: 1e-3, ..Fabric::default() };
    for (kind, topology) in kinds(&sheet) {
        for form in FORMS {
            let mut falling = solver(&topology, &fabric, form, 16);
            let thrown = Vec3::new(1.0, 2.0, -0.5);
            (0..sheet.count()).for_each(|i| falling.set_velocity(i, thrown).unwrap());
            run(&mut falling, 64, GRAVITY, &[]);
            let way = (thrown + 0.5 * GRAVITY).as_dvec3();
            let exact: Vec<_> =
                topology.rest_positions().iter().map(|p| p.as_dvec3() + way).collect();
            let what = format!("{kind}, {form:?}");
            check_at_most(
                &format!("{what}: off the parabola [m]"),
                apart(&places(&falling), &exact),
                2e-5,
            );
            let strain = thread_strains(&falling).iter().fold(0.0_f64, |most, s| most.max(s.abs()));
            // Places are rounded to 2e-7 m here, and edges are 5 cm or longer.
            check_at_most(&format!("{what}: strain"), strain, 4e-5);
        }
    }
}

#[test]
fn a_free_cloth_keeps_both_momenta() {
    let sheet = Sheet::square(8, 1.0);
    let fabric =
        Fabric { thread: 500.0, shear: 100.0, rigidity: 1e-4, damping: 1e-3, ..Fabric::default() };
    for (kind, topology) in kinds(&sheet) {
        for form in FORMS {
            let mut flying = solver(&topology, &fabric, form, 32);
            let mut dice = Dice(7);
            for i in 0..sheet.count() {
                flying.set_velocity(i, dice.vector() + Vec3::new(0.5, 0.0, 1.0)).unwrap();
            }
            let before = momenta(&flying);
            run(&mut flying, 64, Vec3::ZERO, &[]);
            let after = momenta(&flying);
            let what = format!("{kind}, {form:?}: drift of");
            let linear = (after.0 - before.0).length() / before.0.length();
            check_at_most(&format!("{what} momentum, relative"), linear, 3e-6);
            let angular = (after.1 - before.1).length() / before.1.length();
            check_at_most(&format!("{what} angular momentum, relative"), angular, 5e-4);
        }
    }
}

#[test]
fn springs_move_at_second_order() {
    // Held at its corners it falls and bounces, without damping.
    let sheet = Sheet::square(10, 1.0);
    let fabric = Fabric { thread: 200.0, shear: 100.0, ..Fabric::default() };
    for (kind, topology) in kinds(&sheet) {
        let [coarse, middle, fine] = [16, 32, 64].map(|substeps| {
            let mut falling = solver(&topology, &fabric, StretchMethod::ExplicitSprings, substeps);
            falling.set_pins(&[0, 10, 110, 120]).unwrap();
            run(&mut falling, 20, GRAVITY, &[]);
            places(&falling)
        });
        let rms = |a: &[DVec3], b: &[DVec3]| {
            (a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)).sum::<f64>() / a.len() as f64)
                .sqrt()
        };
        let order = (rms(&coarse, &middle) / rms(&middle, &fine)).log2();
        check(&format!("{kind}: order of the motion"), order, 2.0, 0.15);
    }
}

/// Stress over Young's modulus of a sheet whose border has a small uniform strain `e`, at rest: its parts along x, along z, and
/// shear, from the forces on all particles (the virial). Strained both ways, so that what is of second order cancels.
fn stress(sheet: &Sheet, thread: f64, e: [f64; 3]) -> [f64; 3] {
    let topology = Topology::from(sheet.irregular(MassLumping::Lumped));
    let fabric = Fabric { thread, shear: thread, ..Fabric::default() };
    let [columns, rows] = sheet.cells;
    let is_border = |&i: &u32| {
        let (row, column) = (i as usize / (columns + 1), i as usize % (columns + 1));
        row % rows == 0 || column % columns == 0
    };
    let border: Vec<_> = (0..sheet.count() as u32).filter(is_border).collect();
    let size = DVec2::new(sheet.cells[0] as f64, sheet.cells[1] as f64) * sheet.cell;
    let mut sum = [0.0; 3];
    for small in [1e-3, -1e-3] {
        let moved = |p: &Vec3| {
            let p = p.as_dvec3() - DVec3::new(size.x, 0.0, size.y) * 0.5;
            p + DVec3::new(e[0] * p.x + e[2] * p.z, 0.0, e[2] * p.x + e[1] * p.z) * small
        };
        let strained: Vec<_> = topology.rest_positions().iter().map(moved).collect();
        // What is within goes where forces balance.
        let settings =
            settings_for(&fabric, Method::Verlet, settings(StretchMethod::ExplicitSprings, 8));
        let start: Vec<_> = strained.iter().map(|p| p.as_vec3()).collect();
        let slowed = Fabric { drag: 1.5, ..fabric };
        let mut inner =
            ClothSolver::new(topology.clone(), &start, material(&slowed), settings).unwrap();
        inner.set_pins(&border).unwrap();
        settle(&mut inner, Vec3::ZERO, 1e-7, 640);
        let strained = places(&inner);
        let forces = moduli::solved(topology.clone(), &fabric, &strained);
        let scale = -1.0 / (2.0 * small * size.x * size.y * thread);
        for (f, p) in forces.iter().zip(&strained) {
            sum[0] += f.x * p.x * scale;
            sum[1] += f.z * p.z * scale;
            sum[2] += 0.5 * (f.x * p.z + f.z * p.x) * scale;
        }
    }
    sum
}

#[test]
fn a_mesh_is_as_stiff_as_asked_along_its_rows() {
    let sheet = Sheet::square(24, 1.0);
    let [along, across, sheared] =
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.5]].map(|e| stress(&sheet, 0.1, e));
    println!("{along:.4?} {across:.4?} {sheared:.4?}");
    // Betti: the work of each state's forces on the other's strain is the same.
    check("C12 less C21", along[1] - across[0], 0.0, 2e-3);
    let poisson = along[1] / across[1];
    check("Young's modulus along x", along[0] - along[1] * poisson, 1.0, 0.05);
    check("Young's modulus along z", across[1] - across[0] * along[1] / along[0], 1.0, 0.05);
    // Cauchy's relation of central forces. An isotropic sheet's C66 is 0.375: as vertices go where forces balance, this mesh is
    // softer in shear, and on the bias, than along its rows.
    check("C66 less C12", sheared[2] - along[1], 0.0, 0.05);
    check("C66", sheared[2], 0.225, 0.02);
}

#[test]
fn a_strip_between_two_ends_hangs_as_the_catenary() {
    // Without stretch, ends 0.8 lengths apart: 2 c sinh(D / 2c) = L, sag c (cosh(D / 2c) - 1).
    const SAG: f64 = 0.265_437_5;
    for cells in [16_usize, 32] {
        let sheet = Sheet { cells: [4, cells], cell: DVec2::splat(1.0 / cells as f64) };
        for (kind, topology) in kinds(&sheet) {
            let fabric = Fabric { thread: 2e4, drag: 8.0, ..Fabric::default() };
            // Two straight halves of the strip's length.
            let fold = |p: &Vec3| {
                let drop = 0.3 * 2.0 * f32::min(p.z, 1.0 - p.z);
                Vec3::new(p.x, -drop, 0.8 * p.z)
            };
            let start: Vec<_> = topology.rest_positions().iter().map(fold).collect();
            let settings =
                settings_for(&fabric, Method::Verlet, settings(StretchMethod::ImplicitThreads, 32));
            let mut strip =
                ClothSolver::new(topology, &start, material(&fabric), settings).unwrap();
            let last = 5 * cells as u32;
            strip.set_pins(&(0..5).chain(last..last + 5).collect::<Vec<_>>()).unwrap();
            settle(&mut strip, GRAVITY, 1e-6, 384);
            let middle = 5 * cells / 2;
            let sag =
                -(middle..middle + 5).map(|i| strip.position(i).as_dvec3().y).sum::<f64>() / 5.0;
            // A chain of N links hangs lower by 0.535 / N^2.
            let bound = 2.0 * 0.535 * SAG / (cells * cells) as f64 + 1e-3;
            check(&format!("{kind}, {cells} cells: sag / L"), sag, SAG, bound);
        }
    }
}

/// A strip of 1 m in its plane, held by its first row.
fn plumb() -> Sheet {
    Sheet { cells: [8, 40], cell: DVec2::splat(0.025) }
}

/// The mean of the last row's places along the strip.
fn end(strip: &ClothSolver) -> f64 {
    let sheet = plumb();
    let row = sheet.at(sheet.cells[1], 0)..sheet.count();
    row.map(|i| f64::from(strip.position(i).z)).sum::<f64>() / sheet.columns() as f64
}

/// Young's modulus over the threads' constant, with shear springs of 0.4 of it: a weave's along its threads, `C11 - C12^2 / C11`.
/// The vertices of an irregular mesh go where forces balance, which makes it softer than its formula: by 3 to 4 % in such a strip. Its held row
/// cannot get narrower, which makes a sheet stiffer by 1 %.
fn young(kind: &str) -> (f64, f64) {
    if kind == "sheet" { (1.4 - 0.4 * 0.4 / 1.4, 0.015) } else { (1.0, 0.05) }
}

const THREAD: f64 = 50.0;

#[test]
fn a_strip_is_stretched_by_its_own_weight() {
    // rho g L^2 / 2 E.
    let fabric = Fabric { thread: THREAD, shear: 0.4 * THREAD, drag: 14.0, ..Fabric::default() };
    for (kind, topology) in kinds(&plumb()) {
        for form in FORMS {
            let mut strip = solver(&topology, &fabric, form, 32);
            strip.set_pins(&(0..9).collect::<Vec<_>>()).unwrap();
            settle(&mut strip, Vec3::Z * 10.0, 1e-6, 384);
            let (modulus, tolerance) = young(kind);
            let exact = 0.2 * 10.0 / (2.0 * THREAD * modulus);
            let measured = end(&strip) - 1.0;
            check(&format!("{kind}, {form:?}: elongation / L"), measured, exact, tolerance * exact);
        }
    }
}

#[test]
fn a_strip_swings_along_itself_as_a_bar_and_loses_nothing() {
    // sqrt(E / rho) pi / 2 L.
    let fabric = Fabric { thread: THREAD, shear: 0.4 * THREAD, ..Fabric::default() };
    for (kind, topology) in kinds(&plumb()) {
        let mut strip = solver(&topology, &fabric, StretchMethod::ExplicitSprings, 32);
        strip.set_pins(&(0..9).collect::<Vec<_>>()).unwrap();
        for i in 9..plumb().count() {
            let along = strip.position(i).z * std::f32::consts::FRAC_PI_2;
            strip.set_velocity(i, Vec3::Z * 0.02 * along.sin()).unwrap();
        }
        let off: Vec<_> = (0..320)
            .map(|_| {
                run(&mut strip, 1, Vec3::ZERO, &[]);
                end(&strip) - 1.0
            })
            .collect();
        let passages: Vec<_> = off
            .windows(2)
            .enumerate()
            .filter(|(_, pair)| pair[0] < 0.0 && pair[1] >= 0.0)
            .map(|(tick, pair)| tick as f64 - pair[0] / (pair[1] - pair[0]))
            .collect();
        let [first, .., last] = passages[..] else { panic!("{kind}: it does not swing") };
        let period = (last - first) / (passages.len() - 1) as f64 * f64::from(TICK);
        let omega = std::f64::consts::TAU / period;
        let (modulus, tolerance) = young(kind);
        let exact = (THREAD * modulus / 0.2).sqrt() * std::f64::consts::FRAC_PI_2;
        check(&format!("{kind}: frequency [1/s]"), omega, exact, 0.5 * tolerance * exact);
        let largest = |part: &[f64]| part.iter().fold(0.0_f64, |most, it| most.max(it.abs()));
        let left = largest(&off[256..]) / largest(&off[..64]);
        check(&format!("{kind}: amplitude left after 4 s"), left, 1.0, 0.03);
    }
}

#[test]
fn rest_does_not_depend_on_the_step() {
    let sheet = Sheet::square(10, 1.0);
    let fabric = Fabric { thread: 200.0, shear: 100.0, drag: 6.0, ..Fabric::default() };
    for (kind, topology) in kinds(&sheet) {
        let [coarse, fine] = [12, 24].map(|substeps| {
            let mut hung = solver(&topology, &fabric, StretchMethod::ExplicitSprings, substeps);
            let border = |i: &u32| {
                let (row, column) = (*i as usize / 11, *i as usize % 11);
                row % 10 == 0 || column % 10 == 0
            };
            hung.set_pins(&(0..121).filter(border).collect::<Vec<_>>()).unwrap();
            settle(&mut hung, GRAVITY, 1e-6, 640);
            places(&hung)
        });
        assert!(coarse[60].y < -0.05, "{kind}: it hangs {} m", coarse[60].y);
        check_at_most(&format!("{kind}: x12 from x24 [m]"), apart(&coarse, &fine), 5e-6);
    }
}

#[test]
fn a_patch_slides_down_a_slope_as_coulomb_has_it() {
    let mu = 0.5_f32;
    let sheet = Sheet::square(6, 0.2);
    for (kind, topology) in kinds(&sheet) {
        for (factor, ticks) in [(0.95, 320), (1.05, 64), (1.5, 64)] {
            let angle = (factor * mu).atan();
            let turn = Quat::from_rotation_z(-angle);
            let material = Material { friction: mu, ..plain() };
            let place = |p: &Vec3| turn * (*p + Vec3::Y * material.thickness);
            let start: Vec<_> = topology.rest_positions().iter().map(place).collect();
            let settings = settings(StretchMethod::ImplicitThreads, 16);
            let mut patch = ClothSolver::new(topology.clone(), &start, material, settings).unwrap();
            let pose = Pose { translation: Vec3::ZERO, rotation: turn, scale: 1.0 };
            let floor = InfinitePlane3d::new(Vec3::Y);
            run(&mut patch, ticks, GRAVITY, &[Collider::new(&floor, pose).with_friction(mu)]);
            let down = (turn * Vec3::X).as_dvec3();
            let gone = (patch.position(24) - start[24]).as_dvec3().dot(down);
            let what = format!("{kind}, {factor} of the slope");
            if factor < 1.0 {
                check_at_most(&format!("{what}: creep in 5 s [m]"), gone.abs(), 1e-5);
            } else {
                let exact = 9.81 * f64::from(angle.sin() - mu * angle.cos());
                check(&format!("{what}: acceleration [m/s2]"), 2.0 * gone, exact, 0.01 * exact);
            }
        }
    }
}

#[test]
fn what_is_plane_stays_plane_to_the_bit() {
    let sheet = Sheet::square(10, 1.0);
    let fabric = Fabric { thread: 200.0, shear: 100.0, rigidity: 1e-4, ..Fabric::default() };
    for (kind, topology) in kinds(&sheet) {
        for form in FORMS {
            let mut falling = solver(&topology, &fabric, form, 32);
            falling.set_pins(&[0, 10]).unwrap();
            let pins = still(&falling);
            let input = StepInput {
                dt: TICK,
                gravity: Vec3::new(3.0, 0.0, 9.0),
                pins: &pins,
                ..StepInput::default()
            };
            for _ in 0..64 {
                falling.tick(&input).unwrap();
            }
            assert!(positions(&falling).iter().all(|p| p.y == 0.0), "{kind}, {form:?}");
        }
    }
}
