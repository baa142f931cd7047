//! Reads parry's shapes. Compiled for each engine, as each has its own version of parry: `super::parry`.

use bevy::prelude::*;

use super::parry::math::Pose;
use super::parry::shape::{HeightField, HeightFieldCellStatus, SharedShape, TypedShape};
use crate::engines::bakes::Triangles;
use crate::engines::plate::Plate;
use crate::engines::solid::{EngineSolid, Reader};
use crate::error::engine::EngineProblem;
use crate::sdf::shapes::{self, CapsuleBetween, Cell};
use crate::solver::ParameterError;

/// Most parts of a surface or a line that has a thickness: a point looks at the box of each.
const MOST: usize = 2048;

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
        TypedShape::TriMesh(mesh) if reader.thickness > 0.0 => {
            let radius = reader.radius(name)?;
            shell(mesh.triangles(), name, |triangle| plate(triangle.vertices(), radius, reader))
        }
        TypedShape::ConvexPolyhedron(_) | TypedShape::TriMesh(_) | TypedShape::Voxels(_) => {
            Ok(reader.baked(Kept(shape.clone())))
        }
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
            shell(line.segments(), name, |segment| {
                reader.exact(CapsuleBetween { from: segment.a, to: segment.b, radius })
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
                Cell {
                    zigzag: status.contains(HeightFieldCellStatus::ZIGZAG_SUBDIVISION),
                    left_removed: status.contains(HeightFieldCellStatus::LEFT_TRIANGLE_REMOVED),
                    right_removed: status.contains(HeightFieldCellStatus::RIGHT_TRIANGLE_REMOVED),
                }
            })
        })
        .map_err(EngineProblem::HeightField)?;
    reader.custom(ground)
}

/// Parts of a surface or of a line, each with its thickness.
fn shell<T>(
    parts: impl ExactSizeIterator<Item = T>,
    shape: &'static str,
    thicken: impl Fn(T) -> Result<EngineSolid, EngineProblem>,
) -> Result<EngineSolid, EngineProblem> {
    let count = parts.len();
    if count > MOST {
        return Err(EngineProblem::TooMany { shape, count, most: MOST });
    }
    let part = |part| Ok((Vec3::ZERO, Quat::IDENTITY, thicken(part)?));
    Ok(EngineSolid::Compound(parts.map(part).collect::<Result<_, _>>()?))
}

/// Inside a rounded shape, what is flat has a length that is hardly any.
fn not_flat(length: f32) -> f32 {
    if (0.0..1e-6).contains(&length) { 1e-6 } else { length }
}

/// Whether all of a shape is baked: such a field serves at every even scale.
pub(super) fn is_baked(shape: &SharedShape, reader: &Reader) -> bool {
    match shape.as_typed_shape() {
        TypedShape::ConvexPolyhedron(_) | TypedShape::Voxels(_) => true,
        TypedShape::TriMesh(_) => reader.thickness == 0.0,
        TypedShape::Compound(compound) => {
            compound.shapes().iter().all(|(_, shape)| is_baked(shape, reader))
        }
        _ => false,
    }
}

fn plate(corners: &[Vec3; 3], radius: f32, reader: &Reader) -> Result<EngineSolid, EngineProblem> {
    if !corners.iter().all(|corner| corner.is_finite()) {
        return Err(not_finite("a corner of its triangle"));
    }
    reader.custom(Plate { corners: *corners, radius })
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
            TypedShape::ConvexPolyhedron(hull) => hull.to_trimesh(),
            TypedShape::RoundConvexPolyhedron(round) => round.inner_shape.to_trimesh(),
            TypedShape::TriMesh(mesh) => (mesh.vertices().to_vec(), mesh.indices().to_vec()),
            TypedShape::Voxels(voxels) => voxels.to_trimesh(),
            _ => default(),
        };
        (vertices, triangles.into_flattened())
    }
}
