//! Any triangle mesh as cloth: particles at its vertices, springs along its edges.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `error`, `validate`, `junctions` | what is refused |
//! | `reorder` | where the particles lie in memory |
//! | `edges`, `springs` | edges and the triangles beside them; masses and spring constants |
//! | `planarity` | whether straight lines between particles lie within the cloth |
//! | `hinges`, `grid_hinges` | bending across edges, and along the threads of cells |
//! | `couplings` | hinges that are flat at rest, particle by particle |
//! | `wide_hinges` | hinges over several edges, for friction of bending |
//! | `adjacency` | the springs and hinges that each particle gathers |
//! | `chains` | lines of springs that are solved whole |
//! | `coloring` | springs in batches that share no particle |
//!
//! The forces on a graph are in `forces::graph_springs`, its constraints in `constraints::graph_strain_limit` and
//! `constraints::threads::chains`, its stages in `model::mesh`.

pub(crate) mod adjacency;
pub(crate) mod chains;
pub(crate) mod coloring;
pub(crate) mod couplings;
pub(crate) mod domains;
pub(crate) mod edges;
mod error;
pub(crate) mod grid_hinges;
pub(crate) mod hinge;
pub(crate) mod hinges;
mod junctions;
mod planarity;
mod reorder;
mod springs;
mod validate;
pub(crate) mod wide_hinges;

use core::ops::Range;

use bevy_math::Vec3;

pub use crate::solver::topology::graph::error::GraphError;

pub(crate) use crate::solver::topology::graph::springs::Link;

use crate::solver::settings::MassLumping;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Array;
use crate::solver::topology::graph::adjacency::Table;
use crate::solver::topology::graph::chains::Chains;
use crate::solver::topology::graph::coloring::Pairs;
use crate::solver::topology::graph::domains::Rounds;
use crate::solver::topology::graph::edges::Mesh;
use crate::solver::topology::graph::hinges::Hinges;
use crate::solver::topology::graph::junctions::Junction;
use crate::solver::topology::graph::wide_hinges::LazyWideHinges;

/// Factors of single particles, in their order; an empty list stands for ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weights<'a> {
    /// Factors of the mass, from 1e-3 to 1e3. Higher is heavier.
    pub mass: &'a [f32],
    /// Factors of springs and bending, from 1e-3 to 1e3: a spring has the mean of its ends' factors. Higher
    /// is stiffer.
    pub stiffness: &'a [f32],
}

/// The rest shape of a cloth that is any triangle mesh: the immutable part, shared by equal cloths.
///
/// Right-angled cells of two triangles behave as those of a lattice, whichever of their diagonals is
/// in the mesh. All else has the springs of an isotropic sheet of Young's modulus `thread_stiffness` (van Gelder
/// 1998): its Poisson's ratio is 1/3 and its shear modulus 3/8 of that, whatever shear stiffness is asked for.
/// Where triangles are unlike, vertices go where forces balance, and the mesh is softer for it: one of jittered
/// squares by 2 % along its rows, its shear modulus 0.23.
#[derive(Clone, Debug, PartialEq)]
pub struct Graph {
    pub(crate) layout: Layout,
    pub(crate) lumping: MassLumping,
    /// Rest positions \[m\], in the order given.
    pub(crate) rest_positions: Vec<Vec3>,
    /// Corners of the triangles, in the order given.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Factors of mass and stiffness, in the order given; empty for ones.
    pub(crate) weights: [Vec<f32>; 2],
    /// The slot of each particle, and the particle of each slot.
    pub(crate) slot_of: Vec<u32>,
    pub(crate) particle_at: Vec<u32>,
    /// Structural springs.
    pub(crate) structural: Vec<Link>,
    /// Shear springs.
    pub(crate) shear: Vec<Link>,
    /// Structural springs laid end to end.
    pub(crate) chains: Rounds<Chains>,
    /// Structural springs, and shear springs, in batches.
    pub(crate) structural_pairs: Rounds<Pairs>,
    pub(crate) shear_pairs: Rounds<Pairs>,
    /// Structural, then shear springs by particle, and their rest lengths \[m\].
    pub(crate) springs: Table,
    pub(crate) spring_rest: Array,
    /// Flexion springs across the edges: shape for a constant as of a lattice's \[1/m4\].
    pub(crate) flexion: Vec<Link>,
    pub(crate) hinges: Hinges,
    /// Area by slot whose mass a particle carries \[m2\].
    pub(crate) area: Vec<f32>,
    pub(crate) total_area: f32,
    /// Whether rest distances through space are distances along the cloth (flat and convex).
    pub(crate) flat: bool,
    pub(crate) wide_hinges: LazyWideHinges,
}

impl Graph {
    /// Particles a graph may have at most, and half the number of triangles.
    pub const MAX_PARTICLES: usize = 1 << 24;

    /// A cloth at rest in the given positions \[m\], of triangles given by the indices of their
    /// corners. Which way round a triangle goes does not matter.
    ///
    /// # Errors
    /// [`GraphError`] where these make no cloth: vertices at one place are to be welded and triangles
    /// without area left out before, and no vertex may lie on an edge of which it is no end.
    pub fn new(
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        lumping: MassLumping,
    ) -> Result<Self, GraphError> {
        Self::with_weights(positions, triangles, lumping, Weights::default())
    }

    /// The same, with factors of mass and stiffness for each particle.
    ///
    /// # Errors
    /// [`GraphError`], as [`Graph::new`], and for weights that cannot be used.
    pub fn with_weights(
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        lumping: MassLumping,
        weights: Weights<'_>,
    ) -> Result<Self, GraphError> {
        validate::check(positions, triangles, weights)?;
        let slot_of = reorder::slots_of(positions.len(), triangles);
        let mut particle_at = vec![0; positions.len()];
        for (particle, &slot) in slot_of.iter().enumerate() {
            particle_at[slot as usize] = particle as u32;
        }
        let in_order = |factors: &[f32]| -> Vec<f32> {
            let at = |&particle: &u32| factors[particle as usize];
            if factors.is_empty() { Vec::new() } else { particle_at.iter().map(at).collect() }
        };
        let given = [weights.mass.to_vec(), weights.stiffness.to_vec()];
        let (mass, stiffness) = (in_order(weights.mass), in_order(weights.stiffness));
        let weights = Weights { mass: &mass, stiffness: &stiffness };
        let by_slot: Vec<_> = particle_at.iter().map(|&p| positions[p as usize]).collect();
        let corners: Vec<_> = triangles.iter().map(|t| t.map(|p| slot_of[p as usize])).collect();
        let mesh = Mesh { positions: &by_slot, triangles: &corners };
        let edges = mesh.edges();
        if let Some(Junction { slot, edge }) = junctions::find(&mesh, &edges) {
            let [particle, first, second] =
                [slot, edge[0], edge[1]].map(|slot| particle_at[slot as usize] as usize);
            return Err(GraphError::TJunction { particle, first, second });
        }
        let total_area = (0..triangles.len()).map(|t| mesh.area(t)).sum::<f64>() as f32;
        let count = positions.len();
        let structural = springs::structural(&edges, lumping, weights.stiffness);
        let shear = springs::shear(&mesh, &edges, weights.stiffness);
        let springs = springs_table(count, structural.iter().chain(&shear));
        let mut spring_rest = springs.room();
        let link = |i: usize| structural.get(i).unwrap_or_else(|| &shear[i - structural.len()]);
        springs.fill(&mut spring_rest, |i| link(i).rest);
        let exact: Vec<_> = by_slot.iter().map(|p| p.as_dvec3()).collect();
        let layout = Layout::paged(count);
        let batches = |slots: &Range<usize>, links: &[Link]| Pairs::new(slots.len(), links);
        Ok(Self {
            layout,
            lumping,
            chains: Rounds::new(layout, &structural, |slots, links| {
                Chains::new(&exact[slots.start..slots.end.min(count)], links)
            }),
            structural_pairs: Rounds::new(layout, &structural, batches),
            shear_pairs: Rounds::new(layout, &shear, batches),
            flexion: springs::flexion(&mesh, &edges, weights.stiffness),
            hinges: Hinges::new(&mesh, &edges, lumping, |ends| springs::between(&stiffness, ends)),
            springs,
            spring_rest,
            structural,
            shear,
            area: springs::areas(&mesh, &edges, lumping, weights),
            total_area,
            flat: planarity::is_flat_and_convex(&mesh, &edges),
            wide_hinges: LazyWideHinges::default(),
            weights: given,
            rest_positions: positions.to_vec(),
            triangles: triangles.to_vec(),
            slot_of,
            particle_at,
        })
    }

    /// The same cloth with masses and springs of the border lumped otherwise.
    ///
    /// # Errors
    /// None that [`Graph::new`] did not find before.
    pub fn with_lumping(&self, lumping: MassLumping) -> Result<Self, GraphError> {
        let [mass, stiffness] = &self.weights;
        let weights = Weights { mass, stiffness };
        Self::with_weights(&self.rest_positions, &self.triangles, lumping, weights)
    }

    /// Number of particles.
    pub fn particle_count(&self) -> usize {
        self.rest_positions.len()
    }

    /// Rest positions \[m\], in the order of the particles.
    pub fn rest_positions(&self) -> &[Vec3] {
        &self.rest_positions
    }

    /// Corners of the triangles, as they were given.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Structural and shear springs.
    pub fn spring_count(&self) -> usize {
        self.structural.len() + self.shear.len()
    }

    /// Slots of the particles along the chains, domain after domain: what two graphs have alike whose chains are of the same springs.
    pub(crate) fn chain_slots(&self) -> Vec<&[u32]> {
        self.chains.iter().map(|domain| &*domain.work.slots).collect()
    }

    /// The structural springs: both particles and the rest length \[m\].
    pub fn structural_springs(&self) -> impl Iterator<Item = (usize, usize, f32)> + '_ {
        self.structural.iter().map(|link| {
            let [a, b] = link.ends.map(|slot| self.particle_at[slot as usize] as usize);
            (a, b, link.rest)
        })
    }

    /// Area of all triangles at rest \[m2\].
    pub fn total_area(&self) -> f32 {
        self.total_area
    }

    /// The slot of a particle.
    pub(crate) fn slot(&self, particle: usize) -> usize {
        self.slot_of[particle] as usize
    }

    /// The particles of so many slots.
    pub(crate) fn particles(&self, slot: usize, count: usize) -> &[u32] {
        &self.particle_at[slot..slot + count]
    }

    /// The particle of a slot.
    pub(crate) fn particle(&self, slot: usize) -> usize {
        self.particle_at[slot] as usize
    }

    /// Rest position of the particle of a slot \[m\].
    pub(crate) fn rest(&self, slot: usize) -> Vec3 {
        self.rest_positions[self.particle_at[slot] as usize]
    }

    /// Springs by particle.
    pub(crate) fn table(&self, links: &[Link]) -> Table {
        springs_table(self.particle_count(), links.iter())
    }
}

fn springs_table<'a>(particles: usize, links: impl Iterator<Item = &'a Link>) -> Table {
    let both = |(i, &Link { ends: [a, b], .. }): (u32, &Link)| [(a, (b, i)), (b, (a, i))];
    let entries: Vec<_> = (0..).zip(links).flat_map(both).collect();
    Table::new(Layout::paged(particles).len(), &entries, |slot| slot)
}
