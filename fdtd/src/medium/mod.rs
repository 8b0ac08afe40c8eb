//! Air by its weather: speed of sound, density and absorption from temperature, humidity and pressure.
//!
//! All three take the same mole fraction of water vapour but [`absorption`], which has its own in the standard.

pub mod absorbed;
pub mod absorption;
mod density;
mod sound_speed;

use crate::error::Error;
use crate::grid::Medium;

/// Pressure of the standard atmosphere in pascals.
pub const STANDARD_PRESSURE_PA: f64 = 101_325.0;

/// Mole fraction of carbon dioxide in [`Air`], as in the reference state of CIPM-2007.
pub const CARBON_DIOXIDE: f64 = 4e-4;

/// Temperatures in degC that are accepted: where Cramer's polynomial is fitted.
pub const TEMPERATURES_DEGC: [f64; 2] = [0.0, 30.0];

/// Relative humidities in percent that are accepted.
pub const HUMIDITIES_PERCENT: [f64; 2] = [0.0, 100.0];

/// Pressures in pascals that are accepted: where CIPM-2007 holds. Cramer's polynomial is fitted from 75 to 102 kPa; in
/// the rest of this range its pressure terms are below 0.03 m/s.
pub const PRESSURES_PA: [f64; 2] = [60e3, 110e3];

/// Air at rest by its weather.
///
/// ```
/// use fdtd::medium::{Air, STANDARD_PRESSURE_PA};
///
/// let air = Air { temperature_degc: 20.0, relative_humidity_percent: 0.0, pressure_pa: STANDARD_PRESSURE_PA };
/// let medium = air.medium();
/// assert!((medium.c_mps - 343.4).abs() < 0.1);
/// assert!((medium.rho_kgpm3 - 1.204).abs() < 0.001);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Air {
    /// Temperature in degC.
    pub temperature_degc: f64,
    /// Relative humidity in percent.
    pub relative_humidity_percent: f64,
    /// Pressure in pascals.
    pub pressure_pa: f64,
}

impl Air {
    /// Refuses numbers outside the formulas' ranges. `origin` is the file, `at` what stands before a field's name
    /// (`medium.`, `--`).
    ///
    /// # Errors
    /// [`Error::Invalid`] that names the field and its range.
    pub fn check(&self, origin: &str, at: &str) -> Result<(), Error> {
        let fields = [
            (
                "temperature_degc",
                self.temperature_degc,
                TEMPERATURES_DEGC,
                "degC",
            ),
            (
                "relative_humidity_percent",
                self.relative_humidity_percent,
                HUMIDITIES_PERCENT,
                "percent",
            ),
            ("pressure_pa", self.pressure_pa, PRESSURES_PA, "Pa"),
        ];
        for (field, value, [low, high], unit) in fields {
            if !(low..=high).contains(&value) {
                return Err(Error::invalid(
                    origin,
                    format!("{at}{field}"),
                    format!("{value} is out of range"),
                    format!("give a number from {low} to {high} {unit}"),
                ));
            }
        }
        Ok(())
    }

    /// Thermodynamic temperature in kelvins.
    pub fn temperature_k(&self) -> f64 {
        self.temperature_degc + 273.15
    }

    /// Mole fraction of water vapour: humidity times enhancement factor times saturation pressure over pressure
    /// (CIPM-2007: Picard et al. 2008, eqs. A1.1 to A1.3).
    pub fn water_vapour(&self) -> f64 {
        let (t, kelvin, p) = (
            self.temperature_degc,
            self.temperature_k(),
            self.pressure_pa,
        );
        let saturation_pa = (1.237_884_7e-5 * kelvin * kelvin - 1.912_131_6e-2 * kelvin
            + 33.937_110_47
            - 6.343_164_5e3 / kelvin)
            .exp();
        let enhancement = 1.000_62 + 3.14e-8 * p + 5.6e-7 * t * t;
        1e-2 * self.relative_humidity_percent * enhancement * saturation_pa / p
    }

    /// Speed of sound in m/s (Cramer 1993).
    pub fn speed_of_sound_mps(&self) -> f64 {
        sound_speed::cramer_mps(
            self.temperature_degc,
            self.pressure_pa,
            self.water_vapour(),
            CARBON_DIOXIDE,
        )
    }

    /// Density in kg/m^3 (CIPM-2007).
    pub fn density_kgpm3(&self) -> f64 {
        density::cipm2007_kgpm3(
            self.temperature_degc,
            self.pressure_pa,
            self.water_vapour(),
            CARBON_DIOXIDE,
        )
    }

    /// The medium of the field.
    pub fn medium(&self) -> Medium {
        Medium {
            c_mps: self.speed_of_sound_mps(),
            rho_kgpm3: self.density_kgpm3(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn air(temperature_degc: f64, relative_humidity_percent: f64) -> Air {
        Air {
            temperature_degc,
            relative_humidity_percent,
            pressure_pa: STANDARD_PRESSURE_PA,
        }
    }

    #[test]
    fn water_vapour_is_that_of_the_steam_tables() {
        // Saturation pressure of water at 20 degC: 2339 Pa, at 0 degC 611.2 Pa (IAPWS); the enhancement adds 0.4 %.
        for (temperature_degc, saturation_pa) in [(0.0, 611.2), (20.0, 2339.2)] {
            let pressure_pa =
                air(temperature_degc, 100.0).water_vapour() * STANDARD_PRESSURE_PA / 1.004;
            assert!(
                (pressure_pa / saturation_pa - 1.0).abs() < 1e-3,
                "{pressure_pa}"
            );
        }
        assert_eq!(air(20.0, 0.0).water_vapour(), 0.0);
    }

    #[test]
    fn warm_and_humid_air_is_faster_and_lighter() {
        let [dry, humid, warm] =
            [air(20.0, 0.0), air(20.0, 80.0), air(25.0, 0.0)].map(|air| air.medium());
        assert!(humid.c_mps > dry.c_mps && warm.c_mps > dry.c_mps);
        assert!(humid.rho_kgpm3 < dry.rho_kgpm3 && warm.rho_kgpm3 < dry.rho_kgpm3);
    }

    #[test]
    fn what_the_formulas_do_not_cover_is_refused() {
        assert!(air(20.0, 50.0).check("file", "medium.").is_ok());
        for (bad, field) in [
            (air(31.0, 50.0), "medium.temperature_degc"),
            (air(f64::NAN, 50.0), "medium.temperature_degc"),
            (air(20.0, 101.0), "medium.relative_humidity_percent"),
            (
                Air {
                    pressure_pa: 1013.25,
                    ..air(20.0, 50.0)
                },
                "medium.pressure_pa",
            ),
        ] {
            let message = bad.check("file", "medium.").unwrap_err().to_string();
            assert!(
                message.starts_with(&format!("file: {field}: ")),
                "{message}"
            );
        }
    }
}
