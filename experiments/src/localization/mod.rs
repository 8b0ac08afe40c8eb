//! Localization of whole drives and of streams, by every method: what the command line and the Python package share.

mod stream;

use anyhow::{Result, bail};
use localizer::echo::EchoBlock;
use localizer::landmarks::{self, LandmarkMap, LandmarkTracker, Noise, Start, Status};
use localizer::quality::{CodeMeter, Fit, FitMeter};
use localizer::{Estimate, MapImage, Method, Parameters, Pose, offline, slam};

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

/// Looks on: is given every block and the poses that are possible after it.
pub type LookOn<'a> = dyn FnMut(&EchoBlock, &[Pose]) + 'a;

/// Is told the number of blocks done, that of all, the newest block, and what is known so far.
pub type EachOfSlam<'a> = dyn FnMut([u64; 2], &EchoBlock, &slam::Slam) -> Result<()> + 'a;

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
    look_on: &mut LookOn<'_>,
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
        look_on(block, tracker.filter().particles());
        estimates.push(estimate);
        Ok(true)
    })?;
    Ok(ByImages {
        estimates,
        fits: meter.finish(),
        code: trust::check_echoes(drive.meta(), &code, &drive.name, warnings)?,
    })
}

/// Localizes a whole drive among landmarks, block by block.
///
/// # Errors
/// As [`by_images`], and when the robot never moves fast enough for a pose.
pub fn among_landmarks(
    drive: &Drive<'_>,
    map: &LandmarkMap,
    parameters: &Parameters,
    start: &Start,
    warnings: &mut Warnings,
    look_on: &mut LookOn<'_>,
) -> Result<Vec<landmarks::Estimate>> {
    drive.check_signal()?;
    let mut tracker = LandmarkTracker::new(parameters, start, Noise::default());
    let mut code = CodeMeter::new(parameters);
    let (mut estimates, mut poses) = (Vec::new(), Vec::new());
    drive.measure_each(parameters, &mut |block, recent| {
        code.add(block);
        estimates.extend(tracker.update(block, recent, map));
        poses.clear();
        poses.extend(tracker.filter().hypotheses().iter().map(|own| own.pose()));
        look_on(block, &poses);
        Ok(true)
    })?;
    trust::check_echoes(drive.meta(), &code, &drive.name, warnings)?;
    if estimates.is_empty() {
        bail!("the robot does not move fast enough for a pose; record it driving");
    }
    Ok(estimates)
}

/// Estimates a whole drive and its landmarks without a map, block by block.
///
/// # Errors
/// As [`by_images`], and that of `each`, which ends the work.
pub fn without_map(
    drive: &Drive<'_>,
    parameters: &Parameters,
    start: Pose,
    warnings: &mut Warnings,
    each: &mut EachOfSlam<'_>,
) -> Result<slam::Drive> {
    drive.check_signal()?;
    let mut estimator = slam::Slam::new(parameters, start, Noise::default());
    let mut code = CodeMeter::new(parameters);
    let periods = (drive.duration_s() / parameters.period_s()) as u64;
    let all = (periods + 1).saturating_sub(parameters.measurement.periods as u64);
    let (mut done, mut ended) = (0, Ok(()));
    drive.measure_each(parameters, &mut |block, recent| {
        code.add(block);
        estimator.update(block, recent);
        done += 1;
        ended = each([done, all.max(done)], block, &estimator);
        Ok(ended.is_ok())
    })?;
    ended?;
    trust::check_echoes(drive.meta(), &code, &drive.name, warnings)?;
    Ok(estimator.finish())
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
