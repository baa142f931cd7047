//! Gusts: noise that is smooth in space and time and the same for the same seed.
//!
//! Value noise on a lattice of space and time: a random vector at each lattice point, blended between
//! the sixteen around a place by the quintic of Perlin, *Improving Noise* (2002), which has no kinks in
//! its slope. The random vectors are those of the hash `pcg4d` of Jarzynski and Olano, *Hash Functions
//! for GPU Rendering* (2020). All in integers, sums and products, so that every machine gives the
//! same bits. Places and times are split in f64 into a whole number of cells and the rest, so that
//! nothing is lost after hours or far from the origin.

use bevy::math::{DVec3, Vec3};

use super::Gusts;

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

    /// The gust at a place relative to the origin \[m/s\].
    #[inline(always)]
    pub fn at(&self, place: Vec3) -> Vec3 {
        let p = place * self.inverse_scale + self.rest;
        let (x, fx) = split(p.x);
        let (y, fy) = split(p.y);
        let (z, fz) = split(p.z);
        let [x, y, z] = [
            self.cell[0].wrapping_add(x),
            self.cell[1].wrapping_add(y),
            self.cell[2].wrapping_add(z),
        ];
        let (fx, fy, fz) = (fade(fx), fade(fy), fade(fz));
        let edge = |y: u32, z: u32, t: u32| {
            let (a, b) = (lattice_point(x, y, z, t), lattice_point(x.wrapping_add(1), y, z, t));
            a + (b - a) * fx
        };
        let square = |z: u32, t: u32| {
            let (a, b) = (edge(y, z, t), edge(y.wrapping_add(1), z, t));
            a + (b - a) * fy
        };
        let cube = |t: u32| {
            let (a, b) = (square(z, t), square(z.wrapping_add(1), t));
            a + (b - a) * fz
        };
        let (a, b) = (cube(self.time), cube(self.time.wrapping_add(1)));
        (a + (b - a) * self.late) * self.strength
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
