//! Meshes that are barely cloth, and a world that goes bad and good again, in an app.
//!
//! What is refused, each by itself: `tests/ecs/bad_input`, `bad_colliders`, `intake`, `anchors`, `hung`. Here:
//! that a cloth of what is left of a bad mesh moves and is drawn for ten seconds, and that a world which goes
//! bad over and over leaves others alone. Truths: finite places and normals of length one; bit equality.

use crate::support::app::*;
use crate::{app::stiffest, support::kinds::TEN_SECONDS};
use bevy::prelude::*;
use bevy_drape::{ClothGravityOverride, ClothWindOverride, prelude::*};

/// A strip of two triangles, then whatever else.
fn strip(more: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    let positions = corners.iter().chain(more).copied().collect();
    let sound = [[0, 1, 2], [2, 1, 3]];
    triangle_mesh(positions, sound.iter().chain(triangles).flatten().copied().collect())
}

/// Meshes of which something is left.
fn barely() -> Vec<(&'static str, Mesh)> {
    vec![
        ("two triangles", strip(&[], &[])),
        ("without area", strip(&[[2.0, 0.0, 0.0]], &[[0, 1, 4], [0, 0, 1], [3, 3, 3]])),
        ("nearly without area", strip(&[[0.5, 2e-5, 0.0]], &[[0, 1, 4]])),
        ("a needle", strip(&[[1e4, 0.0, 0.5]], &[[0, 2, 4]])),
        ("coincident vertices", strip(&[[1.0, 0.0, 0.0], [1.0, 1e-7, 1.0]], &[[4, 5, 0]])),
        ("the same triangle thrice", strip(&[], &[[0, 1, 2], [2, 1, 0]])),
        ("an isolated vertex", strip(&[[1e3, 1e3, 1e3]], &[])),
        ("only a corner in common", strip(&[[3.0, 0.0, 2.0], [3.0, 0.0, 1.0]], &[[3, 4, 5]])),
        (
            "twenty triangles at one edge",
            strip(
                &std::array::from_fn::<_, 20, _>(|i| {
                    let a = i as f32;
                    [0.5, 1.0 + 0.1 * a.sin(), a.cos()]
                }),
                &std::array::from_fn::<_, 20, _>(|i| [1, 2, 4 + i as u32]),
            ),
        ),
        ("a Moebius strip", moebius()),
        ("far from its origin", {
            let place = |r: u32, c: u32| Vec3::new(9e5 + c as f32, 0.0, -9e5 + r as f32);
            let mut mesh = grid_mesh(4, 4, |v| v, place);
            let Some(bevy::mesh::Indices::U32(indices)) = mesh.indices_mut() else { panic!() };
            indices.truncate(30);
            mesh
        }),
        ("tiny", strip(&[], &[]).scaled_by(Vec3::splat(1e-4))),
        ("huge", strip(&[], &[]).scaled_by(Vec3::splat(1e5))),
    ]
}

fn moebius() -> Mesh {
    let count = 12_u32;
    let place = |i: u32, side: f32| {
        let angle = std::f32::consts::TAU * i as f32 / count as f32;
        let across = Quat::from_rotation_y(angle) * Quat::from_rotation_z(0.5 * angle);
        (Quat::from_rotation_y(angle) * Vec3::X + across * Vec3::X * 0.2 * side).to_array()
    };
    let positions = (0..count).flat_map(|i| [place(i, -1.0), place(i, 1.0)]).collect();
    let corner = |i: u32, side: u32| 2 * (i % count) + if i == count { 1 - side } else { side };
    let quads = (0..count).flat_map(|i| {
        let [a, b, c, d] = [corner(i, 0), corner(i, 1), corner(i + 1, 0), corner(i + 1, 1)];
        [a, b, c, c, b, d]
    });
    triangle_mesh(positions, quads.collect())
}

#[test]
fn h14_what_is_left_of_a_bad_mesh_is_a_cloth() {
    let mut app = app();
    spawn(&mut app, (SdfCollider::from(Sphere::new(0.5)), Transform::from_xyz(0.5, -0.6, 0.5)));
    let cloths: Vec<_> = barely()
        .into_iter()
        .flat_map(|(what, mesh)| {
            let mesh = add_mesh(&mut app, mesh);
            let material = ClothMaterial::default();
            let stiffest = ClothMaterial { damping: 1e9, ..stiffest() };
            [("automatic", material), ("stiffest", stiffest)].map(|(name, material)| {
                let bundle = (
                    Cloth::of_mesh3d(),
                    Mesh3d(mesh.clone()),
                    material,
                    ClothPins::vertices([0]),
                    ClothAir::default(),
                );
                (format!("{what}, {name}"), spawn(&mut app, bundle))
            })
        })
        .collect();
    let mut worst = vec![0.0_f32; cloths.len()];
    for _ in 0..TEN_SECONDS {
        app.update();
        for ((what, cloth), worst) in cloths.iter().zip(&mut worst) {
            assert_eq!(failure(&app, *cloth), None, "{what}");
            assert!(positions(&app, *cloth).iter().all(|p| p.is_finite()), "{what}");
            let mesh = drawn(&app, *cloth);
            let at = attribute(mesh, Mesh::ATTRIBUTE_POSITION);
            assert!(at.iter().all(|p| p.is_finite()), "{what}");
            for normal in attribute(mesh, Mesh::ATTRIBUTE_NORMAL) {
                assert!((normal.length() - 1.0).abs() < 1e-3, "{what}: normal {normal}");
            }
            *worst = worst.max(simulation(&app, *cloth).last_tick().unwrap().max_strain);
        }
    }
    for ((what, cloth), worst) in cloths.iter().zip(&worst) {
        let now = simulation(&app, *cloth).last_tick().unwrap().max_strain;
        println!("{what}: strain {worst:.3} at worst, {now:.3} after 10 s");
        assert!(now < 0.2, "{what}");
    }
}

#[test]
fn h14_less_than_two_triangles_are_told() {
    let mut app = app();
    let meshes = [
        ("a vertex", triangle_mesh(vec![[0.0; 3]], vec![])),
        ("an edge", triangle_mesh(vec![[0.0; 3], [1.0, 0.0, 0.0]], vec![0, 1, 1])),
        (
            "a triangle",
            triangle_mesh(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![0, 1, 2]),
        ),
        ("nothing", triangle_mesh(vec![], vec![])),
    ];
    for (what, mesh) in meshes {
        let mesh = Mesh3d(add_mesh(&mut app, mesh));
        let cloth = spawn(&mut app, (Cloth::of_mesh3d(), mesh));
        updates(&mut app, 3);
        let error = failure(&app, cloth).expect(what).to_string();
        assert!(error.contains(&cloth.to_string()), "{what}: {error}");
        assert!(app.world().get::<ClothSimulation>(cloth).is_none(), "{what}");
    }
}

/// What may be asked of the world's numbers.
const BAD: [f32; 4] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30];

/// A cloth that feels everything, and what it hangs from.
struct Victim {
    cloth: Entity,
    anchor: Entity,
}

fn victim(app: &mut App, graph: bool, material: ClothMaterial) -> Victim {
    let anchor = spawn(app, Transform::from_xyz(0.0, 0.2, 0.0));
    let pins = ClothPins::vertices([0, 7]).and(ClothPins::vertices([63]).anchored_to(anchor));
    let cloth = spawn(app, (sheet(), pins, material, ClothAir::default()));
    if graph {
        let mesh = Mesh3d(add_mesh(app, holed_mesh()));
        app.world_mut().entity_mut(cloth).insert((Cloth::of_mesh3d(), mesh));
    }
    Victim { cloth, anchor }
}

/// Ten seconds in which, every other tick, one number of what surrounds the cloths is none. Others that feel
/// none of it go on in the same bits; the cloths that do are finite throughout, and cloths again after it.
#[test]
fn h15_a_world_that_goes_bad_over_and_over() {
    let stiffest = ClothMaterial { damping: 1e9, ..stiffest() };
    let run = |bad: bool| {
        let mut app = app();
        app.insert_resource(ClothWind::steady(Vec3::new(1.0, 0.0, 2.0)));
        let ball = SdfCollider::from(Sphere::new(0.2));
        spawn(&mut app, (ball.clone(), Transform::from_xyz(0.1, -0.25, 0.0)));
        let other = victim(&mut app, false, ClothMaterial::default()).cloth;
        let own = (
            ClothGravityOverride(*ClothGravity::default()),
            ClothWindOverride(ClothWind::steady(Vec3::new(1.0, 0.0, 2.0))),
        );
        app.world_mut().entity_mut(other).insert(own);
        // Not in the other's bits: a ball that goes bad must not have been touched by it.
        let second = spawn(&mut app, (ball, Transform::from_xyz(0.0, -50.0, 0.0)));
        let zone = WindZone::radial(Sphere::new(1.0), 3.0);
        let zone = spawn(&mut app, (zone, Transform::from_xyz(0.0, -50.0, 0.0)));
        let mut victims = Vec::new();
        for graph in [false, true] {
            for material in [ClothMaterial::default(), stiffest] {
                victims.push(victim(&mut app, graph, material));
            }
        }
        let mut told = 0;
        for tick in 0..TEN_SECONDS {
            if bad {
                spoil(&mut app, tick, &victims, second, zone);
            }
            app.update();
            for victim in &victims {
                told += usize::from(failure(&app, victim.cloth).is_some());
                if let Some(error) = failure(&app, victim.cloth) {
                    let error = error.to_string();
                    let named = [victim.cloth, victim.anchor, second, zone]
                        .iter()
                        .any(|entity| error.contains(&entity.to_string()));
                    assert!(named, "{error}");
                }
                let at = positions(&app, victim.cloth);
                assert!(at.iter().all(|p| p.is_finite() && p.length() < 1e3), "tick {tick}");
                let drawn = attribute(drawn(&app, victim.cloth), Mesh::ATTRIBUTE_POSITION);
                assert!(drawn.iter().all(|p| p.is_finite()), "drawn in tick {tick}");
            }
        }
        mend(&mut app, &victims, second, zone);
        updates(&mut app, 64);
        for (i, victim) in victims.iter().enumerate() {
            assert_eq!(failure(&app, victim.cloth), None, "{i}");
            let strain = simulation(&app, victim.cloth).last_tick().unwrap().max_strain;
            assert!(strain < 0.2, "{i}: strain {strain} a second after");
        }
        assert_eq!(failure(&app, other), None);
        (bits(&app, other), told)
    };
    let (alone, none) = run(false);
    let (beside, told) = run(true);
    assert_eq!(none, 0);
    assert!(told > TEN_SECONDS, "told {told} times");
    assert!(alone == beside, "the other cloth has noticed");
}

/// Makes one thing bad in every other tick, and good again in the next.
fn spoil(app: &mut App, tick: usize, victims: &[Victim], ball: Entity, zone: Entity) {
    mend(app, victims, ball, zone);
    if tick.is_multiple_of(2) {
        return;
    }
    let value = BAD[tick / 2 % 4];
    let bad = Vec3::new(0.0, value, 0.0);
    for victim in victims {
        match tick / 8 % 9 {
            0 => transform(app, victim.anchor).translation = bad,
            1 => transform(app, victim.anchor).rotation = Quat::from_xyzw(value, 0.0, 0.0, 1.0),
            2 => transform(app, victim.cloth).translation = bad,
            3 => transform(app, victim.cloth).scale = Vec3::new(1.0, value, 1.0),
            4 => {
                let mut running = app.world_mut().get_mut::<ClothSimulation>(victim.cloth).unwrap();
                running.set_velocities(|_| bad);
            }
            5 => _ = app.insert_resource(ClothGravity(bad)),
            6 => _ = app.insert_resource(ClothWind::steady(bad)),
            7 => transform(app, ball).translation = bad,
            _ => transform(app, zone).translation = bad,
        }
    }
}

fn mend(app: &mut App, victims: &[Victim], ball: Entity, zone: Entity) {
    for victim in victims {
        *transform(app, victim.anchor) = Transform::from_xyz(0.0, 0.2, 0.0);
        *transform(app, victim.cloth) = Transform::IDENTITY;
    }
    app.insert_resource(ClothGravity::default());
    app.insert_resource(ClothWind::steady(Vec3::new(1.0, 0.0, 2.0)));
    *transform(app, ball) = Transform::from_xyz(0.0, -50.0, 0.0);
    *transform(app, zone) = Transform::from_xyz(0.0, -50.0, 0.0);
}
