//! Hulls and meshes, made into solids in the background: once a shape, however many colliders have it.

use core::hash::{BuildHasher, Hasher};
use std::sync::{Arc, OnceLock, Weak};

use bevy::platform::collections::HashMap;
use bevy::platform::hash::FixedHasher;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool};

use crate::collider::bake::{SdfCells, bake_mesh};
use crate::error::engine::EngineProblem;
use crate::sdf::shapes::Shell;
use crate::sdf::{BakeError, SignedDistance};

/// Most triangles of a shell that is made at once: it is there in less time than a task would need.
const FEW: usize = 2048;

/// A shape that is known by its triangles.
pub(crate) trait Triangles: Send + Sync + 'static {
    /// What its engine calls it.
    fn name(&self) -> &'static str;
    /// Where it is in memory. As long as it is kept, nothing else is there.
    fn address(&self) -> usize;
    /// Its vertices \[m\] and the three corners of each of its triangles.
    fn buffers(&self) -> (Vec<Vec3>, Vec<u32>);
}

/// A solid to be made of triangles.
#[derive(Clone, Copy)]
pub(crate) enum Making {
    /// A field of what they enclose.
    Field(SdfCells),
    /// All that is within a radius of them \[m\].
    Shell(f32),
}

/// A solid that is made, or will be. Dropped with the last collider that has it.
pub(crate) struct Bake {
    result: Arc<OnceLock<Result<Arc<dyn SignedDistance>, EngineProblem>>>,
    /// Kept, as it is found by its address.
    _shape: Arc<dyn Triangles>,
    /// Cancelled when it is dropped.
    _task: Option<Task<()>>,
}

impl Bake {
    /// The solid; `None` while it is made.
    pub fn get(&self) -> Result<Option<Arc<dyn SignedDistance>>, EngineProblem> {
        self.result.get().cloned().transpose()
    }
}

/// A [`Making`], as bits.
type Kind = [u32; 3];
/// Two hashes of a mesh, and how many numbers went into them.
type Content = (u64, u64, usize);

/// All bakes that a collider has.
#[derive(Resource, Default)]
pub(crate) struct Bakes {
    by_address: HashMap<(usize, Kind), Weak<Bake>>,
    by_content: HashMap<(Content, Kind), Weak<Bake>>,
}

impl Bakes {
    /// The solid of a shape: that of the same one, or of an equal one, or one that is begun.
    pub fn bake(&mut self, shape: Arc<dyn Triangles>, making: Making) -> Arc<Bake> {
        let kind = kind_of(making);
        let address = (shape.address(), kind);
        if let Some(known) = self.by_address.get(&address).and_then(Weak::upgrade) {
            return known;
        }
        let (positions, indices) = shape.buffers();
        let content = (content_of(&positions, &indices), kind);
        if let Some(known) = self.by_content.get(&content).and_then(Weak::upgrade) {
            return known;
        }
        let (result, name) = (Arc::new(OnceLock::new()), shape.name());
        let is_quick = matches!(making, Making::Shell(_)) && indices.len() <= 3 * FEW;
        let outcome = result.clone();
        let work = move || {
            // Nothing else sets it.
            let _ = outcome.set(make(name, &positions, &indices, making));
        };
        let task = if is_quick {
            work();
            None
        } else {
            let pool = AsyncComputeTaskPool::get_or_init(TaskPool::default);
            Some(pool.spawn(async move { work() }))
        };
        let bake = Arc::new(Bake { result, _shape: shape, _task: task });
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

fn make(
    shape: &'static str,
    positions: &[Vec3],
    indices: &[u32],
    making: Making,
) -> Result<Arc<dyn SignedDistance>, EngineProblem> {
    match making {
        Making::Field(cells) => match bake_mesh(positions, indices, cells) {
            Ok(field) => Ok(Arc::new(field)),
            Err(BakeError::NotClosed { open_edges }) => {
                Err(EngineProblem::OpenMesh { shape, open_edges })
            }
            Err(problem) => Err(EngineProblem::Bake { shape, problem }),
        },
        Making::Shell(radius) => match Shell::new(positions, indices, radius) {
            Ok(shell) => Ok(Arc::new(shell)),
            Err(problem) => Err(EngineProblem::Shell { shape, problem }),
        },
    }
}

fn kind_of(making: Making) -> Kind {
    match making {
        Making::Field(SdfCells::Count(count)) => [0, count, 0],
        Making::Field(SdfCells::Size { cell_size, margin }) => {
            [1, cell_size.to_bits(), margin.to_bits()]
        }
        Making::Shell(radius) => [2, radius.to_bits(), 0],
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
