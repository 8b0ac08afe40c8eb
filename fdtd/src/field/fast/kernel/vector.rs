//! Vectors of numbers: the operations that the sweeps need of an instruction set. Loads and stores go through raw
//! pointers; every function states its caller's obligations.

use super::super::super::step::{FLUSH_BELOW_PA, flush_subnormals};
use super::super::layout::{NARROW, WIDE};
use crate::number::Number;

/// A few numbers in registers.
pub(super) trait Vector: Number {
    /// Numbers in it.
    const LANES: usize;
    /// Whether registers are many: two rows of the 13-point stencil fit into them.
    const MANY: bool;
    /// The vector of eight numbers for the strips, whose layers are a multiple of eight wide.
    type Narrow: Vector;

    /// # Safety
    /// `at` must point to `LANES` readable numbers, and the instruction set be there.
    unsafe fn load(at: *const f32) -> Self;
    /// # Safety
    /// `at` must point to `LANES` writable numbers, and the instruction set be there.
    unsafe fn store(self, at: *mut f32);
    /// Itself, with zero for magnitudes below [`FLUSH_BELOW_PA`].
    fn flushed(self) -> Self;
    /// The first `count` numbers of `old`, then its own.
    fn after(self, old: Self, count: usize) -> Self;
    /// Every number moved one place up, `first` before them.
    fn moved_up(self, first: f32) -> Self;
    /// Every number moved one place down, `last` after them.
    fn moved_down(self, last: f32) -> Self;
    /// Prefetches the cache line at `at`, which may be any address.
    #[inline(always)]
    fn fetch(_at: *const f32) {}
}

/// Eight numbers as the target's default instructions hold them.
#[derive(Clone, Copy)]
pub(super) struct Plain([f32; NARROW]);

impl Vector for Plain {
    const LANES: usize = NARROW;
    const MANY: bool = false;
    type Narrow = Self;

    #[inline(always)]
    unsafe fn load(at: *const f32) -> Self {
        // SAFETY: the caller's promise.
        Self(unsafe { at.cast::<[f32; NARROW]>().read_unaligned() })
    }
    #[inline(always)]
    unsafe fn store(self, at: *mut f32) {
        // SAFETY: the caller's promise.
        unsafe { at.cast::<[f32; NARROW]>().write_unaligned(self.0) }
    }
    #[inline(always)]
    fn flushed(self) -> Self {
        let mut numbers = self.0;
        flush_subnormals(&mut numbers);
        Self(numbers)
    }
    #[inline(always)]
    fn after(self, old: Self, count: usize) -> Self {
        Self(std::array::from_fn(|i| {
            if i < count { old.0[i] } else { self.0[i] }
        }))
    }
    #[inline(always)]
    fn moved_up(self, first: f32) -> Self {
        Self(std::array::from_fn(|i| {
            if i == 0 { first } else { self.0[i - 1] }
        }))
    }
    #[inline(always)]
    fn moved_down(self, last: f32) -> Self {
        Self(std::array::from_fn(|i| {
            if i + 1 == NARROW { last } else { self.0[i + 1] }
        }))
    }
}

impl Number for Plain {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; NARROW])
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] * other.0[i]))
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(std::array::from_fn(|i| {
            self.0[i].mul_add(factor.0[i], term.0[i])
        }))
    }
    #[inline(always)]
    fn mul_sub(self, factor: Self, term: Self) -> Self {
        Self(std::array::from_fn(|i| {
            self.0[i].mul_add(factor.0[i], -term.0[i])
        }))
    }
}

/// Arithmetic of a vector by the intrinsics of its instruction set.
#[cfg(target_arch = "x86_64")]
macro_rules! number {
    ($vector:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident, $mul_add:ident, $mul_sub:ident) => {
        // SAFETY of all below: a vector is only made where its instructions are enabled.
        impl Number for $vector {
            #[inline(always)]
            fn splat(value: f32) -> Self {
                // SAFETY: see above.
                Self(unsafe { $splat(value) })
            }
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                // SAFETY: see above.
                Self(unsafe { $add(self.0, other.0) })
            }
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                // SAFETY: see above.
                Self(unsafe { $sub(self.0, other.0) })
            }
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                // SAFETY: see above.
                Self(unsafe { $mul(self.0, other.0) })
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, term: Self) -> Self {
                // SAFETY: see above.
                Self(unsafe { $mul_add(self.0, factor.0, term.0) })
            }
            #[inline(always)]
            fn mul_sub(self, factor: Self, term: Self) -> Self {
                // SAFETY: see above.
                Self(unsafe { $mul_sub(self.0, factor.0, term.0) })
            }
        }
    };
}

/// Eight numbers in an AVX register. Only made inside functions compiled for AVX2 and FMA.
#[cfg(target_arch = "x86_64")]
#[cfg_attr(fuzzing, expect(dead_code, reason = "its kernels are left out"))]
#[derive(Clone, Copy)]
pub(super) struct Avx(std::arch::x86_64::__m256);

#[cfg(target_arch = "x86_64")]
mod avx {
    use std::arch::x86_64::*;

    use super::{Avx, FLUSH_BELOW_PA, NARROW, Number, Vector};

    impl Vector for Avx {
        const LANES: usize = NARROW;
        const MANY: bool = false;
        type Narrow = Self;

        #[inline(always)]
        unsafe fn load(at: *const f32) -> Self {
            // SAFETY: the caller's promise.
            Self(unsafe { _mm256_loadu_ps(at) })
        }
        #[inline(always)]
        unsafe fn store(self, at: *mut f32) {
            // SAFETY: the caller's promise.
            unsafe { _mm256_storeu_ps(at, self.0) }
        }
        #[inline(always)]
        fn flushed(self) -> Self {
            // SAFETY: see below.
            unsafe {
                let size = _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0);
                let kept = _mm256_cmp_ps::<_CMP_NLT_UQ>(size, _mm256_set1_ps(FLUSH_BELOW_PA));
                Self(_mm256_and_ps(self.0, kept))
            }
        }
        #[inline(always)]
        fn after(self, old: Self, count: usize) -> Self {
            // SAFETY: see below.
            unsafe {
                let places = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
                let kept = _mm256_cmpgt_epi32(_mm256_set1_epi32(count as i32), places);
                Self(_mm256_blendv_ps(self.0, old.0, _mm256_castsi256_ps(kept)))
            }
        }
        #[inline(always)]
        fn moved_up(self, first: f32) -> Self {
            // SAFETY: see below.
            unsafe {
                let from = _mm256_setr_epi32(0, 0, 1, 2, 3, 4, 5, 6);
                let moved = _mm256_permutevar8x32_ps(self.0, from);
                Self(_mm256_blend_ps::<1>(moved, _mm256_set1_ps(first)))
            }
        }
        #[inline(always)]
        fn fetch(at: *const f32) {
            // SAFETY: a hint, which no address makes fail.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(at.cast()) }
        }
        #[inline(always)]
        fn moved_down(self, last: f32) -> Self {
            // SAFETY: see below.
            unsafe {
                let from = _mm256_setr_epi32(1, 2, 3, 4, 5, 6, 7, 7);
                let moved = _mm256_permutevar8x32_ps(self.0, from);
                Self(_mm256_blend_ps::<128>(moved, _mm256_set1_ps(last)))
            }
        }
    }

    number!(
        Avx,
        _mm256_set1_ps,
        _mm256_add_ps,
        _mm256_sub_ps,
        _mm256_mul_ps,
        _mm256_fmadd_ps,
        _mm256_fmsub_ps
    );
}

/// Sixteen numbers in an AVX-512 register. Only made inside functions compiled for AVX-512.
#[cfg(target_arch = "x86_64")]
#[cfg_attr(fuzzing, expect(dead_code, reason = "its kernels are left out"))]
#[derive(Clone, Copy)]
pub(super) struct Avx512(std::arch::x86_64::__m512);

#[cfg(target_arch = "x86_64")]
mod avx512 {
    use std::arch::x86_64::*;

    use super::{Avx512, FLUSH_BELOW_PA, Number, Vector, WIDE};

    impl Vector for Avx512 {
        const LANES: usize = WIDE;
        const MANY: bool = true;
        type Narrow = super::Avx;

        #[inline(always)]
        unsafe fn load(at: *const f32) -> Self {
            // SAFETY: the caller's promise.
            Self(unsafe { _mm512_loadu_ps(at) })
        }
        #[inline(always)]
        unsafe fn store(self, at: *mut f32) {
            // SAFETY: the caller's promise.
            unsafe { _mm512_storeu_ps(at, self.0) }
        }
        #[inline(always)]
        fn flushed(self) -> Self {
            // SAFETY: see below.
            unsafe {
                let size = _mm512_abs_ps(self.0);
                let kept = _mm512_cmp_ps_mask::<_CMP_NLT_UQ>(size, _mm512_set1_ps(FLUSH_BELOW_PA));
                Self(_mm512_maskz_mov_ps(kept, self.0))
            }
        }
        #[inline(always)]
        fn after(self, old: Self, count: usize) -> Self {
            let kept = ((1_u32 << count) - 1) as __mmask16;
            // SAFETY: see below.
            Self(unsafe { _mm512_mask_blend_ps(kept, self.0, old.0) })
        }
        #[inline(always)]
        fn moved_up(self, first: f32) -> Self {
            // SAFETY: see below.
            unsafe {
                let from = _mm512_setr_epi32(0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14);
                let first = _mm512_set1_ps(first);
                Self(_mm512_mask_permutexvar_ps(first, !1, from, self.0))
            }
        }
        #[inline(always)]
        fn moved_down(self, last: f32) -> Self {
            // SAFETY: see below.
            unsafe {
                let from = _mm512_setr_epi32(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 15);
                let last = _mm512_set1_ps(last);
                Self(_mm512_mask_permutexvar_ps(last, 0x7fff, from, self.0))
            }
        }
    }

    number!(
        Avx512,
        _mm512_set1_ps,
        _mm512_add_ps,
        _mm512_sub_ps,
        _mm512_mul_ps,
        _mm512_fmadd_ps,
        _mm512_fmsub_ps
    );
}
