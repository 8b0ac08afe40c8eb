//! Changes at walls in some rows after their plain step.

use std::ops::Range;

use super::super::plan::Plan;
use super::super::walls::{Corrections, RowSurface, Walls};
use super::shared::{Levels, Shared};
use crate::boundary::Reaction;

/// Corrects the cells of some rows whose stencils meet walls. The numbers of entries named here are those of flat walls
/// of whole cells and their ends.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
pub(super) unsafe fn correct(walls: &Walls, levels: Levels, rows: &Range<usize>) {
    for corrections in &walls.corrections {
        // SAFETY: the caller's promise.
        unsafe {
            match corrections.each {
                1 => group::<1>(corrections, levels, rows),
                2 => group::<2>(corrections, levels, rows),
                4 => group::<4>(corrections, levels, rows),
                5 => group::<5>(corrections, levels, rows),
                8 => group::<8>(corrections, levels, rows),
                9 => group::<9>(corrections, levels, rows),
                each => any_group(each, corrections, levels, rows),
            }
        }
    }
}

/// Corrects cells with `EACH` entries.
///
/// # Safety
/// As [`correct`].
#[inline(always)]
unsafe fn group<const EACH: usize>(cells: &Corrections, levels: Levels, rows: &Range<usize>) {
    // SAFETY: the caller's promise.
    unsafe { any_group(EACH, cells, levels, rows) }
}

/// As [`group`], for numbers that are rare.
///
/// # Safety
/// As [`correct`].
#[inline(always)]
unsafe fn any_group(each: usize, cells: &Corrections, levels: Levels, rows: &Range<usize>) {
    let (cells, entries) = cells.of(rows);
    for (&at, entries) in cells.iter().zip(entries.chunks_exact(each)) {
        // SAFETY: offsets come from the layout, the cells from these rows.
        unsafe {
            let now = levels.now.add(at as usize);
            let mut sum = 0.0_f32;
            for &(offset, weight) in entries {
                sum = weight.mul_add(*now.offset(offset as isize), sum);
            }
            *levels.next.add(at as usize) += sum;
        }
    }
}

/// Silences the cells of some rows that lie inside walls.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
pub(super) unsafe fn silence(walls: &Walls, levels: Levels, rows: &Range<usize>) {
    for &at in walls.solid.of(rows) {
        // SAFETY: offsets come from the layout, the cells from these rows.
        unsafe { *levels.next.add(at as usize) = 0.0 };
    }
}

/// Advances the surfaces of some rows and subtracts their flow from the cells.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
pub(super) unsafe fn react(plan: &Plan, shared: Shared, levels: Levels, rows: &Range<usize>) {
    for (iy, surfaces) in plan.walls.surfaces_of(rows) {
        let at = (iy + plan.layout.halo) * plan.layout.stride;
        // SAFETY: the caller's promise.
        unsafe { react_row(surfaces, shared, levels.now.add(at), levels.next.add(at)) };
    }
}

/// Advances the surfaces of a row, which begins at `now` and `next`.
///
/// # Safety
/// As [`super::run_tile`], for this row.
#[inline(always)]
unsafe fn react_row(surfaces: &[RowSurface], shared: Shared, now: *const f32, next: *mut f32) {
    for surface in surfaces {
        // SAFETY: the caller's promise; the memory of a row's surfaces belongs to who writes the row.
        unsafe {
            let memory = shared.surfaces.add(surface.memory);
            let memory = std::slice::from_raw_parts_mut(memory, surface.memory_count);
            let mut sum = match surface.reaction {
                Reaction::Decay(decay) => decay * memory[0],
                Reaction::Branches(_) => 0.0,
            };
            for &(offset, weight) in &surface.taps {
                sum = weight.mul_add(*now.offset(offset as isize), sum);
            }
            let change = match &surface.reaction {
                Reaction::Decay(_) => std::mem::replace(&mut memory[0], sum) - sum,
                Reaction::Branches(branches) => branches.step(sum, memory),
            };
            for &(offset, gain) in &surface.gains {
                let p = next.add(offset as usize);
                *p = gain.mul_add(change, *p);
            }
        }
    }
}
