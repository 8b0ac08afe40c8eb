use super::*;
use crate::exact::{hankel::hankel0, tone};
use crate::laws::conditions::CONDITIONS;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

const AIR: Medium = CONDITIONS[6].medium;

/// The pressure of a burst at rest by its spectrum: (1/pi) Re int (omega rho / 4) Q(omega) H0^(2)(omega r/c) e^(i omega
/// t) d omega.
fn by_spectrum(burst: &Burst, r_m: f64, t_s: f64) -> f64 {
    let spread = 9.0 / burst.sigma_s;
    let (low, high) = (
        (TAU * burst.frequency_hz - spread).max(0.0),
        TAU * burst.frequency_hz + spread,
    );
    let steps = 4000;
    let step = (high - low) / f64::from(steps);
    let sum: Complex<f64> = (1..steps)
        .map(|k| {
            let omega = low + step * f64::from(k);
            burst.spectrum(omega)
                * hankel0(omega * r_m / AIR.c_mps)
                * Complex::from_polar(0.25 * omega * AIR.rho_kgpm3, omega * t_s)
        })
        .sum();
    sum.re * step / PI
}

#[test]
fn the_tail_integral_agrees_with_the_spectrum() {
    let burst = Burst::from_zero(8e3, 800.0);
    let strength = |t_s: f64| burst.value(t_s);
    let rest = |_: f64| [0.2, -0.1];
    let source = burst_on_path(AIR, burst, &strength, &rest);
    let (x_m, r_m) = ([0.8, 0.7], 1.0);
    let peak = tone::at_rest(&AIR, 8e3, 1.0, r_m).norm();
    for step in 0..60 {
        let t_s = r_m / AIR.c_mps + f64::from(step) * 6.1e-5;
        let (ours, other) = (source.pressure(x_m, t_s), by_spectrum(&burst, r_m, t_s));
        assert!(
            (ours - other).abs() < 1e-7 * peak,
            "at {t_s}: {ours} {other}"
        );
    }
}

#[test]
fn a_long_tone_in_uniform_motion_agrees_with_the_closed_form() {
    // Fast, so that a wrong power of the Mach number cannot hide; switched on slowly, so that the onset's tail is gone.
    let (v_mps, frequency_hz) = (100.0, 2e3);
    let ramp = |t_s: f64| {
        (0.5 - 0.5 * (PI * (t_s / 0.02).clamp(0.0, 1.0)).cos()) * (TAU * frequency_hz * t_s).cos()
    };
    let ramped = |t_s: f64| {
        if t_s < 0.02 {
            ramp(t_s.max(0.0))
        } else {
            (TAU * frequency_hz * t_s).cos()
        }
    };
    let moving = |t_s: f64| [v_mps * t_s, 0.0];
    let source = Monopole {
        medium: AIR,
        strength_at: &ramped,
        support_s: [0.0, 1.0],
        finest_s: 1.0 / frequency_hz,
        position_at: &moving,
    };
    for (ahead_m, y_m) in [(1.0, 0.0), (0.6, 0.8), (-0.7, 0.5), (-1.0, 0.0)] {
        for step in 0..8 {
            let t_s = 0.05 + f64::from(step) * 7.3e-5;
            let x_m = [v_mps * 0.05 + ahead_m, y_m];
            let exact = tone::in_uniform_motion(&AIR, frequency_hz, 1.0, v_mps, x_m, t_s);
            let ours = source.pressure(x_m, t_s);
            let scale = tone::at_rest(&AIR, frequency_hz, 1.0, 1.0).norm();
            assert!(
                (ours - exact).abs() < 1e-5 * scale,
                "{x_m:?} {t_s}: {ours} {exact}"
            );
        }
    }
}

#[test]
fn without_motion_the_closed_form_is_the_hankel_function() {
    let t_s = 1.2345e-3;
    let still = tone::in_uniform_motion(&AIR, 5e3, 2.0, 0.0, [0.3, 0.4], t_s);
    let rest = tone::at_rest(&AIR, 5e3, 2.0, 0.5) * Complex::from_polar(1.0, TAU * 5e3 * t_s);
    assert!((still - rest.re).abs() < 1e-9 * rest.norm());
}

#[test]
fn a_moving_microphone_hears_the_convective_derivative() {
    let burst = Burst::from_zero(4e3, 600.0);
    let strength = |t_s: f64| burst.value(t_s);
    let turning = |t_s: f64| [0.3 * (200.0 * t_s).cos(), 0.3 * (200.0 * t_s).sin()];
    let source = burst_on_path(AIR, burst, &strength, &turning);
    let v_mps = [40.0, -25.0];
    let receiver = |t_s: f64| [1.0 + v_mps[0] * t_s, 0.4 + v_mps[1] * t_s];
    let peak = tone::at_rest(&AIR, 4e3, 1.0, 1.0).norm();
    for step in 0..20 {
        let t_s = 3e-3 + f64::from(step) * 1.7e-4;
        let [x, y] = receiver(t_s);
        let (h_s, h_m) = (2e-6, 1e-3);
        let six = |f: &dyn Fn(f64) -> f64, h: f64| {
            let rise = |n: f64| f(n * h) - f(-n * h);
            (45.0 * rise(1.0) - 9.0 * rise(2.0) + rise(3.0)) / (60.0 * h)
        };
        let along = six(&|dt| source.potential(receiver(t_s + dt), t_s + dt), h_s);
        let gradient = [
            six(&|d| source.potential([x + d, y], t_s), h_m),
            six(&|d| source.potential([x, y + d], t_s), h_m),
        ];
        let convective = AIR.rho_kgpm3 * (along - v_mps[0] * gradient[0] - v_mps[1] * gradient[1]);
        assert!((convective - source.pressure([x, y], t_s)).abs() < 1e-5 * peak);
    }
}

#[test]
fn before_the_front_there_is_nothing() {
    let burst = Burst::from_zero(4e3, 600.0);
    let strength = |t_s: f64| burst.value(t_s);
    let rest = |_: f64| [0.0, 0.0];
    let source = burst_on_path(AIR, burst, &strength, &rest);
    assert_eq!(source.potential([1.0, 0.0], 1.0 / AIR.c_mps - 1e-6), 0.0);
    assert!(source.potential([1.0, 0.0], 1.0 / AIR.c_mps + burst.centre_s) != 0.0);
}
