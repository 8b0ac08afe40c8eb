//! How a recording was aligned, and what is to be said about it.

use super::report::SoundReport;

/// Where the reading of a clock comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClockSource {
    /// `recording.json` or an option.
    Given,
    /// The ranges of the echoes along the log's path.
    Echoes,
    /// Speeds and turns of another log.
    Motion,
    /// Nothing tells it; the log's times suit the sound as they are.
    Assumed,
}

/// Reading of a log's clock at the first sample of the first period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogClock {
    /// The reading in seconds.
    pub reading_s: f64,
    /// Its standard deviation in seconds; 0 when it was given.
    pub sigma_s: f64,
    /// Where it comes from.
    pub source: ClockSource,
}

impl LogClock {
    /// A reading that the user gives.
    pub(crate) fn given(reading_s: f64) -> Self {
        Self {
            reading_s,
            sigma_s: 0.0,
            source: ClockSource::Given,
        }
    }
}

/// How a recording's sound and logs were put on one clock.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// Rate of the file in Hz.
    pub file_rate_hz: f64,
    /// Rate at which it is worked with in Hz.
    pub rate_hz: f64,
    /// Channels of the file.
    pub channels: usize,
    /// The channel that is used; the first is 1.
    pub channel: usize,
    /// The sound; after the first second of it, or as it was given.
    pub sound: SoundReport,
    /// The wheels' clock.
    pub odometry: LogClock,
    /// The truth's clock.
    pub truth: Option<LogClock>,
    /// The speed of sound was not given.
    pub speed_of_sound_assumed: bool,
}

impl Alignment {
    /// That of a recording whose numbers are all given.
    pub(crate) fn given(file_rate_hz: f64, rate_hz: f64, channels: usize) -> Self {
        Self {
            file_rate_hz,
            rate_hz,
            channels,
            channel: 1,
            sound: SoundReport::default(),
            odometry: LogClock::given(0.0),
            truth: None,
            speed_of_sound_assumed: false,
        }
    }

    /// What was done to the recording, a line each; nothing for one that was aligned and complete.
    pub fn told(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if self.channels > 1 {
            lines.push(format!("channel {} of {}", self.channel, self.channels));
        }
        if (self.file_rate_hz - self.rate_hz).abs() > 1e-6 {
            lines.push(format!(
                "resampled from {} Hz to {:.3} Hz, so that a period is a whole number of samples",
                self.file_rate_hz, self.rate_hz
            ));
        }
        if self.sound.code_db.is_some() {
            lines.push(format!(
                "the first period begins {:.4} ms after the first sample; the recorder runs {:+.2} ppm against the \
                 loudspeaker",
                1e3 * self.sound.late_s,
                self.sound.drift_ppm
            ));
        }
        for (name, file, clock) in [
            ("wheels", "odometry_clock_s", Some(&self.odometry)),
            ("truth", "truth_clock_s", self.truth.as_ref()),
        ] {
            let Some(clock) = clock else {
                continue;
            };
            let how = match clock.source {
                ClockSource::Given => continue,
                ClockSource::Echoes => "by the echoes",
                ClockSource::Motion => "by speeds and turns",
                ClockSource::Assumed => {
                    lines.push(format!(
                        "warning: nothing tells the {name}' clock: it is taken for the sound's; give {file} \
                         if it is not"
                    ));
                    continue;
                }
            };
            lines.push(format!(
                "the clock of the {name} shows {:.4} s at the first period, {how} (+-{:.1} ms)",
                clock.reading_s,
                1e3 * clock.sigma_s
            ));
        }
        if self.speed_of_sound_assumed {
            lines.push(format!(
                "warning: speed_of_sound_mps is not given: {SPEED_OF_SOUND_MPS} m/s, that of 20 degC, is taken"
            ));
        }
        lines
    }
}

/// Speed of sound where none is given, in m/s: dry air of 20 degC.
pub const SPEED_OF_SOUND_MPS: f64 = 343.2;
