//! Heights of squares of cells, and of squares of those.

/// Lowest and highest height of a square of cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    pub low: f32,
    pub high: f32,
}

impl Range {
    /// Of nothing: everything is infinitely far from it.
    pub const EMPTY: Self = Self { low: f32::INFINITY, high: f32::NEG_INFINITY };

    pub fn of(heights: [f32; 4]) -> Self {
        let [a, b, c, d] = heights;
        Self { low: a.min(b).min(c.min(d)), high: a.max(b).max(c.max(d)) }
    }

    fn join(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

/// A square of cells.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    pub range: Range,
    /// Whether a triangle is missing in it.
    pub has_hole: bool,
}

#[derive(Clone, Copy, Debug)]
struct Level {
    columns: usize,
    rows: usize,
    /// Its first node.
    first: usize,
}

/// Level `n` has squares of `2^n` cells a side; the last one is a single square. The cells themselves are not stored,
/// since four heights say it.
#[derive(Clone, Debug)]
pub struct Pyramid {
    levels: Box<[Level]>,
    ranges: Box<[Range]>,
    /// Empty if there are no holes.
    holes: Box<[bool]>,
}

impl Pyramid {
    /// `cell` says the range of a cell, and whether a triangle is missing in it.
    pub fn new(
        columns: usize,
        rows: usize,
        has_holes: bool,
        cell: impl Fn(usize, usize) -> Node,
    ) -> Self {
        let mut levels = vec![Level { columns, rows, first: 0 }];
        let (mut ranges, mut holes) = (Vec::new(), Vec::new());
        loop {
            let below = levels[levels.len() - 1];
            let is_lowest = levels.len() == 1;
            let level = Level {
                columns: below.columns.div_ceil(2),
                rows: below.rows.div_ceil(2),
                first: ranges.len(),
            };
            for row in 0..level.rows {
                for column in 0..level.columns {
                    let mut node = Node { range: Range::EMPTY, has_hole: false };
                    for row in 2 * row..(2 * row + 2).min(below.rows) {
                        for column in 2 * column..(2 * column + 2).min(below.columns) {
                            let index = below.first + row * below.columns + column;
                            let part = if is_lowest {
                                cell(column, row)
                            } else {
                                let has_hole = has_holes && holes[index];
                                Node { range: ranges[index], has_hole }
                            };
                            node.range = node.range.join(part.range);
                            node.has_hole |= part.has_hole;
                        }
                    }
                    ranges.push(node.range);
                    if has_holes {
                        holes.push(node.has_hole);
                    }
                }
            }
            levels.push(level);
            if level.columns == 1 && level.rows == 1 {
                break;
            }
        }
        Self { levels: levels.into(), ranges: ranges.into(), holes: holes.into() }
    }

    /// Number of squares along x and z in a level, from zero.
    #[inline(always)]
    pub fn counts(&self, level: usize) -> [usize; 2] {
        [self.levels[level].columns, self.levels[level].rows]
    }

    /// A square of a level from one on.
    #[inline(always)]
    pub fn node(&self, level: usize, column: usize, row: usize) -> Node {
        let Level { columns, first, .. } = self.levels[level];
        let index = first + row * columns + column;
        Node {
            range: self.ranges[index],
            has_hole: self.holes.get(index).copied().unwrap_or(false),
        }
    }

    fn all(&self) -> Range {
        self.ranges[self.ranges.len() - 1]
    }

    pub fn lowest(&self) -> f32 {
        self.all().low
    }

    pub fn highest(&self) -> f32 {
        self.all().high
    }

    pub fn memory_bytes(&self) -> usize {
        size_of_val::<[Level]>(&self.levels)
            + size_of_val::<[Range]>(&self.ranges)
            + size_of_val::<[bool]>(&self.holes)
    }
}
