//! Constants of a mesh's explicit springs and hinges as they are in use. Where the substeps do not
//! carry a particle's, those of its springs are lowered and no others: a sliver of a triangle must not
//! take its stiffness from the whole cloth.

use crate::solver::forces::families::Constants;
use crate::solver::plan::stability::{Bound, Shares};
use crate::solver::settings::Bending;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Array;
use crate::solver::topology::graph::Graph;
use crate::solver::topology::graph::adjacency::Table;
use crate::solver::topology::graph::hinge::Hinge;

/// Explicit constants by entry of the tables, and those of the hinges.
#[derive(Clone, Debug)]
pub(crate) struct GraphStiffness {
    /// Constants of structural and shear springs \[N/m\].
    pub springs: Array,
    /// Constants of the springs' damping \[N s/m\].
    pub damping: Array,
    /// Flexion springs, where the settings ask for them.
    pub flexion: Option<Flexion>,
    /// Constants of hinges \[N/m\].
    pub hinges: Array,
    /// Constants of hinges that are flat at rest, as couplings of particles \[N/m\].
    pub couplings: Array,
    /// A clamped hinge counts double: it stands for half a triangle more.
    clamp: Vec<f32>,
    /// Room for what the substeps leave of each particle's constants.
    shares: Vec<Shares>,
}

/// Flexion springs by particle.
#[derive(Clone, Debug)]
pub(crate) struct Flexion {
    pub table: Table,
    pub rest: Array,
    pub constants: Array,
}

/// Constants that the material asks of explicit forces, and the rates that the substeps carry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Demand {
    /// Constants that the material asks for.
    pub asked: Constants,
    /// `omega^2` that is stable \[1/s2\].
    pub stable: f32,
    /// Damping of structural and of shear springs \[N s/m\], and the rate that is stable \[1/s\].
    pub damping: [f32; 2],
    pub stable_damping: f32,
}

impl GraphStiffness {
    /// For held slots.
    pub fn new(graph: &Graph, held: &[bool]) -> Self {
        let clamp = |hinge: &Hinge| {
            let [a, b, p, q] = hinge.slots.map(|slot| held[slot as usize]);
            if a && b && p != q { 2.0 } else { 1.0 }
        };
        Self {
            springs: graph.springs.room(),
            damping: graph.springs.room(),
            flexion: None,
            hinges: Array::zeros(Layout::paged(graph.hinges.all.len()).len()),
            couplings: graph.hinges.flat.room(),
            clamp: graph.hinges.all.iter().map(clamp).collect(),
            shares: vec![Shares::WHOLE; graph.layout.len()],
        }
    }

    /// Makes room for flexion springs where they are asked for.
    pub fn set_bending(&mut self, graph: &Graph, bending: Bending) {
        if bending != Bending::Flexion {
            self.flexion = None;
        } else if self.flexion.is_none() {
            let table = graph.table(&graph.flexion);
            let mut rest = table.room();
            table.fill(&mut rest, |i| graph.flexion[i].rest);
            self.flexion = Some(Flexion { constants: table.room(), table, rest });
        }
    }

    /// Row sums of each particle, over its mass.
    pub fn circles(&self, graph: &Graph, inverse_mass: &[f32]) -> Vec<Constants> {
        let mut circles = vec![Constants::default(); graph.layout.len()];
        for link in &graph.structural {
            for slot in link.ends {
                circles[slot as usize].thread += 2.0 * link.shape;
            }
        }
        for link in &graph.shear {
            for slot in link.ends {
                circles[slot as usize].shear += 2.0 * link.shape;
            }
        }
        for link in &graph.flexion {
            for slot in link.ends {
                circles[slot as usize].flexion += 2.0 * link.shape;
            }
        }
        for (hinge, clamp) in graph.hinges.all.iter().zip(&self.clamp) {
            let sum: f32 = hinge.weights.iter().map(|weight| weight.abs()).sum();
            for (slot, weight) in hinge.slots.into_iter().zip(hinge.weights) {
                circles[slot as usize].bend += hinge.shape * clamp * weight.abs() * sum;
            }
        }
        for (circle, &w) in circles.iter_mut().zip(inverse_mass) {
            *circle = circle.scaled(w);
        }
        circles
    }

    /// Sets all constants.
    pub fn set(&mut self, graph: &Graph, bound: &Bound, demand: &Demand) {
        let Bound::Graph(circles) = bound else { return };
        let Demand { asked, stable, damping, stable_damping } = *demand;
        for (share, circle) in self.shares.iter_mut().zip(circles) {
            *share = Shares::of(circle, &asked, stable);
            let rate = damping[0] * circle.thread + damping[1] * circle.shear;
            share.damping = (stable_damping / rate).min(1.0);
        }
        let shares = &self.shares;
        let least = |slots: &[u32], of: fn(&Shares) -> f32| {
            slots.iter().map(|&slot| of(&shares[slot as usize])).fold(1.0, f32::min)
        };
        let structural = graph.structural.len();
        graph.springs.fill(&mut self.springs, |i| match graph.structural.get(i) {
            Some(link) => link.shape * asked.thread * least(&link.ends, |share| share.thread),
            None => {
                let link = &graph.shear[i - structural];
                link.shape * asked.shear * least(&link.ends, |share| share.shear)
            }
        });
        graph.springs.fill(&mut self.damping, |i| match graph.structural.get(i) {
            Some(link) => link.shape * damping[0] * least(&link.ends, |share| share.damping),
            None => {
                let link = &graph.shear[i - structural];
                link.shape * damping[1] * least(&link.ends, |share| share.damping)
            }
        });
        if let Some(Flexion { table, constants, .. }) = &mut self.flexion {
            table.fill(constants, |i| {
                let link = &graph.flexion[i];
                link.shape * asked.flexion * least(&link.ends, |share| share.bending)
            });
        }
        for (i, hinge) in graph.hinges.all.iter().enumerate() {
            let share = least(&hinge.slots, |share| share.bending);
            self.hinges[i] = hinge.shape * self.clamp[i] * asked.bend * share;
        }
        graph.hinges.couple(&self.hinges, &mut self.couplings);
    }
}
