//! What a scheme's sweep is to the wavefront.

use std::marker::PhantomData;

use super::super::super::stencil::Splat;
use super::near::Near;
use super::task::Task;
use super::vector::Vector;

/// A scheme's sweep.
pub(super) trait Sweep<V: Vector> {
    /// Rows that a step of the wavefront takes together.
    const ROWS: usize;
    /// Cells of the centre that these rows take one after the other: all they touch then stays in the first-level cache,
    /// and each vector comes from the second level once per block.
    const CHUNK: usize;

    /// Rows of the centre. `now` and `next` point to the first vector of the first row's part, `vectors` long.
    ///
    /// # Safety
    /// As many rows and vectors beyond these as the stencil reaches, of `now`, and rows `0..rows` of `next` with as many
    /// vectors to both sides must be inside the buffers and free for this thread.
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

    /// What the absorbing layer along x takes the second difference of at some cells; turned, that along y.
    ///
    /// # Safety
    /// As many rows and cells beyond these as the stencil reaches but one must be readable.
    unsafe fn layered<N: Near<V>>(weights: &Splat<V>, near: &N) -> V;
}

/// [`Sweep::rows`] as a task.
pub(super) struct Rows<'a, V, S> {
    pub(super) weights: &'a Splat<V>,
    pub(super) now: *const f32,
    pub(super) next: *mut f32,
    pub(super) stride: usize,
    pub(super) vectors: usize,
    pub(super) rows: usize,
    pub(super) sweep: PhantomData<S>,
}

impl<V: Vector, S: Sweep<V>> Task for Rows<'_, V, S> {
    #[inline(always)]
    unsafe fn run(self) {
        // A copy, which no store can change: the compiler would load the weights again after each.
        let weights = *self.weights;
        let (now, next) = (self.now, self.next);
        // SAFETY: the maker's promise.
        unsafe { S::rows(&weights, now, next, self.stride, self.vectors, self.rows) }
    }
}
