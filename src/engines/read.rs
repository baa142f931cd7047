//! Reads parry's shapes. Compiled for each engine, as each has its own version of parry: `super::parry`.

use bevy::prelude::*;

use super::parry::math::Pose;
use super::parry::shape::{
    ConvexPolyhedron, HeightField, HeightFieldCellStatus, SharedShape, TypedShape, Voxels,
};
use crate::engines::bakes::Triangles;
use crate::engines::boxes::boxes_of;
use crate::engines::solid::{EngineSolid, Reader};
use crate::error::engine::EngineProblem;
use crate::sdf::shapes::{self, CapsuleBetween, HeightFieldCell};
use crate::solver::ParameterError;

/// Most parts that voxels or a line are cut into, which is done at once.
const MOST: usize = 65_536;

/// Reads a shape, in its own frame.
pub(super) fn read(shape: &SharedShape, reader: &mut Reader) -> Result<EngineSolid, EngineProblem> {
    let name = name_of(shape);
    match shape.as_typed_shape() {
        TypedShape::Ball(ball) => reader.exact(Sphere { radius: ball.radius }),
        TypedShape::Cuboid(cuboid) => reader.exact(Cuboid { half_size: cuboid.half_extents }),
        TypedShape::Capsule(capsule) => {
            let (from, to) = (capsule.segment.a, capsule.segment.b);
            reader.exact(CapsuleBetween { from, to, radius: capsule.radius })
        }
        TypedShape::Cylinder(cylinder) => {
            reader.exact(Cylinder { radius: cylinder.radius, half_height: cylinder.half_height })
        }
        TypedShape::Cone(cone) => {
            reader.exact(Cone { radius: cone.radius, height: 2.0 * cone.half_height })
        }
        TypedShape::HalfSpace(half_space) => reader.exact(InfinitePlane3d {
            normal: Dir3::new(half_space.normal).map_err(|_| not_finite("its normal"))?,
        }),
        TypedShape::Segment(segment) => {
            let radius = reader.radius(name)?;
            reader.exact(CapsuleBetween { from: segment.a, to: segment.b, radius })
        }
        TypedShape::Triangle(triangle) => {
            let radius = reader.radius(name)?;
            plate(triangle.vertices(), radius, reader)
        }
        TypedShape::RoundTriangle(round) => {
            plate(round.inner_shape.vertices(), round.border_radius, reader)
        }
        TypedShape::TriMesh(_) if reader.thickness > 0.0 => reader.thickened(Kept(shape.clone())),
        TypedShape::ConvexPolyhedron(_) | TypedShape::TriMesh(_) => {
            Ok(reader.baked(Kept(shape.clone())))
        }
        TypedShape::Voxels(voxels) => blocks(voxels, reader),
        TypedShape::RoundCuboid(round) => {
            let half_size = round.inner_shape.half_extents.to_array().map(not_flat).into();
            reader.rounded(reader.exact(Cuboid { half_size })?, round.border_radius)
        }
        TypedShape::RoundCylinder(round) => {
            let inner = &round.inner_shape;
            let (radius, half_height) = (not_flat(inner.radius), not_flat(inner.half_height));
            reader.rounded(reader.exact(Cylinder { radius, half_height })?, round.border_radius)
        }
        TypedShape::RoundCone(round) => {
            let inner = &round.inner_shape;
            let (radius, height) = (not_flat(inner.radius), not_flat(2.0 * inner.half_height));
            reader.rounded(reader.exact(Cone { radius, height })?, round.border_radius)
        }
        TypedShape::RoundConvexPolyhedron(round) => {
            let inner = reader.baked(Kept(shape.clone()));
            reader.rounded(inner, round.border_radius)
        }
        TypedShape::Compound(compound) => {
            let part = |(pose, shape): &(Pose, SharedShape)| {
                Ok((pose.translation, pose.rotation, read(shape, reader)?))
            };
            Ok(EngineSolid::Compound(compound.shapes().iter().map(part).collect::<Result<_, _>>()?))
        }
        TypedShape::Polyline(line) => {
            let radius = reader.radius(name)?;
            many(line.segments(), name, |segment| {
                at_origin(reader.exact(CapsuleBetween {
                    from: segment.a,
                    to: segment.b,
                    radius,
                })?)
            })
        }
        TypedShape::HeightField(field) => ground(field, reader),
        TypedShape::Custom(_) => Err(EngineProblem::Unsupported { shape: name }),
    }
}

/// Ground: parry's has its columns along x and its rows along z, as ours.
fn ground(field: &HeightField, reader: &Reader) -> Result<EngineSolid, EngineProblem> {
    let (rows, columns) = (field.nrows() + 1, field.ncols() + 1);
    let scale = field.scale();
    let heights: Vec<f32> = (0..rows * columns)
        .map(|at| field.heights()[(at / columns, at % columns)] * scale.y)
        .collect();
    let ground = shapes::HeightField::new(columns, rows, heights, Vec2::new(scale.x, scale.z))
        .and_then(|ground| {
            ground.with_cells(|column, row| {
                let status = field.cell_status(row, column);
                HeightFieldCell {
                    zigzag: status.contains(HeightFieldCellStatus::ZIGZAG_SUBDIVISION),
                    left_removed: status.contains(HeightFieldCellStatus::LEFT_TRIANGLE_REMOVED),
                    right_removed: status.contains(HeightFieldCellStatus::RIGHT_TRIANGLE_REMOVED),
                }
            })
        })
        .map_err(EngineProblem::HeightField)?;
    reader.custom(ground)
}

/// Voxels, in as few boxes as they are easily put.
fn blocks(voxels: &Voxels, reader: &Reader) -> Result<EngineSolid, EngineProblem> {
    let filled = voxels.voxels().filter(|voxel| !voxel.state.is_empty());
    let boxes = boxes_of(filled.map(|voxel| voxel.grid_coords));
    many(boxes.into_iter(), "voxels", |[first, last]| {
        let half_size = (last - first + IVec3::ONE).as_vec3() * voxels.voxel_size() * 0.5;
        let centre = (voxels.voxel_center(first) + voxels.voxel_center(last)) * 0.5;
        Ok((centre, Quat::IDENTITY, reader.exact(Cuboid { half_size })?))
    })
}

/// A part, where it is and how it is turned.
type Placed = (Vec3, Quat, EngineSolid);

fn at_origin(solid: EngineSolid) -> Result<Placed, EngineProblem> {
    Ok((Vec3::ZERO, Quat::IDENTITY, solid))
}

/// A shape that is cut into parts.
fn many<T>(
    parts: impl ExactSizeIterator<Item = T>,
    shape: &'static str,
    place: impl Fn(T) -> Result<Placed, EngineProblem>,
) -> Result<EngineSolid, EngineProblem> {
    let count = parts.len();
    if count > MOST {
        return Err(EngineProblem::TooMany { shape, count, most: MOST });
    }
    Ok(EngineSolid::Compound(parts.map(place).collect::<Result<_, _>>()?))
}

/// Inside a rounded shape, what is flat has a length that is hardly any.
fn not_flat(length: f32) -> f32 {
    if (0.0..1e-6).contains(&length) { 1e-6 } else { length }
}

/// Whether all of a shape is baked: such a field serves at every even scale.
pub(super) fn is_baked(shape: &SharedShape, reader: &Reader) -> bool {
    match shape.as_typed_shape() {
        TypedShape::ConvexPolyhedron(_) => true,
        TypedShape::TriMesh(_) => reader.thickness == 0.0,
        TypedShape::Compound(compound) => {
            compound.shapes().iter().all(|(_, shape)| is_baked(shape, reader))
        }
        _ => false,
    }
}

fn plate(corners: &[Vec3; 3], radius: f32, reader: &Reader) -> Result<EngineSolid, EngineProblem> {
    let problem = |problem| EngineProblem::Shell { shape: "triangle", problem };
    reader.custom(shapes::Shell::new(corners, &[0, 1, 2], radius).map_err(problem)?)
}

fn not_finite(name: &'static str) -> EngineProblem {
    EngineProblem::Shape(ParameterError { name, value: f32::NAN, range: "finite" })
}

fn name_of(shape: &SharedShape) -> &'static str {
    match shape.as_typed_shape() {
        TypedShape::Ball(_) => "ball",
        TypedShape::Cuboid(_) => "cuboid",
        TypedShape::Capsule(_) => "capsule",
        TypedShape::Segment(_) => "segment",
        TypedShape::Triangle(_) => "triangle",
        TypedShape::Voxels(_) => "voxels",
        TypedShape::TriMesh(_) => "triangle mesh",
        TypedShape::Polyline(_) => "polyline",
        TypedShape::HalfSpace(_) => "half-space",
        TypedShape::HeightField(_) => "height field",
        TypedShape::Compound(_) => "compound",
        TypedShape::ConvexPolyhedron(_) => "convex polyhedron",
        TypedShape::Cylinder(_) => "cylinder",
        TypedShape::Cone(_) => "cone",
        TypedShape::RoundCuboid(_) => "round cuboid",
        TypedShape::RoundTriangle(_) => "round triangle",
        TypedShape::RoundCylinder(_) => "round cylinder",
        TypedShape::RoundCone(_) => "round cone",
        TypedShape::RoundConvexPolyhedron(_) => "round convex polyhedron",
        TypedShape::Custom(_) => "custom shape",
    }
}

/// A shape of triangles.
struct Kept(SharedShape);

impl Triangles for Kept {
    fn name(&self) -> &'static str {
        name_of(&self.0)
    }

    fn address(&self) -> usize {
        core::ptr::from_ref(&*self.0).addr()
    }

    fn buffers(&self) -> (Vec<Vec3>, Vec<u32>) {
        let (vertices, triangles) = match self.0.as_typed_shape() {
            TypedShape::ConvexPolyhedron(hull) => triangles_of(hull),
            TypedShape::RoundConvexPolyhedron(round) => triangles_of(&round.inner_shape),
            TypedShape::TriMesh(mesh) => (mesh.vertices().to_vec(), mesh.indices().to_vec()),
            _ => default(),
        };
        (vertices, triangles.into_flattened())
    }
}

/// The faces of a hull, each as triangles around its middle: parry's own, around a corner, meet twice in one edge where a face
/// has corners on a line.
fn triangles_of(hull: &ConvexPolyhedron) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut vertices = hull.points().to_vec();
    let mut triangles = Vec::new();
    for face in hull.faces() {
        let first = face.first_vertex_or_edge as usize;
        let count = face.num_vertices_or_edges as usize;
        let corners = &hull.vertices_adj_to_face()[first..first + count];
        if let Ok(triangle) = corners.try_into() {
            triangles.push(triangle);
            continue;
        }
        let middle = vertices.len() as u32;
        let sum: Vec3 = corners.iter().map(|corner| vertices[*corner as usize]).sum();
        vertices.push(sum / count as f32);
        let next = corners.iter().cycle().skip(1);
        triangles.extend(corners.iter().zip(next).map(|(from, to)| [middle, *from, *to]));
    }
    (vertices, triangles)
}
