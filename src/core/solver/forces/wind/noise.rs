//! Gusts: noise that is smooth in space and time and the same for the same seed.
//!
//! Value noise on a lattice of space and time: a random vector at each lattice point, blended between
//! the sixteen around a place by the quintic of Perlin, *Improving Noise* (2002), which has no kinks in
//! its slope. The random vectors are those of the hash `pcg4d` of Jarzynski and Olano, *Hash Functions
//! for GPU Rendering* (2020). All in integers, sums and products, so that every machine gives the
//! same bits. Places and times are split in f64 into a whole number of cells and the rest, so that
//! nothing is lost after hours or far from the origin.

use bevy_math::{DVec3, Vec3};

use crate::solver::forces::wind::Gusts;
use crate::solver::simd::block::Block3;
use crate::solver::simd::lanes::LANES;

/// The gusts of one instant, for places relative to an origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field {
    strength: f32,
    /// \[1/m\]
    inverse_scale: f32,
    /// Cell of the origin.
    cell: [u32; 3],
    /// Where in it the origin is, in cells.
    rest: Vec3,
    /// Cell of time.
    time: u32,
    /// Blend between its start and its end.
    late: f32,
}

impl Field {
    /// Gusts at `time` \[s\], for places relative to `origin` \[m\].
    pub fn new(gusts: &Gusts, time: f64, origin: Vec3) -> Self {
        let offset = offsets(gusts.seed);
        let place = origin.as_dvec3() / f64::from(gusts.scale);
        let time = time / f64::from(gusts.period);
        let (cell, rest) = (place.floor(), place - place.floor());
        let index = |cell: f64, i: usize| (cell as i64 as u32).wrapping_add(offset[i]);
        Self {
            strength: gusts.strength,
            inverse_scale: 1.0 / gusts.scale,
            cell: [index(cell.x, 0), index(cell.y, 1), index(cell.z, 2)],
            rest: as_vec3(rest),
            time: index(time.floor(), 3),
            late: fade((time - time.floor()) as f32),
        }
    }

    /// The gusts at places relative to the origin \[m/s\].
    #[inline(always)]
    pub fn block(&self, places: &Block3) -> Block3 {
        let (mut xs, mut ys, mut zs) = ([0_u32; LANES], [0_u32; LANES], [0_u32; LANES]);
        let mut parts = Block3::ZERO;
        for i in 0..LANES {
            let p = places.at(i) * self.inverse_scale + self.rest;
            let ((x, fx), (y, fy), (z, fz)) = (split(p.x), split(p.y), split(p.z));
            xs[i] = self.cell[0].wrapping_add(x);
            ys[i] = self.cell[1].wrapping_add(y);
            zs[i] = self.cell[2].wrapping_add(z);
            parts.set(i, Vec3::new(fade(fx), fade(fy), fade(fz)));
        }
        let mut gusts = Block3::ZERO;
        for corner in 0..16_u32 {
            let [x, y, z, t] = [0, 1, 2, 3].map(|axis| corner >> axis & 1);
            let late = if t == 1 { self.late } else { 1.0 - self.late };
            let time = self.time.wrapping_add(t);
            for i in 0..LANES {
                let part = parts.at(i);
                let along_x = if x == 1 { part.x } else { 1.0 - part.x };
                let along_y = if y == 1 { part.y } else { 1.0 - part.y };
                let along_z = if z == 1 { part.z } else { 1.0 - part.z };
                let weight = (along_x * along_y) * (along_z * late);
                let point = lattice_point(
                    xs[i].wrapping_add(x),
                    ys[i].wrapping_add(y),
                    zs[i].wrapping_add(z),
                    time,
                );
                gusts.set(i, gusts.at(i) + point * weight);
            }
        }
        for i in 0..LANES {
            gusts.set(i, gusts.at(i) * self.strength);
        }
        gusts
    }

    /// The gust at the origin \[m/s\].
    pub fn here(&self) -> Vec3 {
        self.block(&Block3::ZERO).at(0)
    }
}

fn as_vec3(v: DVec3) -> Vec3 {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

/// The cell of a coordinate, and the place in it. Not `f32::floor`, which may be a call.
#[inline(always)]
fn split(p: f32) -> (u32, f32) {
    let towards_zero = p as i32;
    let cell = towards_zero.wrapping_sub(i32::from(p < towards_zero as f32));
    (cell as u32, p - cell as f32)
}

/// `6 t^5 - 15 t^4 + 10 t^3`.
#[inline(always)]
fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// A vector with coordinates from -1 to 1, at random: `pcg4d`.
#[inline(always)]
fn lattice_point(x: u32, y: u32, z: u32, t: u32) -> Vec3 {
    let step = |v: u32| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let (mut x, mut y, mut z, mut t) = (step(x), step(y), step(z), step(t));
    x = x.wrapping_add(y.wrapping_mul(t));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    t = t.wrapping_add(y.wrapping_mul(z));
    (x, y, z, t) = (x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16), t ^ (t >> 16));
    x = x.wrapping_add(y.wrapping_mul(t));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    // The highest bits are the best; as many as f32 holds.
    let unit = |v: u32| (v >> 8) as i32 as f32 * (1.0 / 8_388_608.0) - 1.0;
    Vec3::new(unit(x), unit(y), unit(z))
}

/// Where in the lattice a seed begins: `SplitMix64` (Steele, Lea and Flood 2014).
fn offsets(seed: u64) -> [u32; 4] {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let (a, b) = (next(), next());
    [a as u32, (a >> 32) as u32, b as u32, (b >> 32) as u32]
}
