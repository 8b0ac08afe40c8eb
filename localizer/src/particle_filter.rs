//! The particle filter: motion with noise, eq. (8), weights from mutual information, eqs. (9)-(17), expected pose, eq. (18).

use ndarray::ArrayView2;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::dead_reckoning::advance;
use crate::echo_image::Window;
use crate::map_image::MapImage;
use crate::mutual_information::{MutualInformation, quantize};
use crate::parameters::{Method, Parameters};
use crate::pose::{Odometry, Pose, wrap_angle};
use crate::random;
use crate::resampling::{effective_sample_size, systematic};

/// Candidates of the pose and what they believe.
pub struct ParticleFilter {
    parameters: Parameters,
    particles: Vec<Pose>,
    weights: Vec<f64>,
    motion: ChaCha8Rng,
    comb: ChaCha8Rng,
    matcher: Matcher,
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
    /// Particles around `start`; `parameters` are checked ones. Equal seeds give equal runs.
    pub fn new(parameters: &Parameters, start: Pose, seed: u64) -> Self {
        let count = parameters.particles;
        let mut spread = random::stream(seed, "start");
        let mut normal = |sigma: f64| sigma * spread.sample::<f64, _>(StandardNormal);
        let particles: Vec<Pose> = (0..count)
            .map(|_| Pose {
                x_m: start.x_m + normal(parameters.start_sigma_m),
                y_m: start.y_m + normal(parameters.start_sigma_m),
                heading_rad: wrap_angle(start.heading_rad + normal(parameters.start_sigma_rad)),
            })
            .collect();
        Self {
            drawn: particles.clone(),
            particles,
            weights: vec![1.0 / count as f64; count],
            motion: random::stream(seed, "motion"),
            comb: random::stream(seed, "resampling"),
            matcher: Matcher::new(parameters),
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
                    + self.parameters.sigma_v_mps * self.motion.sample::<f64, _>(StandardNormal),
                omega_radps: odometry.omega_radps
                    + self.parameters.sigma_omega_radps
                        * self.motion.sample::<f64, _>(StandardNormal),
            };
            *particle = advance(particle, noisy, duration_s, self.parameters.integration);
        }
    }

    /// Eqs. (9)-(16): mutual information of each particle's echo image with its part of the map, times eq. (17).
    ///
    /// `polar` is what the method sees of a block, see [`crate::EchoBlock::polar`].
    pub fn weigh(&mut self, polar: ArrayView2<'_, f32>, map: &MapImage) {
        let mut information = std::mem::take(&mut self.information);
        self.matcher
            .information(polar, map, &self.particles, &mut information);
        self.weigh_by(&information);
        self.information = information;
    }

    /// Eq. (17) with given likelihoods, one per particle: posterior = prior times likelihood to the power
    /// `likelihood_exponent`, normalized. Weights stay as they are if none is positive.
    pub fn weigh_by(&mut self, likelihoods: &[f64]) {
        let exponent = self.parameters.likelihood_exponent;
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

    /// Draws the next particles by their weights, when the effective sample size asks for it.
    pub fn resample(&mut self) {
        let count = self.particles.len() as f64;
        // With equal weights rounding may lift the effective sample size a little above the number of particles.
        if effective_sample_size(&self.weights)
            > self.parameters.resample_threshold * count * (1.0 + 1e-9)
        {
            return;
        }
        systematic(&self.weights, self.comb.random::<f64>(), &mut self.parents);
        for (drawn, &parent) in self.drawn.iter_mut().zip(&self.parents) {
            *drawn = self.particles[parent];
        }
        std::mem::swap(&mut self.particles, &mut self.drawn);
        self.weights.fill(1.0 / count);
    }
}

/// Compares echo images with parts of the map, eqs. (9)-(16).
///
/// Particles in the same cell see the same part of the map; it is cut out and quantized once a step.
struct Matcher {
    method: Method,
    bins: usize,
    window: Window,
    tool: MutualInformation,
    image: Vec<f32>,
    echo: Vec<u8>,
    crops: Vec<Crop>,
}

/// A quantized part of the map and, for the range-only method, its mutual information with the echo image.
struct Crop {
    centre: [i64; 2],
    bins: Vec<u8>,
    marginal: f64,
    information: Option<f64>,
}

impl Matcher {
    fn new(parameters: &Parameters) -> Self {
        let window = Window::new(parameters, parameters.window_cells());
        Self {
            method: parameters.method,
            bins: parameters.bins,
            tool: MutualInformation::new(parameters.bins, window.len()),
            image: vec![0.0; window.len()],
            echo: vec![0; window.len()],
            crops: Vec::new(),
            window,
        }
    }

    fn information(
        &mut self,
        polar: ArrayView2<'_, f32>,
        map: &MapImage,
        particles: &[Pose],
        information: &mut [f64],
    ) {
        let mut used = 0;
        let blind = polar.nrows() == 1;
        let mut echo_marginal = 0.0;
        for (index, (particle, out)) in particles.iter().zip(information).enumerate() {
            let centre = map.cell_of(particle);
            let crop = match self.crops[..used]
                .iter()
                .position(|crop| crop.centre == centre)
            {
                Some(crop) => crop,
                None => {
                    self.cut(map, centre, used);
                    used += 1;
                    used - 1
                }
            };
            // Without bearings the echo image is the same for every particle.
            if index == 0 || !blind {
                self.window
                    .draw(polar, particle.heading_rad, &mut self.image);
                quantize(&self.image, self.bins, &mut self.echo);
                echo_marginal = self.tool.marginal(&self.echo);
            }
            let crop = &mut self.crops[crop];
            *out = match crop.information.filter(|_| blind) {
                Some(known) => known,
                None => self
                    .tool
                    .information(&self.echo, echo_marginal, &crop.bins, crop.marginal),
            };
            crop.information = Some(*out);
        }
    }

    /// Makes crop number `slot` the one around a world cell.
    fn cut(&mut self, map: &MapImage, centre: [i64; 2], slot: usize) {
        if slot == self.crops.len() {
            let bins = vec![0; self.window.len()];
            self.crops.push(Crop {
                centre,
                bins,
                marginal: 0.0,
                information: None,
            });
        }
        let crop = &mut self.crops[slot];
        crop.centre = centre;
        crop.information = None;
        map.crop(self.method, &self.window, centre, &mut self.image);
        quantize(&self.image, self.bins, &mut crop.bins);
        crop.marginal = self.tool.marginal(&crop.bins);
    }
}
