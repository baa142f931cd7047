//! Triangles between points of a plane, whose sides are the higher of the curves that cross.

use bevy_math::DVec2;

/// Points are on a line if the triangle between them is flatter than this part of the square of the
/// size of all.
const COLLINEAR: f64 = 1e-7;

/// Points joined up.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Triangulation {
    /// Corners, counterclockwise. None where all points are on one line.
    pub triangles: Vec<[usize; 3]>,
    /// The border, counterclockwise; or from one end of the line to the other.
    pub border: Vec<[usize; 2]>,
}

/// Joins all points. Of two lines that cross, `is_higher(kept, other, place)` tells whether the
/// other is to be kept in its place.
pub(super) fn triangulate(
    points: &[DVec2],
    is_higher: impl Fn([usize; 2], [usize; 2]) -> bool,
) -> Triangulation {
    let plane = Plane::new(points);
    let mut order: Vec<usize> = (0..points.len()).collect();
    let key = |&i: &usize| [points[i].x, points[i].y];
    order.sort_by(|a, b| {
        let ([ax, ay], [bx, by]) = (key(a), key(b));
        ax.total_cmp(&bx).then(ay.total_cmp(&by))
    });
    let on_line = |i: usize| plane.side(order[0], order[i - 1], order[i]) == 0.0;
    let Some(first_off) = (2..order.len()).find(|&i| !on_line(i)) else {
        let border = order.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        return Triangulation { triangles: Vec::new(), border };
    };
    let mut mesh = plane.sweep(&order, first_off);
    flip_lower_lines(&mut mesh.triangles, &plane, is_higher);
    mesh
}

/// The points, and what counts as a line among them.
struct Plane<'a> {
    points: &'a [DVec2],
    tolerance: f64,
}

impl<'a> Plane<'a> {
    fn new(points: &'a [DVec2]) -> Self {
        let sizes = points.iter().map(|p| p.distance_squared(points[0]));
        Self { points, tolerance: COLLINEAR * sizes.fold(0.0, f64::max) }
    }

    /// Above 0 where `c` is on the left of the line from `a` to `b`, 0 where it is on it.
    fn side(&self, a: usize, b: usize, c: usize) -> f64 {
        let [a, b, c] = [a, b, c].map(|i| self.points[i]);
        let area = (b - a).perp_dot(c - a);
        if area.abs() <= self.tolerance { 0.0 } else { area }
    }

    /// Joins each point to what it sees of the border of those before it.
    fn sweep(&self, order: &[usize], first_off: usize) -> Triangulation {
        let (line, rest) = order.split_at(first_off);
        let apex = rest[0];
        let left = self.side(line[0], line[first_off - 1], apex) > 0.0;
        let mut triangles = Vec::new();
        // Around the fan, counterclockwise.
        let mut border: Vec<usize> = line.to_vec();
        if !left {
            border.reverse();
        }
        triangles.extend(border.windows(2).map(|pair| [pair[0], pair[1], apex]));
        border.push(apex);
        for &point in &rest[1..] {
            self.add(point, &mut border, &mut triangles);
        }
        let next = border.iter().cycle().skip(1);
        let edges = border.iter().zip(next).map(|(&a, &b)| [a, b]).collect();
        Triangulation { triangles, border: edges }
    }

    fn add(&self, point: usize, border: &mut Vec<usize>, triangles: &mut Vec<[usize; 3]>) {
        let count = border.len();
        let edge = |i: usize| (border[i % count], border[(i + 1) % count]);
        let side = |i: usize| self.side(edge(i).0, edge(i).1, point);
        let sees = |i: usize| side(i) < 0.0;
        // Rounding may put the point on the border: it then sees the edge that it is nearest to.
        let nearest = || {
            let exact = |i: usize| {
                let [a, b, c] = [edge(i).0, edge(i).1, point].map(|i| self.points[i]);
                (b - a).perp_dot(c - a)
            };
            (0..count).fold(0, |best, i| if exact(i) < exact(best) { i } else { best })
        };
        let first = (0..count).find(|&i| sees(i) && !sees(i + count - 1)).unwrap_or_else(nearest);
        let seen = (first + 1..first + count - 1).take_while(|&i| sees(i)).count() + 1;
        for i in first..first + seen {
            let (a, b) = edge(i);
            triangles.push([b, a, point]);
        }
        // From the far end of what is seen around to its near end, and over the new point.
        let kept = count - seen + 1;
        let mut next: Vec<usize> = (0..kept).map(|i| border[(first + seen + i) % count]).collect();
        next.push(point);
        *border = next;
    }
}

/// An edge of a triangle: ends with the lower first, the corner across, the triangle.
type Side = ([usize; 2], usize, usize);

/// Exchanges the diagonal of two triangles for the other one, as often as that is to be kept.
fn flip_lower_lines(
    triangles: &mut [[usize; 3]],
    plane: &Plane<'_>,
    is_higher: impl Fn([usize; 2], [usize; 2]) -> bool,
) {
    // A pass flips lines that are not neighbours. Heights at crossings need not agree on an order:
    // passes are counted.
    for _ in 0..8 + 2 * triangles.len() {
        let mut sides: Vec<Side> = Vec::with_capacity(3 * triangles.len());
        for (triangle, &[a, b, c]) in triangles.iter().enumerate() {
            for (a, b, across) in [(a, b, c), (b, c, a), (c, a, b)] {
                sides.push(([a.min(b), a.max(b)], across, triangle));
            }
        }
        sides.sort_unstable();
        let mut touched = vec![false; triangles.len()];
        let mut flipped = false;
        for pair in sides.windows(2) {
            let [([a, b], c, first), (other, d, second)] = [pair[0], pair[1]];
            if other != [a, b] || touched[first] || touched[second] {
                continue;
            }
            // The lines cross if each parts the ends of the other.
            let crosses = plane.side(c, d, a) * plane.side(c, d, b) < 0.0
                && plane.side(a, b, c) * plane.side(a, b, d) < 0.0;
            if crosses && is_higher([a, b], [c, d]) {
                let leftwards = |[a, b, c]: [usize; 3]| {
                    if plane.side(a, b, c) > 0.0 { [a, b, c] } else { [b, a, c] }
                };
                triangles[first] = leftwards([c, d, a]);
                triangles[second] = leftwards([c, d, b]);
                (touched[first], touched[second], flipped) = (true, true, true);
            }
        }
        if !flipped {
            return;
        }
    }
}

/// Where two lines cross, as parts of the way along each.
pub(super) fn crossing(first: [DVec2; 2], second: [DVec2; 2]) -> [f64; 2] {
    let (along, across) = (first[1] - first[0], second[1] - second[0]);
    let (from, turn) = (second[0] - first[0], along.perp_dot(across));
    [from.perp_dot(across) / turn, from.perp_dot(along) / turn]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[DVec2], [a, b, c]: [usize; 3]) -> f64 {
        0.5 * (points[b] - points[a]).perp_dot(points[c] - points[a])
    }

    /// The area inside a closed border (the shoelace formula).
    fn enclosed(points: &[DVec2], border: &[[usize; 2]]) -> f64 {
        border.iter().map(|&[a, b]| 0.5 * points[a].perp_dot(points[b])).sum()
    }

    fn shorter(points: &[DVec2]) -> impl Fn([usize; 2], [usize; 2]) -> bool + '_ {
        |[a, b], [c, d]| points[c].distance(points[d]) < points[a].distance(points[b]) - 1e-9
    }

    #[test]
    fn triangles_fill_the_hull_once() {
        let mut state = 9_u64;
        let mut roll = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / (1_u64 << 24) as f64
        };
        let scattered: Vec<_> = (0..60).map(|_| DVec2::new(roll(), roll())).collect();
        let grid: Vec<_> = (0..42).map(|i| DVec2::new((i % 7) as f64, (i / 7) as f64)).collect();
        let angle = |i: i32| core::f64::consts::TAU * f64::from(i) / 12.0;
        let ring: Vec<_> = (0..12).map(|i| DVec2::from_angle(angle(i))).collect();
        for points in [scattered, grid, ring] {
            let mesh = triangulate(&points, shorter(&points));
            let total: f64 = mesh.triangles.iter().map(|&t| area(&points, t)).sum();
            assert!(mesh.triangles.iter().all(|&t| area(&points, t) > 0.0));
            assert!((total - enclosed(&points, &mesh.border)).abs() < 1e-9);
            let outside = |&[a, b]: &[usize; 2]| {
                points.iter().any(|&p| (points[b] - points[a]).perp_dot(p - points[a]) < -1e-6)
            };
            assert!(!mesh.border.iter().any(outside), "the border is convex");
            // Euler: 2 n - 2 - (points of the border) triangles, where every point is a corner.
            let count = 2 * points.len() - 2 - mesh.border.len();
            assert_eq!(mesh.triangles.len(), count);
        }
    }

    #[test]
    fn points_on_a_line_make_a_chain() {
        let points: Vec<_> = [3.0, 0.0, 2.0, 1.0].map(|x| DVec2::new(x, 2.0 * x + 1.0)).into();
        let mesh = triangulate(&points, |_, _| unreachable!("nothing crosses"));
        assert_eq!(mesh, Triangulation { triangles: vec![], border: vec![[1, 3], [3, 2], [2, 0]] });
    }

    #[test]
    fn the_higher_diagonal_is_kept() {
        let square = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        for high in [[0, 2], [1, 3]] {
            let mesh = triangulate(&square, |_, other| other == high);
            assert!(mesh.triangles.iter().all(|t| high.iter().all(|corner| t.contains(corner))));
            assert_eq!(mesh.triangles.len(), 2);
        }
    }

    #[test]
    fn lines_cross_where_they_cross() {
        let first = [DVec2::new(0.0, 0.0), DVec2::new(4.0, 0.0)];
        let second = [DVec2::new(1.0, -1.0), DVec2::new(1.0, 3.0)];
        assert_eq!(crossing(first, second), [0.25, 0.25]);
    }
}
