//! Speed of sound in humid air: Cramer 1993, J. Acoust. Soc. Am. 93, 2510, eq. (15) and Table III.

/// Coefficients `a_0` to `a_15` for the speed of sound.
const A: [f64; 16] = [
    331.5024,
    0.603_055,
    -0.000_528,
    51.471_935,
    0.149_587_4,
    -0.000_782,
    -1.82e-7,
    3.73e-8,
    -2.93e-10,
    -85.209_31,
    -0.228_525,
    5.91e-5,
    -2.835_149,
    -2.15e-13,
    29.179_762,
    0.000_486,
];

/// Speed of sound at zero frequency in m/s; temperature in degC, pressure in pascals, mole fractions of water vapour
/// and carbon dioxide. Fitted from 0 to 30 degC, 75 to 102 kPa, up to 0.06 and 0.01; off the theory by less than 300
/// parts per million.
pub(super) fn cramer_mps(t: f64, p: f64, water: f64, carbon_dioxide: f64) -> f64 {
    let squared = |first: usize| A[first] + t * (A[first + 1] + t * A[first + 2]);
    squared(0)
        + squared(3) * water
        + squared(6) * p
        + squared(9) * carbon_dioxide
        + A[12] * water * water
        + A[13] * p * p
        + A[14] * carbon_dioxide * carbon_dioxide
        + A[15] * water * p * carbon_dioxide
}

#[cfg(test)]
mod tests {
    use super::super::{Air, STANDARD_PRESSURE_PA};
    use super::*;

    #[test]
    fn dry_air_has_the_published_speeds() {
        // Tables give 331.3 to 331.5 m/s at 0 degC.
        let zero = cramer_mps(0.0, STANDARD_PRESSURE_PA, 0.0, 314e-6);
        assert!((zero - 331.45).abs() < 0.02, "{zero}");
        // ISO 9613-1 takes 343.2 m/s at 20 degC, as an ideal gas.
        let twenty = cramer_mps(20.0, STANDARD_PRESSURE_PA, 0.0, 314e-6);
        assert!((twenty - 343.3).abs() < 0.1, "{twenty}");
        // An ideal gas's speed rises with the root of the temperature.
        let ratio = twenty / zero / (293.15_f64 / 273.15).sqrt();
        assert!((ratio - 1.0).abs() < 3e-4, "{ratio}");
    }

    #[test]
    fn humid_air_is_faster_by_theory() {
        // Vapour of mole fraction x changes molar mass and ratio of specific heats: c rises by about 0.16 x (Bohn 1988:
        // 0.3 % from dry to saturated at 20 degC).
        let speed = |relative_humidity_percent: f64| {
            Air {
                temperature_degc: 20.0,
                relative_humidity_percent,
                pressure_pa: STANDARD_PRESSURE_PA,
            }
            .speed_of_sound_mps()
        };
        let rise = speed(100.0) / speed(0.0) - 1.0;
        assert!((0.0030..0.0042).contains(&rise), "{rise}");
    }
}
