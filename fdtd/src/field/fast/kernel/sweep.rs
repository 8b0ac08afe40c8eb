//! The interface of a scheme's sweep to the wavefront.

use super::super::super::stencil::Splat;
use super::near::Near;
#[cfg(target_arch = "x86_64")]
use super::vector::{Avx, Avx512};
use super::vector::{Plain, Vector};

/// A scheme's sweep.
pub(super) trait Sweep<V: Vector> {
    /// Rows of the centre. `now` and `next` point to the first vector of the first row's part, `vectors` long.
    ///
    /// # Safety
    /// As many rows and vectors beyond these as the stencil reaches, of `now`, and rows `0..rows` of `next` with as
    /// many vectors to both sides must be inside the buffers and free for this thread.
    unsafe fn rows(
        weights: &Splat<V>,
        now: *const f32,
        next: *mut f32,
        stride: usize,
        vectors: usize,
        rows: usize,
    );

    /// New pressure of cells amid `near`, whose past is `past`.
    ///
    /// # Safety
    /// As many rows and cells beyond these as the stencil reaches must be readable.
    unsafe fn cells<N: Near<V>>(weights: &Splat<V>, near: &N, past: V) -> V;

    /// Quantity whose second difference the absorbing layer along x takes, at some cells; turned, that of the layer
    /// along y.
    ///
    /// # Safety
    /// As many rows and cells beyond these as the stencil reaches but one must be readable.
    unsafe fn layered<N: Near<V>>(weights: &Splat<V>, near: &N) -> V;
}

/// A vector that rows of cells are swept with.
pub(super) trait SweepVector: Vector {
    /// [`Sweep::rows`], where registers are few as a function of its own: inlined into the one large function of a
    /// tile's sweep, the compiler then keeps hardly a pointer or a weight of the inner loop in a register, but loads
    /// them from the stack for every vector.
    ///
    /// # Safety
    /// As [`Sweep::rows`].
    #[inline(always)]
    unsafe fn sweep<S: Sweep<Self>>(
        weights: &Splat<Self>,
        now: *const f32,
        next: *mut f32,
        stride: usize,
        vectors: usize,
        rows: usize,
    ) {
        // SAFETY: the caller's promise.
        unsafe { S::rows(weights, now, next, stride, vectors, rows) }
    }
}

impl SweepVector for Plain {}

#[cfg(target_arch = "x86_64")]
impl SweepVector for Avx512 {}

#[cfg(target_arch = "x86_64")]
impl SweepVector for Avx {
    #[inline(always)]
    unsafe fn sweep<S: Sweep<Self>>(
        weights: &Splat<Self>,
        now: *const f32,
        next: *mut f32,
        stride: usize,
        vectors: usize,
        rows: usize,
    ) {
        #[inline(never)]
        #[target_feature(enable = "avx2,fma")]
        unsafe fn apart<S: Sweep<Avx>>(
            weights: &Splat<Avx>,
            now: *const f32,
            next: *mut f32,
            stride: usize,
            vectors: usize,
            rows: usize,
        ) {
            // A copy, which no store can change: the compiler would load the weights again after each.
            let weights = *weights;
            // SAFETY: the caller's promise.
            unsafe { S::rows(&weights, now, next, stride, vectors, rows) }
        }
        // SAFETY: the caller's promise.
        unsafe { apart::<S>(weights, now, next, stride, vectors, rows) }
    }
}
