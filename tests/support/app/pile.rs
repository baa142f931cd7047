//! A pile of boxes of a physics engine under a cloth, which falls asleep and wakes.

use bevy::prelude::*;
use bevy_drape::prelude::*;

use super::{simulation, spawn, updates};

/// Length of a box's side, and mass of each \[m, kg\].
pub const SIDE: f32 = 0.2;
pub const MASS: f32 = 0.5;

const COUNT: usize = 20;

/// Boxes in five layers, and the cloth over them.
struct Pile<S> {
    boxes: Vec<Entity>,
    cloth: Entity,
    sleeps: S,
}

impl<S: Fn(&App, Entity) -> bool> Pile<S> {
    fn asleep(&self, app: &App) -> usize {
        self.boxes.iter().filter(|&&it| (self.sleeps)(app, it)).count()
    }

    fn is_asleep(&self, app: &App) -> bool {
        self.asleep(app) == COUNT && simulation(app, self.cloth).is_asleep()
    }

    /// Runs until all sleep: the boxes, and then the cloth, whose corners hang free and swing for longer.
    fn falls_asleep(&self, app: &mut App) {
        let (mut of_boxes, mut ticks) = (0, 0);
        while !self.is_asleep(app) && ticks < 40 * 64 {
            app.update();
            ticks += 1;
            of_boxes = if self.asleep(app) == COUNT { of_boxes } else { ticks };
        }
        let [of_boxes, of_all] = [of_boxes, ticks].map(|ticks| ticks as f32 / 64.0);
        println!("boxes asleep after {of_boxes} s, the cloth after {of_all} s");
        assert!(of_boxes < 5.0 && of_all < 8.0);
    }
}

/// Lets a pile fall asleep, wakes it by a ball that cloth alone meets, and lets it fall asleep again. The engine makes a ground whose top
/// is at a height of zero, boxes at places, and the ball at one.
pub fn sleeps_and_wakes(
    mut app: App,
    ground: impl FnOnce(&mut App),
    cube: impl Fn(&mut App, Vec3) -> Entity,
    ball: impl FnOnce(&mut App, Vec3) -> Entity,
    sleeps: impl Fn(&App, Entity) -> bool,
) {
    ground(&mut app);
    let place = |i: usize| {
        let (layer, at) = ((i / 4) as f32, i % 4);
        let side = |at: usize| at as f32 * 0.22 - 0.11;
        Vec3::new(side(at % 2), 0.101 + SIDE * layer, side(at / 2))
    };
    let boxes = (0..COUNT).map(|i| cube(&mut app, place(i))).collect();
    let cloth = Cloth::sheet(Vec2::splat(1.6), UVec2::splat(48));
    let cloth = spawn(&mut app, (cloth, Transform::from_xyz(0.0, 1.1, 0.0)));
    let pile = Pile { boxes, cloth, sleeps };
    pile.falls_asleep(&mut app);
    updates(&mut app, 64);
    assert!(pile.is_asleep(&app));
    // The cloth hands on that it is touched.
    let ball = ball(&mut app, Vec3::new(0.1, 1.3, 0.1));
    updates(&mut app, 32);
    let woken = (COUNT - pile.asleep(&app), !simulation(&app, cloth).is_asleep());
    println!("woken: {} boxes, cloth {}", woken.0, woken.1);
    assert!(woken.0 > 0 && woken.1);
    app.world_mut().despawn(ball);
    pile.falls_asleep(&mut app);
}
