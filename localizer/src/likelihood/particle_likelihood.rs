//! Likelihood of the particles: mutual information of echo images and map patches, eqs. (9)-(16).

use ndarray::ArrayView2;

use crate::image::echo_image::ImageWindow;
use crate::image::map_image::MapImage;
use crate::likelihood::direction_cache::{DirectionCache, ImageLayout};
use crate::likelihood::map_patches::MapPatches;
use crate::likelihood::mutual_information::{MutualInformation, quantize};
use crate::parameters::{Method, Parameters};
use crate::pose::{Pose, wrap_angle};

/// Compares the echo image of each particle with its map patch, eqs. (9)-(16).
pub(crate) struct ParticleLikelihood {
    sensor_offset_m: [f64; 2],
    bins: usize,
    window: ImageWindow,
    mutual_information: MutualInformation,
    cache: DirectionCache,
    image: Vec<f32>,
    echo: Vec<u8>,
    patches: MapPatches,
    comparisons: Vec<Comparison>,
    /// Largest echo, patch and index in `comparisons`, sorted.
    sequence: Vec<(u32, usize, usize)>,
}

/// The comparison of one particle's echo image with its map patch.
#[derive(Debug, Clone)]
struct Comparison {
    particle: usize,
    patch: usize,
    heading_rad: f64,
    layout: ImageLayout,
}

impl ParticleLikelihood {
    pub(crate) fn new(parameters: &Parameters) -> Self {
        let window = ImageWindow::new(parameters, parameters.window_cells());
        let particles = parameters.filter.particles;
        let directions = match parameters.filter.method {
            Method::Doppler => parameters.measurement.directions,
            Method::ToaOnly | Method::Odometry => 0,
        };
        Self {
            sensor_offset_m: parameters.signal.sensor_offset_m,
            bins: parameters.filter.bins,
            mutual_information: MutualInformation::new(parameters.filter.bins, window.len()),
            cache: DirectionCache::new(&window, directions, parameters.filter.bins, particles),
            image: vec![0.0; window.len()],
            echo: vec![0; window.len()],
            // One per particle at most, so that a step does not allocate.
            patches: MapPatches::new(
                parameters.filter.method,
                &window,
                parameters.filter.bins,
                particles,
            ),
            comparisons: Vec::with_capacity(particles),
            sequence: Vec::with_capacity(particles),
            window,
        }
    }

    /// Writes the mutual information in nats of every particle's echo image and map patch. `polar` is `[direction,
    /// delay]`, or one row in the range-only method.
    pub(crate) fn information(
        &mut self,
        polar: ArrayView2<'_, f32>,
        map: &MapImage,
        particles: &[Pose],
        information: &mut [f64],
    ) {
        if polar.nrows() < 2 {
            return self.range_only_information(polar, map, particles, information);
        }
        if polar.nrows() != self.cache.directions() + 1 {
            // More or fewer directions than the parameters have.
            self.cache =
                DirectionCache::new(&self.window, polar.nrows() - 1, self.bins, particles.len());
        }
        self.plan(polar, map, particles);
        let mut before: Option<&Comparison> = None;
        for &(_, _, index) in &self.sequence {
            let comparison = &self.comparisons[index];
            let patch = self.patches.get(comparison.patch);
            let followed = before.filter(|before| {
                before.patch == comparison.patch
                    && self.cache.is_change(&before.layout, &comparison.layout)
            });
            information[comparison.particle] = match followed {
                Some(before) => {
                    self.cache.for_each_change(
                        &self.window,
                        &before.layout,
                        &comparison.layout,
                        |start, old, new| {
                            self.mutual_information
                                .change(old, new, &patch.bins[start..]);
                        },
                    );
                    self.mutual_information.value(patch.marginal)
                }
                None => {
                    self.cache
                        .draw(&self.window, &comparison.layout, &mut self.echo);
                    self.mutual_information
                        .information(&self.echo, &patch.bins, patch.marginal)
                }
            };
            before = Some(comparison);
        }
    }

    /// Prepares the comparison of each particle, and the sequence in which they are evaluated.
    fn plan(&mut self, polar: ArrayView2<'_, f32>, map: &MapImage, particles: &[Pose]) {
        self.cache.clear();
        self.patches.clear();
        self.comparisons.clear();
        for (particle, pose) in particles.iter().enumerate() {
            let patch = self.patch_at(map, pose);
            self.comparisons.push(Comparison {
                particle,
                patch,
                heading_rad: wrap_angle(pose.heading_rad),
                layout: ImageLayout::default(),
            });
        }
        self.comparisons
            .sort_unstable_by(|a, b| a.heading_rad.total_cmp(&b.heading_rad));
        for index in 0..self.comparisons.len() {
            let (before, rest) = self.comparisons.split_at_mut(index);
            let before = before.last().map(|before| &before.layout);
            let comparison = &mut rest[0];
            comparison.layout =
                self.cache
                    .layout(&self.window, polar, comparison.heading_rad, before);
        }
        // Images with the same maximum share their bins; for the same patch and a close heading, also most pixels.
        // Largest echoes are not negative, so that they compare as their bits do; indices are in the order of
        // headings.
        self.sequence.clear();
        let comparisons = self.comparisons.iter().enumerate();
        self.sequence.extend(comparisons.map(|(index, comparison)| {
            (comparison.layout.largest.to_bits(), comparison.patch, index)
        }));
        self.sequence.sort_unstable();
    }

    /// [`Self::information`] in the range-only method: the echo image is the same for all particles, and the result
    /// for all of a cell.
    fn range_only_information(
        &mut self,
        polar: ArrayView2<'_, f32>,
        map: &MapImage,
        particles: &[Pose],
        information: &mut [f64],
    ) {
        self.window.draw(polar, 0.0, &mut self.image);
        quantize(&self.image, self.bins, &mut self.echo);
        self.patches.clear();
        for (pose, out) in particles.iter().zip(information) {
            let patch = self.patch_at(map, pose);
            let patch = self.patches.get(patch);
            *out = match patch.information {
                Some(known) => known,
                None => {
                    self.mutual_information
                        .information(&self.echo, &patch.bins, patch.marginal)
                }
            };
            patch.information = Some(*out);
        }
    }

    /// Number of the patch around a pose.
    fn patch_at(&mut self, map: &MapImage, pose: &Pose) -> usize {
        let centre = map.cell_of(&pose.carried(self.sensor_offset_m));
        self.patches
            .around(map, &self.window, &self.mutual_information, centre)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::particle_filter::ParticleFilter;
    use crate::parameters::{FilterParameters, MeasurementParameters};

    #[test]
    fn information_agrees_with_the_printed_equations() {
        let parameters = Parameters {
            measurement: MeasurementParameters {
                max_range_m: 3.0,
                ..MeasurementParameters::default()
            },
            filter: FilterParameters {
                window_half_width_m: 1.5,
                start_sigma_m: 0.3,
                start_sigma_rad: 0.05,
                ..FilterParameters::default()
            },
            ..Parameters::default()
        };
        let polar = ndarray::Array2::from_shape_fn((30, parameters.delays()), |(n, k)| {
            ((n * 7 + k * 13) % 101) as f32
        });
        let mut map = MapImage {
            origin_cell: [-18, -20],
            cell_m: 0.1,
            intensity: ndarray::Array2::from_shape_fn((45, 41), |(y, x)| {
                ((x * 5 + y * y) % 37) as f32
            }),
            toa_only: ndarray::Array2::zeros((45, 41)),
            parameters: parameters.clone(),
        };
        map.toa_only.assign(&map.intensity);
        let filter = ParticleFilter::new(&parameters, Pose::default(), 4);
        let window = ImageWindow::new(&parameters, 15);
        for method in [Method::Doppler, Method::ToaOnly] {
            let polar = if method == Method::ToaOnly {
                polar.slice(ndarray::s![3..4, ..])
            } else {
                polar.view()
            };
            let mut fast = vec![0.0; 100];
            let mut likelihood = ParticleLikelihood::new(&Parameters {
                filter: FilterParameters {
                    method,
                    ..parameters.filter
                },
                ..parameters.clone()
            });
            likelihood.information(polar, &map, filter.particles(), &mut fast);
            for (pose, fast) in filter.particles().iter().zip(fast) {
                let mut image = vec![0.0; window.len()];
                map.patch(method, &window, map.cell_of(pose), &mut image);
                let part =
                    crate::reference::quantize(window.to_array(&image).as_slice().unwrap(), 127);
                let plain = if method == Method::ToaOnly {
                    window.draw(polar, pose.heading_rad, &mut image);
                    window.to_array(&image)
                } else {
                    crate::reference::echo_image(&parameters, polar, pose.heading_rad, 15)
                };
                let echo = crate::reference::quantize(plain.as_slice().unwrap(), 127);
                assert!((crate::reference::mutual_information(&part, &echo) - fast).abs() < 1e-9);
            }
        }
    }
}
