//! A recording: microphone signal and wheel odometry of one drive.
//!
//! As a folder it holds `signal.wav` (mono), `odometry.csv` (`t_s,v_mps,omega_radps`), `recording.json`
//! ([`RecordingMeta`]) and, if known, `truth.tum` (true poses) and `direct.wav` (the same drive without walls). Time
//! 0 is the first sample, which is also the first of a period of the transmitted signal.

mod meta;

pub use meta::RecordingMeta;

use crate::error::Error;
use crate::odometry::{self, Odometry, OdometrySample};
use crate::pose::Pose;
use crate::trajectory::Trajectory;

/// Signal, odometry and, if known, truth of one drive.
///
/// ```
/// use std::path::Path;
///
/// use localizer::Recording;
///
/// let recording = Recording::read(Path::new("../examples/site_robot/drive"))?;
/// assert!((recording.meta.sample_rate_hz - 48_005.9).abs() < 0.1);
/// assert!((recording.duration_s() - 14.4).abs() < 0.2);
/// # Ok::<(), localizer::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Microphone signal at f_s.
    pub signal: Vec<f32>,
    /// The same drive without walls, as long as `signal`.
    pub direct: Option<Vec<f32>>,
    /// Speeds over time, increasing in time.
    pub odometry: Vec<OdometrySample>,
    /// True poses.
    pub truth: Option<Trajectory>,
    /// Periods in which the direct wave was not heard, in increasing order: no echo of theirs counts.
    pub unheard: Vec<usize>,
    /// Waveform, rate, speed of sound, start.
    pub meta: RecordingMeta,
}

impl Recording {
    /// Checks that signal, direct wave and odometry fit together.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a field of [`RecordingMeta`] that cannot be used, samples that are not finite, a direct
    /// wave of another length, and odometry that is unsorted, not finite, has gaps above one second, or does not cover
    /// the signal.
    pub fn check(&self, origin: &str) -> Result<(), Error> {
        self.meta.check(&format!("{origin}: recording.json"))?;
        for (name, samples) in [
            ("signal.wav", Some(&self.signal)),
            ("direct.wav", self.direct.as_ref()),
        ] {
            if let Some(place) =
                samples.and_then(|samples| samples.iter().position(|sample| !sample.is_finite()))
            {
                let problem = format!("sample {place} is not a finite number");
                return Err(Error::invalid(
                    origin,
                    name,
                    problem,
                    "repair or cut the recording",
                ));
            }
        }
        if let Some(direct) = &self.direct
            && direct.len() != self.signal.len()
        {
            let problem = format!(
                "has {} samples, signal.wav has {}",
                direct.len(),
                self.signal.len()
            );
            return Err(Error::invalid(
                origin,
                "direct.wav",
                problem,
                "make both equally long, or remove direct.wav",
            ));
        }
        let fastest_mps = 0.1 * self.meta.speed_of_sound_mps;
        odometry::check_samples(&self.odometry, self.duration_s(), fastest_mps, origin)
    }

    /// Duration of the signal in seconds.
    pub fn duration_s(&self) -> f64 {
        self.signal.len() as f64 / self.meta.sample_rate_hz
    }

    /// Mean odometry of each of the first `count` periods of `period_s` seconds.
    pub fn odometry_per_period(&self, period_s: f64, count: usize) -> Vec<Odometry> {
        (0..count)
            .map(|n| {
                odometry::mean_over_time(
                    &self.odometry,
                    n as f64 * period_s,
                    (n + 1) as f64 * period_s,
                )
            })
            .collect()
    }

    /// The pose at time 0: the truth where it covers it, else the start in `recording.json`, else the origin.
    pub fn start_pose(&self) -> Pose {
        self.known_start().unwrap_or_default()
    }

    /// As [`Self::start_pose`], but `None` instead of the origin.
    pub fn known_start(&self) -> Option<Pose> {
        let truth = self.truth.as_ref();
        let truth = truth.and_then(|truth| truth.covered_pose_at(0.0));
        truth.or(self.meta.start)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::parameters::Parameters;

    /// A recording of a fifth of a second with all that a folder may hold.
    pub(crate) fn recording() -> Recording {
        let parameters = Parameters::default();
        let sample = |t_s: f64| OdometrySample {
            t_s,
            v_mps: 0.3,
            omega_radps: 0.01,
        };
        Recording {
            signal: (0..8184).map(|k| (k as f32 * 0.3).sin()).collect(),
            direct: Some(vec![0.25; 8184]),
            odometry: (0..=5).map(|k| sample(0.05 * f64::from(k))).collect(),
            truth: Some(Trajectory {
                t_s: vec![0.0],
                poses: vec![Pose {
                    x_m: 1.0,
                    y_m: 2.0,
                    heading_rad: 0.5,
                }],
            }),
            unheard: Vec::new(),
            meta: RecordingMeta {
                start: Some(Pose::default()),
                ..RecordingMeta::from_parameters(&parameters)
            },
        }
    }

    #[test]
    fn the_start_is_truth_then_meta_then_origin() {
        let mut recording = recording();
        recording.truth = None;
        recording.meta.start = Some(Pose {
            x_m: 3.0,
            ..Pose::default()
        });
        assert_eq!(recording.start_pose().x_m, 3.0);
        recording.meta.start = None;
        assert_eq!(recording.start_pose(), Pose::default());
    }
}
