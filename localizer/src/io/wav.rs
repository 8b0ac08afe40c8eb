//! Mono WAV files: 32 and 64-bit float, or integers of 8 to 32 bits scaled to full scale 1, as recorders write them.
//! Integers of fewer valid bits than they take in the file are at its upper end, as WAVE_FORMAT_EXTENSIBLE says.

use std::fs::File;
use std::io::{BufWriter, Cursor};
use std::path::Path;

use hound::{SampleFormat, WavSpec, WavWriter};
use symphonia::core::codecs::audio::AudioDecoderOptions;
use symphonia::core::errors::Error as SymphoniaError;
use symphonia::core::formats::{FormatReader, TrackType};
use symphonia::core::io::MediaSourceStream;
use symphonia::default::{formats::WavReader, get_codecs};

use super::files;
use crate::error::Error;

/// Reads a mono WAV file of the given rate.
///
/// # Errors
/// [`Error::Io`] when the file cannot be read, otherwise those of [`parse`].
pub fn read(path: &Path, sample_rate_hz: f64) -> Result<Vec<f32>, Error> {
    let bytes = std::fs::read(path).map_err(|source| Error::io(path, source))?;
    parse(bytes, sample_rate_hz, &path.display().to_string())
}

/// Reads the bytes of a mono WAV file of the given rate; `origin` names it in errors.
///
/// # Errors
/// [`Error::Invalid`] when they are no WAV file, end before its lengths say, hold several channels, another rate, no
/// sample, or samples that are not finite.
pub fn parse(bytes: Vec<u8>, sample_rate_hz: f64, origin: &str) -> Result<Vec<f32>, Error> {
    let refuse =
        |field: &str, problem: String, remedy: &str| Error::invalid(origin, field, problem, remedy);
    let damaged = |error: SymphoniaError| {
        refuse(
            "WAV format",
            error.to_string(),
            "write a whole mono file of 32-bit float or 16-bit PCM, not through a pipe",
        )
    };
    let most = bytes.len();
    let source = MediaSourceStream::new(Box::new(Cursor::new(bytes)), Default::default());
    let mut file = WavReader::try_new(source, Default::default()).map_err(damaged)?;
    let promised = file
        .default_track(TrackType::Audio)
        .and_then(|track| track.num_frames);
    let codec = file
        .default_track(TrackType::Audio)
        .and_then(|track| track.codec_params.as_ref()?.audio().cloned())
        .ok_or_else(|| refuse("WAV format", "holds no sound".into(), "export it again"))?;
    let channels = codec
        .channels
        .as_ref()
        .map_or(0, |channels| channels.count());
    if channels != 1 {
        let problem = format!("there are {channels}");
        return Err(refuse("channels", problem, "export one channel"));
    }
    let rate_hz = f64::from(codec.sample_rate.unwrap_or_default());
    if (rate_hz - sample_rate_hz).abs() > 1e-9 {
        return Err(refuse(
            "sample rate",
            format!("{rate_hz} Hz, but recording.json says {sample_rate_hz} Hz"),
            "correct recording.json or resample the file",
        ));
    }
    let mut decoder = get_codecs()
        .make_audio_decoder(&codec, &AudioDecoderOptions::default())
        .map_err(damaged)?;
    let mut samples = Vec::new();
    let mut decoded: Vec<f64> = Vec::new();
    while let Some(packet) = file.next_packet().map_err(damaged)? {
        let sound = decoder.decode(&packet).map_err(damaged)?;
        let count = sound.samples_interleaved();
        if samples.len() + count > most {
            return Err(refuse(
                "WAV format",
                "its lengths do not fit its bytes".into(),
                "export it again",
            ));
        }
        decoded.resize(count, 0.0);
        sound.copy_to_slice_interleaved(&mut decoded);
        samples.extend(decoded.iter().map(|&sample| sample as f32));
    }
    if promised.is_some_and(|frames| frames != samples.len() as u64) {
        return Err(refuse(
            "samples",
            format!("there are {}, its lengths say more", samples.len()),
            "export it again",
        ));
    }
    if samples.is_empty() {
        return Err(refuse("samples", "there are none".into(), "record again"));
    }
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

    /// A file of a `fmt ` chunk, other chunks, and data, as recorders lay it out.
    fn bytes(format: &[u8], others: &[(&[u8; 4], &[u8])], data: &[u8]) -> Vec<u8> {
        let mut body = b"WAVE".to_vec();
        let mut chunk = |id: &[u8; 4], content: &[u8]| {
            body.extend(id);
            body.extend((content.len() as u32).to_le_bytes());
            body.extend(content);
            // Chunks of odd size are padded.
            body.resize(body.len().next_multiple_of(2), 0);
        };
        chunk(b"fmt ", format);
        for (id, content) in others {
            chunk(id, content);
        }
        chunk(b"data", data);
        let mut file = b"RIFF".to_vec();
        file.extend((body.len() as u32).to_le_bytes());
        file.extend(body);
        file
    }

    /// A `fmt ` chunk of one channel at 40 kHz; with `valid` bits as WAVE_FORMAT_EXTENSIBLE.
    fn format(tag: u16, bits: u16, valid: Option<u16>) -> Vec<u8> {
        let first = if valid.is_some() { 0xfffe } else { tag };
        let width = u32::from(bits / 8);
        let mut format: Vec<u8> = [first, 1].map(u16::to_le_bytes).concat();
        format.extend([40_000, 40_000 * width].map(u32::to_le_bytes).concat());
        format.extend([bits / 8, bits].map(u16::to_le_bytes).concat());
        if let Some(valid) = valid {
            format.extend([22, valid, 4, 0, tag].map(u16::to_le_bytes).concat());
            format.extend(b"\x00\x00\x00\x00\x10\x00\x80\x00\x00\xaa\x00\x38\x9b\x71");
        }
        format
    }

    #[test]
    fn every_layout_of_a_sample_gives_the_same_sound() {
        let sound = [0.0_f32, 0.5, -0.25, -1.0, 0.75];
        // Integers left-aligned in the width of the file.
        let integers = |width: usize| -> Vec<u8> {
            let full = |sample: f32| (f64::from(sample) * 2_f64.powi(31)) as i32;
            let bytes = sound.map(|sample| full(sample).to_le_bytes()[4 - width..].to_vec());
            bytes.concat()
        };
        let single = sound.map(f32::to_le_bytes).concat();
        let double = sound.map(|sample| f64::from(sample).to_le_bytes()).concat();
        let unsigned: Vec<u8> = integers(1).iter().map(|byte| byte ^ 0x80).collect();
        for (tag, bits, valid, data) in [
            (1, 8, None, unsigned),
            (1, 16, None, integers(2)),
            (1, 24, None, integers(3)),
            (1, 32, None, integers(4)),
            (1, 16, Some(16), integers(2)),
            (1, 16, Some(12), integers(2)),
            (1, 24, Some(20), integers(3)),
            (1, 32, Some(24), integers(4)),
            (3, 32, None, single.clone()),
            (3, 32, Some(32), single),
            (3, 64, None, double.clone()),
            (3, 64, Some(64), double),
        ] {
            for others in [
                &[][..],
                &[(b"note", b"odd" as &[u8])],
                &[
                    (b"bext", &[7; 603]),
                    (b"LIST", b"INFOISFT\x05\0\0\0Lavf\0\0"),
                ],
            ] {
                let file = bytes(&format(tag, bits, valid), others, &data);
                let read = parse(file, 40_000.0, "a.wav").unwrap();
                assert_eq!(read, sound, "{tag} {bits} {valid:?} {others:?}");
            }
        }
    }

    #[test]
    fn loud_floats_keep_their_pascals() {
        let pascals = [20.1_f32, -3e5, 1e-30, f32::MIN_POSITIVE];
        let file = bytes(
            &format(3, 32, None),
            &[],
            &pascals.map(f32::to_le_bytes).concat(),
        );
        assert_eq!(parse(file, 40_000.0, "a.wav").unwrap(), pascals);
    }

    #[test]
    fn files_that_are_cut_short_or_of_another_kind_are_refused() {
        let whole = bytes(&format(1, 16, None), &[], &[1; 64]);
        for length in 0..whole.len() {
            let cut = parse(whole[..length].to_vec(), 40_000.0, "a.wav");
            assert!(cut.is_err(), "{length}");
        }
        let mut endless = whole.clone();
        let data = whole.len() - 64;
        endless[data - 4..data].fill(0xff);
        let mulaw = bytes(&format(7, 8, None), &[], &[1; 64]);
        let none = bytes(&format(1, 16, None), &[], &[]);
        for (file, word) in [
            (endless, "pipe"),
            (mulaw, "WAV format"),
            (none, "there are none"),
        ] {
            let message = parse(file, 40_000.0, "a.wav").unwrap_err().to_string();
            assert!(
                message.contains("a.wav") && message.contains(word),
                "{message}"
            );
        }
    }

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
