//! Small numbers set to zero in flushing steps, see [`crate::field`].

use std::ops::Range;

use super::super::super::step::{flush_subnormals, layer_row};
use super::super::plan::Plan;
use super::shared::{Levels, Shared};
use super::vector::Vector;

/// Flushes the memory of the layers in some rows, before it is used.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
pub(super) unsafe fn memory<V: Vector>(plan: &Plan, shared: Shared, rows: Range<usize>) {
    let x = plan.memory_x.stride();
    // SAFETY: parts of the buffers, and of rows of this thread.
    unsafe { part::<V>(shared.layer_x.wrapping_add(rows.start * x), rows.len() * x) };
    let (cells, ny) = (plan.setup.layer.cells(), plan.setup.ny);
    // On the low side a row reads the memory of the next row's face too, which is as old as its own; a second time
    // changes nothing.
    for iy in rows.start..(rows.end + 1).min(ny) {
        if let Some(row) = layer_row(cells, ny, iy)
            && (iy < rows.end || !plan.memory_y.is_high(row))
        {
            let at = shared.layer_y.wrapping_add(plan.memory_y.face(row));
            // SAFETY: as above.
            unsafe { part::<V>(at, 2 * plan.layout.stride) };
        }
    }
}

/// Flushes the cells of some rows after their plain step.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
pub(super) unsafe fn cells<V: Vector>(plan: &Plan, levels: Levels, rows: Range<usize>) {
    let stride = plan.layout.stride;
    let first = (rows.start + plan.layout.halo) * stride;
    // SAFETY: rows of this thread.
    unsafe { part::<V>(levels.next.add(first), rows.len() * stride) };
}

/// Sets the small ones of `count` numbers to zero, vector by vector: left to itself the compiler stores those numbers
/// of a vector that change, which is slow on processors without AVX-512.
///
/// # Safety
/// They must be writable.
#[inline(always)]
unsafe fn part<V: Vector>(at: *mut f32, count: usize) {
    let whole = count - count % V::LANES;
    // SAFETY: the caller's promise.
    unsafe {
        for i in (0..whole).step_by(V::LANES) {
            V::load(at.add(i)).flushed().store(at.add(i));
        }
        flush_subnormals(std::slice::from_raw_parts_mut(at.add(whole), count - whole));
    }
}

/// Flushes the cells of some rows that walls have changed, and the memory of their surfaces.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
pub(super) unsafe fn walls(plan: &Plan, shared: Shared, levels: Levels, rows: Range<usize>) {
    // SAFETY: cells of rows of this thread, and memory of their surfaces, which belongs to who writes the row.
    let few = |at: *mut f32, count: usize| {
        flush_subnormals(unsafe { std::slice::from_raw_parts_mut(at, count) })
    };
    for corrections in &plan.walls.corrections {
        for &at in corrections.of(&rows).0 {
            few(levels.next.wrapping_add(at as usize), 1);
        }
    }
    for (iy, surfaces) in plan.walls.surfaces_of(&rows) {
        let row = levels
            .next
            .wrapping_add((iy + plan.layout.halo) * plan.layout.stride);
        for surface in surfaces {
            few(
                shared.surfaces.wrapping_add(surface.memory),
                surface.memory_count,
            );
            for &(offset, _) in &surface.gains {
                few(row.wrapping_add(offset as usize), 1);
            }
        }
    }
}
