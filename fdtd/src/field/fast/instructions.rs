//! The instruction sets that the sweeps are compiled for.

use super::layout::{NARROW, WIDE};

/// An instruction set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InstructionSet {
    /// AVX-512 (F and VL) with fused multiply-add, sixteen numbers at a time.
    Avx512,
    /// AVX2 with fused multiply-add.
    Avx2,
    /// The target's default instructions (NEON on 64-bit Arm).
    Portable,
}

impl InstructionSet {
    /// Numbers in one of its vectors.
    pub(super) fn lanes(self) -> usize {
        match self {
            Self::Avx512 => WIDE,
            Self::Avx2 | Self::Portable => NARROW,
        }
    }

    /// The best one of this machine.
    pub fn detect() -> Self {
        #[cfg(all(target_arch = "x86_64", not(fuzzing)))]
        {
            use std::arch::is_x86_feature_detected as has;
            if has!("avx2") && has!("fma") {
                let wide = has!("avx512f") && has!("avx512vl");
                return if wide { Self::Avx512 } else { Self::Avx2 };
            }
        }
        Self::Portable
    }
}
