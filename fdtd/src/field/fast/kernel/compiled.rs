//! Functions compiled for an instruction set.

use super::super::instructions::InstructionSet;

/// Runs `work` compiled for AVX2 with fused multiply-add.
///
/// # Panics
/// When the machine has no such instructions.
#[cfg(target_arch = "x86_64")]
pub(in crate::field) fn with_avx2<R>(work: impl FnOnce() -> R) -> R {
    #[target_feature(enable = "avx2,fma")]
    fn inside<R>(work: impl FnOnce() -> R) -> R {
        work()
    }
    assert!(
        InstructionSet::detect() != InstructionSet::Portable,
        "no AVX2 with FMA here"
    );
    // SAFETY: just checked.
    unsafe { inside(work) }
}

/// Runs `work` compiled for AVX-512.
///
/// # Panics
/// When the machine has no such instructions.
#[cfg(target_arch = "x86_64")]
pub(in crate::field) fn with_avx512<R>(work: impl FnOnce() -> R) -> R {
    #[target_feature(enable = "avx512f,avx512vl,avx2,fma")]
    fn inside<R>(work: impl FnOnce() -> R) -> R {
        work()
    }
    assert!(
        InstructionSet::detect() == InstructionSet::Avx512,
        "no AVX-512 here"
    );
    // SAFETY: just checked.
    unsafe { inside(work) }
}
