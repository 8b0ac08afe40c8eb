//! Between rigid walls energy stays.
//!
//! Layout: a closed polygon with slanted sides and a screen in it, 160 x 160 cells; a broad burst, then 20 000 steps without a source.
//! Formula: the leapfrog's invariant `|p' - p|^2 / 2 - <p', L p> / 2` with `L p = p' - 2 p + p''` from three successive fields.
//! Bias: none; the operator is symmetric.
//! Tolerance: 1e-4 of the energy over the run. A wall that is not symmetric would blow up or decay within some hundred steps.

use crate::rig::Rig;
use fdtd::exact::burst::Burst;
use fdtd::field::{FastField, Field};
use fdtd::scheme::Scheme;

/// The invariant at the half step to come. Takes one step.
pub(crate) fn energy(field: &mut FastField, rig: &Rig) -> f64 {
    let before = field.state();
    field.advance(&rig.silence(1), &mut Vec::new());
    let after = field.state();
    let cells = after
        .pressure
        .iter()
        .zip(&before.pressure)
        .zip(&before.previous);
    cells
        .map(|((&next, &now), &past)| {
            let (next, now, past) = (f64::from(next), f64::from(now), f64::from(past));
            0.5 * (next - now).powi(2) - 0.5 * next * (next - 2.0 * now + past)
        })
        .sum()
}

pub(crate) fn closed_rig(scheme: Scheme, size: usize) -> Rig {
    let last = size as f64;
    let mut rig = Rig::open(scheme, size, size).with_walls(|ix, iy| {
        let (x, y) = (ix as f64, iy as f64);
        let outside = x < 5.0 + 0.1 * y
            || x > last - 6.0 - 0.05 * y
            || y < 5.0 + 0.15 * x
            || y > last - 7.0 - 0.2 * (x - 0.5 * last).abs();
        let screen = (x - 0.6 * last - 0.4 * (y - 0.5 * last)).abs() < 2.0
            && (y - 0.5 * last).abs() < 0.15 * last;
        outside || screen
    });
    rig.layer_cells = 0;
    rig
}

#[test]
fn energy_stays_in_a_closed_room() {
    for scheme in Scheme::ALL {
        let rig = closed_rig(scheme, 160);
        let burst = Burst::from_zero(6e3, 2000.0);
        let mut field = rig.field();
        field.advance(
            &rig.sounding([0.3, 0.32], &|t_s| burst.value(t_s), 400),
            &mut Vec::new(),
        );
        let start = energy(&mut field, &rig);
        let silence = rig.silence(2000);
        for turn in 1..=10 {
            field.advance(&silence, &mut Vec::new());
            let change = energy(&mut field, &rig) / start - 1.0;
            println!(
                "energy, {scheme}, after {} steps: {change:+.1e}",
                2000 * turn
            );
            assert!(
                start > 0.0 && change.abs() < 1e-4,
                "{scheme}: energy changed by {change}"
            );
        }
    }
}
