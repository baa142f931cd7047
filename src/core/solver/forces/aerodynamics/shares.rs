//! The mass that takes a face's force.

/// A face at rest.
pub(super) struct Face<const N: usize> {
    /// Slots of its corners.
    pub corners: [usize; N],
    /// \[m2\]
    pub area: f32,
}

/// For each face, the inverse of the area whose mass takes its force \[1/m2\].
///
/// A particle's mass is divided among the faces around it in proportion to their areas, and a face
/// takes as many times the smallest share of its corners as it has corners. So the shares of all
/// faces together are never more than a particle weighs, and if no face's share overshoots the wind,
/// no particle's velocity does in the mean of the squares.
pub(super) fn shares<const N: usize>(faces: &[Face<N>], particle_area: &[f32]) -> Vec<f32> {
    // In f64, where the sum of a few of them is exact, so that it does not depend on their order.
    let mut around = vec![0.0_f64; particle_area.len()];
    for face in faces {
        for &corner in &face.corners {
            around[corner] += f64::from(face.area);
        }
    }
    let share = |face: &Face<N>, corner: usize| {
        f64::from(face.area) / around[corner] * f64::from(particle_area[corner])
    };
    let inverse = |face: &Face<N>| {
        let least = face.corners.iter().map(|&c| share(face, c)).fold(f64::INFINITY, f64::min);
        // A face without area feels nothing.
        if least > 0.0 { (1.0 / (N as f64 * least)).min(f64::from(f32::MAX)) as f32 } else { 0.0 }
    };
    faces.iter().map(inverse).collect()
}
