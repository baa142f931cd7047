//! What cloths feel of the world: zones, gravity, the wind, the length of ticks.

use super::{
    HUGE, INF, NAN, alone, bundle,
    rows::{bad_winds, is_wind},
    told, world,
};
use crate::support::app::*;
use bevy::{prelude::*, time::Fixed};
use bevy_drape::{
    ClothComponent, ClothError, ClothErrorKind, ClothGravityOverride, ClothWindOverride,
    prelude::*,
    solver::{SolverError, WindShape},
};
use std::time::Duration;

#[test]
fn zones_of_wind() {
    let ball = || WindZone::directional(Sphere::new(3.0), Vec3::Y * 5.0);
    let of = |shape: WindShape| (WindZone::directional(shape, Vec3::Y * 5.0), Transform::default());
    let placed = |place: Transform| (ball(), place);
    let scaled = |x, y| placed(Transform::from_scale(Vec3::new(x, y, x)));
    let mut table = Vec::new();
    for bad in [NAN, INF, -1.0, 0.0, HUGE] {
        table.extend([
            of(Sphere { radius: bad }.into()),
            of(Cuboid { half_size: Vec3::new(1.0, bad, 1.0) }.into()),
            of(Cone { radius: bad, height: 1.0 }.into()),
            of(Cone { radius: 1.0, height: bad }.into()),
        ]);
    }
    for bad in [NAN, INF, -INF, HUGE] {
        let moving = |zone| (zone, Transform::default());
        table.extend([
            moving(WindZone::directional(Sphere::new(3.0), Vec3::new(1.0, bad, 0.0))),
            moving(WindZone::radial(Sphere::new(3.0), bad)),
            moving(ball().with_falloff(bad)),
        ]);
    }
    table.extend([
        (ball().with_falloff(-1.0), Transform::default()),
        scaled(1.0, 2.0),
        scaled(0.0, 0.0),
        scaled(-1.0, -1.0),
        scaled(NAN, NAN),
        scaled(INF, INF),
        placed(Transform::from_xyz(0.0, NAN, 0.0)),
        placed(Transform::from_xyz(INF, 0.0, 0.0)),
        placed(Transform::from_rotation(Quat::from_xyzw(0.0, NAN, 0.0, 1.0))),
    ]);
    let (mut app, good) = world();
    let zones: Vec<_> = table
        .into_iter()
        .map(|(zone, place)| (format!("{zone:?} {place:?}"), spawn(&mut app, (zone, place))))
        .collect();
    let lost = spawn(&mut app, ball());
    app.world_mut().entity_mut(lost).remove::<Transform>();
    let gone = spawn(&mut app, WindZone::radial(Sphere::new(NAN), 1.0));
    let former = spawn(&mut app, WindZone::radial(Sphere::new(NAN), 1.0));
    updates(&mut app, 8);
    assert_eq!(
        told(&app, lost, "lost"),
        ClothError { entity: lost, kind: ClothErrorKind::NoTransform }
    );
    app.world_mut().despawn(gone);
    app.world_mut().entity_mut(former).remove::<WindZone>();
    updates(&mut app, 12);
    assert_eq!(failure(&app, former), None);
    for (what, zone) in &zones {
        let error = told(&app, *zone, what);
        let expected = matches!(
            error,
            ClothError {
                kind: ClothErrorKind::Parameter { component: ClothComponent::WindZone, .. },
                ..
            } | ClothError { kind: ClothErrorKind::Scale(_), .. }
        );
        assert!(expected, "{what}: {error}");
    }
    assert_eq!(failure(&app, good), None);
    assert!(bits(&app, good) == alone(20), "the cloth has felt one");
    // Mended, each has a film of its own to blow at.
    let films: Vec<_> = zones
        .into_iter()
        .chain([("lost".to_owned(), lost)])
        .enumerate()
        .map(|(i, (what, zone))| {
            let place = Transform::from_xyz(20.0 * (i + 1) as f32, 0.0, 0.0);
            app.world_mut().entity_mut(zone).insert((ball(), place));
            let material = ClothMaterial { area_density: 1e-3, ..default() };
            let still = (ClothGravityOverride(Vec3::ZERO), ClothWindOverride::default());
            let film = (sheet(), material, ClothAir::default(), still, place);
            (what, zone, spawn(&mut app, film))
        })
        .collect();
    updates(&mut app, 2);
    for (what, zone, film) in films {
        assert_eq!(failure(&app, zone), None, "{what}");
        let blown = simulation(&app, film).velocity(27).unwrap().y;
        assert!(blown > 2.0, "{what}: {blown} m/s");
    }
}

/// A bad world-wide setting is reported on every cloth that uses it; a cloth with its own override keeps running.
#[test]
fn gravity_and_wind_of_the_world_and_the_length_of_ticks() {
    type Change = Box<dyn Fn(&mut App)>;
    let mut table: Vec<(String, Change, fn(&ClothError) -> bool, bool)> = Vec::new();
    for bad in [Vec3::NAN, Vec3::Z * -INF, Vec3::splat(HUGE)] {
        table.push((
            format!("gravity {bad}"),
            Box::new(move |app| _ = app.insert_resource(ClothGravity(bad))),
            |error| {
                matches!(
                    error,
                    ClothError { kind: ClothErrorKind::Solver(SolverError::Gravity), .. }
                )
            },
            true,
        ));
    }
    for (bad, _) in bad_winds() {
        let what = format!("{bad:?}");
        table.push((what, Box::new(move |app| _ = app.insert_resource(bad)), is_wind, true));
    }
    table.push((
        "ticks of two seconds".into(),
        Box::new(|app| {
            app.world_mut().resource_mut::<Time<Virtual>>().set_max_delta(Duration::from_secs(9));
            app.insert_resource(Time::<Fixed>::from_seconds(2.0));
        }),
        |error| {
            matches!(error, ClothError { kind: ClothErrorKind::Solver(SolverError::Tick(_)), .. })
        },
        false,
    ));
    for (what, spoil, is, felt) in table {
        let (mut app, feels) = world();
        let wind = *app.world().resource::<ClothWind>();
        let own = (ClothGravityOverride(*ClothGravity::default()), ClothWindOverride(wind));
        let own = spawn(&mut app, (bundle(), own));
        let calm = spawn(&mut app, sheet());
        updates(&mut app, 10);
        let before = bits(&app, feels);
        spoil(&mut app);
        updates(&mut app, 4);
        let error = told(&app, feels, &what);
        assert!(is(&error), "{what}: {error}");
        assert!(bits(&app, feels) == before, "{what}: it stands");
        assert_eq!(failure(&app, own).is_none(), felt, "{what}");
        assert_eq!(failure(&app, calm).is_none(), is_wind(&error), "{what}: it feels no wind");
        let ticks = 10 + 4 * usize::from(felt);
        app.insert_resource(ClothGravity::default()).insert_resource(wind);
        app.insert_resource(Time::<Fixed>::from_hz(64.0));
        updates(&mut app, 8);
        assert_eq!((failure(&app, feels), failure(&app, own)), (None, None), "{what}");
        assert!(simulation(&app, feels).tick_count() > 15, "{what}: mended");
        let ran = simulation(&app, own).tick_count();
        assert!(ran >= ticks as u64 + 6, "{what}: {ran} ticks");
        let mut same = world();
        updates(&mut same.0, ran as usize);
        assert!(bits(&app, own) == bits(&same.0, same.1), "{what}: it has noticed");
    }
}
