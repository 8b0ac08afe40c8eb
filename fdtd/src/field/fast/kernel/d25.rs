//! The 25-point scheme's sweep.
//!
//! In the centre a column's cells are loaded once and what they give to the seven columns around them is added to seven
//! running sums, west to east: sixteen arithmetic operations and eight loads per vector instead of 27 and 26.

use super::super::super::stencil::Splat;
use super::near::{Loads, Near, beside};
use super::sweep::Sweep;
use super::vector::Vector;

/// Columns taken together where registers are few: after so many, every running sum is in the register where it was,
/// and none was moved.
const UNROLLED: usize = 6;

/// The 25-point sweep.
pub(super) struct D25;

impl<V: Vector> Sweep<V> for D25 {
    #[inline(always)]
    unsafe fn layered<N: Near<V>>(w: &Splat<V>, near: &N) -> V {
        // SAFETY: the caller's promise.
        unsafe {
            w.d25_layer(
                near.at(0, 0),
                [
                    [near.at(-1, 0), near.at(1, 0)],
                    [near.at(-2, 0), near.at(2, 0)],
                ],
                [near.at(0, -1), near.at(0, 1)],
                [
                    [near.at(-1, -1), near.at(-1, 1)],
                    [near.at(1, -1), near.at(1, 1)],
                ],
            )
        }
    }

    #[inline(always)]
    unsafe fn cells<N: Near<V>>(w: &Splat<V>, near: &N, past: V) -> V {
        // SAFETY: the caller's promise.
        unsafe {
            let sum = w
                .d25_first(near.at(-3, 0), past)
                .add(sides(w, &beside(near, -2, 0), 1)[1])
                .add(sides(w, &beside(near, -1, 0), 2)[0]);
            let verticals = [
                near.at(0, -1).add(near.at(0, 1)),
                near.at(0, -2).add(near.at(0, 2)),
                near.at(0, -3).add(near.at(0, 3)),
            ];
            let sum = w
                .d25_own(near.at(0, 0), verticals, sum)
                .add(sides(w, &beside(near, 1, 0), 2)[0])
                .add(sides(w, &beside(near, 2, 0), 1)[1]);
            w.d25_last(near.at(3, 0), sum)
        }
    }

    #[inline(always)]
    unsafe fn rows(
        w: &Splat<V>,
        now: *const f32,
        next: *mut f32,
        stride: usize,
        vectors: usize,
        rows: usize,
    ) {
        // SAFETY: the caller's promise covers every offset used here.
        unsafe {
            for i in 0..rows {
                centre_row(
                    w,
                    now.add(i * stride),
                    next.add(i * stride),
                    stride,
                    vectors,
                );
            }
        }
    }
}

/// Sum of the cells `rows` below and above.
///
/// # Safety
/// Both must be readable.
#[inline(always)]
unsafe fn vertical<V: Vector>(at: *const f32, rows: usize) -> V {
    // SAFETY: the caller's promise.
    unsafe { V::load(at.sub(rows)).add(V::load(at.add(rows))) }
}

/// Sums of the cells one, two and three rows below and above.
///
/// # Safety
/// All must be readable.
#[inline(always)]
unsafe fn verticals<V: Vector>(at: *const f32, stride: usize) -> [V; 3] {
    // SAFETY: the caller's promise.
    unsafe {
        [
            vertical(at, stride),
            vertical(at, 2 * stride),
            vertical(at, 3 * stride),
        ]
    }
}

/// Contributions of a column to the columns beside it and two away, from its cells up to `far` rows away: 2, or 1 where
/// the contribution to the columns beside it, which is wrong then, is not used. A function, not a closure: a closure
/// that is not inlined would call every vector instruction as a function.
///
/// # Safety
/// As [`Near::at`].
#[inline(always)]
unsafe fn sides<V: Vector, N: Near<V>>(w: &Splat<V>, column: &N, far: isize) -> [V; 2] {
    // SAFETY: the caller's promise.
    unsafe {
        w.d25_sides(
            column.at(0, 0),
            [
                column.at(0, -1).add(column.at(0, 1)),
                column.at(0, -far).add(column.at(0, far)),
            ],
        )
    }
}

/// The running sums after the column at `at`, and the sum that it completes: that of the column three to the west.
///
/// # Safety
/// As [`Sweep::rows`].
#[inline(always)]
unsafe fn passed<V: Vector>(
    w: &Splat<V>,
    at: *const f32,
    target: *const f32,
    stride: usize,
    sums: [V; 6],
) -> ([V; 6], V) {
    // SAFETY: the caller's promise.
    unsafe {
        let own = V::load(at);
        let verticals = verticals(at, stride);
        let [beside, beyond] = w.d25_sides(own, [verticals[0], verticals[1]]);
        let past = V::load(target.add(3 * V::LANES));
        let next = [
            sums[1].add(beyond),
            sums[2].add(beside),
            w.d25_own(own, verticals, sums[3]),
            sums[4].add(beside),
            sums[5].add(beyond),
            w.d25_first(own, past),
        ];
        (next, w.d25_last(own, sums[0]))
    }
}

/// One row of the centre.
///
/// # Safety
/// As [`Sweep::rows`] for one row.
#[inline(always)]
unsafe fn centre_row<V: Vector>(
    w: &Splat<V>,
    row: *const f32,
    target: *mut f32,
    stride: usize,
    vectors: usize,
) {
    // SAFETY: the caller's promise covers every offset used here; `target` is read up to three vectors beyond the end,
    // where its halo is, and written inside only.
    unsafe {
        let column = |j: isize| row.offset(j * V::LANES as isize);
        let here = |j: isize| V::load(column(j));
        let past = |j: isize| V::load(target.offset(j * V::LANES as isize));
        // sums[k] belongs to column j + k - 3 when column j comes.
        let mut sums = [here(0); 6];
        let west = sides(w, &Loads::plain(column(-1), stride), 2);
        sums[3] = w
            .d25_first(here(-3), past(0))
            .add(sides(w, &Loads::plain(column(-2), stride), 2)[1])
            .add(west[0]);
        sums[4] = w.d25_first(here(-2), past(1)).add(west[1]);
        sums[5] = w.d25_first(here(-1), past(2));
        let mut j = 0;
        while j < vectors.min(3) {
            let at = j * V::LANES;
            sums = passed(w, row.add(at), target.add(at), stride, sums).0;
            j += 1;
        }
        while !V::MANY && j + UNROLLED <= vectors {
            for k in j..j + UNROLLED {
                let at = k * V::LANES;
                let (next, done) = passed(w, row.add(at), target.add(at), stride, sums);
                done.store(target.add(at).sub(3 * V::LANES));
                sums = next;
            }
            j += UNROLLED;
        }
        for k in j..vectors {
            let at = k * V::LANES;
            let (next, done) = passed(w, row.add(at), target.add(at), stride, sums);
            done.store(target.add(at).sub(3 * V::LANES));
            sums = next;
        }
        let end = vectors as isize;
        let east = sides(w, &Loads::plain(column(end), stride), 2);
        let rest = [
            w.d25_last(here(end), sums[0]),
            w.d25_last(here(end + 1), sums[1].add(east[1])),
            w.d25_last(
                here(end + 2),
                sums[2]
                    .add(east[0])
                    .add(sides(w, &Loads::plain(column(end + 1), stride), 2)[1]),
            ),
        ];
        for (k, sum) in rest.into_iter().enumerate() {
            let j = end - 3 + k as isize;
            if j >= 0 {
                sum.store(target.offset(j * V::LANES as isize));
            }
        }
    }
}
