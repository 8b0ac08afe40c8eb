//! Density of humid air: CIPM-2007 (Picard, Davis, Glaeser and Fujii 2008, Metrologia 45, 149), eqs. (1) and A1.4.

/// Molar gas constant of the paper, J/(mol K).
const GAS_CONSTANT: f64 = 8.314_472;
/// Molar mass of dry air with 400 parts per million of carbon dioxide, kg/mol.
const DRY_AIR: f64 = 28.965_46e-3;
/// Added molar mass per mole fraction of carbon dioxide above that (it takes the place of oxygen), kg/mol.
const CARBON: f64 = 12.011e-3;
/// Molar mass of water, kg/mol.
const WATER: f64 = 18.015_28e-3;

/// Density in kg/m^3; temperature in degC, pressure in pascals, mole fractions of water vapour and carbon dioxide. Good
/// to 22 parts per million from 15 to 27 degC and 60 to 110 kPa.
pub(super) fn cipm2007_kgpm3(t: f64, p: f64, water: f64, carbon_dioxide: f64) -> f64 {
    let kelvin = t + 273.15;
    let molar_mass = DRY_AIR + CARBON * (carbon_dioxide - 4e-4);
    p * molar_mass / (compressibility(t, p, water) * GAS_CONSTANT * kelvin)
        * (1.0 - water * (1.0 - WATER / molar_mass))
}

/// Compressibility factor Z.
fn compressibility(t: f64, p: f64, water: f64) -> f64 {
    let over = p / (t + 273.15);
    let first = 1.581_23e-6 - 2.9331e-8 * t
        + 1.1043e-10 * t * t
        + (5.707e-6 - 2.051e-8 * t) * water
        + (1.9898e-4 - 2.376e-6 * t) * water * water;
    1.0 - over * first + over * over * (1.83e-11 - 0.765e-8 * water * water)
}

#[cfg(test)]
mod tests {
    use super::super::{Air, STANDARD_PRESSURE_PA};
    use super::*;

    #[test]
    fn dry_air_at_the_standard_state_weighs_what_tables_say() {
        // 1.2930 kg/m^3 at 0 degC, 1.2041 at 20 degC, 1.2250 at 15 degC (standard atmosphere, ideal gas).
        for (t, table) in [(0.0, 1.2930), (15.0, 1.2250), (20.0, 1.2041)] {
            let density = cipm2007_kgpm3(t, STANDARD_PRESSURE_PA, 0.0, 314e-6);
            assert!((density / table - 1.0).abs() < 6e-4, "{t} {density}");
        }
    }

    #[test]
    fn humid_air_agrees_with_the_approximate_formula_of_oiml_r111() {
        // OIML R 111-1, eq. (E.3-1): p in hPa, h in percent; relative uncertainty 2e-4 from 900 to 1100 hPa, 10 to 30
        // degC, below 80 %.
        for (t, percent, p) in [
            (20.0, 50.0, STANDARD_PRESSURE_PA),
            (12.0, 30.0, 95e3),
            (28.0, 75.0, 105e3),
        ] {
            let air = Air {
                temperature_degc: t,
                relative_humidity_percent: percent,
                pressure_pa: p,
            };
            let approximate =
                (0.348_48 * 1e-2 * p - 0.009 * percent * (0.061 * t).exp()) / (273.15 + t);
            let ratio = air.density_kgpm3() / approximate;
            assert!((ratio - 1.0).abs() < 2e-4, "{t} {ratio}");
        }
    }
}
