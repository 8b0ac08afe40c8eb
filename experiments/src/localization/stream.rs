//! A streaming localizer by either kind of map, with estimates in one form.

use localizer::landmarks::{LandmarkLocalizer, LandmarkMap, Noise, Start};
use localizer::{
    Error, Estimate, Localizer, MapImage, Method, Odometry, Parameters, Pose, landmarks,
};

use super::{status, status_name};

/// An estimate of either method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Told {
    /// Instant of the pose in seconds.
    pub t_s: f64,
    /// The pose.
    pub pose: Pose,
    /// Covariance of x, y (m) and heading (rad).
    pub covariance: [[f64; 3]; 3],
    /// Instant of the newest sample in seconds.
    pub latest_s: f64,
    /// The pose at the newest sample.
    pub latest: Pose,
    /// What it rests on (`echoes`, `slow`, `wheels`), or how far to trust it (`sure`, `converging`, `lost`).
    pub status: &'static str,
    /// Effective share of particles, or of the expected echoes that were found.
    pub fit: f64,
}

impl Told {
    /// An estimate by images with these parameters.
    pub fn of_images(estimate: &Estimate, parameters: &Parameters) -> Self {
        let measurement = &parameters.measurement;
        let rest = measurement.periods as f64 - measurement.reference_periods();
        let by_wheels = parameters.filter.method == Method::Odometry;
        Self {
            t_s: estimate.t_s,
            pose: estimate.pose,
            covariance: estimate.covariance,
            latest_s: estimate.t_s + rest * parameters.period_s(),
            latest: estimate.latest,
            status: status(estimate, by_wheels),
            fit: estimate.effective_sample_size / parameters.filter.particles as f64,
        }
    }
}

impl From<&landmarks::Estimate> for Told {
    fn from(estimate: &landmarks::Estimate) -> Self {
        Self {
            t_s: estimate.t_s,
            pose: estimate.pose,
            covariance: estimate.covariance,
            latest_s: estimate.latest_s,
            latest: estimate.latest,
            status: status_name(estimate.status),
            fit: estimate.fit,
        }
    }
}

/// A streaming localizer.
pub enum Stream {
    /// By echo images, with its parameters.
    Images(Box<(Localizer, Parameters)>),
    /// Among landmarks.
    Landmarks(Box<LandmarkLocalizer>),
}

impl Stream {
    /// By echo images, from a start.
    ///
    /// # Errors
    /// As [`Localizer::new`].
    pub fn by_images(
        parameters: Parameters,
        map: MapImage,
        start: Pose,
        seed: u64,
    ) -> Result<Self, Error> {
        let localizer = Localizer::new(&parameters, map, start, seed)?;
        Ok(Self::Images(Box::new((localizer, parameters))))
    }

    /// Among landmarks.
    ///
    /// # Errors
    /// As [`LandmarkLocalizer::new`].
    pub fn among_landmarks(
        parameters: &Parameters,
        map: LandmarkMap,
        start: &Start,
    ) -> Result<Self, Error> {
        let localizer = LandmarkLocalizer::new(parameters, map, start, Noise::default())?;
        Ok(Self::Landmarks(Box::new(localizer)))
    }

    /// One period in, at most one estimate out; with `heard` false the samples are a gap of the sound.
    ///
    /// # Errors
    /// As [`Localizer::step_period`].
    pub fn step(
        &mut self,
        samples: &[f32],
        heard: bool,
        odometry: Odometry,
    ) -> Result<Option<Told>, Error> {
        match self {
            Self::Images(images) => {
                let (localizer, parameters) = images.as_mut();
                let estimate = localizer.step_period(samples, heard, odometry)?;
                Ok(estimate.map(|estimate| Told::of_images(&estimate, parameters)))
            }
            Self::Landmarks(localizer) => {
                let estimate = localizer.step_period(samples, heard, odometry)?;
                Ok(estimate.as_ref().map(Told::from))
            }
        }
    }
}
