//! One result, however it is run: bit equality.

use crate::support::app::*;
use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_drape::{ClothExecution, ClothSubstep, ClothSubstepSystems, prelude::*, solver::Substeps};
use std::process::Command;

/// Cloths of several sizes, materials and substeps, that fall, hang and are moved: their positions
/// after a while.
fn scene(app: &mut App) -> Vec<[u32; 3]> {
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.add_systems(FixedUpdate, |mut solids: Query<&mut Transform, With<SdfCollider>>| {
        for mut transform in &mut solids {
            transform.translation.y += 0.005;
        }
    });
    let solids = [
        spawn(app, SdfCollider::from(Sphere::new(0.3))),
        spawn(app, (SdfCollider::from(Cuboid::default()), Transform::from_xyz(2.0, 0.0, 0.0))),
    ];
    let cloths: Vec<_> = (0..12_u32)
        .map(|i| {
            let sheet = Cloth::sheet(Vec2::ONE, UVec2::new(6 + i, 17 - i));
            let stiffness = [20.0, 500.0, 5e4][i as usize % 3];
            let material =
                ClothMaterial { thread_stiffness: stiffness, damping: 0.01, ..default() };
            let fixed = Substeps::Fixed(1 + i);
            let substeps = if i % 4 == 0 { Substeps::default() } else { fixed };
            let settings = ClothSettings { substeps, ..default() };
            let pins = match i % 3 {
                0 => ClothPins::none(),
                1 => ClothPins::from(PinSelection::Corners),
                _ => ClothPins::vertices([0]).anchored_to(solids[i as usize % 2]),
            };
            let place = Transform::from_xyz((i % 2) as f32 * 2.0, 0.6, 0.0);
            spawn(app, (sheet, material, settings, pins, place))
        })
        .collect();
    updates(app, 30);
    cloths.iter().flat_map(|cloth| bits(app, *cloth)).collect()
}

fn run(execution: ClothExecution) -> Vec<[u32; 3]> {
    let mut app = app();
    app.insert_resource(execution);
    scene(&mut app)
}

#[test]
fn fused_and_staged_are_the_same_and_repeat() {
    let fused = run(ClothExecution::Fused);
    assert_eq!(fused, run(ClothExecution::Fused));
    assert_eq!(fused, run(ClothExecution::Staged));
    assert_eq!(fused, run(ClothExecution::Automatic));
    assert!(fused.iter().flatten().all(|bits| f32::from_bits(*bits).is_finite()));
}

#[derive(Component)]
struct Marked;

#[test]
fn the_order_in_which_bevy_stores_colliders_does_not_matter() {
    let run = |marked: Option<usize>| {
        let mut app = app();
        // A groove: the particles at its bottom touch both sides, one after the other.
        let solids = [Vec3::new(1.0, 1.0, 0.2), Vec3::new(-0.5, 1.0, 0.0)].map(|normal| {
            let side = InfinitePlane3d::new(Dir3::new(normal).unwrap());
            spawn(&mut app, SdfCollider::from(side))
        });
        if let Some(marked) = marked {
            app.world_mut().entity_mut(solids[marked]).insert(Marked);
        }
        let rag = Cloth::sheet(Vec2::splat(0.1), UVec2::splat(9));
        let cloth = spawn(&mut app, (rag, Transform::from_xyz(0.02, 0.1, 0.0)));
        updates(&mut app, 60);
        bits(&app, cloth)
    };
    assert_eq!(run(None), run(Some(0)));
    assert_eq!(run(None), run(Some(1)));
}

#[derive(Resource, Default)]
struct Substep(u32);

#[test]
fn a_games_own_system_goes_between_the_stages() {
    let mut app = app();
    app.insert_resource(ClothExecution::Automatic);
    let settings = |count| ClothSettings { substeps: Substeps::Fixed(count), ..default() };
    let few = spawn(&mut app, (sheet(), settings(3)));
    let many = spawn(&mut app, (sheet(), settings(7)));
    updates(&mut app, 5);
    app.init_resource::<Substep>().add_systems(
        ClothSubstep,
        (|mut count: ResMut<Substep>| count.0 += 1)
            .after(ClothSubstepSystems::Correct)
            .before(ClothSubstepSystems::Collide),
    );
    updates(&mut app, 4);
    assert_eq!(
        app.world().resource::<Substep>().0,
        28,
        "as many rounds as the cloth with most needs"
    );
    for (cloth, count) in [(few, 3), (many, 7)] {
        assert_eq!(simulation(&app, cloth).last_tick().unwrap().substeps, count);
        assert_eq!(simulation(&app, cloth).tick_count(), 9);
    }
    app.insert_resource(ClothExecution::Fused);
    updates(&mut app, 4);
    assert_eq!(app.world().resource::<Substep>().0, 28);
}

#[test]
fn one_two_and_four_threads_give_the_same_bits() {
    let name = "execution::one_two_and_four_threads_give_the_same_bits";
    let plugins = |app: &mut App| {
        app.add_plugins(ClothPlugin::default());
    };
    let Some(bits) = in_pools(name, &[1, 2, 4], plugins, |app| format!("{:?}", scene(app))) else {
        return;
    };
    assert!(bits[0].len() > 1000);
    assert!(bits[0] == bits[1] && bits[0] == bits[2]);
}

/// Every test of this crate again, in the other form.
#[test]
fn all_tests_pass_in_the_staged_form() {
    if std::env::var_os(POOL).is_some() {
        return;
    }
    let is_staged = std::env::var_os(STAGED).is_some();
    let form = *app().world().resource::<ClothExecution>();
    assert_eq!(form == ClothExecution::Staged, is_staged, "the variable chooses the form");
    if is_staged {
        return;
    }
    let run = |arguments: &[&str]| {
        let mut command = Command::new(std::env::current_exe().unwrap());
        let output = command.args(arguments).env(STAGED, "1").output().unwrap();
        (output.status.success(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (_, list) = run(&["--list", "--format", "terse"]);
    let count = list.lines().filter(|line| line.ends_with(": test")).count();
    let (passed, text) = run(&[]);
    assert!(passed && text.contains(&format!("ok. {count} passed; 0 failed; 0 ignored")), "{text}");
}
