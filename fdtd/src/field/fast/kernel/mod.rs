//! The unsafe heart of the fast engine: sweeps over rows through raw pointers. Nothing outside this folder is unsafe.
//!
//! * here: who runs which rows of which step; `walls`: what walls change; `transducers`: source and receiver;
//! * `sweep`, `slf`, `m13`, `d25`: the plain stencils;
//! * `layers`: the strips beside the centre with the absorbing layers along x; `along_y`: those along y; `near`: what
//!   they see of a cell's neighbourhood;
//! * `flush_subnormals`: small numbers set to zero;
//! * `halo`: the cells that rows hold twice;
//! * `shared`: buffers, levels and weights; `compiled`: functions for an instruction set; `vector`: eight or sixteen
//!   numbers of one.
//!
//! Why unsafe: tiles of one time block share the two pressure buffers and write disjoint rows of them at the same time,
//! which slices cannot express, and the sweeps run under a chosen instruction set. Its soundness is explained in
//! `tiles`: which rows a tile reads and writes, and for which of another tile's it waits, so that no two tiles touch
//! the same row at the same time in conflicting ways. All pointers stay inside the buffers because the layout gives
//! every row a halo of vectors and the buffers a rim of rows as wide as the stencil reaches.
#![expect(
    unsafe_code,
    reason = "disjoint rows of shared buffers; see the module's text"
)]

mod along_y;
mod compiled;
mod d25;
mod flush_subnormals;
mod halo;
mod layers;
mod m13;
mod near;
mod shared;
mod slf;
mod sweep;
mod transducers;
mod vector;
mod walls;

use std::sync::atomic::{AtomicU64, Ordering};

#[cfg(target_arch = "x86_64")]
pub(in crate::field) use self::compiled::{with_avx2, with_avx512};

use self::d25::D25;
use self::m13::M13;
pub(super) use self::shared::Shared;
use self::shared::{Levels, Weights};
use self::slf::Slf;
use self::sweep::{Sweep, SweepVector};
use self::vector::Plain;
#[cfg(all(target_arch = "x86_64", not(fuzzing)))]
use self::vector::{Avx, Avx512};
use super::super::step::StepForcing;
#[cfg(all(target_arch = "x86_64", not(fuzzing)))]
use super::instructions::InstructionSet;
use super::line::Line;
use super::plan::Plan;
use super::team::{Front, Team};
use super::tiles::Tile;
use crate::scheme::Scheme;
use crate::spread::{Stencil, TAPS};

/// Sums that the receiver's rows leave, `[step, row of stencil]`, as bits of `f64`.
pub(super) type RowSums = [[AtomicU64; TAPS]];

/// Rows whose strips and halos are done together: what they touch stays in the first-level cache.
const EDGE_ROWS: usize = 8;

/// Where a tile stands among the others: its own front, and that of the tile above.
type Fronts<'a> = (&'a Front, Option<&'a Front>);

/// Runs the tiles of one time block, side by side on `team`.
pub(super) fn run_block(
    plan: &Plan,
    shared: Shared,
    tiles: &[Tile],
    steps: &[StepForcing],
    sums: &RowSums,
    team: &Team,
) {
    team.run(tiles, |tile, own, above| {
        // Capture the whole of `shared`, which may be sent, not its pointers one by one.
        let shared = &shared;
        // SAFETY: tiles keep apart as `tiles` says, and the caller holds the field mutably.
        unsafe { run_tile(plan, *shared, tile, steps, sums, (own, above)) }
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
/// `shared` must hold the buffers of `plan`, and the rows of `tile` be touched by no other thread but those that run
/// the other tiles of the block, with these fronts.
pub(super) unsafe fn run_tile(
    plan: &Plan,
    shared: Shared,
    tile: &Tile,
    steps: &[StepForcing],
    sums: &RowSums,
    fronts: Fronts<'_>,
) {
    // SAFETY: the caller's promise; the instruction set was detected on this machine.
    unsafe {
        match (plan.instructions, plan.setup.scheme) {
            #[cfg(all(target_arch = "x86_64", not(fuzzing)))]
            (InstructionSet::Avx512, Scheme::Slf) => {
                avx512_slf(plan, shared, tile, steps, sums, fronts)
            }
            #[cfg(all(target_arch = "x86_64", not(fuzzing)))]
            (InstructionSet::Avx512, Scheme::Iwb | Scheme::M13 | Scheme::O13) => {
                avx512_m13(plan, shared, tile, steps, sums, fronts);
            }
            #[cfg(all(target_arch = "x86_64", not(fuzzing)))]
            (InstructionSet::Avx512, Scheme::D25) => {
                avx512_d25(plan, shared, tile, steps, sums, fronts)
            }
            #[cfg(all(target_arch = "x86_64", not(fuzzing)))]
            (InstructionSet::Avx2, Scheme::Slf) => {
                avx2_slf(plan, shared, tile, steps, sums, fronts)
            }
            #[cfg(all(target_arch = "x86_64", not(fuzzing)))]
            (InstructionSet::Avx2, Scheme::Iwb | Scheme::M13 | Scheme::O13) => {
                avx2_m13(plan, shared, tile, steps, sums, fronts);
            }
            #[cfg(all(target_arch = "x86_64", not(fuzzing)))]
            (InstructionSet::Avx2, Scheme::D25) => {
                avx2_d25(plan, shared, tile, steps, sums, fronts)
            }
            (_, Scheme::Slf) => sweep_tile::<Plain, Slf>(plan, shared, tile, steps, sums, fronts),
            (_, Scheme::Iwb | Scheme::M13 | Scheme::O13) => {
                sweep_tile::<Plain, M13>(plan, shared, tile, steps, sums, fronts);
            }
            (_, Scheme::D25) => sweep_tile::<Plain, D25>(plan, shared, tile, steps, sums, fronts),
        }
    }
}

macro_rules! instantiate {
    ($name:ident, $vector:ty, $sweep:ty, $features:literal) => {
        // A fuzzer with a sanitizer would take minutes to compile what no parser calls.
        #[cfg(all(target_arch = "x86_64", not(fuzzing)))]
        #[target_feature(enable = $features)]
        unsafe fn $name(
            plan: &Plan,
            shared: Shared,
            tile: &Tile,
            steps: &[StepForcing],
            sums: &RowSums,
            fronts: Fronts<'_>,
        ) {
            // SAFETY: the caller's promise.
            unsafe { sweep_tile::<$vector, $sweep>(plan, shared, tile, steps, sums, fronts) }
        }
    };
}
instantiate!(avx512_slf, Avx512, Slf, "avx512f,avx512vl,avx2,fma");
instantiate!(avx512_m13, Avx512, M13, "avx512f,avx512vl,avx2,fma");
instantiate!(avx512_d25, Avx512, D25, "avx512f,avx512vl,avx2,fma");
instantiate!(avx2_slf, Avx, Slf, "avx2,fma");
instantiate!(avx2_m13, Avx, M13, "avx2,fma");
instantiate!(avx2_d25, Avx, D25, "avx2,fma");

/// All steps of a tile: a wavefront of short row blocks, step after step, each one radius behind the one before.
///
/// # Safety
/// As [`run_tile`].
#[inline(always)]
unsafe fn sweep_tile<V: SweepVector, S: Sweep<V> + Sweep<V::Narrow>>(
    plan: &Plan,
    shared: Shared,
    tile: &Tile,
    steps: &[StepForcing],
    sums: &RowSums,
    (own, above): Fronts<'_>,
) {
    let weights = Weights::<V>::new(plan);
    let radius = plan.setup.scheme.radius();
    let (begin, end) = tile.sweep(steps.len());
    let block = plan.blocking.rows as isize;
    let (shared_rows, needed) = tile.waits_from(steps.len());
    let mut above = above;
    let mut base = begin;
    while base < end + (radius * steps.len()) as isize {
        if base + block > shared_rows
            && let Some(above) = above.take()
        {
            above.wait_for(needed);
        }
        for step in 0..steps.len() {
            let (low, high) = tile.rows(step);
            let from = base - (radius * step) as isize;
            let (first, last) = (from.max(low as isize), (from + block).min(high as isize));
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
        base += block;
        own.reached(base);
    }
}

/// One step of a few rows: see the order of operations in [`crate::field`].
///
/// # Safety
/// As [`run_tile`], for these rows.
#[inline(always)]
unsafe fn advance_rows<V: SweepVector, S: Sweep<V> + Sweep<V::Narrow>>(
    plan: &Plan,
    shared: Shared,
    weights: &Weights<V>,
    rows: std::ops::Range<usize>,
    step: usize,
    forcing: &StepForcing,
    sums: &[AtomicU64; TAPS],
) {
    let layout = &plan.layout;
    let stride = layout.stride;
    let levels = Levels {
        now: shared.levels[step % 2].cast_const(),
        next: shared.levels[(step + 1) % 2],
    };
    // SAFETY: rows lie in the grid, and the buffers have a rim of rows on both sides; within a row every offset comes
    // from the layout. The caller promises that nobody else touches what is written here.
    unsafe {
        if forcing.flush {
            flush_subnormals::memory::<V>(plan, shared, rows.clone());
        }
        let start = (rows.start + layout.halo) * stride + layout.centre_at;
        let chunk = plan.blocking.chunk;
        for first in (0..layout.centre).step_by(chunk) {
            let from = start + first * V::LANES;
            let vectors = chunk.min(layout.centre - first);
            V::sweep::<S>(
                &weights.wide,
                levels.now.add(from),
                levels.next.add(from),
                stride,
                vectors,
                rows.len(),
            );
            let vectors = first..first + vectors;
            along_y::centre::<V, S>(plan, shared, levels, &weights.wide, vectors, rows.clone());
        }
        // After the centre: the single cells of the halo that strips read were stored long ago by then.
        for first in rows.clone().step_by(EDGE_ROWS) {
            let few = first..rows.end.min(first + EDGE_ROWS);
            layers::strips::<V, S>(plan, shared, levels, weights, few);
        }
        if forcing.flush {
            flush_subnormals::cells::<V>(plan, levels, rows.clone());
        }
        walls::correct(&plan.walls, levels, &rows);
        walls::react(plan, shared, levels, &rows);
        if forcing.flush {
            flush_subnormals::walls(plan, shared, levels, rows.clone());
        }
        walls::silence(&plan.walls, levels, &rows);
        let row = |iy: usize| {
            let at = levels.next.add((iy + layout.halo) * stride);
            std::slice::from_raw_parts_mut(at, stride)
        };
        let within = |s: &Stencil| rows.start.max(s.y0)..rows.end.min(s.y0 + TAPS);
        for injection in &forcing.injections {
            for iy in within(&injection.stencil) {
                transducers::send(plan, row(iy), iy, injection);
            }
        }
        for iy in rows.clone() {
            halo::refresh::<V>(layout, row(iy).as_mut_ptr());
        }
        for iy in within(&forcing.receiver) {
            let sum = transducers::receive(plan, row(iy), &forcing.receiver);
            sums[iy - forcing.receiver.y0].store(sum.to_bits(), Ordering::Relaxed);
        }
    }
}
