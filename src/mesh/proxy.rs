//! A coarse shape that is simulated in the place of a fine one that is drawn.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use bevy::math::{UVec2, Vec3};
use bevy_drape_core::surface::{Binding, Bond, NormalGroups};

use crate::error::proxy::ProxyProblem;
use crate::mesh::faces::{Faces, grid_triangles};
use crate::mesh::intake::{ClothIntake, Connection, MeshShape, NormalPlan};
use crate::mesh::raw::RawMesh;
use crate::mesh::rest_shape::RestShape;

/// The part of the drawn shape's size that a vertex may be away from what is simulated.
const FURTHEST: f32 = 0.25;

/// The shape that is drawn, and the one that carries it.
#[derive(Debug)]
pub(crate) struct Proxy {
    pub drawn: RestShape,
    pub simulated: Arc<MeshShape>,
    /// The particles of `drawn` on the triangles of `simulated`.
    pub binding: Binding,
    /// The particles of `simulated` on the triangles of `drawn`.
    back: Binding,
}

/// How a coarse shape is made.
#[derive(Debug)]
pub(crate) enum Coarse {
    /// Columns and rows.
    Grid(UVec2),
    /// A part of the particles.
    Ratio(f32),
    /// A mesh that was made for it, and its fingerprint.
    Mesh(RawMesh, u64),
}

/// Tells proxies apart.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct ProxyKey {
    drawn: DrawnKey,
    how: HowKey,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum DrawnKey {
    Sheet([u32; 2], UVec2),
    Mesh(u64),
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum HowKey {
    Grid(UVec2),
    Ratio(u32),
    Mesh(u64),
}

impl ProxyKey {
    pub fn new(drawn: &RestShape, coarse: &Coarse) -> Self {
        let drawn = match drawn {
            RestShape::Sheet { size, particles } => {
                DrawnKey::Sheet(size.to_array().map(f32::to_bits), *particles)
            }
            RestShape::Mesh(shape) => DrawnKey::Mesh(shape.fingerprint),
        };
        let how = match coarse {
            Coarse::Grid(particles) => HowKey::Grid(*particles),
            Coarse::Ratio(ratio) => HowKey::Ratio(ratio.to_bits()),
            Coarse::Mesh(_, fingerprint) => HowKey::Mesh(*fingerprint),
        };
        Self { drawn, how }
    }

    /// Tells the simulated shape from others.
    fn fingerprint(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.hash(&mut hasher);
        hasher.finish()
    }
}

impl Proxy {
    /// # Errors
    /// [`ProxyProblem`] where the coarse shape cannot be made of the drawn one, or not carry it.
    pub fn new(drawn: RestShape, coarse: Coarse, key: ProxyKey) -> Result<Self, ProxyProblem> {
        let fine = Faces::of(&drawn);
        let simplified = match &coarse {
            Coarse::Ratio(ratio) => Some(*ratio),
            _ => None,
        };
        let raw = match coarse {
            Coarse::Grid(particles) => {
                let columns_and_rows = fine.grid.map_err(ProxyProblem::NotAGrid)?;
                resampled(&fine, columns_and_rows, particles)?
            }
            Coarse::Ratio(ratio) => reduced(&fine, ratio)?,
            Coarse::Mesh(raw, _) => RawMesh { normals: None, colors: None, ..raw },
        };
        let simulated = MeshShape::new(raw, key.fingerprint()).map_err(ProxyProblem::Mesh)?;
        if let (Some(_), RestShape::Mesh(whole)) = (simplified, &drawn) {
            let (from, got) = (whole.intake.pieces, simulated.intake.pieces);
            if got < from {
                return Err(ProxyProblem::LostParts { from, got });
            }
        }
        let faces = Faces::of_mesh(&simulated);
        let binding = fine.onto(&faces);
        let (size, (particle, distance)) = (fine.size(), binding.furthest());
        if distance > FURTHEST * size {
            return Err(match simplified {
                Some(ratio) => ProxyProblem::TooSimple { ratio, particle, distance, size },
                None => ProxyProblem::TooFar { particle, distance, size },
            });
        }
        let stand_ins: Vec<_> = binding.bonds().iter().map(strongest).collect();
        let back = faces.onto(&fine);
        let sources: Vec<_> = back.bonds().iter().map(strongest).collect();
        let simulated = Arc::new(standing_for(simulated, &drawn, &stand_ins, &sources));
        Ok(Self { drawn, simulated, binding, back })
    }

    /// The particles of one of its two shapes on the triangles of the other.
    pub fn between(&self, new: &RestShape, old: &RestShape) -> Option<&Binding> {
        let is_simulated =
            |it: &RestShape| matches!(it, RestShape::Mesh(it) if Arc::ptr_eq(it, &self.simulated));
        if new.is(&self.drawn) && is_simulated(old) {
            Some(&self.binding)
        } else {
            (is_simulated(new) && old.is(&self.drawn)).then_some(&self.back)
        }
    }
}

/// The corner that a point is nearest to.
fn strongest(bond: &Bond) -> u32 {
    let corners = bond.corners.into_iter().zip(bond.weights);
    // Of equal ones the first.
    let most = corners.reduce(|most, next| if next.1 > most.1 { next } else { most });
    most.map_or(0, |(corner, _)| corner)
}

/// A shape whose vertices are those of another, which is drawn. `stand_ins` are the particles that those of the drawn shape stand for,
/// `sources` those of the drawn shape that tell of each particle.
fn standing_for(
    shape: MeshShape,
    drawn: &RestShape,
    stand_ins: &[u32],
    sources: &[u32],
) -> MeshShape {
    let (particles, unused, colors): (&dyn Fn(usize) -> usize, _, _) = match drawn {
        RestShape::Sheet { .. } => (&|vertex| vertex, Box::default(), None),
        RestShape::Mesh(fine) => (
            &|vertex| fine.particle_of_vertex[vertex] as usize,
            fine.unused.clone(),
            fine.colors.clone(),
        ),
    };
    let vertices = drawn.vertex_count();
    let mut vertices_of = vec![Vec::new(); drawn.particle_count()];
    for (vertex, particle) in drawn.used_vertices() {
        vertices_of[particle].push(vertex as u32);
    }
    let told = (0..).zip(sources).flat_map(|(particle, &source)| {
        vertices_of[source as usize].iter().map(move |&vertex| (vertex, particle))
    });
    let count = shape.positions.len();
    let normals = match &shape.connection {
        &Connection::Grid { columns, .. } => NormalPlan::Grid { columns, vertex_of_particle: None },
        Connection::Triangles(triangles) => {
            let each: Vec<_> = (0..count as u32).collect();
            NormalPlan::Groups(NormalGroups::new(&each, count, None, triangles))
        }
    };
    MeshShape {
        particle_of_vertex: (0..vertices).map(|vertex| stand_ins[particles(vertex)]).collect(),
        told_by: Some(told.collect()),
        intake: ClothIntake { vertices, unused_vertices: unused.len(), ..shape.intake },
        unused,
        colors,
        normals,
        ..shape
    }
}

/// The same surface with other columns and rows.
fn resampled(fine: &Faces, drawn: UVec2, asked: UVec2) -> Result<RawMesh, ProxyProblem> {
    if asked.cmplt(UVec2::splat(2)).any() || asked.cmpgt(drawn).any() {
        return Err(ProxyProblem::Grid { asked, drawn });
    }
    let at = |column: u32, row: u32| fine.points[(row * drawn.x + column) as usize];
    // The cell that a column or row lies in, and its part of the way through it.
    let cell = |i: u32, asked: u32, drawn: u32| {
        let place = i * (drawn - 1);
        let first = (place / (asked - 1)).min(drawn - 2);
        (first, (place - first * (asked - 1)) as f32 / (asked - 1) as f32)
    };
    let place = |i: u32| {
        let (column, u) = cell(i % asked.x, asked.x, drawn.x);
        let (row, v) = cell(i / asked.x, asked.y, drawn.y);
        let upper = at(column, row).lerp(at(column + 1, row), u);
        upper.lerp(at(column, row + 1).lerp(at(column + 1, row + 1), u), v)
    };
    let positions = (0..asked.x * asked.y).map(place).collect();
    Ok(RawMesh { positions, triangles: grid_triangles(asked), normals: None, colors: None })
}

/// The same surface with a part of its particles.
fn reduced(fine: &Faces, ratio: f32) -> Result<RawMesh, ProxyProblem> {
    if !(ratio > 0.0 && ratio <= 1.0) {
        return Err(ProxyProblem::Ratio(ratio));
    }
    match fine.grid {
        Ok(drawn) => {
            let fewer = |side: u32| (((side - 1) as f32 * ratio.sqrt()).round() as u32 + 1).max(2);
            resampled(fine, drawn, UVec2::new(fewer(drawn.x), fewer(drawn.y)))
        }
        Err(_) => Ok(used_only(&fine.points, &simplify(fine, ratio)?)),
    }
}

/// The triangles of a mesh that has about this part of the particles: some of those, and no others.
#[cfg(feature = "simplify")]
fn simplify(fine: &Faces, ratio: f32) -> Result<Vec<[u32; 3]>, ProxyProblem> {
    use meshopt::SimplifyOptions;
    let corners = fine.triangles.as_flattened();
    let points: Vec<_> = fine.points.iter().map(Vec3::to_array).collect();
    // Triangles of one size bend and stretch alike; how far the surface goes from the drawn one is measured afterwards.
    let (regular, any_error) = (SimplifyOptions::Regularize, f32::MAX);
    let wanted = (fine.triangles.len() as f32 * ratio).ceil() as usize * 3;
    let left = meshopt::simplify_decoder(corners, &points, wanted, any_error, regular, None);
    let (triangles, _) = left.as_chunks();
    Ok(triangles.to_vec())
}

#[cfg(not(feature = "simplify"))]
fn simplify(_: &Faces, _: f32) -> Result<Vec<[u32; 3]>, ProxyProblem> {
    Err(ProxyProblem::NoSimplifier)
}

/// Triangles and the points that they use.
fn used_only(points: &[Vec3], triangles: &[[u32; 3]]) -> RawMesh {
    let mut number = vec![u32::MAX; points.len()];
    let mut positions = Vec::new();
    let mut renumbered = |corner: u32| {
        let number = &mut number[corner as usize];
        if *number == u32::MAX {
            *number = positions.len() as u32;
            positions.push(points[corner as usize]);
        }
        *number
    };
    let triangles = triangles.iter().map(|it| it.map(&mut renumbered)).collect();
    RawMesh { positions, triangles, normals: None, colors: None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Vec2;

    #[test]
    fn both_ways_between_its_shapes_are_as_if_made_for_them() {
        let sheet = |side| RestShape::Sheet { size: Vec2::ONE, particles: UVec2::splat(side) };
        let coarse = || Coarse::Grid(UVec2::splat(5));
        let drawn = sheet(9);
        let key = ProxyKey::new(&drawn, &coarse());
        let proxy = Proxy::new(drawn.clone(), coarse(), key).unwrap();
        let simulated = RestShape::Mesh(proxy.simulated.clone());
        for (new, old) in [(&drawn, &simulated), (&simulated, &drawn)] {
            let kept = proxy.between(new, old).unwrap().bonds();
            assert_eq!(kept, Faces::of(new).onto(&Faces::of(old)).bonds());
        }
        assert!(proxy.between(&drawn, &drawn).is_none());
        assert!(proxy.between(&simulated, &sheet(8)).is_none());
    }
}
