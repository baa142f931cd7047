//! The mesh as a closed surface: welded, checked, with its normals.

use super::{BakeError, triangle::Triangle};
use bevy_math::{DVec3, Vec3, ops};
use bevy_platform::collections::HashMap;

/// A closed, consistently oriented triangle mesh.
///
/// Half-edge `3 t + k` runs along triangle `t` from its corner `k` to the next.
pub(super) struct ClosedMesh {
    pub(super) min: Vec3,
    pub(super) max: Vec3,
    /// 1, or -1 if the whole mesh is wound inside out.
    pub(super) orientation: f64,
    points: Vec<DVec3>,
    /// Points of each triangle.
    corners: Vec<[u32; 3]>,
    /// The same edge in the neighbouring triangle.
    twins: Vec<u32>,
    /// Unit normals; zero where a triangle has no area.
    face_normals: Vec<DVec3>,
    vertex_normals: Vec<DVec3>,
}

impl ClosedMesh {
    pub(super) fn new(positions: &[Vec3], indices: &[u32]) -> Result<Self, BakeError> {
        check_input(positions, indices)?;
        let (points, corners) = weld(positions, indices);
        let twins = pair_edges(&corners)?;

        let mut mesh = Self {
            min: Vec3::INFINITY,
            max: Vec3::NEG_INFINITY,
            orientation: 1.0,
            points,
            corners,
            twins,
            face_normals: Vec::new(),
            vertex_normals: Vec::new(),
        };
        for point in &mesh.points {
            mesh.min = mesh.min.min(point.as_vec3());
            mesh.max = mesh.max.max(point.as_vec3());
        }
        mesh.orientation = mesh.orient()?;
        mesh.face_normals =
            mesh.corners.iter().map(|&corners| face_normal(mesh.positions(corners))).collect();
        mesh.vertex_normals = mesh.weigh_vertex_normals();
        Ok(mesh)
    }

    /// The triangles that have an area. The others' points all lie on their neighbours' edges.
    pub(super) fn triangles(&self) -> Vec<Triangle> {
        let with_area = |t: &usize| self.face_normals[*t] != DVec3::ZERO;
        let triangle = |t: usize| {
            Triangle::new(self.positions(self.corners[t]), self.face_normals[t], t as u32)
        };
        (0..self.corners.len()).filter(with_area).map(triangle).collect()
    }

    /// Angle-weighted pseudonormal of a triangle's corner, not normalised.
    pub(super) fn vertex_normal(&self, triangle: u32, corner: usize) -> DVec3 {
        self.vertex_normals[self.corners[triangle as usize][corner] as usize]
    }

    /// Pseudonormal of a triangle's edge, not normalised: the sum of the normals on both sides.
    pub(super) fn edge_normal(&self, triangle: u32, edge: usize) -> DVec3 {
        let half_edge = 3 * triangle as usize + edge;
        self.normal_beside(half_edge) + self.normal_beside(self.twins[half_edge] as usize)
    }

    fn positions(&self, corners: [u32; 3]) -> [DVec3; 3] {
        corners.map(|corner| self.points[corner as usize])
    }

    /// Sense of the winding, from the sign of the enclosed volume.
    fn orient(&self) -> Result<f64, BakeError> {
        let extent = (self.max.as_dvec3() - self.min.as_dvec3()).length();
        let from = self.min.as_dvec3();
        let mut six_volumes = 0.0;
        for &corners in &self.corners {
            let [a, b, c] = self.positions(corners).map(|point| point - from);
            six_volumes += a.dot(b.cross(c));
        }
        // Rounding alone stays far below this share of the box.
        if six_volumes.abs() <= 1.0e-12 * extent * extent * extent {
            return Err(BakeError::NoVolume);
        }
        Ok(six_volumes.signum())
    }

    /// Normal of the surface on one side of an edge.
    ///
    /// A triangle without area is a line: one long edge lying on two short ones. What the surface does
    /// beside one of its edges is what it does across the opposite side of that line.
    fn normal_beside(&self, half_edge: usize) -> DVec3 {
        let triangle = half_edge / 3;
        let normal = self.face_normals[triangle];
        if normal != DVec3::ZERO {
            return normal;
        }
        let across = |k: usize| self.face_normals[self.twins[3 * triangle + k] as usize / 3];
        let long = self.longest_edge(triangle);
        if half_edge % 3 == long {
            (across((long + 1) % 3) + across((long + 2) % 3)).normalize_or_zero()
        } else {
            across(long)
        }
    }

    fn longest_edge(&self, triangle: usize) -> usize {
        let p = self.positions(self.corners[triangle]);
        let squared = [0, 1, 2].map(|k| p[k].distance_squared(p[(k + 1) % 3]));
        let longer = |a: usize, b: usize| if squared[b] > squared[a] { b } else { a };
        longer(longer(0, 1), 2)
    }

    fn weigh_vertex_normals(&self) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; self.points.len()];
        for (t, &corners) in self.corners.iter().enumerate() {
            let p = self.positions(corners);
            let normal = if self.face_normals[t] == DVec3::ZERO {
                let long = self.longest_edge(t);
                self.face_normals[self.twins[3 * t + long] as usize / 3]
            } else {
                self.face_normals[t]
            };
            for k in 0..3 {
                let angle = angle_between(p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
                normals[corners[k] as usize] += angle * normal;
            }
        }
        normals
    }
}

fn check_input(positions: &[Vec3], indices: &[u32]) -> Result<(), BakeError> {
    if indices.is_empty() {
        return Err(BakeError::Empty);
    }
    if !indices.len().is_multiple_of(3) {
        return Err(BakeError::PartialTriangle { index_count: indices.len() });
    }
    for &index in indices {
        let Some(position) = positions.get(index as usize) else {
            return Err(BakeError::IndexOutOfRange { index, vertex_count: positions.len() });
        };
        if !position.is_finite() {
            return Err(BakeError::NonFinite { index });
        }
    }
    Ok(())
}

/// Gives vertices at the same position one number, and drops triangles that use one twice.
fn weld(positions: &[Vec3], indices: &[u32]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut points = Vec::new();
    let mut numbers = HashMap::new();
    let mut number = |index: u32| {
        // Adding zero makes the negative zero positive.
        let position = positions[index as usize] + Vec3::ZERO;
        *numbers.entry(position.to_array().map(f32::to_bits)).or_insert_with(|| {
            points.push(position.as_dvec3());
            points.len() as u32 - 1
        })
    };
    let (triples, _) = indices.as_chunks::<3>();
    let corners = triples
        .iter()
        .map(|triple| triple.map(&mut number))
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    (points, corners)
}

/// Finds each half-edge's twin: the one that runs the other way along the same two points.
fn pair_edges(corners: &[[u32; 3]]) -> Result<Vec<u32>, BakeError> {
    let mut half_edges = Vec::with_capacity(3 * corners.len());
    for (t, triangle) in corners.iter().enumerate() {
        for k in 0..3 {
            let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
            half_edges.push(((from.min(to), from.max(to)), from < to, (3 * t + k) as u32));
        }
    }
    half_edges.sort_unstable();

    let mut twins = vec![0; half_edges.len()];
    let (mut open_edges, mut crowded, mut same_way) = (0, 0, 0);
    for edge in half_edges.chunk_by(|a, b| a.0 == b.0) {
        match edge {
            [_] => open_edges += 1,
            [(_, forward, _), (_, also_forward, _)] if forward == also_forward => same_way += 1,
            [(_, _, one), (_, _, other)] => {
                twins[*one as usize] = *other;
                twins[*other as usize] = *one;
            }
            _ => crowded += 1,
        }
    }
    match (open_edges, crowded, same_way) {
        (0, 0, 0) if corners.is_empty() => Err(BakeError::NoVolume),
        (0, 0, 0) => Ok(twins),
        (0, 0, edges) => Err(BakeError::Inconsistent { edges }),
        (0, edges, _) => Err(BakeError::NonManifold { edges }),
        (open_edges, _, _) => Err(BakeError::NotClosed { open_edges }),
    }
}

/// Unit normal, or zero if the triangle is so thin that it has none in `f32` coordinates.
fn face_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    const THINNEST: f64 = 1.0e-10;
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let cross = ab.cross(ac);
    let longest_squared = ab.length_squared().max(ac.length_squared()).max(bc.length_squared());
    if cross.length() <= THINNEST * longest_squared {
        DVec3::ZERO
    } else {
        cross.normalize_or_zero()
    }
}

/// Angle between two edges \[rad\]. A weight: `f32` is enough, and the same on every platform.
fn angle_between(u: DVec3, v: DVec3) -> f64 {
    let (u, v) = (u.normalize_or_zero(), v.normalize_or_zero());
    f64::from(ops::atan2(u.cross(v).length() as f32, u.dot(v) as f32))
}
