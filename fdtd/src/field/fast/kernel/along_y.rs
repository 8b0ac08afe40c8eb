//! The layers along y: on the vectors of the centre, column by column, and on those of the strips one row at a time.

use std::ops::Range;

use super::super::super::stencil::{Splat, face_memory, layer_cell};
use super::super::super::step::layer_row;
use super::super::plan::Plan;
use super::near::{Loads, Near, Turned, beside};
use super::shared::{Levels, Shared};
use super::sweep::Sweep;
use super::vector::Vector;

/// The layers along y on some vectors of the centre in some rows, after the plain step.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
pub(super) unsafe fn centre<V: Vector, S: Sweep<V>>(
    plan: &Plan,
    shared: Shared,
    levels: Levels,
    weights: &Splat<V>,
    vectors: Range<usize>,
    rows: Range<usize>,
) {
    let cells = plan.setup.layer.cells();
    let low = rows.start..rows.end.min(cells);
    let high = rows.start.max(plan.setup.ny - cells)..rows.end;
    // SAFETY: the caller's promise.
    unsafe {
        if !low.is_empty() {
            centre_columns::<V, S, false>(plan, shared, levels, weights, vectors.clone(), low);
        }
        if !high.is_empty() {
            centre_columns::<V, S, true>(plan, shared, levels, weights, vectors, high);
        }
    }
}

/// The layer along y on side `HIGH` in some columns of vectors of the centre. Where registers are few vectors are
/// short, and two share a cache line and are taken together.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
unsafe fn centre_columns<V: Vector, S: Sweep<V>, const HIGH: bool>(
    plan: &Plan,
    shared: Shared,
    levels: Levels,
    weights: &Splat<V>,
    vectors: Range<usize>,
    rows: Range<usize>,
) {
    let at = |j: usize| plan.layout.centre_at + j * V::LANES;
    let mut j = vectors.start;
    // SAFETY: the caller's promise.
    unsafe {
        while !V::MANY && j + 2 <= vectors.end {
            let rows = rows.clone();
            centre_column::<V, S, HIGH, 2>(plan, shared, levels, weights, at(j), rows);
            j += 2;
        }
        for j in j..vectors.end {
            let rows = rows.clone();
            centre_column::<V, S, HIGH, 1>(plan, shared, levels, weights, at(j), rows);
        }
    }
}

/// The layer along y on side `HIGH` in the column of `COUNT` vectors at `x` of the centre, rows in ascending order: a
/// row's upper slope and face are the next row's lower ones.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
#[inline(always)]
unsafe fn centre_column<V: Vector, S: Sweep<V>, const HIGH: bool, const COUNT: usize>(
    plan: &Plan,
    shared: Shared,
    levels: Levels,
    weights: &Splat<V>,
    x: usize,
    rows: Range<usize>,
) {
    let Some(first) = LayerRow::new(plan, shared, rows.start) else {
        return;
    };
    let stride = plan.layout.stride;
    let linear = V::splat(first.linear);
    let open = V::splat(first.open);
    // SAFETY: the caller's promise.
    unsafe {
        let at = (rows.start + plan.layout.halo) * stride + x;
        let mut next = levels.next.add(at);
        let mut face = first.face.add(x);
        let mut near = Loads {
            here: levels.now.add(at),
            ahead: V::LANES,
            stride,
        };
        let zero = V::splat(0.0);
        let mut here = [zero; COUNT];
        let mut lower_slope = here;
        let mut lower = here;
        for k in 0..COUNT {
            let near = beside(&near, k as isize, 0);
            here[k] = S::layered(weights, &Turned(&near));
            let south = S::layered(weights, &Turned(&beside(&near, 0, -1)));
            lower_slope[k] = here[k].sub(south);
            let face = face.add(k * V::LANES);
            lower[k] = if HIGH {
                // The row below has left the new memory of the face between.
                V::load(face.sub(2 * stride))
            } else {
                face_memory(
                    V::splat(first.decay[0]),
                    open,
                    V::load(face),
                    lower_slope[k],
                )
            };
        }
        for decay in &plan.row_decay[rows] {
            let decay = decay.unwrap_or_default().map(V::splat);
            for k in 0..COUNT {
                let near = beside(&near, k as isize, 0);
                let face = face.add(k * V::LANES);
                let next = next.add(k * V::LANES);
                let north = S::layered(weights, &Turned(&beside(&near, 0, 1)));
                let upper_slope = north.sub(here[k]);
                let old = V::load(if HIGH { face } else { face.add(2 * stride) });
                let upper = face_memory(decay[1], open, old, upper_slope);
                let cell = face.add(stride);
                let slopes = [lower_slope[k], upper_slope];
                let faces = [lower[k], upper];
                let (zeta, change) = layer_cell(slopes, faces, decay[2], open, V::load(cell));
                (if HIGH { upper } else { lower[k] }).store(face);
                zeta.store(cell);
                linear.mul_add(change, V::load(next)).store(next);
                (here[k], lower_slope[k], lower[k]) = (north, upper_slope, upper);
            }
            near.here = near.here.add(stride);
            next = next.add(stride);
            face = face.add(2 * stride);
        }
    }
}

/// A row of a layer along y.
pub(super) struct LayerRow {
    stride: usize,
    linear: f32,
    open: f32,
    decay: [f32; 3],
    high: bool,
    /// Memory of its outer face.
    face: *mut f32,
}

impl LayerRow {
    /// Row `iy`, if it belongs to a layer.
    #[inline(always)]
    pub(super) fn new(plan: &Plan, shared: Shared, iy: usize) -> Option<Self> {
        let decay = plan.row_decay[iy]?;
        let row = layer_row(plan.setup.layer.cells(), plan.setup.ny, iy)?;
        Some(Self {
            stride: plan.layout.stride,
            linear: plan.setup.weights.linear,
            open: plan.setup.layer.open(),
            decay,
            high: plan.memory_y.is_high(row),
            face: shared.layer_y.wrapping_add(plan.memory_y.face(row)),
        })
    }

    /// New pressure after the layer of the cells amid `near`, `x` from the start of the row, from the one before. The
    /// memory of the first `foreign` cells stays as it is.
    ///
    /// # Safety
    /// The cells' memory must be this thread's, as many rows and cells beyond these as the stencil reaches be readable,
    /// and the row below done but not the row above.
    #[inline(always)]
    pub(super) unsafe fn absorb<V: Vector, S: Sweep<V>, N: Near<V>>(
        &self,
        weights: &Splat<V>,
        near: &N,
        x: usize,
        p: V,
        foreign: usize,
    ) -> V {
        let stride = self.stride;
        // SAFETY: the caller's promise.
        unsafe {
            let here = S::layered(weights, &Turned(near));
            let south = S::layered(weights, &Turned(&beside(near, 0, -1)));
            let north = S::layered(weights, &Turned(&beside(near, 0, 1)));
            let slopes = [here.sub(south), north.sub(here)];
            let decay = self.decay.map(V::splat);
            let open = V::splat(self.open);
            let face = self.face.add(x);
            let cell = face.add(stride);
            let (outer, old) = (V::load(face), V::load(cell));
            let faces = if self.high {
                // The row below has left the new memory of the face between.
                let lower = V::load(face.sub(2 * stride));
                [lower, face_memory(decay[1], open, outer, slopes[1])]
            } else {
                let inner = V::load(face.add(2 * stride));
                [
                    face_memory(decay[0], open, outer, slopes[0]),
                    face_memory(decay[1], open, inner, slopes[1]),
                ]
            };
            let (zeta, change) = layer_cell(slopes, faces, decay[2], open, old);
            let new = faces[usize::from(self.high)];
            if foreign == 0 {
                new.store(face);
                zeta.store(cell);
            } else {
                new.after(outer, foreign).store(face);
                zeta.after(old, foreign).store(cell);
            }
            V::splat(self.linear).mul_add(change, p)
        }
    }
}
