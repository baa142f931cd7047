//! An engine's shape as it is read: solids of our own, and what is still baked.

use std::sync::Arc;

use crate::collider::bake::SdfCells;
use crate::collider::shape::{CustomSdf, SdfShape};
use crate::engines::bakes::{Bake, Bakes, Triangles};
use crate::error::engine::EngineProblem;
use crate::sdf::SignedDistance;

/// A shape that is read.
pub(crate) enum EngineSolid {
    /// An exact one.
    Exact(SdfShape),
    /// One that is baked, or will be.
    Baked(Arc<Bake>),
}

impl EngineSolid {
    /// What cloths collide with; `None` while something of it is baked.
    pub fn shape(&self) -> Result<Option<SdfShape>, EngineProblem> {
        match self {
            Self::Exact(shape) => Ok(Some(shape.clone())),
            Self::Baked(bake) => Ok(bake.get()?.map(|field| SdfShape::Custom(CustomSdf(field)))),
        }
    }
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

    /// A solid within triangles.
    pub fn baked(&mut self, shape: impl Triangles) -> EngineSolid {
        EngineSolid::Baked(self.bakes.bake(Arc::new(shape), self.cells))
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
