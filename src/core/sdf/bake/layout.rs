//! Where the grid's nodes are.

use super::{BakeError, BakeSettings, MAX_NODES};
use bevy_math::{DVec3, UVec3, Vec3};

/// Whether squares of lengths in a grid of such cells, and of differences in one cell, stay well within
/// `f32`.
pub(in crate::sdf) fn is_usable_cell_size(cell_size: f32) -> bool {
    (1e-9..=1e9).contains(&cell_size)
}

/// The grid's place and size.
pub(super) struct Layout {
    pub(super) origin: Vec3,
    pub(super) cell_size: f32,
    pub(super) dims: UVec3,
}

impl Layout {
    /// Covers the box and its margin with cells whose corners are whole multiples of the cell size, so that
    /// a mesh moved by whole cells keeps its field.
    pub(super) fn new(min: Vec3, max: Vec3, settings: &BakeSettings) -> Result<Self, BakeError> {
        let BakeSettings { cell_size, margin } = *settings;
        if !is_usable_cell_size(cell_size) {
            return Err(BakeError::CellSize { cell_size });
        }
        if !(margin.is_finite() && margin >= 0.0) {
            return Err(BakeError::Margin { margin });
        }
        let cell = f64::from(cell_size);
        let low = min.as_dvec3() - f64::from(margin);
        let high = max.as_dvec3() + f64::from(margin);
        let snapped = (low / cell).floor() * cell;
        let origin = DVec3::from_array(core::array::from_fn(|axis| {
            // The corner is an `f32`, and must not be rounded into the box.
            let rounded = snapped[axis] as f32;
            let corner = if f64::from(rounded) > low[axis] { rounded.next_down() } else { rounded };
            f64::from(corner)
        }));
        // At least one cell: two nodes.
        let counts = ((high - origin) / cell).ceil().max(DVec3::ONE) + 1.0;
        let nodes = counts.element_product();
        if !(nodes <= MAX_NODES as f64 && origin.as_vec3().is_finite()) {
            return Err(BakeError::TooLarge { nodes: nodes as u64, limit: MAX_NODES });
        }
        Ok(Self { origin: origin.as_vec3(), cell_size, dims: counts.as_uvec3() })
    }

    pub(super) fn size(&self) -> [usize; 3] {
        self.dims.to_array().map(|count| count as usize)
    }

    pub(super) fn node_count(&self) -> usize {
        self.size().into_iter().product()
    }

    pub(super) fn index(&self, x: usize, y: usize, z: usize) -> usize {
        let [nx, ny, _] = self.size();
        x + nx * (y + ny * z)
    }

    /// Position of a node \[m\].
    pub(super) fn node(&self, x: usize, y: usize, z: usize) -> DVec3 {
        let steps = DVec3::new(x as f64, y as f64, z as f64);
        self.origin.as_dvec3() + f64::from(self.cell_size) * steps
    }
}
