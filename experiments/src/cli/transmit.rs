//! `echolot transmit`.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use localizer::Parameters;
use localizer::align::Resampler;
use localizer::io::description::TransmitDescription;
use localizer::io::wav;
use localizer::parameters::SignalParameters;
use localizer::signal::waveform;

use super::arguments::ForceArgument;
use super::output::print_json;
use crate::data::manifest;
use crate::data::place::Place;

/// Samples of a file at most: 24 bits of them are 1.5 GB.
const MOST_SAMPLES: f64 = 5e8;

/// The code is computed at so many times its highest frequency, where its corners' overtones are weak.
const FINE: f64 = 8.0;

/// Arguments of `transmit`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot transmit -o tx.wav --seconds 600 --rate 48000\n  \
    echolot transmit -o tx.wav --code 511 --carrier 18000 --chips 4000\n\n\
    Beside the WAV its description is written (tx.json). Copy it as transmitted.json into the folder of a recording, \
    and map, localize and track know the code. Loop the file without a pause, or make it as long as the \
    drive: it holds \
    whole periods of the code, and where a period is no whole number of samples, as many as make one."
)]
pub(crate) struct Arguments {
    /// The WAV to play.
    #[arg(short, long, value_name = "TX.wav")]
    output: PathBuf,
    /// Duration, seconds; the next whole number of periods is taken.
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    seconds: f64,
    /// Sample rate of the file, Hz.
    #[arg(long, value_name = "F", default_value_t = 48_000)]
    rate: u32,
    /// Largest sample, decibels of full scale.
    #[arg(long, value_name = "DB", default_value_t = -6.0, allow_hyphen_values = true)]
    level: f64,
    /// Chips of the M-sequence: 2^n - 1.
    #[arg(long, value_name = "N", default_value_t = 1023)]
    code: usize,
    /// Carrier frequency, Hz.
    #[arg(long, value_name = "F", default_value_t = 10_000.0)]
    carrier: f64,
    /// Chip rate, Hz.
    #[arg(long, value_name = "F", default_value_t = 10_000.0)]
    chips: f64,
    /// Bits of a sample: 16 or 24.
    #[arg(long, value_name = "N", default_value_t = 24)]
    bits: u16,
    #[command(flatten)]
    force: ForceArgument,
}

impl Arguments {
    /// Refuses numbers that cannot be used.
    fn check(&self) -> Result<()> {
        let rate_hz = f64::from(self.rate);
        for (option, value) in [("--carrier", self.carrier), ("--chips", self.chips)] {
            if !(value.is_finite() && value > 0.0) {
                bail!("{option}: {value} cannot be used; give a positive number of hertz");
            }
        }
        if self.carrier < self.chips {
            bail!(
                "--carrier: {} Hz is below the chip rate, and the code would fold at 0 Hz; raise it",
                self.carrier
            );
        }
        if !(8000..=768_000).contains(&self.rate) {
            bail!("--rate: {} Hz; give 8000 to 768000 Hz", self.rate);
        }
        if (SignalParameters {
            code_length: self.code,
            ..SignalParameters::default()
        })
        .code_order()
        .is_none()
        {
            bail!("--code: {}; give 2^n - 1 with n from 2 to 18", self.code);
        }
        if self.carrier + 0.5 * self.chips > 0.475 * rate_hz {
            bail!(
                "--carrier: {} Hz and half the chip rate are above 0.475 of the sample rate; lower them, or give a \
                 higher --rate",
                self.carrier
            );
        }
        if !(self.level <= 0.0 && self.level >= -120.0) {
            bail!("--level: {} dB; give -120 to 0", self.level);
        }
        if ![16, 24].contains(&self.bits) {
            bail!("--bits: {}; give 16 or 24", self.bits);
        }
        if !(self.seconds > 0.0 && self.seconds * rate_hz <= MOST_SAMPLES) {
            let most = MOST_SAMPLES / rate_hz;
            bail!(
                "--seconds: {}; give more than 0 and at most {most:.0}",
                self.seconds
            );
        }
        if self.output.extension().is_none_or(|end| end != "wav") {
            bail!(
                "{}: is no name of a WAV; give one that ends in .wav",
                self.output.display()
            );
        }
        Ok(())
    }

    /// Checks the places of the WAV and of its description. A WAV has no mark: it is known by its description, which
    /// gives its digest.
    fn check_output(&self) -> Result<()> {
        let beside = self.output.with_extension("json");
        let known = TransmitDescription::read(&beside).ok();
        let digest = known.as_ref().and_then(|known| known.digest.clone());
        Place::of(&self.output, self.force.force)
            .file(|bytes| digest.as_deref() == Some(&manifest::digest(bytes)))?;
        Place::of(&beside, self.force.force).file(|_| known.is_some())
    }

    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        self.check()?;
        self.check_output()?;
        let period_s = self.code as f64 / self.chips;
        let rate_hz = f64::from(self.rate);
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
        if together.is_none() {
            eprintln!(
                "warning: no number of periods up to a thousand is a whole number of samples: the file has a \
                seam where \
                 it is looped; make it as long as the drive, or give another --rate"
            );
        }
        let distinct = together.map_or(count, samples_of);
        let samples = self.samples(distinct, period_s);
        let samples: Vec<f32> = samples.iter().copied().cycle().take(count).collect();
        let peak = samples
            .iter()
            .fold(f32::MIN_POSITIVE, |peak, sample| peak.max(sample.abs()));
        let scale = 10_f64.powf(0.05 * self.level) as f32 / peak;
        wav::write_scaled(&self.output, &[samples], self.rate, self.bits, scale)?;
        let written =
            std::fs::read(&self.output).with_context(|| self.output.display().to_string())?;
        let description = TransmitDescription {
            code_length: self.code,
            chip_rate_hz: self.chips,
            carrier_hz: self.carrier,
            sample_rate_hz: rate_hz,
            periods,
            period_s,
            level_db: self.level,
            digest: Some(manifest::digest(&written)),
        };
        let beside = self.output.with_extension("json");
        description.write(&beside)?;
        if json {
            return print_json(&description);
        }
        eprintln!(
            "wrote {} and {} ({periods} periods of {:.4} ms, {:.1} s)",
            self.output.display(),
            beside.display(),
            1e3 * period_s,
            count as f64 / rate_hz
        );
        Ok(())
    }

    /// The code's samples, whose corners are smoothed to what the rate holds.
    fn samples(&self, count: usize, period_s: f64) -> Vec<f32> {
        let rate_hz = f64::from(self.rate);
        let fine = (FINE * period_s * (self.carrier + self.chips).max(0.5 * rate_hz)).ceil();
        let signal = SignalParameters {
            sample_rate_hz: fine / period_s,
            code_length: self.code,
            chip_rate_hz: self.chips,
            carrier_hz: self.carrier,
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

/// The least number of periods that is a whole number of samples, `samples` in one; none up to a thousand.
fn whole(samples: f64) -> Option<usize> {
    (1..=1000).find(|&count| {
        let total = count as f64 * samples;
        (total - total.round()).abs() < 1e-6
    })
}
