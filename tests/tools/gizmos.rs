//! Lines that would be drawn, as Bevy's `GizmoAsset` holds them.

use crate::support::app::*;
use bevy::{
    gizmos::{GizmoAsset, GizmoHandles, GizmoPlugin},
    prelude::*,
};
use bevy_drape::{
    ClothGizmos, ClothGizmosPlugin, ClothGrab, ClothSleepThreshold, SdfSlice, prelude::*,
};
use std::any::TypeId;

type Line = (Vec3, Vec3, LinearRgba);

/// An app that shows what is chosen.
fn app_showing(shown: ClothGizmos) -> App {
    let mut app = app_with((ClothPlugin::default(), GizmoPlugin, ClothGizmosPlugin));
    show(&mut app, shown);
    app
}

fn show(app: &mut App, shown: ClothGizmos) {
    *app.world_mut().resource_mut::<GizmoConfigStore>().config_mut::<ClothGizmos>().1 = shown;
}

/// What is drawn in this frame: line by line, also of strips.
fn lines(app: &App) -> Vec<Line> {
    let handles = app.world().resource::<GizmoHandles>().handles();
    let Some(Some(handle)) = handles.get(&TypeId::of::<ClothGizmos>()) else { return Vec::new() };
    let drawn = app.world().resource::<Assets<GizmoAsset>>().get(handle).expect("it is there");
    let pairs = drawn.list_positions.chunks_exact(2).zip(drawn.list_colors.chunks_exact(2));
    let strips = drawn.strip_positions.windows(2).zip(drawn.strip_colors.windows(2));
    // Strips are told apart by places that are no numbers.
    pairs
        .chain(strips)
        .map(|(at, color)| (at[0], at[1], color[0]))
        .filter(|(from, to, _)| from.is_finite() && to.is_finite())
        .collect()
}

#[test]
fn nothing_is_drawn_of_what_is_off() {
    let mut app = app_showing(ClothGizmos::NOTHING);
    app.insert_resource(ClothWind::steady(Vec3::X));
    spawn(&mut app, (sheet(), ClothPins::from(PinSelection::Corners), ClothAir::default()));
    spawn(&mut app, SdfCollider::from(InfinitePlane3d::default()));
    updates(&mut app, 3);
    assert_eq!(lines(&app), []);
    // Each by itself draws something, and all of it goes with Bevy's own switch.
    let off = ClothGizmos::NOTHING;
    for one in [
        ClothGizmos { threads: true, ..off },
        ClothGizmos { pins: true, ..off },
        ClothGizmos { contacts: true, ..off },
        ClothGizmos { wind: true, ..off },
        ClothGizmos { bounds: true, ..off },
    ] {
        show(&mut app, one);
        app.update();
        assert!(!lines(&app).is_empty(), "{one:?}");
    }
    show(&mut app, ClothGizmos::ALL);
    app.world_mut().resource_mut::<GizmoConfigStore>().config_mut::<ClothGizmos>().0.enabled =
        false;
    app.update();
    assert_eq!(lines(&app), []);
}

#[test]
fn threads_are_drawn_where_they_are() {
    let mut app = app_showing(ClothGizmos { threads: true, ..ClothGizmos::NOTHING });
    let cloth = spawn(&mut app, sheet());
    updates(&mut app, 5);
    let drawn = lines(&app);
    // 8 x 8: seven threads a row and a column.
    assert_eq!(drawn.len(), 2 * 7 * 8);
    let places = positions(&app, cloth);
    let is_one = |at: &Vec3| places.contains(at);
    assert!(drawn.iter().all(|(from, to, _)| is_one(from) && is_one(to)));
    // It falls as it is: at rest, grey.
    assert!(drawn.iter().all(|(.., color)| (color.red - color.blue).abs() < 0.02));
}

#[test]
fn stretched_threads_are_red() {
    let mut app = app_showing(ClothGizmos { threads: true, ..ClothGizmos::NOTHING });
    app.insert_resource(ClothGravity(Vec3::NEG_Y * 300.0));
    // Upright: 60 N/m at the top, over 2000 N/m a strain of 3 %.
    let upright = Transform::from_rotation(Quat::from_rotation_x(90.0_f32.to_radians()));
    let material = ClothMaterial { drag: 20.0, ..default() };
    spawn(&mut app, (sheet(), material, upright, ClothPins::from(PinSelection::FirstRow)));
    updates(&mut app, 100);
    let down = |line: &&Line| (line.0 - line.1).normalize().y.abs() > 0.9;
    let drawn = lines(&app);
    let reds = drawn.iter().filter(down).filter(|line| line.2.red > 2.0 * line.2.blue).count();
    assert!(reds > 40, "{reds}");
}

#[test]
fn crossings_are_red() {
    let off = ClothGizmos::NOTHING;
    let mut app = app_showing(ClothGizmos { crossings: true, ..off });
    app.insert_resource(ClothGravity(Vec3::ZERO));
    spawn(&mut app, sheet());
    let mesh = Mesh3d(add_mesh(&mut app, looped_mesh()));
    let tangled = spawn(&mut app, (Cloth::of_mesh3d(), mesh));
    updates(&mut app, 3);
    let drawn = lines(&app);
    assert!(drawn.len() > 4);
    assert_eq!(drawn.len(), simulation(&app, tangled).crossings() as usize);
    // The loop closes on the plane x = 0: what pierces is there, and reaches to both of its sides.
    let longest = 0.07;
    for (from, to, color) in drawn {
        assert!(from.x.abs() < longest && to.x.abs() < longest, "{from} {to}");
        assert!(color.red > 0.9 && color.blue < 0.1);
    }
    show(&mut app, off);
    app.update();
    assert_eq!(lines(&app), []);
}

#[test]
fn pins_are_tied_to_their_anchors() {
    let mut app = app_showing(ClothGizmos { pins: true, ..ClothGizmos::NOTHING });
    let anchor = spawn(&mut app, Transform::from_xyz(3.0, 2.0, 1.0));
    let soft = ClothPins::vertices([7]).softly(50.0, 1.0);
    let pins = ClothPins::vertices([0]).anchored_to(anchor).and(soft);
    let cloth = spawn(&mut app, (sheet(), pins, ClothSleepThreshold::NEVER));
    updates(&mut app, 100);
    let drawn = lines(&app);
    // Two crosses of three lines, the line to the anchor, the line of the spring.
    assert_eq!(drawn.len(), 3 + 3 + 1 + 1);
    let held = position(&app, cloth, 0);
    assert!(drawn.iter().any(|line| line.0 == held && line.1 == Vec3::new(3.0, 2.0, 1.0)));
    // The spring gives under the cloth's weight, and its line shows by how much.
    let (pulled, rest) = (position(&app, cloth, 7), Vec3::new(0.5, 0.0, -0.5));
    assert!(pulled.distance(rest) > 1e-3);
    assert!(drawn.iter().any(|line| line.0 == pulled && line.1.distance(rest) < 1e-5));
}

#[test]
fn what_is_grabbed_is_tied_to_its_target() {
    let mut app = app_showing(ClothGizmos { pins: true, ..ClothGizmos::NOTHING });
    let target = Vec3::new(0.0, 3.0, 0.0);
    let cloth = spawn(&mut app, (sheet(), ClothGrab::particle(9, target)));
    updates(&mut app, 5);
    let held = position(&app, cloth, 9);
    assert!(lines(&app).iter().any(|line| line.0 == held && line.1.distance(target) < 1e-6));
}

#[test]
fn contacts_have_the_colliders_normal() {
    let mut app =
        app_showing(ClothGizmos { contacts: true, normal_length: 0.25, ..ClothGizmos::NOTHING });
    let ground = SdfCollider::from(InfinitePlane3d::default());
    spawn(&mut app, (ground.clone(), Transform::from_scale(Vec3::splat(2.0))));
    // Another that it does not meet.
    spawn(&mut app, (ground.in_layers(2), Transform::from_xyz(0.0, 5.0, 0.0)));
    let settings = ClothSettings { layers: 1.into(), ..default() };
    let cloth = spawn(&mut app, (sheet(), settings, Transform::from_xyz(0.0, 0.02, 0.0)));
    app.update();
    assert_eq!(lines(&app), [], "it has not come down yet");
    updates(&mut app, 100);
    let drawn = lines(&app);
    assert_eq!(drawn.len(), 64, "all of it lies on the ground");
    for ((from, to, _), place) in drawn.iter().zip(positions(&app, cloth)) {
        assert_eq!(*from, place);
        assert!((*to - place).distance(0.25 * Vec3::Y) < 1e-5, "{from} {to}");
    }
}

#[test]
fn arrows_are_the_wind() {
    let mut app = app_showing(ClothGizmos { wind: true, wind_scale: 0.5, ..ClothGizmos::NOTHING });
    app.insert_resource(ClothWind::steady(Vec3::X * 4.0));
    let cloth = spawn(&mut app, (sheet(), ClothPins::from(PinSelection::All), ClothAir::default()));
    spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 9.0, 0.0)));
    updates(&mut app, 2);
    let shafts = lines(&app);
    for place in positions(&app, cloth) {
        let arrow = shafts.iter().find(|line| line.0 == place).expect("an arrow starts there");
        assert!((arrow.1 - place).distance(2.0 * Vec3::X) < 1e-5);
    }
    assert!(shafts.iter().all(|line| line.0.y < 5.0), "the other one feels none");
    // A zone is outlined where its entity is.
    let zone = WindZone::directional(Cuboid::new(2.0, 2.0, 2.0), Vec3::Y);
    spawn(&mut app, (zone, Transform::from_xyz(20.0, 0.0, 0.0)));
    updates(&mut app, 2);
    let corner = Vec3::new(21.0, 1.0, 1.0);
    assert!(lines(&app).iter().any(|line| line.0.distance(corner) < 1e-5));
}

#[test]
fn bounds_hold_every_particle() {
    let mut app = app_showing(ClothGizmos { bounds: true, ..ClothGizmos::NOTHING });
    let cloth = spawn(&mut app, (sheet(), ClothPins::from(PinSelection::FirstRow)));
    updates(&mut app, 30);
    let drawn = lines(&app);
    assert!((12..=15).contains(&drawn.len()), "{}", drawn.len());
    let places = positions(&app, cloth);
    let low = places.iter().copied().reduce(Vec3::min).unwrap();
    let high = places.iter().copied().reduce(Vec3::max).unwrap();
    for (from, to, _) in drawn {
        for corner in [from, to] {
            let away = (corner - low).abs().min((corner - high).abs());
            assert!(away.max_element() < 1e-5, "{corner}");
        }
    }
}

#[test]
fn a_slice_through_a_sphere_is_circles() {
    let mut app = app_showing(ClothGizmos::NOTHING);
    let slice = SdfSlice { half_size: 1.0, spacing: 0.25, ..default() };
    let place = Transform::from_xyz(1.0, 2.0, 3.0).with_scale(Vec3::splat(2.0));
    let solid = spawn(&mut app, (SdfCollider::from(Sphere::new(0.5)), slice, place));
    updates(&mut app, 2);
    let drawn = lines(&app);
    let (mut inside, mut surface, mut outside) = (0, 0, 0);
    for (from, to, color) in &drawn {
        for end in [from, to] {
            // In the plane, and a whole multiple of the spacing from the surface, within what a chord
            // of a cell is inside of its circle.
            assert_eq!(end.z, 3.0);
            let level = (end.distance(place.translation) - 1.0) / 0.5;
            assert!((level - level.round()).abs() < 0.02, "{level}");
        }
        let middle = (*from + *to) * 0.5;
        match middle.distance(place.translation) {
            r if r < 0.9 => {
                inside += 1;
                assert!(color.red > color.blue);
            }
            r if r < 1.1 => {
                surface += 1;
                assert_eq!(*color, LinearRgba::WHITE);
            }
            _ => {
                outside += 1;
                assert!(color.blue > color.red);
            }
        }
    }
    assert!(inside > 50 && surface > 100 && outside > 100, "{inside} {surface} {outside}");
    app.world_mut().entity_mut(solid).remove::<SdfSlice>();
    app.update();
    assert_eq!(lines(&app), []);
    // Nothing that can be set makes it hang or panic.
    for (half_size, spacing) in [(f32::NAN, 1.0), (1.0, 0.0), (1.0, 1e-30), (1e30, 1e-3)] {
        let slice = SdfSlice { half_size, spacing, ..default() };
        app.world_mut().entity_mut(solid).insert(slice);
        app.update();
    }
}

#[test]
fn without_bevys_gizmos_nothing_happens() {
    let mut app = app_with((ClothPlugin::default(), ClothGizmosPlugin));
    spawn(&mut app, sheet());
    updates(&mut app, 2);
    // Bevy's plugin may come later.
    let mut app = app_with((ClothPlugin::default(), ClothGizmosPlugin, GizmoPlugin));
    spawn(&mut app, sheet());
    updates(&mut app, 2);
    assert!(!lines(&app).is_empty());
}
