//! A sound card between the microphone and the file: its own rate and clock, a late start, channels, whole numbers.

use std::path::Path;

use anyhow::{Result, bail};
use localizer::Recording;
use localizer::align::Resampler;
use localizer::io::wav;
use serde::{Deserialize, Serialize};

/// A sound card.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoundCard {
    /// Rate of the file, whole hertz.
    pub sample_rate_hz: u32,
    /// Bits of a sample: 16 or 24.
    pub bits: u16,
    /// Channels of the file; all but the microphone's hold its noise alone.
    pub channels: u16,
    /// The microphone's channel, the first is 1.
    pub channel: u16,
    /// Time of the drive's start, and of the first period, since the first sample in seconds.
    pub late_s: f64,
    /// Excess of the card's rate over the loudspeaker's, parts per million.
    pub drift_ppm: f64,
}

impl SoundCard {
    /// Refuses values that cannot be used.
    ///
    /// # Errors
    /// With the field.
    pub fn check(&self) -> Result<()> {
        if !(8000..=768_000).contains(&self.sample_rate_hz) {
            bail!(
                "sound_card.sample_rate_hz: {}; give 8000 to 768000",
                self.sample_rate_hz
            );
        }
        if ![16, 24].contains(&self.bits) {
            bail!("sound_card.bits: {}; give 16 or 24", self.bits);
        }
        if !(1..=8).contains(&self.channels) || !(1..=self.channels).contains(&self.channel) {
            bail!(
                "sound_card.channel: {} of {}; give 1 to 8 channels and one of them",
                self.channel,
                self.channels
            );
        }
        if !(0.0..=60.0).contains(&self.late_s) {
            bail!("sound_card.late_s: {}; give 0 to 60 s", self.late_s);
        }
        if !(-300.0..=300.0).contains(&self.drift_ppm) {
            bail!("sound_card.drift_ppm: {}; give -300 to 300", self.drift_ppm);
        }
        Ok(())
    }

    /// What the card records of a signal at `rate_hz`; silence before it.
    pub fn recorded(&self, signal: &[f32], rate_hz: f64) -> Vec<f32> {
        let own_hz = f64::from(self.sample_rate_hz) * (1.0 + 1e-6 * self.drift_ppm);
        let length_s = signal.len() as f64 / rate_hz + self.late_s;
        let mut samples = vec![0.0; (length_s * own_hz) as usize];
        let step = rate_hz / own_hz;
        Resampler::new(step).fill(signal, -self.late_s * rate_hz, step, &mut samples);
        samples
    }

    /// Writes the recording as a laboratory gets it: the logs on their clocks, and nothing about any clock.
    ///
    /// `channels` are the samples of the file.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, recording: &Recording, channels: &[Vec<f32>], folder: &Path) -> Result<()> {
        recording.write(folder)?;
        wav::write_integers(
            &folder.join("signal.wav"),
            channels,
            self.sample_rate_hz,
            self.bits,
        )?;
        let mut meta = recording.meta.clone();
        meta.sample_rate_hz = f64::from(self.sample_rate_hz);
        (meta.late_s, meta.drift_ppm) = (None, None);
        (meta.odometry_clock_s, meta.truth_clock_s) = (None, None);
        let text = serde_json::to_string_pretty(&meta)? + "\n";
        std::fs::write(folder.join("recording.json"), text)?;
        Ok(())
    }
}
