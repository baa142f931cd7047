//! What a point costs on a height field, by how far from the ground it is; and near shells and compounds, by how many parts they
//! have. What a cloth costs that lies on hills.

use std::{error::Error, sync::Arc, time::Instant};

use bevy::math::{
    Quat, Vec2, Vec3, ops,
    primitives::{InfinitePlane3d, Sphere},
};
use bevy_drape::sdf::shapes::{Compound, HeightField, Part, Shell};
use bevy_drape::sdf::{LANES, PointBlock, SampleBlock, SignedDistance};
use bevy_drape::solver::{Collider, Lattice, MassLumping, Pose};

use crate::{
    solver::{Scene, compare},
    turns::{Bound, Wrong, heading, line, median},
};

/// Points that are looked at in one go, and how often.
const POINTS: usize = 20_000;
const TURNS: usize = 9;

/// Numbers from 0 to 1, always the same.
struct Dice(u32);

impl Dice {
    fn roll(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 24) as f32
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.roll()
    }
}

pub fn ground() -> Result<(), Box<dyn Error>> {
    for count in [257, 2049] {
        let size = Vec2::splat(count as f32 - 1.0);
        let heights = hills(count, 20.0);
        let begun = Instant::now();
        let field = HeightField::new(count, count, heights, size)?;
        let (time, memory) = (begun.elapsed().as_secs_f64(), field.memory_bytes() as f64 / 1e6);
        println!("\nground of {count} x {count}, made in {time:.2} s, {memory:.1} MB; ns a point");
        println!("  {:48} {:>10} {:>10}", "", "within 2 m", "anywhere");
        for (name, low, high) in [
            ("within 0.05 m", 0.0, 0.05),
            ("0.05 to 0.5 m above", 0.05, 0.5),
            ("0.5 to 2 m above", 0.5, 2.0),
            ("2 to 10 m above", 2.0, 10.0),
            ("50 m above", 50.0, 50.0),
            ("0.5 m below", -0.5, -0.5),
            ("5 m below", -5.0, -5.0),
        ] {
            let [near, far] = [2.0, 0.9 * size.x].map(|side| cost(&field, side, [low, high]));
            println!("  {name:48} {near:10.0} {far:10.0}");
        }
        let places: Vec<Vec3> = (0..POINTS).map(|k| on_ground(&field, k)).collect();
        let name = "16 within 0.05 m, 0.03 m apart, at once";
        println!("  {name:48} {:>10} {:10.0}", "", block_cost(&field, &places, Some(&field)));
    }
    println!("\nof many parts, a point within 0.05 m, 16 points 0.03 m apart at once");
    println!("  {:32} {:>10} {:>10} {:>10}", "", "made in s", "MB", "ns a point");
    for side in [8, 32, 128, 512] {
        let (count, spacing) = (side as f32, 0.25 * side as f32);
        let heights = hills(side + 1, 0.1 * spacing);
        let place = |k: usize| spacing * (k as f32 / count - 0.5);
        let vertex = |k: usize| {
            let (i, j) = (k / (side + 1), k % (side + 1));
            Vec3::new(place(j), heights[k], place(i))
        };
        let vertices: Vec<Vec3> = (0..heights.len()).map(vertex).collect();
        let begun = Instant::now();
        let shell = Shell::new(&vertices, &squares(side), 0.02)?;
        let (made, memory) = (begun.elapsed().as_secs_f64(), shell.memory_bytes() as f64 / 1e6);
        let name = format!("shell of {} triangles", shell.triangle_count());
        let cost = block_cost(&shell, &vertices, None);
        println!("  {name:32} {made:10.3} {memory:10.2} {cost:10.1}");

        let ball = |at: &Vec3| Part::new(Sphere::new(0.1), *at, Quat::IDENTITY);
        let begun = Instant::now();
        let balls = Compound::new(vertices.iter().map(ball))?;
        let made = begun.elapsed().as_secs_f64();
        let name = format!("compound of {} balls", balls.part_count());
        let cost = block_cost(&balls, &vertices, None);
        println!("  {name:32} {made:10.3} {:>10} {cost:10.1}", "");
    }
    Ok(())
}

/// A cloth that lies on hills, and one that lies on a plane.
pub fn lying(rounds: usize, wrong: &mut Wrong) -> Result<(), Box<dyn Error>> {
    let lattice = Arc::new(Lattice::sheet(Vec2::ONE, 64, 64, MassLumping::Lumped)?);
    heading("on the ground, us a tick, 64 x 64 on a square metre", "plane", "hills");
    let plane = InfinitePlane3d::default();
    for (name, count) in [("cells of 25 cm", 17), ("cells of 6 cm", 65)] {
        let field = HeightField::new(count, count, hills(count, 0.03), Vec2::splat(4.0))?;
        let under = |solid, below| [Collider::new(solid, Pose::from_translation(Vec3::Y * below))];
        let (on_plane, on_hills) =
            (under(&plane as &dyn SignedDistance, -0.05), under(&field, -0.06));
        let without = Scene::new(lattice.clone().into(), 1e-5)?.among(&on_plane);
        let with = Scene::new(lattice.clone().into(), 1e-5)?.among(&on_hills);
        line(name, &compare(name, rounds, (&without, with), false, wrong), Bound::None);
    }
    Ok(())
}

/// A place on the ground, all over it.
fn on_ground(field: &HeightField, k: usize) -> Vec3 {
    let part = |many: f32| (many * k as f32).fract() - 0.5;
    let (x, z) = (0.9 * part(0.618_034) * field.size().x, 0.9 * part(0.754_878) * field.size().y);
    Vec3::new(x, field.height_at(x, z).unwrap_or_default(), z)
}

/// Two triangles for each square of a grid.
fn squares(side: usize) -> Vec<u32> {
    let corner = |i: usize, j: usize| (i * (side + 1) + j) as u32;
    let cells = (0..side * side).map(|k| (k / side, k % side));
    cells
        .flat_map(|(i, j)| {
            let [a, b] = [corner(i, j), corner(i, j + 1)];
            let [c, d] = [corner(i + 1, j), corner(i + 1, j + 1)];
            [a, c, b, b, c, d]
        })
        .collect()
}

/// The cost of a point in a row of 16 that begins near one of these places \[ns\], and goes along the ground if there is any.
fn block_cost(solid: &dyn SignedDistance, places: &[Vec3], ground: Option<&HeightField>) -> f64 {
    let mut dice = Dice(73);
    let blocks: Vec<_> = (0..POINTS / LANES)
        .map(|_| {
            let first = places[(dice.roll() * places.len() as f32) as usize % places.len()];
            let mut block = PointBlock::default();
            for lane in 0..LANES {
                let at = first + Vec3::X * 0.03 * lane as f32;
                let height = ground.and_then(|ground| ground.height_at(at.x, at.z));
                let up = height.unwrap_or(at.y) + dice.between(0.0, 0.05);
                block.set(lane, at.with_y(up));
            }
            block
        })
        .collect();
    let turn = |_| {
        let begun = Instant::now();
        let mut out = SampleBlock::default();
        for block in &blocks {
            solid.sample_block(block, &mut out);
            core::hint::black_box(&out);
        }
        begun.elapsed().as_secs_f64() * 1e9 / POINTS as f64
    };
    median((0..TURNS).map(turn).collect())
}

/// Hills of several lengths, and a cliff.
fn hills(count: usize, height: f32) -> Vec<f32> {
    let mut dice = Dice(60);
    let place = |i: usize| i as f32 / (count - 1) as f32;
    (0..count * count)
        .map(|i| {
            let (u, v) = (place(i % count), place(i / count));
            let waves = ops::sin(6.0 * u) * ops::cos(5.0 * v + 1.0);
            let ripples = 0.3 * ops::sin(23.0 * u + 11.0 * v);
            let cliff = if u + 0.3 * v > 0.7 { 0.8 } else { 0.0 };
            height * (waves + ripples + cliff + dice.between(-0.05, 0.05))
        })
        .collect()
}

/// What one of many points costs that are in the middle, within so long a side, and so far above the ground \[ns\].
fn cost(field: &HeightField, side: f32, [low, high]: [f32; 2]) -> f64 {
    let mut dice = Dice(72);
    let points: Vec<_> = (0..POINTS)
        .map(|_| {
            let [x, z] = [(); 2].map(|()| side * dice.between(-0.5, 0.5));
            let ground = field.height_at(x, z).unwrap_or_default();
            Vec3::new(x, ground + dice.between(low, high), z)
        })
        .collect();
    let turn = |_| {
        let begun = Instant::now();
        let sum: f32 = points.iter().map(|&p| field.sample(p).distance).sum();
        core::hint::black_box(sum);
        begun.elapsed().as_secs_f64() * 1e9 / POINTS as f64
    };
    median((0..TURNS).map(turn).collect())
}
