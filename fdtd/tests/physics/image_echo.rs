//! Arrival and level of the echo of a rigid wall, and the time scale of two reflections between parallel walls:
//! [`fdtd::validation::echo`] says layout, formula and tolerance.

use fdtd::validation::echo::{CASES, PARALLEL, image, parallel_walls};

fn check(apart_m: f64, vertical: bool) {
    for (scheme, frequency_hz, tolerance) in CASES {
        let error = image(scheme, frequency_hz, apart_m, vertical).expect("a finite field");
        println!("echo, {scheme}, {apart_m} m apart: waveform, level in dB, delay in s {error:?}");
        for (error, tolerance) in error.iter().zip(tolerance) {
            assert!(
                error.abs() < tolerance,
                "{scheme}: {error} over {tolerance}"
            );
        }
    }
}

#[test]
fn a_wall_straight_ahead() {
    check(0.0, true);
}

#[test]
fn a_wall_met_at_an_angle() {
    check(0.7, false);
}

#[test]
fn two_parallel_walls_do_not_change_the_time_scale() {
    for (scheme, tolerance) in PARALLEL {
        let off = parallel_walls(scheme).expect("a finite field");
        println!("parallel walls, {scheme}: time scale off by {off:+.1e}");
        assert!(off.abs() < tolerance, "{scheme}: {off}");
    }
}
