//! The pose block by block, from echoes that are measured already or from samples as they come in.

use super::filter::{LandmarkFilter, Start, Status};
use super::hypothesis::{Noise, Seen};
use super::map::LandmarkMap;
use super::peaks::{MOST_PEAKS, Peak, PeakFinder};
use super::sighting::cosine_sigma;
use crate::echo::block_buffer::BlockBuffer;
use crate::echo::doppler_bank::{DopplerBank, DopplerScratch};
use crate::echo::{EchoBlock, EchoSequence};
use crate::error::Error;
use crate::filter::motion_model::advance;
use crate::odometry::{Odometry, mean_over_periods};
use crate::parameters::{Integration, Parameters};
use crate::pose::Pose;
use crate::signal::direct_wave;

/// The result of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Instant to which `pose` refers in seconds: the block's centre, or its start, by `time_reference`.
    pub t_s: f64,
    /// The pose.
    pub pose: Pose,
    /// Covariance of x, y (m) and heading (rad).
    pub covariance: [[f64; 3]; 3],
    /// `pose` carried by the wheels, less their errors, to the end of the block: the newest sample.
    pub latest: Pose,
    /// The instant of the newest sample in seconds.
    pub latest_s: f64,
    /// How far to trust it.
    pub status: Status,
    /// Share of the expected echoes found lately.
    pub fit: f64,
    /// Poses that are still possible.
    pub hypotheses: usize,
    /// What the wheels' turn rate lacks, in rad/s.
    pub turn_rate_error_radps: f64,
    /// What the wheels' speed lacks, as a part of it.
    pub speed_error: f64,
    /// Speed of sound in m/s.
    pub speed_of_sound_mps: f64,
}

/// Follows the blocks of one drive among landmarks.
pub struct LandmarkTracker {
    parameters: Parameters,
    noise: Noise,
    filter: LandmarkFilter,
    finder: PeakFinder,
    peaks: Vec<Peak>,
    started: bool,
}

impl LandmarkTracker {
    /// A tracker; `parameters` must pass [`Parameters::check`].
    pub fn new(parameters: &Parameters, start: &Start, noise: Noise) -> Self {
        Self {
            filter: LandmarkFilter::new(start, noise),
            finder: PeakFinder::new(parameters),
            peaks: Vec::with_capacity(MOST_PEAKS),
            parameters: parameters.clone(),
            noise,
            started: false,
        }
    }

    /// The filter.
    pub fn filter(&self) -> &LandmarkFilter {
        &self.filter
    }

    /// The peaks of the newest block.
    pub fn peaks(&self) -> &[Peak] {
        &self.peaks
    }

    /// Moves the hypotheses to the block's instant and holds them against its echoes. None while an unknown start has
    /// not seen a block of a moving robot.
    ///
    /// Blocks must be given one by one in their order. `recent` is the odometry of the block's M periods, preceded by
    /// that of the period before if there is one.
    pub fn update(
        &mut self,
        block: &EchoBlock,
        recent: &[Odometry],
        map: &LandmarkMap,
    ) -> Option<Estimate> {
        let here = self.predict(recent);
        if !block.stationary {
            let v_mps = block.odometry.v_mps;
            self.finder
                .find(block.intensity.view(), v_mps, &mut self.peaks);
            let seen = Seen {
                peaks: &self.peaks,
                cosine_sigma: cosine_sigma(&self.parameters, v_mps),
                odometry: block.odometry,
                signal: &self.parameters.signal,
            };
            self.filter.update(&seen, map);
        }
        let best = self.filter.best()?;
        let rest = recent.len() as f64 - here;
        let onward = mean_over_periods(recent, here, recent.len() as f64);
        let onward = Odometry {
            v_mps: onward.v_mps * (1.0 + best.state[4]),
            omega_radps: onward.omega_radps + best.state[3],
        };
        let covariance = best.pose_covariance();
        Some(Estimate {
            t_s: block.t_s,
            pose: best.pose(),
            covariance: [0, 1, 2].map(|row| [0, 1, 2].map(|column| covariance[(row, column)])),
            latest: advance(
                &best.pose(),
                onward,
                rest * self.parameters.period_s(),
                Integration::Midpoint,
            ),
            latest_s: block.t_s + rest * self.parameters.period_s(),
            status: self.filter.status(),
            fit: self.filter.fit(),
            hypotheses: self.filter.hypotheses().len(),
            turn_rate_error_radps: best.state[3],
            speed_error: best.state[4],
            speed_of_sound_mps: self.parameters.signal.speed_of_sound_mps * (1.0 + best.state[5]),
        })
    }

    /// From the previous block's instant, or from time 0, to this block's. Returns that instant in periods from the
    /// start of `recent`.
    fn predict(&mut self, recent: &[Odometry]) -> f64 {
        let reference = self.parameters.measurement.reference_periods();
        let period_s = self.parameters.period_s();
        let (mut from, to) = if self.started {
            (reference, reference + 1.0)
        } else {
            (0.0, reference)
        };
        self.started = true;
        // Pieces of at most a period, so that a turn is followed.
        while from < to {
            let end = (from.floor() + 1.0).min(to);
            self.filter.predict(
                mean_over_periods(recent, from, end),
                (end - from) * period_s,
            );
            from = end;
        }
        to
    }

    /// Standard deviations of motion and echoes.
    pub fn noise(&self) -> &Noise {
        &self.noise
    }
}

/// Follows a robot among landmarks, period by period.
///
/// ```
/// use std::path::Path;
///
/// use localizer::landmarks::{self, LandmarkLocalizer, Noise, Start};
/// use localizer::{Parameters, Recording, echo};
///
/// let mapping = Recording::read(Path::new("../examples/site_robot/mapping"))?;
/// let mut parameters = Parameters::default().for_recording(&mapping.meta);
/// parameters.measurement.periods = landmarks::PERIODS;
/// let echoes = echo::measure(&mapping, &parameters)?;
/// let truth = mapping.truth.as_ref().ok_or("no truth.tum")?;
/// let map = landmarks::learn(&[(&echoes, &echoes.poses(truth))])?;
///
/// let drive = Recording::read(Path::new("../examples/site_robot/drive"))?;
/// let mut localizer = LandmarkLocalizer::new(&parameters, map, &Start::Unknown, Noise::default())?;
/// let period = parameters.samples_per_period();
/// let odometry = drive.odometry_per_period(parameters.period_s(), 20);
/// for (samples, &odometry) in drive.signal.chunks_exact(period).zip(&odometry) {
///     if let Some(estimate) = localizer.step(samples, odometry)? {
///         println!("{:.2} s: {:?}, {:?}", estimate.t_s, estimate.pose, estimate.status);
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct LandmarkLocalizer {
    parameters: Parameters,
    map: LandmarkMap,
    buffer: BlockBuffer,
    bank: DopplerBank,
    scratch: DopplerScratch,
    block: EchoBlock,
    tracker: LandmarkTracker,
}

impl LandmarkLocalizer {
    /// A localizer in a map, which may have been learnt with other parameters.
    ///
    /// # Errors
    /// [`Error::Invalid`] for parameters that cannot be used, or `direct_wave` free-field, which cannot stream.
    pub fn new(
        parameters: &Parameters,
        map: LandmarkMap,
        start: &Start,
        noise: Noise,
    ) -> Result<Self, Error> {
        let bank = DopplerBank::new(parameters)?;
        direct_wave::check_streaming(parameters)?;
        Ok(Self {
            buffer: BlockBuffer::new(parameters),
            scratch: bank.scratch(),
            block: EchoBlock::empty(&bank),
            tracker: LandmarkTracker::new(parameters, start, noise),
            parameters: parameters.clone(),
            bank,
            map,
        })
    }

    /// One step: takes in one period of samples and the mean odometry during it.
    ///
    /// Returns `None` until M periods have come in and, from an unknown start, until the robot moves.
    ///
    /// # Errors
    /// As [`crate::Localizer::step`].
    pub fn step(&mut self, samples: &[f32], odometry: Odometry) -> Result<Option<Estimate>, Error> {
        self.step_period(samples, true, odometry)
    }

    /// As [`Self::step`]; with `heard` false the samples are a gap of the sound, see
    /// [`crate::Localizer::step_period`].
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn step_period(
        &mut self,
        samples: &[f32],
        heard: bool,
        odometry: Odometry,
    ) -> Result<Option<Estimate>, Error> {
        // A block of the last M periods, one period later than the previous one.
        self.buffer.push_period(samples, heard, odometry)?;
        let (index, deaf) = (self.buffer.block_index(), self.buffer.is_deaf());
        let Some((received, recent)) = self.buffer.block() else {
            return Ok(None);
        };
        let own = &recent[recent.len() - self.parameters.measurement.periods..];
        self.block.set_motion(&self.parameters, index, own);
        self.block.stationary |= deaf;
        // H of every direction and delay, eqs. (1)-(3) of the paper.
        self.bank.measure(
            received,
            self.block.odometry.v_mps,
            &mut self.scratch,
            &mut self.block.intensity,
        );
        // Its peaks, held against the landmarks.
        Ok(self.tracker.update(&self.block, recent, &self.map))
    }

    /// The map.
    pub fn map(&self) -> &LandmarkMap {
        &self.map
    }

    /// The filter and the peaks behind the newest estimate.
    pub fn tracker(&self) -> &LandmarkTracker {
        &self.tracker
    }
}

/// Estimates the pose at every block of a drive whose echoes are measured, with the result that
/// [`LandmarkLocalizer::step`] gives for the same samples. The parameters are those of the echoes: the map may have
/// been learnt with other periods, or by another robot.
pub fn localize(
    echoes: &EchoSequence,
    map: &LandmarkMap,
    start: &Start,
    noise: Noise,
) -> Vec<Estimate> {
    let mut tracker = LandmarkTracker::new(&echoes.parameters, start, noise);
    echoes
        .blocks
        .iter()
        .enumerate()
        .filter_map(|(index, block)| tracker.update(block, echoes.recent_odometry(index), map))
        .collect()
}
