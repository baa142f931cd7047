//! Which vector instructions a kernel runs on.
//!
//! Every kernel is one body, compiled once for each instruction set and chosen at run time. Rust
//! neither contracts nor reorders floating point, so all of them give the same bits.

use crate::solver::simd::transpose::{Plain, Transpose};

/// A vector instruction set of x86-64. Other processors have [`Isa::Baseline`] alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Isa {
    /// The instruction set that the crate was compiled for: SSE2 on x86-64, unless built with more.
    Baseline,
    /// AVX2, with the rest of the x86-64-v3 level.
    Avx2,
    /// AVX-512 (F, BW, CD, DQ, VL), the x86-64-v4 level.
    Avx512,
}

impl Isa {
    /// All instruction sets, the narrowest first.
    pub const ALL: [Self; 3] = [Self::Baseline, Self::Avx2, Self::Avx512];

    /// The widest instruction set of the machine at hand.
    pub fn detect() -> Self {
        Self::ALL.into_iter().rev().find(|isa| isa.is_available()).unwrap_or(Self::Baseline)
    }

    /// Whether the machine at hand has this instruction set.
    pub fn is_available(self) -> bool {
        match self {
            Self::Baseline => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => pulp::x86::V3::is_available(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => pulp::x86::V4::is_available(),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }

    /// Runs a kernel that is given the means to exchange rows and columns.
    #[inline(always)]
    pub(crate) fn run_transposing<K: TransposingKernel>(self, kernel: K) -> K::Output {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Baseline => {}
            Self::Avx2 => {
                if let Some(v3) = pulp::x86::V3::try_new() {
                    return v3.vectorize(CallWith(kernel, v3));
                }
            }
            Self::Avx512 => {
                if let Some(v4) = pulp::x86::V4::try_new() {
                    return v4.vectorize(CallWith(kernel, v4));
                }
            }
        }
        kernel.run(Plain)
    }

    /// Runs `kernel` compiled for this instruction set, or for the baseline where the machine
    /// lacks it.
    #[inline(always)]
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Baseline => {}
            Self::Avx2 => {
                if let Some(v3) = pulp::x86::V3::try_new() {
                    return v3.vectorize(Call(kernel));
                }
            }
            Self::Avx512 => {
                if let Some(v4) = pulp::x86::V4::try_new() {
                    return v4.vectorize(Call(kernel));
                }
            }
        }
        kernel.run()
    }
}

/// A loop over particles, compiled once for each instruction set.
///
/// An implementation marks `run`, and every function that it calls, `#[inline(always)]`: a function
/// that is not inlined keeps the baseline's instructions.
pub(crate) trait Kernel {
    /// The result of the kernel.
    type Output;
    /// Runs the loop.
    fn run(self) -> Self::Output;
}

/// A [`Kernel`] that exchanges rows and columns.
pub(crate) trait TransposingKernel {
    /// The result of the kernel.
    type Output;
    /// Runs the loop.
    fn run(self, transpose: impl Transpose) -> Self::Output;
}

#[cfg(target_arch = "x86_64")]
struct CallWith<K, T>(K, T);

#[cfg(target_arch = "x86_64")]
impl<K: TransposingKernel, T: Transpose> pulp::NullaryFnOnce for CallWith<K, T> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> K::Output {
        self.0.run(self.1)
    }
}

#[cfg(target_arch = "x86_64")]
struct Call<K>(K);

#[cfg(target_arch = "x86_64")]
impl<K: Kernel> pulp::NullaryFnOnce for Call<K> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> K::Output {
        self.0.run()
    }
}
