//! Source and receiver in one row. Functions of their own: a step calls them for few of its rows, and the compiler
//! would otherwise spread their checks over the sweeps' function, which has no register to spare.

use super::super::super::step::Injection;
use super::super::plan::Plan;
use crate::spread::Stencil;

/// Adds to row `iy`, which is one of the stencil's, the source's contribution to it. Solid cells take nothing.
#[inline(never)]
pub(super) fn send(plan: &Plan, row: &mut [f32], iy: usize, injection: &Injection) {
    let s = &injection.stencil;
    let weight = s.wy[iy - s.y0] * injection.amplitude;
    for (ix, wx) in (s.x0..).zip(&s.wx) {
        let p = &mut row[plan.layout.offset(ix)];
        *p = wx.mul_add(weight, *p);
    }
    for &ix in plan.setup.walls.solid_within(iy, s.x0..s.x0 + s.wx.len()) {
        row[plan.layout.offset(ix)] = 0.0;
    }
}

/// The receiver's sum over one of the stencil's rows, weighted along x.
#[inline(never)]
pub(super) fn receive(plan: &Plan, row: &[f32], s: &Stencil) -> f64 {
    let taps = (s.x0..).zip(&s.wx);
    taps.map(|(ix, &wx)| f64::from(wx) * f64::from(row[plan.layout.offset(ix)]))
        .sum()
}
