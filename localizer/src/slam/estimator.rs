//! The drive and its landmarks, block by block.

use nalgebra::Matrix3;

use super::equations::START_SIGMA;
use super::graph::STATES;
use super::joint::Joint;
use crate::echo::EchoBlock;
use crate::filter::motion_model::advance;
use crate::landmarks::hypothesis::{Covariance, Hypothesis, Seen};
use crate::landmarks::landmark::Motion;
use crate::landmarks::peaks::{MOST_PEAKS, PeakFinder};
use crate::landmarks::sighting::cosine_sigma;
use crate::landmarks::track::Track;
use crate::landmarks::{Estimate, LandmarkMap, Noise, Sighting, Status};
use crate::odometry::{Odometry, mean_over_periods};
use crate::parameters::{Integration, Parameters};
use crate::pose::Pose;

/// Seconds of driving before landmarks are looked for first, and radians turned: mirror images part in turns.
const FIRST_S: f64 = 4.0;
const FIRST_TURN_RAD: f64 = 0.8;
/// Seconds after which they are looked for without a turn.
const FIRST_AT_MOST_S: f64 = 12.0;
/// Seconds between two estimates of the whole.
const GROWTH_S: f64 = 3.0;
/// Seconds until landmarks are looked for again when none were found that can be trusted.
const RETRY_S: f64 = 1.0;
/// Blocks for which a fit must be good to be sure, and bad to be lost.
const GOOD_BLOCKS: usize = 10;
const BAD_BLOCKS: usize = 15;
/// Times as many blocks are alike as in a known map: landmarks are learnt from the same echoes.
const ALIKE: f64 = 2.0;
/// Most blocks whose covariance is computed; those between have their neighbour's.
const MOST_COVARIANCES: usize = 500;
/// Variance of poses that nothing holds, m^2 and rad^2.
const UNKNOWN: f64 = 1e2;

/// Estimates a drive and its landmarks, without map or truth.
///
/// ```
/// use std::path::Path;
///
/// use localizer::landmarks::{self, Noise};
/// use localizer::slam::Slam;
/// use localizer::{Parameters, Recording, echo};
///
/// let drive = Recording::read(Path::new("../examples/site_robot/drive"))?;
/// let mut parameters = Parameters::default().for_recording(&drive.meta);
/// parameters.measurement.periods = landmarks::PERIODS;
/// let echoes = echo::measure(&drive, &parameters)?;
/// let mut slam = Slam::new(&parameters, drive.start_pose(), Noise::default());
/// for (index, block) in echoes.blocks.iter().enumerate() {
///     let newest = slam.update(block, echoes.recent_odometry(index));
///     println!("{:.2} s: {:?}, {:?}", newest.t_s, newest.pose, newest.status);
/// }
/// let drive = slam.finish();
/// println!("{} poses, {:?}", drive.estimates.len(), drive.map.map(|map| map.landmarks.len()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Slam {
    parameters: Parameters,
    noise: Noise,
    finder: PeakFinder,
    joint: Joint,
    map: Option<LandmarkMap>,
    /// The filter that follows the newest blocks among the landmarks found so far.
    track: Track,
    live: Vec<Newest>,
    /// Blocks at which the next estimate of the whole is due, and radians turned so far.
    next: usize,
    turned_rad: f64,
}

/// The newest block as the filter has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Newest {
    /// Instant in seconds.
    pub t_s: f64,
    /// Pose.
    pub pose: Pose,
    /// The pose carried to the end of the block, the newest sample, and that instant.
    pub latest: Pose,
    /// Instant of the newest sample in seconds.
    pub latest_s: f64,
    /// How far to trust it.
    pub status: Status,
    /// Share of the expected echoes found lately.
    pub fit: f64,
}

/// The drive as a whole.
#[derive(Debug, Clone)]
pub struct Drive {
    /// Every block's estimate; `latest` is what was known when the block was the newest one. Blocks behind the last
    /// estimate that could be trusted are `lost`.
    pub estimates: Vec<Estimate>,
    /// Status of every block when it was the newest one.
    pub live: Vec<Status>,
    /// The landmarks; none when none was found.
    pub map: Option<LandmarkMap>,
    /// What the wheels' turn rate (rad/s) and speed (part of one) always lack.
    pub wheel_errors: [f64; 2],
}

impl Slam {
    /// An estimator that starts at a pose, which says where the frame of the map is; `parameters` must pass
    /// [`Parameters::check`].
    pub fn new(parameters: &Parameters, start: Pose, noise: Noise) -> Self {
        // Ranges are metres by the set speed of sound; nothing else says how long a metre is.
        let noise = Noise {
            sound: 1e-6,
            alike_blocks: ALIKE * noise.alike_blocks,
            ..noise
        };
        let newest = Hypothesis::new(&start, START_SIGMA[0], START_SIGMA[1], &noise);
        Self {
            parameters: parameters.clone(),
            finder: PeakFinder::new(parameters),
            joint: Joint::new(start, noise),
            map: None,
            track: Track::of(vec![newest]),
            live: Vec::new(),
            next: 0,
            turned_rad: 0.0,
            noise,
        }
    }

    /// Takes a block in. Blocks must be given one by one in their order; `recent` is the odometry of the block's M
    /// periods, preceded by that of the period before if there is one.
    pub fn update(&mut self, block: &EchoBlock, recent: &[Odometry]) -> Newest {
        let sighting = (!block.stationary).then(|| {
            let v_mps = block.odometry.v_mps;
            let mut peaks = Vec::with_capacity(MOST_PEAKS);
            self.finder.find(block.intensity.view(), v_mps, &mut peaks);
            Sighting {
                pose: Pose::default(),
                motion: Motion::new(block.odometry, &self.parameters.signal),
                cosine_sigma: cosine_sigma(&self.parameters, v_mps),
                peaks,
            }
        });
        self.take(block.t_s, block.odometry, sighting, recent)
    }

    /// Takes in what a block at the instant `t_s` with the mean odometry `during` saw; none when the robot stood.
    pub fn take(
        &mut self,
        t_s: f64,
        during: Odometry,
        sighting: Option<Sighting>,
        recent: &[Odometry],
    ) -> Newest {
        let here = self.predict(recent);
        if let (Some(map), Some(sighting)) = (&self.map, &sighting) {
            let seen = Seen {
                peaks: &sighting.peaks,
                cosine_sigma: sighting.cosine_sigma,
                odometry: during,
                signal: &self.parameters.signal,
            };
            self.track.update(&seen, map, &self.noise);
        }
        self.joint.seen.push(sighting);
        self.joint.during.push(during);
        self.follow();
        self.turned_rad += (during.omega_radps * self.parameters.period_s()).abs();
        let blocks = self.joint.blocks();
        if self.is_due() {
            self.refine();
            let wait_s = if self.map.is_some() {
                GROWTH_S
            } else {
                RETRY_S
            };
            self.next = blocks + (wait_s / self.parameters.period_s()).ceil() as usize;
        }
        let pose = self.hypothesis().map_or(Pose::default(), Hypothesis::pose);
        let rest = recent.len() as f64 - here;
        let onward = mean_over_periods(recent, here, recent.len() as f64);
        let rest_s = rest * self.parameters.period_s();
        let newest = Newest {
            t_s,
            pose,
            latest: advance(&pose, self.mended(onward), rest_s, Integration::Midpoint),
            latest_s: t_s + rest_s,
            status: self.status(),
            fit: self.track.fit(),
        };
        self.live.push(newest);
        newest
    }

    fn hypothesis(&self) -> Option<&Hypothesis> {
        self.track.hypotheses.first()
    }

    /// Odometry less the errors of the wheels.
    fn mended(&self, odometry: Odometry) -> Odometry {
        let [turn_rate, speed] = self
            .hypothesis()
            .map_or([0.0; 2], |best| [best.state[3], best.state[4]]);
        Odometry {
            v_mps: odometry.v_mps * (1.0 + speed),
            omega_radps: odometry.omega_radps + turn_rate,
        }
    }

    /// Appends the filter's pose to the drive.
    fn follow(&mut self) {
        if let Some(best) = self.track.hypotheses.first() {
            let state = best.state;
            let [turn_rate, speed] = self.joint.graph.steady;
            self.joint.graph.nodes.push([
                state[0],
                state[1],
                state[2],
                state[3] - turn_rate,
                state[4] - speed,
            ]);
        }
    }

    fn status(&self) -> Status {
        if self.map.is_none() {
            Status::Converging
        } else if self.track.good >= GOOD_BLOCKS {
            Status::Sure
        } else if self.track.bad >= BAD_BLOCKS {
            Status::Lost
        } else {
            match self.live.last().map(|newest| newest.status) {
                Some(Status::Sure) if !self.track.is_single() => Status::Converging,
                Some(last) => last,
                None => Status::Converging,
            }
        }
    }

    fn is_due(&self) -> bool {
        let blocks = self.joint.blocks();
        let t_s = blocks as f64 * self.parameters.period_s();
        let turned = t_s >= FIRST_S && self.turned_rad >= FIRST_TURN_RAD;
        blocks >= self.next && (self.map.is_some() || turned || t_s >= FIRST_AT_MOST_S)
    }

    /// From the last block's instant, or from time 0, to this one's. Returns that instant in periods from the start of
    /// `recent`.
    fn predict(&mut self, recent: &[Odometry]) -> f64 {
        let reference = self.parameters.measurement.reference_periods();
        let (from, to) = if self.joint.blocks() > 0 {
            (reference, reference + 1.0)
        } else {
            (0.0, reference)
        };
        let mean = mean_over_periods(recent, from, to);
        let duration_s = (to - from) * self.parameters.period_s();
        self.track.predict(mean, duration_s, &self.noise);
        self.joint.graph.wheels.push((mean, duration_s));
        to
    }

    /// Estimates the drive so far, and goes on from there.
    fn refine(&mut self) {
        let newest = self.joint.refine();
        let Some(best) = self.track.hypotheses.first() else {
            return;
        };
        let mut best = best.clone();
        for (k, number) in newest.state.iter().enumerate() {
            best.state[k] = *number;
        }
        if let Some(known) = newest.covariance {
            best.covariance = Covariance::zeros();
            best.covariance
                .fixed_view_mut::<STATES, STATES>(0, 0)
                .copy_from(&known);
            best.covariance[(STATES, STATES)] = self.noise.sound.powi(2);
            self.map = self.joint.map(&self.parameters);
        }
        self.track.hypotheses = vec![best];
    }

    /// The landmarks found so far.
    pub fn map(&self) -> Option<&LandmarkMap> {
        self.map.as_ref()
    }

    /// Estimates the whole drive once more and returns it.
    pub fn finish(mut self) -> Drive {
        let blocks = self.joint.blocks();
        if blocks > 0 {
            self.refine();
        }
        let good = self.joint.good_blocks();
        let every = blocks.div_ceil(MOST_COVARIANCES).max(1);
        let chosen: Vec<usize> = (1..=blocks).step_by(every).collect();
        let unknown = Matrix3::identity() * UNKNOWN;
        let covariances = (good > 0)
            .then(|| self.joint.covariances(&chosen))
            .flatten()
            .unwrap_or_else(|| vec![unknown; chosen.len()]);
        let estimate = |(block, live): (usize, &Newest)| {
            let covariance = &covariances[block / every];
            let [turn_rate, speed] = self.joint.graph.wheel_errors(block + 1);
            Estimate {
                t_s: live.t_s,
                pose: self.joint.graph.pose(block + 1),
                covariance: [0, 1, 2].map(|row| [0, 1, 2].map(|column| covariance[(row, column)])),
                latest: live.latest,
                latest_s: live.latest_s,
                status: if block < good {
                    Status::Sure
                } else {
                    Status::Lost
                },
                fit: live.fit,
                hypotheses: 1,
                turn_rate_error_radps: turn_rate,
                speed_error: speed,
                speed_of_sound_mps: self.parameters.signal.speed_of_sound_mps,
            }
        };
        Drive {
            estimates: self.live.iter().enumerate().map(estimate).collect(),
            live: self.live.iter().map(|newest| newest.status).collect(),
            wheel_errors: self.joint.graph.steady,
            map: self.map,
        }
    }
}
