//! Particles, edges and faces that are too far away are passed over, which changes no bit.

use bevy::math::{
    Quat, Vec2, Vec3,
    bounding::Aabb3d,
    primitives::{Cone, Cuboid, Cylinder},
};
use bevy_drape::sdf::{SdfSample, SignedDistance, shapes::Rounded};
use bevy_drape::solver::{ClothSolver, Collider, Material, Pose, Settings, StepInput, Topology};

use crate::support::{sheets::mesh, solver::*};

const SIDE: usize = 20;
const TICKS: i32 = 90;

/// A solid whose distances are of no use to pass anything over, and of which nothing else is known.
#[derive(Debug)]
struct Near<S>(S);

impl<S: SignedDistance> SignedDistance for Near<S> {
    fn sample(&self, point: Vec3) -> SdfSample {
        self.0.sample(point)
    }

    fn bounds(&self) -> Option<Aabb3d> {
        self.0.bounds()
    }

    fn core_depth(&self) -> f32 {
        self.0.core_depth()
    }

    fn least_radius(&self) -> f32 {
        self.0.least_radius()
    }

    fn overestimate(&self) -> f32 {
        1e3
    }
}

/// The bits at the end, and how many particles touch, of a metre of cloth that falls on a solid which rocks.
fn falls_on(solid: &dyn SignedDistance, is_mesh: bool) -> (Vec<[u32; 6]>, u32) {
    let (topology, by): (Topology, _) = match is_mesh {
        true => (mesh(SIDE, SIDE, 1.0 / 19.0, 0.3).into(), Vec3::new(-0.5, 0.0, -0.5)),
        false => (sheet(Vec2::ONE, SIDE, SIDE, Settings::default().lumping).into(), Vec3::ZERO),
    };
    let mut cloth: ClothSolver =
        at_rest(&topology, by + Vec3::Y * 0.01, Material::default(), Settings::default());
    let pose = |tick: i32| Pose {
        translation: Vec3::new(0.02, -0.22, 0.01),
        rotation: Quat::from_rotation_x(0.003 * ((tick % 20 - 10) as f32).abs()),
        scale: 1.0,
    };
    let mut touching = 0;
    for tick in 0..TICKS {
        let colliders = [Collider::new(solid, pose(tick)).moving_to(pose(tick + 1))];
        let input =
            StepInput { dt: TICK, gravity: GRAVITY, colliders: &colliders, ..StepInput::default() };
        touching = cloth.tick(&input).unwrap().contact_count;
    }
    (bits(&cloth), touching)
}

fn check_same<S: SignedDistance + Clone>(solid: &S) {
    for is_mesh in [false, true] {
        let (passed_over, touching) = falls_on(solid, is_mesh);
        let (looked_at, _) = falls_on(&Near(solid.clone()), is_mesh);
        assert!(touching > 0, "{solid:?}: nothing touches it");
        assert!(passed_over == looked_at, "{solid:?}, mesh {is_mesh}");
    }
}

#[test]
fn what_is_passed_over_changes_no_bit() {
    check_same(&Cone::new(0.3, 0.4));
    check_same(&Cuboid::new(0.4, 0.4, 0.3));
    check_same(&Cylinder::new(0.2, 0.4));
    check_same(&Rounded::new(Cuboid::new(0.3, 0.38, 0.25), 0.01));
}
