//! Bending across the edges of a mesh: quadratic bending (Bergou, Wardetzky, Harmon, Zorin and Grinspun
//! 2006), linear in the positions and zero where the cloth is flat.
//!
//! A hinge is an edge and the two triangles beside it. Its turn is `D = sum c_i x_i` over the four
//! corners with cotangent weights that add up to nothing: the length of the edge times the jump of
//! the slope across it. Its energy is `K |D|^2 / 2`. A mesh of equilateral triangles then stores, with
//! `K = B / (A1 + A2)` and curvatures of sum t and half difference d, `B (t^2 + 8 d^2) / 6`: `B / 2` for
//! each square of a cylinder's curvature, and 8/9 of it for a strip, which is free to curve across. As
//! fabric is measured in strips, `K = 9/8 B / (A1 + A2)`. (The paper's factor is 3, that of its mass
//! matrix, and makes a cylinder three times too stiff.) A rest turn of magnitude D0 makes it
//! `K (|D| - D0)^2 / 2`.
//!
//! Between rectangular cells the hinges are the lattice's instead, whichever way the cells are halved
//! (`grid_hinges`).

use bevy_math::DVec3;

use crate::solver::settings::MassLumping;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::parallel::Band;
use crate::solver::simd::soa::Array;
use crate::solver::topology::graph::adjacency::Table;
use crate::solver::topology::graph::couplings::Couplings;
use crate::solver::topology::graph::edges::{Edge, Mesh};
use crate::solver::topology::graph::grid_hinges::{Bend, Cells};
use crate::solver::topology::graph::hinge::Hinge;

/// Turns below this, an edge's length, count as flat at rest: some 0.06 degrees.
const FLAT: f32 = 1e-3;
/// Factor that makes a strip as stiff as asked for.
const STRIP: f64 = 9.0 / 8.0;

/// The hinges of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Hinges {
    /// Hinges that are curved at rest, then those that are flat.
    pub all: Vec<Hinge>,
    /// Worked out hinge by hinge.
    pub curved: Curved,
    /// Worked out particle by particle.
    pub flat: Couplings,
}

/// Hinges that are curved at rest, in rows of [`LANES`].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curved {
    /// Of the hinges, as if they were particles.
    layout: Layout,
    pub slots: [Vec<u32>; 4],
    pub weights: [Array; 3],
    pub turn: Array,
    /// The hinges of each particle, and its weights in them.
    pub table: Table,
    pub own_weight: Array,
}

impl Hinges {
    pub fn new(
        mesh: &Mesh<'_>,
        edges: &[Edge],
        lumping: MassLumping,
        stiffness: impl Fn([u32; 2]) -> f32,
    ) -> Self {
        let cells = Cells::new(mesh, edges);
        let bends = cells.bends(mesh, edges, lumping);
        let along = bends.iter().map(|bend| {
            let [centre, p, q] = bend.slots;
            along_thread(mesh, bend, 0.5 * (stiffness([centre, p]) + stiffness([centre, q])))
        });
        let across = edges
            .iter()
            .filter(|edge| edge.sides == 2 && !edge.diagonal && !cells.are_beside(edge))
            .map(|edge| across_edge(mesh, edge, stiffness(edge.ends)));
        let (curved, flat): (Vec<Hinge>, Vec<Hinge>) =
            along.chain(across).partition(|hinge| hinge.turn != 0.0);
        let slots = Layout::paged(mesh.positions.len()).len();
        Self {
            curved: Curved::new(slots, mesh.positions.len() as u32, &curved),
            flat: Couplings::new(slots, &flat),
            all: [curved, flat].concat(),
        }
    }

    /// How many are curved at rest.
    fn split(&self) -> usize {
        self.all.len() - self.flat.hinges()
    }

    /// Sums what flat hinges of the given constants \[N/m\] pull with.
    pub fn couple(&self, constants: &[f32], couplings: &mut Array) {
        let split = self.split();
        self.flat.fill(&self.all[split..], &constants[split..], couplings);
    }
}

impl Curved {
    /// The curved hinges of the particles of `slots` slots, of which `beside` is nobody's.
    fn new(slots: usize, beside: u32, all: &[Hinge]) -> Self {
        let layout = Layout::paged(all.len());
        let len = layout.len();
        let corner = |i: usize| {
            let mut slots: Vec<u32> = all.iter().map(|hinge| hinge.slots[i]).collect();
            slots.resize(len, beside);
            slots
        };
        let column = |of: &dyn Fn(&Hinge) -> f32| {
            let mut array = Array::zeros(len);
            for (to, hinge) in array.iter_mut().zip(all) {
                *to = of(hinge);
            }
            array
        };
        let mut entries = Vec::with_capacity(4 * all.len());
        for (i, hinge) in all.iter().enumerate() {
            for (corner, &slot) in hinge.slots.iter().enumerate() {
                if hinge.weights[corner] == 0.0 {
                    continue;
                }
                entries.push((slot, (i as u32, (4 * i + corner) as u32)));
            }
        }
        let table = Table::new(slots, &entries, |_| 0);
        let mut own_weight = table.room();
        table.fill(&mut own_weight, |source| all[source / 4].weights[source % 4]);
        Self {
            layout,
            slots: [corner(0), corner(1), corner(2), corner(3)],
            weights: [
                column(&|hinge| hinge.weights[1]),
                column(&|hinge| hinge.weights[2]),
                column(&|hinge| hinge.weights[3]),
            ],
            turn: column(&|hinge| hinge.turn),
            table,
            own_weight,
        }
    }

    /// Hinges and what fills up their pages.
    pub fn room(&self) -> usize {
        self.layout.len()
    }

    /// All hinges, to be cut into bands where threads are to share them.
    pub fn band(&self, shared: bool) -> Band {
        if shared { Band::all(self.layout) } else { Band::uncut(self.layout) }
    }
}

/// Turn of a hinge at rest; 0 where that is less than [`FLAT`] parts of `unit`.
fn rest_turn(mesh: &Mesh<'_>, slots: [u32; 4], weights: [f64; 4], unit: f64) -> f32 {
    let turn: DVec3 = slots
        .iter()
        .zip(weights)
        .map(|(&slot, weight)| (mesh.at(slot) - mesh.at(slots[0])) * weight)
        .sum();
    if turn.length() > f64::from(FLAT) * unit { turn.length() as f32 } else { 0.0 }
}

/// A particle and its neighbours along a thread, with weights that make `D` an angle.
fn along_thread(mesh: &Mesh<'_>, bend: &Bend, stiffness: f32) -> Hinge {
    let [centre, p, q] = bend.slots;
    let [before, after] = bend.lengths.map(|length| 1.0 / length);
    let slots = [centre, centre, p, q];
    let weights = [-(before + after), 0.0, before, after];
    Hinge {
        slots,
        weights: weights.map(|weight| weight as f32),
        shape: (bend.width / (0.5 * (bend.lengths[0] + bend.lengths[1]))) as f32 * stiffness,
        turn: rest_turn(mesh, slots, weights, 1.0),
    }
}

fn across_edge(mesh: &Mesh<'_>, edge: &Edge, stiffness: f32) -> Hinge {
    let ([a, b], [p, q]) = (edge.ends, edge.opposite);
    let cotangent = |corner: u32, u: u32, v: u32| {
        let (cosine, sine) = mesh.corner(corner, u, v);
        cosine / sine
    };
    let (ap, aq) = (cotangent(a, b, p), cotangent(a, b, q));
    let (bp, bq) = (cotangent(b, a, p), cotangent(b, a, q));
    let weights = [bp + bq, ap + aq, -(ap + bp), -(aq + bq)];
    let slots = [a, b, p, q];
    Hinge {
        slots,
        weights: weights.map(|weight| weight as f32),
        shape: (STRIP / edge.area) as f32 * stiffness,
        turn: rest_turn(mesh, slots, weights, edge.length),
    }
}
