//! A million steps in f32 between rigid walls.
//!
//! Layout: the closed room of the energy test, 64 x 64 cells; 120 periods of a tone in 2000 steps, then silence up to a million (8.3 s).
//! Formula: energy stays; the mean pressure is `rho c^2 / area` times the integral of q, which is zero after whole periods.
//! Bias: rounding is a random walk. Without the restoring quantum its double sum would move the mean by more than the sound.
//! Tolerance: 1e-3 of the energy; the mean below 1 % of the root mean square.

use crate::rig::DT_S;
use fdtd::field::Field;
use fdtd::scheme::Scheme;
use fdtd::validation::room::{closed_rig, energy};
use std::f64::consts::TAU;

#[test]
fn a_million_steps_do_not_drift() {
    // m13 is o13 with other weights.
    for scheme in [Scheme::Slf, Scheme::O13, Scheme::D25] {
        let rig = closed_rig(scheme, 64);
        let tone = |t_s: f64| {
            if t_s < 2000.0 * DT_S {
                (TAU * 7.2e3 * t_s).sin()
            } else {
                0.0
            }
        };
        let mut field = rig.field();
        field.advance(&rig.sounding([0.13, 0.15], &tone, 2100), &mut Vec::new());
        let silence = rig.silence(4000);
        let air = rig.walls.areas().iter().sum::<f64>();
        let early = energy(&mut field, &rig);
        let (mut mean, mut squares) = (0.0_f64, 0.0);
        for _ in 0..250 {
            field.advance(&silence, &mut Vec::new());
            let pressure = field.state().pressure;
            mean = mean.max((pressure.iter().map(|&p| f64::from(p)).sum::<f64>() / air).abs());
            squares += pressure.iter().map(|&p| f64::from(p).powi(2)).sum::<f64>() / air;
        }
        let rms = (squares / 250.0).sqrt();
        let change = energy(&mut field, &rig) / early - 1.0;
        println!(
            "drift, {scheme}: energy {change:+.1e}, mean at most {mean:.3} Pa, root mean square {rms:.1} Pa"
        );
        assert!(change.abs() < 1e-3, "{scheme}: energy changed by {change}");
        assert!(mean < 0.01 * rms, "{scheme}: mean {mean} Pa of {rms} Pa");
    }
}
