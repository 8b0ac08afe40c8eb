//! The clocks of a recording's logs: given, or found by the echoes and by matching speeds and turns.

use super::recording_source::RecordingSource;
use crate::align::{ClockSource, LogClock, PathKind, Tracks, match_logs};
use crate::echo::block_stream;
use crate::error::Error;
use crate::filter::motion_model::advance;
use crate::landmarks::peaks::PeakFinder;
use crate::odometry::{Odometry, OdometrySample};
use crate::parameters::{Integration, Parameters};
use crate::pose::Pose;
use crate::trajectory::Trajectory;

/// Periods of a block: ranges need no more.
const PERIODS: usize = 2;

/// Time from the first motion on whose echoes tell the wheels' clock, in seconds.
pub const WHEELS_S: f64 = 20.0;

/// Time whose echoes tell the truth's clock, in seconds.
const TRUTH_S: f64 = 60.0;

/// Time of the wheels' log in which their greatest speed is looked for, in seconds.
const SPEEDS_S: f64 = 15.0;

/// Least and greatest speed of echoes that are looked for, in m/s.
const SPEEDS_MPS: [f64; 2] = [0.5, 3.0];

/// Range rate of an echo that tells a robot that drives, in m/s.
const DRIVING_MPS: f64 = 0.06;

/// Time by which a log may end too early or begin too late, in seconds.
const SLACK_S: f64 = 1.0;

/// Where the truth may lie around what the wheels say, in seconds.
const AROUND_S: f64 = 0.4;

/// Finds the wheels' clock by the echoes of a drive's beginning.
pub struct WheelClock {
    finder: PeakFinder,
    parameters: Parameters,
    speed_mps: f64,
    tracks: Tracks,
    began_s: Option<f64>,
    peaks: Vec<crate::landmarks::peaks::Peak>,
}

impl WheelClock {
    /// For a recording with these parameters whose log begins with `odometry`.
    pub fn new(parameters: &Parameters, odometry: &[OdometrySample]) -> Self {
        let mut parameters = parameters.clone();
        parameters.measurement.periods = PERIODS;
        parameters.measurement.time_reference = crate::TimeReference::Centre;
        let first_s = odometry.first().map_or(0.0, |sample| sample.t_s);
        let fastest = odometry
            .iter()
            .take_while(|sample| sample.t_s <= first_s + SPEEDS_S)
            .fold(0.0_f64, |fastest, sample| fastest.max(sample.v_mps.abs()));
        Self {
            finder: PeakFinder::new(&parameters),
            speed_mps: (1.1 * fastest).clamp(SPEEDS_MPS[0], SPEEDS_MPS[1]),
            tracks: Tracks::new(parameters.signal.speed_of_sound_mps, PathKind::Wheels),
            parameters,
            began_s: None,
            peaks: Vec::new(),
        }
    }

    /// The parameters of the blocks.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The speed with which blocks are to be measured.
    pub fn odometry(&self) -> Odometry {
        Odometry {
            v_mps: self.speed_mps,
            omega_radps: 0.0,
        }
    }

    /// Takes a block. False when it and those after are not needed.
    pub fn push(&mut self, block: &crate::EchoBlock) -> bool {
        if block.stationary {
            return true;
        }
        let view = block.intensity.view();
        self.finder.find(view, self.speed_mps, &mut self.peaks);
        let drives = |cosine: f64| (cosine * self.speed_mps).abs() > DRIVING_MPS;
        if self.peaks.iter().filter(|peak| drives(peak.cosine)).count() >= 2 {
            self.began_s.get_or_insert(block.t_s);
        }
        if self
            .began_s
            .is_some_and(|began_s| block.t_s > began_s + WHEELS_S)
        {
            return false;
        }
        self.tracks.push(block.t_s, self.speed_mps, &self.peaks);
        true
    }

    /// What the wheels' clock shows at time 0 of the sound; none when the drive does not tell.
    pub fn find(&self, odometry: &[OdometrySample], duration_s: f64) -> Option<LogClock> {
        let path = dead_reckoned(odometry);
        let place = self.parameters.signal.sensor_offset_m;
        let range = readings(path.t_s.first(), path.t_s.last(), duration_s)?;
        let found = self.tracks.match_path(&path, place, range)?;
        Some(LogClock {
            reading_s: found.offset_s,
            sigma_s: found.sigma_s,
            source: ClockSource::Echoes,
        })
    }
}

/// Readings at time 0 of the sound at which a log from `first` to `last` covers the sound.
fn readings(first: Option<&f64>, last: Option<&f64>, duration_s: f64) -> Option<[f64; 2]> {
    let (first, last) = (first?, last?);
    let range = [first - SLACK_S, last - duration_s + SLACK_S];
    (range[0] <= range[1]).then_some(range)
}

/// The path by wheels alone, from the origin.
fn dead_reckoned(odometry: &[OdometrySample]) -> Trajectory {
    let mut path = Trajectory::default();
    let mut pose = Pose::default();
    for (index, sample) in odometry.iter().enumerate() {
        if let Some(before) = index.checked_sub(1).map(|before| odometry[before]) {
            let mean = Odometry {
                v_mps: 0.5 * (before.v_mps + sample.v_mps),
                omega_radps: 0.5 * (before.omega_radps + sample.omega_radps),
            };
            pose = advance(&pose, mean, sample.t_s - before.t_s, Integration::Midpoint);
        }
        path.t_s.push(sample.t_s);
        path.poses.push(pose);
    }
    path
}

impl RecordingSource {
    /// Puts the logs on the sound's clock.
    pub(super) fn find_logs(&mut self) -> Result<(), Error> {
        let late_s = self.alignment.sound.late_s;
        let given = |clock_s: Option<f64>| clock_s.map(|clock_s| LogClock::given(clock_s + late_s));
        let mut wheels = given(self.meta.odometry_clock_s);
        let mut truth = given(self.meta.truth_clock_s);
        let has_truth = self.truth.is_some();
        if wheels.is_none() || (truth.is_none() && has_truth) {
            let (clock, tracks) = self.tracks(has_truth && truth.is_none())?;
            if wheels.is_none() {
                wheels = clock.find(&self.odometry, self.duration_s());
            }
            if truth.is_none() {
                truth = self.truth_by_echoes(&tracks, wheels);
            }
            let by_motion = self.by_motion();
            // True poses tell more than a path by wheels, which slip.
            if let (Some(truth), Some((offset_s, sigma_s))) = (truth, by_motion) {
                let sigma_s = sigma_s.hypot(truth.sigma_s);
                if self.meta.odometry_clock_s.is_none()
                    && wheels.is_none_or(|wheels| sigma_s < wheels.sigma_s)
                {
                    wheels = Some(LogClock {
                        reading_s: truth.reading_s - offset_s,
                        sigma_s,
                        source: ClockSource::Motion,
                    });
                }
            }
            if let (Some(wheels), None, Some((offset_s, sigma_s))) = (wheels, truth, by_motion) {
                truth = Some(LogClock {
                    reading_s: wheels.reading_s + offset_s,
                    sigma_s,
                    source: ClockSource::Motion,
                });
            }
        }
        let first_s = self.odometry.first().map(|sample| sample.t_s);
        let last_s = self.odometry.last().map(|sample| sample.t_s);
        let wheels = self.believed(wheels, "odometry", [first_s, last_s])?;
        for sample in &mut self.odometry {
            sample.t_s -= wheels.reading_s;
        }
        self.alignment.odometry = wheels;
        self.meta.odometry_clock_s = Some(wheels.reading_s);
        self.meta.truth_clock_s = Some(0.0);
        if let Some(path) = &self.truth {
            let ends = [path.t_s.first().copied(), path.t_s.last().copied()];
            let truth = self.believed(truth, "truth", ends)?;
            for t_s in self.truth.iter_mut().flat_map(|truth| &mut truth.t_s) {
                *t_s -= truth.reading_s;
            }
            self.alignment.truth = Some(truth);
            self.meta.truth_clock_s = Some(truth.reading_s);
        }
        Ok(())
    }

    /// A clock, or the sound's own where its log suits it.
    fn believed(
        &self,
        clock: Option<LogClock>,
        name: &str,
        ends: [Option<f64>; 2],
    ) -> Result<LogClock, Error> {
        if let Some(clock) = clock {
            return Ok(clock);
        }
        let late_s = self.alignment.sound.late_s;
        if let [Some(first_s), Some(last_s)] = ends
            && first_s <= late_s + SLACK_S
            && last_s >= late_s + self.duration_s() - SLACK_S
            && first_s > -10.0 * SLACK_S
        {
            return Ok(LogClock {
                source: ClockSource::Assumed,
                ..LogClock::given(late_s)
            });
        }
        let problem = "neither echoes nor speeds and turns tell it";
        let remedy = format!(
            "give what the clock of the {name} shows at the first sample of signal.wav, or record a drive with turns \
            and changes of speed"
        );
        Err(Error::invalid(
            self.folder.join("recording.json").display(),
            format!("{name}_clock_s"),
            problem,
            remedy,
        ))
    }

    /// Follows the echoes of the drive's beginning, for the wheels and, if `long`, for the truth.
    fn tracks(&self, long: bool) -> Result<(WheelClock, Tracks), Error> {
        let mut parameters = Parameters::default().for_recording(&self.meta);
        let signal = &parameters.signal;
        let longest_m = signal.range_of_delay_m(signal.samples_per_period() as f64 - 1.0);
        parameters.measurement.max_range_m = parameters.measurement.max_range_m.min(longest_m);
        let mut clock = WheelClock::new(&parameters, &self.odometry);
        let parameters = clock.parameters().clone();
        let speed = clock.odometry();
        let mut all = Tracks::new(parameters.signal.speed_of_sound_mps, PathKind::Truth);
        let mut finder = PeakFinder::new(&parameters);
        let mut peaks = Vec::new();
        let mut sound = self.sound()?;
        block_stream::measure_each(
            &parameters,
            &mut || sound.next_period(),
            &|_| speed,
            &mut |block, _| {
                let more = clock.push(block);
                if long && !block.stationary {
                    finder.find(block.intensity.view(), speed.v_mps, &mut peaks);
                    all.push(block.t_s, speed.v_mps, &peaks);
                }
                Ok(more || (long && block.t_s < TRUTH_S))
            },
        )?;
        Ok((clock, all))
    }

    fn truth_by_echoes(&self, tracks: &Tracks, wheels: Option<LogClock>) -> Option<LogClock> {
        let truth = self.truth.as_ref()?;
        let mut range = readings(truth.t_s.first(), truth.t_s.last(), self.duration_s())?;
        if let (Some(wheels), Some((offset_s, _))) = (wheels, self.by_motion()) {
            let middle = wheels.reading_s + offset_s;
            range = [
                range[0].max(middle - AROUND_S),
                range[1].min(middle + AROUND_S),
            ];
        }
        let place = self.meta.sensor_offset_m();
        let found = tracks.match_path(truth, place, range)?;
        Some(LogClock {
            reading_s: found.offset_s,
            sigma_s: found.sigma_s,
            source: ClockSource::Echoes,
        })
    }

    /// What the truth's clock shows when the wheels' shows 0, and its standard deviation, by speeds and turns.
    fn by_motion(&self) -> Option<(f64, f64)> {
        let found = match_logs(&self.odometry, self.truth.as_ref()?)?;
        Some((found.offset_s, found.sigma_s))
    }
}
