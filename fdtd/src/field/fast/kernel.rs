//! The unsafe heart of the fast engine: sweeps over rows through raw pointers.
//!
//! Why unsafe: tiles of one time block share the two pressure buffers and write disjoint rows of them at the same
//! time, which slices cannot express, and the sweeps run under a chosen instruction set. What makes it sound is said
//! in `tiles`: which rows a tile reads and writes, and that no two tiles of a phase touch the same row in
//! conflicting ways. All pointers stay inside the buffers because the layout gives every row a halo of
//! `HALO` vectors and the buffers a rim of `HALO` rows.
#![expect(
    unsafe_code,
    reason = "disjoint rows of shared buffers; see the module's text"
)]

use std::sync::atomic::{AtomicU64, Ordering};

use super::super::StepForcing;
use super::super::layer_row;
use super::super::stencil::{Number, Splat, layer};
use super::layout::{HALO, NARROW, WIDE};
use super::tiles::Tile;
#[cfg(target_arch = "x86_64")]
use super::vector::{Avx, Avx512};
use super::vector::{Plain, Vector};
use super::{Line, Plan};
use crate::scheme::Scheme;
use crate::spread::TAPS;

/// Rows that the leapfrog sweep holds in registers together.
const HELD: usize = 4;

/// The buffers of a field as the tiles of one time block see them.
#[derive(Clone, Copy)]
pub(super) struct Shared {
    /// Level of the first step, and the past that it overwrites; both start at grid row `-HALO`.
    pub(super) levels: [*mut f32; 2],
    /// Layer memory along x, `[iy, 6, width]`.
    pub(super) layer_x: *mut f32,
    /// Layer memory along y, `[row of layer, 3, stride]`.
    pub(super) layer_y: *mut f32,
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
            (InstructionSet::Avx512, Scheme::M13) => avx512_m13(plan, shared, tile, steps, sums),
            #[cfg(target_arch = "x86_64")]
            (InstructionSet::Avx2, Scheme::Slf) => avx2_slf(plan, shared, tile, steps, sums),
            #[cfg(target_arch = "x86_64")]
            (InstructionSet::Avx2, Scheme::M13) => avx2_m13(plan, shared, tile, steps, sums),
            (_, Scheme::Slf) => sweep_tile::<Plain, Slf>(plan, shared, tile, steps, sums),
            (_, Scheme::M13) => sweep_tile::<Plain, M13>(plan, shared, tile, steps, sums),
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
instantiate!(avx2_slf, Avx, Slf, "avx2,fma");
instantiate!(avx2_m13, Avx, M13, "avx2,fma");

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

/// A scheme's sweep over some rows of one part of the rows.
trait Sweep<V: Vector> {
    /// Rows that a step of the wavefront takes together.
    const ROWS: usize;
    /// Cells of the centre that these rows take one after the other: all they touch then stays in the first-level cache,
    /// and each vector comes from the second level once per block.
    const CHUNK: usize;

    /// `now` and `next` point to the first cell of the first row's part, `vectors` long; `ahead` is the distance of the
    /// next cell along x in memory.
    ///
    /// # Safety
    /// Rows `-2..rows + 2` of `now` and rows `0..rows` of `next`, each with two cells to both sides, must be inside
    /// the buffers and free for this thread.
    unsafe fn rows(
        weights: &Splat<V>,
        now: *const f32,
        next: *mut f32,
        stride: usize,
        ahead: usize,
        vectors: usize,
        rows: usize,
    );

    /// What the absorbing layer takes the second difference of at the cells from `at` on, with neighbours `along` the
    /// absorbed axis and `across` it that far away in memory.
    ///
    /// # Safety
    /// The cells and these neighbours must be readable.
    unsafe fn layered(weights: &Splat<V>, at: *const f32, along: usize, across: usize) -> V;
}

struct Slf;
struct M13;

impl<V: Vector> Sweep<V> for Slf {
    #[inline(always)]
    unsafe fn layered(_: &Splat<V>, at: *const f32, _: usize, _: usize) -> V {
        // SAFETY: the caller's promise.
        unsafe { V::load(at) }
    }

    const ROWS: usize = 8;
    const CHUNK: usize = 480;

    #[inline(always)]
    unsafe fn rows(
        w: &Splat<V>,
        now: *const f32,
        next: *mut f32,
        stride: usize,
        ahead: usize,
        vectors: usize,
        rows: usize,
    ) {
        // SAFETY: the caller's promise covers every offset used here.
        unsafe {
            let mut done = 0;
            while ahead == V::LANES && done + HELD <= rows {
                let (now, next) = (now.add(done * stride), next.add(done * stride));
                let row = |i: usize| now.add(i * stride);
                let mut here: [V; HELD] = std::array::from_fn(|i| V::load(row(i)));
                for j in 0..vectors {
                    let at = j * V::LANES;
                    let east: [V; HELD] =
                        std::array::from_fn(|i| V::load(row(i).add(at + V::LANES)));
                    let south = V::load(now.add(at).sub(stride));
                    let north = V::load(row(HELD).add(at));
                    for i in 0..HELD {
                        let below = if i == 0 { south } else { here[i - 1] };
                        let above = if i + 1 == HELD { north } else { here[i + 1] };
                        let target = next.add(i * stride + at);
                        let west = V::load(row(i).add(at).sub(V::LANES));
                        w.slf(here[i], [west, east[i]], [below, above], V::load(target))
                            .store(target);
                    }
                    here = east;
                }
                done += HELD;
            }
            for i in done..rows {
                let (row, target) = (now.add(i * stride), next.add(i * stride));
                for j in 0..vectors {
                    let at = row.add(j * V::LANES);
                    let sides = [V::load(at.sub(ahead)), V::load(at.add(ahead))];
                    let ends = [V::load(at.sub(stride)), V::load(at.add(stride))];
                    let target = target.add(j * V::LANES);
                    w.slf(V::load(at), sides, ends, V::load(target))
                        .store(target);
                }
            }
        }
    }
}

impl<V: Vector> Sweep<V> for M13 {
    #[inline(always)]
    unsafe fn layered(w: &Splat<V>, at: *const f32, along: usize, across: usize) -> V {
        // SAFETY: the caller's promise.
        unsafe {
            w.m13_layer(
                V::load(at),
                [V::load(at.sub(along)), V::load(at.add(along))],
                [V::load(at.sub(across)), V::load(at.add(across))],
            )
        }
    }

    const ROWS: usize = 16;
    const CHUNK: usize = 240;

    #[inline(always)]
    unsafe fn rows(
        w: &Splat<V>,
        now: *const f32,
        next: *mut f32,
        stride: usize,
        ahead: usize,
        vectors: usize,
        rows: usize,
    ) {
        // SAFETY: the caller's promise covers every offset used here.
        unsafe {
            let mut done = 0;
            while V::MANY && ahead == V::LANES && done + 2 <= rows {
                let at = done * stride;
                m13_pair(w, now.add(at), next.add(at), stride, vectors);
                done += 2;
            }
            for i in done..rows {
                let (row, target) = (now.add(i * stride), next.add(i * stride));
                let vertical =
                    |at: *const f32| V::load(at.sub(stride)).add(V::load(at.add(stride)));
                if ahead == V::LANES {
                    let mut here: [V; 4] =
                        std::array::from_fn(|k| V::load(row.sub(2 * V::LANES).add(k * V::LANES)));
                    let mut upright = vertical(row);
                    let mut columns = [
                        w.m13_column(here[1], vertical(row.sub(V::LANES))),
                        w.m13_column(here[2], upright),
                    ];
                    for j in 0..vectors {
                        let at = row.add(j * V::LANES);
                        let beyond = V::load(at.add(2 * V::LANES));
                        let next_upright = vertical(at.add(V::LANES));
                        let column = w.m13_column(here[3], next_upright);
                        let ends = [V::load(at.sub(2 * stride)), V::load(at.add(2 * stride))];
                        let target = target.add(j * V::LANES);
                        w.m13(
                            here[2],
                            upright,
                            [columns[0], column],
                            [here[0], beyond],
                            ends,
                            V::load(target),
                        )
                        .store(target);
                        here = [here[1], here[2], here[3], beyond];
                        upright = next_upright;
                        columns = [columns[1], column];
                    }
                } else {
                    for j in 0..vectors {
                        let at = row.add(j * V::LANES);
                        let column = |at: *const f32| w.m13_column(V::load(at), vertical(at));
                        let columns = [column(at.sub(ahead)), column(at.add(ahead))];
                        let sides = [V::load(at.sub(2 * ahead)), V::load(at.add(2 * ahead))];
                        let ends = [V::load(at.sub(2 * stride)), V::load(at.add(2 * stride))];
                        let target = target.add(j * V::LANES);
                        w.m13(
                            V::load(at),
                            vertical(at),
                            columns,
                            sides,
                            ends,
                            V::load(target),
                        )
                        .store(target);
                    }
                }
            }
        }
    }
}

/// The 13-point sweep over two rows of the centre: each row's cells are the other's neighbours, so that a pair of
/// vectors takes eight loads instead of twelve.
///
/// # Safety
/// As [`Sweep::rows`] for two rows.
#[inline(always)]
unsafe fn m13_pair<V: Vector>(
    w: &Splat<V>,
    now: *const f32,
    next: *mut f32,
    stride: usize,
    vectors: usize,
) {
    // SAFETY: the caller's promise covers every offset used here.
    unsafe {
        let back = now.sub(2 * V::LANES);
        let (south, north) = (now.sub(stride), now.add(2 * stride));
        let (far_south, far_north) = (south.sub(stride), north.add(stride));
        let mut lower: [V; 4] = std::array::from_fn(|k| V::load(back.add(k * V::LANES)));
        let mut upper: [V; 4] =
            std::array::from_fn(|k| V::load(back.add(stride).add(k * V::LANES)));
        let west = [south, north].map(|row| V::load(row.sub(V::LANES)));
        let mut beside = [south, north].map(|row| V::load(row));
        let mut upright = [beside[0].add(upper[2]), lower[2].add(beside[1])];
        let mut columns = [
            [
                w.m13_column(lower[1], west[0].add(upper[1])),
                w.m13_column(lower[2], upright[0]),
            ],
            [
                w.m13_column(upper[1], lower[1].add(west[1])),
                w.m13_column(upper[2], upright[1]),
            ],
        ];
        for j in 0..vectors {
            let at = j * V::LANES;
            let beyond = [now, now.add(stride)].map(|row| V::load(row.add(at + 2 * V::LANES)));
            let east = [south, north].map(|row| V::load(row.add(at + V::LANES)));
            let rising = [east[0].add(upper[3]), lower[3].add(east[1])];
            let column = [
                w.m13_column(lower[3], rising[0]),
                w.m13_column(upper[3], rising[1]),
            ];
            let target = next.add(at);
            w.m13(
                lower[2],
                upright[0],
                [columns[0][0], column[0]],
                [lower[0], beyond[0]],
                [V::load(far_south.add(at)), beside[1]],
                V::load(target),
            )
            .store(target);
            let target = target.add(stride);
            w.m13(
                upper[2],
                upright[1],
                [columns[1][0], column[1]],
                [upper[0], beyond[1]],
                [beside[0], V::load(far_north.add(at))],
                V::load(target),
            )
            .store(target);
            lower = [lower[1], lower[2], lower[3], beyond[0]];
            upper = [upper[1], upper[2], upper[3], beyond[1]];
            columns = [[columns[0][1], column[0]], [columns[1][1], column[1]]];
            upright = rising;
            beside = east;
        }
    }
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
    // SAFETY: rows lie in the grid, and the buffers have HALO rows more on both sides; within a row every offset comes
    // from the layout. The caller promises that nobody else touches what is written here.
    unsafe {
        let now_base = shared.levels[step % 2].cast_const();
        let next_base = shared.levels[(step + 1) % 2];
        let at = (rows.start + HALO) * stride;
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
            let at = (iy + HALO) * stride;
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
