//! Every choice of the method; the default is the paper's Table I.

mod choices;
mod filter;
mod json;
mod measurement;
mod signal;

use std::sync::Arc;

use crate::error::Error;

pub use self::choices::{DirectWave, Integration, Method, Resampling, TimeReference, ToaImage};
pub use self::filter::FilterParameters;
#[cfg(test)]
pub(crate) use self::json::each_field_changed;
pub use self::measurement::MeasurementParameters;
pub use self::signal::SignalParameters;

/// Parameters of the method. `Default` is Table I of the paper, plus our choice wherever the paper leaves one open.
///
/// The JSON form is one flat object without the groups. Fields that are missing have their default; unknown ones are
/// refused.
///
/// ```
/// use localizer::{Method, Parameters};
///
/// let parameters: Parameters = serde_json::from_str(r#"{"periods": 4, "method": "toa-only"}"#)?;
/// assert_eq!(parameters.measurement.periods, 4);
/// assert_eq!(parameters.filter.method, Method::ToaOnly);
/// assert_eq!(parameters.signal, Parameters::default().signal);
/// assert!(serde_json::from_str::<Parameters>(r#"{"period": 4}"#).is_err());
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Parameters {
    /// Waveform, sample rate, speed of sound and place of the sensors, all fixed by the recording.
    pub signal: SignalParameters,
    /// Parameters that echoes and maps depend on, beside the signal's.
    pub measurement: MeasurementParameters,
    /// Parameters of the filter alone.
    pub filter: FilterParameters,
    /// One period of another waveform than the code's, fixed by the recording too. Not part of the JSON.
    pub transmitted: Option<Arc<[f32]>>,
}

impl Parameters {
    /// Samples L_s of one period, see [`SignalParameters::samples_per_period`].
    pub fn samples_per_period(&self) -> usize {
        self.signal.samples_per_period()
    }

    /// Duration of one period in seconds, see [`SignalParameters::period_s`].
    pub fn period_s(&self) -> f64 {
        self.signal.period_s()
    }

    /// Number of delays of every echo image: 0 to the one of `max_range_m`.
    pub fn delays(&self) -> usize {
        self.signal.delay_of_range(self.measurement.max_range_m) + 1
    }

    /// Half width of the matched images in cells, N_W.
    pub fn window_cells(&self) -> usize {
        (self.filter.window_half_width_m / self.measurement.cell_m).round() as usize
    }

    /// Checks every field once.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the first field that cannot be used.
    pub fn check(&self) -> Result<(), Error> {
        let refuse = |field: &str, value: &dyn std::fmt::Display, remedy: &str| {
            Err(Error::invalid(
                "parameters",
                field,
                format!("{value} cannot be used"),
                remedy,
            ))
        };
        for (field, value) in [
            ("sample_rate_hz", self.signal.sample_rate_hz),
            ("chip_rate_hz", self.signal.chip_rate_hz),
            ("carrier_hz", self.signal.carrier_hz),
            ("speed_of_sound_mps", self.signal.speed_of_sound_mps),
            ("cell_m", self.measurement.cell_m),
            ("window_half_width_m", self.filter.window_half_width_m),
            ("max_range_m", self.measurement.max_range_m),
            ("direct_wave_time_s", self.measurement.direct_wave_time_s),
            ("likelihood_exponent", self.filter.likelihood_exponent),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return refuse(field, &value, "give a positive number");
            }
        }
        for (field, value) in [
            ("sigma_v_mps", self.filter.sigma_v_mps),
            ("sigma_omega_radps", self.filter.sigma_omega_radps),
            ("min_range_m", self.measurement.min_range_m),
            ("range_pool_m", self.measurement.range_pool_m),
            ("min_speed_mps", self.measurement.min_speed_mps),
            ("start_sigma_m", self.filter.start_sigma_m),
            ("start_sigma_rad", self.filter.start_sigma_rad),
            ("sensor_offset_m[0]", self.signal.sensor_offset_m[0].abs()),
            ("sensor_offset_m[1]", self.signal.sensor_offset_m[1].abs()),
            (
                "sensor_baseline_m[0]",
                self.signal.sensor_baseline_m[0].abs(),
            ),
            (
                "sensor_baseline_m[1]",
                self.signal.sensor_baseline_m[1].abs(),
            ),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return refuse(field, &value, "give zero or a positive number");
            }
        }
        if !(0.0..=1.0).contains(&self.filter.resample_threshold) {
            return refuse(
                "resample_threshold",
                &self.filter.resample_threshold,
                "give a fraction from 0 to 1",
            );
        }
        if let Some(period) = &self.transmitted {
            if period.len() != self.samples_per_period() {
                let remedy = "give one period of the waveform at sample_rate_hz";
                return refuse("transmitted", &period.len(), remedy);
            }
        } else if self.signal.code_order().is_none() {
            return refuse(
                "code_length",
                &self.signal.code_length,
                "give 2^n - 1 with n from 2 to 18",
            );
        }
        let samples =
            self.signal.code_length as f64 / self.signal.chip_rate_hz * self.signal.sample_rate_hz;
        if (samples - samples.round()).abs() > 1e-6 {
            return refuse(
                "sample_rate_hz",
                &self.signal.sample_rate_hz,
                "choose it so that a whole number of samples makes one period of the code",
            );
        }
        if self.transmitted.is_none()
            && self.signal.carrier_hz + 0.5 * self.signal.chip_rate_hz
                > 0.5 * self.signal.sample_rate_hz
        {
            return refuse(
                "carrier_hz",
                &self.signal.carrier_hz,
                "keep carrier and half the chip rate below half the sample rate",
            );
        }
        if !(1..=64).contains(&self.measurement.periods) {
            return refuse("periods", &self.measurement.periods, "give 1 to 64");
        }
        if !(1..=1000).contains(&self.measurement.directions) {
            return refuse("directions", &self.measurement.directions, "give 1 to 1000");
        }
        if !(1..=255).contains(&self.filter.bins) {
            return refuse("bins", &self.filter.bins, "give 1 to 255");
        }
        if !(1..=10_000_000).contains(&self.filter.particles) {
            return refuse("particles", &self.filter.particles, "give 1 to 10 million");
        }
        if !(1..=2000).contains(&self.window_cells()) {
            return refuse(
                "window_half_width_m",
                &self.filter.window_half_width_m,
                "give 1 to 2000 cells of cell_m",
            );
        }
        if self.measurement.range_pool_m > self.measurement.max_range_m {
            return refuse(
                "range_pool_m",
                &self.measurement.range_pool_m,
                "give at most max_range_m; half a cell is plenty",
            );
        }
        let longest_m = self
            .signal
            .range_of_delay_m(self.signal.samples_per_period() as f64 - 1.0);
        if self.measurement.max_range_m > longest_m {
            let remedy =
                format!("give at most {longest_m:.2} m, half the way of sound in one period");
            return refuse("max_range_m", &self.measurement.max_range_m, &remedy);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{MeasurementParameters, SignalParameters};

    #[test]
    fn the_default_is_table_i() {
        let parameters = Parameters::default();
        assert!(parameters.check().is_ok());
        assert_eq!(parameters.samples_per_period(), 4092);
        assert!((parameters.period_s() - 0.1023).abs() < 1e-12);
        assert_eq!(parameters.window_cells(), 40);
    }

    #[test]
    fn unknown_and_unusable_fields_are_refused() {
        assert!(serde_json::from_str::<Parameters>(r#"{"periods": 4}"#).is_ok());
        assert!(serde_json::from_str::<Parameters>(r#"{"period": 4}"#).is_err());
        let bad = Parameters {
            measurement: MeasurementParameters {
                cell_m: f64::NAN,
                ..MeasurementParameters::default()
            },
            ..Parameters::default()
        };
        assert!(bad.check().unwrap_err().to_string().contains("cell_m"));
        let bad = Parameters {
            signal: SignalParameters {
                code_length: 1000,
                ..SignalParameters::default()
            },
            ..Parameters::default()
        };
        assert!(bad.check().unwrap_err().to_string().contains("2^n - 1"));
    }

    #[test]
    fn fifty_kilohertz_gives_five_samples_a_chip() {
        let parameters = Parameters {
            signal: SignalParameters {
                sample_rate_hz: 50_000.0,
                ..SignalParameters::default()
            },
            ..Parameters::default()
        };
        assert!(parameters.check().is_ok());
        assert_eq!(parameters.samples_per_period(), 5115);
    }
}
