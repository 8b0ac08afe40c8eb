//! Every choice of the method in one flat structure; its default is the paper's Table I.

mod choices;

use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::signal::waveform;

pub use self::choices::{
    DirectWave, Integration, Method, MotionModel, Resampling, TimeReference, ToaImage,
};

/// Parameters of the method. `Default` is Table I of the paper, plus our choice wherever the paper leaves one open.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Sampling frequency f_s of the received signal in Hz.
    pub sample_rate_hz: f64,
    /// Chips L of the M-sequence: 2^n - 1.
    pub code_length: usize,
    /// Chip rate 1/T_c in Hz.
    pub chip_rate_hz: f64,
    /// Carrier frequency f_c in Hz.
    pub carrier_hz: f64,
    /// Speed of sound c_a in m/s.
    pub speed_of_sound_mps: f64,
    /// Periods M in one block.
    pub periods: usize,
    /// N_theta of eq. (3): there are N_theta + 1 directions, pi n / N_theta.
    pub directions: usize,
    /// Cell width of map and echo image, dx_m = dy_m, in metres.
    pub cell_m: f64,
    /// Half width N_W dx_m of the matched images in metres.
    pub window_half_width_m: f64,
    /// Particles N_s.
    pub particles: usize,
    /// Standard deviation of the speed in eq. (8) in m/s.
    pub sigma_v_mps: f64,
    /// Standard deviation of the turning rate in eq. (8) in rad/s.
    pub sigma_omega_radps: f64,
    /// Highest bin K of the quantized images, so that there are K + 1 of them; at most 255.
    pub bins: usize,
    /// How the pose is estimated.
    pub method: Method,
    /// The instant of a block to which its pose refers.
    pub time_reference: TimeReference,
    /// What is done about the direct wave.
    pub direct_wave: DirectWave,
    /// Time constant of the running mean in seconds.
    pub direct_wave_time_s: f64,
    /// Pixels nearer than this are zero, in metres.
    pub min_range_m: f64,
    /// Echoes are measured up to this range, in metres.
    pub max_range_m: f64,
    /// H at a delay is the largest envelope within this range to both sides, in metres. The envelope's peak is far narrower
    /// than a cell, so that eq. (5), which reads one sample per pixel, misses most of it; 0 is eq. (5) as printed.
    pub range_pool_m: f64,
    /// A block with a smaller mean speed has no bearings: it moves the particles and weighs nothing. In m/s.
    pub min_speed_mps: f64,
    /// What is assumed about the speed within a block.
    pub motion_model: MotionModel,
    /// How the motion model integrates one step.
    pub integration: Integration,
    /// Weights are the mutual information to this power; 1 is eq. (17).
    pub likelihood_exponent: f64,
    /// What stands for all directions in the range-only method.
    pub toa_image: ToaImage,
    /// How the next particles are drawn by their weights.
    pub resampling: Resampling,
    /// Resample when the effective sample size is at most this fraction of N_s; 1 is always.
    pub resample_threshold: f64,
    /// Standard deviation of the first particles' coordinates in metres; 0 is a known start.
    pub start_sigma_m: f64,
    /// Standard deviation of the first particles' headings in radians; 0 is a known start.
    pub start_sigma_rad: f64,
    /// Place on the robot, `[forward, left]` in metres, from which ranges count: the middle between loudspeaker and microphone.
    /// With them b apart, an echo's path exceeds twice the range from there by b^2/4r at most, and by nothing at a corner.
    pub sensor_offset_m: [f64; 2],
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            sample_rate_hz: 40_000.0,
            code_length: 1023,
            chip_rate_hz: 10_000.0,
            carrier_hz: 10_000.0,
            speed_of_sound_mps: 340.0,
            periods: 6,
            directions: 29,
            cell_m: 0.1,
            window_half_width_m: 4.0,
            particles: 100,
            sigma_v_mps: 0.0004,
            sigma_omega_radps: 0.09,
            bins: 127,
            method: Method::default(),
            time_reference: TimeReference::default(),
            direct_wave: DirectWave::default(),
            direct_wave_time_s: 10.0,
            min_range_m: 0.25,
            max_range_m: 8.5,
            range_pool_m: 0.0,
            min_speed_mps: 0.02,
            motion_model: MotionModel::default(),
            integration: Integration::default(),
            likelihood_exponent: 1.0,
            toa_image: ToaImage::default(),
            resampling: Resampling::default(),
            resample_threshold: 1.0,
            start_sigma_m: 0.0,
            start_sigma_rad: 0.0,
            sensor_offset_m: [0.0; 2],
        }
    }
}

impl Parameters {
    /// Samples L_s = L T_c f_s of one period.
    pub fn samples_per_period(&self) -> usize {
        (self.code_length as f64 / self.chip_rate_hz * self.sample_rate_hz).round() as usize
    }

    /// Duration L T_c of one period, the step time, in seconds.
    pub fn period_s(&self) -> f64 {
        self.samples_per_period() as f64 / self.sample_rate_hz
    }

    /// Delays kept of every echo image: 0 to the one of `max_range_m`.
    pub fn delays(&self) -> usize {
        self.delay_of_range(self.max_range_m) + 1
    }

    /// Delay in samples of a reflector at this range, eqs. (5) and (15).
    pub fn delay_of_range(&self, range_m: f64) -> usize {
        (2.0 * self.sample_rate_hz / self.speed_of_sound_mps * range_m).round() as usize
    }

    /// Range in metres of an echo with this delay in samples.
    pub fn range_of_delay_m(&self, delay: f64) -> f64 {
        0.5 * self.speed_of_sound_mps * delay / self.sample_rate_hz
    }

    /// Periods between the start of a block and the instant to which its pose refers.
    pub fn reference_periods(&self) -> f64 {
        match self.time_reference {
            TimeReference::Centre => 0.5 * self.periods as f64,
            TimeReference::Start => 0.0,
        }
    }

    /// Half width of the matched images in cells, N_W.
    pub fn window_cells(&self) -> usize {
        (self.window_half_width_m / self.cell_m).round() as usize
    }

    /// The same parameters with the waveform, the speed of sound and the sensor's place of a recording.
    pub fn for_recording(&self, meta: &crate::recording::RecordingMeta) -> Self {
        Self {
            sample_rate_hz: meta.sample_rate_hz,
            code_length: meta.code_length,
            chip_rate_hz: meta.chip_rate_hz,
            carrier_hz: meta.carrier_hz,
            speed_of_sound_mps: meta.speed_of_sound_mps,
            sensor_offset_m: meta.sensor_offset_m(),
            ..self.clone()
        }
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
            ("sample_rate_hz", self.sample_rate_hz),
            ("chip_rate_hz", self.chip_rate_hz),
            ("carrier_hz", self.carrier_hz),
            ("speed_of_sound_mps", self.speed_of_sound_mps),
            ("cell_m", self.cell_m),
            ("window_half_width_m", self.window_half_width_m),
            ("max_range_m", self.max_range_m),
            ("direct_wave_time_s", self.direct_wave_time_s),
            ("likelihood_exponent", self.likelihood_exponent),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return refuse(field, &value, "give a positive number");
            }
        }
        for (field, value) in [
            ("sigma_v_mps", self.sigma_v_mps),
            ("sigma_omega_radps", self.sigma_omega_radps),
            ("min_range_m", self.min_range_m),
            ("range_pool_m", self.range_pool_m),
            ("min_speed_mps", self.min_speed_mps),
            ("start_sigma_m", self.start_sigma_m),
            ("start_sigma_rad", self.start_sigma_rad),
            ("sensor_offset_m[0]", self.sensor_offset_m[0].abs()),
            ("sensor_offset_m[1]", self.sensor_offset_m[1].abs()),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return refuse(field, &value, "give zero or a positive number");
            }
        }
        if !(0.0..=1.0).contains(&self.resample_threshold) {
            return refuse(
                "resample_threshold",
                &self.resample_threshold,
                "give a fraction from 0 to 1",
            );
        }
        if waveform::order_of(self.code_length).is_none() {
            return refuse(
                "code_length",
                &self.code_length,
                "give 2^n - 1 with n from 2 to 18",
            );
        }
        let samples = self.code_length as f64 / self.chip_rate_hz * self.sample_rate_hz;
        if (samples - samples.round()).abs() > 1e-6 {
            return refuse(
                "sample_rate_hz",
                &self.sample_rate_hz,
                "choose it so that a whole number of samples makes one period of the code",
            );
        }
        if self.carrier_hz + 0.5 * self.chip_rate_hz > 0.5 * self.sample_rate_hz {
            return refuse(
                "carrier_hz",
                &self.carrier_hz,
                "keep carrier and half the chip rate below half the sample rate",
            );
        }
        if !(1..=64).contains(&self.periods) {
            return refuse("periods", &self.periods, "give 1 to 64");
        }
        if !(1..=1000).contains(&self.directions) {
            return refuse("directions", &self.directions, "give 1 to 1000");
        }
        if !(1..=255).contains(&self.bins) {
            return refuse("bins", &self.bins, "give 1 to 255");
        }
        if !(1..=10_000_000).contains(&self.particles) {
            return refuse("particles", &self.particles, "give 1 to 10 million");
        }
        if !(1..=2000).contains(&self.window_cells()) {
            return refuse(
                "window_half_width_m",
                &self.window_half_width_m,
                "give 1 to 2000 cells of cell_m",
            );
        }
        if self.range_pool_m > self.max_range_m {
            return refuse(
                "range_pool_m",
                &self.range_pool_m,
                "give at most max_range_m; half a cell is plenty",
            );
        }
        let longest_m = self.range_of_delay_m(self.samples_per_period() as f64 - 1.0);
        if self.max_range_m > longest_m {
            let remedy =
                format!("give at most {longest_m:.2} m, half the way of sound in one period");
            return refuse("max_range_m", &self.max_range_m, &remedy);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            cell_m: f64::NAN,
            ..Parameters::default()
        };
        assert!(bad.check().unwrap_err().to_string().contains("cell_m"));
        let bad = Parameters {
            code_length: 1000,
            ..Parameters::default()
        };
        assert!(bad.check().unwrap_err().to_string().contains("2^n - 1"));
    }

    #[test]
    fn fifty_kilohertz_gives_five_samples_a_chip() {
        let parameters = Parameters {
            sample_rate_hz: 50_000.0,
            ..Parameters::default()
        };
        assert!(parameters.check().is_ok());
        assert_eq!(parameters.samples_per_period(), 5115);
    }
}
