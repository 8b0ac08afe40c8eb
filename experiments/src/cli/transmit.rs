//! `echolot transmit`.

use std::path::PathBuf;

use anyhow::Result;

use super::arguments::ForceArgument;
use super::output::print_json;
use crate::transmission::{Transmission, check_place};

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
    /// What is to be played.
    fn transmission(&self) -> Transmission {
        Transmission {
            seconds: self.seconds,
            rate_hz: self.rate,
            level_db: self.level,
            code_length: self.code,
            carrier_hz: self.carrier,
            chip_rate_hz: self.chips,
        }
    }

    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        self.transmission().check()?;
        check_place(&self.output, self.bits, self.force.force)?;
        let sound = self.transmission().sound()?;
        if !sound.seamless {
            eprintln!(
                "warning: no number of periods up to a thousand is a whole number of samples: the file has a \
                seam where it is looped; make it as long as the drive, or give another --rate"
            );
        }
        let length_s = sound.samples.len() as f64 / sound.description.sample_rate_hz;
        let description = sound.write(&self.output, self.bits)?;
        if json {
            return print_json(&description);
        }
        eprintln!(
            "wrote {} and {} ({} periods of {:.4} ms, {:.1} s)",
            self.output.display(),
            self.output.with_extension("json").display(),
            description.periods,
            1e3 * description.period_s,
            length_s
        );
        Ok(())
    }
}
