//! What is known of a sound's clock, and what was found.

/// What is known of a sound's clock; the rest is found.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SoundClock {
    /// Time of the first sample of a period since the first sample of the sound, in seconds.
    pub late_s: Option<f64>,
    /// Excess of the recorder's rate over the loudspeaker's, in parts per million.
    pub drift_ppm: Option<f64>,
}

/// A place where samples are missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Period at which the code was found again.
    pub period: usize,
    /// Samples of the input that are missing (less than none: that are too many), but for whole periods.
    pub samples: f64,
}

/// What was found in a sound.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SoundReport {
    /// Time of the first sample of the first period since the first sample of the sound, in seconds.
    pub late_s: f64,
    /// Excess of the recorder's rate over the loudspeaker's, in parts per million, at the end.
    pub drift_ppm: f64,
    /// Strongest lag of the code over the median of all lags, in decibels; none when the clock was given.
    pub code_db: Option<f64>,
    /// Height of the direct wave: 1 for the amplitude that was sent.
    pub direct: f64,
    /// Periods so far, and those of them without the direct wave.
    pub periods: usize,
    /// Periods in which the direct wave was not heard.
    pub unheard: usize,
    /// Places where samples are missing.
    pub gaps: Vec<Gap>,
    /// Root mean square of the direct wave's time less what was foreseen, in seconds.
    pub jitter_s: f64,
}
