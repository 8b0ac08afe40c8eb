//! A line source in free field, at rest and moving, heard by a microphone at rest and moving: [`fdtd::validation::free_field`] and
//! [`fdtd::validation::direct_method`] say layout, formula and tolerance.
//!
//! Level over frequency beside them: 0.1 dB to 10 kHz (m13) and to 15 kHz (d25).

use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use fdtd::validation::direct_method::level_and_sidebands;
use fdtd::validation::free_field::{CASES, MOTIONS, error};

fn check(number: usize) {
    let motion = MOTIONS[number];
    for (scheme, frequency_hz, tolerance, tolerance_db) in CASES {
        let [waveform, level_db] = error(
            scheme,
            frequency_hz,
            500.0,
            &motion.source,
            &motion.receiver,
            900,
        )
        .expect("a finite field");
        let name = motion.name;
        println!("free field, {name}, {scheme}: waveform {waveform:.5}, level {level_db:+.3} dB");
        assert!(
            waveform < tolerance,
            "{name}, {scheme}: waveform off by {waveform}"
        );
        assert!(
            level_db.abs() < tolerance_db,
            "{name}, {scheme}: level off by {level_db} dB"
        );
    }
}

#[test]
fn both_at_rest() {
    check(0);
}

#[test]
fn a_fast_source() {
    check(1);
}

#[test]
fn a_fast_microphone() {
    check(2);
}

#[test]
fn a_source_on_a_circle_and_a_microphone_in_motion() {
    check(3);
}

#[test]
fn level_over_frequency() {
    for (scheme, frequency_hz, tolerance_db) in [
        (Scheme::M13, 2e3, 0.01),
        (Scheme::M13, 6e3, 0.03),
        (Scheme::M13, 10e3, 0.1),
        (Scheme::M13, 14e3, 0.5),
        (Scheme::D25, 2e3, 0.01),
        (Scheme::D25, 6e3, 0.03),
        (Scheme::D25, 10e3, 0.05),
        (Scheme::D25, 15e3, 0.1),
    ] {
        let source = |t_s: f64| [0.9012 + 0.3 * t_s, 0.8021 - 0.2 * t_s];
        let receiver = |t_s: f64| [1.51 + 0.3 * t_s, 1.213 - 0.2 * t_s];
        let [_, level_db] =
            error(scheme, frequency_hz, 300.0, &source, &receiver, 1400).expect("a finite field");
        println!("free field, {scheme}, level at {frequency_hz} Hz: {level_db:+.3} dB");
        assert!(
            level_db.abs() < tolerance_db,
            "{scheme}, {frequency_hz} Hz: level off by {level_db} dB"
        );
    }
}

#[test]
fn level_and_false_sidebands_of_a_moving_source() {
    for frequency_hz in [2e3, 6e3, 10e3, 15e3] {
        let [level_db, sideband_db] =
            level_and_sidebands(Scheme::D25, Spread::Kaiser8, frequency_hz)
                .expect("a finite field");
        println!(
            "moving tone of {frequency_hz} Hz: {level_db:+.3} dB, sidebands {sideband_db:.1} dB"
        );
        assert!(
            level_db.abs() < 0.1,
            "{frequency_hz} Hz: level {level_db} dB"
        );
        assert!(
            sideband_db < -60.0,
            "{frequency_hz} Hz: sidebands {sideband_db} dB"
        );
    }
}
