//! The standard leapfrog's sweep.

use super::super::super::stencil::Splat;
use super::near::Near;
use super::sweep::Sweep;
use super::vector::Vector;

/// Rows that the sweep holds in registers together.
const HELD: usize = 4;

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

    const ROWS: usize = 24;
    const CHUNK: usize = 480;

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
            let mut done = 0;
            while done + HELD <= rows {
                let (now, next) = (now.add(done * stride), next.add(done * stride));
                let row = |i: usize| now.add(i * stride);
                let mut west: [V; HELD] = std::array::from_fn(|i| V::load(row(i).sub(V::LANES)));
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
                        w.slf(here[i], [west[i], east[i]], [below, above], V::load(target))
                            .store(target);
                    }
                    west = here;
                    here = east;
                }
                done += HELD;
            }
            for i in done..rows {
                let (row, target) = (now.add(i * stride), next.add(i * stride));
                for j in 0..vectors {
                    let at = row.add(j * V::LANES);
                    let sides = [V::load(at.sub(V::LANES)), V::load(at.add(V::LANES))];
                    let ends = [V::load(at.sub(stride)), V::load(at.add(stride))];
                    let target = target.add(j * V::LANES);
                    w.slf(V::load(at), sides, ends, V::load(target))
                        .store(target);
                }
            }
        }
    }
}
