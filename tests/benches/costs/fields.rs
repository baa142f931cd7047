//! What baked fields cost: a drape on one in place of the shape itself, and the bake.

use std::{collections::BTreeMap, error::Error, sync::Arc, time::Instant};

use bevy::math::{Vec2, Vec3, primitives::Sphere};
use bevy_drape::{
    sdf::{BakeSettings, DistanceField},
    solver::{Collider, Lattice, MassLumping, Pose},
};
use examples_common::repository;

use crate::{
    solver::{Scene, compare},
    turns::{Bound, Wrong, heading, line},
};

/// A closed mesh: positions, and corners of triangles.
type Closed = (Vec<Vec3>, Vec<u32>);

pub fn fields(n: usize, rounds: usize, wrong: &mut Wrong) -> Result<(), Box<dyn Error>> {
    drape(n, rounds, wrong)?;
    bake()
}

fn drape(n: usize, rounds: usize, wrong: &mut Wrong) -> Result<(), Box<dyn Error>> {
    const RADIUS: f32 = 0.5;
    let lattice = Arc::new(Lattice::sheet(Vec2::splat(2.0), n, n, MassLumping::Lumped)?);
    let (positions, indices) = ball(RADIUS);
    let ball = Sphere::new(RADIUS);
    let place = Pose::from_translation(Vec3::NEG_Y * 0.51);
    let shape = [Collider::new(&ball, place)];
    let free = Scene::new(lattice.into(), 0.0)?;
    heading("a baked field, us a tick, draped on a ball", "sphere", "field");
    for cells in [32, 64, 128] {
        let settings = BakeSettings::for_mesh(&positions, cells);
        let field = DistanceField::bake(&positions, &indices, &settings)?;
        let baked = [Collider::new(&field, place)];
        let name = format!("of {cells} cells");
        // Friction holds it on the ball for so long.
        let (without, with) = (free.clone().among(&shape), free.clone().among(&baked));
        let turns = compare(&name, rounds.min(90), (&without, with), false, wrong);
        line(&name, &turns, Bound::Times(1.3));
    }
    Ok(())
}

/// The bunny of `assets/` in 70,000 triangles.
fn bake() -> Result<(), Box<dyn Error>> {
    let (models, _) = tobj::load_obj(repository("assets/bunny.obj"), &tobj::GPU_LOAD_OPTIONS)?;
    let bunny = &models.first().ok_or("the bunny's file is empty")?.mesh;
    let positions = bunny.positions.as_chunks().0.iter().map(|&p| Vec3::from_array(p)).collect();
    let quartered = quarter(quarter((positions, bunny.indices.clone())));
    let (positions, indices) = split(quartered, 70_000);
    println!("\nthe bunny of {} triangles baked, one thread", indices.len() / 3);
    for (cells, bound) in [(64, 1.0), (128, 6.0)] {
        let settings = BakeSettings::for_mesh(&positions, cells);
        let begun = Instant::now();
        let field = DistanceField::bake(&positions, &indices, &settings)?;
        let time = begun.elapsed().as_secs_f64();
        let memory = field.memory_bytes() as f64 / (1 << 20) as f64;
        let missed = if time > bound { ": MISSED" } else { "" };
        let name = format!("{cells} cells along its longest side");
        println!("  {name:48} {time:8.2} s, bound {bound}; {memory:.1} MiB{missed}");
    }
    Ok(())
}

/// An octahedron quartered, and blown up to a ball.
fn ball(radius: f32) -> Closed {
    let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let faces =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let mut mesh = (axes.to_vec(), faces.as_flattened().to_vec());
    for _ in 0..5 {
        mesh = quarter(mesh);
        mesh.0.iter_mut().for_each(|p| *p = p.normalize() * radius);
    }
    mesh
}

/// Each triangle as four, by the middles of its edges.
fn quarter((mut positions, indices): Closed) -> Closed {
    let mut middles = BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            positions.push(0.5 * (positions[a as usize] + positions[b as usize]));
            positions.len() as u32 - 1
        })
    };
    let quarters = |&[a, b, c]: &[u32; 3]| {
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    };
    let all: Vec<_> = indices.as_chunks().0.iter().flat_map(quarters).collect();
    (positions, all.as_flattened().to_vec())
}

/// As many triangles, or one more, by splitting the first ones at their middles.
fn split((mut positions, indices): Closed, triangles: usize) -> Closed {
    let faces: &[[u32; 3]] = indices.as_chunks().0;
    let count = triangles.saturating_sub(faces.len()).div_ceil(2);
    let mut all = faces[count..].to_vec();
    for &[a, b, c] in &faces[..count] {
        let middle = positions.len() as u32;
        let sum = [a, b, c].map(|i| positions[i as usize]).iter().sum::<Vec3>();
        positions.push(sum / 3.0);
        all.extend([[a, b, middle], [b, c, middle], [c, a, middle]]);
    }
    (positions, all.as_flattened().to_vec())
}
