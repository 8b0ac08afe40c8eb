//! Mono WAV files: 32-bit float, or 16, 24 and 32-bit integers scaled to full scale 1.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use hound::{SampleFormat, WavReader, WavSpec, WavWriter};

use super::files;
use crate::error::Error;

/// Reads a mono WAV file of the given rate.
///
/// # Errors
/// [`Error::Io`] when the file cannot be opened; [`Error::Invalid`] when it is no WAV file, has several channels,
/// another rate, or samples that are not finite.
pub fn read(path: &Path, sample_rate_hz: f64) -> Result<Vec<f32>, Error> {
    let refuse = |field: &str, problem: String, remedy: &str| {
        Error::invalid(path.display(), field, problem, remedy)
    };
    let mut reader = WavReader::open(path).map_err(|error| of_hound(path, error))?;
    let spec = reader.spec();
    if spec.channels != 1 {
        return Err(refuse(
            "channels",
            format!("there are {}", spec.channels),
            "export one channel",
        ));
    }
    if (f64::from(spec.sample_rate) - sample_rate_hz).abs() > 1e-9 {
        let problem = format!(
            "{} Hz, but recording.json says {sample_rate_hz} Hz",
            spec.sample_rate
        );
        return Err(refuse(
            "sample rate",
            problem,
            "correct recording.json or resample the file",
        ));
    }
    let samples: Result<Vec<f32>, hound::Error> = match spec.sample_format {
        SampleFormat::Float => reader.samples::<f32>().collect(),
        SampleFormat::Int => {
            let scale = 0.5_f64.powi(i32::from(spec.bits_per_sample) - 1);
            reader
                .samples::<i32>()
                .map(|sample| sample.map(|value| (f64::from(value) * scale) as f32))
                .collect()
        }
    };
    let samples = samples.map_err(|error| of_hound(path, error))?;
    if let Some(place) = samples.iter().position(|sample| !sample.is_finite()) {
        return Err(refuse(
            "samples",
            format!("sample {place} is not a finite number"),
            "repair or cut the file",
        ));
    }
    Ok(samples)
}

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

fn of_hound(path: &Path, error: hound::Error) -> Error {
    match error {
        hound::Error::IoError(source) => Error::io(path, source),
        other => Error::invalid(
            path.display(),
            "WAV format",
            other,
            "write mono 32-bit float or 16-bit PCM",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_bits_keep_the_shape() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pcm.wav");
        let samples: Vec<f32> = (0..1000).map(|k| 20.0 * (k as f32 * 0.1).sin()).collect();
        write_pcm16(&path, &samples, 50_000.0).unwrap();
        let read = read(&path, 50_000.0).unwrap();
        let peak = samples.iter().fold(0.0_f32, |peak, x| peak.max(x.abs()));
        for (read, sample) in read.iter().zip(&samples) {
            assert!((read - 0.9 * sample / peak).abs() < 2e-5, "{read} {sample}");
        }
    }

    fn file(spec: WavSpec, fill: impl Fn(&mut WavWriter<BufWriter<File>>)) -> tempfile::TempPath {
        let path = tempfile::NamedTempFile::new().unwrap().into_temp_path();
        let mut writer = WavWriter::create(&path, spec).unwrap();
        fill(&mut writer);
        writer.finalize().unwrap();
        path
    }

    const PCM: WavSpec = WavSpec {
        channels: 1,
        sample_rate: 40_000,
        bits_per_sample: 16,
        sample_format: SampleFormat::Int,
    };

    #[test]
    fn sixteen_bits_are_scaled() {
        let path = file(PCM, |writer| {
            for value in [0_i16, 16_384, -32_768] {
                writer.write_sample(value).unwrap();
            }
        });
        assert_eq!(read(&path, 40_000.0).unwrap(), [0.0, 0.5, -1.0]);
        assert!(
            read(&path, 50_000.0)
                .unwrap_err()
                .to_string()
                .contains("recording.json says 50000 Hz")
        );
    }

    #[test]
    fn stereo_nan_and_nonsense_are_refused() {
        let path = file(WavSpec { channels: 2, ..PCM }, |writer| {
            writer.write_sample(1_i16).unwrap();
            writer.write_sample(1_i16).unwrap();
        });
        assert!(
            read(&path, 40_000.0)
                .unwrap_err()
                .to_string()
                .contains("channels")
        );
        let float = WavSpec {
            bits_per_sample: 32,
            sample_format: SampleFormat::Float,
            ..PCM
        };
        let path = file(float, |writer| writer.write_sample(f32::NAN).unwrap());
        assert!(
            read(&path, 40_000.0)
                .unwrap_err()
                .to_string()
                .contains("sample 0")
        );
        std::fs::write(&path, b"nothing of the kind").unwrap();
        assert!(
            read(&path, 40_000.0)
                .unwrap_err()
                .to_string()
                .contains("WAV format")
        );
        assert!(matches!(
            read(Path::new("/none.wav"), 4e4),
            Err(Error::Io { .. })
        ));
    }
}
