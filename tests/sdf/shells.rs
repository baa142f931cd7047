//! Surfaces with a thickness. The truth is the definition: the least distance in `f64` to all triangles, one after the
//! other, less the radius.

use crate::ground::to_triangle;
use crate::solids::hold_to;
use crate::support::dice::Dice;
use bevy::math::{DVec3, Vec3};
use bevy_drape::sdf::shapes::{Shell, ShellError};
use bevy_drape::sdf::{LANES, PointBlock, SignedDistance};

/// Triangles by their corners, which they do not share.
type Triangles = Vec<[Vec3; 3]>;

fn shell(triangles: &Triangles, radius: f32) -> Shell {
    let vertices = triangles.as_flattened();
    let indices: Vec<u32> = (0..vertices.len() as u32).collect();
    Shell::new(vertices, &indices, radius).unwrap()
}

/// Triangles here and there, from long ones to slivers; every seventh is a line, and every eleventh a point.
fn soup(count: usize, dice: &mut Dice) -> Triangles {
    let triangle = |i: usize| {
        let (a, size) = (dice.in_box(1.0), dice.between(0.02, 0.4));
        let [ab, ac] = [(); 2].map(|()| size * dice.in_box(1.0));
        let (ab, ac) = match i {
            i if i % 11 == 10 => (DVec3::ZERO, DVec3::ZERO),
            i if i % 7 == 6 => (ab, 0.5 * ab),
            i if i % 5 == 4 => (ab, 0.5 * ab + 1e-3 * ac),
            _ => (ab, ac),
        };
        [a, a + ab, a + ac].map(DVec3::as_vec3)
    };
    (0..count).map(triangle).collect()
}

/// Hills of two by two metres with a hole, in triangles that share their sides.
fn hills(side: usize) -> Triangles {
    let at = |i: usize, j: usize| {
        let [x, z] = [j, i].map(|k| 2.0 * k as f32 / side as f32 - 1.0);
        Vec3::new(x, 0.2 * (5.0 * x).sin() * (4.0 * z).cos(), z)
    };
    let cells = (0..side * side).map(|k| (k / side, k % side));
    let whole = cells.filter(|&(i, j)| (i, j) != (side / 3, side / 2));
    whole
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)];
            [[a, c, b], [b, c, d]]
        })
        .collect()
}

fn truth(triangles: &Triangles, radius: f32) -> impl Fn(DVec3) -> f64 {
    let triangles: Vec<_> = triangles.iter().map(|t| t.map(Vec3::as_dvec3)).collect();
    move |point| {
        // `to_triangle` knows nothing of a triangle that is a point.
        let to =
            |triangle: &[DVec3; 3]| point.distance(triangle[0]).min(to_triangle(point, triangle));
        let distances = triangles.iter().map(to);
        distances.fold(f64::INFINITY, f64::min) - f64::from(radius)
    }
}

/// The distance is that to the nearest triangle less the radius; see [`hold_to`].
#[test]
fn shells_are_all_that_is_near_their_triangles() {
    let mut dice = Dice(80);
    for (seed, triangles, radius) in [
        (1, soup(1, &mut dice), 0.5),
        (2, soup(3, &mut dice), 0.3),
        (3, soup(200, &mut dice), 0.05),
        (4, hills(24), 0.04),
    ] {
        let solid = shell(&triangles, radius);
        assert_eq!(solid.triangle_count(), triangles.len());
        hold_to(&solid, 1.0, seed, truth(&triangles, radius), |_| true);
        assert_eq!(
            (solid.least_radius(), solid.core_depth(), solid.overestimate()),
            (radius, 0.0, 0.0)
        );

        let bounds = solid.bounds().unwrap();
        let corners = || triangles.iter().flatten();
        let low = corners().fold(Vec3::INFINITY, |low, corner| low.min(*corner)) - radius;
        let high = corners().fold(Vec3::NEG_INFINITY, |high, corner| high.max(*corner)) + radius;
        assert_eq!((Vec3::from(bounds.min), Vec3::from(bounds.max)), (low, high));
    }
}

/// On a triangle, out is along its normal: to one side for all points of it.
#[test]
fn on_a_triangle_out_is_across_it() {
    let solid = shell(&vec![[Vec3::ZERO, Vec3::X, Vec3::Y]], 0.1);
    for point in [Vec3::new(0.3, 0.3, 0.0), Vec3::new(0.5, 0.5, 0.0), Vec3::ZERO] {
        let sample = solid.sample(point);
        assert_eq!((sample.distance, sample.normal), (-0.1, Vec3::Z), "{point}");
    }
    let point = vec![[Vec3::ONE; 3]];
    assert_eq!(shell(&point, 0.1).sample(Vec3::ONE).normal, Vec3::Y);
}

/// One lane of a block that is nowhere leaves the others alone.
#[test]
fn points_that_are_no_numbers_are_near_nothing() {
    let solid = shell(&hills(50), 0.04);
    let mut points = PointBlock::default();
    points.set(3, Vec3::new(0.1, f32::NAN, 0.2));
    let mut distances = [0.0; LANES];
    solid.distance_block(&points, &mut distances);
    assert_eq!(distances[3], f32::INFINITY);
    assert_eq!(distances[2].to_bits(), solid.distance(Vec3::ZERO).to_bits());
}

/// Errors tell what is no shell.
#[test]
fn shells_are_checked() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let shell = |corners: &[Vec3], indices: &[u32], radius| {
        Shell::new(corners, indices, radius).map(|shell| shell.triangle_count())
    };
    assert_eq!(shell(&corners, &[0, 1, 2], 0.1), Ok(1));
    assert_eq!(shell(&corners, &[], 0.1), Err(ShellError::NoTriangles));
    assert_eq!(shell(&corners, &[0, 1, 2, 0], 0.1), Err(ShellError::NotTriangles { indices: 4 }));
    let beyond = ShellError::Index { triangle: 1, index: 3, vertices: 3 };
    assert_eq!(shell(&corners, &[0, 1, 2, 0, 1, 3], 0.1), Err(beyond));
    for bad in [f32::INFINITY, f32::NEG_INFINITY, 1e8] {
        let position = Vec3::new(0.0, bad, 0.0);
        let expected = Err(ShellError::Position { vertex: 1, position });
        assert_eq!(shell(&[Vec3::ZERO, position, Vec3::X], &[0, 1, 2], 0.1), expected);
    }
    let nan = [Vec3::ZERO, Vec3::NAN, Vec3::X];
    assert!(matches!(shell(&nan, &[0, 1, 2], 0.1), Err(ShellError::Position { vertex: 1, .. })));
    for radius in [0.0, -0.1, f32::INFINITY, 1e8] {
        assert_eq!(shell(&corners, &[0, 1, 2], radius), Err(ShellError::Radius { radius }));
    }
    assert!(matches!(shell(&corners, &[0, 1, 2], f32::NAN), Err(ShellError::Radius { .. })));
}
