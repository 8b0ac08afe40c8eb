//! Parameters of the signal, all fixed by the recording.

use std::fmt::Display;

use crate::error::Error;

/// Slowest and fastest sound in air in m/s: beyond -100 and +150 degC there is a wrong unit rather than a robot.
pub const SPEEDS_OF_SOUND_MPS: [f64; 2] = [260.0, 420.0];
/// Farthest place of a loudspeaker or microphone from the robot's own point in metres.
pub const FARTHEST_SENSOR_M: f64 = 10.0;
/// Most samples of one period.
const MOST_SAMPLES: f64 = 16_777_216.0;

/// Waveform, sample rate, speed of sound and place of the sensors; all of them follow from `recording.json`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignalParameters {
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
    /// Place on the robot, `[forward, left]` in metres, from which ranges count: the middle between loudspeaker and
    /// microphone. With them b apart, an echo's path exceeds twice the range r from there by b^2/4r at most, and by
    /// nothing at a corner.
    pub sensor_offset_m: [f64; 2],
    /// The microphone's place less the loudspeaker's, `[forward, left]` in metres. Landmarks use it; images do not.
    pub sensor_baseline_m: [f64; 2],
}

impl Default for SignalParameters {
    fn default() -> Self {
        Self {
            sample_rate_hz: 40_000.0,
            code_length: 1023,
            chip_rate_hz: 10_000.0,
            carrier_hz: 10_000.0,
            speed_of_sound_mps: 340.0,
            sensor_offset_m: [0.0; 2],
            sensor_baseline_m: [0.0; 2],
        }
    }
}

impl SignalParameters {
    /// The order n of the M-sequence of `code_length` = 2^n - 1 chips; `None` unless n is 2 to 18.
    pub fn code_order(&self) -> Option<u32> {
        (2..=18).find(|&order| (1_usize << order) - 1 == self.code_length)
    }

    /// Checks every field once; errors name `origin`. The code's own rules do not hold for another waveform.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the first field that cannot be used.
    pub fn check(&self, origin: &str, other_waveform: bool) -> Result<(), Error> {
        self.check_numbers(origin, other_waveform)?;
        let samples = self.code_length as f64 / self.chip_rate_hz * self.sample_rate_hz;
        if (samples - samples.round()).abs() > 1e-6 {
            return Err(Error::invalid(
                origin,
                "sample_rate_hz",
                format!("{} cannot be used", self.sample_rate_hz),
                "choose it so that a whole number of samples makes one period of the code",
            ));
        }
        Ok(())
    }

    /// As [`Self::check`], of a sound that is still to be resampled to whole samples of a period.
    pub(crate) fn check_numbers(&self, origin: &str, other_waveform: bool) -> Result<(), Error> {
        let refuse = |field: &str, value: &dyn Display, remedy: &str| {
            let problem = format!("{value} cannot be used");
            Err(Error::invalid(origin, field, problem, remedy))
        };
        // Of another waveform it is the number of periods in a second.
        let slowest_hz = if other_waveform { 1e-3 } else { 1.0 };
        let [c_low, c_high] = SPEEDS_OF_SOUND_MPS;
        for (field, value, low, high, unit) in [
            ("sample_rate_hz", self.sample_rate_hz, 1.0, 1e8, "Hz"),
            ("chip_rate_hz", self.chip_rate_hz, slowest_hz, 1e8, "Hz"),
            ("carrier_hz", self.carrier_hz, 1.0, 1e8, "Hz"),
            (
                "speed_of_sound_mps",
                self.speed_of_sound_mps,
                c_low,
                c_high,
                "m/s, as in air",
            ),
        ] {
            if !(low..=high).contains(&value) {
                return refuse(field, &value, &format!("give {low} to {high} {unit}"));
            }
        }
        for (name, place_m, farthest_m) in [
            ("sensor_offset_m", self.sensor_offset_m, FARTHEST_SENSOR_M),
            (
                "sensor_baseline_m",
                self.sensor_baseline_m,
                2.0 * FARTHEST_SENSOR_M,
            ),
        ] {
            for (axis, value) in place_m.into_iter().enumerate() {
                // Written so that NaN is refused.
                if !(-farthest_m..=farthest_m).contains(&value) {
                    let field = format!("{name}[{axis}]");
                    let remedy = format!("give -{farthest_m} to {farthest_m} m");
                    return refuse(&field, &value, &remedy);
                }
            }
        }
        if self.code_length == 0 || (self.code_order().is_none() && !other_waveform) {
            return refuse(
                "code_length",
                &self.code_length,
                "give 2^n - 1 with n from 2 to 18",
            );
        }
        let samples = self.code_length as f64 / self.chip_rate_hz * self.sample_rate_hz;
        if samples > MOST_SAMPLES {
            let remedy = format!("keep one period of the code within {MOST_SAMPLES} samples");
            return refuse("chip_rate_hz", &self.chip_rate_hz, &remedy);
        }
        if other_waveform {
            return Ok(());
        }
        if self.carrier_hz + 0.5 * self.chip_rate_hz > 0.5 * self.sample_rate_hz {
            return refuse(
                "carrier_hz",
                &self.carrier_hz,
                "keep carrier and half the chip rate below half the sample rate",
            );
        }
        if self.carrier_hz * self.code_length as f64 / self.chip_rate_hz < 1.0 {
            return refuse(
                "carrier_hz",
                &self.carrier_hz,
                "give a carrier of at least one oscillation in a period of the code",
            );
        }
        Ok(())
    }

    /// Samples L_s = L T_c f_s of one period.
    pub fn samples_per_period(&self) -> usize {
        (self.code_length as f64 / self.chip_rate_hz * self.sample_rate_hz).round() as usize
    }

    /// Duration L T_c of one period, the step time, in seconds.
    pub fn period_s(&self) -> f64 {
        self.samples_per_period() as f64 / self.sample_rate_hz
    }

    /// Delay in samples of a reflector at this range, eqs. (5) and (15).
    pub fn delay_of_range(&self, range_m: f64) -> usize {
        (2.0 * self.sample_rate_hz / self.speed_of_sound_mps * range_m).round() as usize
    }

    /// Range in metres of an echo with this delay in samples.
    pub fn range_of_delay_m(&self, delay: f64) -> f64 {
        0.5 * self.speed_of_sound_mps * delay / self.sample_rate_hz
    }
}
