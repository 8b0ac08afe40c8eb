//! The cells that a stencil reaches, as seen from one of them, and along either axis.

use super::vector::Vector;

/// Vectors of neighbouring cells.
pub(super) trait Near<V: Vector> {
    /// The cells `dx` columns to the east and `dy` rows to the north.
    ///
    /// # Safety
    /// They must be readable, and within the stencil's reach.
    unsafe fn at(&self, dx: isize, dy: isize) -> V;
}

/// Cells in memory.
#[derive(Clone, Copy)]
pub(super) struct Loads {
    pub(super) here: *const f32,
    /// Distance of the next column in memory.
    pub(super) ahead: usize,
    /// Distance of the next row.
    pub(super) stride: usize,
}

impl Loads {
    /// Cells of a row in plain order.
    #[inline(always)]
    pub(super) fn plain(here: *const f32, stride: usize) -> Self {
        Self {
            here,
            ahead: 1,
            stride,
        }
    }
}

impl<V: Vector> Near<V> for Loads {
    #[inline(always)]
    unsafe fn at(&self, dx: isize, dy: isize) -> V {
        // SAFETY: the caller's promise.
        unsafe {
            V::load(
                self.here
                    .offset(dx * self.ahead as isize + dy * self.stride as isize),
            )
        }
    }
}

/// The neighbourhood seen from another of its cells.
pub(super) struct Shifted<'a, N> {
    near: &'a N,
    dx: isize,
    dy: isize,
}

impl<V: Vector, N: Near<V>> Near<V> for Shifted<'_, N> {
    #[inline(always)]
    unsafe fn at(&self, dx: isize, dy: isize) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.near.at(self.dx + dx, self.dy + dy) }
    }
}

/// The neighbourhood with columns for rows.
pub(super) struct Turned<'a, N>(pub(super) &'a N);

impl<V: Vector, N: Near<V>> Near<V> for Turned<'_, N> {
    #[inline(always)]
    unsafe fn at(&self, dx: isize, dy: isize) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.0.at(dy, dx) }
    }
}

/// The neighbourhood of the cells `dx` columns to the east and `dy` rows to the north.
#[inline(always)]
pub(super) fn beside<N>(near: &N, dx: isize, dy: isize) -> Shifted<'_, N> {
    Shifted { near, dx, dy }
}
