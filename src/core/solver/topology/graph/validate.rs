//! What a mesh must be to become a graph. What can be mended is mended above; the rest is refused
//! here.

use bevy_math::{DVec3, Vec3};

use crate::solver::topology::graph::{Graph, GraphError, Weights};

/// Least area of a triangle, relative to the square of its longest edge.
const LEAST_AREA: f64 = 1e-6;

/// Checks everything that is given.
pub(crate) fn check(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    weights: Weights<'_>,
) -> Result<(), GraphError> {
    check_counts(positions.len(), triangles)?;
    let too_far = |p: &Vec3| !(p.is_finite() && p.abs().max_element() <= 1e6);
    if let Some(particle) = positions.iter().position(too_far) {
        return Err(GraphError::NonFinite { particle });
    }
    for (triangle, corners) in triangles.iter().enumerate() {
        check_triangle(positions, triangle, *corners)?;
    }
    check_duplicates(triangles)?;
    check_isolated(positions.len(), triangles)?;
    check_weights("mass factors", positions.len(), weights.mass)?;
    check_weights("stiffness factors", positions.len(), weights.stiffness)
}

fn check_counts(particles: usize, triangles: &[[u32; 3]]) -> Result<(), GraphError> {
    let count = triangles.len();
    if count < 2 {
        return Err(GraphError::TooFewTriangles { triangles: count });
    }
    if particles > Graph::MAX_PARTICLES || count > 2 * Graph::MAX_PARTICLES {
        return Err(GraphError::TooLarge { particles, triangles: count });
    }
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&corner) = corners.iter().find(|&&corner| corner as usize >= particles) {
            return Err(GraphError::NoSuchCorner { triangle, corner, particles });
        }
    }
    Ok(())
}

fn check_triangle(
    positions: &[Vec3],
    triangle: usize,
    corners: [u32; 3],
) -> Result<(), GraphError> {
    let at = |i: usize| positions[corners[i] as usize].as_dvec3();
    let mut longest = 0.0_f64;
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let length = at(i).distance(at(j));
        if length <= f64::from(f32::MIN_POSITIVE) && corners[i] != corners[j] {
            let (first, second) = (corners[i] as usize, corners[j] as usize);
            return Err(GraphError::Coincident { first, second });
        }
        longest = longest.max(length);
    }
    // A corner named twice comes here too.
    if area(at(0), at(1), at(2)) <= LEAST_AREA * longest * longest {
        return Err(GraphError::ZeroArea { triangle });
    }
    Ok(())
}

/// Area of a triangle \[m2\].
pub(crate) fn area(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

fn check_duplicates(triangles: &[[u32; 3]]) -> Result<(), GraphError> {
    let mut sorted: Vec<([u32; 3], usize)> = triangles
        .iter()
        .enumerate()
        .map(|(triangle, corners)| {
            let mut corners = *corners;
            corners.sort_unstable();
            (corners, triangle)
        })
        .collect();
    sorted.sort_unstable();
    match sorted.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(pair) => Err(GraphError::Duplicate { first: pair[0].1, second: pair[1].1 }),
        None => Ok(()),
    }
}

fn check_isolated(particles: usize, triangles: &[[u32; 3]]) -> Result<(), GraphError> {
    let mut has_triangle = vec![false; particles];
    for &corner in triangles.iter().flatten() {
        has_triangle[corner as usize] = true;
    }
    match has_triangle.iter().position(|&has| !has) {
        Some(particle) => Err(GraphError::Isolated { particle }),
        None => Ok(()),
    }
}

fn check_weights(what: &'static str, particles: usize, weights: &[f32]) -> Result<(), GraphError> {
    if !weights.is_empty() && weights.len() != particles {
        return Err(GraphError::WrongWeightCount { what, particles, got: weights.len() });
    }
    let unusable = |&weight: &f32| !(1e-3..=1e3).contains(&weight);
    match weights.iter().position(unusable) {
        Some(particle) => Err(GraphError::Weight { what, particle, value: weights[particle] }),
        None => Ok(()),
    }
}
