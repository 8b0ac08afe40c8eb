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
pub use self::signal::{FARTHEST_SENSOR_M, SPEEDS_OF_SOUND_MPS, SignalParameters};

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
        self.check_of(self.transmitted.is_some())
    }

    /// As [`Self::check`], of a map: it may come from a waveform of its own, which the map does not hold.
    pub(crate) fn check_of_map(&self) -> Result<(), Error> {
        self.check_of(self.transmitted.is_some() || self.signal.code_length == 1)
    }

    fn check_of(&self, other_waveform: bool) -> Result<(), Error> {
        let refuse = |field: &str, value: &dyn std::fmt::Display, remedy: &str| {
            Err(Error::invalid(
                "parameters",
                field,
                format!("{value} cannot be used"),
                remedy,
            ))
        };
        self.signal.check("parameters", other_waveform)?;
        let Self {
            measurement: m,
            filter: f,
            ..
        } = self;
        // Beyond these numbers there is no room, no robot, and no exact arithmetic.
        for (field, value, low, high) in [
            ("cell_m", m.cell_m, 1e-4, 100.0),
            ("window_half_width_m", f.window_half_width_m, 1e-4, 1e4),
            ("max_range_m", m.max_range_m, 1e-3, 1e4),
            ("direct_wave_time_s", m.direct_wave_time_s, 1e-6, 1e9),
            ("likelihood_exponent", f.likelihood_exponent, 1e-6, 1e3),
            ("sigma_v_mps", f.sigma_v_mps, 0.0, 100.0),
            ("sigma_omega_radps", f.sigma_omega_radps, 0.0, 100.0),
            ("min_range_m", m.min_range_m, 0.0, 1e4),
            ("range_pool_m", m.range_pool_m, 0.0, 1e4),
            ("min_speed_mps", m.min_speed_mps, 0.0, 100.0),
            ("start_sigma_m", f.start_sigma_m, 0.0, 1e4),
            ("start_sigma_rad", f.start_sigma_rad, 0.0, 100.0),
        ] {
            if !(low..=high).contains(&value) {
                return refuse(field, &value, &format!("give {low} to {high}"));
            }
        }
        if !(0.0..=1.0).contains(&self.filter.resample_threshold) {
            return refuse(
                "resample_threshold",
                &self.filter.resample_threshold,
                "give a fraction from 0 to 1",
            );
        }
        if let Some(period) = &self.transmitted
            && period.len() != self.samples_per_period()
        {
            let remedy = "give one period of the waveform at sample_rate_hz";
            return refuse("transmitted", &period.len(), remedy);
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
        if m.min_range_m >= m.max_range_m {
            return refuse("min_range_m", &m.min_range_m, "give less than max_range_m");
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
            let remedy = format!(
                "give at most {longest_m:.2} m, half the way of sound in one period of {} chips",
                self.signal.code_length
            );
            return refuse("max_range_m", &self.measurement.max_range_m, &remedy);
        }
        Ok(())
    }
}

/// Bytes of a number of type `T` for each of `count`.
fn bytes<T>(count: f64) -> f64 {
    count * size_of::<T>() as f64
}

impl Parameters {
    /// Refuses a measurement of `blocks` blocks that does not fit into memory; the parameters must pass
    /// [`Parameters::check`].
    pub(crate) fn check_memory_of_echoes(&self, blocks: usize) -> Result<(), Error> {
        let directions = self.measurement.directions as f64 + 2.0;
        let block =
            bytes::<f32>(directions * self.delays() as f64 + self.samples_per_period() as f64);
        let what = format!("the echoes of {blocks} blocks");
        crate::memory::check("directions", &what, blocks as f64 * block)
    }

    /// Refuses a filter that does not fit into memory; the parameters must pass [`Parameters::check`].
    pub(crate) fn check_memory_of_filter(&self) -> Result<(), Error> {
        let pixels = (2.0 * self.window_cells() as f64 + 1.0).powi(2);
        let directions = self.measurement.directions as f64;
        // A map patch of a byte a pixel, two borders a direction, and poses and weights.
        let particle = pixels + bytes::<u32>(4.0 * directions) + bytes::<f64>(64.0);
        let particles = self.filter.particles;
        // Sorted pixels, and the strips of the images that all particles share.
        let shared = pixels * (bytes::<f64>(16.0) + 8.0 * directions);
        let what = format!("{particles} particles with windows of {pixels} pixels");
        crate::memory::check("particles", &what, particles as f64 * particle + shared)
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
