//! Sound on the grid is as fast as the discrete dispersion relation says.
//!
//! Layout: 2.6 m x 2.6 m; a broad burst from a cell's centre, heard 0.5 m and 1.2 m away along the axis and along the diagonal.
//! Formula: `k` solves the scheme's symbol at `4 sin^2(omega dt/2)`; the phase between the two places is that of `H0^(2)(k r)`.
//! Bias: the curvature of the slowness curve changes the near-field term; below 1e-5 here.
//! Tolerance: 1e-4 of the phase velocity at 4, 7, 10 and 13 kHz, while its own error is up to 2.6 % (slf) and 0.7 % (m13).

use crate::rig::{DT_S, DX_M, Rig, centre_m, line};
use fdtd::exact::burst::Burst;
use fdtd::exact::hankel::hankel0;
use fdtd::scheme::{Scheme, phase_velocity};
use std::f64::consts::{FRAC_PI_4, TAU};

#[test]
fn phase_velocity_over_frequency_and_angle() {
    let burst = Burst::from_zero(8.5e3, 3e3);
    let strength = |t_s: f64| burst.value(t_s);
    for scheme in Scheme::ALL {
        for (angle_rad, step) in [(0.0, [1, 0]), (FRAC_PI_4, [1, 1])] {
            let rig = Rig::open(scheme, 520, 520);
            let source = |_: f64| centre_m(120, 120);
            let [near, far] = [100, if step[1] == 0 { 240 } else { 210 }].map(|cells| {
                let receiver = |_: f64| centre_m(120 + cells * step[0], 120 + cells * step[1]);
                let r_m = cells as f64 * DX_M * (step[0] as f64).hypot(step[1] as f64);
                (r_m, rig.run(&source, &receiver, &strength, 1100))
            });
            for frequency_hz in [4e3, 7e3, 10e3, 13e3] {
                let expected =
                    phase_velocity(scheme, rig.courant(), TAU * frequency_hz * DT_S, angle_rad)
                        .expect("below the cut-off");
                let k = TAU * frequency_hz / (340.0 * expected);
                let measured = line(&far.1, frequency_hz) / line(&near.1, frequency_hz);
                let model = hankel0(k * far.0) / hankel0(k * near.0);
                let error = (measured / model).arg() / (k * (far.0 - near.0));
                println!(
                    "dispersion, {scheme}, {:.0} degrees, {frequency_hz} Hz: {expected:.5}, off by {error:+.1e}",
                    angle_rad.to_degrees()
                );
                assert!(
                    error.abs() < 1e-4,
                    "{scheme} {angle_rad} {frequency_hz}: {error}"
                );
            }
        }
    }
}
