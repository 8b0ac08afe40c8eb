//! The loudspeaker and the microphone, options, and the samples of a signal.

use rayon::prelude::*;

/// Time of the onset ramp of the source, in seconds.
pub(super) const ONSET_S: f64 = 1e-3;

/// Samples that one thread works on at a time.
const CHUNK_SAMPLES: usize = 4096;

/// Selection of the images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageSourceOptions {
    /// Most reflections of an echo.
    pub max_order: usize,
    /// Whether the sound that reaches the microphone without reflection is included. It never is when the two are less
    /// than 1 mm apart, where a line source has no finite pressure.
    pub include_direct: bool,
    /// Distance in metres on either side of a border of visibility over which an echo fades; more than 0.
    pub fade_m: f64,
    /// Source strength times the time since the middle of the drive, which gives travel times
    /// ([`fdtd::medium::absorbed`]).
    pub stamped: bool,
}

impl Default for ImageSourceOptions {
    fn default() -> Self {
        Self {
            max_order: 2,
            include_direct: false,
            fade_m: 0.05,
            stamped: false,
        }
    }
}

/// A position in metres at any time in seconds; evaluated at times somewhat before 0 and after the end too.
pub type PositionAt<'a> = &'a (dyn Fn(f64) -> [f64; 2] + Sync);

/// A loudspeaker and a microphone that move.
#[derive(Clone, Copy)]
pub struct PlanePair<'a> {
    /// Where the loudspeaker is.
    pub source_at: PositionAt<'a>,
    /// Where the microphone is.
    pub receiver_at: PositionAt<'a>,
    /// How long they are recorded, in seconds.
    pub duration_s: f64,
}

/// The `floor(duration_s * sample_rate_hz)` samples of a signal, a chunk at a time on all threads: `fill` takes the
/// index of a chunk's first sample, and the chunk.
pub(super) fn in_chunks(
    duration_s: f64,
    sample_rate_hz: f64,
    fill: impl Fn(usize, &mut [f32]) + Sync,
) -> Vec<f32> {
    // A whole number of samples must not be lost to the last bit of a product.
    let samples = (duration_s * sample_rate_hz + 1e-6).floor().max(0.0) as usize;
    let mut signal = vec![0.0_f32; samples];
    let chunks = signal.par_chunks_mut(CHUNK_SAMPLES).enumerate();
    chunks.for_each(|(chunk, out)| fill(chunk * CHUNK_SAMPLES, out));
    signal
}
