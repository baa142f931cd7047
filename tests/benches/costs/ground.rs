//! What a point costs on a height field, by how far from the ground it is.

use std::{error::Error, time::Instant};

use bevy::math::{Vec2, Vec3, ops};
use bevy_drape::sdf::{SignedDistance, shapes::HeightField};

use crate::turns::median;

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
    }
    Ok(())
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
