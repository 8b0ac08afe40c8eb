//! Absorption of sound by the atmosphere: ISO 9613-1:1993, eqs. (3) to (5) and B.2, B.3.

use super::{Air, STANDARD_PRESSURE_PA};

/// Decibels per neper.
pub const DECIBELS_PER_NEPER: f64 = 8.685_889_638_065_037;

/// Attenuation of a tone in dB/m at a frequency in hertz: the classical part, and the relaxation of oxygen and
/// nitrogen.
///
/// Good to 10 % for 0.05 to 5 % of water vapour and -20 to 50 degC, says the standard.
pub fn decibels_per_metre(air: &Air, frequency_hz: f64) -> f64 {
    let (kelvin, square) = (air.temperature_k(), frequency_hz * frequency_hz);
    let (warmth, pressure) = (kelvin / 293.15, air.pressure_pa / STANDARD_PRESSURE_PA);
    let saturation = 10_f64.powf(-6.8346 * (273.16 / kelvin).powf(1.261) + 4.6151);
    // Molar concentration of water vapour in percent.
    let h = air.relative_humidity_percent * saturation / pressure;
    let oxygen_hz = pressure * (24.0 + 4.04e4 * h * (0.02 + h) / (0.391 + h));
    let nitrogen_hz = pressure / warmth.sqrt()
        * (9.0 + 280.0 * h * (-4.170 * (warmth.powf(-1.0 / 3.0) - 1.0)).exp());
    let relaxation = |share: f64, vibration_k: f64, at_hz: f64| {
        share * (-vibration_k / kelvin).exp() / (at_hz + square / at_hz)
    };
    8.686
        * square
        * (1.84e-11 / pressure * warmth.sqrt()
            + warmth.powf(-2.5)
                * (relaxation(0.012_75, 2239.1, oxygen_hz)
                    + relaxation(0.1068, 3352.0, nitrogen_hz)))
}

/// The same in nepers per metre: a wave's amplitude falls as `exp(-alpha x)`.
pub fn nepers_per_metre(air: &Air, frequency_hz: f64) -> f64 {
    decibels_per_metre(air, frequency_hz) / DECIBELS_PER_NEPER
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exact midband frequency of the octave band of `1000 * 2^octave` hertz, as the standard's tables are computed.
    fn midband_hz(octave: i32) -> f64 {
        1000.0 * 10_f64.powf(0.3 * f64::from(octave))
    }

    #[test]
    fn the_table_of_iso_9613_2_is_met_to_its_last_digit() {
        // ISO 9613-2:1996, table 2: temperature in degC, humidity in percent, dB/km at 500 Hz to 8 kHz. Computed with
        // this formula, rounded to three digits at most.
        let table: [(f64, f64, [f64; 5]); 6] = [
            (10.0, 70.0, [1.9, 3.7, 9.7, 32.8, 117.0]),
            (20.0, 70.0, [2.8, 5.0, 9.0, 22.9, 76.6]),
            (30.0, 70.0, [3.1, 7.4, 12.7, 23.1, 59.3]),
            (15.0, 20.0, [2.7, 8.2, 28.2, 88.8, 202.0]),
            (15.0, 50.0, [2.2, 4.2, 10.8, 36.2, 129.0]),
            (15.0, 80.0, [2.4, 4.1, 8.3, 23.7, 82.8]),
        ];
        for (temperature_degc, relative_humidity_percent, values) in table {
            let air = Air {
                temperature_degc,
                relative_humidity_percent,
                pressure_pa: STANDARD_PRESSURE_PA,
            };
            for (octave, expected) in (-1..).zip(values) {
                let found = 1e3 * decibels_per_metre(&air, midband_hz(octave));
                let digit = if expected < 100.0 { 0.1 } else { 1.0 };
                assert!(
                    (found - expected).abs() < 0.6 * digit,
                    "{temperature_degc} degC, {relative_humidity_percent} %: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn ten_kilohertz_at_twenty_degrees_and_half_humidity() {
        // ISO 9613-1:1993, table 1: 1.59e2 dB/km.
        let air = Air {
            temperature_degc: 20.0,
            relative_humidity_percent: 50.0,
            pressure_pa: STANDARD_PRESSURE_PA,
        };
        let found = 1e3 * decibels_per_metre(&air, 10e3);
        assert!((found - 159.0).abs() < 1.0, "{found}");
        assert!((nepers_per_metre(&air, 10e3) - found * 1e-3 / 8.686).abs() < 1e-6);
    }
}
