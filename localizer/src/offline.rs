//! Localization of a whole drive whose echoes are measured: the loop of the streaming localizer without its front end.

use crate::echo::echo_blocks::EchoSequence;
use crate::error::Error;
use crate::filter::tracker::{Estimate, Tracker};
use crate::image::map_image::MapImage;
use crate::parameters::Parameters;
use crate::pose::Pose;
use crate::trajectory::Trajectory;

/// Estimates the pose at every block, with the result that [`crate::Localizer::step`] gives for the same samples.
///
/// `parameters` may differ from those of the measurement in everything that the filter alone uses (method, window,
/// particles, ranges up to the measured one, and so on).
///
/// # Errors
/// [`Error::Invalid`] for parameters that cannot be used or need another measurement, a map with other cells, or a start
/// that is not finite.
pub fn localize(
    echoes: &EchoSequence,
    map: &MapImage,
    parameters: &Parameters,
    start: Pose,
    seed: u64,
) -> Result<Vec<Estimate>, Error> {
    let mut tracker = tracker(&echoes.parameters, map, parameters, start, seed)?;
    Ok(echoes
        .blocks
        .iter()
        .enumerate()
        .map(|(index, block)| tracker.update(block, echoes.recent_odometry(index), map))
        .collect())
}

/// A tracker for blocks of echoes that were measured with the parameters `measured`, to be matched with `map`.
///
/// # Errors
/// As [`localize`].
pub fn tracker(
    measured: &Parameters,
    map: &MapImage,
    parameters: &Parameters,
    start: Pose,
    seed: u64,
) -> Result<Tracker, Error> {
    check_measurement(measured, parameters)?;
    map.check(parameters)?;
    Tracker::new(parameters, start, seed)
}

/// The expected poses of a run as a trajectory.
pub fn trajectory(estimates: &[Estimate]) -> Trajectory {
    Trajectory {
        t_s: estimates.iter().map(|estimate| estimate.t_s).collect(),
        poses: estimates.iter().map(|estimate| estimate.pose).collect(),
    }
}

/// Refuses parameters under which the echoes would have been measured differently.
fn check_measurement(measured: &Parameters, wanted: &Parameters) -> Result<(), Error> {
    let of_measurement = |parameters: &Parameters| Parameters {
        // What only maps and filters use:
        method: measured.method,
        cell_m: measured.cell_m,
        window_half_width_m: measured.window_half_width_m,
        particles: measured.particles,
        sigma_v_mps: measured.sigma_v_mps,
        sigma_omega_radps: measured.sigma_omega_radps,
        bins: measured.bins,
        min_range_m: measured.min_range_m,
        integration: measured.integration,
        likelihood_exponent: measured.likelihood_exponent,
        resample_threshold: measured.resample_threshold,
        start_sigma_m: measured.start_sigma_m,
        start_sigma_rad: measured.start_sigma_rad,
        // A shorter range is a part of the measured one.
        max_range_m: parameters.max_range_m.max(measured.max_range_m),
        ..parameters.clone()
    };
    if of_measurement(wanted) != *measured {
        let problem = "the echoes were measured with other values of waveform, periods, directions or direct wave";
        return Err(Error::invalid(
            "parameters",
            "measurement",
            problem,
            "measure the echoes with these parameters",
        ));
    }
    Ok(())
}
