//! Bits, to be the same.

use bevy_drape::solver::ClothSolver;

/// The bits of all positions relative to the origin, and velocities.
pub fn bits(solver: &ClothSolver) -> Vec<[u32; 6]> {
    (0..solver.topology().particle_count())
        .map(|i| {
            let (x, v) = (solver.local_position(i), solver.velocity(i));
            [x.x, x.y, x.z, v.x, v.y, v.z].map(f32::to_bits)
        })
        .collect()
}

/// Fowler, Noll and Vo's hash (FNV-1a, 64 bits).
pub struct Fingerprint(pub u64);

impl Default for Fingerprint {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fingerprint {
    pub fn add<const N: usize>(&mut self, bits: &[[u32; N]]) {
        for byte in bits.iter().flatten().flat_map(|word| word.to_le_bytes()) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// Of some bits.
    pub fn of<const N: usize>(bits: &[[u32; N]]) -> u64 {
        let mut fingerprint = Self::default();
        fingerprint.add(bits);
        fingerprint.0
    }
}
