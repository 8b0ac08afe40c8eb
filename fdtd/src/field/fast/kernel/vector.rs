//! Vectors of numbers: what the sweeps need of an instruction set.
//! Loads and stores go through raw pointers; every function states what its caller promises.

use super::super::super::stencil::Number;
use super::super::layout::{NARROW, WIDE};

/// A few numbers in registers.
pub(super) trait Vector: Number {
    /// How many.
    const LANES: usize;
    /// Whether two rows of the 13-point stencil fit into the registers.
    const MANY: bool;
    /// The vector of eight numbers for the layers along x, whose width is a multiple of eight.
    type Narrow: Vector;

    /// # Safety
    /// `at` must point to `LANES` readable numbers, and the instruction set be there.
    unsafe fn load(at: *const f32) -> Self;
    /// # Safety
    /// `at` must point to `LANES` writable numbers, and the instruction set be there.
    unsafe fn store(self, at: *mut f32);
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

/// Eight numbers in an AVX register. Only made inside functions compiled for AVX2 and FMA.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
pub(super) struct Avx(std::arch::x86_64::__m256);

#[cfg(target_arch = "x86_64")]
mod avx {
    use std::arch::x86_64::*;

    use super::{Avx, NARROW, Number, Vector};

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
    }

    // SAFETY of all below: an `Avx` is only made where AVX2 and FMA are enabled.
    impl Number for Avx {
        #[inline(always)]
        fn splat(value: f32) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_set1_ps(value) })
        }
        #[inline(always)]
        fn add(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_add_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_sub_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_mul_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn mul_add(self, factor: Self, term: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_fmadd_ps(self.0, factor.0, term.0) })
        }
        #[inline(always)]
        fn mul_sub(self, factor: Self, term: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_fmsub_ps(self.0, factor.0, term.0) })
        }
    }
}

/// Sixteen numbers in an AVX-512 register. Only made inside functions compiled for AVX-512.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
pub(super) struct Avx512(std::arch::x86_64::__m512);

#[cfg(target_arch = "x86_64")]
mod avx512 {
    use std::arch::x86_64::*;

    use super::{Avx512, Number, Vector, WIDE};

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
    }

    // SAFETY of all below: an `Avx512` is only made where AVX-512 is enabled.
    impl Number for Avx512 {
        #[inline(always)]
        fn splat(value: f32) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm512_set1_ps(value) })
        }
        #[inline(always)]
        fn add(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm512_add_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm512_sub_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm512_mul_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn mul_add(self, factor: Self, term: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm512_fmadd_ps(self.0, factor.0, term.0) })
        }
        #[inline(always)]
        fn mul_sub(self, factor: Self, term: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm512_fmsub_ps(self.0, factor.0, term.0) })
        }
    }
}
