//! The data that a cloth or a collider reads of a mesh asset: the door, where they are checked.

use std::hash::{BuildHasher, Hasher};

use bevy::math::Vec3;
use bevy::mesh::{Indices, Mesh, PrimitiveTopology, VertexAttributeValues};
use bevy::platform::hash::FixedHasher;

use crate::error::problems::MeshProblem;

/// Largest coordinate of a mesh \[m\].
const FURTHEST: f32 = 1e6;

/// The data of a mesh. Its indices may still be beyond its vertices.
#[derive(Debug)]
pub(crate) struct RawMesh {
    /// Positions in the mesh's own frame \[m\], all of them finite.
    pub positions: Vec<Vec3>,
    /// Three vertices each, counterclockwise as seen from the front.
    pub triangles: Vec<[u32; 3]>,
    pub normals: Option<Vec<Vec3>>,
    /// Colours, 0 to 1 in integer formats.
    pub colors: Option<Box<[[f32; 4]]>>,
}

impl RawMesh {
    /// Reads a list or strip of triangles, with or without indices.
    pub fn read(mesh: &Mesh) -> Result<Self, MeshProblem> {
        let positions = positions(mesh)?;
        if let Some(vertex) = positions.iter().position(|p| !is_near(*p)) {
            return Err(MeshProblem::NonFinite(vertex));
        }
        let triangles = triangles(mesh, positions.len())?;
        let count = positions.len();
        let normals = match mesh.try_attribute_option(Mesh::ATTRIBUTE_NORMAL)? {
            Some(VertexAttributeValues::Float32x3(normals)) if normals.len() == count => {
                Some(normals.iter().map(|n| Vec3::from_array(*n)).collect())
            }
            _ => None,
        };
        let colors = mesh
            .try_attribute_option(Mesh::ATTRIBUTE_COLOR)?
            .and_then(colors)
            .filter(|colors| colors.len() == count);
        Ok(Self { positions, triangles, normals, colors })
    }

    /// Without triangles beyond its vertices.
    pub fn within(mut self) -> Self {
        let count = self.positions.len();
        self.triangles.retain(|it| it.iter().all(|&vertex| (vertex as usize) < count));
        self
    }
}

/// A hash of all that [`RawMesh::read`] reads: meshes of the same hash make the same cloth.
pub(crate) fn fingerprint(mesh: &Mesh) -> Result<u64, MeshProblem> {
    // Fast on long data: a mesh is looked at in each tick until what is made of it is there.
    let mut hasher = FixedHasher.build_hasher();
    for which in [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL, Mesh::ATTRIBUTE_COLOR] {
        if let Some(values) = mesh.try_attribute_option(which)? {
            hasher.write_u64(values.len() as u64);
            hasher.write(values.get_bytes());
        }
        hasher.write_u8(0);
    }
    hasher.write_u8(u8::from(mesh.primitive_topology() == PrimitiveTopology::TriangleStrip));
    match mesh.try_indices_option()? {
        Some(Indices::U16(indices)) => hasher.write(bytemuck::cast_slice(indices)),
        Some(Indices::U32(indices)) => hasher.write(bytemuck::cast_slice(indices)),
        None => {}
    }
    Ok(hasher.finish())
}

fn is_near(position: Vec3) -> bool {
    position.is_finite() && position.abs().max_element() <= FURTHEST
}

fn positions(mesh: &Mesh) -> Result<Vec<Vec3>, MeshProblem> {
    match mesh.try_attribute_option(Mesh::ATTRIBUTE_POSITION)? {
        Some(VertexAttributeValues::Float32x3(positions)) => {
            Ok(positions.iter().map(|p| Vec3::from_array(*p)).collect())
        }
        _ => Err(MeshProblem::NoPositions),
    }
}

/// The formats that Bevy's loaders use.
fn colors(values: &VertexAttributeValues) -> Option<Box<[[f32; 4]]>> {
    match values {
        VertexAttributeValues::Float32x4(colors) => Some(colors.as_slice().into()),
        VertexAttributeValues::Unorm8x4(colors) => {
            Some(colors.iter().map(|color| color.map(|c| f32::from(c) / 255.0)).collect())
        }
        VertexAttributeValues::Unorm16x4(colors) => {
            Some(colors.iter().map(|color| color.map(|c| f32::from(c) / 65535.0)).collect())
        }
        _ => None,
    }
}

fn triangles(mesh: &Mesh, vertices: usize) -> Result<Vec<[u32; 3]>, MeshProblem> {
    // A strip begins anew after the largest number of its format.
    let (indices, restart) = match mesh.try_indices_option()? {
        Some(Indices::U16(indices)) => {
            (indices.iter().map(|i| u32::from(*i)).collect(), u32::from(u16::MAX))
        }
        Some(Indices::U32(indices)) => (indices.clone(), u32::MAX),
        None => ((0..vertices as u32).collect::<Vec<_>>(), u32::MAX),
    };
    match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => match indices.as_chunks() {
            (triangles, []) => Ok(triangles.to_vec()),
            _ => Err(MeshProblem::LooseIndices(indices.len())),
        },
        PrimitiveTopology::TriangleStrip => Ok(unrolled(&indices, restart)),
        _ => Err(MeshProblem::NotTriangles),
    }
}

/// The triangles of strips. Those with a repeated vertex only join two strips, and are left out.
fn unrolled(indices: &[u32], restart: u32) -> Vec<[u32; 3]> {
    let strips = indices.split(|index| *index == restart);
    let in_strip = |strip| {
        let windows = <[u32]>::array_windows::<3>(strip).enumerate();
        windows.map(|(i, &[a, b, c])| if i.is_multiple_of(2) { [a, b, c] } else { [b, a, c] })
    };
    strips.flat_map(in_strip).filter(|&[a, b, c]| a != b && b != c && c != a).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::asset::RenderAssetUsages;

    fn mesh(topology: PrimitiveTopology, count: usize, indices: Option<Indices>) -> Mesh {
        let positions: Vec<_> = (0..count).map(|i| [i as f32, (i * i) as f32, 0.0]).collect();
        let mut mesh = Mesh::new(topology, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions);
        if let Some(indices) = indices {
            mesh.insert_indices(indices);
        }
        mesh
    }

    #[test]
    fn strips_and_bare_lists_are_lists() {
        use PrimitiveTopology::{TriangleList, TriangleStrip};
        let max = u16::MAX;
        for (topology, count, indices, expected) in [
            (TriangleList, 6, None, vec![[0, 1, 2], [3, 4, 5]]),
            (TriangleStrip, 5, None, vec![[0, 1, 2], [2, 1, 3], [2, 3, 4]]),
            (
                TriangleStrip,
                8,
                Some(Indices::U16(vec![0, 1, 2, 3, max, 4, 5, 6, 7])),
                vec![[0, 1, 2], [2, 1, 3], [4, 5, 6], [6, 5, 7]],
            ),
            (
                TriangleStrip,
                7,
                Some(Indices::U32(vec![0, 1, 2, 2, 3, 3, 4, 5])),
                vec![[0, 1, 2], [4, 3, 5]],
            ),
            (TriangleList, 4, Some(Indices::U16(vec![2, 1, 3])), vec![[2, 1, 3]]),
        ] {
            let raw = RawMesh::read(&mesh(topology, count, indices)).unwrap();
            assert_eq!(raw.triangles, expected);
        }
        let problem = |mesh: &Mesh| RawMesh::read(mesh).unwrap_err();
        assert_eq!(problem(&mesh(TriangleList, 4, None)), MeshProblem::LooseIndices(4));
        let lines = mesh(PrimitiveTopology::LineList, 6, None);
        assert_eq!(problem(&lines), MeshProblem::NotTriangles);
    }

    #[test]
    fn colours_of_all_loaders_are_read() {
        let with = |values: VertexAttributeValues| {
            let mut mesh = mesh(PrimitiveTopology::TriangleList, 3, None);
            mesh.try_insert_attribute(
                bevy::mesh::MeshVertexAttribute {
                    format: (&values).into(),
                    ..Mesh::ATTRIBUTE_COLOR
                },
                values,
            )
            .unwrap();
            RawMesh::read(&mesh).unwrap().colors.map(|colors| colors[1])
        };
        let expected = Some([0.0, 1.0, 0.2, 0.4]);
        assert_eq!(with(vec![[0.0, 1.0, 0.2, 0.4]; 3].into()), expected);
        assert_eq!(with(VertexAttributeValues::Unorm8x4(vec![[0, 255, 51, 102]; 3])), expected);
        assert_eq!(
            with(VertexAttributeValues::Unorm16x4(vec![[0, 65535, 13107, 26214]; 3])),
            expected
        );
        assert_eq!(with(VertexAttributeValues::Float32(vec![0.5; 3])), None);
    }

    #[test]
    fn only_the_same_data_have_the_same_fingerprint() {
        let base = || mesh(PrimitiveTopology::TriangleList, 6, None);
        let of = |mesh: &Mesh| fingerprint(mesh).unwrap();
        let mut moved = base();
        if let Some(VertexAttributeValues::Float32x3(p)) =
            moved.attribute_mut(Mesh::ATTRIBUTE_POSITION)
        {
            p[5][2] = 1e-9;
        }
        let normals = vec![[0.0, 1.0, 0.0]; 6];
        let others = [
            moved,
            base().with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals),
            base().with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, vec![[0.0; 4]; 6]),
            base().with_inserted_indices(Indices::U16(vec![0, 1, 2])),
            base().with_inserted_indices(Indices::U32(vec![0, 1, 2])),
            mesh(PrimitiveTopology::TriangleStrip, 6, None),
        ];
        assert_eq!(of(&base()), of(&base()));
        let mut all: Vec<_> = others.iter().map(of).chain([of(&base())]).collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 7);
        // What is not read does not count.
        let uv = base().with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0, 1.0]; 6]);
        assert_eq!(of(&uv), of(&base()));
    }
}
