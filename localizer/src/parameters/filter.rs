//! Parameters of the filter: they change neither echoes nor maps.

use super::choices::{Integration, Method, Resampling};

/// Method, matched window, particles, noise, weights, resampling and start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterParameters {
    /// How the pose is estimated.
    pub method: Method,
    /// Half width N_W dx_m of the matched images in metres.
    pub window_half_width_m: f64,
    /// Particles N_s.
    pub particles: usize,
    /// Standard deviation of the speed in eq. (8) in m/s.
    pub sigma_v_mps: f64,
    /// Standard deviation of the turning rate in eq. (8) in rad/s.
    pub sigma_omega_radps: f64,
    /// Highest bin K of the quantized images, so that there are K + 1 of them; at most 255.
    pub bins: usize,
    /// How the motion model integrates one step.
    pub integration: Integration,
    /// Weights are the mutual information to this power; 1 is eq. (17).
    pub likelihood_exponent: f64,
    /// How the next particles are drawn by their weights.
    pub resampling: Resampling,
    /// Resample when the effective sample size is at most this fraction of N_s; 1 is always.
    pub resample_threshold: f64,
    /// Standard deviation of the first particles' coordinates in metres; 0 is a known start.
    pub start_sigma_m: f64,
    /// Standard deviation of the first particles' headings in radians; 0 is a known start.
    pub start_sigma_rad: f64,
}

impl Default for FilterParameters {
    fn default() -> Self {
        Self {
            method: Method::default(),
            window_half_width_m: 4.0,
            particles: 100,
            sigma_v_mps: 0.0004,
            sigma_omega_radps: 0.09,
            bins: 127,
            integration: Integration::default(),
            likelihood_exponent: 1.0,
            resampling: Resampling::default(),
            resample_threshold: 1.0,
            start_sigma_m: 0.0,
            start_sigma_rad: 0.0,
        }
    }
}
