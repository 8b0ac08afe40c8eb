//! Localization of whole drives and of streams, by every method: what the command line and the Python package share.

mod stream;

use anyhow::{Result, bail};
use localizer::landmarks::{self, LandmarkMap, Noise, Start, Status};
use localizer::quality::{CodeMeter, Fit, FitMeter};
use localizer::{Estimate, MapImage, Method, Parameters, Pose, echo, offline, slam};

pub use self::stream::{Stream, Told};
use crate::drive::Drive;
use crate::trust::{self, Warnings};

/// Standard deviations of a start that is given or that truth gives, in metres and radians.
pub const START_SIGMA: [f64; 2] = [0.01, 0.02];

/// What an estimate by images rests on: the wheels alone, too slow a robot for bearings, or echoes.
pub fn status(estimate: &Estimate, by_wheels: bool) -> &'static str {
    match (by_wheels, estimate.stationary) {
        (true, _) => "wheels",
        (false, true) => "slow",
        (false, false) => "echoes",
    }
}

/// The name of a status among landmarks.
pub fn status_name(status: Status) -> &'static str {
    match status {
        Status::Sure => "sure",
        Status::Converging => "converging",
        Status::Lost => "lost",
    }
}

/// Estimates of a whole drive by echo images.
#[derive(Debug)]
pub struct ByImages {
    /// One estimate a block.
    pub estimates: Vec<Estimate>,
    /// How well each fits the map.
    pub fits: Vec<Fit>,
    /// Share of the blocks in which the code is; none of a robot that rests.
    pub code: Option<f64>,
}

/// Localizes a whole drive by echo images from a start, block by block, so that memory does not grow with the drive.
///
/// # Errors
/// When the sound holds no echoes, the parameters cannot be used, or the map has other cells.
pub fn by_images(
    drive: &Drive<'_>,
    map: &MapImage,
    parameters: &Parameters,
    (start, seed): (Pose, u64),
    warnings: &mut Warnings,
) -> Result<ByImages> {
    drive.check_signal()?;
    let mut tracker = offline::tracker(parameters, map, parameters, start, seed)?;
    let mut meter = FitMeter::new(parameters, map);
    let mut code = CodeMeter::new(parameters);
    let mut estimates = Vec::new();
    drive.measure_each(parameters, &mut |block, recent| {
        let estimate = tracker.update(block, recent, map);
        code.add(block);
        meter.add(block, &estimate);
        estimates.push(estimate);
        Ok(true)
    })?;
    Ok(ByImages {
        estimates,
        fits: meter.finish(),
        code: trust::check_echoes(drive.meta(), &code, &drive.name, warnings)?,
    })
}

/// Localizes a whole drive among landmarks.
///
/// # Errors
/// As [`by_images`], and when the robot never moves fast enough for a pose.
pub fn among_landmarks(
    drive: &Drive<'_>,
    map: &LandmarkMap,
    parameters: &Parameters,
    start: &Start,
    warnings: &mut Warnings,
) -> Result<Vec<landmarks::Estimate>> {
    let echoes = measured(drive, parameters, warnings)?;
    let estimates = landmarks::localize(&echoes, map, start, Noise::default());
    if estimates.is_empty() {
        bail!("the robot does not move fast enough for a pose; record it driving");
    }
    Ok(estimates)
}

/// Estimates a whole drive and its landmarks without a map; `each` is told the number of blocks done and of all.
///
/// # Errors
/// As [`by_images`].
pub fn without_map(
    drive: &Drive<'_>,
    parameters: &Parameters,
    start: Pose,
    warnings: &mut Warnings,
    each: &mut dyn FnMut(u64, u64) -> Result<()>,
) -> Result<slam::Drive> {
    let echoes = measured(drive, parameters, warnings)?;
    let mut estimator = slam::Slam::new(parameters, start, Noise::default());
    for (index, block) in echoes.blocks.iter().enumerate() {
        estimator.update(block, echoes.recent_odometry(index));
        each(index as u64 + 1, echoes.blocks.len() as u64)?;
    }
    Ok(estimator.finish())
}

/// The echoes of a drive that holds some.
fn measured(
    drive: &Drive<'_>,
    parameters: &Parameters,
    warnings: &mut Warnings,
) -> Result<echo::EchoSequence> {
    drive.check_signal()?;
    let echoes = echo::measure(drive.load()?.as_ref(), parameters)?;
    let code = CodeMeter::of(&echoes);
    trust::check_echoes(drive.meta(), &code, &drive.name, warnings)?;
    Ok(echoes)
}

/// Parameters of a localization by echo images: `base`, or those of the map, with the waveform of the drive.
pub fn image_parameters(
    base: Option<&Parameters>,
    map: &MapImage,
    drive: &Drive<'_>,
    method: Method,
) -> Parameters {
    let mut parameters = base.unwrap_or(&map.parameters).for_recording(drive.meta());
    parameters.filter.method = method;
    parameters
}
