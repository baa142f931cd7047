//! The axes of a cloud of points, and small symmetric linear systems.

use bevy_math::Vec3;

use super::SurfacePoint;

/// Middle and axes of a surface.
pub struct Cloud {
    /// The mean of its points.
    pub mean: Vec3,
    /// Directions in which it is longest, next, and shortest.
    pub axes: [Vec3; 3],
}

impl Cloud {
    /// Of a surface that has any.
    pub fn of(points: &[SurfacePoint]) -> Option<Self> {
        let area: f32 = points.iter().map(|it| it.area).sum();
        if area.is_nan() || area <= 0.0 {
            return None;
        }
        let mean = points.iter().map(|it| it.point * it.area).sum::<Vec3>() / area;
        let mut moments = [[0.0; 3]; 3];
        for SurfacePoint { point, area } in points {
            let offset = (*point - mean).to_array();
            for i in 0..3 {
                for j in 0..=i {
                    moments[i][j] += f64::from(area * offset[i] * offset[j]);
                }
            }
        }
        for (i, j) in [(1, 0), (2, 0), (2, 1)] {
            moments[j][i] = moments[i][j];
        }
        Some(Self { mean, axes: eigenvectors(moments) })
    }
}

/// The eigenvectors of a symmetric matrix, that of the largest eigenvalue first (Jacobi's rotations).
fn eigenvectors(mut m: [[f64; 3]; 3]) -> [Vec3; 3] {
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let scale = m[p][p].abs() + m[q][q].abs();
            if m[p][q].abs() <= 1e-12 * scale {
                continue;
            }
            let slope = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
            let t = slope.signum() / (slope.abs() + (slope * slope + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut m {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            for k in 0..3 {
                (m[p][k], m[q][k]) = (c * m[p][k] - s * m[q][k], s * m[p][k] + c * m[q][k]);
                (axes[p][k], axes[q][k]) =
                    (c * axes[p][k] - s * axes[q][k], s * axes[p][k] + c * axes[q][k]);
            }
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| m[b][b].total_cmp(&m[a][a]));
    order.map(|i| Vec3::from_array(axes[i].map(|it| it as f32)))
}

/// The solution of a symmetric positive definite system (Cholesky); `None` where it is none.
pub fn solve<const N: usize>(mut m: [[f64; N]; N], mut right: [f64; N]) -> Option<[f64; N]> {
    for i in 0..N {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| m[i][k] * m[j][k]).sum();
            let left = m[i][j] - known;
            if i == j {
                if left.is_nan() || left <= 0.0 {
                    return None;
                }
                m[i][i] = left.sqrt();
            } else {
                m[i][j] = left / m[j][j];
            }
        }
    }
    for i in 0..N {
        let known: f64 = (0..i).map(|k| m[i][k] * right[k]).sum();
        right[i] = (right[i] - known) / m[i][i];
    }
    for i in (0..N).rev() {
        let known: f64 = (i + 1..N).map(|k| m[k][i] * right[k]).sum();
        right[i] = (right[i] - known) / m[i][i];
    }
    Some(right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_math::Quat;

    #[test]
    fn a_box_has_the_axes_it_was_turned_by() {
        let turn = Quat::from_euler(bevy_math::EulerRot::XYZ, 0.4, -1.1, 2.3);
        let corner = |i: usize| {
            let side = |bit: usize, half: f32| if i >> bit & 1 == 0 { -half } else { half };
            let point = Vec3::new(side(0, 1.0), side(1, 3.0), side(2, 2.0));
            SurfacePoint { point: turn * point + Vec3::new(5.0, -2.0, 1.0), area: 0.5 }
        };
        let points: Vec<_> = (0..8).map(corner).collect();
        let Cloud { mean, axes } = Cloud::of(&points).unwrap();
        assert!(mean.distance(Vec3::new(5.0, -2.0, 1.0)) < 1e-5);
        for (axis, expected) in axes.into_iter().zip([Vec3::Y, Vec3::Z, Vec3::X]) {
            assert!(axis.dot(turn * expected).abs() > 1.0 - 1e-6, "{axis}");
        }
        assert!(Cloud::of(&[]).is_none());
    }

    #[test]
    fn systems_are_solved_and_others_refused() {
        let m = [[4.0, 2.0, -1.0], [2.0, 5.0, 0.5], [-1.0, 0.5, 3.0]];
        let x = [0.3, -2.0, 1.5];
        let right = m.map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum());
        let found = solve(m, right).unwrap();
        assert!(found.iter().zip(x).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        assert_eq!(solve([[1.0, 2.0], [2.0, 1.0]], [1.0, 1.0]), None);
        assert_eq!(solve([[f64::NAN]], [1.0]), None);
    }
}
