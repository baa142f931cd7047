//! Recognises an open grid of quads in a triangle list, whatever its vertex order and
//! triangulation.
//!
//! The counts of vertices and quads give rows and columns, the border's corners give a place to
//! start, and from there every cell is forced: three known corners and one shared edge leave one
//! fourth. So a wrong guess fails within a row, and the right one visits every triangle once.

use bevy::platform::collections::HashMap;

use crate::error::problems::GridProblem;

/// An open grid of quads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct GridTopology {
    pub rows: usize,
    pub columns: usize,
    /// The vertex of every particle, row by row. Rows, columns and the triangles' front make the
    /// same right-handed frame as +z, +x and +y.
    pub vertex_of_particle: Vec<u32>,
}

/// The third vertex of the triangle on the left of each directed edge.
struct HalfEdges(HashMap<(u32, u32), u32>);

impl HalfEdges {
    fn new(triangles: &[[u32; 3]]) -> Result<Self, GridProblem> {
        let mut edges = HashMap::with_capacity(3 * triangles.len());
        for &[a, b, c] in triangles {
            for (from, to, third) in [(a, b, c), (b, c, a), (c, a, b)] {
                if from == to || edges.insert((from, to), third).is_some() {
                    return Err(GridProblem::NotASurface);
                }
            }
        }
        Ok(Self(edges))
    }

    fn third(&self, from: u32, to: u32) -> Option<u32> {
        self.0.get(&(from, to)).copied()
    }

    /// The border, counterclockwise, from its smallest vertex on.
    fn border(&self) -> Result<Vec<u32>, GridProblem> {
        let mut next = HashMap::new();
        for &(from, to) in self.0.keys() {
            if !self.0.contains_key(&(to, from)) && next.insert(from, to).is_some() {
                return Err(GridProblem::Border);
            }
        }
        let start = next.keys().min().copied().ok_or(GridProblem::Border)?;
        let mut border = vec![start];
        let mut at = start;
        while let Some(&to) = next.get(&at)
            && to != start
            && border.len() < next.len()
        {
            border.push(to);
            at = to;
        }
        if border.len() == next.len() { Ok(border) } else { Err(GridProblem::Border) }
    }

    /// The fourth vertex of the cell of `a`, its right neighbour `b` and the one below, `c`: either
    /// diagonal.
    fn fourth(&self, a: u32, b: u32, c: u32) -> Option<u32> {
        let third = self.third(a, c)?;
        if third == b { self.third(b, c) } else { (self.third(a, third)? == b).then_some(third) }
    }
}

/// Finds the rows and columns of a triangle list.
///
/// # Errors
/// [`GridProblem`] where it is no open grid of quads.
pub(crate) fn recognize(
    triangles: &[[u32; 3]],
    vertex_count: usize,
) -> Result<GridTopology, GridProblem> {
    if triangles.iter().flatten().any(|&v| v as usize >= vertex_count) {
        return Err(GridProblem::BadIndex);
    }
    let misfit = GridProblem::NotRectangular { vertices: vertex_count, triangles: triangles.len() };
    let edges = HalfEdges::new(triangles)?;
    let border = edges.border()?;
    let (short, long) = sides(vertex_count, triangles.len(), border.len()).ok_or(misfit)?;
    let mut starts: Vec<_> = (0..border.len()).collect();
    starts.sort_unstable_by_key(|&at| border[at]);
    let both = [(long, short), (short, long)];
    starts
        .iter()
        .flat_map(|&start| both.map(|(rows, columns)| (start, rows, columns)))
        .find_map(|(start, rows, columns)| fill(&edges, &border, start, rows, columns))
        .ok_or(misfit)
}

/// Side lengths in vertices, shorter first, of a grid with these counts; `None` if no grid has them.
fn sides(vertices: usize, triangles: usize, border: usize) -> Option<(usize, usize)> {
    let quads = triangles / 2;
    let sum = (vertices + 1).checked_sub(quads)?;
    let root = (sum * sum).checked_sub(4 * vertices)?.isqrt();
    let (short, long) = ((sum - root) / 2, (sum + root) / 2);
    let fits = triangles.is_multiple_of(2)
        && short >= 2
        && short * long == vertices
        && (short - 1) * (long - 1) == quads
        && 2 * (short + long) - 4 == border;
    fits.then_some((short, long))
}

/// Fills the grid from a guess of its first corner. The border runs counterclockwise: down the
/// first column, and back along the first row.
fn fill(
    edges: &HalfEdges,
    border: &[u32],
    start: usize,
    rows: usize,
    columns: usize,
) -> Option<GridTopology> {
    let around = |step: usize| border[(start + step) % border.len()];
    let mut grid = vec![0; rows * columns];
    for (column, vertex) in grid[..columns].iter_mut().enumerate() {
        *vertex = around((border.len() - column) % border.len());
    }
    for row in 1..rows {
        grid[row * columns] = around(row);
        for column in 1..columns {
            let a = grid[(row - 1) * columns + column - 1];
            let b = grid[(row - 1) * columns + column];
            let c = grid[row * columns + column - 1];
            grid[row * columns + column] = edges.fourth(a, b, c)?;
        }
    }
    let mut seen = vec![false; grid.len()];
    let distinct = grid.iter().all(|&v| !core::mem::replace(&mut seen[v as usize], true));
    distinct.then_some(GridTopology { rows, columns, vertex_of_particle: grid })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows and columns facing up, each cell split one way or the other, vertices renamed.
    fn grid(
        rows: u32,
        columns: u32,
        flip: impl Fn(u32) -> bool,
        name: impl Fn(u32) -> u32,
    ) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        for cell in 0..(rows - 1) * (columns - 1) {
            let (r, c) = (cell / (columns - 1), cell % (columns - 1));
            let a = r * columns + c;
            let (b, c, d) = (a + 1, a + columns, a + columns + 1);
            let split = if flip(cell) { [[a, c, b], [b, c, d]] } else { [[a, c, d], [a, d, b]] };
            triangles.extend(split.map(|t| t.map(&name)));
        }
        triangles
    }

    #[test]
    fn grids_in_order_are_themselves() {
        for (rows, columns) in [(2, 2), (2, 5), (5, 2), (4, 4), (3, 7), (7, 3)] {
            for pattern in [0_u32, 1, 2, 3] {
                let flip = |cell: u32| {
                    [false, true, cell.is_multiple_of(2), cell % 3 == 1][pattern as usize]
                };
                let found = recognize(&grid(rows, columns, flip, |v| v), (rows * columns) as usize);
                let found = found.unwrap();
                assert_eq!((found.rows, found.columns), (rows as usize, columns as usize));
                let expected: Vec<_> = (0..rows * columns).collect();
                assert_eq!(found.vertex_of_particle, expected);
            }
        }
    }

    #[test]
    fn shuffled_grids_keep_their_cells() {
        let (rows, columns) = (6, 9);
        let name = |v: u32| (v * 25 + 7) % 54;
        let mut triangles = grid(rows, columns, |cell| cell % 5 < 2, name);
        triangles.reverse();
        triangles.iter_mut().step_by(2).for_each(|t| t.rotate_left(1));
        let found = recognize(&triangles, 54).unwrap();
        let place = |v: u32| {
            let at = found.vertex_of_particle.iter().position(|&w| w == v).unwrap();
            (at / found.columns, at % found.columns)
        };
        for r in 0..rows {
            for c in 1..columns {
                let (a, b) = (place(name(r * columns + c - 1)), place(name(r * columns + c)));
                assert_eq!(a.0.abs_diff(b.0) + a.1.abs_diff(b.1), 1);
            }
        }
        assert_eq!(found.rows * found.columns, 54);
        assert_eq!(found.rows.min(found.columns), 6);
    }

    #[test]
    fn other_meshes_are_refused() {
        let wrapped: Vec<_> = (0..4_u32)
            .flat_map(|r| (0..6_u32).map(move |c| (r * 6 + c, r * 6 + (c + 1) % 6)))
            .flat_map(|(a, b)| [[a, a + 6, b], [b, a + 6, b + 6]])
            .collect();
        assert_eq!(recognize(&wrapped, 30), Err(GridProblem::Border));
        let tetrahedron = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        assert_eq!(recognize(&tetrahedron, 4), Err(GridProblem::Border));
        let fan: Vec<_> = (1..7).map(|i| [0, i, i % 6 + 1]).collect();
        assert!(matches!(recognize(&fan, 7), Err(GridProblem::NotRectangular { .. })));
        assert_eq!(recognize(&[[0, 1, 9]], 3), Err(GridProblem::BadIndex));
        assert_eq!(recognize(&[[0, 1, 2], [0, 1, 3]], 4), Err(GridProblem::NotASurface));
        assert_eq!(recognize(&[], 0), Err(GridProblem::Border));
        let with_spare_vertex = recognize(&grid(3, 3, |_| true, |v| v), 10);
        assert!(matches!(with_spare_vertex, Err(GridProblem::NotRectangular { .. })));
        let mut hole = grid(5, 5, |_| true, |v| v);
        hole.drain(10..12);
        assert_eq!(recognize(&hole, 25), Err(GridProblem::Border));
    }
}
