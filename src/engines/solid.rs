//! An engine's shape as it is read: solids of our own, and what is still baked.

use std::sync::Arc;

use bevy::prelude::*;

use crate::collider::bake::SdfCells;
use crate::collider::shape::{CustomSdf, SdfShape};
use crate::engines::bakes::{Bake, Bakes, Making, Triangles};
use crate::error::engine::EngineProblem;
use crate::sdf::SignedDistance;
use crate::sdf::shapes::{Compound, Part, Rounded};
use crate::solver::ParameterError;

/// A shape that is read.
pub(crate) enum EngineSolid {
    /// An exact one.
    Exact(SdfShape),
    /// One that is made of triangles, or will be.
    Baked(Arc<Bake>),
    /// One that is swollen by a radius \[m\].
    Rounded(Box<Self>, f32),
    /// Several, each with where it is and how it is turned.
    Compound(Vec<(Vec3, Quat, Self)>),
}

impl EngineSolid {
    /// What cloths collide with; `None` while something of it is made.
    pub fn shape(&self) -> Result<Option<SdfShape>, EngineProblem> {
        match self {
            Self::Exact(shape) => Ok(Some(shape.clone())),
            other => Ok(other.solid()?.map(|solid| SdfShape::Custom(CustomSdf(solid)))),
        }
    }

    fn solid(&self) -> Result<Option<Arc<dyn SignedDistance>>, EngineProblem> {
        Ok(match self {
            Self::Exact(shape) => shape.to_solid(),
            Self::Baked(bake) => bake.get()?,
            Self::Rounded(inner, radius) => {
                let rounded = |solid| Arc::new(Rounded { solid, radius: *radius }) as _;
                inner.solid()?.map(rounded)
            }
            Self::Compound(parts) => compound(parts)?,
        })
    }
}

fn compound(
    parts: &[(Vec3, Quat, EngineSolid)],
) -> Result<Option<Arc<dyn SignedDistance>>, EngineProblem> {
    let mut placed = Vec::with_capacity(parts.len());
    for (translation, rotation, part) in parts {
        let Some(solid) = part.solid()? else { return Ok(None) };
        placed.push(Part { solid, translation: *translation, rotation: *rotation });
    }
    Ok(Some(Arc::new(Compound::new(placed).map_err(EngineProblem::Compound)?)))
}

/// What shapes are read with.
pub(crate) struct Reader<'a> {
    pub bakes: &'a mut Bakes,
    pub cells: SdfCells,
    /// Of what has no inside \[m\].
    pub thickness: f32,
}

impl Reader<'_> {
    /// A solid whose numbers are in their ranges.
    pub fn exact(&self, shape: impl Into<SdfShape>) -> Result<EngineSolid, EngineProblem> {
        let shape = shape.into();
        shape.check().map_err(EngineProblem::Shape)?;
        Ok(EngineSolid::Exact(shape))
    }

    /// Any other solid.
    pub fn custom(&self, shape: impl SignedDistance) -> Result<EngineSolid, EngineProblem> {
        self.exact(SdfShape::Custom(CustomSdf(Arc::new(shape))))
    }

    /// One that is swollen by a radius \[m\].
    pub fn rounded(&self, inner: EngineSolid, radius: f32) -> Result<EngineSolid, EngineProblem> {
        if !(0.0..=1e7).contains(&radius) {
            let (name, range) = ("the border's radius", "from 0 to 1e7 m");
            return Err(EngineProblem::Shape(ParameterError { name, value: radius, range }));
        }
        Ok(EngineSolid::Rounded(Box::new(inner), radius))
    }

    /// A solid within triangles.
    pub fn baked(&mut self, shape: impl Triangles) -> EngineSolid {
        EngineSolid::Baked(self.bakes.bake(Arc::new(shape), Making::Field(self.cells)))
    }

    /// A surface of triangles that has the collider's thickness.
    pub fn thickened(&mut self, shape: impl Triangles) -> Result<EngineSolid, EngineProblem> {
        let radius = self.radius(shape.name())?;
        Ok(EngineSolid::Baked(self.bakes.bake(Arc::new(shape), Making::Shell(radius))))
    }

    /// How far the surface is from what has no inside \[m\].
    pub fn radius(&self, shape: &'static str) -> Result<f32, EngineProblem> {
        if self.thickness > 0.0 {
            Ok(0.5 * self.thickness)
        } else {
            Err(EngineProblem::NoInside { shape })
        }
    }
}
