//! Samples of a stream: raw, or behind the header of a WAV stream.

use std::io::Read;

use anyhow::{Context, Result, bail};
use clap::ValueEnum;

/// Longest header of a WAV stream, in bytes.
const LONGEST_HEADER: u64 = 1 << 20;

/// Tag of the extensible format, and the end of the identifier behind whose first two bytes the format's own tag is.
const EXTENSIBLE: u16 = 0xfffe;
const IDENTIFIER: &[u8] = b"\x00\x00\x00\x00\x10\x00\x80\x00\x00\xaa\x00\x38\x9b\x71";

/// Format of the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// A WAV stream; its header tells format, rate and channels.
    Wav,
    /// 32-bit float, little endian.
    F32,
    /// 64-bit float, little endian.
    F64,
    /// 8-bit integers, unsigned.
    U8,
    /// 16-bit integers, little endian.
    S16,
    /// 24-bit integers, three bytes, little endian.
    S24,
    /// 32-bit integers, little endian.
    S32,
}

/// What a stream holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    /// Format of a sample.
    pub format: Format,
    /// Sample rate in Hz.
    pub rate_hz: f64,
    /// Number of channels.
    pub channels: usize,
    /// The channel that is used, the first is 1; the first with the code unless given.
    pub channel: Option<usize>,
}

impl Format {
    /// Bytes of a sample.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::S16 => 2,
            Self::S24 => 3,
            Self::F32 | Self::S32 | Self::Wav => 4,
            Self::F64 => 8,
        }
    }

    /// One sample, full scale 1. Integers of fewer valid bits than their width are at its upper end.
    pub fn sample(self, bytes: &[u8]) -> f32 {
        let integer =
            |bytes: [u8; 4]| (f64::from(i32::from_le_bytes(bytes)) / 2_147_483_648.0) as f32;
        match (self, bytes) {
            (Self::U8, &[a]) => integer([0, 0, 0, a ^ 0x80]),
            (Self::S16, &[a, b]) => integer([0, 0, a, b]),
            (Self::S24, &[a, b, c]) => integer([0, a, b, c]),
            (Self::S32, &[a, b, c, d]) => integer([a, b, c, d]),
            (Self::F64, bytes) => bytes
                .try_into()
                .map_or(0.0, |bytes| f64::from_le_bytes(bytes) as f32),
            (_, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            _ => 0.0,
        }
    }
}

/// Reads the header of a WAV stream up to its samples. Lengths are not believed: a pipe's writer does not know them.
///
/// # Errors
/// When it is no WAV stream, ends in its header, or holds samples of another kind than a WAV file may.
pub fn header(stream: &mut impl Read, channel: Option<usize>) -> Result<Layout> {
    let mut four = [0; 12];
    stream
        .read_exact(&mut four)
        .context("standard input: has no WAV header")?;
    if &four[..4] != b"RIFF" || &four[8..] != b"WAVE" {
        bail!("standard input: is no WAV stream; give --format f32, s16, s24 or s32 with --rate");
    }
    let (mut found, mut read) = (None, 0);
    loop {
        let mut chunk = [0; 8];
        stream
            .read_exact(&mut chunk)
            .context("standard input: ends in its WAV header")?;
        let length = u64::from(u32::from_le_bytes([chunk[4], chunk[5], chunk[6], chunk[7]]));
        if &chunk[..4] == b"data" {
            break;
        }
        read += length + 8;
        if read > LONGEST_HEADER {
            bail!("standard input: has no samples in the first {LONGEST_HEADER} bytes; repair it");
        }
        let mut content = vec![0; (length + length % 2) as usize];
        stream
            .read_exact(&mut content)
            .context("standard input: ends in its WAV header")?;
        if &chunk[..4] == b"fmt " {
            found = Some(described(&content)?);
        }
    }
    let Some((format, rate_hz, channels)) = found else {
        bail!("standard input: its WAV header has no format; repair it");
    };
    Layout {
        format,
        rate_hz,
        channels,
        channel,
    }
    .checked()
}

/// Format, rate in Hz and channels of a `fmt ` chunk.
fn described(content: &[u8]) -> Result<(Format, f64, usize)> {
    if content.len() < 16 {
        bail!("standard input: the format of its WAV header is cut off; repair it");
    }
    let two = |at: usize| u16::from_le_bytes([content[at], content[at + 1]]);
    let rate = u32::from_le_bytes([content[4], content[5], content[6], content[7]]);
    let (mut tag, channels, frame, bits) = (two(0), two(2), two(12), two(14));
    let mut valid = bits;
    if tag == EXTENSIBLE {
        if content.get(26..40) != Some(IDENTIFIER) {
            bail!(
                "standard input: the extensible format of its WAV header is of no known kind; give integers or floats"
            );
        }
        (tag, valid) = (two(24), two(18));
    }
    // Valid bits are at the upper end of a sample, so that its full width is what counts.
    let width = frame.checked_div(channels).unwrap_or(0);
    if channels.checked_mul(width) != Some(frame)
        || bits != 8 * width.min(8)
        || !(1..=bits).contains(&valid)
        || (tag == 3 && valid != bits)
    {
        bail!(
            "standard input: its WAV header contradicts itself: {channels} channels, {frame} bytes for all of them, \
             {bits} bits, {valid} of them valid; repair it"
        );
    }
    let format = match (tag, bits) {
        (1, 8) => Format::U8,
        (1, 16) => Format::S16,
        (1, 24) => Format::S24,
        (1, 32) => Format::S32,
        (3, 32) => Format::F32,
        (3, 64) => Format::F64,
        (tag, bits) => bail!(
            "standard input: WAV of format {tag} with {bits} bits; give integers of 8 to 32 bits or floats of 32 or 64"
        ),
    };
    Ok((format, f64::from(rate), usize::from(channels)))
}

impl Layout {
    /// Refuses what cannot be.
    ///
    /// # Errors
    /// With the option that is wrong.
    pub fn checked(self) -> Result<Self> {
        if !(1..=64).contains(&self.channels) {
            bail!("--channels: {}; give 1 to 64", self.channels);
        }
        if let Some(channel) = self.channel
            && !(1..=self.channels).contains(&channel)
        {
            bail!(
                "--channel: {channel} of {}; give one that is there",
                self.channels
            );
        }
        if !(1000.0..=1e6).contains(&self.rate_hz) {
            bail!("--rate: {} Hz; give 1000 to 1000000", self.rate_hz);
        }
        Ok(self)
    }

    /// The samples of whole frames, of all channels; bytes that are left over are not looked at.
    pub fn samples(&self, bytes: &[u8]) -> Vec<f32> {
        let whole = bytes.len() - bytes.len() % (self.format.bytes() * self.channels);
        let samples = bytes[..whole].chunks_exact(self.format.bytes());
        samples.map(|sample| self.format.sample(sample)).collect()
    }
}

#[cfg(test)]
mod tests {
    use localizer::io::wav;

    use super::*;

    #[test]
    fn samples_of_every_format_are_scaled() {
        assert_eq!(Format::U8.sample(&[0x40]), -0.5);
        assert_eq!(Format::S16.sample(&[0, 0x40]), 0.5);
        assert_eq!(Format::S24.sample(&[0, 0, 0x80]), -1.0);
        assert_eq!(Format::S32.sample(&[0, 0, 0, 0x20]), 0.25);
        assert_eq!(Format::F32.sample(&0.125_f32.to_le_bytes()), 0.125);
        assert_eq!(Format::F64.sample(&0.125_f64.to_le_bytes()), 0.125);
    }

    #[test]
    fn a_header_with_unknown_length_and_other_chunks_is_read() {
        let mut bytes =
            b"RIFF\xff\xff\xff\xffWAVELIST\x03\x00\x00\x00abc\x00fmt \x10\x00\x00\x00".to_vec();
        bytes.extend([1, 0, 2, 0]);
        bytes.extend(48_000_u32.to_le_bytes());
        bytes.extend(192_000_u32.to_le_bytes());
        bytes.extend([4, 0, 16, 0]);
        bytes.extend(b"data\xff\xff\xff\xff");
        let layout = header(&mut bytes.as_slice(), Some(2)).unwrap();
        let expected = Layout {
            format: Format::S16,
            rate_hz: 48_000.0,
            channels: 2,
            channel: Some(2),
        };
        assert_eq!(layout, expected);
        assert!(header(&mut bytes.as_slice(), Some(3)).is_err());
        for cut in 0..bytes.len() - 1 {
            assert!(header(&mut &bytes[..cut], None).is_err(), "{cut}");
        }
    }

    /// A whole WAV of one channel at 40 kHz; with `valid` bits in the extensible format.
    fn file(tag: u16, bits: u16, frame: u16, valid: Option<u16>) -> Vec<u8> {
        let mut format: Vec<u8> = [valid.map_or(tag, |_| EXTENSIBLE), 1]
            .map(u16::to_le_bytes)
            .concat();
        format.extend(
            [40_000, 40_000 * u32::from(frame)]
                .map(u32::to_le_bytes)
                .concat(),
        );
        format.extend([frame, bits].map(u16::to_le_bytes).concat());
        if let Some(valid) = valid {
            format.extend([22, valid, 4, 0, tag].map(u16::to_le_bytes).concat());
            format.extend(IDENTIFIER);
        }
        // Finite as floats too.
        let data: Vec<u8> = (0..48).map(|k: u8| k.wrapping_mul(37) & 0x3f).collect();
        let mut file = b"RIFF".to_vec();
        file.extend((28 + format.len() as u32 + data.len() as u32 - 8).to_le_bytes());
        file.extend(b"WAVEfmt ");
        file.extend((format.len() as u32).to_le_bytes());
        file.extend(&format);
        file.extend(b"data");
        file.extend((data.len() as u32).to_le_bytes());
        file.extend(&data);
        file
    }

    #[test]
    fn a_stream_is_read_as_its_file_is_or_refused() {
        let mut both = 0;
        for tag in [0, 1, 3, 6, 7, 0x11] {
            for bits in [0, 1, 8, 12, 16, 20, 24, 32, 40, 64] {
                for frame in [0, 1, 2, 3, 4, 5, 8] {
                    for valid in [
                        None,
                        Some(0),
                        Some(8),
                        Some(12),
                        Some(20),
                        Some(24),
                        Some(32),
                        Some(64),
                    ] {
                        let bytes = file(tag, bits, frame, valid);
                        let mut stream = bytes.as_slice();
                        let streamed =
                            header(&mut stream, None).map(|layout| layout.samples(stream));
                        let whole = wav::parse(bytes.clone(), 40_000.0, "a.wav");
                        match (streamed, whole) {
                            (Ok(streamed), Ok(whole)) => {
                                assert_eq!(streamed, whole, "{tag} {bits} {frame} {valid:?}");
                                both += 1;
                            }
                            // A file may be refused that a stream could hold, but not the other way round.
                            (Ok(_), Err(error)) => {
                                panic!("{tag} {bits} {frame} {valid:?}: the file: {error}")
                            }
                            (Err(_), _) => {}
                        }
                    }
                }
            }
        }
        assert!(both >= 12, "{both}");
        let left_aligned = file(1, 32, 4, Some(24));
        let layout = header(&mut left_aligned.as_slice(), None).unwrap();
        assert_eq!(layout.format, Format::S32);
    }
}
