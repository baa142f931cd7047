//! P14: cloths that fall onto each other, with and without inter-collision.

use std::{sync::Arc, time::Instant};

use bevy::math::{
    Quat, Vec2, Vec3,
    primitives::{InfinitePlane3d, Sphere},
};
use bevy_drape::solver::{
    ClothSolver, Collider, InterCollision, Island, Lattice, MassLumping, Material, Member, Pose,
    Settings, StepInput,
};

use super::super::run::{FRAME, GRAVITY};
use super::super::{Job, Measured, Outcome};

/// Frames of a run: 4 s.
const FRAMES: usize = 240;
/// Particles along a side.
const N: usize = 64;

/// Some cloths, and what they fall onto.
#[derive(Clone, Copy)]
enum Pile {
    /// Five sheets of some size \[m\], 10 mm apart, over a ball of a quarter of it.
    Five(f32),
    /// Ten sheets of 2 m, turned against each other, and a ball that dents them.
    Stack,
}

impl Pile {
    fn name(self) -> String {
        match self {
            Self::Five(side) => format!("five sheets of {side} m over a ball"),
            Self::Stack => "a stack of ten, and a ball".into(),
        }
    }

    fn cloths(self, collide: bool) -> Outcome<Vec<ClothSolver>> {
        let (side, count) = match self {
            Self::Five(side) => (side, 5),
            Self::Stack => (2.0, 10),
        };
        let sheet = Arc::new(Lattice::sheet(Vec2::splat(side), N, N, MassLumping::Lumped)?);
        let cloth = |layer: usize| {
            let layer = layer as f32;
            let (turn, up) = match self {
                Self::Five(side) => (0.0, 0.25 * side + 0.02 + 0.01 * layer),
                Self::Stack => (0.35 * layer, 0.03 + 0.1 * layer),
            };
            let place = |&p: &Vec3| Quat::from_rotation_y(turn) * p + Vec3::Y * up;
            let start: Vec<_> = sheet.rest_positions().iter().map(place).collect();
            let settings = Settings::default();
            let mut cloth = ClothSolver::new(sheet.clone(), &start, Material::USUAL, settings)?;
            cloth.set_shared(false);
            cloth.set_inter_collision(collide.then(InterCollision::default))?;
            Ok(cloth)
        };
        (0..count).map(cloth).collect()
    }

    /// Its ball: radius, and height after some seconds.
    fn ball(self, time: f32) -> (f32, f32) {
        match self {
            Self::Five(side) => (0.25 * side, 0.0),
            Self::Stack => (0.3, (2.5 - (time - 1.5).max(0.0)).max(0.5)),
        }
    }

    fn ground(self) -> f32 {
        match self {
            Self::Five(side) => -0.25 * side,
            Self::Stack => 0.0,
        }
    }

    fn run(self, collide: bool) -> Outcome<Measured> {
        let mut cloths = self.cloths(collide)?;
        let (ball, ground) = (Sphere::new(self.ball(0.0).0), InfinitePlane3d::new(Vec3::Y));
        let up = |height: f32| Pose { translation: Vec3::Y * height, ..Pose::IDENTITY };
        let mut island = Island::default();
        let (mut times, mut worst, mut peak, mut p99) = (Vec::new(), 0, 0.0_f32, 0.0_f32);
        for frame in 0..FRAMES {
            let [from, to] = [frame, frame + 1].map(|frame| up(self.ball(frame as f32 * FRAME).1));
            let colliders = [
                Collider::new(&ball, from).moving_to(to),
                Collider::new(&ground, up(self.ground())),
            ];
            let (dt, gravity) = (FRAME, GRAVITY);
            let input = StepInput { dt, gravity, colliders: &colliders, ..StepInput::default() };
            let begun = Instant::now();
            if collide {
                let mut members: Vec<_> =
                    cloths.iter_mut().map(|cloth| Member::new(cloth, input)).collect();
                island.tick(&mut members);
                for member in members {
                    member.outcome.transpose()?;
                }
            } else {
                for cloth in &mut cloths {
                    cloth.tick(&input)?;
                }
            }
            times.push(begun.elapsed().as_secs_f64() * 1e3);
            for strain in cloths.iter().map(ClothSolver::strain) {
                (peak, p99) = (peak.max(strain.max), p99.max(strain.p99));
            }
            if frame % 4 == 3 {
                worst = worst.max(crossings(&cloths));
            }
        }
        let [p99, peak] = [p99, peak].map(|strain| f64::from(strain) * 100.0);
        let errors = vec![worst.into(), crossings(&cloths).into(), p99, peak];
        let each = |cloth: &ClothSolver| {
            cloth.topology().particle_count() * cloth.plan().substeps as usize
        };
        let work = cloths.iter().map(each).sum();
        Ok(Measured { frames: times, errors, work, allocations: f64::NAN, ..Measured::default() })
    }
}

/// Crossings of all cloths with each other.
fn crossings(cloths: &[ClothSolver]) -> u32 {
    let with = |place: usize| {
        cloths[..place].iter().map(move |other| other.crossings_with(&cloths[place]))
    };
    (0..cloths.len()).flat_map(with).sum()
}

/// The runs of all piles, with inter-collision and without.
pub fn jobs() -> impl Iterator<Item = Job<'static>> {
    let piles = [Pile::Five(0.64), Pile::Five(1.0), Pile::Five(2.0), Pile::Stack];
    piles.into_iter().flat_map(|pile| {
        [false, true].map(|collide| Job {
            method: pile.name(),
            n: N,
            knob: if collide { "inter-collision" } else { "off" }.into(),
            run: Box::new(move || pile.run(collide)),
        })
    })
}
