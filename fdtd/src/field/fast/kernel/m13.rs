//! The 13-point scheme's sweep.

use super::super::super::stencil::Splat;
use super::super::line::LINE;
use super::near::Near;
use super::sweep::Sweep;
use super::vector::Vector;

/// Vectors of a row taken together: after so many, every cell held is in the register where it was, and none was moved.
const UNROLLED: usize = 4;

/// The 13-point sweep.
pub(super) struct M13;

impl<V: Vector> Sweep<V> for M13 {
    #[inline(always)]
    unsafe fn layered<N: Near<V>>(w: &Splat<V>, near: &N) -> V {
        // SAFETY: the caller's promise.
        unsafe {
            w.m13_layer(
                near.at(0, 0),
                [near.at(-1, 0), near.at(1, 0)],
                [near.at(0, -1), near.at(0, 1)],
            )
        }
    }

    #[inline(always)]
    unsafe fn cells<N: Near<V>>(w: &Splat<V>, near: &N, past: V) -> V {
        // SAFETY: the caller's promise.
        unsafe {
            let west = near.at(-1, -1).add(near.at(-1, 1));
            let east = near.at(1, -1).add(near.at(1, 1));
            w.m13(
                near.at(0, 0),
                near.at(0, -1).add(near.at(0, 1)),
                [
                    w.m13_column(near.at(-1, 0), west),
                    w.m13_column(near.at(1, 0), east),
                ],
                [near.at(-2, 0), near.at(2, 0)],
                [near.at(0, -2), near.at(0, 2)],
                past,
            )
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
            let mut done = 0;
            while V::MANY && done + 2 <= rows {
                let at = done * stride;
                m13_pair(w, now.add(at), next.add(at), stride, vectors);
                done += 2;
            }
            for i in done..rows {
                let (row, target) = (now.add(i * stride), next.add(i * stride));
                let mut held = Held::new(w, row, stride);
                let mut j = 0;
                while j + UNROLLED <= vectors {
                    let at = row.add(j * V::LANES);
                    let target = target.add(j * V::LANES);
                    // Cells that the next row is the first to use.
                    for k in (0..UNROLLED).step_by(LINE / V::LANES) {
                        V::fetch(at.wrapping_add(3 * stride + k * V::LANES));
                        V::fetch(target.wrapping_add(stride + k * V::LANES));
                    }
                    for k in 0..UNROLLED {
                        held.step(w, at.add(k * V::LANES), target.add(k * V::LANES), stride);
                    }
                    j += UNROLLED;
                }
                for j in j..vectors {
                    held.step(w, row.add(j * V::LANES), target.add(j * V::LANES), stride);
                }
            }
        }
    }
}

/// Values that one row's sweep holds in registers.
struct Held<V> {
    /// The row's cells from two columns to the west to one to the east.
    here: [V; 4],
    /// The sum of the cells below and above.
    middle: V,
    /// Contributions of the column to the west and of this one to those beside them.
    columns: [V; 2],
}

impl<V: Vector> Held<V> {
    /// At the first vector of the row at `row`.
    ///
    /// # Safety
    /// As [`Sweep::rows`].
    #[inline(always)]
    unsafe fn new(w: &Splat<V>, row: *const f32, stride: usize) -> Self {
        // SAFETY: the caller's promise.
        unsafe {
            let back = row.sub(2 * V::LANES);
            let here: [V; 4] = std::array::from_fn(|k| V::load(back.add(k * V::LANES)));
            let middle = upright(row, stride);
            let west = upright(row.sub(V::LANES), stride);
            let columns = [w.m13_column(here[1], west), w.m13_column(here[2], middle)];
            Self {
                here,
                middle,
                columns,
            }
        }
    }

    /// Advances the vector at `at`, whose past is at `target`, and goes on to the next.
    ///
    /// # Safety
    /// As [`Sweep::rows`].
    #[inline(always)]
    unsafe fn step(&mut self, w: &Splat<V>, at: *const f32, target: *mut f32, stride: usize) {
        // SAFETY: the caller's promise.
        unsafe {
            let here = self.here;
            let beyond = V::load(at.add(2 * V::LANES));
            let rising = upright(at.add(V::LANES), stride);
            let column = w.m13_column(here[3], rising);
            let ends = [V::load(at.sub(2 * stride)), V::load(at.add(2 * stride))];
            w.m13(
                here[2],
                self.middle,
                [self.columns[0], column],
                [here[0], beyond],
                ends,
                V::load(target),
            )
            .store(target);
            self.here = [here[1], here[2], here[3], beyond];
            self.middle = rising;
            self.columns = [self.columns[1], column];
        }
    }
}

/// Sum of the cells below and above.
///
/// # Safety
/// Both must be readable.
#[inline(always)]
unsafe fn upright<V: Vector>(at: *const f32, stride: usize) -> V {
    // SAFETY: the caller's promise.
    unsafe { V::load(at.sub(stride)).add(V::load(at.add(stride))) }
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
        let mut held = Pair::new(w, now, stride);
        let mut j = 0;
        while j + UNROLLED <= vectors {
            for k in 0..UNROLLED {
                let at = (j + k) * V::LANES;
                held.step(w, now.add(at), next.add(at), stride);
            }
            j += UNROLLED;
        }
        for j in j..vectors {
            let at = j * V::LANES;
            held.step(w, now.add(at), next.add(at), stride);
        }
    }
}

/// Values that the sweep over two rows holds from vector to vector.
struct Pair<V> {
    /// Cells of the lower and the upper row, from two to the west to one to the east.
    rows: [[V; 4]; 2],
    /// Cells of the row below and of that above both.
    beside: [V; 2],
    /// Sums of the cells below and above each.
    upright: [V; 2],
    /// Parts of the columns to the west and of the column itself.
    columns: [[V; 2]; 2],
}

impl<V: Vector> Pair<V> {
    /// The values held before the vector at `now` of the lower row.
    ///
    /// # Safety
    /// As [`m13_pair`].
    #[inline(always)]
    unsafe fn new(w: &Splat<V>, now: *const f32, stride: usize) -> Self {
        // SAFETY: the caller's promise.
        unsafe {
            let back = now.sub(2 * V::LANES);
            let (south, north) = (now.sub(stride), now.add(2 * stride));
            let lower: [V; 4] = std::array::from_fn(|k| V::load(back.add(k * V::LANES)));
            let upper: [V; 4] =
                std::array::from_fn(|k| V::load(back.add(stride).add(k * V::LANES)));
            let west = [south, north].map(|row| V::load(row.sub(V::LANES)));
            let beside = [south, north].map(|row| V::load(row));
            let upright = [beside[0].add(upper[2]), lower[2].add(beside[1])];
            let columns = [
                [
                    w.m13_column(lower[1], west[0].add(upper[1])),
                    w.m13_column(lower[2], upright[0]),
                ],
                [
                    w.m13_column(upper[1], lower[1].add(west[1])),
                    w.m13_column(upper[2], upright[1]),
                ],
            ];
            Self {
                rows: [lower, upper],
                beside,
                upright,
                columns,
            }
        }
    }

    /// One vector of both rows.
    ///
    /// # Safety
    /// As [`m13_pair`].
    #[inline(always)]
    unsafe fn step(&mut self, w: &Splat<V>, now: *const f32, next: *mut f32, stride: usize) {
        // SAFETY: the caller's promise.
        unsafe {
            let [lower, upper] = self.rows;
            let (south, north) = (now.sub(stride), now.add(2 * stride));
            let (far_south, far_north) = (south.sub(stride), north.add(stride));
            let beyond = [now, now.add(stride)].map(|row| V::load(row.add(2 * V::LANES)));
            let east = [south, north].map(|row| V::load(row.add(V::LANES)));
            let rising = [east[0].add(upper[3]), lower[3].add(east[1])];
            let column = [
                w.m13_column(lower[3], rising[0]),
                w.m13_column(upper[3], rising[1]),
            ];
            w.m13(
                lower[2],
                self.upright[0],
                [self.columns[0][0], column[0]],
                [lower[0], beyond[0]],
                [V::load(far_south), self.beside[1]],
                V::load(next),
            )
            .store(next);
            let above = next.add(stride);
            w.m13(
                upper[2],
                self.upright[1],
                [self.columns[1][0], column[1]],
                [upper[0], beyond[1]],
                [self.beside[0], V::load(far_north)],
                V::load(above),
            )
            .store(above);
            self.rows = [
                [lower[1], lower[2], lower[3], beyond[0]],
                [upper[1], upper[2], upper[3], beyond[1]],
            ];
            self.columns = [
                [self.columns[0][1], column[0]],
                [self.columns[1][1], column[1]],
            ];
            self.upright = rising;
            self.beside = east;
        }
    }
}
