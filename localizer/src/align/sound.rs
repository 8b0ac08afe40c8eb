//! From a sound card's samples to whole periods of the code at a rate of which a period is a whole number of samples.
//!
//! A second of sound tells where a period begins and how fast the recorder's clock runs against the loudspeaker's
//! ([`super::acquisition`]). From then on the direct wave, which does not move on the robot, is followed from period
//! to period by its phase: a filter of second order (gains of the least-squares line over the periods so far, at most a
//! hundred) steers the positions at which the input is read. Nothing looks ahead, so that a live robot gets the
//! bytes of its recording.

use rustfft::num_complex::Complex;

use super::acquisition::{self, LEAST_HEIGHT, acquire};
use super::follower::{Follower, LARGEST_DRIFT};
use super::replica::Replica;
use super::report::{SoundClock, SoundReport};
use super::resampler::{Position, Resampler};
use crate::error::Error;
use crate::parameters::Parameters;

enum State {
    Searching { from: i64 },
    Following(Follower),
}

/// Takes a period: its samples, and whether the direct wave was in it.
pub type Emit<'a> = dyn FnMut(&[f32], bool) -> Result<(), Error> + 'a;

/// Turns samples as they come into periods.
pub struct SoundAligner {
    input: Vec<f32>,
    /// Number of the first sample of `input`.
    base: i64,
    nominal_step: f64,
    length: usize,
    rate_hz: f64,
    out_hz: f64,
    clock: SoundClock,
    parameters: Parameters,
    replica: Replica,
    resampler: Resampler,
    state: State,
    period: Vec<f32>,
    report: SoundReport,
    /// Whether the input is already what the output should be.
    whole: bool,
}

impl SoundAligner {
    /// An aligner for a sound of `rate_hz`; its periods are those of `parameters`.
    ///
    /// # Errors
    /// Those of [`Parameters::check`]; [`Error::Invalid`] for a rate or a clock that cannot be.
    pub fn new(parameters: &Parameters, rate_hz: f64, clock: SoundClock) -> Result<Self, Error> {
        parameters.check()?;
        let refuse = |field: &str, value: f64, remedy: &str| {
            let problem = format!("{value} cannot be used");
            Err(Error::invalid("sound", field, problem, remedy))
        };
        let out_hz = parameters.signal.sample_rate_hz;
        let nominal_step = rate_hz / out_hz;
        if !(nominal_step.is_finite() && (1e-3..=1e3).contains(&nominal_step)) {
            return refuse("sample rate", rate_hz, "give the rate of the sound in Hz");
        }
        if let Some(late_s) = clock.late_s
            && !(0.0..=1e5).contains(&late_s)
        {
            return refuse("late_s", late_s, "give 0 to 100000 s");
        }
        if let Some(drift_ppm) = clock.drift_ppm
            && !(-1e6 * LARGEST_DRIFT..=1e6 * LARGEST_DRIFT).contains(&drift_ppm)
        {
            return refuse("drift_ppm", drift_ppm, "give -300 to 300");
        }
        let length = parameters.samples_per_period();
        let state = match (clock.late_s, clock.drift_ppm) {
            (Some(late_s), Some(drift_ppm)) => {
                let step = nominal_step * (1.0 + 1e-6 * drift_ppm);
                let start = Position::at(late_s * rate_hz);
                State::Following(Follower::new(start, [step, nominal_step], out_hz, None))
            }
            _ => State::Searching { from: 0 },
        };
        Ok(Self {
            input: Vec::new(),
            base: 0,
            whole: clock.late_s == Some(0.0)
                && clock.drift_ppm == Some(0.0)
                && (nominal_step - 1.0).abs() < 1e-12,
            nominal_step,
            length,
            rate_hz,
            replica: Replica::new(parameters)?,
            parameters: parameters.clone(),
            out_hz,
            resampler: Resampler::new(nominal_step),
            state,
            period: vec![0.0; length],
            report: SoundReport {
                late_s: clock.late_s.unwrap_or(0.0),
                drift_ppm: clock.drift_ppm.unwrap_or(0.0),
                ..SoundReport::default()
            },
            clock,
        })
    }

    /// What was found so far.
    pub fn report(&self) -> &SoundReport {
        &self.report
    }

    /// Whether the code has been found.
    pub fn has_code(&self) -> bool {
        matches!(self.state, State::Following(_))
    }

    /// Takes samples and hands out every period that is complete: its samples and whether the direct wave was in it.
    ///
    /// # Errors
    /// Those of `emit`, and [`Error::Invalid`] for a sample that is not finite.
    pub fn push(&mut self, samples: &[f32], emit: &mut Emit<'_>) -> Result<(), Error> {
        if let Some(place) = samples.iter().position(|sample| !sample.is_finite()) {
            let number = self.base + (self.input.len() + place) as i64;
            let problem = format!("sample {number} is not a finite number");
            return Err(Error::invalid(
                "sound",
                "samples",
                problem,
                "repair or cut the sound",
            ));
        }
        // A long piece is taken in parts: what is kept stays short.
        for part in samples.chunks(self.length.max(1)) {
            self.input.extend_from_slice(part);
            self.work(false, emit)?;
        }
        Ok(())
    }

    /// Hands out the periods that are complete at the end of the sound.
    ///
    /// # Errors
    /// Those of `emit`, and [`Error::Invalid`] when the code was never found.
    pub fn finish(&mut self, emit: &mut Emit<'_>) -> Result<(), Error> {
        self.work(true, emit)?;
        if self.has_code() {
            return Ok(());
        }
        let length_s = self.end() as f64 / self.rate_hz;
        let problem = format!("the code is not heard in {length_s:.1} s of it");
        let remedy = "check code, channel, loudspeaker and gain (`echolot record check`), record at least two \
            seconds, or give late_s and drift_ppm";
        Err(Error::invalid("signal.wav", "sound", problem, remedy))
    }

    fn work(&mut self, ended: bool, emit: &mut Emit<'_>) -> Result<(), Error> {
        while let State::Searching { from } = self.state {
            if !self.search(from, ended) {
                return Ok(());
            }
        }
        while self.follow(ended) {
            let heard = match &mut self.state {
                State::Following(follower) => {
                    follower.judge(&self.period, &mut self.replica, &mut self.report)
                }
                State::Searching { .. } => false,
            };
            self.report.periods += 1;
            self.report.unheard += usize::from(!heard);
            emit(&self.period, heard)?;
        }
        Ok(())
    }

    /// Samples so far.
    fn end(&self) -> i64 {
        self.base + self.input.len() as i64
    }

    /// Looks for the code from sample `from` on. False when more samples are needed.
    fn search(&mut self, from: i64, ended: bool) -> bool {
        let period = self.length as f64 * self.nominal_step;
        let needed = acquisition::PERIODS as f64 * period + self.resampler.reach() as f64;
        let until = from + needed.ceil() as i64;
        let enough = self.end() >= until;
        let last = ended && (self.end() - from) as f64 > 3.0 * period;
        if !enough && !last {
            return false;
        }
        // No sample more than needed: what is found must not depend on the pieces in which the sound comes.
        let window = (from - self.base) as usize..(until.min(self.end()) - self.base) as usize;
        let found = acquire(
            &self.input[window],
            self.nominal_step,
            (self.length, self.out_hz),
            &mut self.replica,
            &self.resampler,
        );
        let possible = |step: f64| (step / self.nominal_step - 1.0).abs() <= LARGEST_DRIFT;
        let Some(found) = found.filter(|found| possible(found.step)) else {
            if enough {
                let next = from + (6.0 * period) as i64;
                self.state = State::Searching { from: next };
                self.forget(next);
            }
            return enough;
        };
        let given = self
            .clock
            .drift_ppm
            .map(|ppm| self.nominal_step * (1.0 + 1e-6 * ppm));
        let step = given.unwrap_or(found.step);
        let period = self.length as f64 * step;
        // A recording that starts with a period must not lose it to a hair's breadth.
        let earliest = -0.002 * period;
        let mut start = found.start;
        while start < earliest {
            start += period;
        }
        while start - period >= earliest && self.is_heard(from, start - period, step, found.direct)
        {
            start -= period;
        }
        let mut start = Position {
            whole: from,
            fraction: 0.0,
        }
        .plus(start);
        if let Some(late_s) = self.clock.late_s {
            // The user says where a period begins: the direct wave has another lag then.
            let given = late_s * self.rate_hz;
            let lag = self.replica.direct_lag + (start.samples() - given) / step;
            let lag = lag.rem_euclid(self.length as f64);
            match Replica::with_lag(&self.parameters, lag) {
                Ok(replica) => self.replica = replica,
                Err(_) => return false,
            }
            start = Position::at(given);
        }
        self.report.late_s = start.samples() / self.rate_hz;
        self.report.code_db = Some(10.0 * found.ratio.log10());
        self.report.direct = found.direct.norm();
        let found_ppm = 1e6 * (step / self.nominal_step - 1.0);
        self.report.drift_ppm = self.clock.drift_ppm.unwrap_or(found_ppm);
        let direct = given.is_none().then_some(found.direct);
        let steps = [step, self.nominal_step];
        self.state = State::Following(Follower::new(start, steps, self.out_hz, direct));
        true
    }

    /// Whether the direct wave is in the period that starts `start` after sample `from`.
    fn is_heard(&mut self, from: i64, start: f64, step: f64, direct: Complex<f64>) -> bool {
        let place = Position {
            whole: from - self.base,
            fraction: 0.0,
        }
        .plus(start);
        self.resampler
            .fill_from(&self.input, place, step, &mut self.period);
        self.replica.direct(&self.period).norm() > LEAST_HEIGHT * direct.norm()
    }

    /// Reads the next period. False when its samples are not there yet.
    fn follow(&mut self, ended: bool) -> bool {
        let (reach, end) = (self.resampler.reach() as f64, self.end());
        let State::Following(follower) = &mut self.state else {
            return false;
        };
        let last = follower.start.plus(self.length as f64 * follower.steered);
        let margin = if ended || self.whole {
            -0.5
        } else {
            reach + 1.0
        };
        if last.plus(margin).samples() > end as f64 {
            return false;
        }
        let place = follower.start.since(self.base);
        if self.whole {
            let from = place.samples().round() as usize;
            self.period
                .copy_from_slice(&self.input[from..from + self.length]);
        } else {
            self.resampler
                .fill_from(&self.input, place, follower.steered, &mut self.period);
        }
        follower.advance(self.length);
        // What a jump back may need stays.
        let kept = 0.75 * self.length as f64 * self.nominal_step + reach;
        self.forget(last.whole - kept as i64);
        true
    }

    /// Forgets samples before number `before`.
    fn forget(&mut self, before: i64) {
        let count = (before - 1 - self.base).clamp(0, self.input.len() as i64) as usize;
        // Moving the rest costs as much as a period's work: only a long beginning goes.
        if count > 2 * self.length {
            self.input.drain(..count);
            self.base += count as i64;
        }
    }
}
