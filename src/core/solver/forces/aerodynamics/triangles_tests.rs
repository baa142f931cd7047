//! On the triangles of a sheet, held to the sheet's own cells where both must agree, and to sums over
//! single triangles.

use bevy_math::{Vec2, Vec3};

use crate::solver::forces::aerodynamics::cells::{Cells, PushCells};
use crate::solver::forces::aerodynamics::law::Law;
use crate::solver::forces::aerodynamics::triangles::*;
use crate::solver::forces::aerodynamics::{FaceWind, Flow};
use crate::solver::settings::MassLumping;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::soa::Soa;
use crate::solver::topology::lattice::Lattice;

const ROWS: usize = 7;
const COLUMNS: usize = 21;
const COUNT: usize = ROWS * COLUMNS;
const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);
const LAW: Law = Law { drag: 0.7, lift: 0.5, kick: 0.01 };

fn lattice() -> Lattice {
    Lattice::sheet(Vec2::new(2.0, 0.9), ROWS, COLUMNS, MassLumping::Lumped).unwrap()
}

fn triangles() -> Vec<[u32; 3]> {
    let columns = COLUMNS as u32;
    (0..ROWS as u32 - 1)
        .flat_map(|r| (0..columns - 1).map(move |c| r * columns + c))
        .flat_map(|a| [[a, a + columns, a + 1], [a + 1, a + columns, a + columns + 1]])
        .collect()
}

/// A value of each particle, in a lattice's slots.
fn spread(lattice: &Lattice, of: impl Fn(Vec3) -> Vec3) -> Soa {
    let mut out = Soa::zeros(lattice.layout.len());
    for (slot, &p) in lattice.layout.slots().zip(&lattice.rest_positions) {
        out.set(slot, of(p));
    }
    out
}

/// Accelerations by air, by cells or by triangles.
fn push(isa: Isa, by_cells: bool, wave: f32, velocity: impl Fn(Vec3) -> Vec3) -> Vec<Vec3> {
    let lattice = lattice();
    let x = spread(&lattice, |p| p + Vec3::Y * (wave * p.x * (p.z + p.x)));
    let d = spread(&lattice, velocity);
    let mut a = spread(&lattice, |_| GRAVITY);
    let mut inverse_mass = vec![0.0; lattice.layout.len()];
    for slot in lattice.layout.slots() {
        inverse_mass[slot] = 1.0 / (0.2 * lattice.area[slot]);
    }
    let (mut cells, of_cells) = Cells::new(&lattice);
    let (mut triangles, of_triangles) =
        Triangles::new(lattice.layout, &triangles(), &lattice.rest_positions, &lattice.area);
    let flow = Flow {
        law: LAW,
        wind: FaceWind::Uniform(Vec3::new(2.0, 3.0, -1.0)),
        inverse_unit: 1.0,
        inverse_density: 1.0 / 0.2,
        inverse_area: if by_cells { &of_cells } else { &of_triangles },
    };
    let (inverse_mass, x, d) = (&inverse_mass[..], &x, &d);
    if by_cells {
        isa.run(PushCells { cells: &mut cells, flow, inverse_mass, x, d, a: &mut a });
    } else {
        let triangles = &mut triangles;
        isa.run(PushTriangles { triangles, flow, inverse_mass, x, d, a: &mut a });
    }
    lattice.layout.slots().map(|slot| a.get(slot) - GRAVITY).collect()
}

fn masses() -> Vec<f32> {
    let lattice = lattice();
    lattice.layout.slots().map(|slot| 0.2 * lattice.area[slot]).collect()
}

fn total(accelerations: &[Vec3]) -> Vec3 {
    accelerations.iter().zip(masses()).map(|(&a, m)| a * m).sum()
}

#[test]
fn a_flat_sheet_feels_the_same_by_triangles_as_by_cells() {
    let velocity = |_| Vec3::new(0.3, 0.1, 0.2);
    let (cells, triangles) =
        (push(Isa::detect(), true, 0.0, velocity), push(Isa::detect(), false, 0.0, velocity));
    assert!(total(&cells).length() > 1.0);
    // Six triangles around a particle inside, a third each of half a cell.
    for r in 1..ROWS - 1 {
        for c in 1..COLUMNS - 1 {
            let (a, b) = (cells[r * COLUMNS + c], triangles[r * COLUMNS + c]);
            // What takes a triangle's force is lighter next to corners.
            let near = if r % (ROWS - 3) == 1 { 0.1 } else { 1e-4 };
            assert!(a.distance(b) <= near * a.length(), "{r} {c}: {a} and {b}");
        }
    }
    let apart = total(&cells).distance(total(&triangles));
    assert!(apart < 0.02 * total(&cells).length(), "{apart}");
}

#[test]
fn a_wave_feels_what_its_triangles_feel() {
    let velocity = |p: Vec3| Vec3::new(p.z, p.x * p.x, 1.0 - p.x);
    let lattice = lattice();
    let place = |p: Vec3| p + Vec3::Y * (0.8 * p.x * (p.z + p.x));
    let rest = &lattice.rest_positions;
    let (_, shares) = Triangles::new(lattice.layout, &triangles(), rest, &lattice.area);
    let mut expected = vec![Vec3::ZERO; COUNT];
    for (corners, share) in triangles().into_iter().zip(shares) {
        let [a, b, c] = corners.map(|p| place(rest[p as usize]));
        let mean = corners.map(|p| velocity(rest[p as usize])).into_iter().sum::<Vec3>() / 3.0;
        let now = Vec3::new(2.0, 3.0, -1.0) - mean;
        let area = (b - a).cross(c - a) * 0.5;
        let force = LAW.force(area, now, now - GRAVITY * LAW.kick, share / 0.2);
        for p in corners {
            expected[p as usize] += force / (3.0 * masses()[p as usize]);
        }
    }
    for (i, (a, b)) in push(Isa::detect(), false, 0.8, velocity).iter().zip(expected).enumerate() {
        assert!(a.distance(b) <= 1e-4 * (1.0 + b.length()), "{i}: {a} and {b}");
    }
}

#[test]
fn the_shares_of_the_triangles_around_a_particle_are_no_more_than_it_weighs() {
    let lattice = lattice();
    let rest = &lattice.rest_positions;
    let (_, inverse) = Triangles::new(lattice.layout, &triangles(), rest, &lattice.area);
    let mut taken = vec![0.0; COUNT];
    for (corners, inverse) in triangles().into_iter().zip(inverse) {
        for p in corners {
            taken[p as usize] += 1.0 / (3.0 * inverse);
        }
    }
    for (slot, taken) in lattice.layout.slots().zip(taken) {
        assert!(taken <= lattice.area[slot] * 1.0001 && taken > 0.2 * lattice.area[slot]);
    }
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let velocity = |p: Vec3| Vec3::new(p.z, p.x * p.x, 1.0 - p.x);
    let first = push(Isa::Baseline, false, 0.8, velocity);
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        assert!(push(isa, false, 0.8, velocity) == first, "{isa:?}");
    }
}
