//! Where all particles are in a frame, between two ticks: what is drawn of a cloth begins with it.

use bevy_math::{Mat3, Vec3};

use crate::solver::ClothSolver;
use crate::solver::simd::block::Block3;
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;
use crate::solver::topology::Topology;

impl ClothSolver {
    /// Writes the place of every particle at part `blend` of the last tick: turned from where it is relative to
    /// [`ClothSolver::origin`], then shifted.
    ///
    /// # Panics
    /// If `places` are fewer than the particles.
    pub(crate) fn write_places(&self, blend: f32, turn: &Mat3, shift: Vec3, places: &mut [Vec3]) {
        let (start, end) = (&self.state.start, &self.state.x);
        let start = (blend < 1.0).then_some(start);
        self.isa.run(Place { topology: &self.topology, start, end, blend, turn, shift, places });
    }
}

/// Writes where particles are, block by block.
struct Place<'a> {
    topology: &'a Topology,
    /// Where the last tick began, if that matters.
    start: Option<&'a Soa>,
    end: &'a Soa,
    blend: f32,
    turn: &'a Mat3,
    shift: Vec3,
    places: &'a mut [Vec3],
}

impl Kernel for Place<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { topology, start, end, blend, turn, shift, places } = self;
        let layout = topology.layout();
        for row in 0..layout.rows {
            for column in (0..layout.columns).step_by(LANES) {
                let (slot, inside) =
                    (layout.slot(row, column), layout.inside(row, column).min(LANES));
                if inside == 0 {
                    // The rest of a mesh's last page.
                    break;
                }
                let mut at = Block3::load(end, slot);
                if let Some(start) = start {
                    let from = Block3::load(start, slot);
                    for i in 0..LANES {
                        at.set(i, from.at(i) + (at.at(i) - from.at(i)) * blend);
                    }
                }
                for i in 0..LANES {
                    let Vec3 { x, y, z } = at.at(i);
                    at.set(i, turn.x_axis * x + turn.y_axis * y + turn.z_axis * z + shift);
                }
                match topology {
                    Topology::Lattice(_) => {
                        let first = row * layout.columns + column;
                        for (i, place) in places[first..first + inside].iter_mut().enumerate() {
                            *place = at.at(i);
                        }
                    }
                    Topology::Graph(graph) => {
                        for (i, &particle) in graph.particles(slot, inside).iter().enumerate() {
                            places[particle as usize] = at.at(i);
                        }
                    }
                }
            }
        }
    }
}
