//! What can be wrong with a cloth, one row each.

use super::{Act, HUGE, INF, NAN, pins};
use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{
    ClothComponent, ClothCulling, ClothError, ClothErrorKind, ClothGravityOverride, ClothInertia,
    ClothInterCollision, ClothSelfCollision, ClothSleepThreshold, ClothTeleport, ClothWindOverride,
    ColorChannel, PinProblem,
    prelude::*,
    solver::{Gusts, MassLumping, SolverError, Substeps},
};

type Is = Box<dyn Fn(&ClothError) -> bool>;

/// What becomes of a cloth about which something is bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It goes on as if it were not there, in the same bits as the good cloth.
    GoesOn,
    /// It goes on in another way.
    Runs,
    /// It stays where it is, or is not set up at all.
    Stands,
}

use Fate::{GoesOn, Runs, Stands};

/// Something that is wrong with a cloth.
pub struct Row {
    pub what: String,
    pub spoil: Act,
    pub mend: Act,
    /// The error that it is told.
    pub is: Is,
    /// What of a cloth that is so from the start, and of one that becomes so.
    pub fates: [Fate; 2],
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
                    ClothError { kind: ClothErrorKind::Parameter { component: ClothComponent::$component, problem }, .. }
                        if problem.name == stringify!($field) && !problem.range.is_empty()
                ),
            ));
        })*
    };
}

// Of a component with a single number the rest is nothing.
#[allow(clippy::needless_update)]
pub fn rows_of_numbers() -> Vec<Row> {
    let mut rows = Vec::new();
    let wild = [NAN, INF, -INF, -1.0, HUGE];
    let positive = [NAN, INF, -INF, -1.0, HUGE, 0.0];
    numbers!(rows, ClothMaterial, [Stands, GoesOn], {
        area_density: positive;
        thread_stiffness: wild;
        shear_stiffness: wild;
        flexural_rigidity: wild;
        bending_friction: wild;
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
        max_depenetration_speed: positive;
    });
    numbers!(rows, ClothAir, [Runs, GoesOn], {
        density: wild;
        drag: wild;
        lift: wild;
    });
    numbers!(rows, ClothSelfCollision, [GoesOn; 2], {
        distance: [NAN, INF, -1.0, 0.0, HUGE].map(Some);
        friction: wild;
    });
    let before = rows.len();
    numbers!(rows, ClothInterCollision, [GoesOn; 2], {
        distance: [NAN, INF, -1.0, 0.0, HUGE].map(Some);
        friction: wild;
    });
    // Mended by being taken away: all of these cloths are in one place.
    for row in &mut rows[before..] {
        row.mend = Box::new(|entity| _ = entity.remove::<ClothInterCollision>());
    }
    numbers!(rows, ClothSleepThreshold, [GoesOn; 2], {
        distance: [NAN, INF, -INF, -1.0];
        time: [NAN, INF, -INF, -1.0];
    });
    numbers!(rows, ClothCulling, [GoesOn; 2], {
        after: [NAN, INF, -INF, -1.0];
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
        |error| {
            matches!(
                error,
                ClothError {
                    kind: ClothErrorKind::Parameter {
                        component: ClothComponent::ClothSettings,
                        ..
                    },
                    ..
                }
            )
        },
    ));
    rows
}

pub fn rows_of_surroundings() -> Vec<Row> {
    let mut rows = Vec::new();
    for bad in [Vec3::NAN, Vec3::X * INF, Vec3::Y * -HUGE] {
        rows.push(Row::new(
            format!("gravity {bad}"),
            [Stands; 2],
            move || ClothGravityOverride(bad),
            |entity| _ = entity.remove::<ClothGravityOverride>(),
            |error| {
                matches!(
                    error,
                    ClothError { kind: ClothErrorKind::Solver(SolverError::Gravity), .. }
                )
            },
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

pub fn bad_winds() -> Vec<(ClothWind, &'static str)> {
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

pub fn is_wind(error: &ClothError) -> bool {
    matches!(error, ClothError { kind: ClothErrorKind::Solver(SolverError::Wind(_)), .. })
}

/// Pins beside those of the good cloth, which stay.
pub fn rows_of_pins() -> Vec<Row> {
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
                ClothError { kind: ClothErrorKind::Pin { pin: 1, problem }, .. } => is(problem),
                _ => false,
            },
        )
    };
    table.into_iter().map(row).collect()
}

pub fn rows_of_sheets() -> Vec<Row> {
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
            |error| matches!(error, ClothError { kind: ClothErrorKind::Shape(_), .. }),
        ));
    }
    rows
}

pub fn rows_of_places() -> Vec<Row> {
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
            |error| matches!(error, ClothError { kind: ClothErrorKind::Scale(_), .. }),
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
            |error| {
                matches!(
                    error,
                    ClothError { kind: ClothErrorKind::Solver(_), .. }
                        | ClothError { kind: ClothErrorKind::Scale(_), .. }
                )
            },
        ));
    }
    rows
}
