//! The sound that the loudspeaker plays: whole periods of the code at the rate of a sound card.

use std::path::Path;

use anyhow::{Context, Result, bail};
use localizer::Parameters;
use localizer::align::Resampler;
use localizer::io::description::TransmitDescription;
use localizer::io::wav;
use localizer::parameters::SignalParameters;
use localizer::signal::waveform;

use crate::data::manifest;
use crate::data::place::Place;

/// Samples of a file at most: 24 bits of them are 1.5 GB.
const MOST_SAMPLES: f64 = 5e8;

/// The code is computed at so many times its highest frequency, where its corners' overtones are weak.
const FINE: f64 = 8.0;

/// What is to be played.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transmission {
    /// Duration in seconds; the next whole number of periods is taken.
    pub seconds: f64,
    /// Sample rate in Hz.
    pub rate_hz: u32,
    /// Largest sample in decibels of full scale.
    pub level_db: f64,
    /// Chips of the M-sequence.
    pub code_length: usize,
    /// Carrier frequency in Hz.
    pub carrier_hz: f64,
    /// Chip rate in Hz.
    pub chip_rate_hz: f64,
}

/// The sound of a [`Transmission`].
#[derive(Debug, Clone)]
pub struct TransmittedSound {
    /// Samples, to be multiplied by `scale`.
    pub samples: Vec<f32>,
    /// Brings the largest sample to the level.
    pub scale: f32,
    /// What it is.
    pub description: TransmitDescription,
    /// Whether it can be looped without a seam.
    pub seamless: bool,
}

impl Transmission {
    /// Refuses numbers that cannot be used; errors name the options of `echolot transmit`.
    ///
    /// # Errors
    /// With the first of them.
    pub fn check(&self) -> Result<()> {
        let rate_hz = f64::from(self.rate_hz);
        for (option, value) in [
            ("--carrier", self.carrier_hz),
            ("--chips", self.chip_rate_hz),
        ] {
            if !(value.is_finite() && value > 0.0) {
                bail!("{option}: {value} cannot be used; give a positive number of hertz");
            }
        }
        if self.carrier_hz < self.chip_rate_hz {
            bail!(
                "--carrier: {} Hz is below the chip rate, and the code would fold at 0 Hz; raise it",
                self.carrier_hz
            );
        }
        if !(8000..=768_000).contains(&self.rate_hz) {
            bail!("--rate: {} Hz; give 8000 to 768000 Hz", self.rate_hz);
        }
        if (SignalParameters {
            code_length: self.code_length,
            ..SignalParameters::default()
        })
        .code_order()
        .is_none()
        {
            bail!(
                "--code: {}; give 2^n - 1 with n from 2 to 18",
                self.code_length
            );
        }
        if self.carrier_hz + 0.5 * self.chip_rate_hz > 0.475 * rate_hz {
            bail!(
                "--carrier: {} Hz and half the chip rate are above 0.475 of the sample rate; lower them, or give a \
                 higher --rate",
                self.carrier_hz
            );
        }
        if !(self.level_db <= 0.0 && self.level_db >= -120.0) {
            bail!("--level: {} dB; give -120 to 0", self.level_db);
        }
        if !(self.seconds > 0.0 && self.seconds * rate_hz <= MOST_SAMPLES) {
            let most = MOST_SAMPLES / rate_hz;
            bail!(
                "--seconds: {}; give more than 0 and at most {most:.0}",
                self.seconds
            );
        }
        Ok(())
    }

    /// Its sound.
    ///
    /// # Errors
    /// As [`Self::check`], and when whole periods are too long.
    pub fn sound(&self) -> Result<TransmittedSound> {
        self.check()?;
        let period_s = self.code_length as f64 / self.chip_rate_hz;
        let rate_hz = f64::from(self.rate_hz);
        let least = (self.seconds / period_s - 1e-9).ceil().max(1.0) as usize;
        let together = whole(period_s * rate_hz);
        let periods = least.next_multiple_of(together.unwrap_or(1));
        let samples_of = |periods: usize| (periods as f64 * period_s * rate_hz).round() as usize;
        let count = samples_of(periods);
        if count as f64 > 2.0 * MOST_SAMPLES {
            bail!(
                "--seconds: whole periods would have {count} samples; give another --rate or --chips"
            );
        }
        let distinct = together.map_or(count, samples_of);
        let samples = self.samples(distinct, period_s);
        let samples: Vec<f32> = samples.iter().copied().cycle().take(count).collect();
        let peak = samples
            .iter()
            .fold(f32::MIN_POSITIVE, |peak, sample| peak.max(sample.abs()));
        Ok(TransmittedSound {
            scale: 10_f64.powf(0.05 * self.level_db) as f32 / peak,
            samples,
            description: TransmitDescription {
                code_length: self.code_length,
                chip_rate_hz: self.chip_rate_hz,
                carrier_hz: self.carrier_hz,
                sample_rate_hz: rate_hz,
                periods,
                period_s,
                level_db: self.level_db,
                digest: None,
            },
            seamless: together.is_some(),
        })
    }

    /// The code's samples, whose corners are smoothed to what the rate holds.
    fn samples(&self, count: usize, period_s: f64) -> Vec<f32> {
        let rate_hz = f64::from(self.rate_hz);
        let fine =
            (FINE * period_s * (self.carrier_hz + self.chip_rate_hz).max(0.5 * rate_hz)).ceil();
        let signal = SignalParameters {
            sample_rate_hz: fine / period_s,
            code_length: self.code_length,
            chip_rate_hz: self.chip_rate_hz,
            carrier_hz: self.carrier_hz,
            ..SignalParameters::default()
        };
        let parameters = Parameters {
            signal,
            ..Parameters::default()
        };
        let period: Vec<f32> = waveform::transmitted(&parameters)
            .iter()
            .map(|&sample| sample as f32)
            .collect();
        let step = fine / period_s / rate_hz;
        let resampler = Resampler::new(step);
        // One period between two others, so that it goes on at both ends.
        let reach = resampler.reach().min(period.len() * 64);
        let before = reach.div_ceil(period.len());
        let around: Vec<f32> = period
            .iter()
            .copied()
            .cycle()
            .take((2 * before + 1) * period.len())
            .collect();
        let mut samples = vec![0.0; count];
        let first = before * period.len();
        let mut one = [0.0];
        for (k, sample) in samples.iter_mut().enumerate() {
            let place = (k as f64 * step).rem_euclid(period.len() as f64);
            resampler.fill(&around, first as f64 + place, step, &mut one);
            *sample = one[0];
        }
        samples
    }
}

impl TransmittedSound {
    /// Writes it as a WAV with samples of so many bits, and its description beside it (`.json`), which comes back.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(self, path: &Path, bits: u16) -> Result<TransmitDescription> {
        let rate_hz = self.description.sample_rate_hz as u32;
        let channels = std::slice::from_ref(&self.samples);
        wav::write_scaled(path, channels, rate_hz, bits, self.scale)?;
        let written = std::fs::read(path).with_context(|| path.display().to_string())?;
        let description = TransmitDescription {
            digest: Some(manifest::digest(&written)),
            ..self.description
        };
        description.write(&path.with_extension("json"))?;
        Ok(description)
    }
}

/// Checks the places of a WAV with samples of so many bits and of its description. A WAV has no mark: it is known by
/// its description, which gives its digest.
///
/// # Errors
/// When the file cannot be written so, or what is there was not written by this program (unless forced).
pub fn check_place(path: &Path, bits: u16, force: bool) -> Result<()> {
    if ![16, 24].contains(&bits) {
        bail!("--bits: {bits}; give 16 or 24");
    }
    if path.extension().is_none_or(|end| end != "wav") {
        bail!(
            "{}: is no name of a WAV; give one that ends in .wav",
            path.display()
        );
    }
    let beside = path.with_extension("json");
    let known = TransmitDescription::read(&beside).ok();
    let digest = known.as_ref().and_then(|known| known.digest.clone());
    Place::of(path, force).file(|bytes| digest.as_deref() == Some(&manifest::digest(bytes)))?;
    Place::of(&beside, force).file(|_| known.is_some())
}

/// The least number of periods that is a whole number of samples, `samples` in one; none up to a thousand.
fn whole(samples: f64) -> Option<usize> {
    (1..=1000).find(|&count| {
        let total = count as f64 * samples;
        (total - total.round()).abs() < 1e-6
    })
}
