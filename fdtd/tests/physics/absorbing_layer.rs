//! What the absorbing layer sends back.
//!
//! Layout: source and microphone 0.3 m in front of the layer of 20 cells and as far apart as the angle asks; a broad burst (3 to 13 kHz at -20 dB). The same in a
//! grid whose every border is 1 m further away is subtracted.
//! Formula: reflection = peak of the difference over peak of the echo that a rigid wall in the layer's place would send (image source).
//! Bias: the difference holds the echoes of all four borders, so it is an upper bound.
//! Tolerance: -60 dB at 0, 30, 45 and 60 degrees, both schemes.

use crate::rig::{AIR, DX_M, Rig, decibels, difference, exact};
use fdtd::exact::burst::Burst;
use fdtd::exact::monopole::burst_on_path;
use fdtd::scheme::Scheme;

const AWAY_M: f64 = 0.3;
const MORE_CELLS: usize = 200;

fn peak(signal: &[f64]) -> f64 {
    signal.iter().fold(0.0, |most, p| p.abs().max(most))
}

#[test]
fn the_layer_reflects_less_than_a_thousandth_up_to_sixty_degrees() {
    let burst = Burst::from_zero(8e3, 2500.0);
    let strength = |t_s: f64| burst.value(t_s);
    for scheme in Scheme::ALL {
        for degrees in [0.0_f64, 30.0, 45.0, 60.0] {
            let apart_m = 2.0 * AWAY_M * degrees.to_radians().tan();
            let steps = ((2.0 * AWAY_M / degrees.to_radians().cos() / AIR.c_mps
                + burst.support_s()[1])
                * 1.15
                * 120e3) as usize;
            let (nx, ny) = (400, 180);
            let left_m = 0.5 * (nx as f64 * DX_M - apart_m);
            let hear = |more: usize| {
                let shift_m = more as f64 * DX_M;
                let low_m = 20.0 * DX_M + AWAY_M + shift_m;
                let rig = Rig::open(scheme, nx + 2 * more, ny + 2 * more);
                rig.run(
                    &|_| [left_m + shift_m, low_m],
                    &|_| [left_m + apart_m + shift_m, low_m],
                    &strength,
                    steps,
                )
            };
            let sent_back = peak(&difference(&hear(0), &hear(MORE_CELLS)));
            let image = |_: f64| [0.0, -AWAY_M];
            let echo = peak(&exact(
                &burst_on_path(AIR, burst, &strength, &image),
                &|_| [apart_m, AWAY_M],
                steps,
            ));
            let reflection_db = decibels(sent_back / echo);
            println!("layer, {scheme}, {degrees} degrees: {reflection_db:.1} dB");
            assert!(
                reflection_db < -60.0,
                "{scheme} at {degrees} degrees: {reflection_db} dB"
            );
        }
    }
}
