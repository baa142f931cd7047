//! The triangle of a surface that is nearest to a point.

use bevy_math::{IVec3, Vec3};
use bevy_platform::collections::HashMap;

/// Cells along the longest side, at most.
const MOST_CELLS: f32 = 128.0;
/// A triangle that faces along is taken before a nearer one that does not, unless it is further than that by so many cells.
const DETOUR: f32 = 4.0;

/// The place on a surface that is nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    /// The corners of its triangle, and their weights, of which none is negative and the sum is one.
    pub corners: [u32; 3],
    pub weights: [f32; 3],
    pub distance: f32,
}

/// Triangles by the cells of a regular grid that their boxes reach into.
pub(super) struct NearestTriangles<'a> {
    points: &'a [Vec3],
    triangles: &'a [[u32; 3]],
    cells: HashMap<IVec3, Vec<u32>>,
    /// Side of a cell \[m\].
    side: f32,
    /// Where the first cell begins.
    min: Vec3,
    /// The last cell along each axis.
    last: IVec3,
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
        let around = boxes.clone().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (min, max) = around.unwrap_or_default();
        let side = mean.max((max - min).max_element() / MOST_CELLS);
        let side = if side > 0.0 { side } else { 1.0 };
        let cells = HashMap::new();
        let last = ((max - min) / side).floor().as_ivec3();
        let mut all = Self { points, triangles, cells, side, min, last };
        for (number, (min, max)) in (0_u32..).zip(boxes) {
            for_each_cell(all.cell(min), all.cell(max), |at| {
                all.cells.entry(at).or_default().push(number);
            });
        }
        all
    }

    /// The nearest place of the triangles that face along `normal`; of all, where none of those is about as near, or the normal is zero.
    /// Of equal ones that of the first triangle.
    pub fn nearest(&self, point: Vec3, normal: Vec3) -> Found {
        // What is outside begins at the nearest cell: all others are further by as many cells as they are from that.
        let home = self.cell(point);
        let (mut any, mut facing) = (None, None);
        for ring in 0..=self.last.max_element() {
            for_each_of_ring(home, ring, self.last, |at| {
                for &number in self.cells.get(&at).map_or(&[][..], |cell| cell) {
                    self.look(number, point, normal, &mut any, &mut facing);
                }
            });
            // What lies beyond is a whole ring away.
            let reached = ring as f32 * self.side;
            let is_reached = |best: Option<Best>, more: f32| {
                best.is_some_and(|(square, ..)| square.sqrt() + more <= reached)
            };
            if is_reached(facing, 0.0) || is_reached(any, DETOUR * self.side) {
                break;
            }
        }
        // Each triangle is in some cell.
        let (nearest, number, weights) = any.unwrap_or((f32::INFINITY, 0, [1.0, 0.0, 0.0]));
        let most = nearest.sqrt() + DETOUR * self.side;
        let facing = facing.filter(|(square, ..): &Best| square.sqrt() <= most);
        let (square, number, weights) = facing.unwrap_or((nearest, number, weights));
        Found { corners: self.triangles[number as usize], weights, distance: square.sqrt() }
    }

    fn look(
        &self,
        number: u32,
        point: Vec3,
        normal: Vec3,
        any: &mut Option<Best>,
        facing: &mut Option<Best>,
    ) {
        let [a, b, c] = self.corners(number);
        let weights = nearest_of([a, b, c], point);
        let place = a * weights[0] + b * weights[1] + c * weights[2];
        let square = place.distance_squared(point);
        let improve = |best: &mut Option<Best>| {
            let is_nearer = best.is_none_or(|(least, first, _)| {
                square < least || square == least && number < first
            });
            if is_nearer {
                *best = Some((square, number, weights));
            }
        };
        improve(any);
        if normal == Vec3::ZERO || (b - a).cross(c - a).dot(normal) > 0.0 {
            improve(facing);
        }
    }

    fn corners(&self, number: u32) -> [Vec3; 3] {
        self.triangles[number as usize].map(|corner| self.points[corner as usize])
    }

    /// The cell that a point is in, or is nearest to.
    fn cell(&self, point: Vec3) -> IVec3 {
        ((point - self.min) / self.side).floor().as_ivec3().clamp(IVec3::ZERO, self.last)
    }
}

/// The square of a distance, the number of a triangle, and the weights of its corners.
type Best = (f32, u32, [f32; 3]);

fn for_each_cell(first: IVec3, last: IVec3, mut act: impl FnMut(IVec3)) {
    for z in first.z..=last.z {
        for y in first.y..=last.y {
            for x in first.x..=last.x {
                act(IVec3::new(x, y, z));
            }
        }
    }
}

/// The cells, from zero to the last, that are `ring` cells away along some axis, and no more along any.
fn for_each_of_ring(home: IVec3, ring: i32, end: IVec3, mut act: impl FnMut(IVec3)) {
    let (first, last) = ((home - ring).max(IVec3::ZERO), (home + ring).min(end));
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
        // Small ones here and there, so that the nearest that faces along may be far.
        let centres: Vec<_> = vectors(40).into_iter().flat_map(|centre| [centre; 3]).collect();
        let points: Vec<_> = centres.iter().zip(vectors(160)).map(|(c, p)| c + p * 0.1).collect();
        let triangles: Vec<_> = (0..40).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let search = NearestTriangles::new(&points, &triangles);
        let mut seen = [0; 2];
        for (point, normal) in vectors(200).into_iter().zip(vectors(201).into_iter().skip(1)) {
            let point = point * 1.5;
            let of_all = |takes: &dyn Fn(Vec3) -> bool| {
                let facing = (0..40)
                    .map(|i| search.corners(i))
                    .filter(|[a, b, c]| takes((b - a).cross(c - a)));
                let distance = |corners: [Vec3; 3]| {
                    let w = nearest_of(corners, point);
                    (corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2]).distance(point)
                };
                facing.map(distance).fold(f32::INFINITY, f32::min)
            };
            let (any, facing) = (of_all(&|_| true), of_all(&|side| side.dot(normal) > 0.0));
            let is_near = facing <= any + DETOUR * search.side;
            let expected = if is_near { facing } else { any };
            let found = search.nearest(point, normal);
            assert!((found.distance - expected).abs() < 1e-5, "{} {expected}", found.distance);
            seen[usize::from(is_near)] += 1;
        }
        assert!(seen[0] > 0 && seen[1] > 50, "{seen:?}");
    }

    #[test]
    fn what_is_far_away_finds_what_is_there() {
        // A millimetre of surface, sought from as far as a mesh may be.
        let points = [Vec3::ZERO, Vec3::X, Vec3::Z].map(|p| p * 1e-3 - Vec3::splat(5e-4));
        let triangles = [[0, 2, 1]];
        let search = NearestTriangles::new(&points, &triangles);
        for point in [Vec3::splat(1e6), Vec3::splat(-1e6), Vec3::new(1e6, -1e6, 0.0)] {
            for normal in [Vec3::Y, Vec3::NEG_Y, Vec3::ZERO] {
                let found = search.nearest(point, normal);
                assert!((found.distance / point.length() - 1.0).abs() < 1e-5);
            }
        }
    }
}
