//! The halos of a row, after its step.

use super::super::layout::RowLayout;
use super::vector::Vector;

/// Rebuilds the halos of the row at `row`. With aligned loads and stores only, whole vectors each: a vector read one
/// cell off, or one completed by a single cell, would wait until its stores have left the processor's queue.
///
/// # Safety
/// The row must be this thread's.
#[inline(always)]
pub(super) unsafe fn refresh<V: Vector>(layout: &RowLayout, row: *mut f32) {
    if layout.centre == 0 {
        return;
    }
    let halo = layout.halo;
    // SAFETY: offsets come from the layout, vectors of which `V` is one of.
    unsafe {
        let first = row.add(layout.centre_at);
        let after = first.add(layout.centre * V::LANES);
        let (low_end, high) = (row.add(layout.low_at + layout.low), row.add(layout.high_at));
        let (before, last) = (first.sub(halo * V::LANES), after.sub(halo * V::LANES));
        for h in 0..halo {
            let at = h * V::LANES;
            // Lane l continues in lane l + 1; the outer lanes continue in the strips.
            V::load(last.add(at))
                .moved_up(*low_end.sub(halo).add(h))
                .store(before.add(at));
            V::load(first.add(at))
                .moved_down(*high.add(h))
                .store(after.add(at));
            // Strips see the lanes next to them.
            *low_end.add(h) = *first.add(at);
            *high.sub(halo).add(h) = *last.add(at + V::LANES - 1);
        }
    }
}
