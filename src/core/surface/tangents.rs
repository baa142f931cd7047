//! Tangents that turn with the cloth, so that a normal map is lit as it is folded.

use bevy_math::{Vec2, Vec3};

/// Least doubled area of a triangle that tells a direction, over the square of its longest edge.
const LEAST_AREA: f32 = 1e-6;

/// Each vertex's tangent as it was loaded, in the edges of the triangles around it: where these go, it goes. What
/// the modelling program made of its UVs is kept as it is.
#[derive(Debug)]
pub struct Tangents {
    /// The vertices of a triangle, and for each of them its tangent's part along both edges from the first.
    triangles: Vec<([u32; 3], [Vec2; 3])>,
    sums: Vec<Vec3>,
}

impl Tangents {
    /// The tangents of a mesh's vertices, at the places where they were loaded; `corners` are its triangles'
    /// vertices, three by three. Triangles with a corner beyond the vertices, or without an area, are left out.
    pub fn new(places: &[[f32; 3]], tangents: &[[f32; 4]], corners: &[u32]) -> Self {
        let is_known = |&corner: &u32| (corner as usize) < places.len().min(tangents.len());
        let (corners, _) = corners.as_chunks::<3>();
        let triangles = corners.iter().filter(|corners| corners.iter().all(is_known));
        let triangles = triangles.filter_map(|&corners| {
            let [a, b, c] = corners.map(|corner| Vec3::from(places[corner as usize]));
            let (e, f) = (b - a, c - a);
            let (ee, ef, ff) = (e.dot(e), e.dot(f), f.dot(f));
            let area = ee * ff - ef * ef;
            let parts = corners.map(|corner| {
                let [x, y, z, _] = tangents[corner as usize];
                let (te, tf) = (e.dot(Vec3::new(x, y, z)), f.dot(Vec3::new(x, y, z)));
                // Least squares: what is out of the triangle's plane is left out.
                Vec2::new(ff * te - ef * tf, ee * tf - ef * te) / area
            });
            let is_one = area > LEAST_AREA * ee.max(ff).powi(2);
            (is_one && parts.iter().all(|part| part.is_finite())).then_some((corners, parts))
        });
        Self { triangles: triangles.collect(), sums: Vec::new() }
    }

    /// Writes them, for vertices at their places and with their normals.
    ///
    /// # Panics
    /// If there are fewer vertices than it was made for.
    pub fn write(&mut self, places: &[[f32; 3]], normals: &[[f32; 3]], out: &mut [[f32; 4]]) {
        self.sums.clear();
        self.sums.resize(out.len(), Vec3::ZERO);
        for (corners, parts) in &self.triangles {
            let [a, b, c] = corners.map(|corner| Vec3::from(places[corner as usize]));
            for (&corner, part) in corners.iter().zip(parts) {
                self.sums[corner as usize] += part.x * (b - a) + part.y * (c - a);
            }
        }
        for ((out, &sum), normal) in out.iter_mut().zip(&self.sums).zip(normals) {
            let normal = Vec3::from(*normal);
            // What has no direction keeps the one that it had.
            if let Some(tangent) = (sum - normal * normal.dot(sum)).try_normalize() {
                *out = tangent.extend(out[3]).to_array();
            }
        }
    }
}
