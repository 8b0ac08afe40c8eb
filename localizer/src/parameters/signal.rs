//! Parameters of the signal, all fixed by the recording.

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
