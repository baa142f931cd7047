//! Area-weighted normals of any triangles: smooth across seams, split where the mesh was split.

use super::normals::unit;
use bevy_math::{Vec3, Vec3A};

/// Cosine of the largest angle, 10 degrees, between two normals that are meant to be one. Both
/// sides of a UV seam differ by rounding, both sides of a hard edge by more than this.
const SAME: f32 = 0.984_807_7;

/// Works out the normals of any triangles: vertices of one particle that share a normal are a group.
#[derive(Debug, PartialEq)]
pub struct NormalGroups {
    /// The group of each vertex.
    of_vertex: Box<[u32]>,
    /// The particle of each group.
    particles: Box<[u32]>,
    /// The groups at the corners of each triangle that has three different particles.
    triangles: Box<[[u32; 3]]>,
}

impl NormalGroups {
    /// Groups the vertices of each particle whose normals agree at rest, all of them where the mesh
    /// has no normals. Triangles are of vertices.
    ///
    /// # Panics
    /// If a particle or a vertex is beyond their number, or there are fewer normals than vertices.
    pub fn new(
        particle_of_vertex: &[u32],
        particle_count: usize,
        normals: Option<&[Vec3]>,
        triangles: &[[u32; 3]],
    ) -> Self {
        let mut of_vertex = vec![0; particle_of_vertex.len()];
        let mut particles = Vec::with_capacity(particle_count);
        for (particle, vertices) in by_particle(particle_of_vertex, particle_count).enumerate() {
            let first = particles.len();
            // The vertex that each group of this particle began with.
            let mut leaders = Vec::new();
            for vertex in vertices {
                let agrees = |leader: &u32| {
                    normals.is_none_or(|normals| {
                        agree(normals[*leader as usize], normals[vertex as usize])
                    })
                };
                let at = leaders.iter().position(agrees).unwrap_or_else(|| {
                    leaders.push(vertex);
                    particles.push(particle as u32);
                    leaders.len() - 1
                });
                of_vertex[vertex as usize] = (first + at) as u32;
            }
        }
        let groups = |triangle: &[u32; 3]| triangle.map(|v| of_vertex[v as usize]);
        let has_area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|group| particles[group as usize]);
            a != b && b != c && c != a
        };
        Self {
            triangles: triangles.iter().map(groups).filter(has_area).collect(),
            of_vertex: of_vertex.into(),
            particles: particles.into(),
        }
    }

    /// Writes the normal of every vertex, for particles at these points, in `sums`.
    ///
    /// A normal is the sum of the vector areas of its group's triangles; +y where they cancel.
    ///
    /// # Panics
    /// If there are fewer points than particles.
    pub fn write(&self, points: &[Vec3], sums: &mut GroupSums, out: &mut [[f32; 3]]) {
        let GroupSums { places, sums } = sums;
        places.clear();
        places
            .extend(self.particles.iter().map(|&particle| Vec3A::from(points[particle as usize])));
        sums.clear();
        sums.resize(self.particles.len(), Vec3A::ZERO);
        for &[a, b, c] in &self.triangles {
            let [a, b, c] = [a as usize, b as usize, c as usize];
            let area = (places[b] - places[a]).cross(places[c] - places[a]);
            sums[a] += area;
            sums[b] += area;
            sums[c] += area;
        }
        for sum in &mut *sums {
            *sum = unit(Vec3::from(*sum)).into();
        }
        for (out, &group) in out.iter_mut().zip(&self.of_vertex) {
            *out = sums[group as usize].to_array();
        }
    }
}

/// Room to work out the normals of groups in.
#[derive(Debug, Default)]
pub struct GroupSums {
    /// By group: where it is, and the sum of what its triangles are.
    places: Vec<Vec3A>,
    sums: Vec<Vec3A>,
}

/// Whether two normals, of whatever length, point the same way. What has no direction agrees.
fn agree(a: Vec3, b: Vec3) -> bool {
    let lengths = (a.length_squared() * b.length_squared()).sqrt();
    // Also true for a NaN.
    let apart = a.dot(b) < SAME * lengths;
    !apart
}

/// The vertices of each particle, in ascending order.
fn by_particle(
    particle_of_vertex: &[u32],
    particle_count: usize,
) -> impl Iterator<Item = Vec<u32>> {
    let mut starts = vec![0_u32; particle_count + 1];
    for &particle in particle_of_vertex {
        starts[particle as usize + 1] += 1;
    }
    for particle in 0..particle_count {
        starts[particle + 1] += starts[particle];
    }
    let mut next = starts.clone();
    let mut vertices = vec![0; particle_of_vertex.len()];
    for (vertex, &particle) in particle_of_vertex.iter().enumerate() {
        vertices[next[particle as usize] as usize] = vertex as u32;
        next[particle as usize] += 1;
    }
    (0..particle_count).map(move |p| vertices[starts[p] as usize..starts[p + 1] as usize].to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normals(groups: &NormalGroups, points: &[Vec3], vertices: usize) -> Vec<Vec3> {
        let mut out = vec![[f32::NAN; 3]; vertices];
        groups.write(points, &mut GroupSums::default(), &mut out);
        out.into_iter().map(Vec3::from_array).collect()
    }

    /// Two squares at a right angle along the x axis: 0 1 2 3 on the floor, 4 5 6 7 on the wall, 4 and
    /// 5 where 0 and 1 are.
    fn corner() -> (Vec<Vec3>, Vec<u32>, [[u32; 3]; 4]) {
        let points = vec![
            Vec3::ZERO,
            Vec3::X,
            Vec3::Z,
            Vec3::new(1.0, 0.0, 1.0),
            Vec3::Y,
            Vec3::new(1.0, 1.0, 0.0),
        ];
        let triangles = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [6, 5, 7]];
        (points, vec![0, 1, 2, 3, 0, 1, 4, 5], triangles)
    }

    #[test]
    fn hard_edges_stay_and_seams_go() {
        let (points, particles, triangles) = corner();
        let flat = [Vec3::Y, Vec3::Y, Vec3::Y, Vec3::Y, Vec3::Z, Vec3::Z, Vec3::Z, Vec3::Z];
        let hard = NormalGroups::new(&particles, 6, Some(&flat), &triangles);
        assert_eq!(normals(&hard, &points, 8), flat);
        for rest in [None, Some([Vec3::new(0.0, 0.7, 0.7); 8]), Some([Vec3::NAN; 8])] {
            let rest = rest.as_ref().map(<[Vec3; 8]>::as_slice);
            let smooth = NormalGroups::new(&particles, 6, rest, &triangles);
            let normals = normals(&smooth, &points, 8);
            assert_eq!((normals[0], normals[1]), (normals[4], normals[5]));
            // Vertex 0 has one triangle on the floor and one on the wall.
            assert!(normals[0].distance(Vec3::new(0.0, 1.0, 1.0).normalize()) < 1e-6);
            assert_eq!((normals[3], normals[7]), (Vec3::Y, Vec3::Z));
        }
    }

    #[test]
    fn larger_triangles_weigh_more_and_collapsed_ones_nothing() {
        let (mut points, particles, triangles) = corner();
        points[4] *= 3.0;
        points[5].y *= 3.0;
        let groups = NormalGroups::new(&particles, 6, None, &triangles);
        let expected = Vec3::new(0.0, 1.0, 3.0).normalize();
        assert!(normals(&groups, &points, 8)[0].distance(expected) < 1e-6);
        let nowhere = vec![Vec3::ONE; 6];
        assert!(normals(&groups, &nowhere, 8).iter().all(|n| *n == Vec3::Y));
    }
}
