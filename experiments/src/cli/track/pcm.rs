//! Sound on standard input: raw samples or a WAV stream, one channel of it, read by a thread of its own.

use std::io::{BufReader, Read};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::ValueEnum;

use crate::run::interrupt;

/// Frames that are read at a time: 10 ms at 48 kHz.
const FRAMES: usize = 480;

/// Pieces that wait; more wait in the pipe.
const WAITING: usize = 64;

/// Longest header of a WAV stream.
const LONGEST_HEADER: u64 = 1 << 20;

/// Format of the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// A WAV stream; its header tells format, rate and channels.
    Wav,
    /// 32-bit float, little endian.
    F32,
    /// 16-bit integers, little endian.
    S16,
    /// 24-bit integers, three bytes, little endian.
    S24,
    /// 32-bit integers, little endian.
    S32,
}

/// What a stream holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Layout {
    pub(super) format: Format,
    pub(super) rate_hz: f64,
    pub(super) channels: usize,
    /// The channel that is used, the first is 1; the first with the code unless given.
    pub(super) channel: Option<usize>,
}

impl Format {
    fn bytes(self) -> usize {
        match self {
            Self::S16 => 2,
            Self::S24 => 3,
            Self::F32 | Self::S32 | Self::Wav => 4,
        }
    }

    /// One sample, full scale 1.
    fn sample(self, bytes: &[u8]) -> f32 {
        match (self, bytes) {
            (Self::S16, &[a, b]) => f32::from(i16::from_le_bytes([a, b])) / 32_768.0,
            (Self::S24, &[a, b, c]) => {
                (f64::from(i32::from_le_bytes([0, a, b, c])) / 2_147_483_648.0) as f32
            }
            (Self::S32, &[a, b, c, d]) => {
                (f64::from(i32::from_le_bytes([a, b, c, d])) / 2_147_483_648.0) as f32
            }
            (_, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            _ => 0.0,
        }
    }
}

/// Reads the header of a WAV stream up to its samples. Lengths are not believed: a pipe's writer does not know them.
pub(super) fn header(stream: &mut impl Read, channel: Option<usize>) -> Result<Layout> {
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
        if &chunk[..4] == b"fmt " && content.len() >= 16 {
            let two = |at: usize| u16::from_le_bytes([content[at], content[at + 1]]);
            let rate = u32::from_le_bytes([content[4], content[5], content[6], content[7]]);
            // The extensible format has its own tag in the first bytes of an identifier.
            let tag = if two(0) == 0xfffe && content.len() >= 26 {
                two(24)
            } else {
                two(0)
            };
            let format = match (tag, two(14)) {
                (1, 16) => Format::S16,
                (1, 24) => Format::S24,
                (1, 32) => Format::S32,
                (3, 32) => Format::F32,
                (tag, bits) => bail!(
                    "standard input: WAV of format {tag} with {bits} bits; give 16, 24, 32-bit integers or 32-bit float"
                ),
            };
            found = Some((format, f64::from(rate), usize::from(two(2))));
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

impl Layout {
    /// Refuses what cannot be.
    pub(super) fn checked(self) -> Result<Self> {
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
}

/// A stream that a thread reads.
pub(super) struct Stream {
    pieces: Receiver<std::io::Result<Vec<f32>>>,
}

impl Stream {
    /// Starts to read.
    pub(super) fn start(stream: BufReader<impl Read + Send + 'static>, layout: Layout) -> Self {
        let (sender, pieces) = sync_channel(WAITING);
        std::thread::spawn(move || pump(stream, layout, &sender));
        Self { pieces }
    }

    /// The next samples of all channels, frame by frame; none at the end.
    pub(super) fn next(&self) -> Result<Option<Vec<f32>>> {
        loop {
            interrupt::check()?;
            match self.pieces.recv_timeout(Duration::from_millis(100)) {
                Ok(piece) => return piece.map(Some).context("standard input"),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(None),
            }
        }
    }
}

/// Reads until the end, or until nobody listens.
fn pump(
    mut stream: BufReader<impl Read>,
    layout: Layout,
    sender: &SyncSender<std::io::Result<Vec<f32>>>,
) {
    let width = layout.format.bytes();
    let frame = width * layout.channels;
    let mut bytes = vec![0; FRAMES * frame];
    let mut held = 0;
    loop {
        match stream.read(&mut bytes[held..]) {
            Ok(0) => return,
            Ok(count) => held += count,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
            Err(error) => {
                // Nobody listens any more, or hears of it.
                let _ = sender.send(Err(error));
                return;
            }
        }
        let whole = held - held % frame;
        let samples: Vec<f32> = bytes[..whole]
            .chunks_exact(width)
            .map(|sample| layout.format.sample(sample))
            .collect();
        bytes.copy_within(whole..held, 0);
        held -= whole;
        if !samples.is_empty() && sender.send(Ok(samples)).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_every_format_are_scaled() {
        assert_eq!(Format::S16.sample(&[0, 0x40]), 0.5);
        assert_eq!(Format::S24.sample(&[0, 0, 0x80]), -1.0);
        assert_eq!(Format::S32.sample(&[0, 0, 0, 0x20]), 0.25);
        assert_eq!(Format::F32.sample(&0.125_f32.to_le_bytes()), 0.125);
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
}
