//! Writes meshes as Wavefront OBJ, by hand: the crates that write it have not been kept for years,
//! and the format is three kinds of lines.

use bevy::{mesh::VertexAttributeValues::Float32x3, prelude::*};
use std::{
    fs::File,
    io::{self, BufWriter, Write},
    path::Path,
};

/// Writes the positions, normals and triangles of a mesh, `to_world`.
///
/// # Errors
/// When the file cannot be written, or the mesh has no such data.
pub(crate) fn write_obj(path: &Path, mesh: &Mesh, to_world: &GlobalTransform) -> io::Result<()> {
    let (Some(Float32x3(positions)), Some(Float32x3(normals)), Some(indices)) = (
        mesh.attribute(Mesh::ATTRIBUTE_POSITION),
        mesh.attribute(Mesh::ATTRIBUTE_NORMAL),
        mesh.indices(),
    ) else {
        return Err(io::Error::other("the mesh has no positions, normals or indices"));
    };
    let mut file = BufWriter::new(File::create(path)?);
    for &position in positions {
        let [x, y, z] = to_world.transform_point(position.into()).to_array();
        writeln!(file, "v {x} {y} {z}")?;
    }
    for &normal in normals {
        let [x, y, z] = (to_world.rotation() * Vec3::from(normal)).to_array();
        writeln!(file, "vn {x} {y} {z}")?;
    }
    let corners: Vec<usize> = indices.iter().map(|vertex| vertex + 1).collect();
    for [a, b, c] in corners.as_chunks().0 {
        writeln!(file, "f {a}//{a} {b}//{b} {c}//{c}")?;
    }
    file.flush()
}
