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

#[test]
fn a_channel_is_read_in_pieces_of_any_length() {
    let path = file(WavSpec { channels: 3, ..PCM }, |writer| {
        for frame in 0..5000_i16 {
            for channel in 0..3 {
                writer.write_sample(frame * 4 + channel).unwrap();
            }
        }
    });
    for piece in [1, 7, 1152, 4096, 10_000] {
        let mut stream = WavStream::open(&path).unwrap();
        assert_eq!((stream.channels(), stream.length()), (3, 5000));
        let mut samples = Vec::new();
        while stream.read(piece, 2, &mut samples).unwrap() > 0 {}
        let expected = (0..5000).map(|frame| (frame * 4 + 1) as f32 / 32_768.0);
        assert!(samples.iter().copied().eq(expected), "{piece}");
        assert!(stream.read(1, 4, &mut samples).is_err());
    }
}
