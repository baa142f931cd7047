//! Writes the positions, normals and tangents of a cloth's mesh, in place.

use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use bevy_drape_core::surface::Tangents;

use crate::error::problems::MeshProblem;
use crate::mesh::drawn::ClothMesh;
use crate::mesh::intake::NormalPlan;
use crate::mesh::rest_shape::RestShape;

/// Writes all that is drawn.
///
/// # Errors
/// [`MeshProblem::Changed`] where the mesh is no longer as it was made.
pub(super) fn write(own: &mut ClothMesh, meshes: &mut Assets<Mesh>) -> Result<(), MeshProblem> {
    let mut mesh = meshes.get_mut(&own.handle).ok_or(MeshProblem::Changed)?;
    let count = own.rest.vertex_count();
    // Looked at first: the asset counts as modified as soon as it is borrowed mutably.
    for attribute in [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL] {
        let values = mesh.try_attribute_option(attribute)?.ok_or(MeshProblem::Changed)?;
        if values.len() != count || !matches!(values, VertexAttributeValues::Float32x3(_)) {
            return Err(MeshProblem::Changed);
        }
    }
    let mesh = &mut *mesh;
    if own.tangents.is_none() {
        let is_sheet = matches!(own.rest, RestShape::Sheet { .. });
        let tangents = if is_sheet { None } else { take_tangents(mesh).map(Box::new) };
        own.tangents = Some(tangents);
    }
    if let VertexAttributeValues::Float32x3(out) =
        mesh.try_attribute_mut(Mesh::ATTRIBUTE_POSITION)?
    {
        write_positions(own, out);
    }
    if let VertexAttributeValues::Float32x3(out) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_NORMAL)? {
        write_normals(own, out);
    }
    if let Some(Some(tangents)) = &mut own.tangents {
        write_tangents(tangents, mesh)?;
    }
    own.written.copy_from_slice(&own.points);
    Ok(())
}

/// The tangents of a mesh that has not been written yet; `None` where it has none, or none that can be used.
fn take_tangents(mesh: &Mesh) -> Option<Tangents> {
    if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
        return None;
    }
    let attribute = |which| mesh.try_attribute_option(which).ok().flatten();
    let VertexAttributeValues::Float32x4(tangents) = attribute(Mesh::ATTRIBUTE_TANGENT)? else {
        return None;
    };
    let VertexAttributeValues::Float32x3(places) = attribute(Mesh::ATTRIBUTE_POSITION)? else {
        return None;
    };
    let corners: Vec<u32> = match mesh.try_indices_option().ok()? {
        Some(Indices::U16(indices)) => indices.iter().map(|&index| index.into()).collect(),
        Some(Indices::U32(indices)) => indices.clone(),
        None => (0..places.len() as u32).collect(),
    };
    Some(Tangents::new(places, tangents, &corners))
}

fn write_tangents(tangents: &mut Tangents, mesh: &mut Mesh) -> Result<(), MeshProblem> {
    // Taken out, to be written while positions and normals are read.
    let Ok(VertexAttributeValues::Float32x4(mut out)) =
        mesh.try_remove_attribute(Mesh::ATTRIBUTE_TANGENT)
    else {
        return Err(MeshProblem::Changed);
    };
    let read = |which| match mesh.try_attribute_option(which)? {
        Some(VertexAttributeValues::Float32x3(values)) => Ok(values),
        _ => Err(MeshProblem::Changed),
    };
    let (places, normals) = (read(Mesh::ATTRIBUTE_POSITION)?, read(Mesh::ATTRIBUTE_NORMAL)?);
    if out.len() == places.len() {
        tangents.write(places, normals, &mut out);
    }
    mesh.try_insert_attribute(Mesh::ATTRIBUTE_TANGENT, out)?;
    Ok(())
}

fn write_positions(own: &ClothMesh, out: &mut [[f32; 3]]) {
    match &own.rest {
        RestShape::Sheet { .. } => {
            for (out, point) in out.iter_mut().zip(&own.points) {
                *out = point.to_array();
            }
        }
        RestShape::Mesh(shape) => {
            for (out, &particle) in out.iter_mut().zip(&shape.particle_of_vertex) {
                *out = own.points[particle as usize].to_array();
            }
        }
    }
}

fn write_normals(own: &mut ClothMesh, out: &mut [[f32; 3]]) {
    let ClothMesh { rest, points, cells, sums, .. } = own;
    match rest {
        RestShape::Sheet { .. } => {
            cells.write(points, None, out);
        }
        RestShape::Mesh(shape) => match &shape.normals {
            NormalPlan::Grid { vertex_of_particle, .. } => {
                cells.write(points, vertex_of_particle.as_deref(), out);
            }
            NormalPlan::Groups(groups) => groups.write(points, sums, out),
        },
    }
}
