//! A rest shape as points, triangles and normals.

use bevy::math::{UVec2, Vec3};
use bevy_drape_core::surface::{Binding, GridNormals, GroupSums, NormalGroups};

use crate::error::problems::GridProblem;
use crate::mesh::intake::{Connection, MeshShape};
use crate::mesh::rest_shape::{RestShape, sheet_points};

/// The particles of a rest shape, the triangles between them, and their normals.
pub(crate) struct Faces {
    pub points: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    pub normals: Vec<[f32; 3]>,
    /// Columns and rows, or why there are none.
    pub grid: Result<UVec2, GridProblem>,
}

impl Faces {
    pub fn of(rest: &RestShape) -> Self {
        match rest {
            RestShape::Sheet { size, particles } => {
                Self::of_grid(sheet_points(*size, *particles), *particles)
            }
            RestShape::Mesh(shape) => Self::of_mesh(shape),
        }
    }

    pub fn of_mesh(shape: &MeshShape) -> Self {
        let points = shape.positions.clone();
        match &shape.connection {
            Connection::Grid { rows, columns } => {
                Self::of_grid(points, UVec2::new(*columns as u32, *rows as u32))
            }
            Connection::Triangles(triangles) => {
                Self::new(points, triangles.clone(), shape.intake.grid)
            }
        }
    }

    fn of_grid(points: Vec<Vec3>, particles: UVec2) -> Self {
        Self::new(points, grid_triangles(particles), Ok(particles))
    }

    fn new(points: Vec<Vec3>, triangles: Vec<[u32; 3]>, grid: Result<UVec2, GridProblem>) -> Self {
        let normals = vec![[0.0; 3]; points.len()];
        let mut faces = Self { points, triangles, normals, grid };
        faces.update_normals();
        faces
    }

    /// Works the normals out anew, where the points are elsewhere.
    pub fn update_normals(&mut self) {
        let Self { points, triangles, normals, grid } = self;
        match grid {
            Ok(particles) => GridNormals::new(particles.x as usize).write(points, None, normals),
            Err(_) => {
                let each: Vec<_> = (0..points.len() as u32).collect();
                let groups = NormalGroups::new(&each, points.len(), None, triangles);
                groups.write(points, &mut GroupSums::default(), normals);
            }
        }
    }

    /// Its points on the triangles of another.
    pub fn onto(&self, carrier: &Self) -> Binding {
        let Self { triangles, points, normals, .. } = carrier;
        Binding::new(&self.points, &self.normals, triangles, points, normals)
    }

    /// The longest side \[m\].
    pub fn size(&self) -> f32 {
        let around = |(min, max): (Vec3, Vec3), p: &Vec3| (min.min(*p), max.max(*p));
        let (min, max) = self.points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), around);
        (max - min).max_element()
    }
}

/// The triangles of rows and columns, facing +y where columns go along +x and rows along +z. Cells are split along alternating diagonals, so
/// that no direction is favoured.
pub(crate) fn grid_triangles(particles: UVec2) -> Vec<[u32; 3]> {
    let (columns, rows) = (particles.x, particles.y);
    let cells = (0..rows - 1).flat_map(|r| (0..columns - 1).map(move |c| (r, c)));
    let split = |(r, c): (u32, u32)| {
        let a = r * columns + c;
        let (b, c2, d) = (a + 1, a + columns, a + columns + 1);
        if (r + c).is_multiple_of(2) { [[a, c2, b], [b, c2, d]] } else { [[a, c2, d], [a, d, b]] }
    };
    cells.flat_map(split).collect()
}
