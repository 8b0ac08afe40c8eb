//! A recording looked at before it is trusted: sound, code, clocks, logs.

mod echoes;
mod level;
mod logs;

use std::path::Path;

use anyhow::Result;
use localizer::align::{ClockSource, LogClock};
use localizer::io::recording_source::{ReadOptions, RecordingSource};
use localizer::io::wav::WavStream;
use localizer::odometry::OdometrySample;
use serde::Serialize;

pub use level::{Level, decibels};

/// What a line says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// As it should be.
    Ok,
    /// Of use, but not as good as it could be.
    Mind,
    /// To be put right first.
    Bad,
}

/// One line of an inspection.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Line {
    /// What was looked at.
    pub name: &'static str,
    /// What it says.
    pub verdict: Verdict,
    /// What was found.
    pub found: String,
    /// What to do about it.
    pub remedy: Option<String>,
}

/// A recording's inspection.
#[derive(Debug, Clone, Default)]
pub struct Inspection {
    /// All lines.
    pub lines: Vec<Line>,
    /// Root mean square of the sound over time: `[s, 1 for full scale]`.
    pub level: Vec<(f64, f64)>,
    /// Strongest echoes over time: `[s, m]`.
    pub echoes: Vec<(f64, f64)>,
    /// The wheels' log.
    pub wheels: Vec<OdometrySample>,
    /// Motion by the truth.
    pub truth: Vec<OdometrySample>,
}

impl Inspection {
    /// Looks at a recording folder. What cannot be read or found is a line, too.
    ///
    /// # Errors
    /// When there is no sound to look at.
    pub fn of(folder: &Path, options: &ReadOptions) -> Result<Self> {
        let path = folder.join("signal.wav");
        let stream = WavStream::open(&path)?;
        let (channels, rate_hz) = (stream.channels(), stream.rate_hz());
        drop(stream);
        let opened = RecordingSource::open(folder, options);
        let channel = match &opened {
            Ok(source) => source.alignment.channel,
            Err(_) => options.channel.unwrap_or(1).min(channels),
        };
        let mut inspection = Self::default();
        let level = Level::read(&path, channel)?;
        inspection.sound(&level, rate_hz, channel, channels);
        match opened {
            Ok(source) => inspection.recording(&source)?,
            Err(error) => {
                let remedy = "put this right; the lines that follow need it".to_owned();
                inspection.bad("recording", error.to_string(), remedy);
            }
        }
        Ok(inspection)
    }

    fn line(
        &mut self,
        name: &'static str,
        verdict: Verdict,
        found: String,
        remedy: Option<String>,
    ) {
        self.lines.push(Line {
            name,
            verdict,
            found,
            remedy,
        });
    }

    fn ok(&mut self, name: &'static str, found: String) {
        self.line(name, Verdict::Ok, found, None);
    }

    fn bad(&mut self, name: &'static str, found: String, remedy: String) {
        self.line(name, Verdict::Bad, found, Some(remedy));
    }

    /// A line that is ok unless `remedy` says what to do.
    fn mind(&mut self, name: &'static str, found: String, remedy: Option<&str>) {
        let verdict = remedy.map_or(Verdict::Ok, |_| Verdict::Mind);
        self.line(name, verdict, found, remedy.map(str::to_owned));
    }

    /// Lines on the file of sound.
    fn sound(&mut self, level: &Level, rate_hz: f64, channel: usize, channels: usize) {
        let seconds = level.samples as f64 / rate_hz;
        self.level = level
            .over_time
            .iter()
            .enumerate()
            .map(|(k, &rms)| ((k as f64 + 0.5) * level::LEVEL_S, rms))
            .collect();
        self.ok(
            "sound",
            format!("{seconds:.1} s at {rate_hz} Hz, channel {channel} of {channels}"),
        );
        let found = format!(
            "{:.1} dB of full scale, peak {:.1} dB",
            decibels(level.rms),
            decibels(level.peak)
        );
        let remedy = match (decibels(level.rms), level.peak) {
            (rms_db, _) if rms_db < -70.0 => {
                Some("turn the microphone's gain or the loudspeaker up")
            }
            (rms_db, peak) if rms_db > -6.0 || peak > 0.98 => Some("turn the gain down a little"),
            _ => None,
        };
        self.mind("level", found, remedy);
        match level.clipped {
            0 => self.ok("clipping", "none".to_owned()),
            count => {
                let share = 100.0 * count as f64 / level.samples as f64;
                let found = format!("{count} samples ({share:.2} %) at full scale");
                self.bad(
                    "clipping",
                    found,
                    "turn the gain down and record again".to_owned(),
                );
            }
        }
        let found = format!("{:.1} dB of full scale", decibels(level.mean.abs()));
        let is_large = level.mean.abs() > 0.1 * level.rms.max(1e-3) && level.mean.abs() > 1e-3;
        let remedy =
            is_large.then_some("it does no harm but takes headroom: check the microphone's supply");
        self.mind("offset", found, remedy);
        let (mains_hz, hum) = level.hum;
        let over = decibels(hum / level.rms.max(1e-12));
        let found = format!("{over:.1} dB of the sound at {mains_hz} Hz and its overtones");
        let remedy = (over > -6.0).then_some(
            "it is out of the code's band but takes headroom: check cables and grounding",
        );
        self.mind("hum", found, remedy);
    }

    /// Lines on clocks, echoes and logs.
    fn recording(&mut self, source: &RecordingSource) -> Result<()> {
        let heard = echoes::hear(source)?;
        self.code(source, &heard.report);
        let logs = [(
            "wheels' clock",
            Some(source.alignment.odometry),
            "odometry_clock_s",
        )];
        for (name, clock, field) in
            logs.into_iter()
                .chain([("truth's clock", source.alignment.truth, "truth_clock_s")])
        {
            if let Some(clock) = clock {
                self.clock(name, clock, field);
            }
        }
        self.echoes = heard.peaks.clone();
        let found = format!(
            "{:.0} dB over the rest of the block, {:.1} of them a block, {:.1} m away in the middle",
            heard.over_db, heard.a_block, heard.middle_m
        );
        let remedy = match (heard.over_db, heard.a_block) {
            (db, count) if db < 12.0 || count < 1.0 => Some(
                "turn the loudspeaker up, drive nearer to walls, or look for noise in the code's band",
            ),
            _ => None,
        };
        self.mind("echoes", found, remedy);
        logs::look(self, source);
        Ok(())
    }

    fn code(&mut self, source: &RecordingSource, report: &localizer::align::SoundReport) {
        let Some(code_db) = report.code_db else {
            let found = "the clock of the sound is given, and not looked for".to_owned();
            self.ok("code", found);
            return;
        };
        let found = format!(
            "found {code_db:.0} dB over the floor; the direct wave has {:.3} of full scale",
            report.direct
        );
        self.mind(
            "code",
            found,
            (code_db < 15.0).then_some("turn the loudspeaker up"),
        );
        let found = format!(
            "the first period begins {:.3} ms after the first sample",
            1e3 * source.alignment.sound.late_s
        );
        self.ok("latency", found);
        let found = format!(
            "the recorder runs {:+.2} ppm against the loudspeaker, steady to {:.2} us",
            report.drift_ppm,
            1e6 * report.jitter_s
        );
        let remedy = match (report.drift_ppm.abs(), 1e6 * report.jitter_s) {
            (_, jitter) if jitter > 3.0 => Some(
                "the direct wave moves: fix loudspeaker and microphone, or look for a loose sample rate",
            ),
            (ppm, _) if ppm > 150.0 => {
                Some("it is corrected, but look whether the sample rate is right")
            }
            _ => None,
        };
        self.mind("drift", found, remedy);
        let missing: Vec<String> = report
            .gaps
            .iter()
            .map(|gap| format!("{:.0} at period {}", gap.samples, gap.period))
            .collect();
        let found = match (report.unheard, missing.is_empty()) {
            (0, _) => format!("{} periods without a gap", report.periods),
            (unheard, true) => format!("{unheard} of {} periods are not heard", report.periods),
            (unheard, false) => format!(
                "{unheard} of {} periods are not heard; samples are missing: {}",
                report.periods,
                missing.join(", ")
            ),
        };
        // Lost samples are lost once; a start of the period that wanders is that of an echo.
        let wanders = report.gaps.iter().any(|gap| gap.samples < 0.0);
        let remedy = (report.unheard > 0).then_some(match wanders {
            true => {
                "poses there follow the wheels alone; samples that come back are no loss: the period is found by \
                echoes, as the direct wave is weaker; turn loudspeaker and microphone towards each other, or place \
                them closer"
            }
            false => "poses there follow the wheels alone; use larger buffers when recording",
        });
        self.mind("gaps", found, remedy);
    }

    fn clock(&mut self, name: &'static str, clock: LogClock, field: &str) {
        let shows = format!("{:.4} s at the first period", clock.reading_s);
        match clock.source {
            ClockSource::Given => self.ok(name, format!("{shows}, as given")),
            ClockSource::Echoes | ClockSource::Motion => {
                let by = match clock.source {
                    ClockSource::Echoes => "the echoes",
                    _ => "speeds and turns",
                };
                let found = format!("{shows}, by {by} (+-{:.0} ms)", 1e3 * clock.sigma_s);
                let remedy = (clock.sigma_s > 0.04)
                    .then_some("drive with more turns and changes of speed, or note the clocks");
                self.mind(name, found, remedy);
            }
            ClockSource::Assumed => {
                let found = "nothing tells it; it is taken for the sound's".to_owned();
                let remedy = format!("give {field}, or drive with turns and changes of speed");
                self.line(name, Verdict::Mind, found, Some(remedy));
            }
        }
    }
}
