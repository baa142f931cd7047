//! Where a distance field has no gradient: the centre of a ball, the medial plane of a box, the axis of a
//! ring; and solids that give what is no number. Truth: the cloth comes out within half a
//! second, and is not thrown.
//!
//! Normals there, and at places that are no numbers: `tests/sdf/shapes.rs`,
//! `normals_are_defined_everywhere`. Fields beyond their grid: `tests/sdf/fields.rs`. A saved field cannot
//! hold what is no number: `tests/sdf/saved.rs`.

use crate::support::{kinds::*, solver::*};
use bevy::math::{
    Quat, Vec3,
    bounding::Aabb3d,
    primitives::{Capsule3d, Cone, Cuboid, Cylinder, Sphere, Torus},
};
use bevy_drape::{
    sdf::{BakeSettings, DistanceField, SdfSample, SignedDistance},
    solver::{Collider, Pose, SolverError, StepInput},
};

const N: usize = 13;

/// A cube of eight corners, baked: its middle is a node of the grid.
fn baked_cube(half: f32) -> DistanceField {
    let corner = |i: u32| {
        let side = |bit: u32| if i & bit == 0 { -half } else { half };
        Vec3::new(side(1), side(2), side(4))
    };
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices: Vec<u32> = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    let positions: Vec<_> = (0..8).map(corner).collect();
    let settings = BakeSettings { cell_size: half / 4.0, margin: half / 2.0 };
    DistanceField::bake(&positions, &indices, &settings).unwrap()
}

/// Solids whose middle is in the middle of the cloth.
fn solids() -> Vec<(&'static str, Box<dyn SignedDistance>)> {
    vec![
        ("ball", Box::new(Sphere::new(0.3))),
        ("box", Box::new(Cuboid::new(0.6, 0.2, 0.6))),
        ("cube", Box::new(Cuboid::new(0.4, 0.4, 0.4))),
        ("large box", Box::new(Cuboid::new(3.0, 0.4, 3.0))),
        ("capsule", Box::new(Capsule3d::new(0.2, 0.4))),
        ("cylinder", Box::new(Cylinder::new(0.3, 0.2))),
        ("cone", Box::new(Cone::new(0.3, 0.5))),
        ("ring", Box::new(Torus { minor_radius: 0.1, major_radius: 0.3 })),
        ("field", Box::new(baked_cube(0.2))),
    ]
}

#[test]
fn h22_a_cloth_through_the_middle_of_a_solid_comes_out() {
    for mut kind in kinds(1.0, N) {
        // Edges keep what is inside for seconds: a limit that the README names.
        kind.settings.edges = false;
        for (name, solid) in solids() {
            let what = format!("{}, {name}", kind.what);
            let mut solver = kind.solver(Quat::IDENTITY, Vec3::ZERO);
            let pose = Pose::IDENTITY;
            let colliders = [Collider::new(&*solid, pose)];
            // What is let out at 2 m/s goes no further than 20 m in the time. The stiffest slips off what pierced it,
            // stretched to five times its length, and leaves at the speed of that.
            let stiffest = kind.what.contains("stiffest");
            let within = Within::cube(if stiffest { 60.0 } else { 25.0 });
            let (mut fast, mut inside) = (0.0_f64, 0);
            // As deep as a field may err.
            let deep = 1e-3 + solid.overestimate();
            for _ in 0..TEN_SECONDS {
                steps(&mut solver, &what, 1, within, Vec3::ZERO, &colliders);
                let depth = positions(&solver).into_iter().map(|p| -solid.distance(p));
                if depth.fold(f32::MIN, f32::max) > deep {
                    inside += 1;
                    fast = fast.max(fastest(&solver));
                }
            }
            // Pierced by what it cannot leave, the stiffest pulls as hard as it may. So does a mesh, whose chains are
            // solved one after the other: a particle of it may be pulled in again for seconds, which is a limit
            // that the README names.
            if kind.what.contains("lattice, automatic") {
                check_at_most(&format!("{what}: ticks inside"), f64::from(inside), 64.0);
                check_at_most(&format!("{what}: fastest meanwhile [m/s]"), fast, 12.0);
            }
        }
    }
}

/// A solid of which nothing can be told beyond x = 0.2 m.
#[derive(Debug)]
struct Unknown {
    distance: f32,
    normal: Vec3,
}

impl SignedDistance for Unknown {
    fn sample(&self, point: Vec3) -> SdfSample {
        let ball = Sphere::new(0.4).sample(point);
        if point.x > 0.2 {
            SdfSample { distance: self.distance, normal: self.normal }
        } else {
            ball
        }
    }

    fn bounds(&self) -> Option<Aabb3d> {
        None
    }
}

/// A solid that gives no numbers does not make the cloth one: it is passed over, or the tick is refused and
/// the cloth is where it was.
#[test]
fn h22_what_is_no_number_is_not_passed_on() {
    for kind in kinds(1.0, N) {
        for distance in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1e30, 1e30, -0.1] {
            for normal in [Vec3::NAN, Vec3::INFINITY, Vec3::ZERO, Vec3::X * 1e30, Vec3::X] {
                let what = format!("{}, distance {distance}, normal {normal}", kind.what);
                let solid = Unknown { distance, normal };
                let mut solver = kind.solver(Quat::IDENTITY, Vec3::Y * 0.41);
                let colliders = [Collider::new(&solid, Pose::IDENTITY)];
                let input = StepInput {
                    dt: TICK,
                    gravity: GRAVITY,
                    colliders: &colliders,
                    ..StepInput::default()
                };
                for _ in 0..SECOND {
                    let before = positions(&solver);
                    match solver.tick(&input) {
                        Ok(_) => {}
                        Err(error) => {
                            assert_eq!(error, SolverError::Diverged, "{what}");
                            assert!(before == positions(&solver), "{what}: it moved");
                        }
                    }
                    look(&solver, &what, Within::cube(1e7));
                }
            }
        }
    }
}
