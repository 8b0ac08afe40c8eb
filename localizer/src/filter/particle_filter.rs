//! Particle filter: motion with noise, eq. (8), weights from mutual information, eqs. (9)-(17), expected pose, eq.
//! (18).

use ndarray::ArrayView2;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::filter::motion_model::advance;
use crate::filter::resampling::{effective_sample_size, multinomial, systematic};
use crate::image::map_image::MapImage;
use crate::likelihood::particle_likelihood::ParticleLikelihood;
use crate::odometry::Odometry;
use crate::parameters::{Parameters, Resampling};
use crate::pose::{Pose, wrap_angle};
use crate::random;

/// Weighted candidates of the pose.
///
/// ```
/// use localizer::filter::particle_filter::ParticleFilter;
/// use localizer::{Odometry, Parameters, Pose};
///
/// let mut parameters = Parameters::default();
/// parameters.filter.start_sigma_m = 0.2;
/// let mut filter = ParticleFilter::new(&parameters, Pose::default(), 1);
/// filter.predict(Odometry { v_mps: 1.0, omega_radps: 0.0 }, 1.0);
/// // A likelihood that favours x = 1.1 m.
/// let likelihoods: Vec<f64> = filter
///     .particles()
///     .iter()
///     .map(|pose| (-((pose.x_m - 1.1) / 0.05).powi(2)).exp())
///     .collect();
/// filter.weigh_by(&likelihoods);
/// assert!((filter.expectation().pose.x_m - 1.1).abs() < 0.05);
/// filter.resample();
/// ```
pub struct ParticleFilter {
    parameters: Parameters,
    particles: Vec<Pose>,
    weights: Vec<f64>,
    motion: ChaCha8Rng,
    draws: ChaCha8Rng,
    likelihood: ParticleLikelihood,
    parents: Vec<usize>,
    drawn: Vec<Pose>,
    information: Vec<f64>,
}

/// Expected pose of the particles and its spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expectation {
    /// Weighted mean, eq. (18); the heading's mean is circular.
    pub pose: Pose,
    /// Weighted covariance of x, y (m) and heading (rad).
    pub covariance: [[f64; 3]; 3],
    /// Effective sample size 1 / sum w^2.
    pub effective_sample_size: f64,
}

impl ParticleFilter {
    /// Particles around `start`; `parameters` must pass [`Parameters::check`]. Equal seeds give equal runs.
    pub fn new(parameters: &Parameters, start: Pose, seed: u64) -> Self {
        let count = parameters.filter.particles;
        let mut spread = random::stream(seed, "start");
        let mut normal = |sigma: f64| sigma * spread.sample::<f64, _>(StandardNormal);
        let particles: Vec<Pose> = (0..count)
            .map(|_| Pose {
                x_m: start.x_m + normal(parameters.filter.start_sigma_m),
                y_m: start.y_m + normal(parameters.filter.start_sigma_m),
                heading_rad: wrap_angle(
                    start.heading_rad + normal(parameters.filter.start_sigma_rad),
                ),
            })
            .collect();
        Self {
            drawn: particles.clone(),
            particles,
            weights: vec![1.0 / count as f64; count],
            motion: random::stream(seed, "motion"),
            draws: random::stream(seed, "resampling"),
            likelihood: ParticleLikelihood::new(parameters),
            parents: vec![0; count],
            information: vec![0.0; count],
            parameters: parameters.clone(),
        }
    }

    /// The candidates of the pose.
    pub fn particles(&self) -> &[Pose] {
        &self.particles
    }

    /// Their weights, which add up to 1.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Eq. (8): moves every particle for `duration_s` with its own noise on both speeds.
    pub fn predict(&mut self, odometry: Odometry, duration_s: f64) {
        for particle in &mut self.particles {
            let noisy = Odometry {
                v_mps: odometry.v_mps
                    + self.parameters.filter.sigma_v_mps
                        * self.motion.sample::<f64, _>(StandardNormal),
                omega_radps: odometry.omega_radps
                    + self.parameters.filter.sigma_omega_radps
                        * self.motion.sample::<f64, _>(StandardNormal),
            };
            *particle = advance(
                particle,
                noisy,
                duration_s,
                self.parameters.filter.integration,
            );
        }
    }

    /// Weighs the particles by the mutual information of their echo images and map patches, eqs. (9)-(17).
    ///
    /// `polar` is `[direction, delay]`, see [`crate::EchoBlock::polar`].
    pub fn weigh(&mut self, polar: ArrayView2<'_, f32>, map: &MapImage) {
        let mut information = std::mem::take(&mut self.information);
        self.likelihood
            .information(polar, map, &self.particles, &mut information);
        self.weigh_by(&information);
        self.information = information;
    }

    /// Eq. (17) with given likelihoods, one per particle: posterior = prior times likelihood to the power
    /// `likelihood_exponent`, normalized. Weights stay as they are if none is positive.
    pub fn weigh_by(&mut self, likelihoods: &[f64]) {
        let exponent = self.parameters.filter.likelihood_exponent;
        let tempered = |value: f64| {
            if exponent == 1.0 {
                value
            } else {
                value.powf(exponent)
            }
        };
        let sum: f64 = self
            .weights
            .iter()
            .zip(likelihoods)
            .map(|(weight, &value)| weight * tempered(value))
            .sum();
        if !(sum.is_finite() && sum > 0.0) {
            return;
        }
        for (weight, &value) in self.weights.iter_mut().zip(likelihoods) {
            *weight *= tempered(value) / sum;
        }
    }

    /// Eq. (18) and its spread.
    pub fn expectation(&self) -> Expectation {
        let (mut x_m, mut y_m, mut sine, mut cosine) = (0.0, 0.0, 0.0, 0.0);
        for (particle, weight) in self.particles.iter().zip(&self.weights) {
            x_m += weight * particle.x_m;
            y_m += weight * particle.y_m;
            sine += weight * particle.heading_rad.sin();
            cosine += weight * particle.heading_rad.cos();
        }
        let pose = Pose {
            x_m,
            y_m,
            heading_rad: sine.atan2(cosine),
        };
        let mut covariance = [[0.0; 3]; 3];
        for (particle, weight) in self.particles.iter().zip(&self.weights) {
            let turned = wrap_angle(particle.heading_rad - pose.heading_rad);
            let deviation = [particle.x_m - x_m, particle.y_m - y_m, turned];
            for (row, a) in covariance.iter_mut().zip(deviation) {
                for (entry, b) in row.iter_mut().zip(deviation) {
                    *entry += weight * a * b;
                }
            }
        }
        Expectation {
            pose,
            covariance,
            effective_sample_size: effective_sample_size(&self.weights),
        }
    }

    /// Draws the next particles by their weights if the effective sample size is at most `resample_threshold` N_s.
    pub fn resample(&mut self) {
        let count = self.particles.len() as f64;
        // With equal weights rounding may lift the effective sample size a little above the number of particles.
        if effective_sample_size(&self.weights)
            > self.parameters.filter.resample_threshold * count * (1.0 + 1e-9)
        {
            return;
        }
        match self.parameters.filter.resampling {
            Resampling::Systematic => {
                systematic(&self.weights, self.draws.random(), &mut self.parents);
            }
            Resampling::Multinomial => {
                let draws = &mut self.draws;
                multinomial(&self.weights, || draws.random(), &mut self.parents);
            }
        }
        for (drawn, &parent) in self.drawn.iter_mut().zip(&self.parents) {
            *drawn = self.particles[parent];
        }
        std::mem::swap(&mut self.particles, &mut self.drawn);
        self.weights.fill(1.0 / count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::FilterParameters;

    fn small() -> Parameters {
        Parameters {
            filter: FilterParameters {
                window_half_width_m: 0.5,
                start_sigma_m: 0.05,
                start_sigma_rad: 0.05,
                ..FilterParameters::default()
            },
            ..Parameters::default()
        }
    }

    #[test]
    fn perfect_sensing_leaves_no_bias() {
        // Weights are the exact likelihood of the true pose, so the mean error over many runs vanishes.
        let parameters = Parameters {
            filter: FilterParameters {
                sigma_v_mps: 0.05,
                particles: 200,
                ..small().filter
            },
            ..small()
        };
        let odometry = Odometry {
            v_mps: 0.3,
            omega_radps: 0.2,
        };
        let runs = 60;
        let (mut x_m, mut y_m, mut turned, mut squares) = (0.0, 0.0, 0.0, 0.0);
        for seed in 0..runs {
            let mut truth = Pose {
                x_m: 1.0,
                y_m: -2.0,
                heading_rad: 3.0,
            };
            let mut filter = ParticleFilter::new(&parameters, truth, seed);
            for _ in 0..60 {
                truth = advance(&truth, odometry, 0.1023, parameters.filter.integration);
                filter.predict(odometry, 0.1023);
                let likelihood: Vec<f64> = filter
                    .particles()
                    .iter()
                    .map(|pose| {
                        let turned = wrap_angle(pose.heading_rad - truth.heading_rad);
                        (-0.5 * (pose.distance_m(&truth) / 0.02).powi(2)
                            - 0.5 * (turned / 0.05).powi(2))
                        .exp()
                    })
                    .collect();
                filter.weigh_by(&likelihood);
                let pose = filter.expectation().pose;
                filter.resample();
                x_m += pose.x_m - truth.x_m;
                y_m += pose.y_m - truth.y_m;
                turned += wrap_angle(pose.heading_rad - truth.heading_rad);
                squares += pose.distance_m(&truth).powi(2);
            }
        }
        let count = 60.0 * runs as f64;
        assert!(
            (x_m / count).abs() < 5e-4 && (y_m / count).abs() < 5e-4,
            "{} {}",
            x_m / count,
            y_m / count
        );
        assert!((turned / count).abs() < 2e-3, "{}", turned / count);
        assert!((squares / count).sqrt() < 0.01);
    }

    #[test]
    fn the_mean_heading_is_circular() {
        let parameters = Parameters {
            filter: FilterParameters {
                start_sigma_m: 0.0,
                start_sigma_rad: 0.3,
                particles: 2000,
                ..small().filter
            },
            ..small()
        };
        let filter = ParticleFilter::new(
            &parameters,
            Pose {
                heading_rad: std::f64::consts::PI,
                ..Pose::default()
            },
            4,
        );
        let expected = filter.expectation();
        assert!(wrap_angle(expected.pose.heading_rad - std::f64::consts::PI).abs() < 0.03);
        assert!((expected.covariance[2][2].sqrt() - 0.3).abs() < 0.02);
        assert!((expected.effective_sample_size - 2000.0).abs() < 1e-6);
    }

    #[test]
    fn useless_likelihoods_change_nothing_and_tempering_sharpens() {
        let mut filter = ParticleFilter::new(&small(), Pose::default(), 4);
        for bad in [0.0, f64::NAN, f64::INFINITY] {
            filter.weigh_by(&[bad; 100]);
            assert!(filter.weights().iter().all(|&weight| weight == 0.01));
        }
        let mut likelihood = [1.0; 100];
        likelihood[3] = 2.0;
        let mut tempered = ParticleFilter::new(
            &Parameters {
                filter: FilterParameters {
                    likelihood_exponent: 4.0,
                    ..small().filter
                },
                ..small()
            },
            Pose::default(),
            4,
        );
        filter.weigh_by(&likelihood);
        tempered.weigh_by(&likelihood);
        assert!((filter.weights()[3] / filter.weights()[0] - 2.0).abs() < 1e-12);
        assert!((tempered.weights()[3] / tempered.weights()[0] - 16.0).abs() < 1e-12);
        assert!((tempered.weights().iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn resampling_waits_for_its_threshold() {
        let parameters = Parameters {
            filter: FilterParameters {
                resample_threshold: 0.5,
                ..small().filter
            },
            ..small()
        };
        let mut filter = ParticleFilter::new(&parameters, Pose::default(), 4);
        let mut likelihood = [1.0; 100];
        likelihood[3] = 2.0;
        filter.weigh_by(&likelihood);
        filter.resample();
        assert!(filter.weights()[3] > filter.weights()[0]);
        likelihood[3] = 1e4;
        filter.weigh_by(&likelihood);
        let favourite = filter.particles()[3];
        filter.resample();
        assert!(filter.weights().iter().all(|&weight| weight == 0.01));
        assert!(
            filter
                .particles()
                .iter()
                .filter(|&&particle| particle == favourite)
                .count()
                > 90
        );
    }
}
