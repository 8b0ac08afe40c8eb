//! What a scheme's sweep is to the wavefront.

use super::super::super::stencil::Splat;
use super::near::Near;
use super::vector::Vector;

/// A scheme's sweep.
pub(super) trait Sweep<V: Vector> {
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
