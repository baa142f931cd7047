//! Bodies that strike a cloth which is held: it catches them.

use bevy::math::{
    Vec2, Vec3,
    primitives::{Capsule3d, Cuboid, Sphere},
};
use bevy_drape::sdf::SignedDistance;
use bevy_drape::solver::{
    ClothSolver, Material, PinMotion, PinPull, PlanReason, Settings, StepInput, Substeps, Topology,
};

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

/// Drops a body onto a hammock. Returns how high it comes up again \[m\], or `None` if it falls through.
fn rebound(
    (mut cloth, pins): (ClothSolver, Vec<PinMotion>),
    mut body: Body,
    shape: &dyn SignedDistance,
    rate: f32,
) -> Option<f32> {
    let gravity = Vec3::NEG_Y * GRAVITY;
    let input = StepInput { dt: 1.0 / rate, gravity, pins: &pins, ..StepInput::default() };
    let mut highest = f32::MIN;
    for _ in 0..(2.5 * rate) as u32 {
        body.tick(&mut cloth, shape, &input);
        let Vec3 { x, y, z } = body.place;
        if y < -0.6 && x.abs() < 0.5 && z.abs() < 0.5 {
            return None;
        }
        if body.velocity.y > 0.0 {
            highest = highest.max(y);
        }
    }
    Some(highest)
}

/// With the substeps of the budget alone some fall through. Where the cloth takes up no mass in the substep that it is struck in, or no more for
/// what is faster, it throws back what it has caught.
#[test]
fn what_falls_from_metres_up_is_caught() {
    let (mut fallen, mut thrown) = (Vec::new(), Vec::new());
    let (mut count, mut most) = (0, 0.0_f32);
    for (is_mesh, budget) in [(false, 8), (true, 8), (false, 20), (true, 20)] {
        for (height, rate) in [(1.0, 32.0), (2.0, 64.0), (5.0, 64.0)] {
            for (i, (shape, mass, inertia, half)) in shapes().into_iter().enumerate() {
                let place = Vec3::new(0.06 * i as f32 - 0.1, height + half + 0.02, 0.05);
                let body = Body { inertia, ..Body::ball(mass, place) };
                let scene = (is_mesh, budget, height, mass);
                count += 1;
                match rebound(hammock(is_mesh, budget), body, &*shape, rate) {
                    None => fallen.push(scene),
                    Some(rise) => {
                        most = most.max(rise / height);
                        if rise > 0.2 * height {
                            thrown.push((scene, rise));
                        }
                    }
                }
            }
        }
    }
    println!("{} of {count} fall through: {fallen:?}; rise by {most} of the fall", fallen.len());
    assert!(fallen.is_empty(), "mesh, budget, height [m], mass [kg]: {fallen:?}");
    assert!(thrown.is_empty(), "mesh, budget, height [m], mass [kg], rise [m]: {thrown:?}");
}

/// A cloth of 36 particles a side, and a ball above it which falls at a speed \[m/s\].
struct Falling {
    cloth: ClothSolver,
    pins: Vec<PinMotion>,
    ball: Body,
    pulls: Vec<PinPull>,
}

impl Falling {
    fn at(speed: f32, height: f32) -> Self {
        let (cloth, pins) = hammock(false, 8);
        let velocity = Vec3::NEG_Y * speed;
        let inertia = Vec3::splat(7e-4);
        let ball = Body { velocity, inertia, ..Body::ball(0.7, Vec3::Y * height) };
        Self { cloth, pins, ball, pulls: Vec::new() }
    }

    fn tick(&mut self) {
        let gravity = Vec3::NEG_Y * GRAVITY;
        let (pins, pulls) = (&self.pins, &self.pulls);
        let input = StepInput { dt: 1.0 / 60.0, gravity, pins, pulls, ..StepInput::default() };
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
    // Until it is caught, and has long come to rest in the cloth.
    let (mut ticks, mut slowest) = (0, f32::MAX);
    while falling.substeps()[0] >= 20 {
        falling.tick();
        ticks += 1;
        slowest = slowest.min(falling.ball.velocity.length());
    }
    println!("caught for {ticks} ticks, down to {slowest} m/s");
    assert!((15..60).contains(&ticks), "{ticks}");
    assert!(slowest < 1.5, "{slowest}");
    // What lies in the cloth asks for none.
    (0..300).for_each(|_| falling.tick());
    assert_eq!(falling.substeps(), [8, 0]);
    assert!(falling.ball.velocity.length() < 0.3, "{}", falling.ball.velocity);
    // What passes by does so as long as it is near.
    let mut passing = Falling::at(5.8, 0.2);
    passing.ball.place.x = -0.7;
    passing.ball.velocity = Vec3::X * 12.0;
    passing.tick();
    assert_eq!(passing.substeps(), [40, 40]);
    (0..12).for_each(|_| passing.tick());
    assert_eq!(passing.substeps(), [8, 0]);
}

#[test]
fn bodies_that_do_not_strike_a_held_cloth_ask_for_no_substeps() {
    let after_a_tick = |case: &str, mut falling: Falling| {
        falling.tick();
        assert_eq!(falling.substeps(), [8, 0], "{case}");
    };
    after_a_tick("slow", Falling::at(0.5, 0.065));
    after_a_tick("far away", Falling::at(6.0, 3.0));
    after_a_tick("leaves", Falling::at(-6.0, 0.2));
    let mut light = Falling::at(5.8, 0.2);
    light.ball.mass = 1e-4;
    after_a_tick("lighter than a particle", light);
    let mut free = Falling::at(5.8, 0.2);
    free.cloth.set_pins(&[]).unwrap();
    free.pins.clear();
    after_a_tick("nothing holds the cloth", free);
    let mut along = Falling::at(5.8, 0.2);
    for pin in &mut along.pins {
        pin.end = pin.start + Vec3::NEG_Y * 0.1;
    }
    after_a_tick("the cloth goes along", along);
    let mut pulls = Falling::at(5.8, 0.2);
    pulls.pulls.push(PinPull { pin: 0, body: 7 });
    after_a_tick("the cloth is held by a body", pulls);

    let mut fixed = Falling::at(5.8, 0.2);
    let settings = Settings { substeps: Substeps::Fixed(8), ..*fixed.cloth.settings() };
    fixed.cloth.set_settings(settings).unwrap();
    fixed.tick();
    assert_eq!(fixed.cloth.plan().substeps, 8);
}

/// Explicit springs would carry this stiffness with the substeps that the body asks for, and not with the cloth's own.
#[test]
fn a_strike_does_not_change_how_a_cloth_is_solved() {
    let mut soft = Falling::at(5.8, 0.2);
    let material = Material { thread_stiffness: 60.0, ..*soft.cloth.material() };
    soft.cloth.set_material(material).unwrap();
    let alone = *soft.cloth.plan();
    let PlanReason::SpringsNeed(needed) = alone.reason else { panic!("{alone}") };
    assert!((9..24).contains(&needed), "{needed}");
    soft.tick();
    let struck = soft.cloth.plan();
    assert_eq!((struck.bodies, struck.stretching), (24, alone.stretching));
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
