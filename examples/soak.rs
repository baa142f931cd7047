//! A soak: the scenes of the gallery for a long time of the game's, headless, while cloths and balls come and go,
//! are teleported, reset, pushed, grabbed, frozen and given other materials by chance.
//!
//! `cargo run --example soak -- --minutes 30`
//!
//! The exit code is 1 if a cloth is not finite, anything is refused, or memory grows.

// A program may print.
#![allow(clippy::print_stdout)]

mod gallery;

use bevy::prelude::*;
use bevy_drape::{ClothGrab, ClothPaused, ClothWindOverride, prelude::*};
use clap::Parser;
use examples_common::{Example, headless};
use std::{fs, process::ExitCode, time::Instant};

/// Memory that a scene may grow by after its first fifth \[MiB\]: what is kept of it, and no more.
const GROWTH: f64 = 8.0;

/// Runs the gallery for a long time, while things come and go by chance.
#[derive(Parser)]
struct Cli {
    /// Minutes of game time, shared out to the scenes.
    #[arg(short, long, default_value_t = 30.0)]
    minutes: f64,
    /// Particles a side of each cloth.
    #[arg(short, long, default_value_t = 24, value_parser = clap::value_parser!(u32).range(4..=128))]
    particles: u32,
    /// Which chances.
    #[arg(short, long, default_value_t = 1)]
    seed: u64,
}

fn main() -> ExitCode {
    let Cli { minutes, particles, seed } = Cli::parse();
    // A hundred thousand particles are for a look at speed, and would take all of the time.
    let scenes: Vec<Example> =
        gallery::SCENES.into_iter().filter(|scene| scene.name != "stress").collect();
    let ticks = (minutes * 60.0 * 64.0 / scenes.len() as f64).ceil() as usize;
    println!("{ticks} ticks of 1/64 s for each of {} scenes", scenes.len());
    let mut well = true;
    for (number, scene) in scenes.iter().enumerate() {
        let report = soak(*scene, particles, ticks, Chance(seed + number as u64));
        match report {
            Ok(report) => println!("{}: {report}", scene.name),
            Err(reason) => {
                println!("{}: FAILED: {reason}", scene.name);
                well = false;
            }
        }
    }
    if well { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Runs a scene, an event every quarter of a second or so.
fn soak(
    scene: Example,
    particles: u32,
    ticks: usize,
    mut chance: Chance,
) -> Result<String, String> {
    let started = Instant::now();
    let mut app = headless::app(scene, particles, 1);
    headless::simulate(&mut app, 0.1)?;
    let (mut events, mut early, mut extra) = (0, 0.0, Vec::new());
    for tick in 0..ticks {
        if tick == ticks / 5 {
            early = memory();
        }
        if chance.below(16) == 0 {
            events += 1;
            disturb(app.world_mut(), particles, &mut chance, &mut extra);
        }
        app.update();
        if tick % 16 == 0 {
            look(app.world_mut())?;
        }
    }
    let grown = memory() - early;
    if grown > GROWTH {
        return Err(format!("memory has grown by {grown:.1} MiB"));
    }
    let seconds = started.elapsed().as_secs_f64();
    Ok(format!("{events} events, memory {early:.1} {grown:+.1} MiB, {seconds:.0} s"))
}

/// Something happens by chance.
fn disturb(world: &mut World, particles: u32, chance: &mut Chance, extra: &mut Vec<Entity>) {
    let mut query = world.query_filtered::<Entity, With<Cloth>>();
    let cloths: Vec<Entity> = query.iter(world).collect();
    let cloth = cloths[chance.below(cloths.len())];
    let place = 2.0 * chance.ball() + 2.2 * Vec3::Y;
    match chance.below(10) {
        // What came by chance goes by chance.
        0 | 1 if extra.len() < 6 => extra.push(spawn(world, particles, place, chance)),
        0..=2 if !extra.is_empty() => {
            world.despawn(extra.swap_remove(chance.below(extra.len())));
        }
        3 => {
            let away = 40.0 * chance.ball().with_y(0.1);
            if let Some(mut transform) = world.get_mut::<Transform>(cloth) {
                transform.translation = (transform.translation + away).clamp_length_max(60.0);
            }
            world.trigger(TeleportCloth { entity: cloth });
        }
        4 => world.trigger(ResetCloth { entity: cloth }),
        5 => {
            let (_, fabric) = ClothMaterial::FABRICS[chance.below(6)];
            world.entity_mut(cloth).insert(fabric);
        }
        6 => {
            let wind = ClothWind::steady(8.0 * chance.ball());
            world.entity_mut(cloth).insert((ClothAir::default(), ClothWindOverride(wind)));
        }
        7 => drop(world.entity_mut(cloth).remove::<(ClothAir, ClothGrab, ClothPaused)>()),
        8 => {
            let target = place;
            world.entity_mut(cloth).insert(ClothGrab::particle(3, target));
        }
        _ => {
            if let Some(mut simulation) = world.get_mut::<ClothSimulation>(cloth) {
                simulation.set_velocities(|_| 3.0 * chance.now());
            }
            world.entity_mut(cloth).insert(ClothPaused { steps: 20 });
        }
    }
}

/// A cloth or a ball.
fn spawn(world: &mut World, particles: u32, place: Vec3, chance: &mut Chance) -> Entity {
    if chance.below(4) == 0 {
        let ball = Sphere::new(0.05 + 0.3 * chance.part());
        return world.spawn((SdfCollider::from(ball), Transform::from_translation(place))).id();
    }
    let (_, fabric) = ClothMaterial::FABRICS[chance.below(6)];
    let cloth = Cloth::sheet(Vec2::splat(0.3 + chance.part()), UVec2::splat(particles));
    let cloth = world.spawn((cloth, fabric, Transform::from_translation(place))).id();
    if chance.below(2) == 0 {
        world.entity_mut(cloth).insert(ClothPins::from(PinSelection::FirstRow));
    }
    cloth
}

/// Looks at all cloths.
fn look(world: &mut World) -> Result<(), String> {
    if let Some(failure) = world.query::<&ClothFailure>().iter(world).next() {
        return Err(failure.error.to_string());
    }
    let mut cloths = world.query::<&ClothSimulation>();
    let finite = cloths.iter(world).flat_map(ClothSimulation::positions).all(Vec3::is_finite);
    if finite { Ok(()) } else { Err("a particle is nowhere".into()) }
}

/// Memory of the process \[MiB\]; none where the system does not tell.
fn memory() -> f64 {
    let pages = fs::read_to_string("/proc/self/statm").ok();
    let resident = pages.and_then(|text| text.split(' ').nth(1)?.parse::<f64>().ok());
    resident.unwrap_or_default() * 4096.0 / f64::from(1 << 20)
}

/// Numbers by chance, the same for the same seed (`SplitMix64`).
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        self.now_bits()
    }

    fn now_bits(&self) -> u64 {
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    /// From 0 to 1.
    fn part(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1 << 24) as f32
    }

    /// Each coordinate from -1 to 1.
    fn ball(&mut self) -> Vec3 {
        2.0 * Vec3::new(self.part(), self.part(), self.part()) - Vec3::ONE
    }

    /// The same for all who ask now.
    fn now(&self) -> Vec3 {
        Chance(self.now_bits()).ball()
    }
}
