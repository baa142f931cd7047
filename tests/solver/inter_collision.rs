//! Cloths that collide with each other, stepped together as an island.
//!
//! Truths: no edge of a cloth pierces a face of another; the limit of strain; momentum is kept; layers slide as Coulomb's law says;
//! bit equality; nobody is disturbed by what another member does wrong. Where layers are held apart, they pass through each other
//! without the feature.

use std::sync::Arc;

use bevy::math::{
    DVec3, Quat, Vec2, Vec3,
    primitives::{InfinitePlane3d, Sphere},
};
use bevy_drape::solver::{
    ClothSolver, Collider, Graph, InterCollision, Isa, Island, MassLumping, Material, Member,
    PinMotion, Pose, SelfCollision, Settings, SolverError, StepInput, Substeps, Topology,
};

use crate::support::{bits::bits, dice::Dice, solver::*};

/// Cloths, and how they are to be stepped.
struct Scene {
    cloths: Vec<ClothSolver>,
    island: Island,
    gravity: Vec3,
    /// A ball, at a place and with a radius.
    ball: Option<(fn(f32) -> Vec3, f32)>,
    ground: f32,
    time: f32,
}

impl Scene {
    fn of(cloths: Vec<ClothSolver>) -> Self {
        let island = Island::default();
        Self { cloths, island, gravity: GRAVITY, ball: None, ground: -1e3, time: 0.0 }
    }

    /// Lets all of them collide with each other.
    fn meeting(mut self, how: InterCollision) -> Self {
        for cloth in &mut self.cloths {
            cloth.set_inter_collision(Some(how)).unwrap();
        }
        self
    }

    /// Takes ticks, and gives the worst number of crossings of every fourth.
    fn run(&mut self, ticks: usize) -> f64 {
        let mut worst = 0;
        for tick in 0..ticks {
            self.tick();
            if tick % 4 == 3 {
                worst = worst.max(self.crossings());
            }
        }
        worst.into()
    }

    fn tick(&mut self) {
        let (from, to) = (self.time, self.time + TICK);
        let (ground, ball) =
            (InfinitePlane3d::default(), Sphere::new(self.ball.map_or(1.0, |ball| ball.1)));
        let at = |translation: Vec3| Pose { translation, ..Pose::IDENTITY };
        let mut colliders = vec![Collider::new(&ground, at(Vec3::Y * self.ground))];
        if let Some((place, _)) = self.ball {
            colliders.push(Collider::new(&ball, at(place(from))).moving_to(at(place(to))));
        }
        let gravity = self.gravity;
        let input = StepInput { dt: TICK, gravity, colliders: &colliders, ..StepInput::default() };
        let mut members: Vec<_> =
            self.cloths.iter_mut().map(|cloth| Member::new(cloth, input)).collect();
        self.island.tick(&mut members);
        for member in members {
            member.outcome.unwrap().unwrap();
        }
        self.time = to;
    }

    fn crossings(&self) -> u32 {
        let all = &self.cloths;
        let with = |place: usize| all[..place].iter().map(move |it| it.crossings_with(&all[place]));
        (0..all.len()).flat_map(with).sum()
    }

    /// The largest strain, and the fastest particle [m/s].
    fn extremes(&self) -> [f64; 2] {
        self.cloths.iter().fold([0.0, 0.0], |[strain, speed], cloth| {
            [strain.max(cloth.strain().max.into()), speed.max(fastest(cloth))]
        })
    }

    fn bits(&self) -> Vec<Vec<[u32; 6]>> {
        self.cloths.iter().map(bits).collect()
    }
}

fn cloth(topology: &Topology, place: impl Fn(Vec3) -> Vec3) -> ClothSolver {
    let places: Vec<_> = topology.rest_positions().iter().map(|&p| place(p)).collect();
    let mut solver =
        ClothSolver::new(topology.clone(), &places, usual(), Settings::default()).unwrap();
    solver.set_shared(false);
    solver
}

fn square(side: f32, n: usize) -> Topology {
    sheet(Vec2::splat(side), n, n, MassLumping::Lumped).into()
}

fn mesh(side: f32, n: usize) -> Topology {
    let spacing = side / (n - 1) as f32;
    let (positions, triangles) = jittered(n, n, spacing, 0.0, 7);
    let shift = Vec3::new(0.5 * side, 0.0, 0.5 * side);
    let centred: Vec<_> = positions.iter().map(|&p| p - shift).collect();
    Topology::from(Arc::new(Graph::new(&centred, &triangles, MassLumping::Lumped).unwrap()))
}

/// Sheets, 10 mm apart, that fall over a ball onto the ground.
fn over_a_ball(count: usize, n: usize) -> Scene {
    let side = 0.64;
    let sheets = (0..count)
        .map(|k| cloth(&square(side, n), |p| p + Vec3::Y * (0.18 + 0.01 * k as f32)))
        .collect();
    Scene { ball: Some((|_| Vec3::ZERO, 0.16)), ground: -0.16, ..Scene::of(sheets) }
}

/// Sheets that fall onto each other, turned, and are dented by a ball.
fn stack(count: usize, n: usize) -> Scene {
    let sheets = (0..count)
        .map(|k| {
            let turn = Quat::from_rotation_y(0.35 * k as f32);
            cloth(&square(1.0, n), |p| turn * p + Vec3::Y * (0.03 + 0.05 * k as f32))
        })
        .collect();
    let ball = |time: f32| Vec3::Y * (1.2 - (time - 0.3).max(0.0)).max(0.15 + 0.1);
    Scene { ball: Some((ball, 0.15)), ground: 0.0, ..Scene::of(sheets) }
}

#[test]
fn sheets_over_a_ball_do_not_pass_through_each_other() {
    let without = over_a_ball(3, 64).run(60);
    assert!(without > 1000.0, "{without} crossings without it");
    let mut scene = over_a_ball(5, 64).meeting(InterCollision::default());
    check_at_most("crossings", scene.run(28), 0.0);
    // The lowest one's corners are drawn into the wedge between the ball and the ground, which holds them by chance at up to 15 %.
    scene.cloths.remove(0);
    check_at_most("largest strain of the others", scene.extremes()[0], 0.12);
}

#[test]
fn a_stack_that_a_ball_dents_stays_a_stack() {
    let mut scene = stack(4, 48).meeting(InterCollision::default());
    check_at_most("crossings", scene.run(110), 0.0);
    check_at_most("largest strain", scene.extremes()[0], 0.12);
    let heights: Vec<_> = scene.cloths.iter().map(|cloth| cloth.position(0).y).collect();
    assert!(heights.is_sorted(), "{heights:?}");
}

#[test]
fn sheets_meshes_and_other_spacings_hold_each_other() {
    for (what, upper, lower) in [
        ("mesh on sheet", mesh(0.6, 36), square(0.6, 36)),
        ("sheet on mesh", square(0.6, 36), mesh(0.6, 36)),
        ("fine on coarse", square(0.4, 48), square(0.6, 24)),
        ("coarse on fine", square(0.5, 16), square(0.6, 40)),
        ("very fine on very coarse", square(0.3, 60), square(0.6, 13)),
    ] {
        let cloths = vec![
            cloth(&lower, |p| p + Vec3::Y * 0.18),
            cloth(&upper, |p| Quat::from_rotation_y(0.4) * p + Vec3::Y * 0.24),
        ];
        let ball: (fn(f32) -> Vec3, f32) = (|_| Vec3::ZERO, 0.16);
        let scene = Scene { ball: Some(ball), ground: -0.16, ..Scene::of(cloths) };
        check_at_most(what, scene.meeting(InterCollision::default()).run(80), 0.0);
    }
}

#[test]
fn only_cloths_that_share_a_layer_collide() {
    let touching = |layers: [u32; 2]| {
        let mut scene = over_a_ball(2, 24);
        for (cloth, layers) in scene.cloths.iter_mut().zip(layers) {
            let how = InterCollision { layers, ..InterCollision::default() };
            cloth.set_inter_collision(Some(how)).unwrap();
        }
        scene.run(40);
        scene.island.touched().count()
    };
    assert_eq!([touching([1, 2]), touching([1, 3])], [0, 1]);
}

/// Cloths in an island that meet none are as they would be alone, but for the substeps of the others.
#[test]
fn who_meets_nobody_has_the_bits_of_one_that_is_alone() {
    let fixed = Settings { substeps: Substeps::Fixed(16), ..Settings::default() };
    let make = |x: f32| {
        let mut cloth = cloth(&square(1.0, 24), |p| p + Vec3::new(x, 0.0, 0.0));
        cloth.set_settings(fixed).unwrap();
        cloth.set_pins(&[0, 23]).unwrap();
        cloth
    };
    let mut alone = make(0.0);
    let mut cloths = [make(0.0), make(5.0)];
    for cloth in &mut cloths {
        cloth.set_inter_collision(Some(InterCollision::default())).unwrap();
    }
    let pins = |cloth: &ClothSolver| -> Vec<_> {
        cloth.pins().iter().map(|&pin| PinMotion::still(cloth.position(pin as usize))).collect()
    };
    let mut island = Island::default();
    for _ in 0..40 {
        let input = StepInput { dt: TICK, gravity: GRAVITY, ..StepInput::default() };
        alone.tick(&StepInput { pins: &pins(&alone), ..input }).unwrap();
        let held = cloths.each_ref().map(pins);
        let mut members: Vec<_> = cloths
            .iter_mut()
            .zip(&held)
            .map(|(cloth, pins)| Member::new(cloth, StepInput { pins, ..input }))
            .collect();
        island.tick(&mut members);
    }
    assert!(bits(&alone) == bits(&cloths[0]));
}

fn substeps(scene: &Scene) -> Vec<u32> {
    scene.cloths.iter().map(|cloth| cloth.plan().substeps).collect()
}

#[test]
fn all_members_take_the_substeps_of_the_one_with_most() {
    let mut scene = over_a_ball(2, 24).meeting(InterCollision::default());
    let fixed = Settings { substeps: Substeps::Fixed(33), ..Settings::default() };
    scene.cloths[1].set_settings(fixed).unwrap();
    scene.tick();
    assert_eq!(substeps(&scene), [33, 33]);
    // Alone again, each has its own.
    let input = StepInput { dt: TICK, gravity: GRAVITY, ..StepInput::default() };
    for cloth in &mut scene.cloths {
        cloth.tick(&input).unwrap();
    }
    assert_eq!(substeps(&scene), [19, 33]);
}

/// Two sheets in the air that fly at each other.
#[test]
fn cloths_that_meet_in_the_air_keep_their_momentum() {
    let light = Material { drag: 0.0, ..usual() };
    let heavy = Material { area_density: 3.0 * light.area_density, ..light };
    let mut scene = Scene::of(vec![
        cloth(&square(0.5, 32), |p| p),
        cloth(&square(0.4, 32), |p| Quat::from_rotation_x(0.3) * p + Vec3::new(0.1, 0.2, 0.0)),
    ])
    .meeting(InterCollision::default());
    scene.gravity = Vec3::ZERO;
    for (cloth, material) in scene.cloths.iter_mut().zip([light, heavy]) {
        cloth.set_material(material).unwrap();
    }
    for particle in 0..32 * 32 {
        scene.cloths[1].set_velocity(particle, Vec3::new(0.3, -2.0, 0.0)).unwrap();
    }
    let momentum = |scene: &Scene| scene.cloths.iter().map(|cloth| momenta(cloth).0).sum::<DVec3>();
    let before = momentum(&scene);
    let lower = momenta(&scene.cloths[0]).0.length();
    check_at_most("crossings", scene.run(120), 0.0);
    let after = momentum(&scene);
    let given = momenta(&scene.cloths[0]).0.length();
    assert!(given > lower + 0.05 * before.length(), "the lower one was given {given}");
    check_at_most("drift of momentum, of m v", (after - before).length() / before.length(), 1e-4);
}

/// A smaller cloth on a held one, which is tilted.
#[test]
fn layers_slide_at_the_angle_of_friction() {
    let angle = 0.5_f32.atan().to_degrees();
    let slid = |degrees: f32| {
        let spacing = 1.0 / 47.0;
        let lower = cloth(&square(1.0, 48), |p| p);
        let upper = cloth(&square(0.5, 24), |p| {
            Quat::from_rotation_y(0.3) * p + Vec3::new(0.1, 0.9, 0.2) * spacing
        });
        let mut cloths = [lower, upper];
        for cloth in &mut cloths {
            cloth.set_material(Material { drag: 0.0, ..usual() }).unwrap();
            cloth.set_inter_collision(Some(InterCollision::default())).unwrap();
        }
        let all: Vec<u32> = (0..48 * 48).collect();
        cloths[0].set_pins(&all).unwrap();
        let pins: Vec<_> =
            all.iter().map(|&pin| PinMotion::still(cloths[0].position(pin as usize))).collect();
        let (sin, cos) = degrees.to_radians().sin_cos();
        let gravity = Vec3::new(9.81 * sin, -9.81 * cos, 0.0);
        let mut island = Island::default();
        let mut at = [0.0; 2];
        for tick in 0..60 {
            let input = StepInput { dt: TICK, gravity, ..StepInput::default() };
            let [lower, upper] = &mut cloths;
            let mut members =
                [Member::new(lower, StepInput { pins: &pins, ..input }), Member::new(upper, input)];
            island.tick(&mut members);
            at[usize::from(tick > 30)] = cloths[1].position(12 * 24 + 12).x;
        }
        at[1] - at[0]
    };
    let [holds, slides] = [slid(angle - 0.5), slid(angle + 0.5)];
    check_at_most("below the angle [m]", holds.abs().into(), 1e-3);
    assert!(slides > 0.01, "above the angle it slides by {slides} m");
}

/// What lies on a cloth that friction holds to the ground stays there. Higher layers creep by a tenth of a millimetre a second if pushes
/// without speed move what friction holds to the ground; by a millimetre, if friction forgets in each tick what has slid; by a centimetre
/// and more, if it does in each substep.
#[test]
fn a_pile_on_a_slope_stays() {
    for (count, most) in [(2, 1e-6), (4, 1e-5), (12, 5e-5)] {
        let layer = |layer: usize| {
            let (turn, up) = (0.25 + 0.45 * layer as f32, 0.03 + 0.02 * layer as f32);
            let place = move |p: Vec3| Quat::from_rotation_y(turn) * p + Vec3::Y * up;
            let mut cloth = cloth(&square(0.7, 32), place);
            cloth.set_material(Material { friction: 0.9, ..usual() }).unwrap();
            cloth
        };
        let how = InterCollision { friction: 0.9, ..InterCollision::default() };
        let mut scene = Scene::of((0..count).map(layer).collect()).meeting(how);
        scene.ground = 0.0;
        scene.run(60);
        let slope = 15.0_f32.to_radians();
        scene.gravity = Vec3::new(slope.sin(), -slope.cos(), 0.0) * 9.81;
        scene.run(60);
        let places = |scene: &Scene| -> Vec<DVec3> { scene.cloths.iter().map(centre).collect() };
        let before = places(&scene);
        scene.run(60);
        for (layer, (now, before)) in places(&scene).into_iter().zip(before).enumerate() {
            check_at_most(&format!("{layer} of {count}: crept by [m]"), now.distance(before), most);
        }
    }
}

/// Two sheets that lie on each other, on a slope down to `x`, for a second.
fn lying_on_a_slope() -> Scene {
    let layer = |layer: usize| {
        let turn = Quat::from_rotation_y(0.3 * layer as f32);
        let up = Vec3::Y * (0.005 + 0.02 * layer as f32);
        let mut cloth = cloth(&square(0.7, 32), |p| turn * p + up);
        cloth.set_material(Material { friction: 0.9, ..usual() }).unwrap();
        cloth
    };
    let how = InterCollision { friction: 0.9, ..InterCollision::default() };
    let mut scene = Scene::of((0..2).map(layer).collect()).meeting(how);
    scene.ground = 0.0;
    let slope = 15.0_f32.to_radians();
    scene.gravity = Vec3::new(slope.sin(), -slope.cos(), 0.0) * 9.81;
    scene.run(60);
    scene
}

/// Checks that no particle moves in half a second.
fn check_lies_still(what: &str, scene: &mut Scene) {
    let places = |scene: &Scene| -> Vec<Vec3> {
        let all = |it: &ClothSolver| {
            (0..it.topology().particle_count()).map(|p| it.position(p)).collect()
        };
        scene.cloths.iter().flat_map(|it| -> Vec<Vec3> { all(it) }).collect()
    };
    let before = places(scene);
    scene.run(30);
    let moved = places(scene).into_iter().zip(before).map(|(now, before)| now.distance(before));
    check_at_most(&format!("{what}: has moved [m]"), moved.fold(0.0, f32::max).into(), 2e-5);
}

/// They ride on, as on a boat that turns: what holds them turns with them.
#[test]
fn a_pile_that_is_turned_stays() {
    let mut scene = lying_on_a_slope();
    let turn = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    let there = Pose { rotation: turn, ..Pose::IDENTITY };
    for cloth in &mut scene.cloths {
        cloth.carry(&Pose::IDENTITY, &there).unwrap();
    }
    scene.gravity = turn * scene.gravity;
    check_lies_still("turned", &mut scene);
}

#[test]
fn a_pile_whose_members_change_their_order_stays() {
    let mut scene = lying_on_a_slope();
    scene.cloths.reverse();
    check_lies_still("in the other order", &mut scene);
}

/// A cloth that has parted from another is held no longer where it lay: by its way, as it is put elsewhere at once, or as it goes on alone
/// for a while.
#[test]
fn what_was_lifted_and_put_down_beside_its_place_stays_there() {
    let mut scene = lying_on_a_slope();
    let gravity = core::mem::take(&mut scene.gravity);
    // As far as pairs are looked for, but do not touch.
    for way in [Vec3::new(0.0, 1e-3, 0.0), Vec3::new(0.0, 0.0, 2e-3)] {
        let there = Pose { translation: way, ..Pose::IDENTITY };
        scene.cloths[1].carry(&Pose::IDENTITY, &there).unwrap();
        scene.run(1);
    }
    scene.gravity = gravity;
    check_stays("lifted", &mut scene);

    let mut scene = lying_on_a_slope();
    let upper = &mut scene.cloths[1];
    let beside = |p: usize| upper.position(p) + Vec3::Z * 2e-3;
    let beside: Vec<_> = (0..upper.topology().particle_count()).map(beside).collect();
    upper.place(&beside).unwrap();
    check_stays("put elsewhere", &mut scene);

    let mut scene = lying_on_a_slope();
    let there = Pose { translation: Vec3::Z * 2e-3, ..Pose::IDENTITY };
    scene.cloths[1].carry(&Pose::IDENTITY, &there).unwrap();
    let input = StepInput { dt: TICK, ..StepInput::default() };
    scene.island.tick(&mut [Member::new(&mut scene.cloths[1], input)]);
    check_stays("alone for a tick", &mut scene);
}

/// Checks that the upper sheet does not slide back by `z`.
fn check_stays(what: &str, scene: &mut Scene) {
    let before = centre(&scene.cloths[1]);
    scene.run(30);
    let back = before.z - centre(&scene.cloths[1]).z;
    check_at_most(&format!("{what}: has slid back [m]"), back, 1e-4);
}

#[test]
fn bits_depend_on_neither_instructions_nor_origin_nor_restart() {
    let run = |isa: Isa, restarts: bool| {
        let mut scene = over_a_ball(2, 32).meeting(InterCollision::default());
        for cloth in &mut scene.cloths {
            cloth.set_isa(isa);
            cloth.set_self_collision(Some(SelfCollision::default())).unwrap();
        }
        scene.run(20);
        assert!(scene.island.touched().count() > 0);
        if restarts {
            let mut anew = over_a_ball(2, 32).meeting(InterCollision::default());
            for (cloth, was) in anew.cloths.iter_mut().zip(&scene.cloths) {
                cloth.set_self_collision(Some(SelfCollision::default())).unwrap();
                cloth.restore(&was.save()).unwrap();
            }
            anew.time = scene.time;
            scene = anew;
        }
        scene.run(20);
        scene.bits()
    };
    let truth = run(Isa::Baseline, false);
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        assert!(run(isa, false) == truth, "{isa:?}");
    }
    assert!(run(Isa::detect(), true) == truth, "after a restart");
}

/// Far from the world's origin, and with origins of their own.
#[test]
fn cloths_of_other_origins_meet_where_they_are() {
    let mut scene = Scene::of(
        [7.0, 9.0]
            .map(|x| {
                // One is centred on either side of where origins change.
                cloth(&square(1.0, 24), |p| p + Vec3::new(x, 0.05 * (x - 7.0), 0.0))
            })
            .into(),
    )
    .meeting(InterCollision::default());
    let shift = Pose { translation: Vec3::new(-1.5, 0.0, 0.0), ..Pose::IDENTITY };
    scene.cloths[1].carry(&Pose::IDENTITY, &shift).unwrap();
    scene.ground = -0.01;
    assert_ne!(scene.cloths[0].origin(), scene.cloths[1].origin());
    check_at_most("crossings", scene.run(60), 0.0);
    assert_eq!(scene.island.touched().count(), 1);
    let over = scene.cloths[1].bounds().1.y - scene.cloths[0].bounds().1.y;
    assert!(over > 0.5 / 23.0, "the upper one lies {over} m above the lower one");
}

#[test]
fn what_does_not_move_is_a_wall() {
    let wall = cloth(&square(1.0, 32), |p| p);
    let falls = cloth(&square(0.6, 32), |p| p + Vec3::Y * 0.1);
    let mut cloths = [wall, falls];
    for cloth in &mut cloths {
        cloth.set_inter_collision(Some(InterCollision::default())).unwrap();
    }
    // It would go on with this, if it took a tick.
    cloths[0].set_velocity(5, Vec3::X).unwrap();
    let state = bits(&cloths[0]);
    let mut island = Island::default();
    for _ in 0..60 {
        let input = StepInput { dt: TICK, gravity: GRAVITY, ..StepInput::default() };
        let [wall, falls] = &mut cloths;
        let mut members = [Member::still(wall), Member::new(falls, input)];
        island.tick(&mut members);
        assert!(members[0].outcome.is_none());
    }
    assert!(bits(&cloths[0]) == state);
    assert_eq!(cloths[0].crossings_with(&cloths[1]), 0);
    assert!(cloths[1].position(0).y > 0.01, "it lies on the wall");
    check_at_most("fastest [m/s]", fastest(&cloths[1]), 0.05);
}

#[test]
fn who_is_refused_or_diverges_disturbs_nobody() {
    let mut scene = over_a_ball(3, 24).meeting(InterCollision::default());
    scene.run(10);
    let input = StepInput { dt: TICK, gravity: GRAVITY, ..StepInput::default() };
    let before = scene.bits();
    {
        let mut members: Vec<_> =
            scene.cloths.iter_mut().map(|cloth| Member::new(cloth, input)).collect();
        members[0].input.gravity = Vec3::NAN;
        members[1].input.dt = 2.0 * TICK;
        scene.island.tick(&mut members);
        let outcomes: Vec<_> = members.iter().map(|member| member.outcome).collect();
        assert_eq!(outcomes[0], Some(Err(SolverError::Gravity)));
        assert!(matches!(outcomes[1], Some(Ok(_))) != matches!(outcomes[2], Some(Ok(_))));
        assert!(outcomes.contains(&Some(Err(SolverError::OtherTick))));
    }
    assert!(scene.bits()[0] == before[0], "who is refused stays where it is");
    // One that goes beyond all bounds is undone, and the others go on.
    let far = Material { drag: 0.0, ..usual() };
    scene.cloths[2].set_material(far).unwrap();
    let mut dice = Dice(5);
    for particle in 0..24 * 24 {
        scene.cloths[2].set_velocity(particle, dice.vector() * 9e6).unwrap();
    }
    let wild = Settings { max_speed: f32::INFINITY, ..Settings::default() };
    let wild = scene.cloths[2].set_settings(wild).is_ok();
    let mut members: Vec<_> =
        scene.cloths.iter_mut().map(|cloth| Member::new(cloth, input)).collect();
    scene.island.tick(&mut members);
    assert!(members[..2].iter().all(|member| matches!(member.outcome, Some(Ok(_)))));
    assert!(!wild || members[2].outcome == Some(Err(SolverError::Diverged)));
    drop(members);
    assert!(scene.cloths.iter().all(|cloth| positions(cloth).iter().all(|p| p.is_finite())));
    check_at_most("largest strain of the others", scene.cloths[1].strain().max.into(), 0.2);
}

/// A sheet that is through another when they begin to collide.
#[test]
fn cloths_that_start_within_each_other_stay_calm() {
    let cloths = vec![
        cloth(&square(1.0, 40), |p| p + Vec3::Y * 0.02),
        cloth(&square(0.6, 40), |p| Quat::from_rotation_x(0.4) * p + Vec3::Y * 0.03),
    ];
    let mut scene = Scene { ground: -0.1, ..Scene::of(cloths) }.meeting(InterCollision::default());
    let before = scene.crossings();
    assert!(before > 20, "{before}");
    scene.run(120);
    let [strain, speed] = scene.extremes();
    check_at_most("largest strain", strain, 0.15);
    check_at_most("fastest [m/s]", speed, 0.5);
    // What is through stays through where its weight holds it there, and does not spread.
    let after = scene.crossings();
    assert!(4 * after <= 5 * before, "{after} of {before}");
}

/// Pinned particles go where they are led, and push each other nowhere.
#[test]
fn held_particles_do_not_touch() {
    let mut cloths = [0.0, 0.01].map(|height| cloth(&square(1.0, 12), |p| p + Vec3::Y * height));
    let all: Vec<u32> = (0..12 * 12).collect();
    for cloth in &mut cloths {
        cloth.set_pins(&all).unwrap();
        cloth.set_inter_collision(Some(InterCollision::default())).unwrap();
    }
    let pins = cloths.each_ref().map(still);
    let before = cloths.each_ref().map(positions);
    let mut island = Island::default();
    let input = StepInput { dt: TICK, gravity: GRAVITY, ..StepInput::default() };
    let mut members: Vec<_> = cloths
        .iter_mut()
        .zip(&pins)
        .map(|(cloth, pins)| Member::new(cloth, StepInput { pins, ..input }))
        .collect();
    island.tick(&mut members);
    assert_eq!(island.touched().count(), 0);
    assert!(cloths.each_ref().map(positions) == before);
}

#[test]
fn bad_numbers_are_refused() {
    let mut cloth = cloth(&square(1.0, 11), |p| p);
    let good = InterCollision::default();
    for (name, bad) in [
        ("distance", InterCollision { distance: Some(0.11), ..good }),
        ("distance", InterCollision { distance: Some(f32::NAN), ..good }),
        ("distance", InterCollision { distance: Some(0.0), ..good }),
        ("friction", InterCollision { friction: -1.0, ..good }),
    ] {
        match cloth.set_inter_collision(Some(bad)) {
            Err(SolverError::Parameter(error)) => assert_eq!(error.name, name),
            other => panic!("{name}: {other:?}"),
        }
        assert_eq!(cloth.inter_collision(), None);
    }
    cloth.set_inter_collision(Some(InterCollision { distance: Some(0.09), ..good })).unwrap();
}
