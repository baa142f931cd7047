//! Bodies that strike a cloth which is held: it catches them.

use bevy::math::{
    Vec2, Vec3,
    primitives::{Capsule3d, Cuboid, Sphere},
};
use bevy_drape::sdf::SignedDistance;
use bevy_drape::solver::{ClothSolver, PinMotion, Settings, StepInput, Substeps, Topology};

use crate::bodies::{Body, GRAVITY, hung_by_corners};
use crate::support::{sheets::mesh, solver::*};

const SIDE: u32 = 36;

/// A metre of cloth of 0.2 kg held at its four corners, with an automatic number of substeps.
fn hammock(is_mesh: bool, budget: u32) -> (ClothSolver, Vec<PinMotion>) {
    let (topology, by): (Topology, _) = match is_mesh {
        true => (mesh(36, 36, 1.0 / 35.0, 0.3).into(), Vec3::new(-0.5, 0.0, -0.5)),
        false => (sheet(Vec2::ONE, 36, 36, Settings::default().lumping).into(), Vec3::ZERO),
    };
    let (mut cloth, pins) = hung_by_corners(topology, SIDE, by);
    let substeps = Substeps::Automatic { budget };
    cloth.set_settings(Settings { substeps, ..*cloth.settings() }).unwrap();
    (cloth, pins)
}

/// Shapes with their masses \[kg\], moments of inertia, and half heights \[m\].
fn shapes() -> Vec<(Box<dyn SignedDistance>, f32, Vec3, f32)> {
    let of_box = |size: Vec3, mass: f32| {
        let squares = size * size;
        (Vec3::splat(squares.element_sum()) - squares) * (mass / 12.0)
    };
    let (cube, slab) = (Vec3::splat(0.16), Vec3::new(0.28, 0.06, 0.2));
    vec![
        (Box::new(Sphere::new(0.05)), 0.7, Vec3::splat(7e-4), 0.05),
        (Box::new(Cuboid::from_size(cube)), 4.5, of_box(cube, 4.5), 0.08),
        (Box::new(Cuboid::from_size(slab)), 5.0, of_box(slab, 5.0), 0.03),
        (Box::new(Capsule3d::new(0.03, 0.13)), 0.76, Vec3::new(1.6e-3, 3.4e-4, 1.6e-3), 0.095),
    ]
}

/// Whether a body falls through a hammock that it is dropped onto.
fn falls_through(
    (mut cloth, pins): (ClothSolver, Vec<PinMotion>),
    mut body: Body,
    shape: &dyn SignedDistance,
    rate: f32,
) -> bool {
    let gravity = Vec3::NEG_Y * GRAVITY;
    let input = StepInput { dt: 1.0 / rate, gravity, pins: &pins, ..StepInput::default() };
    (0..(2.5 * rate) as u32).any(|_| {
        body.tick(&mut cloth, shape, &input);
        let Vec3 { x, y, z } = body.place;
        y < -0.6 && x.abs() < 0.5 && z.abs() < 0.5
    })
}

/// With the substeps of the budget alone, or a cloth that takes up mass in the tick after it is struck, eight substeps let most of them through.
#[test]
fn what_falls_from_metres_up_is_caught() {
    let mut fallen = Vec::new();
    let mut count = 0;
    for (is_mesh, budget) in [(false, 8), (true, 8), (false, 20), (true, 20)] {
        for (height, rate) in [(1.0, 32.0), (2.0, 64.0), (5.0, 64.0)] {
            for (i, (shape, mass, inertia, half)) in shapes().into_iter().enumerate() {
                let place = Vec3::new(0.06 * i as f32 - 0.1, height + half + 0.02, 0.05);
                let body = Body { inertia, ..Body::ball(mass, place) };
                count += 1;
                if falls_through(hammock(is_mesh, budget), body, &*shape, rate) {
                    fallen.push((is_mesh, budget, height, mass));
                }
            }
        }
    }
    println!("{} of {count} fall through: {fallen:?}", fallen.len());
    assert!(fallen.is_empty(), "mesh, budget, height [m], mass [kg]: {fallen:?}");
}

/// A cloth of 36 particles a side, and a ball above it which falls at a speed \[m/s\].
struct Falling {
    cloth: ClothSolver,
    pins: Vec<PinMotion>,
    ball: Body,
}

impl Falling {
    fn at(speed: f32, height: f32) -> Self {
        let (cloth, pins) = hammock(false, 8);
        let velocity = Vec3::NEG_Y * speed;
        let inertia = Vec3::splat(7e-4);
        Self { cloth, pins, ball: Body { velocity, inertia, ..Body::ball(0.7, Vec3::Y * height) } }
    }

    fn tick(&mut self) {
        let gravity = Vec3::NEG_Y * GRAVITY;
        let input = StepInput { dt: 1.0 / 60.0, gravity, pins: &self.pins, ..StepInput::default() };
        self.ball.tick(&mut self.cloth, &Sphere::new(0.05), &input);
    }

    fn substeps(&self) -> [u32; 2] {
        [self.cloth.plan().substeps, self.cloth.plan().bodies]
    }
}

#[test]
fn the_plan_has_the_substeps_that_fast_bodies_need() {
    // With what it gains in the tick it goes a tenth of a metre in 1/60 s, 24 times 0.15 of what particles are apart.
    let mut falling = Falling::at(5.8, 0.2);
    falling.tick();
    assert_eq!(falling.substeps(), [24, 24]);
    let plan = falling.cloth.plan().to_string();
    assert!(plan.contains("bodies need 24"), "{plan}");
    // Until it is caught. What lies in the cloth asks for none.
    let mut ticks = 0;
    while falling.substeps()[0] >= 20 {
        falling.tick();
        ticks += 1;
    }
    assert!((15..60).contains(&ticks), "{ticks}");
    (0..300).for_each(|_| falling.tick());
    assert_eq!(falling.substeps(), [8, 0]);
    assert!(falling.ball.velocity.length() < 0.3, "{}", falling.ball.velocity);

    // What is slow, far away, or passes by.
    for (speed, height) in [(0.5, 0.2), (6.0, 3.0)] {
        let mut falling = Falling::at(speed, height);
        falling.tick();
        assert_eq!(falling.substeps(), [8, 0], "{speed} m/s from {height} m");
    }
    let mut passing = Falling::at(5.8, 0.2);
    passing.ball.place.x = -0.7;
    passing.ball.velocity = Vec3::X * 12.0;
    passing.tick();
    assert_eq!(passing.substeps(), [40, 40]);
    (0..12).for_each(|_| passing.tick());
    assert_eq!(passing.substeps(), [8, 0]);

    // A cloth that nothing holds is taken along, and fixed substeps are as they are set.
    let mut free = Falling::at(5.8, 0.2);
    free.cloth.set_pins(&[]).unwrap();
    free.pins.clear();
    free.tick();
    assert_eq!(free.substeps(), [8, 0]);
    let mut fixed = Falling::at(5.8, 0.2);
    let settings = Settings { substeps: Substeps::Fixed(8), ..*fixed.cloth.settings() };
    fixed.cloth.set_settings(settings).unwrap();
    fixed.tick();
    assert_eq!(fixed.cloth.plan().substeps, 8);
    // A cloth that goes along with the body.
    let mut along = Falling::at(5.8, 0.2);
    for pin in &mut along.pins {
        pin.end = pin.start + Vec3::NEG_Y * 0.1;
    }
    along.tick();
    assert_eq!(along.substeps(), [8, 0]);
}

/// A save brings with it for how long what has struck is still caught.
#[test]
fn a_cloth_that_is_struck_goes_on_to_the_bit_when_it_is_restored() {
    let mut falling = Falling::at(5.8, 0.2);
    (0..8).for_each(|_| falling.tick());
    assert!(falling.substeps()[1] >= 20, "{:?}", falling.substeps());
    let mut other = Falling::at(5.8, 0.2);
    other.cloth.restore(&falling.cloth.save()).unwrap();
    other.ball = falling.ball;
    for tick in 0..40 {
        falling.tick();
        other.tick();
        assert_eq!(falling.substeps(), other.substeps(), "{tick}");
        assert_eq!(falling.ball.place, other.ball.place, "{tick}");
    }
    assert!(bits(&falling.cloth) == bits(&other.cloth));
}
