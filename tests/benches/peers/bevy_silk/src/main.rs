//! HANG and DRAPE in bevy_silk's solver, a row a level: see the README beside this package. Its calls alone, without ECS and mesh.

use std::{collections::HashMap, env, fs, time::Instant};

use bevy::math::{Mat4, Vec3};
use bevy_silk::{components::cloth::Cloth, prelude::*};

type Exact = HashMap<(usize, usize), Vec<(f64, f64)>>;

/// Distance from the held edge and height of each row, by number of particles and tenth of a second.
fn read_exact(path: &str) -> Exact {
    let mut exact = Exact::new();
    let text = fs::read_to_string(path).expect("the table of the exact motion");
    for line in text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())) {
        let row: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        let key = (row[0] as usize, (10.0 * row[1]).round() as usize);
        exact.entry(key).or_default().push((row[3], row[4]));
    }
    exact
}

fn run(scene: &str, n: usize, substeps: usize, depth: u8, exact: &Exact) {
    let hang = scene == "HANG";
    let (side, y, z0) = if hang { (1.0, 0.0, 0.0) } else { (2.0, 0.6, -1.0) };
    let rest = side / (n - 1) as f32;
    let start: Vec<Vec3> = (0..n * n)
        .map(|i| Vec3::new((i % n) as f32 * rest - side / 2.0, y, (i / n) as f32 * rest + z0))
        .collect();
    let mut indices = Vec::new();
    for r in 0..n as u32 - 1 {
        for c in 0..n as u32 - 1 {
            let a = r * n as u32 + c;
            let (b, c, d) = (a + 1, a + n as u32, a + n as u32 + 1);
            indices.extend([a, c, b, b, c, d]);
        }
    }
    let anchored = if hang { vec![0, n - 1] } else { Vec::new() };
    let mut cloth = Cloth::new(
        &start,
        &indices,
        anchored.into_iter().map(|i| (i, VertexAnchor::default())).collect(),
        StickGeneration::Triangles,
        StickLen::Auto,
        StickMode::Fixed,
        &Mat4::IDENTITY,
    );
    let h = 1.0 / 60.0 / substeps as f32;
    let (mut times, mut square, mut p99, mut deepest) = (Vec::new(), 0.0, 0.0_f64, 0.0_f64);
    for frame in 1..=180 {
        let before = Instant::now();
        for _ in 0..substeps {
            cloth.update_points(1.0, Vec3::NEG_Y * 9.81 * h * h);
            cloth.update_sticks(depth);
            if !hang {
                let out = |p: &Vec3| (p.length() < 0.5).then(|| p.normalize_or(Vec3::Y) * 0.5);
                cloth.solve_collisions(out);
            }
        }
        times.push(before.elapsed().as_secs_f64() * 1e3);
        let x = &cloth.current_point_positions;
        if hang && frame % 6 == 0 && frame <= 36 {
            let rows = &exact[&(n, frame / 6)];
            let error = |(i, p): (usize, &Vec3)| {
                let (out, y) = rows[i / n];
                let x = (i % n) as f64 / (n - 1) as f64 - 0.5;
                (f64::from(p.x) - x).powi(2) + (f64::from(p.y) - y).powi(2) + (f64::from(p.z) - out).powi(2)
            };
            square += x.iter().enumerate().map(error).sum::<f64>() / (n * n) as f64 / 6.0;
        }
        if frame % 60 == 0 {
            let mut strains = Vec::new();
            for i in 0..n * n {
                for (there, exists) in [(i + 1, i % n + 1 < n), (i + n, i / n + 1 < n)] {
                    if exists {
                        strains.push(f64::from(x[i].distance(x[there]) / rest) - 1.0);
                    }
                }
            }
            strains.sort_by(f64::total_cmp);
            p99 = p99.max(100.0 * strains[strains.len() * 99 / 100]);
        }
        if !hang {
            deepest = x.iter().map(|p| 1e3 * (0.5 - f64::from(p.length()))).fold(deepest, f64::max);
        }
    }
    times.sort_by(f64::total_cmp);
    let rms = if hang { format!("{:.4}", 1e3 * square.sqrt()) } else { String::new() };
    println!("bevy_silk,s{substeps}d{depth},{scene},{n},{:.4},{p99:.4},{rms},{deepest:.4}", times[90]);
}

fn main() {
    let exact = read_exact(&env::args().nth(1).expect("the path of hang_exact.csv"));
    for scene in ["HANG", "DRAPE"] {
        for n in [32, 64] {
            for (substeps, depth) in [(1, 5), (1, 20), (4, 5), (1, 60), (20, 5)] {
                run(scene, n, substeps, depth, &exact);
            }
        }
    }
}
