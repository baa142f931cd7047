//! The triangles of a cloth, by its particles.

use crate::solver::topology::Topology;

/// The triangles of a mesh, or two for each cell of a lattice.
pub(super) fn faces(topology: &Topology) -> Vec<[usize; 3]> {
    match topology {
        Topology::Graph(graph) => {
            graph.triangles().iter().map(|corners| corners.map(|corner| corner as usize)).collect()
        }
        Topology::Lattice(lattice) => {
            let (rows, columns) = (lattice.rows(), lattice.columns());
            let cells = (0..rows - 1).flat_map(|r| (0..columns - 1).map(move |c| r * columns + c));
            cells
                .flat_map(|a| {
                    let [b, c, d] = [a + 1, a + columns, a + columns + 1];
                    [[a, c, d], [a, d, b]]
                })
                .collect()
        }
    }
}
