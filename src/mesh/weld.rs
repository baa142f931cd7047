//! Vertices at the same place become one: UV seams and hard edges are no cuts in the cloth.

use bevy::math::Vec3;
use bevy::platform::collections::HashMap;

/// Distance at which two vertices are one place, as a part of the mesh's largest side. Far above
/// what exporters round away, far below any edge that is meant.
const RELATIVE: f32 = 1e-5;
/// The same as a part of the largest coordinate: four units in the last place, for meshes that lie
/// far from their own origin.
const ROUNDING: f32 = 4.0 * f32::EPSILON;
/// Cells of the search, in tolerances: most vertices need to look into one only.
const CELL: f32 = 8.0;

/// No vertex, or no particle.
pub(crate) const NONE: u32 = u32::MAX;

/// Distance \[m\] at which vertices of a mesh are at one place. Only those that are used count.
pub(crate) fn tolerance(positions: &[Vec3], used: &[bool]) -> f32 {
    let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for (position, _) in positions.iter().zip(used).filter(|(_, used)| **used) {
        min = min.min(*position);
        max = max.max(*position);
    }
    let side = (max - min).max_element();
    let furthest = max.abs().max(min.abs()).max_element();
    (RELATIVE * side).max(ROUNDING * furthest).max(f32::MIN_POSITIVE)
}

/// For each vertex the first used one at its place, which may be itself; [`NONE`] where there is
/// none, so that no triangle uses the place.
///
/// A vertex joins the first one within the tolerance that has not itself joined another: the
/// outcome depends on nothing but the order of the vertices.
pub(crate) fn weld(positions: &[Vec3], used: &[bool], tolerance: f32) -> Vec<u32> {
    let cell_of = |p: Vec3| (p / (CELL * tolerance)).floor().to_array().map(|x| x as i64);
    let mut first_of = vec![NONE; positions.len()];
    // The last first vertex in each cell, and the one before each.
    let mut last_in = HashMap::<[i64; 3], u32>::with_capacity(positions.len());
    let mut before = vec![NONE; positions.len()];
    let all = 0..positions.len();
    for vertex in all.clone().filter(|v| used[*v]).chain(all.filter(|v| !used[*v])) {
        let position = positions[vertex];
        let (low, high) = (cell_of(position - tolerance), cell_of(position + tolerance));
        let mut found = if used[vertex] { vertex as u32 } else { NONE };
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let mut other = last_in.get(&[x, y, z]).copied().unwrap_or(NONE);
                    while other != NONE {
                        if positions[other as usize].distance(position) <= tolerance {
                            found = found.min(other);
                        }
                        other = before[other as usize];
                    }
                }
            }
        }
        first_of[vertex] = found;
        if found as usize == vertex {
            let last = last_in.insert(cell_of(position), found);
            before[vertex] = last.unwrap_or(NONE);
        }
    }
    first_of
}

#[cfg(test)]
mod tests {
    use super::*;

    fn welded(positions: &[Vec3]) -> Vec<u32> {
        let used = vec![true; positions.len()];
        weld(positions, &used, tolerance(positions, &used))
    }

    /// A cloud on a lattice of 5 x 5 x 5, each point three times, off by a part of the tolerance.
    fn cloud(offset: Vec3, jitter: f32) -> Vec<Vec3> {
        let at = |i: u32| Vec3::new((i % 5) as f32, (i / 5 % 5) as f32, (i / 25) as f32);
        let off = |copy: u32| Vec3::new(copy as f32, -(copy as f32), 0.5) * jitter;
        (0..375).map(|i| offset + at(i % 125) + off(i / 125)).collect()
    }

    #[test]
    fn copies_join_the_first_at_their_place() {
        for jitter in [0.0, 1e-7, 4e-6] {
            for (vertex, &first) in welded(&cloud(Vec3::ZERO, jitter)).iter().enumerate() {
                assert_eq!(first as usize, vertex % 125, "{jitter}");
            }
        }
    }

    #[test]
    fn what_is_further_apart_stays_apart() {
        for (vertex, &first) in welded(&cloud(Vec3::ZERO, 1e-4)).iter().enumerate() {
            assert_eq!(first as usize, vertex);
        }
    }

    #[test]
    fn far_from_the_origin_rounding_is_forgiven() {
        let offset = Vec3::new(1e4, -1e4, 3e3);
        for (vertex, &first) in welded(&cloud(offset, 1e-3)).iter().enumerate() {
            assert_eq!(first as usize, vertex % 125);
        }
    }

    #[test]
    fn brute_force_agrees() {
        // Distances on both sides of the tolerance, also across the borders of the cells.
        let positions: Vec<_> = (0..600_u32)
            .map(|i| {
                let x = (i.wrapping_mul(2_654_435_761) >> 16) as f32 / 65536.0;
                let y = (i.wrapping_mul(40_503_001) >> 20) as f32 / 4096.0;
                if i == 0 { Vec3::X } else { Vec3::new(x, y, 0.0) * 2e-4 }
            })
            .collect();
        let used = vec![true; positions.len()];
        let tolerance = tolerance(&positions, &used);
        let mut expected = Vec::<u32>::new();
        for v in 0..positions.len() {
            let joins = |w: &usize| {
                expected[*w] as usize == *w && positions[*w].distance(positions[v]) <= tolerance
            };
            let first = (0..v).find(joins).unwrap_or(v);
            expected.push(first as u32);
        }
        assert_eq!(weld(&positions, &used, tolerance), expected);
        let joined =
            expected.iter().enumerate().filter(|(v, first)| *v != **first as usize).count();
        assert!(joined > 50 && joined < 550, "{joined}");
    }

    #[test]
    fn one_place_and_unused_vertices_are_no_trouble() {
        assert_eq!(welded(&[Vec3::ZERO; 3]), [0, 0, 0]);
        assert_eq!(welded(&[Vec3::splat(1e-44), Vec3::ZERO]), [0, 0]);
        assert_eq!(welded(&[]), [] as [u32; 0]);
        let positions = [Vec3::ZERO, Vec3::X, Vec3::ZERO];
        assert_eq!(weld(&positions, &[false, true, true], 1e-5), [2, 1, 2]);
        assert_eq!(weld(&positions, &[false, true, false], 1e-5), [NONE, 1, NONE]);
    }
}
