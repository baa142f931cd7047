//! Meshes as garments are: ribbons, tubes with holes, pockets sewn on, loose parts, triangles of bad shape and of all sizes.

use std::f32::consts::TAU;
use std::sync::Arc;

use bevy::math::Vec3;
use bevy_drape::solver::{ClothSolver, Graph, MassLumping, Material, Settings, Substeps};

use crate::graph::{FORMS, hangs};
use crate::support::solver::*;

/// Triangles of a grid of quads, their diagonals in turns, without those that `is_hole` says.
fn quads(rows: u32, columns: u32, is_hole: impl Fn(u32, u32) -> bool) -> Vec<[u32; 3]> {
    (0..rows - 1)
        .flat_map(|r| (0..columns - 1).map(move |c| (r, c)))
        .filter(|&(r, c)| !is_hole(r, c))
        .flat_map(|(r, c)| halves(r * columns + c, columns as usize, (r + c) % 2 == 0))
        .collect()
}

#[test]
fn a_ribbon_of_one_triangle_hangs() {
    // Zigzag from side to side.
    let at = |i: u32| Vec3::new(0.03 * (i % 2) as f32, -0.02 * i as f32, 0.0);
    let positions = (0..50).map(at).collect();
    hangs(positions, (0..48).map(|i| [i, i + 1, i + 2]).collect(), &[0, 1], "ribbon");
}

#[test]
fn two_triangles_hang() {
    let corner = Vec3::new(0.1, -0.2, 0.0);
    let positions = vec![Vec3::ZERO, Vec3::X * 0.2, corner, corner + Vec3::X * 0.2];
    hangs(positions, vec![[0, 1, 2], [1, 3, 2]], &[0], "triangles");
}

/// A shirt without sleeves, open in front: a tube with a slit, and holes for the arms; held by its shoulders.
fn shirt() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (rows, columns) = (20, 37);
    let at = |r: u32, c: u32| {
        let angle = TAU * (0.02 + 0.96 * c as f32 / (columns - 1) as f32);
        let wide = 0.2 + 0.05 * (r as f32 / rows as f32);
        Vec3::new(wide * angle.sin(), -0.035 * r as f32, 0.7 * wide * angle.cos())
    };
    let positions = (0..rows).flat_map(|r| (0..columns).map(move |c| at(r, c))).collect();
    let is_arm = |c: u32| c.abs_diff(9) < 3 || c.abs_diff(27) < 3;
    (positions, quads(rows, columns, |r, c| (2..8).contains(&r) && is_arm(c)))
}

/// Leaves out vertices that no triangle has.
fn without_unused(positions: &[Vec3], triangles: &[[u32; 3]]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let new = |old: u32| used.binary_search(&old).unwrap() as u32;
    let kept = used.iter().map(|&old| positions[old as usize]).collect();
    (kept, triangles.iter().map(|corners| corners.map(new)).collect())
}

#[test]
fn an_open_shirt_hangs_from_its_shoulders() {
    let (positions, triangles) = shirt();
    let (positions, triangles) = without_unused(&positions, &triangles);
    let shoulders: Vec<u32> = (7..12).chain(25..30).collect();
    hangs(positions, triangles, &shoulders, "shirt");
}

/// Edges of three triangles, as those of a pocket have, stretch like others and do not bend.
#[test]
fn a_pocket_that_is_sewn_on_keeps_its_seams() {
    let (n, cell) = (13_u32, 0.05);
    let mut positions: Vec<_> = (0..n)
        .flat_map(|r| (0..n).map(move |c| Vec3::new(c as f32, -(r as f32), 0.0) * cell))
        .collect();
    let mut triangles = quads(n, n, |_, _| false);
    // From the fourth to the ninth row and column, its upper edge open.
    let (first, size) = (4, 6);
    let at = |r: u32, c: u32| (first + r) * n + first + c;
    let mut pocket = vec![0; (size * size) as usize];
    for r in 0..size {
        for c in 0..size {
            let is_sewn = r + 1 == size || c == 0 || c + 1 == size;
            pocket[(r * size + c) as usize] = if is_sewn {
                at(r, c)
            } else {
                positions.push(positions[at(r, c) as usize] + Vec3::Z * 0.01);
                positions.len() as u32 - 1
            };
        }
    }
    let mut sewn = quads(size, size, |_, _| false);
    for corners in &mut sewn {
        *corners = corners.map(|corner| pocket[corner as usize]);
    }
    // What lies between two corners of the seam is there already.
    let known = |corners: &[u32; 3]| {
        let sorted = |mut corners: [u32; 3]| {
            corners.sort_unstable();
            corners
        };
        triangles.iter().any(|other| sorted(*other) == sorted(*corners))
    };
    sewn.retain(|corners| !known(corners));
    triangles.extend(sewn);
    hangs(positions, triangles, &[0, n - 1], "pocket");
}

#[test]
fn loose_parts_go_their_own_ways() {
    let (one, triangles) = jittered(7, 7, 0.05, 0.25, 5);
    let count = one.len() as u32;
    let positions: Vec<_> = one.iter().copied().chain(one.iter().map(|p| p + Vec3::Y)).collect();
    let other = triangles.iter().map(|corners| corners.map(|corner| corner + count));
    let triangles: Vec<_> = triangles.iter().copied().chain(other).collect();
    let graph = Arc::new(Graph::new(&positions, &triangles, MassLumping::Lumped).unwrap());
    for form in FORMS {
        let material = Material { thread_stiffness: 500.0, flexural_rigidity: 1e-4, ..plain() };
        let mut solver = at_rest(&graph, Vec3::ZERO, material, settings(form, 16));
        solver.set_pins(&[0, 6]).unwrap();
        run(&mut solver, 64, GRAVITY, &[]);
        // The second is held by nothing.
        let fallen = |i: u32| f64::from(solver.position(i as usize).y - positions[i as usize].y);
        for particle in count..2 * count {
            check(&format!("{form:?}: fallen in 1 s [m]"), fallen(particle), -0.5 * 9.81, 1e-3);
        }
        check_at_most("the first one's farthest fall [m]", -fallen(count - 1), 0.7);
    }
}

/// What a user gets who hangs a mesh in the given way, for four seconds: the largest strain meanwhile, and at the end.
fn hung(positions: &[Vec3], triangles: &[[u32; 3]], pins: &[u32]) -> [f64; 2] {
    let graph = Arc::new(Graph::new(positions, triangles, MassLumping::Lumped).unwrap());
    let mut solver: ClothSolver = at_rest(&graph, Vec3::ZERO, usual(), Settings::default());
    solver.set_pins(pins).unwrap();
    let mut most = 0.0_f32;
    for _ in 0..256 {
        most = most.max(run(&mut solver, 1, GRAVITY, &[]).max_strain);
    }
    [most.into(), solver.strain().max.into()]
}

#[test]
fn triangles_a_hundred_times_as_long_as_wide() {
    // Along the pull, and across it.
    for (name, cell) in [("along", [0.001, 0.1]), ("across", [0.1, 0.001])] {
        let (rows, columns) = if cell[0] < cell[1] { (9, 41) } else { (41, 9) };
        let place = |r: u32, c: u32| Vec3::new(cell[0] * c as f32, -cell[1] * r as f32, 0.0);
        let positions: Vec<_> =
            (0..rows).flat_map(|r| (0..columns).map(move |c| place(r, c))).collect();
        let top: Vec<_> = (0..columns).collect();
        let [most, last] = hung(&positions, &quads(rows, columns, |_, _| false), &top);
        check_at_most(&format!("{name}: largest strain over 4 s"), most, 0.3);
        check_at_most(&format!("{name}: strain at the end"), last, 0.12);
    }
}

#[test]
fn tiny_and_huge_triangles_side_by_side() {
    // Each row is 1.3 times as wide as the last one, from 1 mm to 0.2 m, and so is each column.
    let n = 21_u32;
    let along = |i: u32| 0.001 * (1.3_f32.powi(i as i32) - 1.0) / 0.3;
    let place = |r: u32, c: u32| Vec3::new(along(c), -along(r), 0.0);
    let positions: Vec<_> = (0..n).flat_map(|r| (0..n).map(move |c| place(r, c))).collect();
    let top: Vec<_> = (0..n).collect();
    let triangles = quads(n, n, |_, _| false);
    // From the side of the tiny ones, and from two corners. At one of them triangles of a millimetre bear half of the cloth,
    // some 400 N/m: more than the limit, and its masses of 1 to 40,000, let one pass hold.
    for (name, pins, bound) in [("edge", &top[..], 0.02), ("corners", &[0, n - 1], 0.6)] {
        let [most, last] = hung(&positions, &triangles, pins);
        check_at_most(&format!("{name}: largest strain over 4 s"), most, bound);
        check_at_most(&format!("{name}: strain at the end"), last, bound);
    }
}

#[test]
fn a_mesh_that_jerks_is_held_to_its_limit_at_the_end_of_ticks() {
    // It falls from the plane of its two pins, with few substeps, and jerks at them: one pass of the limit in each substep would leave
    // 39 % where 10 % are allowed.
    let n = 48;
    let (positions, triangles) = jittered(n, n, 1.0 / (n - 1) as f32, 0.3, 5);
    let graph = Arc::new(Graph::new(&positions, &triangles, MassLumping::Lumped).unwrap());
    let settings = Settings { substeps: Substeps::Fixed(8), ..Settings::default() };
    let mut solver: ClothSolver = at_rest(&graph, Vec3::ZERO, usual(), settings);
    solver.set_pins(&[0, n as u32 - 1]).unwrap();
    let strains: Vec<_> = (0..192).map(|_| run(&mut solver, 1, GRAVITY, &[]).max_strain).collect();
    let most = strains.iter().copied().fold(0.0, f32::max);
    let limit = solver.material().max_strain;
    assert!(most > limit, "it jerks: {most}");
    check_at_most("largest strain at a tick's end", most.into(), 0.25);
}
