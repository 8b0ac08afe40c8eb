//! The standard leapfrog's sweep.

use super::super::super::stencil::Splat;
use super::near::Near;
use super::sweep::Sweep;
use super::vector::Vector;

/// The 5-point sweep.
pub(super) struct Slf;

impl<V: Vector> Sweep<V> for Slf {
    #[inline(always)]
    unsafe fn layered<N: Near<V>>(_: &Splat<V>, near: &N) -> V {
        // SAFETY: the caller's promise.
        unsafe { near.at(0, 0) }
    }

    #[inline(always)]
    unsafe fn cells<N: Near<V>>(w: &Splat<V>, near: &N, past: V) -> V {
        // SAFETY: the caller's promise.
        unsafe {
            let sides = [near.at(-1, 0), near.at(1, 0)];
            let ends = [near.at(0, -1), near.at(0, 1)];
            w.slf(near.at(0, 0), sides, ends, past)
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
        let mut done = 0;
        // SAFETY: the caller's promise covers every offset used here.
        unsafe {
            while done < rows {
                let at = done * stride;
                let (now, next) = (now.add(at), next.add(at));
                done += match rows - done {
                    1 => held::<V, 1>(w, now, next, stride, vectors),
                    2 => held::<V, 2>(w, now, next, stride, vectors),
                    3 => held::<V, 3>(w, now, next, stride, vectors),
                    5 if V::MANY => held::<V, 5>(w, now, next, stride, vectors),
                    6.. if V::MANY => held::<V, 6>(w, now, next, stride, vectors),
                    _ => held::<V, 4>(w, now, next, stride, vectors),
                };
            }
        }
    }
}

/// The sweep over `ROWS` rows of the centre, held in registers together, so that most cells are loaded once; returns
/// how many.
///
/// # Safety
/// As [`Sweep::rows`] for so many rows.
#[inline(always)]
unsafe fn held<V: Vector, const ROWS: usize>(
    w: &Splat<V>,
    now: *const f32,
    next: *mut f32,
    stride: usize,
    vectors: usize,
) -> usize {
    // SAFETY: the caller's promise covers every offset used here.
    unsafe {
        let row = |i: usize| now.add(i * stride);
        let mut west: [V; ROWS] = std::array::from_fn(|i| V::load(row(i).sub(V::LANES)));
        let mut here: [V; ROWS] = std::array::from_fn(|i| V::load(row(i)));
        for j in 0..vectors {
            let at = j * V::LANES;
            let east: [V; ROWS] = std::array::from_fn(|i| V::load(row(i).add(at + V::LANES)));
            let south = V::load(now.add(at).sub(stride));
            let north = V::load(row(ROWS).add(at));
            for i in 0..ROWS {
                let below = if i == 0 { south } else { here[i - 1] };
                let above = if i + 1 == ROWS { north } else { here[i + 1] };
                let target = next.add(i * stride + at);
                w.slf(here[i], [west[i], east[i]], [below, above], V::load(target))
                    .store(target);
            }
            west = here;
            here = east;
        }
    }
    ROWS
}
