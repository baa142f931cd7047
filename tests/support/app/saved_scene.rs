//! A scene with all that has a state of its own, to be saved and loaded: cloths that fall onto a ball that
//! moves, held hard and softly by an anchor that moves, pushed, grabbed and blown at.

use super::*;
use bevy::{
    ecs::entity::{EntityHashMap, MapEntities},
    prelude::*,
};
use bevy_drape::{
    ClothForce, ClothForces, ClothGrab, ClothInertia, ClothSnapshot, SdfColliderSnapshot,
    prelude::*,
    solver::{PushOn, StretchMethod},
};

/// What is the cloth of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub mesh: bool,
    pub form: StretchMethod,
    pub busy: bool,
}

impl Case {
    pub const ALL: [Self; 6] = [
        Self { mesh: false, form: StretchMethod::ImplicitThreads, busy: true },
        Self { mesh: false, form: StretchMethod::ExplicitSprings, busy: true },
        Self { mesh: true, form: StretchMethod::ImplicitThreads, busy: true },
        Self { mesh: true, form: StretchMethod::ExplicitSprings, busy: true },
        Self { mesh: false, form: StretchMethod::ImplicitThreads, busy: false },
        Self { mesh: true, form: StretchMethod::ImplicitThreads, busy: false },
    ];
}

/// Ticks of the game, by which things move.
#[derive(Resource, Clone, Copy, Default)]
struct Clock(u32);

#[derive(Component)]
struct Moves(Vec3);

fn run_clock(mut clock: ResMut<Clock>) {
    clock.0 += 1;
}

fn move_things(mut things: Query<(&Moves, &mut Transform)>, clock: Res<Clock>) {
    for (way, mut transform) in &mut things {
        let swing = (clock.0 as f32 * 0.05).sin();
        transform.translation += way.0 * swing;
        transform.rotate_y(0.01 * swing);
    }
}

pub struct Scene {
    pub app: App,
    pub cloth: Entity,
    pub balls: [Entity; 2],
    pub anchor: Entity,
}

/// What is saved of it, with its entities.
pub struct Saved {
    clock: Clock,
    /// Of the anchor, the balls and the cloth.
    transforms: [Transform; 4],
    cloth: ClothSnapshot,
    balls: [SdfColliderSnapshot; 2],
    anchor: Entity,
}

impl Scene {
    /// A scene at its start, after so many other entities.
    pub fn new(case: Case, others: usize) -> Self {
        let mut app = app();
        app.init_resource::<Clock>()
            .insert_resource(ClothWind::steady(Vec3::new(2.0, 0.0, 1.0)))
            .add_systems(FixedUpdate, (run_clock, move_things).chain());
        for _ in 0..others {
            spawn(&mut app, Name::new("another"));
        }
        let anchor = spawn(&mut app, (Moves(Vec3::Y * 0.01), Transform::from_xyz(0.4, 0.5, 0.3)));
        let ball = |app: &mut App, place: Vec3| {
            let way = Moves(Vec3::new(0.006, 0.01, -0.004));
            let collider = SdfCollider::from(Sphere::new(0.25)).with_friction(0.7);
            spawn(app, (way, collider, Transform::from_translation(place)))
        };
        let balls = [Vec3::ZERO, Vec3::new(0.3, 0.02, 0.1)].map(|place| ball(&mut app, place));
        let place = Transform::from_xyz(0.0, 0.3, 0.0);
        let material = ClothMaterial { damping: 0.001, thread_stiffness: 300.0, ..default() };
        let settings = ClothSettings { stretch_method: case.form, ..default() };
        let cloth = spawn(&mut app, (material, settings, place));
        if case.mesh {
            let mesh = add_mesh(&mut app, holed_mesh());
            app.world_mut().entity_mut(cloth).insert((Cloth::of_mesh3d(), Mesh3d(mesh)));
        } else {
            app.world_mut().entity_mut(cloth).insert(sheet());
        }
        if case.busy {
            let pins = ClothPins::vertices([0])
                .and(ClothPins::vertices([7, 15]).anchored_to(anchor))
                .and(ClothPins::vertices([56, 57, 58]).anchored_to(anchor).softly(40.0, 0.2));
            let force = ClothForce { on: PushOn::Particle(40), force: Vec3::X * 0.02 };
            app.world_mut().entity_mut(cloth).insert((
                pins,
                ClothAir::default(),
                ClothForces::from(force),
                ClothInertia::new(0.4),
                Moves(Vec3::X * 0.02),
                ClothGrab { max_force: 0.3, ..ClothGrab::particle(63, Vec3::new(0.5, 0.8, 0.5)) },
            ));
        }
        Self { app, cloth, balls, anchor }
    }

    pub fn save(&self) -> Saved {
        let world = self.app.world();
        let state =
            |ball: Entity| SdfColliderSnapshot::of(world.entity(ball)).expect("it was seen");
        let entities = [self.anchor, self.balls[0], self.balls[1], self.cloth];
        Saved {
            clock: *world.resource::<Clock>(),
            transforms: entities.map(|it| *world.get::<Transform>(it).expect("it has one")),
            cloth: ClothSnapshot::of(world.entity(self.cloth)).expect("it runs"),
            balls: self.balls.map(state),
            anchor: self.anchor,
        }
    }

    /// Loads it into a scene at its start. `carry` does to states what writing and reading does.
    pub fn load(
        &mut self,
        saved: Saved,
        carry: impl Fn(ClothSnapshot) -> ClothSnapshot,
        carry_ball: impl Fn(SdfColliderSnapshot) -> SdfColliderSnapshot,
    ) {
        let mut state = carry(saved.cloth);
        let mut map = EntityHashMap::default();
        map.insert(saved.anchor, self.anchor);
        state.map_entities(&mut map);
        let world = self.app.world_mut();
        world.insert_resource(saved.clock);
        let entities = [self.anchor, self.balls[0], self.balls[1], self.cloth];
        for (entity, transform) in entities.into_iter().zip(saved.transforms) {
            world.entity_mut(entity).insert(transform);
        }
        for (entity, state) in self.balls.into_iter().zip(saved.balls) {
            world.entity_mut(entity).insert(carry_ball(state));
        }
        world.entity_mut(self.cloth).insert(state);
    }

    pub fn bits(&self) -> Vec<[u32; 3]> {
        bits(&self.app, self.cloth)
    }
}

/// Saves a scene in mid-fall, loads it into another game, and holds both to the same bits from there on.
pub fn goes_on(
    case: Case,
    ticks: usize,
    carry: impl Fn(ClothSnapshot) -> ClothSnapshot,
    carry_ball: impl Fn(SdfColliderSnapshot) -> SdfColliderSnapshot,
) {
    let mut one = Scene::new(case, 0);
    updates(&mut one.app, ticks);
    let mut other = Scene::new(case, 5);
    other.load(one.save(), carry, carry_ball);
    assert_ne!(one.anchor, other.anchor, "entities are others");
    let contacts = |scene: &Scene| {
        let tick = simulation(&scene.app, scene.cloth).last_tick();
        tick.map_or(0, |tick| tick.contact_count)
    };
    let mut touched = 0;
    for tick in 0..60 {
        one.app.update();
        other.app.update();
        assert_eq!(one.bits(), other.bits(), "{case:?}, {tick} ticks after {ticks}");
        touched += contacts(&one);
    }
    assert!(touched > 0, "{case:?}: it touches the balls");
    let count = |scene: &Scene| simulation(&scene.app, scene.cloth).tick_count();
    assert_eq!(count(&one), count(&other));
    assert_eq!((failure(&one.app, one.cloth), failure(&other.app, other.cloth)), (None, None));
}
