//! Rows and columns exchanged: tiles of 16 x 16 particles, and what lies particle by particle turned
//! into blocks.
//!
//! The compiler makes gathers of the plain loops where it has AVX-512, and inserts single numbers where
//! it has AVX2: several times as slow as the shuffles that are written out here.

use crate::solver::simd::block::Block;
use crate::solver::simd::lanes::LANES;

/// Four numbers of one particle, which come in one load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(16))]
pub(crate) struct Four(pub [f32; 4]);

#[cfg(target_arch = "x86_64")]
type Half = core::arch::x86_64::__m256;
#[cfg(target_arch = "x86_64")]
type Wide = core::arch::x86_64::__m512;

/// [`LANES`] rows of as many columns, and where they go with rows and columns exchanged: from memory to memory, as no
/// processor has registers for all of them.
pub(crate) trait Tile {
    /// A row.
    fn row(&self, row: usize) -> Block;
    /// Takes a column.
    fn put(&mut self, column: usize, rows: Block);
}

/// How rows and columns are exchanged, with the instructions at hand.
pub(crate) trait Transpose: Copy {
    /// Exchanges rows and columns of a tile.
    #[inline(always)]
    fn tile(self, tile: &mut impl Tile) {
        plain(tile);
    }

    /// Block k of number k of each of [`LANES`] particles.
    #[inline(always)]
    fn apart(self, four: impl Fn(usize) -> Four) -> [Block; 4] {
        let mut out = [Block::ZERO; 4];
        for i in 0..LANES {
            for (block, number) in out.iter_mut().zip(four(i).0) {
                block.0[i] = number;
            }
        }
        out
    }

    /// The reverse of [`Transpose::apart`].
    #[inline(always)]
    fn together(self, blocks: &[Block; 4]) -> [Four; LANES] {
        let mut out = [Four([0.0; 4]); LANES];
        for (i, four) in out.iter_mut().enumerate() {
            for (number, block) in four.0.iter_mut().zip(blocks) {
                *number = block.0[i];
            }
        }
        out
    }
}

/// Plain loops.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain;

impl Transpose for Plain {}

/// By shuffles of 8 lanes.
#[cfg(target_arch = "x86_64")]
impl Transpose for pulp::x86::V3 {
    #[inline(always)]
    fn tile(self, tile: &mut impl Tile) {
        use pulp::cast;
        for right in 0..2 {
            let mut rows = [self.avx._mm256_setzero_ps(); LANES];
            for (i, row) in rows.iter_mut().enumerate() {
                let [near, far] = cast::<[f32; LANES], [[f32; LANES / 2]; 2]>(tile.row(i).0);
                *row = cast(if right == 0 { near } else { far });
            }
            let [a, b, c, d, e, f, g, h, below @ ..] = rows;
            let (above, below) = (eight(self, [a, b, c, d, e, f, g, h]), eight(self, below));
            for (j, (above, below)) in above.into_iter().zip(below).enumerate() {
                let column: [[f32; LANES / 2]; 2] = [cast(above), cast(below)];
                tile.put(LANES / 2 * right + j, Block(cast(column)));
            }
        }
    }

    #[inline(always)]
    fn apart(self, four: impl Fn(usize) -> Four) -> [Block; 4] {
        use pulp::cast;
        let f = self.avx;
        let mut out = [[[0.0_f32; LANES / 2]; 2]; 4];
        for half in 0..2 {
            let mut rows = [f._mm256_setzero_ps(); 4];
            for (k, row) in rows.iter_mut().enumerate() {
                let k = LANES / 2 * half + k;
                let low = f._mm256_castps128_ps256(cast(four(k).0));
                *row = f._mm256_insertf128_ps::<1>(low, cast(four(k + 4).0));
            }
            for (to, quad) in out.iter_mut().zip(halves(self, rows)) {
                to[half] = cast(quad);
            }
        }
        let [x, y, z, w] = out;
        [Block(cast(x)), Block(cast(y)), Block(cast(z)), Block(cast(w))]
    }

    #[inline(always)]
    fn together(self, blocks: &[Block; 4]) -> [Four; LANES] {
        use pulp::cast;
        let f = self.avx;
        let mut out = [Four([0.0; 4]); LANES];
        for half in 0..2 {
            let row = |k: usize| {
                let [low, high] = cast::<[f32; LANES], [[f32; LANES / 2]; 2]>(blocks[k].0);
                cast::<[f32; LANES / 2], _>(if half == 0 { low } else { high })
            };
            for (k, quad) in halves(self, [row(0), row(1), row(2), row(3)]).into_iter().enumerate()
            {
                out[LANES / 2 * half + k].0 = cast(f._mm256_castps256_ps128(quad));
                out[LANES / 2 * half + k + 4].0 = cast(f._mm256_extractf128_ps::<1>(quad));
            }
        }
        out
    }
}

/// By shuffles of 16 lanes.
#[cfg(target_arch = "x86_64")]
impl Transpose for pulp::x86::V4 {
    #[inline(always)]
    fn tile(self, tile: &mut impl Tile) {
        wide(self, tile);
    }

    #[inline(always)]
    fn apart(self, four: impl Fn(usize) -> Four) -> [Block; 4] {
        use pulp::cast;
        let f = self.avx512f;
        // Not by a closure around the intrinsics, which would be calls within it.
        let mut rows = [f._mm512_setzero_ps(); 4];
        for (k, to) in rows.iter_mut().enumerate() {
            let row = f._mm512_castps128_ps512(cast(four(k).0));
            let row = f._mm512_insertf32x4::<1>(row, cast(four(k + 4).0));
            let row = f._mm512_insertf32x4::<2>(row, cast(four(k + 8).0));
            *to = f._mm512_insertf32x4::<3>(row, cast(four(k + 12).0));
        }
        let [x, y, z, w] = quarters(self, rows);
        [Block(cast(x)), Block(cast(y)), Block(cast(z)), Block(cast(w))]
    }

    #[inline(always)]
    fn together(self, blocks: &[Block; 4]) -> [Four; LANES] {
        use pulp::cast;
        let f = self.avx512f;
        let row = |k: usize| cast::<[f32; LANES], _>(blocks[k].0);
        let mut out = [Four([0.0; 4]); LANES];
        for (k, quad) in quarters(self, [row(0), row(1), row(2), row(3)]).into_iter().enumerate() {
            out[k].0 = cast(f._mm512_castps512_ps128(quad));
            out[k + 4].0 = cast(f._mm512_extractf32x4_ps::<1>(quad));
            out[k + 8].0 = cast(f._mm512_extractf32x4_ps::<2>(quad));
            out[k + 12].0 = cast(f._mm512_extractf32x4_ps::<3>(quad));
        }
        out
    }
}

#[inline(always)]
fn plain(tile: &mut impl Tile) {
    let mut out = [Block::ZERO; LANES];
    for i in 0..LANES {
        for (j, value) in tile.row(i).0.into_iter().enumerate() {
            out[j].0[i] = value;
        }
    }
    for (j, column) in out.into_iter().enumerate() {
        tile.put(j, column);
    }
}

/// Exchanges eight rows of half a tile's columns: four and four within halves of registers, then these.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn eight(v3: pulp::x86::V3, rows: [Half; LANES / 2]) -> [Half; LANES / 2] {
    let f = v3.avx;
    let [r0, r1, r2, r3, r4, r5, r6, r7] = rows;
    let [a0, a1, a2, a3] = halves(v3, [r0, r1, r2, r3]);
    let [b0, b1, b2, b3] = halves(v3, [r4, r5, r6, r7]);
    [
        f._mm256_permute2f128_ps::<0x20>(a0, b0),
        f._mm256_permute2f128_ps::<0x20>(a1, b1),
        f._mm256_permute2f128_ps::<0x20>(a2, b2),
        f._mm256_permute2f128_ps::<0x20>(a3, b3),
        f._mm256_permute2f128_ps::<0x31>(a0, b0),
        f._mm256_permute2f128_ps::<0x31>(a1, b1),
        f._mm256_permute2f128_ps::<0x31>(a2, b2),
        f._mm256_permute2f128_ps::<0x31>(a3, b3),
    ]
}

/// Exchanges rows and columns within halves of registers.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn halves(v3: pulp::x86::V3, [r0, r1, r2, r3]: [Half; 4]) -> [Half; 4] {
    let f = v3.avx;
    let (low01, high01) = (f._mm256_unpacklo_ps(r0, r1), f._mm256_unpackhi_ps(r0, r1));
    let (low23, high23) = (f._mm256_unpacklo_ps(r2, r3), f._mm256_unpackhi_ps(r2, r3));
    [
        f._mm256_shuffle_ps::<0x44>(low01, low23),
        f._mm256_shuffle_ps::<0xee>(low01, low23),
        f._mm256_shuffle_ps::<0x44>(high01, high23),
        f._mm256_shuffle_ps::<0xee>(high01, high23),
    ]
}

/// Exchanges rows and columns within quarters of registers.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn quarters(v4: pulp::x86::V4, [r0, r1, r2, r3]: [Wide; 4]) -> [Wide; 4] {
    let f = v4.avx512f;
    let (low01, high01) = (f._mm512_unpacklo_ps(r0, r1), f._mm512_unpackhi_ps(r0, r1));
    let (low23, high23) = (f._mm512_unpacklo_ps(r2, r3), f._mm512_unpackhi_ps(r2, r3));
    [
        f._mm512_shuffle_ps::<0x44>(low01, low23),
        f._mm512_shuffle_ps::<0xee>(low01, low23),
        f._mm512_shuffle_ps::<0x44>(high01, high23),
        f._mm512_shuffle_ps::<0xee>(high01, high23),
    ]
}

/// Four rows at a time within quarters of a register, then the quarters.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn wide(v4: pulp::x86::V4, tile: &mut impl Tile) {
    use pulp::cast;
    let f = v4.avx512f;
    // Quarter q of quads[k][c] is rows 4 k to 4 k + 3 of column 4 q + c.
    let mut quads = [[f._mm512_setzero_ps(); 4]; 4];
    for (k, to) in quads.iter_mut().enumerate() {
        let mut rows = [f._mm512_setzero_ps(); 4];
        for (i, row) in rows.iter_mut().enumerate() {
            *row = cast::<[f32; LANES], _>(tile.row(4 * k + i).0);
        }
        *to = quarters(v4, rows);
    }
    #[expect(clippy::needless_range_loop, reason = "an iterator over four arrays says less")]
    for c in 0..4 {
        let (a, b, c2, d) = (quads[0][c], quads[1][c], quads[2][c], quads[3][c]);
        let (even, odd) =
            (f._mm512_shuffle_f32x4::<0x88>(a, b), f._mm512_shuffle_f32x4::<0xdd>(a, b));
        let (even2, odd2) =
            (f._mm512_shuffle_f32x4::<0x88>(c2, d), f._mm512_shuffle_f32x4::<0xdd>(c2, d));
        tile.put(c, Block(cast(f._mm512_shuffle_f32x4::<0x88>(even, even2))));
        tile.put(8 + c, Block(cast(f._mm512_shuffle_f32x4::<0xdd>(even, even2))));
        tile.put(4 + c, Block(cast(f._mm512_shuffle_f32x4::<0x88>(odd, odd2))));
        tile.put(12 + c, Block(cast(f._mm512_shuffle_f32x4::<0xdd>(odd, odd2))));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::simd::isa::{Isa, TransposingKernel};

    struct Copied<'a> {
        from: &'a [Block; LANES],
        to: [Block; LANES],
    }

    impl Tile for Copied<'_> {
        #[inline(always)]
        fn row(&self, row: usize) -> Block {
            self.from[row]
        }

        #[inline(always)]
        fn put(&mut self, column: usize, rows: Block) {
            self.to[column] = rows;
        }
    }

    /// A tile exchanged, its first four rows as they are by particle, and these put apart again.
    struct Exchange<'a>(&'a [Block; LANES]);

    impl TransposingKernel for Exchange<'_> {
        type Output = ([Block; LANES], [Four; LANES], [Block; 4]);

        #[inline(always)]
        fn run(self, t: impl Transpose) -> Self::Output {
            let [a, b, c, d, ..] = *self.0;
            let fours = t.together(&[a, b, c, d]);
            let mut copy = Copied { from: self.0, to: [Block::ZERO; LANES] };
            t.tile(&mut copy);
            (copy.to, fours, t.apart(|i| fours[i]))
        }
    }

    #[test]
    fn columns_become_rows() {
        let mut tile = [Block::ZERO; LANES];
        for i in 0..LANES * LANES {
            tile[i / LANES].0[i % LANES] = i as f32;
        }
        for isa in Isa::ALL {
            let (out, fours, blocks) = isa.run_transposing(Exchange(&tile));
            for i in 0..LANES * LANES {
                let (row, column) = (i / LANES, i % LANES);
                assert_eq!(out[column].0[row], i as f32, "{isa:?}");
                if row < 4 {
                    assert_eq!(fours[column].0[row], i as f32, "{isa:?}");
                    assert_eq!(blocks[row].0[column], i as f32, "{isa:?}");
                }
            }
        }
    }
}
