//! Rigid bodies that cloths move, held to invariants: energy does not grow, momentum stays, what is carried comes to rest where the
//! cloth bears its weight.

use bevy::math::{
    DVec3, Mat3, Quat, Vec2, Vec3,
    primitives::{Cuboid, Sphere},
};
use bevy_drape::sdf::SignedDistance;
use bevy_drape::solver::{
    ClothSolver, Collider, Isa, Mobility, PinMotion, PinPull, Pose, PushOn, PushWith, Settings,
    SoftPin, StepInput, StretchMethod, Substeps, Topology,
};

use crate::support::{sheets::mesh, solver::*};

pub(crate) const GRAVITY: f32 = 9.81;
const RADIUS: f32 = 0.15;

/// A rigid body in an engine of the simplest kind: velocities, then places, once a tick.
#[derive(Clone, Copy)]
pub(crate) struct Body {
    pub mass: f32,
    /// Moments of inertia about the axes of its own frame.
    pub inertia: Vec3,
    pub place: Vec3,
    pub turn: Quat,
    pub velocity: Vec3,
    pub spin: Vec3,
    /// Whether it answers to the cloth within the tick, or only afterwards.
    pub is_in_substeps: bool,
}

impl Body {
    pub fn ball(mass: f32, place: Vec3) -> Self {
        Self {
            mass,
            inertia: Vec3::splat(0.4 * mass * RADIUS * RADIUS),
            place,
            turn: Quat::IDENTITY,
            velocity: Vec3::ZERO,
            spin: Vec3::ZERO,
            is_in_substeps: true,
        }
    }

    fn pose(&self) -> Pose {
        Pose { translation: self.place, rotation: self.turn, scale: 1.0 }
    }

    /// One tick: the engine moves the body, then the cloth is stepped, then the engine is told.
    pub fn tick(&mut self, cloth: &mut ClothSolver, shape: &dyn SignedDistance, input: &StepInput) {
        let (from, dt) = (self.pose(), input.dt);
        self.velocity += input.gravity * dt;
        self.place += self.velocity * dt;
        self.turn_freely(dt);
        let collider = Collider::new(shape, from).moving_to(self.pose());
        let mobility = Mobility {
            inverse_mass: 1.0 / self.mass,
            inverse_inertia: self.in_world(self.inertia.recip()),
            informed: true,
        };
        let collider = match self.is_in_substeps {
            true => collider.moved_by(mobility, Vec3::ZERO),
            false => collider.measured(),
        };
        let mut colliders = vec![Collider { key: 1, ..collider }];
        colliders.extend_from_slice(input.colliders);
        cloth.tick(&StepInput { colliders: &colliders, ..*input }).unwrap();
        let given = match self.is_in_substeps {
            true => cloth.body_impulse(0),
            false => cloth.impulse(0),
        };
        self.velocity += given.linear / self.mass;
        self.spin += self.in_world(self.inertia.recip()) * given.angular;
    }

    /// Its velocities, less what it was given ahead of time.
    fn own(&self, cloth: &ClothSolver) -> (Vec3, Vec3) {
        let ahead = cloth.expected_impulse(1);
        let spin = self.spin - self.in_world(self.inertia.recip()) * ahead.angular;
        (self.velocity - ahead.linear / self.mass, spin)
    }

    /// A tensor that has these values about its axes, in world axes.
    fn in_world(&self, principal: Vec3) -> Mat3 {
        let axes = Mat3::from_quat(self.turn);
        axes * Mat3::from_diagonal(principal) * axes.transpose()
    }

    /// Turns it, and keeps its angular momentum. What turns about all axes alike keeps its spin.
    fn turn_freely(&mut self, dt: f32) {
        const PARTS: u32 = 32;
        if self.inertia.x == self.inertia.y && self.inertia.y == self.inertia.z {
            self.turn = (Quat::from_scaled_axis(self.spin * dt) * self.turn).normalize();
            return;
        }
        let momentum = self.in_world(self.inertia) * self.spin;
        let step = dt / PARTS as f32;
        for _ in 0..PARTS {
            let before = self.turn;
            for part in [0.5, 1.0] {
                self.turn =
                    (Quat::from_scaled_axis(self.spin * (part * step)) * before).normalize();
                self.spin = self.in_world(self.inertia.recip()) * momentum;
            }
        }
    }
}

/// A metre of cloth of 0.2 kg held at its four corners, and where its pins are.
fn hammock() -> (ClothSolver, Vec<PinMotion>) {
    hung_by_corners(sheet(Vec2::ONE, 32, 32, Settings::default().lumping).into(), 32, Vec3::ZERO)
}

/// The same of an irregular mesh.
fn mesh_hammock() -> (ClothSolver, Vec<PinMotion>) {
    hung_by_corners(mesh(32, 32, 1.0 / 31.0, 0.3).into(), 32, Vec3::new(-0.5, 0.0, -0.5))
}

pub(crate) fn hung_by_corners(
    topology: Topology,
    side: u32,
    by: Vec3,
) -> (ClothSolver, Vec<PinMotion>) {
    let rest: Vec<_> = topology.rest_positions().iter().map(|&p| p + by).collect();
    let material = bevy_drape::solver::Material { area_density: 0.2, ..Default::default() };
    let mut solver = ClothSolver::new(topology, &rest, material, Settings::default()).unwrap();
    solver.set_pins(&[0, side - 1, side * (side - 1), side * side - 1]).unwrap();
    let pin = |&pin: &u32| PinMotion { start: rest[pin as usize], end: rest[pin as usize] };
    let pins = solver.pins().iter().map(pin).collect();
    (solver, pins)
}

/// Kinetic energy and height of cloth and body \[J\].
fn energy(cloth: &ClothSolver, body: &Body) -> f32 {
    let (velocity, spin) = body.own(cloth);
    let count = cloth.topology().particle_count();
    let of_cloth = (0..count).map(|i| {
        // Held ones weigh as much as they would free.
        let mass = 0.2 / count as f32;
        mass * (0.5 * cloth.velocity(i).length_squared() + GRAVITY * cloth.position(i).y)
    });
    of_cloth.sum::<f32>()
        + body.mass * (0.5 * velocity.length_squared() + GRAVITY * body.place.y)
        + 0.5 * spin.dot(body.in_world(body.inertia) * spin)
}

/// What a ball that is dropped onto a hammock does.
struct Dropped {
    /// Heights of its centre in the tenth second \[m\].
    low: f32,
    high: f32,
    /// By how much the energy was above what it was at first at most, of what the drop of the ball sets free.
    gain: f32,
    bits: Vec<[u32; 3]>,
}

fn drop_onto_hammock(mass: f32, is_in_substeps: bool, isa: Isa, rate: f32) -> Dropped {
    let (mut cloth, pins) = hammock();
    cloth.set_isa(isa);
    let gravity = Vec3::NEG_Y * GRAVITY;
    let input = StepInput { dt: 1.0 / rate, gravity, pins: &pins, ..StepInput::default() };
    let mut ball = Body { is_in_substeps, ..Body::ball(mass, Vec3::Y * (0.35 + RADIUS + 0.005)) };
    let shape = Sphere::new(RADIUS);
    let at_first = energy(&cloth, &ball);
    let mut dropped = Dropped { low: f32::MAX, high: f32::MIN, gain: 0.0, bits: Vec::new() };
    for tick in 0..(10.0 * rate) as u32 {
        ball.tick(&mut cloth, &shape, &input);
        let gain = (energy(&cloth, &ball) - at_first) / (mass * GRAVITY * 0.35);
        dropped.gain = dropped.gain.max(gain);
        if tick as f32 >= 9.0 * rate || ball.place.y < -5.0 {
            dropped.low = dropped.low.min(ball.place.y);
            dropped.high = dropped.high.max(ball.place.y);
        }
        dropped.bits.push(ball.place.to_array().map(f32::to_bits));
    }
    dropped
}

#[test]
fn a_hammock_carries_balls_of_any_mass() {
    for mass in [0.05, 0.2, 1.0, 3.0, 10.0] {
        let Dropped { low, high, gain, .. } = drop_onto_hammock(mass, true, Isa::detect(), 64.0);
        let amplitude = 0.5 * (high - low);
        println!("{mass} kg: amplitude {amplitude} m, gain {gain}");
        assert!(amplitude < 5e-3, "{mass} kg swings by {amplitude} m");
        assert!(gain < 0.01, "{mass} kg: energy grew by {gain}");
        // It hangs below the pins, and not at the end of what the cloth gives.
        assert!((-0.35..0.05).contains(&low), "{mass} kg is at {low} m");
    }
}

/// What is asked of springs to make up for what threads leave follows a body's swing late, and gives it energy.
#[test]
fn meshes_of_few_substeps_carry_them_as_well() {
    for substeps in [8, 20] {
        for mass in [0.05, 0.2, 1.0] {
            let (mut cloth, pins) = mesh_hammock();
            let substeps = Substeps::Fixed(substeps);
            cloth.set_settings(Settings { substeps, ..*cloth.settings() }).unwrap();
            let gravity = Vec3::NEG_Y * GRAVITY;
            let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
            let mut ball = Body::ball(mass, Vec3::Y * (RADIUS + 0.006));
            let (mut low, mut high) = (f32::MAX, f32::MIN);
            for tick in 0..1920 {
                ball.tick(&mut cloth, &Sphere::new(RADIUS), &input);
                if tick >= 1856 {
                    (low, high) = (low.min(ball.place.y), high.max(ball.place.y));
                }
            }
            let what = format!("{mass} kg, {substeps:?}: swings by [m]");
            check_at_most(&what, f64::from(0.5 * (high - low)), 5e-3);
            assert!((-0.2..0.06).contains(&low), "{mass} kg is at {low} m");
        }
    }
}

#[test]
fn slow_ticks_carry_them_too() {
    for mass in [0.05, 1.0, 10.0] {
        let Dropped { low, high, gain, .. } = drop_onto_hammock(mass, true, Isa::detect(), 30.0);
        assert!(high - low < 1e-2 && gain < 0.01, "{mass} kg: {low} to {high} m, gain {gain}");
    }
}

#[test]
fn a_ball_that_is_told_afterwards_is_thrown() {
    // What bodies in the substeps are for.
    let Dropped { low, gain, .. } = drop_onto_hammock(1.0, false, Isa::detect(), 64.0);
    assert!(gain > 0.5 || low < -4.0, "it is carried as well: {low} m, gain {gain}");
}

/// Where a ball comes to rest that is laid on a hammock.
fn rests_at(mass: f32, substeps: u32, stretch_method: StretchMethod) -> f32 {
    let substeps = Substeps::Fixed(substeps);
    let (mut cloth, pins) = hammock();
    cloth.set_settings(Settings { substeps, stretch_method, ..Settings::default() }).unwrap();
    let calm = bevy_drape::solver::Material { drag: 2.0, ..*cloth.material() };
    cloth.set_material(calm).unwrap();
    let gravity = Vec3::NEG_Y * GRAVITY;
    let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
    let mut ball = Body::ball(mass, Vec3::Y * (RADIUS + 0.006));
    let mut mean = 0.0;
    for tick in 0..384 {
        ball.tick(&mut cloth, &Sphere::new(RADIUS), &input);
        mean += if tick >= 320 { ball.place.y / 64.0 } else { 0.0 };
    }
    mean
}

/// Truth: explicit springs of many substeps. With 800, of a cloth that moves as it weighs, 10 kg rest within a millimetre of it. If cloth
/// always moved as it weighs, balls of 3 and 10 kg would hang 3 and 10 cm too low.
#[test]
fn balls_rest_where_springs_of_many_substeps_bear_them() {
    let of_few = [(0.05, 5e-3), (0.2, 8e-3), (1.0, 1.6e-2), (3.0, 2.3e-2), (10.0, 4.5e-2)];
    for (mass, within) in of_few {
        let many = rests_at(mass, 200, StretchMethod::ExplicitSprings);
        let Dropped { low, high, .. } = drop_onto_hammock(mass, true, Isa::detect(), 64.0);
        let (dropped, few) =
            (0.5 * (low + high), rests_at(mass, 8, StretchMethod::ImplicitThreads));
        println!("{mass} kg: {many} m with many substeps, {dropped} with 20, {few} with 8");
        assert!((dropped - many).abs() < 5e-3, "{mass} kg: {dropped} for {many}");
        assert!((few - many).abs() < within, "{mass} kg, 8: {few} for {many}");
    }
}

/// The weight of a cloth is not scaled under a body: a ball that is no body, and is moved down on a set way, is borne alike.
#[test]
fn a_ball_that_is_held_where_one_rests_is_borne_by_its_weight() {
    let rests = rests_at(3.0, 20, StretchMethod::ImplicitThreads);
    let borne = |height: f32| {
        let (mut cloth, pins) = hammock();
        let stretch_method = StretchMethod::ExplicitSprings;
        let substeps = Substeps::Fixed(200);
        cloth.set_settings(Settings { substeps, stretch_method, ..Settings::default() }).unwrap();
        let calm = bevy_drape::solver::Material { drag: 2.0, ..*cloth.material() };
        cloth.set_material(calm).unwrap();
        let shape = Sphere::new(RADIUS);
        let at = |tick: i32| height + (0.4 - 0.004 * tick as f32).max(0.0);
        let gravity = Vec3::NEG_Y * GRAVITY;
        let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
        let mut force = 0.0;
        for tick in 0..320 {
            let pose = |tick| Pose::from_translation(Vec3::Y * at(tick));
            let ball = Collider::new(&shape, pose(tick)).moving_to(pose(tick + 1)).measured();
            cloth.tick(&StepInput { colliders: &[ball], ..input }).unwrap();
            force += if tick >= 256 { cloth.impulse(0).linear.y } else { 0.0 };
        }
        force / GRAVITY
    };
    let [least, most] = [5e-3, -5e-3].map(|by| borne(rests + by));
    println!("3 kg rest at {rests} m: the cloth bears {least} to {most} kg");
    assert!(least < 3.0 && 3.0 < most, "3 kg: {least} to {most}");
}

/// A cloth that is put elsewhere moves as it weighs at once, though it bore ten kilograms in the last tick.
#[test]
fn a_cloth_that_is_put_back_is_light_at_once() {
    let (mut cloth, pins, _) = loaded_hammock(10.0);
    let (mut fresh, _) = hammock();
    let rest: Vec<_> = (0..32 * 32).map(|i| fresh.position(i)).collect();
    cloth.place(&rest).unwrap();
    let gravity = Vec3::NEG_Y * GRAVITY;
    let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
    for _ in 0..4 {
        cloth.tick(&input).unwrap();
        fresh.tick(&input).unwrap();
    }
    let middle = 16 * 32 + 16;
    check("fall [m/s]", cloth.velocity(middle).y.into(), fresh.velocity(middle).y.into(), 1e-4);
}

/// A hammock under a ball that lies on it still.
fn loaded_hammock(mass: f32) -> (ClothSolver, Vec<PinMotion>, Body) {
    let (mut cloth, pins) = hammock();
    let gravity = Vec3::NEG_Y * GRAVITY;
    let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
    let mut ball = Body::ball(mass, Vec3::Y * (RADIUS + 0.006));
    for _ in 0..320 {
        ball.tick(&mut cloth, &Sphere::new(RADIUS), &input);
    }
    (cloth, pins, ball)
}

/// Under a heavy body a cloth moves as if it had a part of its mass. It falls as it weighs once nothing holds it.
#[test]
fn cloth_and_body_fall_as_they_weigh_once_they_are_let_go() {
    let (mut cloth, _, mut ball) = loaded_hammock(10.0);
    cloth.set_pins(&[]).unwrap();
    let material = bevy_drape::solver::Material { drag: 0.0, ..*cloth.material() };
    cloth.set_material(material).unwrap();
    let input =
        StepInput { dt: 1.0 / 64.0, gravity: Vec3::NEG_Y * GRAVITY, ..StepInput::default() };
    let fall = |cloth: &ClothSolver| {
        let of = |i| f64::from(cloth.mass(i)) * f64::from(cloth.velocity(i).y);
        (0..cloth.topology().particle_count()).map(of).sum::<f64>()
    };
    for _ in 0..16 {
        ball.tick(&mut cloth, &Sphere::new(RADIUS), &input);
    }
    let all = momentum(&cloth, &ball).0.y / f64::from(0.2 + ball.mass);
    check("fall of cloth and ball [m/s]", all, -f64::from(GRAVITY) * 0.25, 0.03);
    // The ball goes on elsewhere.
    let before = fall(&cloth);
    for _ in 0..16 {
        cloth.tick(&input).unwrap();
    }
    let alone = (fall(&cloth) - before) / 0.2;
    check("fall of the cloth in a quarter of a second [m/s]", alone, -2.4525, 0.01);
}

/// A cloth that has carried a body moves as it weighs when that has gone.
#[test]
fn cloth_is_light_again_when_a_body_has_gone() {
    let (mut cloth, pins, _) = loaded_hammock(10.0);
    let gravity = Vec3::NEG_Y * GRAVITY;
    let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
    // What an impulse on all of it does to a particle in the middle.
    let answer = |cloth: &ClothSolver| {
        let mut pushed = cloth.clone();
        pushed.push(PushOn::All, PushWith::Impulse(Vec3::Y * 0.02)).unwrap();
        let middle = 16 * 32 + 16;
        pushed.velocity(middle).y - cloth.velocity(middle).y
    };
    let loaded = answer(&cloth);
    for _ in 0..192 {
        cloth.tick(&input).unwrap();
    }
    check("velocity under a load [m/s]", f64::from(loaded), 0.1 / 26.0, 1e-4);
    check("velocity later [m/s]", f64::from(answer(&cloth)), 0.1, 1e-4);
}

/// A hammock that is carried along holds a ball as one that stands: mass that it takes up goes with its pins, and the ball does not begin to
/// spin as it is borne on its way.
#[test]
fn a_moving_hammock_carries_a_ball_as_a_standing_one_does() {
    let drop = |along: Vec3| {
        let (mut cloth, mut pins) = hammock();
        let material = bevy_drape::solver::Material { drag: 0.0, ..*cloth.material() };
        cloth.set_material(material).unwrap();
        for i in 0..cloth.topology().particle_count() {
            cloth.set_velocity(i, along).unwrap();
        }
        let (mut low, mut high) = (f32::MAX, f32::MIN);
        let mut ball = Body::ball(3.0, Vec3::Y * (0.1 + RADIUS));
        ball.velocity = along;
        for tick in 0..96 {
            for pin in &mut pins {
                (pin.start, pin.end) = (pin.end, pin.end + along / 64.0);
            }
            let gravity = Vec3::NEG_Y * GRAVITY;
            let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
            ball.tick(&mut cloth, &Sphere::new(RADIUS), &input);
            low = low.min(ball.place.y);
            high = if tick > 24 { high.max(ball.place.y) } else { high };
        }
        let aside = ball.place.x - along.x * 1.5;
        [low, high, aside]
    };
    let (still, carried) = (drop(Vec3::ZERO), drop(Vec3::X * 8.0));
    println!("{still:?} standing, {carried:?} carried along");
    for (still, carried) in still.into_iter().zip(carried) {
        assert!((still - carried).abs() < 5e-3, "{still} m standing, {carried} m carried along");
    }
}

/// A ball lies on a cloth that lies on a cart, as it does where the cart stands: the engine has its weight act where a tick begins, and so does what
/// bears it.
#[test]
fn a_ball_on_a_cloth_on_a_moving_cart_does_not_roll() {
    let along = Vec3::X;
    let topology = sheet(Vec2::ONE, 32, 32, Settings::default().lumping);
    let places: Vec<_> = topology.rest_positions().iter().map(|&p| p + Vec3::Y * 6e-3).collect();
    let material = bevy_drape::solver::Material { area_density: 0.2, ..Default::default() };
    let mut cloth = ClothSolver::new(topology, &places, material, Settings::default()).unwrap();
    for i in 0..places.len() {
        cloth.set_velocity(i, along).unwrap();
    }
    let (cart, shape) = (Cuboid::new(2.0, 0.2, 2.0), Sphere::new(RADIUS));
    let gravity = Vec3::NEG_Y * GRAVITY;
    let mut ball = Body::ball(1.0, Vec3::Y * (RADIUS + 0.012));
    ball.velocity = along;
    for tick in 0..192_u8 {
        let at = |tick| Pose::from_translation(along * (tick / 64.0) - Vec3::Y * 0.1);
        let tick = f32::from(tick);
        let cart = Collider { key: 2, ..Collider::new(&cart, at(tick)).moving_to(at(tick + 1.0)) };
        let (others, dt) = ([cart], 1.0 / 64.0);
        let input = StepInput { dt, gravity, colliders: &others, ..StepInput::default() };
        ball.tick(&mut cloth, &shape, &input);
    }
    check("the ball's way on the cart [m]", (ball.place - along * 3.0).x.into(), 0.0, 0.01);
}

/// At the size that a game has, ten kilograms bounce off by no more than half of the way that they fell. Did the cloth not slow down as it takes
/// up mass, they would by two thirds.
#[test]
fn a_fine_hammock_takes_the_energy_of_a_heavy_ball() {
    let topology = sheet(Vec2::ONE, 64, 64, Settings::default().lumping);
    let (mut cloth, pins) = hung_by_corners(topology.into(), 64, Vec3::ZERO);
    let gravity = Vec3::NEG_Y * GRAVITY;
    let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
    let mut ball = Body::ball(10.0, Vec3::Y * (0.35 + RADIUS + 0.005));
    let mut top = f32::MIN;
    for tick in 0..192 {
        ball.tick(&mut cloth, &Sphere::new(RADIUS), &input);
        top = if tick > 24 { top.max(ball.place.y) } else { top };
    }
    check_at_most("top of a bounce [m]", f64::from(top), 0.25);
}

/// A ton stretches the cloth far before it is found to be borne. Were the cloth then to move as if it had a part of that mass, it would
/// contract, and throw the ton up by a metre.
#[test]
fn a_ton_is_not_thrown_up() {
    let (mut cloth, pins) = hammock();
    let gravity = Vec3::NEG_Y * GRAVITY;
    let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
    let mut ball = Body::ball(1000.0, Vec3::Y * (RADIUS + 0.006));
    let mut top = f32::MIN;
    for tick in 0..128 {
        ball.tick(&mut cloth, &Sphere::new(RADIUS), &input);
        top = if tick > 32 { top.max(ball.place.y) } else { top };
    }
    check_at_most("top after half a second [m]", f64::from(top), f64::from(RADIUS));
}

/// A save brings with it what the cloth carries, and the mass that it moves as if it had for that.
#[test]
fn a_loaded_hammock_goes_on_to_the_bit_when_it_is_restored() {
    let (mut cloth, pins, mut ball) = loaded_hammock(3.0);
    let (mut other, _) = hammock();
    other.restore(&cloth.save()).unwrap();
    let mut others = ball;
    let gravity = Vec3::NEG_Y * GRAVITY;
    let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
    for _ in 0..64 {
        ball.tick(&mut cloth, &Sphere::new(RADIUS), &input);
        others.tick(&mut other, &Sphere::new(RADIUS), &input);
    }
    assert!(bits(&other) == bits(&cloth));
}

#[test]
fn the_bits_are_those_of_every_instruction_set() {
    let expected = drop_onto_hammock(1.0, true, Isa::detect(), 64.0).bits;
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        assert_eq!(drop_onto_hammock(1.0, true, isa, 64.0).bits, expected, "{isa:?}");
    }
}

/// Linear and angular momentum, and kinetic energy, of cloth and body.
fn momentum(cloth: &ClothSolver, body: &Body) -> (DVec3, DVec3, f64) {
    let (velocity, spin) = body.own(cloth);
    let (velocity, spin) = (velocity.as_dvec3(), spin.as_dvec3());
    let (mass, inertia) = (f64::from(body.mass), f64::from(body.inertia.x));
    let mut linear = velocity * mass;
    let mut angular = body.place.as_dvec3().cross(linear) + spin * inertia;
    let mut energy = 0.5 * (mass * velocity.length_squared() + inertia * spin.length_squared());
    for i in 0..cloth.topology().particle_count() {
        let (mass, velocity) = (f64::from(cloth.mass(i)), cloth.velocity(i).as_dvec3());
        linear += velocity * mass;
        angular += cloth.position(i).as_dvec3().cross(velocity * mass);
        energy += 0.5 * mass * velocity.length_squared();
    }
    (linear, angular, energy)
}

/// Parts of its linear and angular momentum that a sheet at 5 m/s and a free box, so many times as heavy, lose while they meet.
fn lost_to_a_free_box(ratio: f32, along: Vec3, aside: f32) -> [f64; 2] {
    const SIDE: f32 = 0.3;
    let lattice = sheet(Vec2::ONE, 48, 48, Settings::default().lumping);
    let place = |&p: &Vec3| p + Vec3::X * aside;
    let places: Vec<_> = lattice.rest_positions().iter().map(place).collect();
    let material =
        bevy_drape::solver::Material { area_density: 0.2, drag: 0.0, ..Default::default() };
    let mut cloth = ClothSolver::new(lattice, &places, material, Settings::default()).unwrap();
    for i in 0..places.len() {
        cloth.set_velocity(i, Vec3::NEG_Y * 5.0 + along).unwrap();
    }
    let mass = 0.2 * ratio;
    let inertia = Vec3::splat(mass / 6.0 * SIDE * SIDE);
    let mut body = Body { inertia, ..Body::ball(mass, Vec3::NEG_Y * 0.3) };
    let before = momentum(&cloth, &body);
    let shape = Cuboid::from_length(SIDE);
    let input = StepInput { dt: 1.0 / 64.0, ..StepInput::default() };
    for _ in 0..64 {
        body.tick(&mut cloth, &shape, &input);
        let energy = momentum(&cloth, &body).2;
        assert!(energy < before.2 * 1.001, "ratio {ratio}: {energy} of {} J", before.2);
    }
    // It was hit at all.
    assert!(body.velocity.y < -0.02, "{}", body.velocity);
    let after = momentum(&cloth, &body);
    let size = before.0.length();
    let linear = (after.0 - before.0).length() / size;
    let angular = (after.1 - before.1).length() / (size * f64::from(SIDE));
    println!("ratio {ratio}, {along} {aside}: {linear:.1e} {angular:.1e}");
    [linear, angular]
}

#[test]
fn a_sheet_that_hits_a_free_box_keeps_momentum() {
    // As it is, from the side, and beside the middle: by how much differs from place to place.
    let about = [-0.006, -0.003, 0.0, 0.003, 0.006];
    let beside = [0.15, 0.2, 0.25, 0.3, 0.35];
    let ways = [(Vec3::ZERO, about), (Vec3::X * 3.0, about), (Vec3::ZERO, beside)];
    for (along, asides) in ways {
        for ratio in [0.1, 0.3, 1.0, 10.0, 100.0] {
            let mut mean = 0.0;
            for aside in asides {
                let [linear, angular] = lost_to_a_free_box(ratio, along, aside);
                assert!(linear < 2e-4, "ratio {ratio}: linear momentum changes by {linear}");
                assert!(angular < 2e-3, "ratio {ratio}: angular momentum changes by {angular}");
                mean += angular / 5.0;
            }
            println!("ratio {ratio}, {along}: {mean:.1e} in the mean");
            assert!(mean < 1.2e-3, "ratio {ratio}, {along}: {mean} in the mean");
        }
    }
}

#[test]
fn colliders_of_one_body_move_as_one() {
    // A ball as two halves of its weight that are one body, at the same place.
    let run = |bodies: &[u64]| {
        let (mut cloth, pins) = hammock();
        let gravity = Vec3::NEG_Y * GRAVITY;
        let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
        let (shape, mut ball) = (Sphere::new(RADIUS), Body::ball(1.0, Vec3::Y * 0.2));
        for _ in 0..192 {
            let from = ball.pose();
            ball.velocity += gravity / 64.0;
            ball.place += ball.velocity / 64.0;
            let mobility = Mobility {
                inverse_mass: 1.0,
                inverse_inertia: Mat3::from_diagonal(ball.inertia.recip()),
                informed: true,
            };
            let part = |(key, &body): (u64, &u64)| {
                let part = Collider::new(&shape, from).moving_to(ball.pose());
                Collider { key, body, ..part }.moved_by(mobility, Vec3::ZERO)
            };
            let parts: Vec<_> = (1..).zip(bodies).map(part).collect();
            cloth.tick(&StepInput { colliders: &parts, ..input }).unwrap();
            for i in 0..bodies.len() {
                ball.velocity += cloth.body_impulse(i).linear;
            }
        }
        ball.place
    };
    let (one, of_one) = (run(&[7]), run(&[7, 7]));
    assert!(one.distance(of_one) < 2e-3, "{one} and {of_one}");
    assert!(one.y < 0.0 && one.y > -0.2, "{one}");
}

#[test]
fn a_body_without_contact_costs_no_bit() {
    let run = |moved: bool| {
        let (mut cloth, pins) = hammock();
        let gravity = Vec3::NEG_Y * GRAVITY;
        let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
        let (shape, pose) = (Sphere::new(RADIUS), Pose::from_translation(Vec3::Y));
        for _ in 0..32 {
            let ball = Collider::new(&shape, pose);
            let mobility =
                Mobility { inverse_mass: 1.0, inverse_inertia: Mat3::IDENTITY, informed: true };
            let ball = if moved { ball.moved_by(mobility, Vec3::ZERO) } else { ball };
            cloth.tick(&StepInput { colliders: &[ball], ..input }).unwrap();
        }
        bits(&cloth)
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn masses_that_cannot_be_used_are_refused() {
    let good = Mobility { inverse_mass: 1.0, inverse_inertia: Mat3::IDENTITY, informed: true };
    let (mut cloth, pins) = hammock();
    let shape = Sphere::new(RADIUS);
    let mut refuses = |mobility, center| {
        let ball = Collider::new(&shape, Pose::IDENTITY).moved_by(mobility, center);
        let colliders = [ball];
        let input = StepInput {
            dt: 1.0 / 64.0,
            pins: &pins,
            colliders: &colliders,
            ..StepInput::default()
        };
        cloth.tick(&input).is_err()
    };
    for inverse_mass in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(refuses(Mobility { inverse_mass, ..good }, Vec3::ZERO), "{inverse_mass}");
    }
    for inertia in [-1.0, f32::NAN, f32::INFINITY] {
        let inverse_inertia = Mat3::from_diagonal(Vec3::new(1.0, inertia, 1.0));
        assert!(refuses(Mobility { inverse_inertia, ..good }, Vec3::ZERO), "{inertia}");
    }
    assert!(refuses(good, Vec3::NAN));
    assert!(!refuses(good, Vec3::ZERO));
    let immovable = Mobility { inverse_mass: 0.0, inverse_inertia: Mat3::ZERO, ..good };
    assert!(!refuses(immovable, Vec3::ZERO));
}

#[test]
fn what_strikes_or_weighs_nothing_makes_no_energy() {
    let gravity = Vec3::NEG_Y * GRAVITY;
    // A ball thrown into a hammock from below, and a feather.
    let cases: [(f32, Vec3, Vec3); 3] = [
        (0.05, Vec3::Y * -0.6, Vec3::Y * 20.0),
        (5.0, Vec3::Y * -0.6, Vec3::Y * 20.0),
        (1e-5, Vec3::Y * 0.2, Vec3::ZERO),
    ];
    for (mass, place, velocity) in cases {
        let (mut cloth, pins) = hammock();
        let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
        let mut ball = Body { velocity, ..Body::ball(mass, place) };
        let shape = Sphere::new(RADIUS);
        let at_first = energy(&cloth, &ball);
        let mut most = at_first;
        for _ in 0..192 {
            ball.tick(&mut cloth, &shape, &input);
            most = most.max(energy(&cloth, &ball));
        }
        println!("{mass} kg from {place}: {at_first} to {most} J, ends at {}", ball.place);
        assert!(most < at_first + 1e-3, "{mass} kg from {place}: {at_first} to {most} J");
        assert!(cloth.strain().max < 0.2, "{mass} kg from {place}: {}", cloth.strain().max);
    }
}

/// Bodies so small that only edges and faces hold them, on cells of 17 cm. They yield to an edge as far as the edge yields to them. Were they
/// to stand still while edges are solved, light ones would be thrown off; were they given what edges turn by, those that roll would
/// roll ever faster, and gain 18 J.
#[test]
fn bodies_smaller_than_a_cell_rest_in_it() {
    const SIDE: f32 = 0.06;
    const COUNT: u32 = 7;
    let (cube, ball) = (Cuboid::from_length(SIDE), Sphere::new(0.5 * SIDE));
    let shapes: [(&str, &dyn SignedDistance, f32); 2] =
        [("cube", &cube, 6.0), ("ball", &ball, 10.0)];
    for (name, shape, part) in shapes {
        for mass in [0.003, 0.01, 0.1, 1.0, 10.0] {
            for draw in 0..4 {
                let place = Vec3::new(0.083 + 0.01 * draw as f32, 0.05, 0.083);
                let inertia = Vec3::splat(mass / part * SIDE * SIDE);
                let turn = Quat::from_rotation_y(0.3 * draw as f32);
                let body = Body { inertia, turn, ..Body::ball(mass, place) };
                let OnCoarseCloth { end, gained, rose } = rests_on_coarse_cloth(body, shape, COUNT);
                assert!(gained < 1e-3, "{name} of {mass} kg gains {gained} J");
                // The cloth has 0.2 J to give as it sinks: a light body alone would go high with that.
                assert!(rose < 0.02, "{name} of {mass} kg is thrown up by {rose} m");
                assert!(end.place.y > -0.6, "{name} of {mass} kg falls through to {}", end.place);
            }
        }
    }
}

/// Ten seconds of a body on a metre of cloth of so many particles a side.
struct OnCoarseCloth {
    end: Body,
    /// By how much the energy of both was ever above its start \[J\].
    gained: f32,
    /// How far the body ever rose above where it began \[m\].
    rose: f32,
}

fn rests_on_coarse_cloth(mut body: Body, shape: &dyn SignedDistance, count: u32) -> OnCoarseCloth {
    let side = count as usize;
    let lattice = sheet(Vec2::ONE, side, side, Settings::default().lumping);
    let (mut cloth, pins) = hung_by_corners(lattice.into(), count, Vec3::ZERO);
    let gravity = Vec3::NEG_Y * GRAVITY;
    let input = StepInput { dt: 1.0 / 64.0, gravity, pins: &pins, ..StepInput::default() };
    let (at_first, height) = (energy(&cloth, &body), body.place.y);
    let (mut gained, mut rose) = (0.0_f32, 0.0_f32);
    for _ in 0..640 {
        body.tick(&mut cloth, shape, &input);
        gained = gained.max(energy(&cloth, &body) - at_first);
        rose = rose.max(body.place.y - height);
    }
    println!("{} kg: gains {gained} J, rises {rose} m, ends at {}", body.mass, body.place);
    OnCoarseCloth { end: body, gained, rose }
}

/// Light rods turn 35 times as easily about their length as across. Seen by the cloth as they are, most gain energy: up to some joules of spin,
/// beside the 10 mJ that they fall by.
#[test]
fn light_rods_are_not_spun_up() {
    for (length, density) in [(0.077, 1800.0), (0.137, 250.0), (0.06, 6000.0), (0.05, 12_000.0)] {
        let size = Vec3::new(1.0, 0.12, 0.12) * length;
        let mass = density * size.element_product();
        let squares = size * size;
        let inertia = (Vec3::splat(squares.element_sum()) - squares) * (mass / 12.0);
        for draw in 0..6 {
            let part = draw as f32;
            let place = Vec3::new(0.12 - 0.05 * part, 0.05, 0.2 - 0.07 * part);
            let turn = Quat::from_scaled_axis(Vec3::new(1.0 + part, 0.3, 2.0 - part));
            let body = Body { inertia, turn, ..Body::ball(mass, place) };
            let count = 7 + 3 * (draw % 3);
            let OnCoarseCloth { gained, rose, .. } =
                rests_on_coarse_cloth(body, &Cuboid::from_size(size), count);
            assert!(gained < 0.02, "a rod of {mass} kg gains {gained} J");
            assert!(rose < 0.05, "a rod of {mass} kg is thrown up by {rose} m");
        }
    }
}

/// A strap of 144 particles, and a ball that its lower end is pinned to, within it.
struct Strap {
    cloth: ClothSolver,
    ball: Body,
    places: Vec<Vec3>,
    /// How many of its upper particles are held where they are.
    held: u32,
    gravity: Vec3,
}

impl Strap {
    fn new(length: f32, held: u32, spring: Option<(f32, f32)>) -> Self {
        let lattice = sheet(Vec2::new(0.1, length), 36, 4, Settings::default().lumping);
        let place = |i: usize| {
            Vec3::new((i % 4) as f32 / 30.0 - 0.05, -((i / 4) as f32) / 35.0 * length, 0.0)
        };
        let places: Vec<_> = (0..144).map(place).collect();
        let material =
            bevy_drape::solver::Material { thread_stiffness: 2e4, drag: 0.0, ..Default::default() };
        let mut cloth = ClothSolver::new(lattice, &places, material, Settings::default()).unwrap();
        match spring {
            None => cloth.set_pins(&(0..held).chain(140..144).collect::<Vec<_>>()).unwrap(),
            Some((stiffness, damping)) => {
                cloth.set_pins(&(0..held).collect::<Vec<_>>()).unwrap();
                let soft = (140..144).map(|particle| SoftPin { particle, stiffness, damping });
                cloth.set_soft_pins(&soft.collect::<Vec<_>>()).unwrap();
            }
        }
        let ball = Body::ball(2.0, Vec3::Y * -1.21);
        Self { cloth, ball, places, held, gravity: Vec3::NEG_Y * GRAVITY }
    }

    fn tick(&mut self) {
        let Self { cloth, ball, places, held, gravity } = self;
        let local = |i: usize| places[i] - Vec3::Y * -1.21;
        let from = ball.pose();
        ball.velocity += *gravity / 64.0;
        ball.place += ball.velocity / 64.0;
        ball.turn = (Quat::from_scaled_axis(ball.spin / 64.0) * ball.turn).normalize();
        let to = ball.pose();
        let at = |pose: &Pose, i: usize| pose.translation + pose.rotation * local(i);
        let still = (0..*held as usize).map(|i| PinMotion::still(places[i]));
        let led = (140..144).map(|i| PinMotion { start: at(&from, i), end: at(&to, i) });
        let pins: Vec<_> = still.chain(led).collect();
        let pulls: Vec<_> = (*held..*held + 4).map(|pin| PinPull { pin, body: 7 }).collect();
        let mobility = Mobility {
            inverse_mass: 1.0 / ball.mass,
            inverse_inertia: Mat3::from_diagonal(ball.inertia.recip()),
            informed: true,
        };
        let shape = Sphere::new(RADIUS);
        let collider = Collider::new(&shape, from).moving_to(to);
        let collider = Collider { key: 1, body: 7, ..collider.moved_by(mobility, Vec3::ZERO) };
        let colliders = [collider];
        let input = StepInput {
            dt: 1.0 / 64.0,
            gravity: *gravity,
            pins: &pins,
            pulls: &pulls,
            colliders: &colliders,
            ..StepInput::default()
        };
        cloth.tick(&input).unwrap();
        let given = cloth.body_impulse(0);
        ball.velocity += given.linear / ball.mass;
        ball.spin += given.angular / ball.inertia.x;
    }
}

#[test]
fn a_body_hangs_in_a_strap_that_is_pinned_within_it() {
    // From its middle, which the strap passes through, and from its surface, where stiff springs would hold it in the ball; hard, or
    // on springs from loose to hardly any.
    for (length, spring) in [
        (1.2_f32, None),
        (1.06, None),
        (1.06, Some((500.0, 2.0))),
        (1.2, Some((500.0, 2.0))),
        (1.2, Some((2e3, 0.0))),
        (1.2, Some((2e3, 10.0))),
        (1.2, Some((500.0, 100.0))),
        (1.2, Some((1e5, 0.0))),
        (1.2, Some((1e5, 1e4))),
        (1.2, Some((1e9, 0.0))),
    ] {
        let mut strap = Strap::new(length, 4, spring);
        let at_first = strap.ball.place;
        let mut farthest = 0.0_f32;
        for _ in 0..640 {
            strap.tick();
            farthest = farthest.max(strap.ball.place.distance(at_first));
        }
        let Strap { cloth, ball, places, .. } = &strap;
        println!("{length} m, {spring:?}: {farthest} m, at the end {} m/s", ball.velocity);
        assert!(farthest < 0.05, "{length} m, {spring:?}: it went {farthest} m");
        assert!(ball.velocity.length() < 0.2, "{length} m, {spring:?}: {}", ball.velocity);
        // Springs give as Hooke says.
        let (stiffness, _) = spring.unwrap_or((f32::INFINITY, 0.0));
        let lower = |i: usize| {
            let place = ball.place + ball.turn * (places[i] - at_first);
            cloth.position(i).y - place.y
        };
        let gives = (140..144).map(lower).sum::<f32>() / 4.0;
        let expected = 2.0 * GRAVITY / (4.0 * stiffness);
        check(&format!("{spring:?}: gives [m]"), gives.into(), expected.into(), 1e-4);
    }
}

/// A ball that swings in a strap comes to rest. Were it expected to be pulled by half of how its pull changes, it would swing on for ever.
#[test]
fn a_body_that_hangs_from_pins_swings_out() {
    for speed in [0.7, 1.5, 2.5] {
        for length in [1.06, 1.2] {
            let mut strap = Strap::new(length, 4, None);
            let at_first = strap.ball.place.y;
            strap.ball.velocity = Vec3::Z * speed;
            let mut highest = [0.0_f32; 10];
            for tick in 0..1280 {
                strap.tick();
                let above = strap.ball.place.y - at_first;
                highest[tick / 128] = highest[tick / 128].max(above);
            }
            println!("{speed} m/s, {length} m: {highest:?}");
            let push = speed * speed / (2.0 * GRAVITY);
            assert!(highest[9] < 0.5 * push, "{speed} m/s, {length} m: {highest:?}");
        }
    }
}

/// Nothing else is there: what the springs take from the cloth the ball has.
#[test]
fn springs_to_a_body_keep_its_momentum() {
    for spring in [(50.0, 0.0), (500.0, 2.0), (1e5, 10.0), (1e9, 0.0)] {
        let mut strap = Strap { gravity: Vec3::ZERO, ..Strap::new(1.06, 0, Some(spring)) };
        let thrown = Vec3::new(3.0, 2.0, 1.0);
        for i in 0..144 {
            strap.cloth.set_velocity(i, thrown).unwrap();
        }
        let momentum = |strap: &Strap| {
            let (velocity, _) = strap.ball.own(&strap.cloth);
            momenta(&strap.cloth).0 + (velocity * strap.ball.mass).as_dvec3()
        };
        let at_first = momentum(&strap);
        let mut off = 0.0_f64;
        for _ in 0..128 {
            strap.tick();
            off = off.max(momentum(&strap).distance(at_first) / at_first.length());
        }
        let own = strap.ball.own(&strap.cloth).0;
        println!("{spring:?}: off by {off}, the ball goes {own}");
        check_at_most(&format!("{spring:?}: momentum"), off, 1e-4);
        assert!(own.length() > 0.01, "{spring:?}: it is not pulled");
    }
}
