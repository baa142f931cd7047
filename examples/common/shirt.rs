//! The mesh of an open shirt: front and back sewn together, of vertices that are in no rows.

use bevy::{asset::RenderAssetUsages, mesh::Indices, mesh::PrimitiveTopology, prelude::*};

/// Half of its width from cuff to cuff and of its body's, its length, and that of its sleeves from above \[m\].
const ARM: f32 = 0.56;
const BODY: f32 = 0.26;
const LENGTH: f32 = 0.72;
const SLEEVE: f32 = 0.24;
/// Half of the neck's width, and how deep it is \[m\].
const NECK: Vec2 = Vec2::new(0.08, 0.05);
/// How far the middle of front and back are from each other, of the body and of a sleeve, by half \[m\].
const DEEP: [f32; 2] = [0.17, 0.11];
/// Half of the slit in front \[m\].
const SLIT: f32 = 0.006;

/// Front or back, and which side of the slit a cell is on.
#[derive(Clone, Copy, PartialEq)]
enum Panel {
    Back,
    Left,
    Right,
}

/// The cells that the panels are cut out of: `columns` of them from cuff to cuff, the neck at the origin.
struct Pattern {
    columns: i32,
    cell: f32,
}

impl Pattern {
    /// The place of a corner of cells, before it is jittered: to the side, and down.
    fn place(&self, row: i32, column: i32) -> Vec2 {
        Vec2::new((column - self.columns / 2) as f32, row as f32) * self.cell
    }

    fn rows(&self) -> i32 {
        (LENGTH / self.cell).round() as i32
    }

    /// Whether a cell is of the shirt.
    fn has(&self, row: i32, column: i32) -> bool {
        let middle = self.place(row, column) + 0.5 * self.cell;
        let (side, down) = (middle.x.abs(), middle.y);
        let is_body = side < BODY && (0.0..LENGTH).contains(&down);
        let is_sleeve = side < ARM && (0.0..SLEEVE).contains(&down);
        let is_neck = side < NECK.x && down < NECK.y;
        (is_body || is_sleeve) && !is_neck
    }

    /// The cells around a corner.
    fn around(row: i32, column: i32) -> [(i32, i32); 4] {
        [(row - 1, column - 1), (row - 1, column), (row, column - 1), (row, column)]
    }

    /// Whether front and back are sewn together at a corner: all around, but not at cuffs, hem and neck.
    fn is_sewn(&self, row: i32, column: i32) -> bool {
        let at = self.place(row, column);
        let is_edge = Self::around(row, column).iter().any(|&(r, c)| !self.has(r, c));
        let is_neck = at.x.abs() < NECK.x + 0.5 * self.cell && at.y < NECK.y + 0.5 * self.cell;
        let is_cuff =
            !self.has(row, column) && !self.has(row - 1, column) && at.x > BODY + self.cell
                || !self.has(row, column - 1)
                    && !self.has(row - 1, column - 1)
                    && at.x < -BODY - self.cell;
        let is_hem = row == self.rows() && at.x.abs() < BODY - self.cell;
        is_edge && !is_neck && !is_cuff && !is_hem
    }

    /// How far front and back are from the middle \[m\].
    fn depth(at: Vec2) -> f32 {
        let across = |part: f32, deep: f32| deep * (1.0 - part * part).max(0.0).sqrt();
        let body = if at.y < 0.02 { 0.0 } else { across(at.x / BODY, DEEP[0]) };
        let sleeve = across(2.0 * at.y / SLEEVE - 1.0, DEEP[1]);
        body.min(across((at.y / SLEEVE).min(1.0) - 1.0, DEEP[0])).max(sleeve)
    }
}

/// A shirt that is open in front, its neck at the origin, its arms stretched out along x: of `columns` cells from cuff to cuff,
/// whose vertices are jittered and whose diagonals go either way.
pub fn shirt(columns: u32) -> Mesh {
    let columns = columns.next_multiple_of(2) as i32;
    let pattern = Pattern { columns, cell: 2.0 * ARM / columns as f32 };
    let mut seed = 7_u32;
    let mut roll = || {
        // Numerical Recipes' generator (Press et al.), from -1 to 1.
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    let mut positions: Vec<Vec3> = Vec::new();
    let mut known = bevy::platform::collections::HashMap::new();
    let mut indices = Vec::new();
    for panel in [Panel::Back, Panel::Left, Panel::Right] {
        for (row, column) in (0..pattern.rows()).flat_map(|r| (0..columns).map(move |c| (r, c))) {
            let is_left = column < columns / 2;
            let is_of = match panel {
                Panel::Back => true,
                Panel::Left => is_left,
                Panel::Right => !is_left,
            };
            if !is_of || !pattern.has(row, column) {
                continue;
            }
            let mut corner = |row: i32, column: i32| {
                let is_sewn = pattern.is_sewn(row, column);
                let is_slit = panel != Panel::Back && column == columns / 2;
                // Corners of a seam are the back's, those of the slit each side's own, all others the front's or the back's.
                let side = if is_sewn {
                    0
                } else if is_slit {
                    1 + i32::from(panel == Panel::Right)
                } else {
                    i32::from(panel != Panel::Back)
                };
                *known.entry((side, row, column)).or_insert_with(|| {
                    let is_inner =
                        Pattern::around(row, column).iter().all(|&(r, c)| pattern.has(r, c));
                    let off = Vec2::new(roll(), roll()) * 0.25 * pattern.cell;
                    let is_free = is_inner && !is_slit;
                    let at = pattern.place(row, column) + if is_free { off } else { Vec2::ZERO };
                    let opening = match panel {
                        Panel::Left if is_slit && !is_sewn => -SLIT,
                        Panel::Right if is_slit && !is_sewn => SLIT,
                        _ => 0.0,
                    };
                    let depth = if is_sewn { 0.0 } else { Pattern::depth(at) };
                    let depth = if panel == Panel::Back { -depth } else { depth };
                    positions.push(Vec3::new(at.x + opening, -at.y, depth));
                    positions.len() as u32 - 1
                })
            };
            let [a, b] = [corner(row, column), corner(row, column + 1)];
            let [c, d] = [corner(row + 1, column), corner(row + 1, column + 1)];
            let halves = if roll() > 0.0 { [[a, c, b], [b, c, d]] } else { [[a, c, d], [a, d, b]] };
            for [p, q, r] in halves {
                indices.extend(if panel == Panel::Back { [p, r, q] } else { [p, q, r] });
            }
        }
    }
    // The texture's border is at cuffs and hem.
    let uvs: Vec<_> =
        positions.iter().map(|p| [0.5 + 0.5 * p.x / ARM, 0.1 - 0.9 * p.y / LENGTH]).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
        .with_inserted_indices(Indices::U32(indices))
        .with_computed_smooth_normals()
}
