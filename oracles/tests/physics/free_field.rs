//! A line source in free field, at rest and moving, with a microphone at rest and moving: [`oracles::laws::free_field`]
//! and [`oracles::laws::direct_method`] say layout, formula and tolerance.
//!
//! Level over frequency beside them: 0.1 dB to 10 kHz (m13) and to 15 kHz (d25).

use crate::rig::{Path, assert_within};
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use oracles::laws::Depth;
use oracles::laws::direct_method::level_and_sidebands;
use oracles::laws::free_field::{error, measure};
use oracles::laws::setting::Setting;

#[test]
fn at_rest_and_moving() {
    assert_within("free field", &measure(Depth::Full).expect("finite fields"));
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
        let setting = Setting::drawn("level", &format!("{scheme}, {frequency_hz} Hz"));
        let spread_hz = 300.0;
        let (source, receiver): (Path<'_>, Path<'_>) = (&source, &receiver);
        let found = error(
            &setting,
            scheme,
            frequency_hz,
            spread_hz,
            source,
            receiver,
            1400,
        );
        let [_, level_db] = found.expect("a finite field");
        println!("free field, {scheme}, level at {frequency_hz} Hz, {setting}: {level_db:+.3} dB");
        assert!(
            level_db.abs() < tolerance_db,
            "{scheme}, {frequency_hz} Hz, {setting}: level off by {level_db} dB"
        );
    }
}

#[test]
fn level_and_false_sidebands_of_a_moving_source() {
    for frequency_hz in [2e3, 6e3, 10e3, 15e3] {
        let setting = Setting::drawn("sidebands", &format!("{frequency_hz} Hz"));
        let (scheme, spread) = (Scheme::D25, Spread::Kaiser8);
        let found = level_and_sidebands(&setting, scheme, spread, frequency_hz);
        let [level_db, sideband_db] = found.expect("a finite field");
        println!(
            "moving tone of {frequency_hz} Hz, {setting}: {level_db:+.3} dB, sidebands {sideband_db:.1} dB"
        );
        assert!(
            level_db.abs() < 0.1,
            "{frequency_hz} Hz, {setting}: level {level_db} dB"
        );
        assert!(
            sideband_db < -60.0,
            "{frequency_hz} Hz, {setting}: sidebands {sideband_db} dB"
        );
    }
}
