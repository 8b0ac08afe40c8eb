//! The strips beside the centre with the layers along x.
//!
//! A vector of a strip takes the plain step and both layers while it is in registers: what the layers read is what the
//! stencil reads, and the new pressure is stored once. Several rows are taken one after the other, so that the layer's
//! decays stay in registers too.

use std::ops::Range;

use super::super::super::stencil::{Splat, face_memory, layer_cell};
use super::super::layout::{Column, NARROW};
use super::super::plan::Plan;
use super::along_y::LayerRow;
use super::near::{Loads, beside};
use super::shared::{Levels, Shared, Weights};
use super::sweep::Sweep;
use super::vector::Vector;

/// One step of some rows of the strips.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
pub(super) unsafe fn strips<V: Vector, S: Sweep<V> + Sweep<V::Narrow>>(
    plan: &Plan,
    shared: Shared,
    levels: Levels,
    weights: &Weights<V>,
    rows: Range<usize>,
) {
    // Rows of a layer along y apart from the others, whose loops are then short enough for the registers.
    let cells = plan.setup.layer.cells();
    let inside = |iy: usize| iy.clamp(rows.start, rows.end);
    let (low, high) = (inside(cells), inside(plan.setup.ny - cells));
    // SAFETY: the caller's promise.
    unsafe {
        if rows.start < low {
            strip_rows::<V, S, true>(plan, shared, levels, weights, rows.start..low);
        }
        if low < high {
            strip_rows::<V, S, false>(plan, shared, levels, weights, low..high);
        }
        if high < rows.end {
            strip_rows::<V, S, true>(plan, shared, levels, weights, high..rows.end);
        }
    }
}

/// [`strips`] for rows that all belong to a layer along y (`ALONG_Y`), or none.
///
/// # Safety
/// As [`strips`].
#[inline(always)]
unsafe fn strip_rows<V: Vector, S: Sweep<V> + Sweep<V::Narrow>, const ALONG_Y: bool>(
    plan: &Plan,
    shared: Shared,
    levels: Levels,
    weights: &Weights<V>,
    rows: Range<usize>,
) {
    // Copies, which no store can change.
    let (weights, narrow) = (&{ weights.wide }, &{ weights.narrow });
    for column in &plan.layout.columns {
        let (rows, x) = (rows.clone(), column.at);
        let wide = column.cells > NARROW;
        // SAFETY: the caller's promise.
        unsafe {
            match column.layer {
                Some((0, first)) if wide => {
                    layer_column::<V, S, 0, ALONG_Y>(plan, shared, levels, weights, x, first, rows)
                }
                Some((0, first)) => layer_column::<V::Narrow, S, 0, ALONG_Y>(
                    plan, shared, levels, narrow, x, first, rows,
                ),
                Some((_, first)) if wide => {
                    layer_column::<V, S, 1, ALONG_Y>(plan, shared, levels, weights, x, first, rows)
                }
                Some((_, first)) => layer_column::<V::Narrow, S, 1, ALONG_Y>(
                    plan, shared, levels, narrow, x, first, rows,
                ),
                None if column.foreign == 0 => plain_column::<V::Narrow, S, true, ALONG_Y>(
                    plan, shared, levels, narrow, column, rows,
                ),
                None => plain_column::<V::Narrow, S, false, ALONG_Y>(
                    plan, shared, levels, narrow, column, rows,
                ),
            }
        }
    }
}

/// One step of some rows of the column at `x`, whose cells in the layer along x on side `SIDE` (0 low, 1 high) begin
/// with `first`.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
unsafe fn layer_column<V: Vector, S: Sweep<V>, const SIDE: usize, const ALONG_Y: bool>(
    plan: &Plan,
    shared: Shared,
    levels: Levels,
    weights: &Splat<V>,
    x: usize,
    first: usize,
    rows: Range<usize>,
) {
    let stride = plan.layout.stride;
    let linear = V::splat(plan.setup.weights.linear);
    let open = V::splat(plan.setup.layer.open());
    let profile = if SIDE == 0 {
        &plan.setup.layer
    } else {
        &plan.high
    };
    let [face_at, cell_at] = plan.memory_x.at(SIDE);
    let memory_stride = plan.memory_x.stride();
    // SAFETY: the profile has a face more than cells, and these a multiple of eight; offsets come from the layout.
    unsafe {
        let face = profile.face.as_ptr().add(first);
        let decay = [
            V::load(face),
            V::load(face.add(1)),
            V::load(profile.cell.as_ptr().add(first)),
        ];
        let at = (rows.start + plan.layout.halo) * stride + x;
        let mut next = levels.next.add(at);
        let mut memory = shared.layer_x.add(rows.start * memory_stride + first);
        let mut near = Loads::plain(levels.now.add(at), stride);
        for iy in rows {
            let mut p = S::cells(weights, &near, V::load(next));
            if ALONG_Y && let Some(along_y) = LayerRow::new(plan, shared, iy) {
                p = along_y.absorb::<V, S, Loads>(weights, &near, x, p, 0);
            }
            let here = S::layered(weights, &near);
            let west = S::layered(weights, &beside(&near, -1, 0));
            let east = S::layered(weights, &beside(&near, 1, 0));
            let slopes = [here.sub(west), east.sub(here)];
            let (face, cell) = (memory.add(face_at), memory.add(cell_at));
            // The column farther in, which has the inner face of the last cell, comes later.
            let inner = if SIDE == 0 { face.add(1) } else { face.sub(1) };
            let (outer, inner) = (V::load(face), V::load(inner));
            let old = if SIDE == 0 {
                [outer, inner]
            } else {
                [inner, outer]
            };
            // Written out: a closure that is not inlined would call every vector instruction as a function.
            let lower = face_memory(decay[0], open, old[0], slopes[0]);
            let upper = face_memory(decay[1], open, old[1], slopes[1]);
            let (zeta, change) = layer_cell(slopes, [lower, upper], decay[2], open, V::load(cell));
            (if SIDE == 0 { lower } else { upper }).store(face);
            zeta.store(cell);
            linear.mul_add(change, p).store(next);
            near.here = near.here.add(stride);
            next = next.add(stride);
            memory = memory.add(memory_stride);
        }
    }
}

/// One step of some rows of a column outside the layers along x, `WHOLE` when all its cells are its own.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
unsafe fn plain_column<V: Vector, S: Sweep<V>, const WHOLE: bool, const ALONG_Y: bool>(
    plan: &Plan,
    shared: Shared,
    levels: Levels,
    weights: &Splat<V>,
    column: &Column,
    rows: Range<usize>,
) {
    let stride = plan.layout.stride;
    let foreign = if WHOLE { 0 } else { column.foreign };
    for iy in rows {
        let at = (iy + plan.layout.halo) * stride + column.at;
        // SAFETY: offsets come from the layout; what is foreign is written as it was.
        unsafe {
            let (now, next) = (levels.now.add(at), levels.next.add(at));
            let past = V::load(next);
            let near = Loads::plain(now, stride);
            let mut p = S::cells(weights, &near, past);
            if ALONG_Y && let Some(along_y) = LayerRow::new(plan, shared, iy) {
                p = along_y.absorb::<V, S, Loads>(weights, &near, column.at, p, foreign);
            }
            let p = if WHOLE { p } else { p.after(past, foreign) };
            p.store(next);
        }
    }
}
