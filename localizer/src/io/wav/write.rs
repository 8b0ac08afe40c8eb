//! Writing under a temporary name that is then renamed.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use hound::{SampleFormat, WavSpec, WavWriter};

use super::{MOST_CHANNELS, of_hound};
use crate::error::Error;
use crate::io::files;

/// Writes a mono 32-bit float WAV file under a temporary name and renames it.
///
/// # Errors
/// [`Error`] when the rate is not a whole number of hertz or the file cannot be written.
pub fn write(path: &Path, samples: &[f32], sample_rate_hz: f64) -> Result<(), Error> {
    write_as(path, sample_rate_hz, SampleFormat::Float, |writer| {
        samples
            .iter()
            .try_for_each(|&sample| writer.write_sample(sample))
    })
}

/// Writes a mono 16-bit WAV file, as a 16-bit converter delivers it: the loudest sample at 0.9 of full scale.
///
/// # Errors
/// As [`write()`].
pub fn write_pcm16(path: &Path, samples: &[f32], sample_rate_hz: f64) -> Result<(), Error> {
    let peak = samples
        .iter()
        .fold(f32::MIN_POSITIVE, |peak, sample| peak.max(sample.abs()));
    let scale = 0.9 * (f32::from(i16::MAX) + 1.0) / peak;
    write_as(path, sample_rate_hz, SampleFormat::Int, |writer| {
        samples
            .iter()
            .try_for_each(|&sample| writer.write_sample((scale * sample).round() as i16))
    })
}

/// Writes a WAV file of 16 or 24 bits: the loudest sample of all channels at 0.9 of full scale.
///
/// # Errors
/// [`Error`] for channels that are not equally long or none, other bits, or a file that cannot be written.
pub fn write_integers(
    path: &Path,
    channels: &[Vec<f32>],
    sample_rate_hz: u32,
    bits: u16,
) -> Result<(), Error> {
    let samples = || channels.iter().flatten();
    let peak = samples().fold(f32::MIN_POSITIVE, |peak, sample| peak.max(sample.abs()));
    write_scaled(path, channels, sample_rate_hz, bits, 0.9 / peak)
}

/// As [`write_integers`], with `scale` times the samples between -1 and 1.
///
/// # Errors
/// As [`write_integers`].
pub fn write_scaled(
    path: &Path,
    channels: &[Vec<f32>],
    sample_rate_hz: u32,
    bits: u16,
    scale: f32,
) -> Result<(), Error> {
    let length = channels.first().map_or(0, Vec::len);
    if channels.is_empty()
        || channels.len() > usize::from(MOST_CHANNELS)
        || channels.iter().any(|channel| channel.len() != length)
        || ![16, 24].contains(&bits)
    {
        let problem = "cannot be written";
        let remedy = "give 1 to 64 equally long channels of 16 or 24 bits";
        return Err(Error::invalid(path.display(), "channels", problem, remedy));
    }
    let spec = WavSpec {
        channels: channels.len() as u16,
        sample_rate: sample_rate_hz,
        bits_per_sample: bits,
        sample_format: SampleFormat::Int,
    };
    let full = 0.5_f32.powi(1 - i32::from(bits));
    files::write_whole(path, |temporary| {
        let write_all = || -> Result<(), hound::Error> {
            let mut writer = WavWriter::create(temporary, spec)?;
            for frame in 0..length {
                for channel in channels {
                    let value = (scale * channel[frame] * full).round();
                    writer.write_sample(value.clamp(-full, full - 1.0) as i32)?;
                }
            }
            writer.finalize()
        };
        write_all().map_err(|error| of_hound(path, error))
    })
}

/// Writes a mono WAV file whose samples `fill` writes: 32-bit float or 16-bit integers.
fn write_as(
    path: &Path,
    sample_rate_hz: f64,
    sample_format: SampleFormat,
    fill: impl Fn(&mut WavWriter<BufWriter<File>>) -> Result<(), hound::Error>,
) -> Result<(), Error> {
    let sample_rate = sample_rate_hz.round() as u32;
    if (f64::from(sample_rate) - sample_rate_hz).abs() > 1e-9 || sample_rate == 0 {
        let problem = format!("{sample_rate_hz} Hz cannot be written");
        return Err(Error::invalid(
            path.display(),
            "sample rate",
            problem,
            "choose a whole number of hertz",
        ));
    }
    let spec = WavSpec {
        channels: 1,
        sample_rate,
        bits_per_sample: match sample_format {
            SampleFormat::Float => 32,
            SampleFormat::Int => 16,
        },
        sample_format,
    };
    files::write_whole(path, |temporary| {
        let write_all = || -> Result<(), hound::Error> {
            let mut writer = WavWriter::create(temporary, spec)?;
            fill(&mut writer)?;
            writer.finalize()
        };
        write_all().map_err(|error| of_hound(path, error))
    })
}
