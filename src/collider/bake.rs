//! Bakes an entity's mesh to a distance field, or gives its surface a thickness, off the main thread.

use bevy::prelude::*;
use bevy::tasks::futures_lite::future::poll_once;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on};

use crate::collider::SdfCollider;
use crate::collider::shape::SdfShape;
use crate::error::ClothErrorKind;
use crate::error::failures::{Blame, Failures};
use crate::mesh::source::MeshSource;
use crate::sdf::shapes::Shell;
use crate::sdf::{BakeError, BakeSettings, DistanceField};

/// Makes the entity an [`SdfCollider`] of its own mesh, or of another, by baking it to a
/// [`DistanceField`] in a background task.
///
/// The mesh must be closed, unless it is given a [`thickness`](Self::thickness). It may still be loading. Where the entity
/// has an `SdfCollider` already, its shape alone is replaced. Changing the component bakes anew; the old field serves until then.
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default, Debug, Clone)]
#[require(Transform)]
pub struct BakeSdf {
    /// The mesh; `None` is the entity's own `Mesh3d`.
    pub mesh: Option<Handle<Mesh>>,
    /// How fine the field is.
    pub cells: SdfCells,
    /// Thickness of the mesh's surface \[m\]. With it the mesh may be open, as the ground of a level, a wall or a bowl, and becomes a
    /// [`Shell`](crate::sdf::shapes::Shell) in place of a field. Thicker holds back what is faster. 0: none.
    pub thickness: f32,
}

/// How fine a baked field is, and how far it reaches.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Debug, Default, PartialEq, Clone)]
pub enum SdfCells {
    /// So many cells along the longest side of the mesh. More follow it closer; memory grows with
    /// the cube.
    Count(u32),
    /// A given size.
    Size {
        /// Spacing of the grid \[m\]. Smaller follows the mesh closer; memory grows with the cube.
        cell_size: f32,
        /// How far the grid reaches beyond the mesh \[m\]. Larger is exact further out.
        margin: f32,
    },
}

impl Default for SdfCells {
    fn default() -> Self {
        Self::Count(64)
    }
}

impl BakeSdf {
    /// Bakes the entity's own mesh with this many cells along its longest side, at least one.
    pub fn with_cells(count: u32) -> Self {
        Self { cells: SdfCells::Count(count), ..default() }
    }

    /// Bakes the entity's own mesh with cells of `cell_size` \[m\], `margin` \[m\] beyond it.
    pub fn with_cell_size(cell_size: f32, margin: f32) -> Self {
        Self { cells: SdfCells::Size { cell_size, margin }, ..default() }
    }

    /// Makes the entity's own mesh solid up to half of `thickness` \[m\] on both sides of its triangles.
    pub fn with_thickness(thickness: f32) -> Self {
        Self { thickness, ..default() }
    }

    /// Bakes another mesh than the entity's own.
    pub fn of(self, mesh: Handle<Mesh>) -> Self {
        Self { mesh: Some(mesh), ..self }
    }
}

/// A bake under way.
#[derive(Component)]
pub(crate) struct Baking(Task<Result<Solid, ClothErrorKind>>);

/// A solid made of a mesh.
enum Solid {
    Field(DistanceField),
    Shell(Shell),
}

/// A bake that is finished, well or not, for this mesh.
#[derive(Component)]
pub(crate) struct Baked;

/// Starts baking what is new or changed, as soon as its mesh is there.
pub(crate) fn start_bakes(
    bakes: Query<(Entity, Ref<BakeSdf>, Option<Ref<Mesh3d>>, Has<Baking>, Has<Baked>)>,
    mut meshes: MeshSource,
    mut commands: Commands,
    mut failures: Failures,
) {
    if bakes.is_empty() {
        return;
    }
    meshes.note_changes();
    for (entity, bake, mesh3d, baking, baked) in &bakes {
        let handle = bake.mesh.as_ref().or(mesh3d.as_deref().map(|mesh3d| &mesh3d.0));
        let failed = failures.blames(entity, Blame::Bake);
        let other_mesh =
            bake.mesh.is_none() && mesh3d.as_ref().is_some_and(DetectChanges::is_changed);
        let wanted = bake.is_changed()
            || other_mesh
            || failed && meshes.has_changed(handle)
            || !(baking || baked || failed);
        if !wanted {
            continue;
        }
        match meshes.triangles(handle) {
            Ok(Some((positions, indices))) => {
                let BakeSdf { cells, thickness, .. } = *bake;
                let task = AsyncComputeTaskPool::get_or_init(TaskPool::default)
                    .spawn(async move { make(&positions, &indices, cells, thickness) });
                commands.entity(entity).try_insert(Baking(task)).try_remove::<Baked>();
                failures.clear(entity, Blame::Unseen);
            }
            // Still loading.
            Ok(None) => {
                commands.entity(entity).try_remove::<(Baking, Baked)>();
            }
            Err(problem) => failures.report(entity, ClothErrorKind::ColliderMesh(problem)),
        }
    }
}

fn make(
    positions: &[Vec3],
    indices: &[u32],
    cells: SdfCells,
    thickness: f32,
) -> Result<Solid, ClothErrorKind> {
    if thickness == 0.0 {
        let field = bake_mesh(positions, indices, cells);
        field.map(Solid::Field).map_err(ClothErrorKind::Bake)
    } else {
        let shell = Shell::new(positions, indices, 0.5 * thickness);
        shell.map(Solid::Shell).map_err(ClothErrorKind::Shell)
    }
}

pub(crate) fn bake_mesh(
    positions: &[Vec3],
    indices: &[u32],
    cells: SdfCells,
) -> Result<DistanceField, BakeError> {
    let settings = match cells {
        SdfCells::Count(0) => return Err(BakeError::NoCells),
        SdfCells::Count(count) => BakeSettings::for_mesh(positions, count),
        SdfCells::Size { cell_size, margin } => BakeSettings { cell_size, margin },
    };
    DistanceField::bake(positions, indices, &settings)
}

/// Gives finished fields and shells to their colliders.
pub(crate) fn finish_bakes(
    mut bakes: Query<(Entity, &mut Baking, Option<&mut SdfCollider>)>,
    mut fields: ResMut<Assets<DistanceField>>,
    mut commands: Commands,
    mut failures: Failures,
) {
    for (entity, mut baking, collider) in &mut bakes {
        let Some(result) = block_on(poll_once(&mut baking.0)) else {
            continue;
        };
        commands.entity(entity).try_remove::<Baking>().try_insert(Baked);
        match result {
            Ok(solid) => {
                failures.clear(entity, Blame::Bake);
                let shape = match solid {
                    Solid::Field(field) => SdfShape::Field(fields.add(field)),
                    Solid::Shell(shell) => shell.into(),
                };
                match collider {
                    Some(mut collider) => collider.shape = shape,
                    None => {
                        commands.entity(entity).try_insert(SdfCollider::new(shape));
                    }
                }
            }
            Err(problem) => failures.report(entity, problem),
        }
    }
}

/// When `BakeSdf` is removed, cancels the running bake and clears its errors. A finished field stays.
pub(crate) fn cancel_bake(
    removed: On<Remove, BakeSdf>,
    mut commands: Commands,
    mut failures: Failures,
) {
    commands.entity(removed.entity).try_remove::<(Baking, Baked)>();
    failures.clear(removed.entity, Blame::Bake);
    failures.clear(removed.entity, Blame::Unseen);
}
