//! The unsafe heart of the fast engine: sweeps over rows through raw pointers. Nothing outside this folder is unsafe.
//!
//! * here: who runs which rows of which step, and all of a step but the plain stencil;
//! * `sweep`, `slf`, `m13`, `d25`: the plain stencils;
//! * `vector`: eight or sixteen numbers of an instruction set.
//!
//! Why unsafe: tiles of one time block share the two pressure buffers and write disjoint rows of them at the same
//! time, which slices cannot express, and the sweeps run under a chosen instruction set. What makes it sound is said
//! in `tiles`: which rows a tile reads and writes, and that no two tiles of a phase touch the same row in
//! conflicting ways. All pointers stay inside the buffers because the layout gives every row a halo of
//! vectors and the buffers a rim of rows as wide as the stencil reaches.
#![expect(
    unsafe_code,
    reason = "disjoint rows of shared buffers; see the module's text"
)]

mod d25;
mod m13;
mod slf;
mod sweep;
mod vector;

use std::sync::atomic::{AtomicU64, Ordering};

use self::d25::D25;
use self::m13::M13;
use self::slf::Slf;
use self::sweep::Sweep;
#[cfg(target_arch = "x86_64")]
use self::vector::{Avx, Avx512};
use self::vector::{Plain, Vector};
use super::super::StepForcing;
use super::super::layer_row;
use super::super::stencil::{Number, Splat, layer};
use super::layout::{NARROW, WIDE};
use super::tiles::Tile;
use super::{Line, Plan};
use crate::scheme::Scheme;
use crate::spread::TAPS;

/// The buffers of a field as the tiles of one time block see them.
#[derive(Clone, Copy)]
pub(super) struct Shared {
    /// Level of the first step, and the past that it overwrites; both start at the first row of the rim.
    pub(super) levels: [*mut f32; 2],
    /// Layer memory along x, `[iy, 6, width]`.
    pub(super) layer_x: *mut f32,
    /// Layer memory along y, `[row of layer, 3, stride]`.
    pub(super) layer_y: *mut f32,
    /// Velocities into surfaces that are not rigid; those of a row belong to who writes the row.
    pub(super) surfaces: *mut f32,
}

// SAFETY: the pointers are only used by tiles of one block, on disjoint rows (see `tiles`), while the field that owns
// the buffers is mutably borrowed by the call that starts them.
unsafe impl Send for Shared {}
// SAFETY: as above.
unsafe impl Sync for Shared {}

/// Sums that the receiver's rows leave, `[step, row of stencil]`, as bits of `f64`.
pub(super) type RowSums = [[AtomicU64; TAPS]];

/// Instruction sets that the sweeps are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InstructionSet {
    /// AVX-512 (F and VL) with fused multiply-add, sixteen numbers at a time.
    Avx512,
    /// AVX2 with fused multiply-add.
    Avx2,
    /// What the target has by default (NEON on 64-bit Arm).
    Portable,
}

impl InstructionSet {
    /// Numbers in one of its vectors.
    pub(super) fn lanes(self) -> usize {
        match self {
            Self::Avx512 => WIDE,
            Self::Avx2 | Self::Portable => NARROW,
        }
    }

    /// The best one of this machine.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::is_x86_feature_detected as has;
            if has!("avx2") && has!("fma") {
                let wide = has!("avx512f") && has!("avx512vl");
                return if wide { Self::Avx512 } else { Self::Avx2 };
            }
        }
        Self::Portable
    }
}

/// Runs the tiles of one phase of a time block, side by side on `pool`.
pub(super) fn run_phase(
    plan: &Plan,
    shared: Shared,
    tiles: &[Tile],
    steps: &[StepForcing],
    sums: &RowSums,
    pool: Option<&rayon::ThreadPool>,
) {
    super::for_each_tile(pool, tiles, |tile| {
        // Capture the whole of `shared`, which may be sent, not its pointers one by one.
        let shared = &shared;
        // SAFETY: tiles of one phase are disjoint as `tiles` says, and the caller holds the field mutably.
        unsafe { run_tile(plan, *shared, tile, steps, sums) }
    });
}

/// The numbers of a buffer of cache lines.
pub(super) fn flat(lines: &[Line]) -> &[f32] {
    // SAFETY: `Line` is nothing but sixteen numbers without padding.
    unsafe { std::slice::from_raw_parts(lines.as_ptr().cast(), size_of_val(lines) / 4) }
}

/// The numbers of a buffer of cache lines.
pub(super) fn flat_mut(lines: &mut [Line]) -> &mut [f32] {
    // SAFETY: as above, and the borrow is exclusive.
    unsafe { std::slice::from_raw_parts_mut(lines.as_mut_ptr().cast(), size_of_val(lines) / 4) }
}

/// Runs one tile of a time block.
///
/// # Safety
/// `shared` must hold the buffers of `plan`, and no other thread may touch the rows that `tile` writes, or write those
/// that it reads, while it runs.
pub(super) unsafe fn run_tile(
    plan: &Plan,
    shared: Shared,
    tile: &Tile,
    steps: &[StepForcing],
    sums: &RowSums,
) {
    // SAFETY: the caller's promise; the instruction set was detected on this machine.
    unsafe {
        match (plan.instructions, plan.setup.scheme) {
            #[cfg(target_arch = "x86_64")]
            (InstructionSet::Avx512, Scheme::Slf) => avx512_slf(plan, shared, tile, steps, sums),
            #[cfg(target_arch = "x86_64")]
            (InstructionSet::Avx512, Scheme::M13 | Scheme::O13) => {
                avx512_m13(plan, shared, tile, steps, sums);
            }
            #[cfg(target_arch = "x86_64")]
            (InstructionSet::Avx512, Scheme::D25) => avx512_d25(plan, shared, tile, steps, sums),
            #[cfg(target_arch = "x86_64")]
            (InstructionSet::Avx2, Scheme::Slf) => avx2_slf(plan, shared, tile, steps, sums),
            #[cfg(target_arch = "x86_64")]
            (InstructionSet::Avx2, Scheme::M13 | Scheme::O13) => {
                avx2_m13(plan, shared, tile, steps, sums);
            }
            #[cfg(target_arch = "x86_64")]
            (InstructionSet::Avx2, Scheme::D25) => avx2_d25(plan, shared, tile, steps, sums),
            (_, Scheme::Slf) => sweep_tile::<Plain, Slf>(plan, shared, tile, steps, sums),
            (_, Scheme::M13 | Scheme::O13) => {
                sweep_tile::<Plain, M13>(plan, shared, tile, steps, sums);
            }
            (_, Scheme::D25) => sweep_tile::<Plain, D25>(plan, shared, tile, steps, sums),
        }
    }
}

macro_rules! instantiate {
    ($name:ident, $vector:ty, $sweep:ty, $features:literal) => {
        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = $features)]
        unsafe fn $name(
            plan: &Plan,
            shared: Shared,
            tile: &Tile,
            steps: &[StepForcing],
            sums: &RowSums,
        ) {
            // SAFETY: the caller's promise.
            unsafe { sweep_tile::<$vector, $sweep>(plan, shared, tile, steps, sums) }
        }
    };
}
instantiate!(avx512_slf, Avx512, Slf, "avx512f,avx512vl,avx2,fma");
instantiate!(avx512_m13, Avx512, M13, "avx512f,avx512vl,avx2,fma");
instantiate!(avx512_d25, Avx512, D25, "avx512f,avx512vl,avx2,fma");
instantiate!(avx2_slf, Avx, Slf, "avx2,fma");
instantiate!(avx2_m13, Avx, M13, "avx2,fma");
instantiate!(avx2_d25, Avx, D25, "avx2,fma");

/// Runs `work` compiled for AVX2 with fused multiply-add.
///
/// # Panics
/// When the machine has no such instructions.
#[cfg(target_arch = "x86_64")]
pub(in crate::field) fn with_avx2<R>(work: impl FnOnce() -> R) -> R {
    #[target_feature(enable = "avx2,fma")]
    fn inside<R>(work: impl FnOnce() -> R) -> R {
        work()
    }
    assert!(
        InstructionSet::detect() != InstructionSet::Portable,
        "no AVX2 with FMA here"
    );
    // SAFETY: just checked.
    unsafe { inside(work) }
}

/// Runs `work` compiled for AVX-512.
///
/// # Panics
/// When the machine has no such instructions.
#[cfg(target_arch = "x86_64")]
pub(in crate::field) fn with_avx512<R>(work: impl FnOnce() -> R) -> R {
    #[target_feature(enable = "avx512f,avx512vl,avx2,fma")]
    fn inside<R>(work: impl FnOnce() -> R) -> R {
        work()
    }
    assert!(
        InstructionSet::detect() == InstructionSet::Avx512,
        "no AVX-512 here"
    );
    // SAFETY: just checked.
    unsafe { inside(work) }
}

/// All steps of a tile: a wavefront of short row blocks, step after step, each one radius behind the one before.
///
/// # Safety
/// As [`run_tile`].
#[inline(always)]
unsafe fn sweep_tile<V: Vector, S: Sweep<V> + Sweep<V::Narrow>>(
    plan: &Plan,
    shared: Shared,
    tile: &Tile,
    steps: &[StepForcing],
    sums: &RowSums,
) {
    let weights = Splat::<V>::new(&plan.setup.weights);
    let radius = plan.setup.scheme.radius();
    let (begin, end) = tile.sweep(steps.len());
    let mut base = begin;
    while base < end + (radius * steps.len()) as isize {
        for step in 0..steps.len() {
            let (low, high) = tile.rows(step);
            let from = base - (radius * step) as isize;
            let (first, last) = (
                from.max(low as isize),
                (from + <S as Sweep<V>>::ROWS as isize).min(high as isize),
            );
            if first < last {
                // SAFETY: the caller's promise; rows first..last belong to this tile at this step.
                unsafe {
                    let rows = first as usize..last as usize;
                    advance_rows::<V, S>(
                        plan,
                        shared,
                        &weights,
                        rows,
                        step,
                        &steps[step],
                        &sums[step],
                    );
                }
            }
        }
        base += <S as Sweep<V>>::ROWS as isize;
    }
}

/// One step of a few rows: see the order of operations in [`crate::field`].
///
/// # Safety
/// As [`run_tile`], for these rows.
#[inline(always)]
unsafe fn advance_rows<V: Vector, S: Sweep<V> + Sweep<V::Narrow>>(
    plan: &Plan,
    shared: Shared,
    weights: &Splat<V>,
    rows: std::ops::Range<usize>,
    step: usize,
    forcing: &StepForcing,
    sums: &[AtomicU64; TAPS],
) {
    let layout = &plan.layout;
    let stride = layout.stride;
    let cells = plan.setup.layer.cells();
    let width = plan.setup.layer.width();
    let courant2 = V::splat(plan.setup.courant2);
    let narrow = Splat::<V::Narrow>::new(&plan.setup.weights);
    // SAFETY: rows lie in the grid, and the buffers have a rim of rows on both sides; within a row every offset comes
    // from the layout. The caller promises that nobody else touches what is written here.
    unsafe {
        let now_base = shared.levels[step % 2].cast_const();
        let next_base = shared.levels[(step + 1) % 2];
        let at = (rows.start + layout.halo) * stride;
        let parts = [
            (layout.low_at, 1, layout.low.div_ceil(V::LANES)),
            (layout.centre_at, V::LANES, layout.centre),
            (layout.high_at, 1, layout.high.div_ceil(V::LANES)),
        ];
        for (part, ahead, vectors) in parts {
            for first in (0..vectors).step_by(<S as Sweep<V>>::CHUNK / V::LANES) {
                let from = at + part + first * V::LANES;
                let (now, next) = (now_base.add(from), next_base.add(from));
                <S as Sweep<V>>::rows(
                    weights,
                    now,
                    next,
                    stride,
                    ahead,
                    (<S as Sweep<V>>::CHUNK / V::LANES).min(vectors - first),
                    rows.len(),
                );
            }
        }
        for iy in rows {
            let at = (iy + layout.halo) * stride;
            let now = now_base.add(at);
            let next = next_base.add(at);
            if let (Some(decay), Some(layer)) =
                (plan.row_decay[iy], layer_row(cells, plan.setup.ny, iy))
            {
                let memory = shared.layer_y.add(layer * 3 * stride);
                let decay = decay.map(V::splat);
                for (part, ahead, vectors) in parts {
                    for x in (part..part + vectors * V::LANES).step_by(V::LANES) {
                        let layered =
                            |p: *const f32| <S as Sweep<V>>::layered(weights, p, stride, ahead);
                        let p = now.add(x);
                        let here = layered(p);
                        let slopes = [
                            here.sub(layered(p.sub(stride))),
                            layered(p.add(stride)).sub(here),
                        ];
                        layer_vector(slopes, decay, memory.add(x), stride, courant2, next.add(x));
                    }
                }
            }
            for (side, profile) in [&plan.setup.layer, &plan.high].into_iter().enumerate() {
                let first = if side == 0 {
                    layout.low_at
                } else {
                    layout.offset(layout.nx - width)
                };
                let memory = shared.layer_x.add((iy * 2 + side) * 3 * width);
                for i in (0..width).step_by(NARROW) {
                    let p = now.add(first + i);
                    let layered =
                        |p: *const f32| <S as Sweep<V::Narrow>>::layered(&narrow, p, 1, stride);
                    let here = layered(p);
                    let slopes = [here.sub(layered(p.sub(1))), layered(p.add(1)).sub(here)];
                    let face = profile.face.as_ptr().add(i);
                    let decay = [
                        V::Narrow::load(face),
                        V::Narrow::load(face.add(1)),
                        V::Narrow::load(profile.cell.as_ptr().add(i)),
                    ];
                    layer_vector::<V::Narrow>(
                        slopes,
                        decay,
                        memory.add(i),
                        width,
                        V::Narrow::splat(plan.setup.courant2),
                        next.add(first + i),
                    );
                }
            }
            let next = std::slice::from_raw_parts_mut(next, stride);
            let walls = &plan.walls[iy];
            for correction in &walls.corrections {
                let mut sum = 0.0_f32;
                let entries = correction.first as usize..correction.end as usize;
                for &(offset, weight) in &plan.entries[entries] {
                    sum = weight.mul_add(*now_base.offset(at as isize + offset as isize), sum);
                }
                next[correction.at as usize] += sum;
            }
            for surface in &walls.surfaces {
                let velocity = shared.surfaces.add(surface.memory);
                let before = *velocity;
                let mut after = surface.decay * before;
                for &(offset, weight) in &surface.taps {
                    after = weight.mul_add(*now_base.offset(at as isize + offset as isize), after);
                }
                *velocity = after;
                for &(offset, gain) in &surface.gains {
                    let p = &mut next[offset as usize];
                    *p = gain.mul_add(before - after, *p);
                }
            }
            for &solid in &walls.solid {
                next[solid as usize] = 0.0;
            }
            for injection in &forcing.injections {
                let s = &injection.stencil;
                if let Some(wy) = iy.checked_sub(s.y0).and_then(|j| s.wy.get(j)) {
                    let weight = wy * injection.amplitude;
                    for (i, wx) in s.wx.iter().enumerate() {
                        let p = &mut next[layout.offset(s.x0 + i)];
                        *p = wx.mul_add(weight, *p);
                    }
                }
            }
            layout.refresh_halos(next);
            let s = &forcing.receiver;
            if let Some(j) = iy.checked_sub(s.y0).filter(|&j| j < TAPS) {
                let taps = s.wx.iter().enumerate();
                let sum: f64 = taps
                    .map(|(i, &w)| f64::from(w) * f64::from(next[layout.offset(s.x0 + i)]))
                    .sum();
                sums[j].store(sum.to_bits(), Ordering::Relaxed);
            }
        }
    }
}

/// The layer's recursion at a vector of cells whose memory lies at `memory`, three parts `part` apart.
///
/// # Safety
/// A vector's numbers at `next` and at each part of the memory must be this thread's.
#[inline(always)]
unsafe fn layer_vector<V: Vector>(
    slopes: [V; 2],
    decay: [V; 3],
    memory: *mut f32,
    part: usize,
    courant2: V,
    next: *mut f32,
) {
    // SAFETY: the caller's promise.
    unsafe {
        let old = std::array::from_fn(|k| V::load(memory.add(k * part)));
        let (new, change) = layer(slopes, decay, old);
        for (k, value) in new.into_iter().enumerate() {
            value.store(memory.add(k * part));
        }
        courant2.mul_add(change, V::load(next)).store(next);
    }
}
