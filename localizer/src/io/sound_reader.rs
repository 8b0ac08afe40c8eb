//! The sound of a recording, period by period.

use std::collections::VecDeque;
use std::path::Path;

use super::wav::WavStream;
use crate::align::{SoundAligner, SoundClock, SoundReport};
use crate::error::Error;
use crate::parameters::Parameters;

/// Samples that are read at a time.
const PIECE: usize = 1 << 14;

/// The sound of a recording, period by period.
pub struct SoundReader {
    stream: WavStream,
    channel: usize,
    aligner: SoundAligner,
    piece: Vec<f32>,
    ready: VecDeque<(Vec<f32>, bool)>,
    ended: bool,
}

impl SoundReader {
    /// Opens a channel of a file.
    ///
    /// # Errors
    /// [`Error`] when that fails.
    pub(super) fn open(path: &Path, channel: usize, aligner: SoundAligner) -> Result<Self, Error> {
        Ok(Self {
            stream: WavStream::open(path)?,
            channel,
            aligner,
            piece: Vec::with_capacity(PIECE),
            ready: VecDeque::new(),
            ended: false,
        })
    }

    /// The next period, and whether the direct wave was heard in it; none at the end.
    ///
    /// # Errors
    /// [`Error`] for a damaged file.
    pub fn next_period(&mut self) -> Result<Option<(Vec<f32>, bool)>, Error> {
        while self.ready.is_empty() && !self.ended {
            let Self {
                stream,
                aligner,
                piece,
                ready,
                ..
            } = self;
            let mut emit = |period: &[f32], heard: bool| {
                ready.push_back((period.to_vec(), heard));
                Ok(())
            };
            piece.clear();
            if stream.read(PIECE, self.channel, piece)? == 0 {
                self.ended = true;
                aligner.finish(&mut emit)?;
            } else {
                aligner.push(piece, &mut emit)?;
            }
        }
        Ok(self.ready.pop_front())
    }

    /// What was found so far.
    pub fn report(&self) -> &SoundReport {
        self.aligner.report()
    }
}

/// Reads a sound until its code is found.
pub(super) fn begin(
    path: &Path,
    channel: usize,
    rate_hz: f64,
    parameters: &Parameters,
    clock: SoundClock,
) -> Result<SoundReport, Error> {
    // The channel must have the code even where the clock is given.
    let known = clock.late_s.is_some() && clock.drift_ppm.is_some();
    let clock = if known { SoundClock::default() } else { clock };
    let mut stream = WavStream::open(path)?;
    let mut aligner = SoundAligner::new(parameters, rate_hz, clock)?;
    let mut piece = Vec::with_capacity(PIECE);
    while !aligner.has_code() {
        piece.clear();
        if stream.read(PIECE, channel, &mut piece)? == 0 {
            aligner.finish(&mut |_, _| Ok(()))?;
            break;
        }
        aligner.push(&piece, &mut |_, _| Ok(()))?;
    }
    Ok(aligner.report().clone())
}
