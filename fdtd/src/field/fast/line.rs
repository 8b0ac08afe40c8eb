//! Cache lines of numbers.

/// Numbers in a cache line.
pub(super) const LINE: usize = 16;

/// A cache line; gives the buffers their alignment.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Line(pub(super) [f32; LINE]);
