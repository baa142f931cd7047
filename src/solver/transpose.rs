//! Tiles of 16 x 16 particles with rows and columns exchanged.
//!
//! The compiler makes gathers of the plain loop where it has AVX-512, which take three times as long
//! as the shuffles that are written out here.

use super::isa::Isa;
use super::lanes::{Block, LANES};

/// How tiles are exchanged, for the instruction set at hand.
#[derive(Clone, Copy, Debug)]
pub(super) enum Transpose {
    /// The plain loop.
    Plain,
    /// By shuffles of 16 lanes.
    #[cfg(target_arch = "x86_64")]
    Wide(pulp::x86::V4),
}

impl Transpose {
    /// What suits kernels run by `isa`.
    #[cfg_attr(not(target_arch = "x86_64"), expect(unused_variables))]
    pub fn new(isa: Isa) -> Self {
        #[cfg(target_arch = "x86_64")]
        if isa == Isa::Avx512
            && let Some(v4) = pulp::x86::V4::try_new()
        {
            return Self::Wide(v4);
        }
        Self::Plain
    }

    /// The columns of a tile as rows.
    #[inline(always)]
    pub fn tile(self, tile: &[Block; LANES]) -> [Block; LANES] {
        match self {
            Self::Plain => plain(tile),
            #[cfg(target_arch = "x86_64")]
            Self::Wide(v4) => wide(v4, tile),
        }
    }
}

#[inline(always)]
fn plain(tile: &[Block; LANES]) -> [Block; LANES] {
    let mut out = [Block::ZERO; LANES];
    for (i, line) in tile.iter().enumerate() {
        for (j, &value) in line.0.iter().enumerate() {
            out[j].0[i] = value;
        }
    }
    out
}

/// Four rows at a time within quarters of a register, then the quarters.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn wide(v4: pulp::x86::V4, tile: &[Block; LANES]) -> [Block; LANES] {
    use pulp::cast;
    let f = v4.avx512f;
    let row = |i: usize| cast::<[f32; LANES], _>(tile[i].0);
    // Quarter q of quads[4 k + c] is rows 4 k to 4 k + 3 of column 4 q + c.
    let mut quads = [row(0); LANES];
    for k in 0..4 {
        let (r0, r1, r2, r3) = (row(4 * k), row(4 * k + 1), row(4 * k + 2), row(4 * k + 3));
        let (low01, high01) = (f._mm512_unpacklo_ps(r0, r1), f._mm512_unpackhi_ps(r0, r1));
        let (low23, high23) = (f._mm512_unpacklo_ps(r2, r3), f._mm512_unpackhi_ps(r2, r3));
        quads[4 * k] = f._mm512_shuffle_ps::<0x44>(low01, low23);
        quads[4 * k + 1] = f._mm512_shuffle_ps::<0xee>(low01, low23);
        quads[4 * k + 2] = f._mm512_shuffle_ps::<0x44>(high01, high23);
        quads[4 * k + 3] = f._mm512_shuffle_ps::<0xee>(high01, high23);
    }
    let mut out = [Block::ZERO; LANES];
    for c in 0..4 {
        let (a, b, c2, d) = (quads[c], quads[4 + c], quads[8 + c], quads[12 + c]);
        let (even, odd) =
            (f._mm512_shuffle_f32x4::<0x88>(a, b), f._mm512_shuffle_f32x4::<0xdd>(a, b));
        let (even2, odd2) =
            (f._mm512_shuffle_f32x4::<0x88>(c2, d), f._mm512_shuffle_f32x4::<0xdd>(c2, d));
        out[c].0 = cast(f._mm512_shuffle_f32x4::<0x88>(even, even2));
        out[8 + c].0 = cast(f._mm512_shuffle_f32x4::<0xdd>(even, even2));
        out[4 + c].0 = cast(f._mm512_shuffle_f32x4::<0x88>(odd, odd2));
        out[12 + c].0 = cast(f._mm512_shuffle_f32x4::<0xdd>(odd, odd2));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_become_rows() {
        let mut tile = [Block::ZERO; LANES];
        for i in 0..LANES * LANES {
            tile[i / LANES].0[i % LANES] = i as f32;
        }
        for isa in Isa::ALL {
            let out = Transpose::new(isa).tile(&tile);
            for i in 0..LANES * LANES {
                assert_eq!(out[i % LANES].0[i / LANES], i as f32, "{isa:?}");
            }
        }
    }
}
