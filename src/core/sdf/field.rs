//! A distance field: a grid of distances and the facts known about it.

use super::{KnownShape, LANES, PointBlock, SampleBlock, SdfSample, SignedDistance, lookup};
use bevy_math::{UVec3, Vec3, bounding::Aabb3d};
use bevy_reflect::TypePath;
use core::fmt;

/// Signed distances to a closed triangle mesh, at the nodes of a regular grid.
///
/// Made by [`bake`](Self::bake), saved by [`to_bytes`](Self::to_bytes) and read by
/// [`from_bytes`](Self::from_bytes). Every node holds the exact distance to the mesh; between nodes it is
/// interpolated trilinearly, so a smooth surface of radius `r` is met within `h^2 / (4 r)` and an edge or
/// a corner within about 0.4 `h`, `h` the cell size. The normal is the interpolant's own gradient,
/// normalised.
///
/// Outside the grid the distance is a lower bound that grows with the distance from the grid, see
/// [`sample`](SignedDistance::sample).
///
/// A field is rigid: its collider may be moved, turned and scaled alike in all directions, not bent.
#[derive(TypePath, Clone, PartialEq)]
#[cfg_attr(feature = "asset", derive(bevy_asset::Asset))]
pub struct DistanceField {
    pub(super) origin: Vec3,
    pub(super) cell_size: f32,
    pub(super) dims: UVec3,
    pub(super) values: Box<[f32]>,
    /// Smallest box around the mesh.
    pub(super) surface_min: Vec3,
    pub(super) surface_max: Vec3,
}

impl DistanceField {
    /// Position of the grid's first node \[m\].
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// Spacing of the grid's nodes \[m\]. Smaller follows the mesh closer and takes more memory.
    pub fn cell_size(&self) -> f32 {
        self.cell_size
    }

    /// Number of nodes along each axis, at least two.
    pub fn dims(&self) -> UVec3 {
        self.dims
    }

    /// Distances at the nodes \[m\], x fastest, then y, then z.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Position of a node \[m\].
    pub fn node(&self, index: UVec3) -> Vec3 {
        self.origin + self.cell_size * index.as_vec3()
    }

    /// The box that the grid covers \[m\].
    pub fn grid_bounds(&self) -> Aabb3d {
        Aabb3d { min: self.origin.into(), max: self.node(self.dims - UVec3::ONE).into() }
    }

    /// Memory that the field takes \[B\].
    pub fn memory_bytes(&self) -> usize {
        size_of::<Self>() + size_of_val::<[f32]>(&self.values)
    }
}

/// Without the nodes' values, which are many.
impl fmt::Debug for DistanceField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DistanceField")
            .field("origin", &self.origin)
            .field("cell_size", &self.cell_size)
            .field("dims", &self.dims)
            .finish_non_exhaustive()
    }
}

impl SignedDistance for DistanceField {
    /// Distance \[m\] and normal at `point`.
    ///
    /// Outside the grid, with `q` the nearest point of the grid's box and `b` the mesh's own box, it is
    /// `max(sqrt(|p - q|^2 + d(q)^2), |p - b|)`. The mesh lies in the grid's box, which is convex, so the
    /// angle at `q` between `p` and any point of the mesh is not acute: no mesh point is nearer than the
    /// first term, and none is nearer than its box. Both grow along every way straight out.
    #[inline]
    fn sample(&self, point: Vec3) -> SdfSample {
        lookup::sample(self, point)
    }

    #[inline]
    fn distance(&self, point: Vec3) -> f32 {
        lookup::distance(self, point)
    }

    #[inline]
    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        lookup::field_block(self, points, out);
    }

    #[inline]
    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        lookup::field_distance_block(self, points, out);
    }

    fn known(&self) -> Option<KnownShape<'_>> {
        Some(KnownShape::Field(self))
    }

    fn core_depth(&self) -> f32 {
        // What is thinner than a cell is hardly in the field at all.
        self.cell_size
    }

    fn bounds(&self) -> Option<Aabb3d> {
        Some(Aabb3d { min: self.surface_min.into(), max: self.surface_max.into() })
    }

    /// How far the distance may exceed the true distance to the mesh, at most \[m\]: `sqrt(3) / 2` cells and
    /// a little rounding.
    ///
    /// The true distance changes by at most 1 m per metre, so node `i` exceeds that at `p` by at most
    /// `|x_i - p|`; the mean of that over the eight nodes, with the weights of the interpolation, is at
    /// most the root of the mean square, `h sqrt(sum of f (1 - f)) <= h sqrt(3 / 4)`. The nodes themselves
    /// are exact: the bake ends by proving each of them against the mesh.
    fn overestimate(&self) -> f32 {
        const HALF_ROOT_THREE: f32 = 0.866_025_5;
        // A dozen roundings of numbers no larger than the grid, each 2^-24 of them.
        const ROUNDING: f32 = 1.0 / (1 << 19) as f32;
        let extent = self.cell_size * self.dims.as_vec3().length();
        HALF_ROOT_THREE * self.cell_size + ROUNDING * extent
    }
}
