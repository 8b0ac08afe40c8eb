//! Localization over a whole drive whose echoes are measured: the loop of the streaming localizer without its front
//! end.

use crate::echo::echo_blocks::EchoSequence;
use crate::error::Error;
use crate::filter::tracker::{Estimate, Tracker};
use crate::image::map_image::MapImage;
use crate::io::recording_source::RecordingSource;
use crate::parameters::Parameters;
use crate::pose::Pose;
use crate::trajectory::Trajectory;

/// Estimates the pose at every block, with the result that [`crate::Localizer::step`] gives for the same samples.
///
/// `parameters` may differ from those of the measurement in everything that the filter alone uses, and as
/// [`MeasurementParameters::provides`](crate::parameters::MeasurementParameters::provides) says.
///
/// # Errors
/// [`Error::Invalid`] for parameters that cannot be used or need another measurement, a map with other cells, or a
/// start that is not finite.
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

/// As [`localize`] for a recording that is opened but not read: blocks are measured a few at a time, so that memory
/// does not grow with the sound.
///
/// # Errors
/// As [`crate::echo::measure`] and [`localize`].
pub fn localize_source(
    source: &RecordingSource,
    map: &MapImage,
    parameters: &Parameters,
    start: Pose,
    seed: u64,
) -> Result<Vec<Estimate>, Error> {
    let mut tracker = tracker(parameters, map, parameters, start, seed)?;
    let mut estimates = Vec::new();
    source.measure_each(parameters, &mut |block, recent| {
        estimates.push(tracker.update(block, recent, map));
        Ok(true)
    })?;
    Ok(estimates)
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
    if measured.signal == wanted.signal && measured.measurement.provides(&wanted.measurement) {
        return Ok(());
    }
    let problem = "the echoes were measured with other values of waveform, periods, directions or direct wave";
    Err(Error::invalid(
        "parameters",
        "measurement",
        problem,
        "measure the echoes with these parameters",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::each_field_changed;

    #[test]
    fn every_field_of_the_filter_may_differ_from_the_measurement_and_no_other_but_those_of_images()
    {
        let measured = Parameters::default();
        for (name, wanted) in each_field_changed(&measured) {
            let of_the_filter =
                wanted.signal == measured.signal && wanted.measurement == measured.measurement;
            assert_ne!(of_the_filter, wanted.filter == measured.filter, "{name}");
            let of_images = ["cell_m", "min_range_m", "max_range_m"].contains(&name.as_str());
            assert_eq!(
                check_measurement(&measured, &wanted).is_ok(),
                of_the_filter || of_images,
                "{name}"
            );
        }
        let mut farther = measured.clone();
        farther.measurement.max_range_m += 0.1;
        assert!(check_measurement(&measured, &farther).is_err());
    }
}
