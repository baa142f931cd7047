//! The patches of a mesh: clusters of its particles, with all faces that touch them.
//!
//! Between two neighbours lie the patches that touch both: what is near on the cloth, on either side of their seam, is within these.
//! A patch at which more than one sheet of cloth begins, as a pocket does on a shirt, is never passed over, and neither is one whose faces
//! go round in different ways.

use core::ops::Range;

use bevy_math::Vec3;

use crate::solver::cloth_contact::clusters::Clusters;
use crate::solver::cloth_contact::faces::FacesAt;
use crate::solver::cloth_contact::find::Pair;
use crate::solver::cloth_contact::grid::NOWHERE;
use crate::solver::cloth_contact::patch::{PARTICLES, Patch, are_flat, narrow_cosine};
use crate::solver::cloth_contact::regions::Extent;
use crate::solver::simd::block::{Block, Block3, larger, smaller};
use crate::solver::simd::isa::{Isa, TransposingKernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;
use crate::solver::simd::transpose::{Four, Transpose};
use crate::solver::topology::buckets::Buckets;

/// The patches of a mesh.
#[derive(Clone, Debug)]
pub(super) struct MeshPatches {
    members: Vec<Members>,
    /// Corners of the faces of each patch, in blocks: slots. Where a block is not full, faces without area fill it up.
    corners: Vec<[[u32; LANES]; 3]>,
    /// The neighbours of each patch that have higher numbers.
    neighbours: Buckets<Neighbour>,
    /// The patches that touch both of two neighbours.
    common: Vec<u32>,
    /// Whether two neighbours were passed over as flat, and then each patch with itself, by their numbers.
    is_flat: Vec<bool>,
    /// Pairs of particles that are less than two spacings apart at rest, within a patch or in two neighbours, and the number of these.
    /// They may touch as soon as the cloth has moved by the margin, however flat it is.
    beside: Vec<(Pair, u32)>,
    /// Where particles are, by slot \[m\].
    at: Vec<Four>,
    /// Normals of the faces of a patch.
    normals: Vec<Block3>,
}

/// The particles and faces of a patch.
#[derive(Clone, Debug)]
struct Members {
    /// Slots of its particles; the first one fills up the block.
    slots: [u32; PARTICLES],
    count: usize,
    /// Where the blocks of its faces are among all.
    faces: Range<usize>,
    /// Whether normals at one of its particles do not tell a fold.
    is_seam: bool,
}

/// A neighbour of a patch.
#[derive(Clone, Copy, Debug)]
struct Neighbour {
    patch: u32,
    /// Its number among all pairs of neighbours.
    pair: u32,
    /// Where the patches that touch both are among all.
    common: [u32; 2],
}

impl MeshPatches {
    /// For the clusters of a mesh, and the pairs of its particles that are near at rest.
    pub fn new(faces: &FacesAt, clusters: &Clusters, beside: Vec<Pair>) -> Self {
        let mut corners = Vec::new();
        let members = clusters.all.iter().map(|cluster| {
            let first = corners.len();
            put_faces(&mut corners, faces, cluster);
            let mut slots = [cluster[0]; PARTICLES];
            slots[..cluster.len()].copy_from_slice(cluster);
            let is_seam = cluster.iter().any(|&slot| is_seam(faces, slot));
            Members { slots, count: cluster.len(), faces: first..corners.len(), is_seam }
        });
        let members: Vec<_> = members.collect();
        let (neighbours, common) = neighbours(faces, clusters);
        let pairs = neighbours.each().map(<[_]>::len).sum::<usize>();
        let mut patches = Self {
            is_flat: vec![false; pairs + members.len()],
            beside: Vec::new(),
            at: vec![Four::default(); faces.slots().next_multiple_of(LANES)],
            normals: Vec::new(),
            members,
            corners,
            neighbours,
            common,
        };
        patches.take_beside(clusters, beside);
        patches
    }

    /// Number of patches.
    pub fn count(&self) -> usize {
        self.members.len()
    }

    /// The slot of a particle: of the patch that is `place` over [`PARTICLES`], the one that is the rest.
    pub fn slot(&self, place: usize) -> Option<usize> {
        let Members { slots, count, .. } = &self.members[place / PARTICLES];
        let particle = place % PARTICLES;
        (particle < *count).then(|| slots[particle] as usize)
    }

    /// Looks at particles that are at these places, and writes them patch by patch.
    pub fn look(&mut self, isa: Isa, at: &Soa, x: &mut Soa, all: &mut Vec<Patch>) {
        isa.run_transposing(LookAtPatches { patches: self, at, x, all });
    }

    /// Begins anew: no neighbours have been passed over yet, but all patches with themselves that are not bent.
    pub fn begin(&mut self, all: &[Patch]) {
        let pairs = self.is_flat.len() - self.members.len();
        let (pairs, own) = self.is_flat.split_at_mut(pairs);
        pairs.fill(false);
        for (is_flat, patch) in own.iter_mut().zip(all) {
            *is_flat = !patch.is_bent();
        }
    }

    /// Whether two patches are neighbours, and all patches around their seam lie in one narrow cone. Notes it if so.
    pub fn are_flat_neighbours(&mut self, all: &[Patch], pair: [u32; 2]) -> bool {
        let Some(Neighbour { pair: number, common: [first, end], .. }) = self.neighbour(pair)
        else {
            return false;
        };
        let common = &self.common[first as usize..end as usize];
        let is_flat = are_flat(all, pair.iter().chain(common).map(|&patch| patch as usize));
        self.is_flat[number as usize] = is_flat;
        is_flat
    }

    /// Takes in the pairs of particles that are near at rest.
    fn take_beside(&mut self, clusters: &Clusters, pairs: Vec<Pair>) {
        let numbered = |pair: Pair| {
            let number = self.number(pair.slots.map(|slot| clusters.of(slot)))?;
            Some((pair, number))
        };
        self.beside = pairs.into_iter().filter_map(numbered).collect();
    }

    /// Finds those of them that may touch, in patches that were passed over.
    pub fn find_beside(&self, at: &Soa, margin: f32, pairs: &mut Vec<Pair>) {
        // Where particles were seen last, each in one line of memory.
        let place = |slot: u32| {
            let Four([x, y, z, _]) = self.at[slot as usize];
            Vec3::new(x, y, z)
        };
        for (pair, number) in &self.beside {
            let (apart, most) = (place(pair.slots[0]) - place(pair.slots[1]), pair.reach + margin);
            if apart.dot(apart) < most * most && self.is_flat[*number as usize] {
                pairs.extend(pair.now(at, margin));
            }
        }
    }

    /// The number of two neighbours, or of a patch with itself, by which it can be asked whether they were passed over. `None` where
    /// they never are.
    fn number(&self, pair: [u32; 2]) -> Option<u32> {
        if pair[0] == pair[1] {
            let pairs = self.is_flat.len() - self.members.len();
            return Some(pairs as u32 + pair[0]);
        }
        self.neighbour(pair).map(|neighbour| neighbour.pair)
    }

    /// The entry of two patches, if they are neighbours.
    fn neighbour(&self, [a, b]: [u32; 2]) -> Option<Neighbour> {
        self.neighbours.of(a.min(b)).iter().copied().find(|neighbour| neighbour.patch == a.max(b))
    }
}

/// Takes in the faces that touch a cluster, each once.
fn put_faces(corners: &mut Vec<[[u32; LANES]; 3]>, faces: &FacesAt, cluster: &[u32]) {
    let mut all: Vec<[u32; 3]> = cluster.iter().flat_map(|&slot| faces.of(slot as usize)).collect();
    all.sort_unstable();
    all.dedup();
    for some in all.chunks(LANES) {
        let mut block = [[cluster[0]; LANES]; 3];
        for (lane, face) in some.iter().enumerate() {
            for (block, &corner) in block.iter_mut().zip(face) {
                block[lane] = corner;
            }
        }
        corners.push(block);
    }
}

/// Whether the faces at a particle are anything but one fan, each with the next one across an edge that both run along in opposite
/// directions: where more than one sheet of cloth begins, or where faces go round another way, their normals do not tell a fold.
fn is_seam(faces: &FacesAt, slot: u32) -> bool {
    // The corners before and after the particle, of each face.
    let around: Vec<_> = faces
        .of(slot as usize)
        .filter_map(|corners| {
            let own = corners.iter().position(|&corner| corner == slot)?;
            Some([corners[(own + 2) % 3], corners[(own + 1) % 3]])
        })
        .collect();
    let next = |corner: u32| around.iter().find(|[before, _]| *before == corner);
    let is_first = |[before, _]: &&[u32; 2]| around.iter().all(|[_, after]| after != before);
    let Some(first) = around.iter().find(is_first).or(around.first()) else { return false };
    let (mut count, mut at) = (1, first[1]);
    while let Some(face) = next(at).filter(|face| *face != first && count < around.len()) {
        (count, at) = (count + 1, face[1]);
    }
    count < around.len()
}

/// The neighbours of each cluster that have higher numbers, and all that touch both.
fn neighbours(faces: &FacesAt, clusters: &Clusters) -> (Buckets<Neighbour>, Vec<u32>) {
    let touched = |(own, cluster): (usize, &Vec<u32>)| {
        let corners = cluster.iter().flat_map(|&slot| faces.of(slot as usize)).flatten();
        let mut touched: Vec<_> = corners.map(|corner| clusters.of(corner)).collect();
        touched.sort_unstable();
        touched.dedup();
        touched.retain(|&other| other != own as u32);
        touched
    };
    let touched: Vec<_> = clusters.all.iter().enumerate().map(touched).collect();
    let (mut with, mut common) = (Vec::new(), Vec::new());
    for (own, around) in touched.iter().enumerate() {
        for &patch in around.iter().filter(|&&other| other > own as u32) {
            let first = common.len() as u32;
            let touches = |other: &&u32| touched[patch as usize].contains(other);
            common.extend(around.iter().filter(touches));
            let common = [first, common.len() as u32];
            with.push((own as u32, Neighbour { patch, pair: with.len() as u32, common }));
        }
    }
    (Buckets::new(touched.len(), &with), common)
}

/// Looks at the patches of a mesh whose particles are at these places.
struct LookAtPatches<'a> {
    patches: &'a mut MeshPatches,
    at: &'a Soa,
    /// Where they are written to, patch by patch.
    x: &'a mut Soa,
    all: &'a mut Vec<Patch>,
}

impl TransposingKernel for LookAtPatches<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, t: impl Transpose) {
        let Self { patches, at: from, x, all } = self;
        let MeshPatches { members, corners, at, normals, .. } = patches;
        let blocks = at.as_chunks_mut::<LANES>().0;
        for (block, at) in blocks.iter_mut().enumerate() {
            let Block3 { x, y, z } = Block3::load(from, block * LANES);
            *at = t.together(&[x, y, z, Block::ZERO]);
        }
        for (patch, Members { slots, count, faces, is_seam }) in members.iter().enumerate() {
            let [px, py, pz, _] = t.apart(|i| at[slots[i] as usize]);
            let mut p = Block3 { x: px, y: py, z: pz };
            let extent = Extent {
                low: Vec3::new(p.x.smallest(), p.y.smallest(), p.z.smallest()),
                high: Vec3::new(p.x.largest(), p.y.largest(), p.z.largest()),
            };
            for i in *count..LANES {
                p.set(i, Vec3::splat(NOWHERE));
            }
            p.store(x, patch * PARTICLES);
            normals.clear();
            let mut sum = Block3::ZERO;
            for corners in &corners[faces.clone()] {
                let normal = face_normals(t, at, corners);
                sum = sum.plus(&normal);
                normals.push(normal);
            }
            let axis = sum.sum();
            let axis = axis * (1.0 / larger(axis.dot(axis), f32::MIN_POSITIVE).sqrt());
            let cosine = if *is_seam { -1.0 } else { least_cosine(normals, axis) };
            all.push(Patch { extent, axis, least_cosine: narrow_cosine(cosine) });
        }
    }
}

/// Normals of some faces, of length one; zero where a face has no area.
#[inline(always)]
fn face_normals(t: impl Transpose, at: &[Four], corners: &[[u32; LANES]; 3]) -> Block3 {
    let [ax, ay, az, _] = t.apart(|i| at[corners[0][i] as usize]);
    let [bx, by, bz, _] = t.apart(|i| at[corners[1][i] as usize]);
    let [cx, cy, cz, _] = t.apart(|i| at[corners[2][i] as usize]);
    let a = Block3 { x: ax, y: ay, z: az };
    let b = Block3 { x: bx, y: by, z: bz };
    let c = Block3 { x: cx, y: cy, z: cz };
    let mut normals = Block3::ZERO;
    for i in 0..LANES {
        let normal = (b.at(i) - a.at(i)).cross(c.at(i) - a.at(i));
        let part = 1.0 / larger(normal.dot(normal), f32::MIN_POSITIVE).sqrt();
        normals.set(i, normal * part);
    }
    normals
}

/// The least cosine of the angle between an axis and any of some normals.
#[inline(always)]
fn least_cosine(normals: &[Block3], axis: Vec3) -> f32 {
    let mut least = Block::splat(1.0);
    for normal in normals {
        for i in 0..LANES {
            let n = normal.at(i);
            // A face without area has none.
            let along = if n.dot(n) == 0.0 { 1.0 } else { n.dot(axis) };
            least.0[i] = smaller(along, least.0[i]);
        }
    }
    least.smallest()
}
