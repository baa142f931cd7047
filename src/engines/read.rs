//! Reads parry's shapes. Compiled for each engine, as each has its own version of parry: `super::parry`.

use bevy::prelude::*;

use super::parry::shape::{SharedShape, TypedShape};
use crate::engines::bakes::Triangles;
use crate::engines::plate::Plate;
use crate::engines::solid::{EngineSolid, Reader};
use crate::error::engine::EngineProblem;
use crate::sdf::shapes::CapsuleBetween;
use crate::solver::ParameterError;

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
        TypedShape::ConvexPolyhedron(_) | TypedShape::TriMesh(_) | TypedShape::Voxels(_) => {
            Ok(reader.baked(Kept(shape.clone())))
        }
        TypedShape::RoundCuboid(_)
        | TypedShape::RoundCylinder(_)
        | TypedShape::RoundCone(_)
        | TypedShape::RoundConvexPolyhedron(_)
        | TypedShape::Compound(_)
        | TypedShape::Polyline(_)
        | TypedShape::HeightField(_)
        | TypedShape::Custom(_) => Err(EngineProblem::Unsupported { shape: name }),
    }
}

/// Whether all of a shape is baked: such a field serves at every even scale.
pub(super) fn is_baked(shape: &SharedShape) -> bool {
    match shape.as_typed_shape() {
        TypedShape::ConvexPolyhedron(_) | TypedShape::TriMesh(_) | TypedShape::Voxels(_) => true,
        TypedShape::Compound(compound) => {
            compound.shapes().iter().all(|(_, shape)| is_baked(shape))
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
