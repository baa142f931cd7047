//! Settings and states through serde, in RON and in postcard: what comes back is what was written, a scene
//! goes on with the same bits, and what is damaged, foreign or newer is an error, never a panic.

// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "support/mod.rs"]
mod support;

use bevy::prelude::*;
use bevy_drape::{
    ClothCulling, ClothError, ClothErrorKind, ClothExecution, ClothForce, ClothForces, ClothGrab,
    ClothGravityOverride, ClothInertia, ClothInterCollision, ClothInterpolation, ClothLevel,
    ClothLod, ClothPaused, ClothProxy, ClothSelfCollision, ClothSkin, ClothSleepThreshold,
    ClothSnapshot, ClothTeleport, ClothWeights, ClothWindOverride, ColliderImpulse, ColorChannel,
    HangingPlaces, SdfColliderDisabled, SdfColliderSnapshot, SkinBackstop, SkinMap, VertexFactor,
    prelude::*,
    sdf::shapes::CapsuleBetween,
    solver::{
        Bending, Gusts, Integrator, MassLumping, PushOn, StateError, StretchMethod, Substeps,
        WindFlow, WindShape,
    },
};
use core::fmt::Debug;
use serde::{Serialize, de::DeserializeOwned};
use support::{
    app::{
        saved_scene::{Case, Scene, goes_on},
        *,
    },
    dice::Dice,
};

fn through_ron<T: Serialize + DeserializeOwned>(value: &T) -> T {
    let text = ron::to_string(value).expect("it is written");
    ron::from_str(&text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

fn through_postcard<T: Serialize + DeserializeOwned>(value: &T) -> T {
    let bytes = postcard::to_allocvec(value).expect("it is written");
    postcard::from_bytes(&bytes).expect("it is read")
}

#[track_caller]
fn comes_back<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: T) {
    assert_eq!(through_ron(&value), value);
    assert_eq!(through_postcard(&value), value);
}

#[test]
fn settings_come_back() {
    comes_back(Cloth::of_mesh3d());
    comes_back(Cloth::sheet(Vec2::new(1.5, 0.1), UVec2::new(7, 9)));
    for (_, fabric) in ClothMaterial::FABRICS {
        comes_back(fabric);
    }
    let odd = ClothMaterial { drag: f32::MIN_POSITIVE, friction: -0.0, ..default() };
    comes_back(odd);
    comes_back(ClothSettings {
        substeps: Substeps::Fixed(3),
        stretch_method: StretchMethod::ExplicitSprings,
        masses: MassLumping::Equal,
        bending: Bending::Flexion,
        integrator: Integrator::Midpoint,
        layers: 5.into(),
        ..default()
    });
    comes_back(ClothInterpolation::LastTick);
    comes_back(ClothGravity(Vec3::X));
    comes_back(ClothGravityOverride(Vec3::Y));
    comes_back(ClothAir::default());
    comes_back(ClothInterCollision { layers: 6.into(), ..default() });
    comes_back(ClothSelfCollision::default());
    comes_back(ClothSelfCollision { distance: Some(0.02), friction: 0.1 });
    let wind = ClothWind::steady(Vec3::X).with_gusts(Gusts { seed: u64::MAX, ..default() });
    comes_back(wind);
    comes_back(ClothWindOverride(wind));
    comes_back(ClothTeleport::NEVER);
    comes_back(ClothInertia::new(0.3));
    comes_back(ClothSleepThreshold::default());
    comes_back(ClothCulling { after: 0.1 });
    comes_back(ClothProxy::grid(3, 7));
    comes_back(ClothProxy::ratio(0.3));
    comes_back(ClothLod {
        levels: vec![
            ClothLevel::at(3.0),
            ClothLevel::at(9.0).substeps(4).proxy(ClothProxy::ratio(0.1)),
        ],
        given: Some(1),
    });
    comes_back(ClothSkin {
        max_distance: SkinMap::joint_weight("free", 0.0, f32::INFINITY),
        backstop: Some(SkinBackstop {
            distance: SkinMap::attribute("BACK", 0.0, 1.0),
            ..default()
        }),
        drive: SkinMap::Data(vec![0.5, 0.25]),
        draws_mask: true,
    });
    // A mesh is an asset.
    assert!(ron::to_string(&ClothProxy::mesh(Handle::default())).is_err());
    comes_back(ClothPaused { steps: 2 });
    comes_back(SdfColliderDisabled);
    comes_back(HangOnStart { places: HangingPlaces::Rest, ..default() });
    comes_back(ClothExecution::Staged);
    comes_back(ColliderImpulse { linear: Vec3::Z, angular: Vec3::X });
    comes_back(ClothWeights {
        mass: VertexFactor::Color { channel: ColorChannel::Blue, at_zero: 1.0, at_one: 2.0 },
        stiffness: VertexFactor::Data(vec![1.0, 0.1, 3.0]),
    });
    comes_back(ClothForces {
        forces: vec![
            ClothForce { on: PushOn::All, force: Vec3::X },
            ClothForce {
                on: PushOn::Within { centre: Vec3::Y, radius: 1.0, falloff: 0.5 },
                force: Vec3::Y,
            },
        ],
    });
    comes_back(ClothGrab { max_force: f32::INFINITY, ..ClothGrab::within(Vec3::X, 0.1, Vec3::Y) });
    for shape in [
        WindShape::Cuboid(Cuboid::new(1.0, 2.0, 3.0)),
        WindShape::Sphere(Sphere::new(0.1)),
        WindShape::Cone(Cone::new(1.0, 2.0)),
    ] {
        comes_back(WindZone { shape, flow: WindFlow::Radial(-3.0), falloff: 0.0 });
    }
}

#[test]
fn pins_come_back_with_their_anchors() {
    let mut world = World::new();
    let anchor = world.spawn_empty().id();
    let pins = ClothPins::vertices([1, 2])
        .anchored_to(anchor)
        .softly(3.0, 0.1)
        .and(PinSelection::FirstColumn)
        .and(ClothPins::within(Vec3::NEG_ONE, Vec3::ONE))
        .and(ClothPins::color(ColorChannel::Alpha, 0.5));
    comes_back(pins.clone());
    let no_entity = ron::to_string(&pins).unwrap().replace(&anchor.to_bits().to_string(), "0");
    assert!(ron::from_str::<ClothPins>(&no_entity).is_err());
}

#[test]
fn colliders_of_plain_shapes_come_back_and_assets_are_refused() {
    let slanted = InfinitePlane3d::new(Vec3::new(0.3, 1.0, -0.2));
    let shapes: [SdfShape; 8] = [
        Sphere::new(0.5).into(),
        Cuboid::new(1.0, 2.0, 3.0).into(),
        Capsule3d::new(0.2, 0.7).into(),
        CapsuleBetween { from: Vec3::X, to: Vec3::Y, radius: 0.1 }.into(),
        slanted.into(),
        Cylinder::new(0.2, 0.4).into(),
        Torus::new(0.1, 0.5).into(),
        Cone::new(0.3, 0.6).into(),
    ];
    for shape in shapes {
        let collider = SdfCollider::new(shape).with_friction(0.9).in_layers(6);
        // Its numbers are all in what it prints.
        let printed = format!("{collider:?}");
        assert_eq!(format!("{:?}", through_ron(&collider)), printed);
        assert_eq!(format!("{:?}", through_postcard(&collider)), printed);
    }
    let field = SdfCollider::field(Handle::default());
    let problem = ron::to_string(&field).unwrap_err().to_string();
    assert!(problem.contains("Field"), "{problem}");
    assert!(ron::to_string(&SdfCollider::custom(Sphere::new(1.0))).is_err());
}

#[test]
fn a_scene_saved_in_mid_fall_goes_on_with_the_same_bits() {
    for case in Case::ALL {
        goes_on(case, 21, |state| through_ron(&state), |state| through_ron(&state));
        goes_on(case, 33, |state| through_postcard(&state), |state| through_postcard(&state));
    }
}

#[test]
fn states_come_back_to_the_bit() {
    for case in Case::ALL {
        let mut scene = Scene::new(case, 0);
        updates(&mut scene.app, 25);
        let state = simulation(&scene.app, scene.cloth).save();
        let bytes = postcard::to_allocvec(&state).unwrap();
        assert_eq!(postcard::to_allocvec(&through_ron(&state)).unwrap(), bytes);
        assert_eq!(postcard::to_allocvec(&through_postcard(&state)).unwrap(), bytes);
        comes_back(state);
        comes_back(SdfColliderSnapshot::of(scene.app.world().entity(scene.balls[0])).unwrap());
    }
}

#[test]
fn another_version_is_an_error() {
    let mut scene = Scene::new(Case::ALL[0], 0);
    updates(&mut scene.app, 3);
    let state = simulation(&scene.app, scene.cloth).save();
    let text = ron::to_string(&state).unwrap();
    assert!(text.starts_with("V1("), "{}", &text[..20]);
    let newer = text.replacen("V1", "V2", 1);
    let problem = ron::from_str::<ClothSnapshot>(&newer).unwrap_err().to_string();
    assert!(problem.contains("V2") && problem.contains("V1"), "{problem}");
    let mut bytes = postcard::to_allocvec(&state).unwrap();
    assert!(postcard::from_bytes::<ClothSnapshot>(&bytes[..bytes.len() / 2]).is_err(), "cut short");
    bytes[0] = 1;
    assert!(postcard::from_bytes::<ClothSnapshot>(&bytes).is_err());
}

/// Replaces what stands between a place in the text and the next comma or bracket.
fn edited(text: &str, after: &str, by: &str) -> String {
    let at = text.find(after).unwrap_or_else(|| panic!("no {after}")) + after.len();
    let end = text[at..].find([',', ')', ']']).expect("it ends") + at;
    format!("{}{by}{}", &text[..at], &text[end..])
}

/// Two sheets that lie on each other on a slope. What holds them is each one's own half, and comes back with it.
#[test]
fn a_pile_comes_back() {
    let pile = |others: usize| {
        let mut app = app();
        app.insert_resource(ClothGravity(Vec3::new(2.5, -9.3, 0.0)));
        for _ in 0..others {
            spawn(&mut app, Name::new("another"));
        }
        spawn(&mut app, SdfCollider::from(InfinitePlane3d::new(Vec3::Y)));
        let cloths = [0.0, 1.0].map(|layer: f32| {
            let place = Transform::from_xyz(0.0, 0.02 + 0.05 * layer, 0.0)
                .with_rotation(Quat::from_rotation_y(0.3 * layer));
            let meets = ClothInterCollision { friction: 0.9, ..default() };
            let material = ClothMaterial { friction: 0.9, ..default() };
            let sheet = Cloth::sheet(Vec2::splat(0.5), UVec2::splat(16));
            // The ground of the other app is new to it, and wakes what sleeps.
            let awake = ClothSleepThreshold::NEVER;
            spawn(&mut app, (sheet, material, meets, awake, place))
        });
        (app, cloths)
    };
    let (mut app, cloths) = pile(0);
    updates(&mut app, 90);
    let saved = cloths.map(|cloth| ClothSnapshot::of(app.world().entity(cloth)).unwrap());
    assert!(ron::to_string(&saved).unwrap().contains("stamp:"), "they touch");
    updates(&mut app, 30);
    let truth = cloths.map(|cloth| bits(&app, cloth));
    for carry in [through_ron::<ClothSnapshot>, through_postcard] {
        let (mut app, cloths) = pile(3);
        updates(&mut app, 2);
        for (cloth, state) in cloths.into_iter().zip(&saved) {
            app.world_mut().entity_mut(cloth).insert(carry(state));
        }
        updates(&mut app, 30);
        assert!(cloths.map(|cloth| bits(&app, cloth)) == truth);
    }
}

#[test]
fn what_is_damaged_is_told_to_its_cloth_and_changes_nothing() {
    let mut scene = Scene::new(Case::ALL[0], 0);
    let mut twin = Scene::new(Case::ALL[0], 0);
    updates(&mut scene.app, 12);
    updates(&mut twin.app, 12);
    let text = ron::to_string(&simulation(&scene.app, scene.cloth).save()).unwrap();
    for (after, by, what) in [
        ("origin:(", "inf", "origin"),
        ("x:[(", "NaN", "positions"),
        ("d:[(", "1e9", "displacements"),
        ("start:[(", "-inf", "positions"),
        ("mark:[(", "NaN", "marked positions"),
        ("mark_origin:(", "NaN", "origin"),
        ("unit:", "0.0", "unit of time"),
        ("last_step:", "-1.0", "last substep"),
        ("response:", "NaN", "response"),
        ("tick:", "9.0", "tick"),
        ("pins:[", "63", "pins"),
        ("soft:[((particle:", "62", "soft pins"),
        ("stiffness:", "-1.0", "stiffness"),
        ("tethered_under:Some((", "NaN", "load"),
        ("attached:[(particle:", "900", "attachments"),
        ("attached:[(particle:0,anchor:", "9", "attachments"),
        ("holds:", "77", "attachments"),
        ("local:(", "NaN", "attachments"),
        ("chosen:[(", "64", "grab"),
        ("still:", "-1.0", "rest"),
        ("placed:(translation:(", "NaN", "pose"),
        ("tick_count:", "18446744073709551615", "count of ticks"),
    ] {
        let damaged = edited(&text, after, by);
        let state: ClothSnapshot =
            ron::from_str(&damaged).unwrap_or_else(|e| panic!("{after}: {e}"));
        scene.app.world_mut().entity_mut(scene.cloth).insert(state);
        scene.app.update();
        twin.app.update();
        let told = failure(&scene.app, scene.cloth).unwrap_or_else(|| panic!("{after}{by}"));
        assert!(
            matches!(told, ClothError { entity, kind: ClothErrorKind::Snapshot(_) } if entity == scene.cloth)
        );
        let told = told.to_string();
        assert!(told.contains(what) && told.contains("damaged"), "{after}{by}: {told}");
        assert_eq!(scene.bits(), twin.bits(), "{after}{by}");
    }
    // One particle less.
    let at = text.find("x:[(").unwrap() + 3;
    let end = text[at..].find(')').unwrap() + at + 2;
    let fewer = format!("{}{}", &text[..at], &text[end..]);
    let state: ClothSnapshot = ron::from_str(&fewer).unwrap();
    scene.app.world_mut().entity_mut(scene.cloth).insert(state);
    scene.app.update();
    let problem = StateError::WrongParticleCount { expected: 64, got: 63 };
    let told = ClothError { entity: scene.cloth, kind: ClothErrorKind::Snapshot(problem) };
    assert_eq!(failure(&scene.app, scene.cloth), Some(told));
}

#[test]
fn no_damage_panics() {
    let mut scene = Scene::new(Case::ALL[2], 0);
    updates(&mut scene.app, 12);
    let bytes = postcard::to_allocvec(&simulation(&scene.app, scene.cloth).save()).unwrap();
    let mut dice = Dice(7);
    let (mut refused, mut told) = (0, 0);
    for _ in 0..600 {
        let mut damaged = bytes.clone();
        for _ in 0..2 {
            let at = dice.below(damaged.len());
            damaged[at] ^= 1 << (dice.0 >> 29 & 7);
        }
        let Ok(state) = postcard::from_bytes::<ClothSnapshot>(&damaged) else {
            refused += 1;
            continue;
        };
        scene.app.world_mut().entity_mut(scene.cloth).insert(state);
        updates(&mut scene.app, 2);
        told += u32::from(failure(&scene.app, scene.cloth).is_some());
        let cloth = simulation(&scene.app, scene.cloth);
        assert!(cloth.positions().all(Vec3::is_finite));
    }
    // Most of it is numbers that are as good as any.
    assert!(refused > 0 && told > 0, "{refused} refused, {told} told");
}
