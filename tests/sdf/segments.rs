//! Segments: the nearest place of each, against a look at a thousand of its places.

use crate::{meshes::*, support::dice::Dice};
use bevy::math::{Quat, Vec3, primitives::*};
use bevy_drape::sdf::shapes::{CapsuleBetween, Compound, Part, Rounded, Shell};
use bevy_drape::sdf::{LANES, NearestBlock, SegmentBlock, SignedDistance};

/// Places of a segment that are looked at.
const LOOKS: u16 = 1000;

/// Part of a segment by which a place that is searched may be further away than the nearest: what six golden sections leave.
const OFF: f32 = 0.022;
/// Part of a segment by which what none is nearer than may be below what is found: for what is computed, and for what is searched.
const LEFT: [f32; 2] = [0.0021, 0.023];

/// A solid, and whether it says exactly which place is nearest.
type Case = (Box<dyn SignedDistance>, bool);

fn cases() -> Vec<Case> {
    let slanted = CapsuleBetween {
        from: Vec3::new(-0.3, -0.4, 0.1),
        to: Vec3::new(0.2, 0.5, -0.1),
        radius: 0.2,
    };
    let round = CapsuleBetween { to: slanted.from, ..slanted };
    let part = |solid: CapsuleBetween, x, angle| {
        Part::new(solid, Vec3::new(x, 0.1, 0.0), Quat::from_rotation_z(angle))
    };
    let fork = Compound::new([part(slanted, -0.2, 0.3), part(slanted, 0.2, -0.9)]);
    let boxes = [-0.4, 0.4].map(|x| {
        Part::new(Cuboid::new(0.3, 0.5, 0.4), Vec3::new(x, 0.0, 0.0), Quat::from_rotation_y(x))
    });
    vec![
        (Box::new(Sphere::new(0.4)), true),
        (Box::new(Capsule3d::new(0.2, 0.9)), true),
        (Box::new(slanted), true),
        (Box::new(round), true),
        (Box::new(InfinitePlane3d::new(Vec3::new(0.3, 0.9, -0.2))), true),
        (Box::new(Rounded::new(slanted, 0.1)), true),
        (Box::new(fork.unwrap()), true),
        (Box::new(Cuboid::new(0.5, 0.8, 0.4)), false),
        (Box::new(Cylinder::new(0.3, 0.9)), false),
        (Box::new(Cone::new(0.4, 0.9)), false),
        (Box::new(Rounded::new(Cuboid::new(0.3, 0.5, 0.2), 0.1)), false),
        (Box::new(Compound::new(boxes).unwrap()), false),
    ]
}

/// Segments of all lengths, some along an axis, and some that are points.
fn segments(dice: &mut Dice) -> SegmentBlock {
    let mut block = SegmentBlock::default();
    for lane in 0..LANES {
        let from = dice.in_box(1.0).as_vec3();
        let length = [0.0, 0.02, 0.3, 2.0][dice.below(4)];
        let slant = dice.direction().as_vec3() * [1e-4, 1e-3, 1e-2][dice.below(3)];
        let along =
            [dice.direction().as_vec3(), Vec3::Y, Vec3::NEG_X, (Vec3::Y + slant)][dice.below(4)];
        block.from.set(lane, from);
        block.way.set(lane, along * length);
    }
    block
}

#[test]
fn the_nearest_place_of_a_segment_is_found() {
    let mut dice = Dice(11);
    for (solid, is_exact) in cases() {
        for _ in 0..60 {
            let block = segments(&mut dice);
            let mut found = NearestBlock::default();
            solid.nearest_on_segments(&block, &mut found);
            for lane in 0..LANES {
                let (from, way) = (block.from.point(lane), block.way.point(lane));
                let at = |part: f32| solid.distance(from + way * part);
                let looks = (0..=LOOKS).map(|i| at(f32::from(i) / f32::from(LOOKS)));
                let least = looks.fold(f32::INFINITY, f32::min);
                let (part, distance) = (found.at[lane], found.distance[lane]);
                let what = || format!("{solid:?}: {from} + {way}: {part}, {distance}, not {least}");
                assert!((0.0..=1.0).contains(&part), "{}", what());
                assert!((at(part) - distance).abs() < 2e-6, "{}", what());
                // Between two looks it may be nearer by no more than half the way.
                let step = 0.5 * way.length() / f32::from(LOOKS);
                assert!(distance > least - step - 2e-6, "{}", what());
                let off = if is_exact { 1e-3 } else { OFF } * way.length();
                assert!(distance < least + off + 2e-6, "{}", what());
                assert!(found.least[lane] < least + 2e-6, "{}", what());
                let left = LEFT[usize::from(!is_exact)] * way.length();
                assert!(found.least[lane] >= distance - left - 2e-6, "{}", what());
            }
        }
    }
}

#[test]
fn of_a_segment_along_a_capsule_the_middle_is_nearest() {
    let capsule = CapsuleBetween { from: Vec3::ZERO, to: Vec3::Y, radius: 0.1 };
    let mut block = SegmentBlock::default();
    for lane in 0..LANES {
        block.from.set(lane, Vec3::new(0.2, 0.05 * lane as f32, 0.0));
        block.way.set(lane, Vec3::Y * 0.2);
    }
    let mut found = NearestBlock::default();
    capsule.nearest_on_segments(&block, &mut found);
    for (at, distance) in found.at.into_iter().zip(found.distance) {
        assert!((at - 0.5).abs() < 1e-5 && (distance - 0.1).abs() < 1e-6, "{at}: {distance}");
    }
}

fn bits_of(value: f32) -> u32 {
    if value.is_nan() { f32::NAN.to_bits() } else { value.to_bits() }
}

/// What is inlined for a solid that is known gives its bits, and what is no number is near to nothing.
#[test]
fn known_solids_find_the_same() {
    let mut dice = Dice(12);
    let mut known_ones = 0;
    let mut solids: Vec<_> = cases().into_iter().map(|(solid, _)| solid).collect();
    let ball = sphere_mesh(6, 0.5);
    solids.push(Box::new(Torus::new(0.2, 0.5)));
    solids.push(Box::new(Shell::new(&ball.positions, &ball.indices, 0.05).unwrap()));
    solids.push(Box::new(bake(&ball, 0.1, 0.2)));
    for solid in solids {
        for round in 0..40 {
            let mut block = segments(&mut dice);
            if round % 2 == 0 {
                block.from.x[3] = f32::NAN;
                block.way.z[5] = f32::NAN;
            }
            let mut found = NearestBlock::default();
            solid.nearest_on_segments(&block, &mut found);
            if round % 2 == 0 {
                let is_near = |lane: usize| found.distance[lane] < 1e30;
                assert!(!is_near(3) && !is_near(5), "{solid:?}: {found:?}");
            }
            let Some(known) = solid.known() else { continue };
            known_ones += 1;
            let mut inlined = NearestBlock::default();
            known.nearest_on_segments(&block, &mut inlined);
            let bits = |it: &NearestBlock| [it.at, it.distance, it.least].map(|it| it.map(bits_of));
            assert_eq!(bits(&inlined), bits(&found), "{solid:?}");
        }
    }
    assert_eq!(known_ones, 40 * 11);
}

/// A part that is far from the middle of every segment, and near to an end of each, is not passed over.
#[test]
fn compounds_look_as_far_as_segments_reach() {
    let ball = |x| Part::new(Sphere::new(0.1), Vec3::X * x, Quat::IDENTITY);
    let balls = Compound::new([ball(-1.0), ball(1.0)]).unwrap();
    let (from, to) = (Vec3::new(-0.9, 0.5, 0.0), Vec3::new(0.85, 0.0, 0.0));
    let mut block = SegmentBlock::default();
    for lane in 0..LANES {
        let shift = Vec3::Z * 1e-3 * lane as f32;
        block.from.set(lane, from + shift);
        block.way.set(lane, to - from);
    }
    let mut found = NearestBlock::default();
    balls.nearest_on_segments(&block, &mut found);
    for (at, distance) in found.at.into_iter().zip(found.distance) {
        assert!(at == 1.0 && (distance - 0.05).abs() < 2e-3, "{at}: {distance}");
    }
}
