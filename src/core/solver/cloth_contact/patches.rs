//! Patches of a cloth, and which of them may meet another or themselves.
//!
//! A patch whose normals lie within a narrow cone cannot meet itself, nor a neighbour that lies within the same cone (Volino and
//! Magnenat-Thalmann 1994, *Efficient Self-Collision Detection on Smoothly Discretized Surface Animations using Geometrical Shape
//! Regularity*). Others may where their boxes come near each other. A cloth that hangs or lies smoothly has none that may.

use crate::solver::cloth_contact::mesh_patches::MeshPatches;
use crate::solver::cloth_contact::patch::{PARTICLES, Patch};
use crate::solver::cloth_contact::sheet_patches::SheetPatches;
use crate::solver::cloth_contact::sweep::Sweep;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::soa::Soa;

/// Pairs of patches that there is room for from the start, for each patch.
const ROOM: usize = 8;

/// How the particles of a cloth are divided into patches.
#[derive(Clone, Debug)]
pub(super) enum Division {
    Sheet(SheetPatches),
    Mesh(MeshPatches),
}

/// The patches of a cloth.
#[derive(Clone, Debug)]
pub(super) struct Patches {
    pub division: Division,
    all: Vec<Patch>,
    sweep: Sweep,
    /// The patches that may meet each other, or themselves.
    meetings: Vec<[u32; 2]>,
}

impl Patches {
    pub fn new(division: Division) -> Self {
        let count = division.count();
        Self {
            division,
            all: Vec::with_capacity(count),
            sweep: Sweep::with_room(count, ROOM * count),
            meetings: Vec::with_capacity(ROOM * count),
        }
    }

    /// Looks at particles that are at these places, and writes them patch by patch.
    pub fn look(&mut self, isa: Isa, at: &Soa, x: &mut Soa) {
        self.all.clear();
        match &mut self.division {
            Division::Sheet(sheet) => sheet.look(isa, at, x, &mut self.all),
            Division::Mesh(mesh) => mesh.look(isa, at, x, &mut self.all),
        }
    }

    /// The patches that may meet each other, or themselves.
    pub fn meetings(&self) -> &[[u32; 2]] {
        &self.meetings
    }

    /// Finds the patches that may meet before the cloth has moved by the margin, where two particles may touch that are `reach` apart
    /// now.
    pub fn find_meetings(&mut self, isa: Isa, reach: f32) {
        let Self { all, sweep, meetings, division } = self;
        meetings.clear();
        let is_bent = |patch: &u32| all[*patch as usize].is_bent();
        meetings.extend((0..all.len() as u32).filter(is_bent).map(|patch| [patch; 2]));
        let extent = |patch: u32| &all[patch as usize].extent;
        let near = sweep.near(isa, all.len(), extent, reach).iter();
        match division {
            Division::Sheet(sheet) => {
                meetings.extend(near.filter(|&&pair| !sheet.are_flat_neighbours(pair)));
            }
            Division::Mesh(mesh) => {
                mesh.begin(all);
                meetings.extend(near.filter(|&&pair| !mesh.are_flat_neighbours(all, pair)));
            }
        }
    }
}

impl Division {
    /// Number of patches, with those that hold no particle.
    pub fn count(&self) -> usize {
        match self {
            Self::Sheet(sheet) => sheet.count(),
            Self::Mesh(mesh) => mesh.count(),
        }
    }

    /// The slots by place: of the patch that is `place` over [`PARTICLES`], the particle that is the rest. `None` where there is none.
    pub fn slots(&self) -> impl Iterator<Item = Option<usize>> + '_ {
        (0..self.count() * PARTICLES).map(|place| match self {
            Self::Sheet(sheet) => sheet.slot(place),
            Self::Mesh(mesh) => mesh.slot(place),
        })
    }
}
