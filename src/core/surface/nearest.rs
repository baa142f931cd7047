//! The triangle of a surface that is nearest to a point.

use bevy_math::{IVec3, Vec3};
use bevy_platform::collections::HashMap;

/// Cells along the longest side, at most.
const MOST_CELLS: f32 = 128.0;

/// A place on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corners {
    pub corners: [u32; 3],
    /// Weights of the corners, of which none is negative and the sum is one.
    pub weights: [f32; 3],
}

/// The place on a surface that is nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    pub on: Corners,
    pub distance: f32,
}

/// Triangles by the cells of a regular grid that their boxes reach into.
pub(super) struct NearestTriangles<'a> {
    points: &'a [Vec3],
    triangles: &'a [[u32; 3]],
    cells: HashMap<IVec3, Vec<u32>>,
    /// Side of a cell \[m\].
    side: f32,
    /// The first and the last cell along each axis.
    bounds: (IVec3, IVec3),
}

impl<'a> NearestTriangles<'a> {
    /// # Panics
    /// If there is no triangle, or a corner is beyond the points.
    pub fn new(points: &'a [Vec3], triangles: &'a [[u32; 3]]) -> Self {
        assert!(!triangles.is_empty(), "a surface needs a triangle");
        let boxes = triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|corner| points[corner as usize]);
            (a.min(b).min(c), a.max(b).max(c))
        });
        let mean = boxes.clone().map(|(min, max)| (max - min).max_element()).sum::<f32>()
            / triangles.len() as f32;
        let (min, max) =
            boxes.clone().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default();
        let side = mean.max((max - min).max_element() / MOST_CELLS);
        let side = if side > 0.0 { side } else { 1.0 };
        let mut cells = HashMap::<IVec3, Vec<u32>>::new();
        let mut bounds = (IVec3::MAX, IVec3::MIN);
        for (number, (min, max)) in (0_u32..).zip(boxes) {
            let (first, last) = (cell(min, side), cell(max, side));
            bounds = (bounds.0.min(first), bounds.1.max(last));
            for_each_cell(first, last, |at| cells.entry(at).or_default().push(number));
        }
        Self { points, triangles, cells, side, bounds }
    }

    /// The nearest place of all triangles that face along `normal`; of all triangles where none does, or the normal is zero. Of equal
    /// ones that of the first triangle.
    pub fn nearest(&self, point: Vec3, normal: Vec3) -> Found {
        self.search(point, |corners| {
            let [a, b, c] = corners;
            normal == Vec3::ZERO || (b - a).cross(c - a).dot(normal) > 0.0
        })
        .or_else(|| self.search(point, |_| true))
        .expect("there is a triangle")
    }

    fn search(&self, point: Vec3, takes: impl Fn([Vec3; 3]) -> bool) -> Option<Found> {
        let home = cell(point, self.side);
        let (first, last) = self.bounds;
        // Rings of cells further than this have no triangle.
        let reach = (home - first).abs().max((home - last).abs()).max_element();
        // Before that there are none either.
        let start = (first - home).max(home - last).max(IVec3::ZERO).max_element();
        let mut best: Option<(f32, u32, [f32; 3])> = None;
        for ring in start..=reach {
            for_each_of_ring(home, ring, self.bounds, |at| {
                for &number in self.cells.get(&at).map_or(&[][..], |cell| cell) {
                    let corners = self.corners(number);
                    if !takes(corners) {
                        continue;
                    }
                    let weights = nearest_of(corners, point);
                    let [a, b, c] = corners;
                    let place = a * weights[0] + b * weights[1] + c * weights[2];
                    let square = place.distance_squared(point);
                    let is_nearer = best.is_none_or(|(least, first, _)| {
                        square < least || square == least && number < first
                    });
                    if is_nearer {
                        best = Some((square, number, weights));
                    }
                }
            });
            // What lies beyond is a whole ring away.
            if best.is_some_and(|(square, ..)| square.sqrt() <= ring as f32 * self.side) {
                break;
            }
        }
        best.map(|(square, number, weights)| Found {
            on: Corners { corners: self.triangles[number as usize], weights },
            distance: square.sqrt(),
        })
    }

    fn corners(&self, number: u32) -> [Vec3; 3] {
        self.triangles[number as usize].map(|corner| self.points[corner as usize])
    }
}

fn cell(point: Vec3, side: f32) -> IVec3 {
    (point / side).floor().as_ivec3()
}

fn for_each_cell(first: IVec3, last: IVec3, mut act: impl FnMut(IVec3)) {
    for z in first.z..=last.z {
        for y in first.y..=last.y {
            for x in first.x..=last.x {
                act(IVec3::new(x, y, z));
            }
        }
    }
}

/// The cells that are `ring` cells away along some axis, and no more along any; within bounds.
fn for_each_of_ring(home: IVec3, ring: i32, bounds: (IVec3, IVec3), mut act: impl FnMut(IVec3)) {
    let first = (home - ring).max(bounds.0);
    let last = (home + ring).min(bounds.1);
    for z in first.z..=last.z {
        for y in first.y..=last.y {
            let is_face = (z - home.z).abs() == ring || (y - home.y).abs() == ring;
            if is_face {
                (first.x..=last.x).for_each(|x| act(IVec3::new(x, y, z)));
            } else {
                let ends = [home.x - ring, home.x + ring];
                let ends = ends.into_iter().filter(|x| (first.x..=last.x).contains(x));
                ends.for_each(|x| act(IVec3::new(x, y, z)));
            }
        }
    }
}

/// The weights of the corners at the place of a triangle that is nearest to a point: by the Voronoi regions of its features, Ericson 2005,
/// *Real-Time Collision Detection*, section 5.1.5.
fn nearest_of([a, b, c]: [Vec3; 3], point: Vec3) -> [f32; 3] {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (ab_ap, ac_ap) = (ab.dot(ap), ac.dot(ap));
    if ab_ap <= 0.0 && ac_ap <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = point - b;
    let (ab_bp, ac_bp) = (ab.dot(bp), ac.dot(bp));
    if ab_bp >= 0.0 && ac_bp <= ab_bp {
        return [0.0, 1.0, 0.0];
    }
    let along = |from: f32, to: f32| if from == to { 0.0 } else { from / (from - to) };
    let of_c = ab_ap * ac_bp - ab_bp * ac_ap;
    if of_c <= 0.0 && ab_ap >= 0.0 && ab_bp <= 0.0 {
        let share = along(ab_ap, ab_bp);
        return [1.0 - share, share, 0.0];
    }
    let cp = point - c;
    let (ab_cp, ac_cp) = (ab.dot(cp), ac.dot(cp));
    if ac_cp >= 0.0 && ab_cp <= ac_cp {
        return [0.0, 0.0, 1.0];
    }
    let of_b = ab_cp * ac_ap - ab_ap * ac_cp;
    if of_b <= 0.0 && ac_ap >= 0.0 && ac_cp <= 0.0 {
        let share = along(ac_ap, ac_cp);
        return [1.0 - share, 0.0, share];
    }
    let of_a = ab_bp * ac_cp - ab_cp * ac_bp;
    let (from_b, from_c) = (ac_bp - ab_bp, ab_cp - ac_cp);
    if of_a <= 0.0 && from_b >= 0.0 && from_c >= 0.0 {
        let share = along(from_b, -from_c);
        return [0.0, 1.0 - share, share];
    }
    let sum = of_a + of_b + of_c;
    let (v, w) = (of_b / sum, of_c / sum);
    [1.0 - v - w, v, w]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers from -1 to 1 without a pattern.
    fn noise(count: usize) -> impl Iterator<Item = f32> {
        let mut state = 1_u32;
        (0..count).map(move |_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        })
    }

    fn vectors(count: usize) -> Vec<Vec3> {
        let all: Vec<_> = noise(3 * count).collect();
        all.chunks(3).map(Vec3::from_slice).collect()
    }

    #[test]
    fn no_place_of_a_triangle_is_nearer() {
        for corners in vectors(3 * 40).chunks(3) {
            let corners = [corners[0], corners[1], corners[2]];
            for point in vectors(20).into_iter().map(|p| p * 3.0) {
                let at = |w: [f32; 3]| corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
                let weights = nearest_of(corners, point);
                assert!(weights.iter().all(|w| *w >= 0.0));
                assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
                let least = at(weights).distance(point);
                for step in 0..=400 {
                    let (u, v) = ((step % 21) as f32 / 20.0, (step / 21) as f32 / 20.0);
                    if u + v <= 1.0 {
                        assert!(at([1.0 - u - v, u, v]).distance(point) >= least - 1e-5);
                    }
                }
            }
        }
    }

    #[test]
    fn the_grid_finds_what_a_look_at_all_finds() {
        let points = vectors(120);
        let triangles: Vec<_> = (0..40).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let search = NearestTriangles::new(&points, &triangles);
        for (point, normal) in vectors(100).into_iter().zip(vectors(100)) {
            let point = point * 4.0;
            let of_all = (0..40)
                .filter(|&i| {
                    let [a, b, c] = search.corners(i);
                    (b - a).cross(c - a).dot(normal) > 0.0
                })
                .map(|i| {
                    let corners = search.corners(i);
                    let w = nearest_of(corners, point);
                    (corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2]).distance(point)
                })
                .fold(f32::INFINITY, f32::min);
            let found = search.nearest(point, normal);
            assert!((found.distance - of_all).abs() < 1e-5, "{} {of_all}", found.distance);
        }
    }
}
