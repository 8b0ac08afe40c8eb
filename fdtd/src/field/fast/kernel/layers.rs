//! The strips beside the centre with the layers along x, and the layers along y.
//!
//! A vector of a strip takes the plain step and both layers while it is in registers: what the layers read is what the stencil
//! reads, and the new pressure is stored once. Several rows are taken one after the other, so that the layer's decays stay in
//! registers too.

use std::ops::Range;

use super::super::super::layer_row;
use super::super::super::stencil::{Splat, layer};
use super::super::Plan;
use super::super::layout::Column;
use super::sweep::Sweep;
use super::vector::Vector;
use super::{Levels, Shared};

/// One step of some rows of the strips.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
pub(super) unsafe fn strips<V: Vector, S: Sweep<V>>(
    plan: &Plan,
    shared: Shared,
    levels: Levels,
    rows: Range<usize>,
) {
    let weights = Splat::<V>::new(&plan.setup.weights);
    for column in &plan.layout.columns {
        // SAFETY: the caller's promise.
        unsafe {
            match (column.layer, column.foreign) {
                (Some((side, first)), 0) => {
                    let strip = (side, first);
                    layer_column::<V, S>(
                        plan,
                        shared,
                        levels,
                        &weights,
                        column,
                        strip,
                        rows.clone(),
                    );
                }
                (_, 0) => {
                    plain_column::<V, S, true>(
                        plan,
                        shared,
                        levels,
                        &weights,
                        column,
                        rows.clone(),
                    );
                }
                _ => {
                    plain_column::<V, S, false>(
                        plan,
                        shared,
                        levels,
                        &weights,
                        column,
                        rows.clone(),
                    );
                }
            }
        }
    }
}

/// One step of some rows of a column in the layer along x.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
unsafe fn layer_column<V: Vector, S: Sweep<V>>(
    plan: &Plan,
    shared: Shared,
    levels: Levels,
    weights: &Splat<V>,
    column: &Column,
    (side, first): (usize, usize),
    rows: Range<usize>,
) {
    let stride = plan.layout.stride;
    let width = plan.setup.layer.width();
    let courant2 = V::splat(plan.setup.courant2);
    let profile = [&plan.setup.layer, &plan.high][side];
    // SAFETY: the profile has a face more than cells, and these a multiple of eight; offsets come from the layout.
    unsafe {
        let face = profile.face.as_ptr().add(first);
        let decay = [
            V::load(face),
            V::load(face.add(1)),
            V::load(profile.cell.as_ptr().add(first)),
        ];
        for iy in rows {
            let at = (iy + plan.layout.halo) * stride + column.at;
            let (now, next) = (levels.now.add(at), levels.next.add(at));
            let mut p = S::cells(weights, now, stride, V::load(next));
            if let Some(along_y) = LayerRow::new(plan, shared, iy) {
                p = along_y.absorb::<V, S>(weights, now, 1, column.at, p, 0);
            }
            let layered = |at: *const f32| S::layered(weights, at, 1, stride);
            let here = layered(now);
            let slopes = [here.sub(layered(now.sub(1))), layered(now.add(1)).sub(here)];
            let memory = shared.layer_x.add((iy * 2 + side) * 3 * width + first);
            absorb(slopes, decay, memory, width, courant2, p, 0).store(next);
        }
    }
}

/// One step of some rows of a column outside the layers along x, `WHOLE` when all its cells are its own.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
unsafe fn plain_column<V: Vector, S: Sweep<V>, const WHOLE: bool>(
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
            let mut p = S::cells(weights, now, stride, past);
            if let Some(along_y) = LayerRow::new(plan, shared, iy) {
                p = along_y.absorb::<V, S>(weights, now, 1, column.at, p, foreign);
            }
            let p = if WHOLE { p } else { p.after(past, foreign) };
            p.store(next);
        }
    }
}

/// The layers along y on some vectors of the centre in some rows, after the plain step.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
pub(super) unsafe fn along_y<V: Vector, S: Sweep<V>>(
    plan: &Plan,
    shared: Shared,
    levels: Levels,
    weights: &Splat<V>,
    vectors: Range<usize>,
    rows: Range<usize>,
) {
    for iy in rows {
        let Some(layer) = LayerRow::new(plan, shared, iy) else {
            continue;
        };
        let row = (iy + plan.layout.halo) * plan.layout.stride;
        for j in vectors.clone() {
            let x = plan.layout.centre_at + j * V::LANES;
            // SAFETY: the caller's promise.
            unsafe {
                let next = levels.next.add(row + x);
                layer
                    .absorb::<V, S>(
                        weights,
                        levels.now.add(row + x),
                        V::LANES,
                        x,
                        V::load(next),
                        0,
                    )
                    .store(next);
            }
        }
    }
}

/// A row of a layer along y.
struct LayerRow {
    stride: usize,
    courant2: f32,
    decay: [f32; 3],
    /// Memory of its first cell.
    memory: *mut f32,
}

impl LayerRow {
    /// Row `iy`, if it belongs to a layer.
    #[inline(always)]
    fn new(plan: &Plan, shared: Shared, iy: usize) -> Option<Self> {
        let decay = plan.row_decay[iy]?;
        let row = layer_row(plan.setup.layer.cells(), plan.setup.ny, iy)?;
        let stride = plan.layout.stride;
        Some(Self {
            stride,
            courant2: plan.setup.courant2,
            decay,
            memory: shared.layer_y.wrapping_add(row * 3 * stride),
        })
    }

    /// New pressure after the layer of the vector at `now`, `x` from the start of the row, from the one before; `ahead` is the
    /// distance of the next cell along x in memory.
    ///
    /// # Safety
    /// The vector's memory must be this thread's, what the layer reads of `now` be readable.
    #[inline(always)]
    unsafe fn absorb<V: Vector, S: Sweep<V>>(
        &self,
        weights: &Splat<V>,
        now: *const f32,
        ahead: usize,
        x: usize,
        p: V,
        foreign: usize,
    ) -> V {
        let stride = self.stride;
        // SAFETY: the caller's promise.
        unsafe {
            let layered = |at: *const f32| S::layered(weights, at, stride, ahead);
            let here = layered(now);
            let slopes = [
                here.sub(layered(now.sub(stride))),
                layered(now.add(stride)).sub(here),
            ];
            let decay = self.decay.map(V::splat);
            let courant2 = V::splat(self.courant2);
            absorb(
                slopes,
                decay,
                self.memory.add(x),
                stride,
                courant2,
                p,
                foreign,
            )
        }
    }
}

/// The layer's recursion at a vector of cells whose memory lies at `memory`, three parts `part` apart, of which the first `foreign`
/// stay as they are; gives the new pressure from that without layer.
///
/// # Safety
/// A vector's numbers at each part of the memory must be this thread's.
#[inline(always)]
unsafe fn absorb<V: Vector>(
    slopes: [V; 2],
    decay: [V; 3],
    memory: *mut f32,
    part: usize,
    courant2: V,
    p: V,
    foreign: usize,
) -> V {
    // SAFETY: the caller's promise.
    unsafe {
        let old = std::array::from_fn(|k| V::load(memory.add(k * part)));
        let (new, change) = layer(slopes, decay, old);
        for (k, (value, old)) in new.into_iter().zip(old).enumerate() {
            let value = if foreign == 0 {
                value
            } else {
                value.after(old, foreign)
            };
            value.store(memory.add(k * part));
        }
        courant2.mul_add(change, p)
    }
}
