//! Linear blend skinning on the CPU: where the vertices of a skinned mesh are, by the formula that GPUs take.

use bevy_math::{Affine3A, Mat3A, Vec3, Vec3A};

/// The joints that a point of a skinned mesh follows: up to four, and how much of each.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Influences {
    /// Indices of joints.
    pub joints: [u16; 4],
    /// Their weights \[1\], of which the sum is one. A joint of weight 0 is not followed.
    pub weights: [f32; 4],
}

impl Influences {
    /// Where the point's joints take it: the weighted sum of their matrices.
    ///
    /// # Panics
    /// If a joint is beyond the matrices.
    #[inline]
    pub fn blend(&self, joints: &[Affine3A]) -> Affine3A {
        let mut sum = Affine3A { matrix3: Mat3A::ZERO, translation: Vec3A::ZERO };
        for (joint, weight) in self.joints.into_iter().zip(self.weights) {
            if weight == 0.0 {
                continue;
            }
            let joint = &joints[joint as usize];
            sum.matrix3.x_axis += joint.matrix3.x_axis * weight;
            sum.matrix3.y_axis += joint.matrix3.y_axis * weight;
            sum.matrix3.z_axis += joint.matrix3.z_axis * weight;
            sum.translation += joint.translation * weight;
        }
        sum
    }
}

/// Calls `act` with the place of each point, when joints are where these matrices take them from the points' own frame.
///
/// # Panics
/// As [`Influences::blend`].
pub fn skin(
    points: &[Vec3],
    influences: &[Influences],
    joints: &[Affine3A],
    mut act: impl FnMut(usize, Vec3),
) {
    for (index, (point, influences)) in points.iter().zip(influences).enumerate() {
        act(index, influences.blend(joints).transform_point3(*point));
    }
}

/// The same with the normal there, of length one; zero where the joints leave none.
///
/// # Panics
/// As [`Influences::blend`].
pub fn skin_with_normals(
    points: &[Vec3],
    normals: &[Vec3],
    influences: &[Influences],
    joints: &[Affine3A],
    mut act: impl FnMut(usize, Vec3, Vec3),
) {
    let points = points.iter().zip(normals).zip(influences).enumerate();
    for (index, ((point, normal), influences)) in points {
        let blend = influences.blend(joints);
        // A normal goes by the inverse transpose; the cofactors are that but for a factor, whose sign is the determinant's.
        let Mat3A { x_axis, y_axis, z_axis } = blend.matrix3;
        let (yz, zx, xy) = (y_axis.cross(z_axis), z_axis.cross(x_axis), x_axis.cross(y_axis));
        let turned = yz * normal.x + zx * normal.y + xy * normal.z;
        let sign = x_axis.dot(yz).signum();
        act(index, blend.transform_point3(*point), (turned * sign).normalize_or_zero().into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_math::{Mat4, Quat};

    /// A joint that turns, shifts and scales by other amounts for each `k`.
    fn joint(k: f32) -> Affine3A {
        let turn = Quat::from_rotation_y(0.3 * k) * Quat::from_rotation_x(-0.2 * k);
        let scale = Vec3::splat(1.0 + 0.1 * k);
        Affine3A::from_scale_rotation_translation(scale, turn, Vec3::new(k, -0.5 * k, 2.0))
    }

    #[test]
    fn points_are_where_the_sum_of_matrices_takes_them() {
        let joints: Vec<_> = (0..5).map(|k| joint(k as f32)).collect();
        let influences = [
            Influences { joints: [4, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] },
            Influences { joints: [1, 2, 3, 4], weights: [0.4, 0.3, 0.2, 0.1] },
            // What has no weight is not looked at.
            Influences { joints: [0, 3, 900, 900], weights: [0.5, 0.5, 0.0, 0.0] },
        ];
        let points = [Vec3::new(0.1, 0.7, -0.3), Vec3::new(1.0, 2.0, 3.0), Vec3::Y];
        let mut seen = 0;
        skin(&points, &influences, &joints, |i, place| {
            // As shaders have it: matrices of four columns.
            let sum = influences[i].joints.iter().zip(influences[i].weights);
            let used = sum.filter(|(_, weight)| *weight > 0.0);
            let matrix = used.fold(Mat4::ZERO, |sum, (joint, weight)| {
                sum + Mat4::from(joints[*joint as usize]) * weight
            });
            let expected = (matrix * points[i].extend(1.0)).truncate();
            assert!(place.distance(expected) < 1e-6, "{place} {expected}");
            seen += 1;
        });
        assert_eq!(seen, 3);
    }

    #[test]
    fn normals_stay_square_to_the_surface() {
        // Uneven, sheared and mirrored: what is square before is square after, on the side that goes outwards.
        let sheared = Mat3A::from_cols(
            Vec3A::new(1.0, 0.2, 0.0),
            Vec3A::new(0.3, 2.0, 0.1),
            Vec3A::new(0.0, -0.4, 0.5),
        );
        let mirrored = Mat3A::from_diagonal(Vec3::new(-1.0, 1.0, 3.0));
        for matrix3 in [sheared, mirrored] {
            let joints = [Affine3A { matrix3, translation: Vec3A::X }];
            let influences = [Influences { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] }];
            let (normal, along) = (Vec3::new(0.6, 0.8, 0.0), [Vec3::new(-0.8, 0.6, 0.0), Vec3::Z]);
            let look = |_, _, turned: Vec3| {
                assert!((turned.length() - 1.0).abs() < 1e-6);
                for along in along {
                    assert!(turned.dot((matrix3 * Vec3A::from(along)).into()).abs() < 1e-6);
                }
                assert!(turned.dot((matrix3 * Vec3A::from(normal)).into()) > 0.0);
            };
            skin_with_normals(&[Vec3::ONE], &[normal], &influences, &joints, look);
        }
        let flat = [Affine3A { matrix3: Mat3A::ZERO, translation: Vec3A::ZERO }];
        let influences = [Influences { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] }];
        skin_with_normals(&[Vec3::ONE], &[Vec3::X], &influences, &flat, |_, _, normal| {
            assert_eq!(normal, Vec3::ZERO);
        });
    }
}
