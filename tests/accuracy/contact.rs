//! Contact. Held to the gap epsilon that particles keep; to the geometry of facets over a ball
//! (`data/epsilon_sphere.csv`): with epsilon `sqrt(R^2 + a^2 / 2) - R` the faces of cells of side a stay
//! outside too; and to Coulomb's threshold and acceleration on inclines, also where `f32` is coarse.

use bevy::math::{
    DVec3, Quat, Vec2, Vec3,
    primitives::{InfinitePlane3d, Sphere},
};
use bevy_drape::solver::{
    ClothSolver, Collider, MassLumping, Material, Pose, Settings, StretchMethod,
};

use super::scenes::*;
use crate::support::solver::*;

/// Deepest of points of all faces below a ball of radius `r` about the origin.
fn deepest_face(x: &[DVec3], columns: usize, r: f64) -> f64 {
    let rows = x.len() / columns;
    let mut deepest = f64::NEG_INFINITY;
    for row in 0..rows - 1 {
        for column in 0..columns - 1 {
            let at = row * columns + column;
            for [a, b, c] in [[at, at + columns, at + 1], [at + 1, at + columns, at + columns + 1]]
            {
                for i in 0..=8 {
                    for j in 0..=8 - i {
                        let (s, t) = (f64::from(i) / 8.0, f64::from(j) / 8.0);
                        let p = x[a] * (1.0 - s - t) + x[b] * s + x[c] * t;
                        deepest = deepest.max(r - p.length());
                    }
                }
            }
        }
    }
    deepest
}

#[test]
fn the_table_of_facets_is_what_sampling_finds() {
    for row in table(include_str!("../data/epsilon_sphere.csv")) {
        let [r, a, facet, edge] = [0, 1, 2, 4].map(|i| row[i].parse::<f64>().unwrap());
        // The corners of a right triangle of legs a at R + epsilon: its hypotenuse's middle is lowest.
        let out = r + facet;
        let leg = a / 2.0_f64.sqrt();
        let height = (out * out - leg * leg).sqrt();
        check("middle of the facet over the ball [m]", height - r, 0.0, 1e-8);
        let out = r + edge;
        check(
            "middle of the edge over the ball [m]",
            out.hypot(0.0).powi(2) - a * a / 4.0,
            r * r,
            1e-8,
        );
    }
}

/// A sheet of cells `a` that lies on the top of a ball of radius R, held `thickness` off it.
fn on_a_ball(r: f64, a: f64, thickness: f64) -> Vec<DVec3> {
    let cells = 6;
    let sheet = Sheet::square(cells, a * cells as f64);
    let material = Material {
        thread_stiffness: 300.0,
        drag: 8.0,
        friction: 0.0,
        thickness: thickness as f32,
        ..plain()
    };
    // What holds the particles is measured.
    let settings = Settings { edges: false, ..settings(StretchMethod::ImplicitThreads, 16) };
    let middle = 0.5 * a * cells as f64;
    // Draped already: each particle above its place, on the ball.
    let out = r + thickness;
    let start: Vec<_> = sheet
        .rest()
        .iter()
        .map(|p| {
            let (x, z) = (p.x - middle, p.z - middle);
            Vec3::new(x as f32, (out * out - x * x - z * z).sqrt() as f32, z as f32)
        })
        .collect();
    let lattice = sheet.lattice(MassLumping::Lumped);
    let mut solver = ClothSolver::new(lattice, &start, material, settings).unwrap();
    let ball = Sphere::new(r as f32);
    run(&mut solver, 64, GRAVITY, &[Collider::new(&ball, Pose::IDENTITY)]);
    places(&solver)
}

#[test]
fn faces_clear_a_ball_with_the_epsilon_of_the_closed_form() {
    let (r, a) = (0.5, 0.05);
    let facet = (r * r + a * a / 2.0_f64).sqrt() - r;
    for part in [1.0, 0.5] {
        let x = on_a_ball(r, a, part * facet);
        let gaps: Vec<_> = x.iter().map(|p| p.length() - r - part * facet).collect();
        let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
        check(&format!("{part} of epsilon: least gap beyond it [m]"), least, 0.0, 2e-7);
        let touching: Vec<_> = gaps.iter().copied().filter(|&g| g < 1e-4).collect();
        assert!(touching.len() > 20, "{} touch", touching.len());
        let mean = touching.iter().sum::<f64>() / touching.len() as f64;
        check(&format!("{part} of epsilon: mean gap beyond it [m]"), mean, 0.0, 2e-6);
        // A flat sheet is strained on a ball: of the longest side that there is between right angles.
        let longest =
            (0..42).filter(|i| i % 7 < 6).map(|i| x[i + 1].distance(x[i + 7])).fold(0.0, f64::max);
        let out = r + part * facet;
        let expected = r - (out * out - longest * longest / 4.0).sqrt();
        let deepest = deepest_face(&x, 7, r);
        check(&format!("{part} of epsilon: deepest face [m]"), deepest, expected, 0.02 * facet);
        check(
            &format!("{part} of epsilon: the table's [m]"),
            deepest,
            (1.0 - part) * facet,
            0.1 * facet,
        );
    }
}

/// Way that a patch goes in a time down a slope of an angle in degrees, `high` above the origin.
fn slide(degrees: f64, mu: f32, high: f32, substeps: u32, ticks: usize) -> f64 {
    let turn = Quat::from_rotation_z(-degrees.to_radians() as f32);
    let pose = Pose { translation: Vec3::Y * high, rotation: turn, scale: 1.0 };
    let floor = InfinitePlane3d::new(Vec3::Y);
    let lattice = sheet(Vec2::splat(0.2), 5, 5, MassLumping::Lumped);
    let material = Material { friction: mu, ..plain() };
    let place = |p: &Vec3| turn * (*p + Vec3::Y * material.thickness) + pose.translation;
    let start: Vec<_> = lattice.rest_positions().iter().map(place).collect();
    let settings = settings(StretchMethod::ImplicitThreads, substeps);
    let mut solver = ClothSolver::new(lattice, &start, material, settings).unwrap();
    run(&mut solver, ticks, GRAVITY, &[Collider::new(&floor, pose).with_friction(mu)]);
    let down = (turn * Vec3::X).as_dvec3();
    (solver.position(12) - start[12]).as_dvec3().dot(down)
}

#[test]
fn the_threshold_of_sliding_is_coulombs_angle() {
    for mu in [0.2_f32, 0.5, 1.0] {
        let angle = f64::from(mu).atan().to_degrees();
        for high in [0.0, 2.0] {
            for substeps in [4, 64] {
                let (mut holds, mut slides) = (angle - 2.0, angle + 2.0);
                while slides - holds > 0.02 {
                    let middle = 0.5 * (holds + slides);
                    // What slides gains speed; what creeps does not.
                    let gone = slide(middle, mu, high, substeps, 64);
                    if gone > 2e-3 { slides = middle } else { holds = middle }
                }
                let what = format!("mu {mu} at {high} m x{substeps}: angle that slides [degrees]");
                // 2 m from the origin places are rounded to 1.2e-7 m, a fifth of what gravity does in the
                // finest of these substeps: some of the hold of friction is lost in that.
                let coarse = high > 0.0 && substeps == 64;
                check(&what, 0.5 * (holds + slides), angle, 0.1);
                let below = (0.95 * f64::from(mu)).atan().to_degrees();
                let creep = slide(below, mu, high, substeps, 640);
                let what = format!(
                    "mu {mu} at {high} m x{substeps}, 0.95 of its slope: creep in 10 s [m]"
                );
                check_at_most(&what, creep.abs(), if coarse { 1e-3 } else { 1e-5 });
            }
        }
    }
}

#[test]
fn the_acceleration_beyond_it_is_coulombs() {
    for mu in [0.2_f32, 0.5] {
        for high in [0.0, 2.0] {
            for substeps in [4, 16, 64] {
                for factor in [1.05, 1.5] {
                    let angle = (factor * f64::from(mu)).atan();
                    let expected = 9.81 * (angle.sin() - f64::from(mu) * angle.cos());
                    let way = slide(angle.to_degrees(), mu, high, substeps, 64);
                    let what =
                        format!("mu {mu} x{factor} at {high} m x{substeps}: acceleration [m/s2]");
                    check(&what, 2.0 * way, expected, 5e-3 * expected);
                }
            }
        }
    }
}
