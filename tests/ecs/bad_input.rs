//! Bad input for every public item of the plugin: NaN, infinite, negative, zero, empty, huge, missing. It is
//! told to its own entity, by name and with what to do; nothing panics, nothing becomes NaN; the rest of the
//! world goes on in the same bits as without it; and what is mended works.
//!
//! What is here, and what stands in a table elsewhere:
//!
//! | items | where |
//! | --- | --- |
//! | `ClothMaterial`, `ClothSettings`, `ClothSleep`, `ClothTeleport`, `ClothInertia`, `ClothAir`, `ClothGravityOverride`, `ClothWindOverride`, `ClothPins`, `Cloth::sheet`, the entity's place, components taken away | here, one row each |
//! | `WindZone`, `ClothGravity`, `ClothWind`, `ClothExecution`, `Time<Fixed>`, methods of `ClothSimulation`, `ColliderImpulse`, `ClothFailure` | here |
//! | `Cloth::from_mesh`, `ClothWeights`, colours | `intake`; meshes mended in place: here |
//! | anchors that go, soft and hard | `anchors`, `pins` |
//! | `SdfCollider`, `SdfShape`, `CustomSdf`, `BakeSdf`, `SdfCells` | `bad_colliders` |
//! | `.sdf` files and their loader | `fields`; byte by byte: `tests/sdf/saved` |
//! | `TeleportCloth`, `ResetCloth`, entities that leave the world | `teleport` |
//! | `ClothPlugin` in a schedule of variable step, `MinimalPlugins` | `app` |
//! | `DistanceField::bake`; shapes asked at no point | `tests/sdf/baking`, `tests/sdf/shapes` |
//! | `ClothSolver`, `Lattice`, `Graph`, `Air`, `Wind`, `SoftPin`, `RigidMotion` | `tests/solver`: `refusals`, `graph_refusals`, `weights`, `air`, `soft`, `motion` |
//!
//! `ClothInterpolation`, `ClothFrozen`, `Integrator`, `ColorChannel` and `ClothShape::Mesh` hold nothing that can be bad.

use crate::common::*;
use bevy::{mesh::VertexAttributeValues, prelude::*, time::Fixed};
use bevy_drape::{MeshProblem, PinProblem, prelude::*, solver::SolverError};
use std::time::Duration;

const NAN: f32 = f32::NAN;
const INF: f32 = f32::INFINITY;
/// No length, no stiffness, no part of anything.
const HUGE: f32 = 1e30;

type Act = Box<dyn Fn(&mut EntityWorldMut)>;
type Is = Box<dyn Fn(&ClothError) -> bool>;

/// What becomes of a cloth about which something is bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    /// It goes on as if it were not there, in the same bits as the good cloth.
    GoesOn,
    /// It goes on in another way.
    Runs,
    /// It stays where it is, or is not set up at all.
    Stands,
}

use Fate::{GoesOn, Runs, Stands};

/// Something that is wrong with a cloth.
struct Row {
    what: String,
    spoil: Act,
    mend: Act,
    /// The error that it is told.
    is: Is,
    /// What of a cloth that is so from the start, and of one that becomes so.
    fates: [Fate; 2],
}

impl Row {
    fn new<B: Bundle>(
        what: impl Into<String>,
        fates: [Fate; 2],
        bad: impl Fn() -> B + 'static,
        mend: impl Fn(&mut EntityWorldMut) + 'static,
        is: impl Fn(&ClothError) -> bool + 'static,
    ) -> Self {
        let spoil = Box::new(move |entity: &mut EntityWorldMut| _ = entity.insert(bad()));
        Self { what: what.into(), spoil, mend: Box::new(mend), is: Box::new(is), fates }
    }
}

/// Rows for numbers of a component that are out of their ranges.
macro_rules! numbers {
    ($rows:ident, $component:ident, $fates:expr, { $($field:ident: $bad:expr;)* }) => {
        $(for bad in $bad {
            $rows.push(Row::new(
                concat!(stringify!($component), ".", stringify!($field)).to_owned()
                    + &format!(" = {bad:?}"),
                $fates,
                move || $component { $field: bad, ..default() },
                |entity| _ = entity.insert($component::default()),
                |error| matches!(
                    error,
                    ClothError::Parameter { component: stringify!($component), problem, .. }
                        if problem.name == stringify!($field) && !problem.range.is_empty()
                ),
            ));
        })*
    };
}

fn rows_of_numbers() -> Vec<Row> {
    let mut rows = Vec::new();
    let wild = [NAN, INF, -INF, -1.0, HUGE];
    let positive = [NAN, INF, -INF, -1.0, HUGE, 0.0];
    numbers!(rows, ClothMaterial, [Stands, GoesOn], {
        area_density: positive;
        thread_stiffness: wild;
        shear_stiffness: wild;
        flexural_rigidity: wild;
        damping: wild;
        drag: wild;
        max_strain: wild;
        friction: wild;
        thickness: wild;
    });
    let none = [Substeps::Fixed(0), Substeps::Automatic { budget: 0 }];
    let many = [Substeps::Fixed(u32::MAX), Substeps::Automatic { budget: u32::MAX }];
    numbers!(rows, ClothSettings, [Stands, GoesOn], {
        substeps: none.into_iter().chain(many);
        provot_passes: [u32::MAX];
        max_speed: positive;
        max_push_speed: positive;
    });
    numbers!(rows, ClothAir, [Runs, GoesOn], {
        density: wild;
        drag: wild;
        lift: wild;
    });
    numbers!(rows, ClothSleep, [GoesOn; 2], {
        distance: [NAN, INF, -INF, -1.0];
        time: [NAN, INF, -INF, -1.0];
    });
    numbers!(rows, ClothTeleport, [GoesOn; 2], {
        distance: [NAN, -INF, -1.0, 0.0];
        angle: [NAN, -INF, -1.0, 0.0];
    });
    numbers!(rows, ClothInertia, [GoesOn; 2], {
        linear: [NAN, INF, -0.1, 1.1];
        angular: [NAN, INF, -0.1, 1.1];
    });
    // Other masses at once, for which a running cloth is made anew.
    rows.push(Row::new(
        "other masses, and no speed",
        [Stands, GoesOn],
        || ClothSettings { masses: MassLumping::Equal, max_speed: 0.0, ..default() },
        |entity| _ = entity.insert(ClothSettings::default()),
        |error| matches!(error, ClothError::Parameter { component: "ClothSettings", .. }),
    ));
    rows
}

fn rows_of_surroundings() -> Vec<Row> {
    let mut rows = Vec::new();
    for bad in [Vec3::NAN, Vec3::X * INF, Vec3::Y * -HUGE] {
        rows.push(Row::new(
            format!("gravity {bad}"),
            [Stands; 2],
            move || ClothGravityOverride(bad),
            |entity| _ = entity.remove::<ClothGravityOverride>(),
            |error| matches!(error, ClothError::Solver { problem: SolverError::Gravity, .. }),
        ));
    }
    for (bad, field) in bad_winds() {
        rows.push(Row::new(
            format!("{bad:?}"),
            [Stands; 2],
            move || ClothWindOverride(bad),
            |entity| _ = entity.remove::<ClothWindOverride>(),
            move |error| is_wind(error) && error.to_string().contains(field),
        ));
    }
    rows
}

fn bad_winds() -> Vec<(ClothWind, &'static str)> {
    let mut winds = Vec::new();
    for bad in [NAN, INF, HUGE] {
        winds.push((ClothWind::steady(Vec3::new(0.0, bad, 1.0)), "velocity"));
    }
    let gusts = |gusts: Gusts| ClothWind::steady(Vec3::Y).with_gusts(gusts);
    for bad in [NAN, INF, -1.0, HUGE] {
        winds.push((gusts(Gusts { strength: bad, ..default() }), "strength"));
        let strength = 1.0;
        winds.push((gusts(Gusts { scale: bad, strength, ..default() }), "scale"));
        winds.push((gusts(Gusts { period: bad, strength, ..default() }), "period"));
    }
    winds
}

fn is_wind(error: &ClothError) -> bool {
    matches!(error, ClothError::Solver { problem: SolverError::Wind(_), .. })
}

/// Pins beside those of the good cloth, which stay.
fn rows_of_pins() -> Vec<Row> {
    let within = |min, max| ClothPins::within(Vec3::splat(min), Vec3::splat(max));
    let soft = |stiffness, damping| ClothPins::vertices([7]).softly(stiffness, damping);
    let missing = |vertex| PinProblem::NoSuchVertex { vertex, count: 64 };
    let mut table: Vec<(ClothPins, Box<dyn Fn(&PinProblem) -> bool>)> = vec![
        (ClothPins::vertices([]), Box::new(|p| *p == PinProblem::Empty)),
        (ClothPins::vertices([7, 64]), Box::new(move |p| *p == missing(64))),
        (ClothPins::vertices([u32::MAX]), Box::new(move |p| *p == missing(u32::MAX))),
        (ClothPins::color(ColorChannel::Red, 0.5), Box::new(|p| *p == PinProblem::NoColors)),
        (
            ClothPins::vertices([7]).anchored_to(Entity::PLACEHOLDER),
            Box::new(|p| *p == PinProblem::NoAnchor(Entity::PLACEHOLDER)),
        ),
    ];
    for (min, max) in [(NAN, 1.0), (-1.0, NAN), (1.0, -1.0), (HUGE, INF), (-INF, -HUGE)] {
        table.push((within(min, max), Box::new(|p| *p == PinProblem::Empty)));
    }
    let is_hold = |name: &'static str| move |p: &PinProblem| matches!(p, PinProblem::Hold(problem) if problem.name == name);
    for bad in [NAN, INF, -INF, -1.0, 0.0, HUGE] {
        table.push((soft(bad, 1.0), Box::new(is_hold("stiffness"))));
        if bad != 0.0 {
            table.push((soft(10.0, bad), Box::new(is_hold("damping"))));
        }
    }
    let row = |(bad, is): (ClothPins, Box<dyn Fn(&PinProblem) -> bool>)| {
        Row::new(
            format!("{:?}", bad.pins),
            [GoesOn; 2],
            move || pins().and(bad.clone()),
            |entity| _ = entity.insert(pins()),
            move |error| match error {
                ClothError::Pin { pin: 1, problem, .. } => is(problem),
                _ => false,
            },
        )
    };
    table.into_iter().map(row).collect()
}

fn rows_of_sheets() -> Vec<Row> {
    let mut rows = Vec::new();
    for (size, particles) in [
        (Vec2::ZERO, UVec2::splat(8)),
        (Vec2::new(1.0, 0.0), UVec2::splat(8)),
        (Vec2::NAN, UVec2::splat(8)),
        (Vec2::INFINITY, UVec2::splat(8)),
        (Vec2::splat(HUGE), UVec2::splat(8)),
        (Vec2::ONE, UVec2::ONE),
        (Vec2::ONE, UVec2::new(8, 0)),
        (Vec2::ONE, UVec2::ZERO),
        (Vec2::ONE, UVec2::MAX),
        (Vec2::ONE, UVec2::splat(1 << 16)),
    ] {
        rows.push(Row::new(
            format!("a sheet of {size}, {particles}"),
            [Stands, GoesOn],
            move || Cloth::sheet(size, particles),
            |entity| _ = entity.insert(sheet()),
            |error| matches!(error, ClothError::Shape { .. }),
        ));
    }
    rows
}

fn rows_of_places() -> Vec<Row> {
    let mut rows = Vec::new();
    let scaled = |x, y, z| Transform::from_scale(Vec3::new(x, y, z));
    let turned = |x, w| Transform::from_rotation(Quat::from_xyzw(x, 0.0, 0.0, w));
    for place in [
        Transform::from_xyz(NAN, 0.0, 0.0),
        Transform::from_xyz(0.0, INF, 0.0),
        scaled(1.0, 2.0, 1.0),
        scaled(-1.0, -1.0, -1.0),
        scaled(0.0, 0.0, 0.0),
        scaled(NAN, NAN, NAN),
        scaled(INF, INF, INF),
        turned(NAN, 1.0),
        turned(0.0, INF),
    ] {
        rows.push(Row::new(
            format!("{place:?}"),
            [Stands, GoesOn],
            move || place,
            |entity| _ = entity.insert(Transform::default()),
            |error| matches!(error, ClothError::Scale { .. }),
        ));
    }
    for (place, what) in [
        (Transform::from_xyz(0.0, 0.0, HUGE), "out of the world"),
        (scaled(1e9, 1e9, 1e9), "larger than the world"),
    ] {
        rows.push(Row::new(
            what,
            [Stands; 2],
            move || (place, ClothTeleport::NEVER),
            |entity| _ = entity.insert(Transform::default()).remove::<ClothTeleport>(),
            |error| matches!(error, ClothError::Solver { .. } | ClothError::Scale { .. }),
        ));
    }
    rows
}

fn pins() -> ClothPins {
    ClothPins::vertices((0..64).step_by(8))
}

/// What the good cloth is of. It feels everything: pins, a collider, gravity and the wind.
fn bundle() -> impl Bundle {
    (sheet(), pins(), ClothAir::default())
}

/// The same, or of a mesh that is no grid.
fn spawn_cloth(app: &mut App, graph: bool) -> Entity {
    let cloth = spawn(app, bundle());
    if graph {
        let mesh = Mesh3d(add_mesh(app, holed_mesh()));
        app.world_mut().entity_mut(cloth).insert((Cloth::from_mesh(), mesh));
    }
    cloth
}

/// A world with a good cloth in it.
fn world() -> (App, Entity) {
    world_of(false)
}

fn world_of(graph: bool) -> (App, Entity) {
    let mut app = app();
    app.insert_resource(ClothWind::steady(Vec3::new(1.0, 0.0, 2.0)));
    spawn(&mut app, (SdfCollider::from(Sphere::new(0.2)), Transform::from_xyz(0.1, -0.25, 0.0)));
    let good = spawn_cloth(&mut app, graph);
    (app, good)
}

/// Where the good cloth is after some ticks, alone in the world.
fn alone(ticks: usize) -> Vec<[u32; 3]> {
    alone_in(world(), ticks)
}

fn alone_in((mut app, good): (App, Entity), ticks: usize) -> Vec<[u32; 3]> {
    updates(&mut app, ticks);
    assert_eq!(failure(&app, good), None);
    assert!(simulation(&app, good).last_tick().unwrap().contact_count > 0, "it meets the ball");
    bits(&app, good)
}

/// What the entity is told, by its name and with something to do.
#[track_caller]
fn told(app: &App, entity: Entity, what: &str) -> ClothError {
    let Some(error) = failure(app, entity) else {
        panic!("{what}: not told");
    };
    let message = error.to_string();
    assert!(message.contains(&entity.to_string()), "{what}: {message}");
    let ways = [
        "change", "choose", "compare", "must be", "insert", "paint", "until", "released", "mend",
        "add",
    ];
    assert!(ways.iter().any(|way| message.contains(way)), "{what}: what to do? {message}");
    error
}

fn is_finite(app: &App, entity: Entity) -> bool {
    let drawn = attribute(drawn(app, entity), Mesh::ATTRIBUTE_POSITION);
    drawn.iter().all(|p| p.is_finite())
        && simulation(app, entity).positions().all(|p| p.is_finite() && p.length() < 10.0)
}

/// Ticks before a running cloth is spoiled, before what is told is looked at, and after all is mended.
const TICKS: [usize; 3] = [16, 6, 6];

/// Runs all rows in one world.
fn check_rows(rows: &[Row], graph: bool) {
    let (mut app, good) = world_of(graph);
    let cloths: Vec<_> = rows
        .iter()
        .map(|row| {
            let early = spawn_cloth(&mut app, graph);
            (row.spoil)(&mut app.world_mut().entity_mut(early));
            [early, spawn_cloth(&mut app, graph)]
        })
        .collect();
    updates(&mut app, TICKS[0]);
    let standing: Vec<_> = cloths.iter().map(|[_, late]| bits(&app, *late)).collect();
    for (row, [_, late]) in rows.iter().zip(&cloths) {
        assert_eq!(failure(&app, *late), None);
        (row.spoil)(&mut app.world_mut().entity_mut(*late));
    }
    updates(&mut app, TICKS[1]);
    let count = |app: &App, entity| app.world().get(entity).map_or(0, ClothSimulation::tick_count);
    for ((row, pair), standing) in rows.iter().zip(&cloths).zip(&standing) {
        for (i, (&entity, &fate)) in pair.iter().zip(&row.fates).enumerate() {
            let what = format!("{}, {}", row.what, ["from the start", "later"][i]);
            let error = told(&app, entity, &what);
            assert!((row.is)(&error), "{what}: {error:?}");
            let since = if i == 0 { count(&app, good) } else { TICKS[1] as u64 };
            let ran = count(&app, entity) - (count(&app, good) - since);
            assert_eq!(ran, if fate == Stands { 0 } else { since }, "{what}: ticks");
            match fate {
                GoesOn => assert!(bits(&app, entity) == bits(&app, good), "{what}: {error}"),
                Runs => assert!(is_finite(&app, entity), "{what}"),
                Stands if i == 1 => assert!(bits(&app, entity) == *standing, "{what}"),
                Stands => {}
            }
        }
        pair.iter().for_each(|&entity| (row.mend)(&mut app.world_mut().entity_mut(entity)));
    }
    updates(&mut app, TICKS[2]);
    for (row, pair) in rows.iter().zip(&cloths) {
        for (&entity, &fate) in pair.iter().zip(&row.fates) {
            let what = &row.what;
            assert_eq!(failure(&app, entity), None, "{what}: mended");
            assert!(count(&app, entity) >= TICKS[2] as u64, "{what}: mended, it runs");
            assert!(is_finite(&app, entity), "{what}");
            if fate == GoesOn {
                assert!(bits(&app, entity) == bits(&app, good), "{what}: mended");
            }
        }
    }
    assert_eq!(failure(&app, good), None);
    assert!(
        bits(&app, good) == alone_in(world_of(graph), TICKS.iter().sum()),
        "the good cloth has noticed"
    );
}

#[test]
fn numbers_of_cloths() {
    for graph in [false, true] {
        check_rows(&rows_of_numbers(), graph);
    }
}

#[test]
fn gravity_and_wind_of_cloths() {
    for graph in [false, true] {
        check_rows(&rows_of_surroundings(), graph);
    }
}

#[test]
fn pins_of_cloths() {
    for graph in [false, true] {
        check_rows(&rows_of_pins(), graph);
    }
}

#[test]
fn sizes_of_sheets() {
    check_rows(&rows_of_sheets(), false);
}

#[test]
fn places_of_cloths() {
    for graph in [false, true] {
        check_rows(&rows_of_places(), graph);
    }
}

/// What is taken away is as if the component had never been given: its default.
#[test]
fn components_that_are_taken_away() {
    let table: [(&str, Act, Fate); 7] = [
        ("ClothMaterial", Box::new(|e| _ = e.remove::<ClothMaterial>()), GoesOn),
        ("ClothSettings", Box::new(|e| _ = e.remove::<ClothSettings>()), GoesOn),
        ("ClothInterpolation", Box::new(|e| _ = e.remove::<ClothInterpolation>()), GoesOn),
        ("Visibility", Box::new(|e| _ = e.remove::<Visibility>()), GoesOn),
        ("Mesh3d", Box::new(|e| _ = e.remove::<Mesh3d>()), GoesOn),
        ("ClothAir", Box::new(|e| _ = e.remove::<ClothAir>()), Runs),
        ("ClothPins", Box::new(|e| _ = e.remove::<ClothPins>()), Runs),
    ];
    let (mut app, good) = world();
    let cloths: Vec<_> = table
        .iter()
        .map(|(_, take, _)| {
            let early = spawn(&mut app, bundle());
            take(&mut app.world_mut().entity_mut(early));
            [early, spawn(&mut app, bundle())]
        })
        .collect();
    updates(&mut app, 12);
    for ((_, take, _), [_, late]) in table.iter().zip(&cloths) {
        take(&mut app.world_mut().entity_mut(*late));
    }
    updates(&mut app, 12);
    for ((what, _, fate), pair) in table.iter().zip(&cloths) {
        for &entity in pair {
            assert_eq!(failure(&app, entity), None, "{what}");
            let running = app.world().get::<ClothSimulation>(entity);
            let running = running.unwrap_or_else(|| panic!("{what}: it never started"));
            assert_eq!(running.tick_count(), 24, "{what}");
            assert_eq!(running.pinned().is_empty(), *what == "ClothPins", "{what}");
            assert_eq!(bits(&app, entity) == bits(&app, good), *fate == GoesOn, "{what}");
        }
    }
    // What was there is not what stays.
    let stiff = ClothMaterial { area_density: 3.0, ..default() };
    let material = spawn(&mut app, (bundle(), stiff));
    updates(&mut app, 2);
    let mass = simulation(&app, material).mass(9).unwrap();
    app.world_mut().entity_mut(material).remove::<ClothMaterial>();
    updates(&mut app, 2);
    let now = simulation(&app, material).mass(9).unwrap();
    assert!((now / mass - 0.2 / 3.0).abs() < 1e-3, "{mass} kg, then {now} kg");
    assert!(
        bits(&app, good) == {
            let (mut app, good) = world();
            updates(&mut app, 28);
            bits(&app, good)
        }
    );
}

#[test]
fn a_place_that_is_lost_is_told_and_lets_go() {
    let lose: [fn(&mut App, Entity); 2] = [
        |app, cloth| _ = app.world_mut().entity_mut(cloth).remove::<Transform>(),
        |app, cloth| {
            let parent = spawn(app, ());
            app.world_mut().entity_mut(cloth).insert(ChildOf(parent));
        },
    ];
    let (mut app, good) = world();
    let early = lose.map(|lose| {
        let cloth = spawn(&mut app, bundle());
        lose(&mut app, cloth);
        cloth
    });
    let late = lose.map(|_| spawn(&mut app, bundle()));
    updates(&mut app, 8);
    for (lose, cloth) in lose.iter().zip(late) {
        lose(&mut app, cloth);
    }
    updates(&mut app, 8);
    for cloth in early {
        assert_eq!(told(&app, cloth, "early"), ClothError::NoTransform { entity: cloth });
        assert!(app.world().get::<ClothSimulation>(cloth).is_none());
    }
    for cloth in late {
        let error = told(&app, cloth, "late");
        let lost = PinProblem::NoAnchor(cloth);
        assert!(matches!(error, ClothError::Pin { problem, .. } if problem == lost), "{error}");
        assert!(simulation(&app, cloth).pinned().is_empty());
        assert_eq!(simulation(&app, cloth).tick_count(), 16);
    }
    for cloth in early.into_iter().chain(late) {
        let mut entity = app.world_mut().entity_mut(cloth);
        entity.remove::<ChildOf>().insert((Transform::default(), pins()));
    }
    updates(&mut app, 8);
    for cloth in early.into_iter().chain(late) {
        assert_eq!(failure(&app, cloth), None);
        assert_eq!(simulation(&app, cloth).pinned().len(), 8);
    }
    assert!(bits(&app, good) == alone(24));
}

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
    assert_eq!(told(&app, lost, "lost"), ClothError::NoTransform { entity: lost });
    app.world_mut().despawn(gone);
    app.world_mut().entity_mut(former).remove::<WindZone>();
    updates(&mut app, 12);
    assert_eq!(failure(&app, former), None);
    for (what, zone) in &zones {
        let error = told(&app, *zone, what);
        let expected = matches!(
            error,
            ClothError::Parameter { component: "WindZone", .. } | ClothError::Scale { .. }
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

/// What all cloths share is told to each that feels it; one that has its own goes on.
#[test]
fn gravity_and_wind_of_the_world_and_the_length_of_ticks() {
    type Change = Box<dyn Fn(&mut App)>;
    let mut table: Vec<(String, Change, fn(&ClothError) -> bool, bool)> = Vec::new();
    for bad in [Vec3::NAN, Vec3::Z * -INF, Vec3::splat(HUGE)] {
        table.push((
            format!("gravity {bad}"),
            Box::new(move |app| _ = app.insert_resource(ClothGravity(bad))),
            |error| matches!(error, ClothError::Solver { problem: SolverError::Gravity, .. }),
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
        |error| matches!(error, ClothError::Solver { problem: SolverError::Tick(_), .. }),
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

#[test]
fn resources_that_are_taken_away_are_as_by_default() {
    let (mut app, good) = world();
    let wind = *app.world().resource::<ClothWind>();
    app.world_mut().entity_mut(good).insert(ClothWindOverride(wind));
    updates(&mut app, 8);
    app.world_mut().remove_resource::<ClothGravity>();
    app.world_mut().remove_resource::<ClothWind>();
    app.world_mut().remove_resource::<ClothExecution>();
    let still = spawn(&mut app, bundle());
    updates(&mut app, 12);
    assert_eq!((failure(&app, good), failure(&app, still)), (None, None));
    assert!(bits(&app, good) == alone(20));
    assert_eq!(simulation(&app, still).tick_count(), 12);
}

#[test]
fn what_is_asked_of_a_running_cloth() {
    let (mut app, good) = world();
    let cloth = spawn(&mut app, bundle());
    updates(&mut app, 20);
    let running = simulation(&app, cloth);
    for particle in [64, usize::MAX] {
        assert_eq!(running.position(particle), None);
        assert_eq!(running.velocity(particle), None);
        assert_eq!(running.mass(particle), None);
    }
    assert_eq!(
        (running.particle_of_vertex(64), running.particle_of_vertex(u32::MAX)),
        (None, None)
    );
    // Velocities that are none are not taken, by the particle.
    let mut running = app.world_mut().get_mut::<ClothSimulation>(cloth).unwrap();
    for bad in [Vec3::NAN, Vec3::X * INF, Vec3::splat(-HUGE)] {
        running.set_velocities(|_| bad);
    }
    updates(&mut app, 4);
    assert!(bits(&app, cloth) == bits(&app, good));
    let mut running = app.world_mut().get_mut::<ClothSimulation>(cloth).unwrap();
    running.set_velocities(|p| if p.x > 0.0 { Vec3::NAN } else { Vec3::ZERO });
    // What a machine lacks is done by what it has.
    bevy_drape::solver::Isa::ALL.into_iter().for_each(|isa| running.set_isa(isa));
    updates(&mut app, 4);
    assert_eq!(failure(&app, cloth), None);
    assert!(is_finite(&app, cloth));
    assert!(bits(&app, good) == alone(28));
}

/// Impulses are written, not read.
#[test]
fn impulses_that_are_no_numbers() {
    let (mut app, good) = world();
    let floor = SdfCollider::from(InfinitePlane3d::default());
    let floor = (floor, ColliderImpulse(Vec3::NAN), Transform::from_xyz(0.0, -9.0, 0.0));
    let floor = spawn(&mut app, floor);
    let none = spawn(&mut app, ColliderImpulse(Vec3::splat(INF)));
    updates(&mut app, 20);
    assert_eq!(app.world().get::<ColliderImpulse>(floor), Some(&ColliderImpulse(Vec3::ZERO)));
    assert_eq!((failure(&app, floor), failure(&app, none)), (None, None));
    assert!(bits(&app, good) == alone(20));
}

fn errors(app: &App, entity: Entity) -> Vec<String> {
    let Some(failure) = app.world().get::<ClothFailure>(entity) else { return Vec::new() };
    failure.errors().map(ClothError::to_string).collect()
}

/// Of several things that are wrong each is told, and goes when it is mended.
#[test]
fn several_things_at_once() {
    let (mut app, good) = world();
    let cloth = spawn(&mut app, bundle());
    updates(&mut app, 8);
    let bad_pin = pins().and(ClothPins::vertices([99]));
    let material = ClothMaterial { drag: NAN, ..default() };
    let settings = ClothSettings { max_speed: -1.0, ..default() };
    let sleep = ClothSleep { time: INF, ..default() };
    app.world_mut().entity_mut(cloth).insert((bad_pin, material, settings, sleep));
    updates(&mut app, 6);
    let names = ["drag", "max_speed", "99", "time"];
    let all = errors(&app, cloth);
    assert_eq!(all.len(), names.len(), "{all:?}");
    for name in names {
        assert!(all.iter().any(|error| error.contains(name)), "{name}: {all:?}");
    }
    assert_eq!(failure(&app, cloth).map(|error| error.to_string()), all.first().cloned());
    assert!(bits(&app, cloth) == bits(&app, good));
    let mend: [(&str, Act); 4] = [
        ("drag", Box::new(|e| _ = e.insert(ClothMaterial::default()))),
        ("99", Box::new(|e| _ = e.insert(pins()))),
        ("time", Box::new(|e| _ = e.remove::<ClothSleep>())),
        ("max_speed", Box::new(|e| _ = e.insert(ClothSettings::default()))),
    ];
    for (i, (name, mend)) in mend.iter().enumerate() {
        mend(&mut app.world_mut().entity_mut(cloth));
        updates(&mut app, 2);
        let left = errors(&app, cloth);
        assert_eq!(left.len(), 3 - i, "{left:?}");
        assert!(!left.iter().any(|error| error.contains(name)), "{name}: {left:?}");
    }
    assert!(bits(&app, good) == alone(22));
    assert!(bits(&app, cloth) == bits(&app, good));
}

/// A cloth and a collider on one entity have nothing to do with each other's errors.
#[test]
fn a_cloth_that_is_also_a_bad_collider() {
    let (mut app, good) = world();
    let collider = SdfCollider::from(Sphere::new(NAN));
    let both = spawn(&mut app, (collider, Cloth::from_mesh()));
    updates(&mut app, 4);
    assert_eq!(errors(&app, both).len(), 2);
    // Its mesh comes, and it is a cloth; the collider is as bad as ever.
    let mesh = grid_mesh(3, 4, |v| v, |r, c| Vec3::new(c as f32, 0.0, r as f32));
    let mesh = Mesh3d(add_mesh(&mut app, mesh));
    app.world_mut().entity_mut(both).insert(mesh);
    updates(&mut app, 4);
    assert_eq!(simulation(&app, both).particle_count(), 12);
    let left = errors(&app, both);
    assert!(left.len() == 1 && left[0].contains("radius"), "{left:?}");
    app.world_mut().entity_mut(both).remove::<Cloth>();
    app.update();
    assert_eq!(errors(&app, both), left);
    app.world_mut().entity_mut(both).remove::<SdfCollider>();
    updates(&mut app, 11);
    assert_eq!(errors(&app, both), [""; 0]);
    assert!(bits(&app, good) == alone(20));
}

fn set_positions(app: &mut App, mesh: &Handle<Mesh>, to: impl Fn(&mut [[f32; 3]])) {
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let mut mesh = meshes.get_mut(mesh).expect("it is there");
    match mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION) {
        Some(VertexAttributeValues::Float32x3(positions)) => to(positions),
        _ => panic!("it has positions"),
    }
}

/// Meshes that come late, or are mended where they are: nothing on the entity changes.
#[test]
fn meshes_mended_in_place() {
    let (mut app, good) = world();
    let sound = grid_mesh(3, 4, |v| v, |r, c| Vec3::new(c as f32, 0.0, r as f32));
    let bent = add_mesh(&mut app, sound.clone());
    set_positions(&mut app, &bent, |p| p[5][1] = NAN);
    let hollow = add_mesh(&mut app, box_mesh(0.3));
    set_positions(&mut app, &hollow, |p| p[2][0] = NAN);
    let late = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let cloths = [&bent, &late].map(|mesh| {
        let mesh = Mesh3d(mesh.clone());
        spawn(&mut app, (Cloth::from_mesh(), mesh, Transform::from_xyz(30.0, 0.0, 0.0)))
    });
    let bake = BakeSdf::with_cells(4);
    let place = Transform::from_xyz(0.0, -40.0, 0.0);
    let colliders = [&hollow, &late].map(|mesh| {
        let bake = BakeSdf { mesh: Some(mesh.clone()), ..bake.clone() };
        spawn(&mut app, (bake, place))
    });
    updates(&mut app, 5);
    let problem = |app: &App, entity| match told(app, entity, "mesh") {
        ClothError::Mesh { problem, .. } | ClothError::ColliderMesh { problem, .. } => problem,
        other => panic!("{other}"),
    };
    assert_eq!(cloths.map(|c| problem(&app, c)), [MeshProblem::NonFinite(5), MeshProblem::Missing]);
    let found = colliders.map(|c| problem(&app, c));
    assert_eq!(found, [MeshProblem::NonFinite(2), MeshProblem::Missing]);
    assert!(cloths.iter().all(|&c| app.world().get::<ClothSimulation>(c).is_none()));
    set_positions(&mut app, &bent, |p| p[5][1] = 0.0);
    set_positions(&mut app, &hollow, |p| p[2][0] = -0.3);
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(&late, box_mesh(0.2)).unwrap();
    updates(&mut app, 5);
    assert_eq!(cloths.map(|c| failure(&app, c)), [None, None]);
    assert_eq!(cloths.map(|c| simulation(&app, c).particle_count()), [12, 8]);
    wait(&mut app, |app| colliders.iter().all(|&c| app.world().get::<SdfCollider>(c).is_some()));
    assert_eq!(colliders.map(|c| failure(&app, c)), [None, None]);
    let ticks = simulation(&app, good).tick_count();
    let mut same = world();
    updates(&mut same.0, ticks as usize);
    assert!(bits(&app, good) == bits(&same.0, same.1));
}
