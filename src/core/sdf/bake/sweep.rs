//! Raster sweeps over the grid: every node learns its neighbours' nearest triangles.
//!
//! Nodes hand on the triangle, not a distance or an offset: the receiving node measures its own exact
//! distance to it. Each of the two sweeps along z visits, slice by slice, the nine neighbours in the slice
//! before; within the slice two sweeps along y take the three neighbours in the row before; within the row
//! two sweeps along x take the node before. Together all 26 neighbours.

use super::{Nearest, band::exact_within, layout::Layout, triangle::Triangle};

/// Carries the triangles of the band to all other nodes.
pub(super) fn propagate(
    layout: &Layout,
    triangles: &[Triangle],
    nearest: &mut Nearest,
    progress: &mut dyn FnMut(f32),
) {
    let depth = layout.size()[2];
    let mut sweep = Sweep { layout, triangles, nearest, exact: exact_within(layout) };
    for (pass, backward) in [false, true].into_iter().enumerate() {
        for step in 0..depth {
            progress((pass * depth + step) as f32 / (2 * depth) as f32);
            let z = if backward { depth - 1 - step } else { step };
            if step > 0 {
                sweep.learn_from_slice(z, if backward { z + 1 } else { z - 1 });
            }
            sweep.within_slice(z);
        }
    }
}

struct Sweep<'a> {
    layout: &'a Layout,
    triangles: &'a [Triangle],
    nearest: &'a mut Nearest,
    exact: f64,
}

impl Sweep<'_> {
    /// All nodes of a slice learn from the nine neighbours in the slice before.
    fn learn_from_slice(&mut self, z: usize, before: usize) {
        let [width, height, _] = self.layout.size();
        for y in 0..height {
            for x in 0..width {
                for from_y in y.saturating_sub(1)..(y + 2).min(height) {
                    self.learn_from_row([x, y, z], from_y, before);
                }
            }
        }
    }

    /// Rows from first to last and back, each from the row before and then from end to end.
    fn within_slice(&mut self, z: usize) {
        let [width, height, _] = self.layout.size();
        for backward in [false, true] {
            for step in 0..height {
                let y = if backward { height - 1 - step } else { step };
                if step > 0 {
                    let before = if backward { y + 1 } else { y - 1 };
                    for x in 0..width {
                        self.learn_from_row([x, y, z], before, z);
                    }
                }
                for x in 1..width {
                    self.learn([x, y, z], self.layout.index(x - 1, y, z));
                }
                for x in (0..width - 1).rev() {
                    self.learn([x, y, z], self.layout.index(x + 1, y, z));
                }
            }
        }
    }

    /// One node learns from the three nearest nodes of another row.
    #[inline(always)]
    fn learn_from_row(&mut self, [x, y, z]: [usize; 3], from_y: usize, from_z: usize) {
        let width = self.layout.size()[0];
        for from_x in x.saturating_sub(1)..(x + 2).min(width) {
            self.learn([x, y, z], self.layout.index(from_x, from_y, from_z));
        }
    }

    /// One node takes its neighbour's triangle if it is nearer than its own.
    #[inline(always)]
    fn learn(&mut self, [x, y, z]: [usize; 3], neighbour: usize) {
        let node = self.layout.index(x, y, z);
        let candidate = self.nearest.triangle[neighbour];
        if candidate == Nearest::NONE
            || candidate == self.nearest.triangle[node]
            || self.nearest.squared[node] <= self.exact
        {
            return;
        }
        let squared =
            self.triangles[candidate as usize].squared_distance(self.layout.node(x, y, z));
        if squared < self.nearest.squared[node] {
            self.nearest.squared[node] = squared;
            self.nearest.triangle[node] = candidate;
        }
    }
}
