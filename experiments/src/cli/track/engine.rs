//! The localizer behind `track`: by echo images or by landmarks.

use localizer::landmarks::{LandmarkLocalizer, Status};
use localizer::parameters::SignalParameters;
use localizer::{Error, Localizer, Odometry, Pose};

use super::view::{self, Echo};

/// A pose as it is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Told {
    pub(super) t_s: f64,
    pub(super) pose: Pose,
    pub(super) covariance: [[f64; 3]; 3],
    pub(super) latest_s: f64,
    pub(super) latest: Pose,
    pub(super) status: &'static str,
    /// Effective share of particles, or of the expected echoes that were found.
    pub(super) fit: f64,
}

/// A streaming localizer.
pub(super) enum Engine {
    Images {
        localizer: Box<Localizer>,
        particles: f64,
        /// Time from a block's instant to its end in seconds.
        rest_s: f64,
        by_wheels: bool,
        signal: SignalParameters,
    },
    Landmarks(Box<LandmarkLocalizer>),
}

impl Engine {
    /// One period in, at most one pose out.
    pub(super) fn step(
        &mut self,
        samples: &[f32],
        heard: bool,
        odometry: Odometry,
    ) -> Result<Option<Told>, Error> {
        match self {
            Self::Images {
                localizer,
                particles,
                rest_s,
                by_wheels,
                ..
            } => Ok(localizer
                .step_period(samples, heard, odometry)?
                .map(|estimate| Told {
                    t_s: estimate.t_s,
                    pose: estimate.pose,
                    covariance: estimate.covariance,
                    latest_s: estimate.t_s + *rest_s,
                    latest: estimate.latest,
                    status: super::super::estimates::status(&estimate, *by_wheels),
                    fit: estimate.effective_sample_size / *particles,
                })),
            Self::Landmarks(localizer) => {
                Ok(localizer
                    .step_period(samples, heard, odometry)?
                    .map(|estimate| Told {
                        t_s: estimate.t_s,
                        pose: estimate.pose,
                        covariance: estimate.covariance,
                        latest_s: estimate.latest_s,
                        latest: estimate.latest,
                        status: match estimate.status {
                            Status::Sure => "sure",
                            Status::Converging => "converging",
                            Status::Lost => "lost",
                        },
                        fit: estimate.fit,
                    }))
            }
        }
    }

    /// The newest echoes: the largest of every direction and tenth of a metre, or the peaks.
    pub(super) fn picture(&self) -> Vec<Echo> {
        match self {
            Self::Images {
                localizer, signal, ..
            } => view::of_block(&localizer.echoes().intensity, signal),
            Self::Landmarks(localizer) => (localizer.tracker().peaks().iter())
                .map(|peak| Echo {
                    range_m: peak.range_m,
                    cosine: peak.cosine,
                    height: peak.amplitude,
                })
                .collect(),
        }
    }
}
