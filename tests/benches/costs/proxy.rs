//! A sheet that is drawn finer than it is simulated.

use crate::{
    app::{app_with, compare},
    turns::{Bound, Wrong, heading, line},
};
use bevy::{mesh::VertexAttributeValues, prelude::*};
use bevy_drape::{
    ClothProxy, ClothSleepThreshold,
    prelude::*,
    solver::{MassLumping, Substeps},
};

/// Particles a side that are drawn, and that are simulated.
const DRAWN: u32 = 100;
const SIMULATED: u32 = 45;
/// Root of the mean squared distance between the vertices of both after half a second \[m\].
const NEAR: f64 = 0.015;

/// What HANG is made of: threads that do not stretch, nothing that bends or brakes. All particles weigh the same.
fn of_hang() -> (ClothMaterial, ClothSettings) {
    let material = ClothMaterial {
        area_density: 0.2,
        thread_stiffness: 1e6,
        shear_stiffness: 1e6,
        flexural_rigidity: 0.0,
        bending_friction: 0.0,
        damping: 0.0,
        drag: 0.0,
        ..default()
    };
    (material, ClothSettings { masses: MassLumping::Equal, ..default() })
}

/// A square metre, held by two corners, let go flat.
fn hang(of: (ClothMaterial, ClothSettings), carried: bool) -> App {
    let mut app = app_with(true, ());
    let mut cloth = app.world_mut().spawn((
        Cloth::sheet(Vec2::ONE, UVec2::splat(DRAWN)),
        of,
        ClothPins::vertices([0, DRAWN - 1]),
        ClothSleepThreshold::NEVER,
        Transform::default(),
    ));
    if carried {
        cloth.insert(ClothProxy::grid(SIMULATED, SIMULATED));
    }
    // One of this size is made in the background.
    while ticks(&mut app) == 0 {
        app.update();
        std::thread::yield_now();
    }
    app
}

fn ticks(app: &mut App) -> u64 {
    let world = app.world_mut();
    world.query::<&ClothSimulation>().iter(world).map(ClothSimulation::tick_count).sum()
}

fn drawn(app: &mut App) -> Vec<Vec3> {
    let world = app.world_mut();
    let handle = world.query::<&Mesh3d>().single(world).expect("it is drawn").clone();
    let mesh = world.resource::<Assets<Mesh>>().get(&handle).expect("its mesh is there");
    match mesh.attribute(Mesh::ATTRIBUTE_POSITION) {
        Some(VertexAttributeValues::Float32x3(places)) => {
            places.iter().map(|place| Vec3::from_array(*place)).collect()
        }
        _ => Vec::new(),
    }
}

pub fn few_carry_many(rounds: usize, wrong: &mut Wrong) {
    heading("a whole update, a sheet of 100 x 100 drawn, us", "100 x 100", "45 x 45");
    let name = "ClothProxy";
    let with = |budget, (material, settings)| {
        (material, ClothSettings { substeps: Substeps::Automatic { budget }, ..settings })
    };
    for (name, of) in [
        (name, default()),
        ("ClothProxy, 8 substeps", with(8, default())),
        ("ClothProxy, HANG", of_hang()),
        ("ClothProxy, HANG, 13 substeps", with(13, of_hang())),
    ] {
        let apps = || [false, true].map(|carried| hang(of, carried));
        let turns = compare(name, rounds.div_ceil(2), apps, false, wrong);
        line(name, &turns, Bound::Times(0.35));
    }
    for (what, of) in [
        ("HANG", of_hang()),
        ("HANG, 13 substeps", with(13, of_hang())),
        ("the default material", default()),
    ] {
        let [whole, carried] = [false, true].map(|carried| {
            let mut app = hang(of, carried);
            // Of 1/64 s.
            while ticks(&mut app) < 32 {
                app.update();
            }
            drawn(&mut app)
        });
        let squares = whole.iter().zip(&carried).map(|(a, b)| f64::from(a.distance_squared(*b)));
        let rms = (squares.sum::<f64>() / whole.len() as f64).sqrt();
        println!("  {what}, 0.5 s: {:.2} mm apart (root of the mean square)", 1e3 * rms);
        let is_held_to = what.starts_with("HANG");
        wrong.unless(
            rms < NEAR || !is_held_to,
            name,
            "the drawn sheet is not where the whole one is",
        );
    }
}
