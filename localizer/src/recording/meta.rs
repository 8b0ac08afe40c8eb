//! The content of `recording.json`.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::parameters::{FARTHEST_SENSOR_M, Parameters, SignalParameters};
use crate::pose::Pose;

/// The content of `recording.json`: waveform, clocks and places of the sensors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordingMeta {
    /// Sampling frequency f_s of the signal in Hz; in a file it may be left out for that of the WAV.
    #[serde(default)]
    pub sample_rate_hz: f64,
    /// Chips L of the transmitted M-sequence; 1 with another waveform.
    #[serde(default)]
    pub code_length: usize,
    /// Chip rate 1/T_c in Hz; periods a second with another waveform.
    #[serde(default)]
    pub chip_rate_hz: f64,
    /// Carrier frequency f_c in Hz; the centre of its power with another waveform.
    #[serde(default)]
    pub carrier_hz: f64,
    /// Speed of sound in m/s.
    #[serde(default)]
    pub speed_of_sound_mps: f64,
    /// Time of the first sample of a period since the first sample of the signal in seconds; found when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub late_s: Option<f64>,
    /// Excess of the recorder's rate over the loudspeaker's in parts per million; found when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift_ppm: Option<f64>,
    /// Channel of `signal.wav`, the first is 1; the first with the code in it when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<usize>,
    /// Pose at time 0, if known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<Pose>,
    /// Place of the loudspeaker on the robot, `[forward, left]` in metres.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub loudspeaker_offset_m: [f64; 2],
    /// Place of the microphone on the robot, `[forward, left]` in metres.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub microphone_offset_m: [f64; 2],
    /// Reading of the clock of `odometry.csv` at the first sample of the signal in seconds; found when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub odometry_clock_s: Option<f64>,
    /// Reading of the clock of `truth.tum` at the first sample of the signal in seconds; found when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truth_clock_s: Option<f64>,
    /// Where the recording comes from, in any form.
    #[serde(default, skip_serializing_if = "serde_json::Value::is_null")]
    pub provenance: serde_json::Value,
    /// One period of another waveform than the code's at `sample_rate_hz`: `transmitted.wav`.
    #[serde(skip)]
    pub transmitted: Option<Arc<[f32]>>,
}

/// Whether a field has its default and need not be written.
fn is_zero<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl Parameters {
    /// The same parameters with the waveform, the speed of sound and the sensor's place of a recording.
    pub fn for_recording(&self, meta: &RecordingMeta) -> Self {
        Self {
            signal: meta.signal_parameters(),
            transmitted: meta.transmitted.clone(),
            ..self.clone()
        }
    }
}

/// Largest reading of a clock in seconds: some 300 years, so that seconds since 1970 fit and nanoseconds do not.
const LATEST_S: f64 = 1e10;
/// Longest time before the first period in seconds.
const LONGEST_S: f64 = 1e6;
/// Largest difference of two sound cards' clocks in parts per million.
const MOST_PPM: f64 = 1e5;
/// Farthest start from the world's origin in metres, per coordinate.
const FARTHEST_M: f64 = 1e6;

impl RecordingMeta {
    /// Checks every field once; errors name `origin`.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the first field that cannot be used.
    pub fn check(&self, origin: &str) -> Result<(), Error> {
        let other_waveform = self.transmitted.is_some();
        self.check_numbers(origin, other_waveform)?;
        self.signal_parameters().check(origin, other_waveform)
    }

    /// As [`Self::check`], of a sound that is still to be resampled to whole samples of a period.
    pub(crate) fn check_numbers(&self, origin: &str, other_waveform: bool) -> Result<(), Error> {
        let within = |field: &str, value: f64, most: f64, unit: &str| {
            // Written so that NaN is refused.
            if (-most..=most).contains(&value) {
                return Ok(());
            }
            let problem = format!("{value} cannot be used");
            let remedy = format!("give -{most} to {most} {unit}");
            Err(Error::invalid(origin, field, problem, remedy))
        };
        for (name, place_m) in [
            ("loudspeaker_offset_m", self.loudspeaker_offset_m),
            ("microphone_offset_m", self.microphone_offset_m),
        ] {
            for (axis, value) in place_m.into_iter().enumerate() {
                let unit = "m, on the robot";
                within(&format!("{name}[{axis}]"), value, FARTHEST_SENSOR_M, unit)?;
            }
        }
        for (field, value, most, unit) in [
            ("late_s", self.late_s, LONGEST_S, "s"),
            ("drift_ppm", self.drift_ppm, MOST_PPM, "ppm"),
            ("odometry_clock_s", self.odometry_clock_s, LATEST_S, "s"),
            ("truth_clock_s", self.truth_clock_s, LATEST_S, "s"),
        ] {
            within(field, value.unwrap_or(0.0), most, unit)?;
        }
        if let Some(start) = self.start {
            within("start.x_m", start.x_m, FARTHEST_M, "m")?;
            within("start.y_m", start.y_m, FARTHEST_M, "m")?;
            within("start.heading_rad", start.heading_rad, 1e3, "rad")?;
        }
        self.signal_parameters()
            .check_numbers(origin, other_waveform)
    }

    /// The parameters that the recording fixes.
    pub fn signal_parameters(&self) -> SignalParameters {
        SignalParameters {
            sample_rate_hz: self.sample_rate_hz,
            code_length: self.code_length,
            chip_rate_hz: self.chip_rate_hz,
            carrier_hz: self.carrier_hz,
            speed_of_sound_mps: self.speed_of_sound_mps,
            sensor_offset_m: self.sensor_offset_m(),
            sensor_baseline_m: [0, 1]
                .map(|axis| self.microphone_offset_m[axis] - self.loudspeaker_offset_m[axis]),
        }
    }

    /// The middle between loudspeaker and microphone on the robot.
    pub fn sensor_offset_m(&self) -> [f64; 2] {
        let (one, other) = (self.loudspeaker_offset_m, self.microphone_offset_m);
        [0.5 * (one[0] + other[0]), 0.5 * (one[1] + other[1])]
    }

    /// The waveform and the speed of sound of `parameters`, without start and provenance.
    pub fn from_parameters(parameters: &Parameters) -> Self {
        Self {
            sample_rate_hz: parameters.signal.sample_rate_hz,
            code_length: parameters.signal.code_length,
            chip_rate_hz: parameters.signal.chip_rate_hz,
            carrier_hz: parameters.signal.carrier_hz,
            speed_of_sound_mps: parameters.signal.speed_of_sound_mps,
            start: None,
            loudspeaker_offset_m: [0.0; 2],
            microphone_offset_m: [0.0; 2],
            late_s: Some(0.0),
            drift_ppm: Some(0.0),
            channel: None,
            odometry_clock_s: Some(0.0),
            truth_clock_s: Some(0.0),
            provenance: serde_json::Value::Null,
            transmitted: parameters.transmitted.clone(),
        }
    }
}
