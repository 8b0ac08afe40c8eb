//! One step in one row: stencils and layers.

use super::super::stencil::{Splat, layer};
use crate::number::Number;
use crate::scheme::Scheme;

/// Cells of zero pressure around the grid, as many as the widest stencil reaches.
pub(super) const RIM: usize = 3;

/// Quantity whose second difference the layer takes, for neighbouring cells of a row; `at(along, across)` gives the
/// cells from the first one on, shifted along the absorbed axis and across it.
#[inline(always)]
pub(super) fn layered_row<'a, N: Number + 'a>(
    scheme: Scheme,
    w: &Splat<N>,
    at: impl Fn(isize, isize) -> &'a [N],
    layered: &mut [N],
) {
    let n = layered.len();
    let cells = |along, across| &at(along, across)[..n];
    let here = cells(0, 0);
    if scheme == Scheme::Slf {
        return layered.copy_from_slice(here);
    }
    let (low, high, left, right) = (cells(-1, 0), cells(1, 0), cells(0, -1), cells(0, 1));
    if scheme == Scheme::D25 {
        let (lower, higher) = (cells(-2, 0), cells(2, 0));
        let corners = [[-1, -1], [-1, 1], [1, -1], [1, 1]];
        let [a, b, c, d] = corners.map(|[along, across]| cells(along, across));
        for i in 0..n {
            layered[i] = w.d25_layer(
                here[i],
                [[low[i], high[i]], [lower[i], higher[i]]],
                [left[i], right[i]],
                [[a[i], b[i]], [c[i], d[i]]],
            );
        }
        return;
    }
    for i in 0..n {
        layered[i] = w.m13_layer(here[i], [low[i], high[i]], [left[i], right[i]]);
    }
}

/// Contribution of the layer to neighbouring cells `next` of a row, from the quantity of [`layered_row`] below, at and
/// above them; `memory` holds that of their lower faces, then upper faces, then their own.
#[inline(always)]
pub(super) fn absorb<N: Number>(
    [lower, here, upper]: [&[N]; 3],
    decay: impl Fn(usize) -> [f32; 3],
    open: f32,
    memory: &mut [N],
    linear: f32,
    next: &mut [N],
) {
    let (n, open, linear) = (next.len(), N::splat(open), N::splat(linear));
    let (lower, here, upper) = (&lower[..n], &here[..n], &upper[..n]);
    let (memory_lower, rest) = memory.split_at_mut(n);
    let (memory_upper, memory_cell) = rest.split_at_mut(n);
    let memory_cell = &mut memory_cell[..n];
    for i in 0..n {
        let slopes = [here[i].sub(lower[i]), upper[i].sub(here[i])];
        let old = [memory_lower[i], memory_upper[i], memory_cell[i]];
        let (new, change) = layer(slopes, decay(i).map(N::splat), open, old);
        [memory_lower[i], memory_upper[i], memory_cell[i]] = new;
        next[i] = linear.mul_add(change, next[i]);
    }
}

/// Standard leapfrog in the cells `next` of a row, which hold their past, from the rows around it with their rims.
#[inline(always)]
pub(super) fn slf_row<N: Number>(w: &Splat<N>, [south, here, north]: [&[N]; 3], next: &mut [N]) {
    let n = next.len();
    let (west, east) = (&here[RIM - 1..][..n], &here[RIM + 1..][..n]);
    let (south, here, north) = (&south[RIM..][..n], &here[RIM..][..n], &north[RIM..][..n]);
    for i in 0..n {
        next[i] = w.slf(here[i], [west[i], east[i]], [south[i], north[i]], next[i]);
    }
}

/// As [`slf_row`], 13 points.
#[inline(always)]
pub(super) fn m13_row<N: Number>(
    w: &Splat<N>,
    [far_south, south, here, north, far_north]: [&[N]; 5],
    next: &mut [N],
) {
    let n = next.len();
    let width = n + 2 * RIM;
    let (far_south, south, here) = (&far_south[..width], &south[..width], &here[..width]);
    let (north, far_north) = (&north[..width], &far_north[..width]);
    for (i, p) in next.iter_mut().enumerate() {
        let x = i + RIM;
        let west = w.m13_column(here[x - 1], south[x - 1].add(north[x - 1]));
        let east = w.m13_column(here[x + 1], south[x + 1].add(north[x + 1]));
        *p = w.m13(
            here[x],
            south[x].add(north[x]),
            [west, east],
            [here[x - 2], here[x + 2]],
            [far_south[x], far_north[x]],
            *p,
        );
    }
}

/// As [`slf_row`], 25 points.
#[inline(always)]
pub(super) fn d25_row<N: Number>(w: &Splat<N>, rows: [&[N]; 7], next: &mut [N]) {
    let width = next.len() + 2 * RIM;
    let [s3, s2, s1, here, n1, n2, n3] = rows.map(|row| &row[..width]);
    for (i, p) in next.iter_mut().enumerate() {
        let x = i + RIM;
        let column = [s2, s1, here, n1, n2];
        let west = [
            d25_sides(w, column, x - 2)[1],
            d25_sides(w, column, x - 1)[0],
        ];
        let east = [
            d25_sides(w, column, x + 1)[0],
            d25_sides(w, column, x + 2)[1],
        ];
        let own = [s1[x].add(n1[x]), s2[x].add(n2[x]), s3[x].add(n3[x])];
        let sum = w.d25_first(here[x - 3], *p).add(west[0]).add(west[1]);
        let sum = w.d25_own(here[x], own, sum).add(east[0]).add(east[1]);
        *p = w.d25_last(here[x + 3], sum);
    }
}

/// Contributions of the cells of a column to the columns beside it. Not a closure: one that is not inlined is compiled
/// without fused multiply-adds.
#[inline(always)]
fn d25_sides<N: Number>(w: &Splat<N>, [s2, s1, here, n1, n2]: [&[N]; 5], x: usize) -> [N; 2] {
    w.d25_sides(here[x], [s1[x].add(n1[x]), s2[x].add(n2[x])])
}
