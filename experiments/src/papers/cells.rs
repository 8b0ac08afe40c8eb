//! Trials of the cells that several studies have, and their names in data files.

use localizer::parameters::FilterParameters;
use localizer::{Method, Parameters};

use crate::trials::Trial;

/// Trials `0..count` of the Doppler method with the scene's scheme and these parameters.
pub(super) fn doppler_trials(parameters: &Parameters, count: usize) -> Vec<Trial> {
    trials_of(parameters, Method::Doppler, count)
}

/// Trials `0..count` of a method with the scene's scheme.
pub(super) fn trials_of(parameters: &Parameters, method: Method, count: usize) -> Vec<Trial> {
    (0..count as u64)
        .map(|trial| {
            let filter = FilterParameters {
                method,
                ..parameters.filter
            };
            let parameters = Parameters {
                filter,
                ..parameters.clone()
            };
            Trial::new(parameters, trial)
        })
        .collect()
}

/// Name of a method in data files.
pub(super) fn method_name(method: Method) -> &'static str {
    match method {
        Method::Doppler => "doppler",
        Method::ToaOnly => "toa-only",
        Method::Odometry => "odometry",
    }
}
