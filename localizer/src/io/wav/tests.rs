use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use hound::{SampleFormat, WavSpec, WavWriter};

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
