//! Hulls and meshes, baked in the background: once a shape, however many colliders have it.

use core::hash::{BuildHasher, Hasher};
use std::sync::{Arc, OnceLock, Weak};

use bevy::platform::collections::HashMap;
use bevy::platform::hash::FixedHasher;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool};

use crate::collider::bake::{SdfCells, bake_mesh};
use crate::error::engine::EngineProblem;
use crate::sdf::{BakeError, DistanceField};

/// A shape that is known by its triangles.
pub(crate) trait Triangles: Send + Sync + 'static {
    /// What its engine calls it.
    fn name(&self) -> &'static str;
    /// Where it is in memory. As long as it is kept, nothing else is there.
    fn address(&self) -> usize;
    /// Its vertices \[m\] and the three corners of each of its triangles.
    fn buffers(&self) -> (Vec<Vec3>, Vec<u32>);
}

/// A field that is baked, or will be. Dropped with the last collider that has it.
pub(crate) struct Bake {
    result: Arc<OnceLock<Result<Arc<DistanceField>, BakeError>>>,
    /// Kept, as it is found by its address.
    shape: Arc<dyn Triangles>,
    /// Cancelled when it is dropped.
    _task: Task<()>,
}

impl Bake {
    /// The field; `None` while it is baked.
    pub fn get(&self) -> Result<Option<Arc<DistanceField>>, EngineProblem> {
        match self.result.get() {
            None => Ok(None),
            Some(Ok(field)) => Ok(Some(field.clone())),
            Some(Err(BakeError::NotClosed { open_edges })) => {
                Err(EngineProblem::OpenMesh { shape: self.shape.name(), open_edges: *open_edges })
            }
            Some(Err(problem)) => {
                Err(EngineProblem::Bake { shape: self.shape.name(), problem: problem.clone() })
            }
        }
    }
}

/// How fine a field is, as bits.
type Fineness = [u32; 3];
/// Two hashes of a mesh, and how many numbers went into them.
type Content = (u64, u64, usize);

/// All bakes that a collider has.
#[derive(Resource, Default)]
pub(crate) struct Bakes {
    by_address: HashMap<(usize, Fineness), Weak<Bake>>,
    by_content: HashMap<(Content, Fineness), Weak<Bake>>,
}

impl Bakes {
    /// The bake of a shape: that of the same one, or of an equal one, or one that is started.
    pub fn bake(&mut self, shape: Arc<dyn Triangles>, cells: SdfCells) -> Arc<Bake> {
        let fineness = fineness_of(cells);
        let address = (shape.address(), fineness);
        if let Some(known) = self.by_address.get(&address).and_then(Weak::upgrade) {
            return known;
        }
        let (positions, indices) = shape.buffers();
        let content = (content_of(&positions, &indices), fineness);
        if let Some(known) = self.by_content.get(&content).and_then(Weak::upgrade) {
            return known;
        }
        let result = Arc::new(OnceLock::new());
        let outcome = result.clone();
        let task = AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn(async move {
            // Nothing else sets it.
            let _ = outcome.set(bake_mesh(&positions, &indices, cells).map(Arc::new));
        });
        let bake = Arc::new(Bake { result, shape, _task: task });
        self.by_address.insert(address, Arc::downgrade(&bake));
        self.by_content.insert(content, Arc::downgrade(&bake));
        bake
    }

    /// Forgets what no collider has any more.
    pub fn tidy(&mut self) {
        self.by_address.retain(|_, bake| bake.strong_count() > 0);
        self.by_content.retain(|_, bake| bake.strong_count() > 0);
    }
}

fn fineness_of(cells: SdfCells) -> Fineness {
    match cells {
        SdfCells::Count(count) => [0, count, 0],
        SdfCells::Size { cell_size, margin } => [1, cell_size.to_bits(), margin.to_bits()],
    }
}

/// Two independent hashes: that they are the same by chance, of two meshes of one size, is out of the question.
fn content_of(positions: &[Vec3], indices: &[u32]) -> Content {
    let hash = |salt: u64| {
        let mut hasher = FixedHasher.build_hasher();
        hasher.write_u64(salt);
        hasher.write(bytemuck::cast_slice(positions));
        hasher.write(bytemuck::cast_slice(indices));
        hasher.finish()
    };
    (hash(0x9e37_79b9_7f4a_7c15), hash(0xd1b5_4a32_d192_ed03), positions.len())
}
