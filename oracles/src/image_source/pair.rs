//! What sounds and what hears it, and which images count.

/// Time of the onset ramp of the source, in seconds.
pub(super) const ONSET_S: f64 = 1e-3;

/// Samples that one thread works on at a time.
pub(super) const CHUNK_SAMPLES: usize = 4096;

/// Which images sound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageSourceOptions {
    /// Most reflections of an echo.
    pub max_order: usize,
    /// Whether the sound that reaches the microphone without reflection is included. It never is when the two are less than 1 mm
    /// apart, where a line source has no finite pressure.
    pub include_direct: bool,
    /// Distance in metres on either side of a border of visibility over which an echo fades; more than 0.
    pub fade_m: f64,
    /// Source strength times the time since the middle of the drive, which tells travel times ([`fdtd::medium::absorbed`]).
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

/// A position in metres at any time in seconds; asked at times somewhat before 0 and after the end too.
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
