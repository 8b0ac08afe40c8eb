//! Likelihood of the particles: mutual information of echo images and parts of the map, eqs. (9)-(16).

use ndarray::ArrayView2;

use crate::image::echo_image::ImageWindow;
use crate::image::map_image::MapImage;
use crate::likelihood::direction_cache::{DirectionCache, ImageLayout};
use crate::likelihood::map_patches::MapPatches;
use crate::likelihood::mutual_information::{MutualInformation, quantize};
use crate::parameters::{Method, Parameters};
use crate::pose::{Pose, wrap_angle};

/// Compares echo images with parts of the map, eqs. (9)-(16).
pub(crate) struct ParticleLikelihood {
    sensor_offset_m: [f64; 2],
    bins: usize,
    window: ImageWindow,
    tool: MutualInformation,
    sheets: DirectionCache,
    image: Vec<f32>,
    echo: Vec<u8>,
    crops: MapPatches,
    sights: Vec<Comparison>,
    /// Largest echo, crop and place in `sights` of each, sorted.
    order: Vec<(u32, usize, usize)>,
}

/// What a particle is to be compared with.
#[derive(Debug, Clone)]
struct Comparison {
    particle: usize,
    crop: usize,
    heading_rad: f64,
    outline: ImageLayout,
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
            tool: MutualInformation::new(parameters.filter.bins, window.len()),
            sheets: DirectionCache::new(&window, directions, parameters.filter.bins, particles),
            image: vec![0.0; window.len()],
            echo: vec![0; window.len()],
            // As many as there can be cells with particles: made now, a step never has to allocate.
            crops: MapPatches::new(
                parameters.filter.method,
                &window,
                parameters.filter.bins,
                particles,
            ),
            sights: Vec::with_capacity(particles),
            order: Vec::with_capacity(particles),
            window,
        }
    }

    /// Mutual information of every particle's echo image and part of the map.
    pub(crate) fn information(
        &mut self,
        polar: ArrayView2<'_, f32>,
        map: &MapImage,
        particles: &[Pose],
        information: &mut [f64],
    ) {
        if polar.nrows() < 2 {
            return self.blind_information(polar, map, particles, information);
        }
        if polar.nrows() != self.sheets.directions() + 1 {
            // Another number of directions than the parameters said.
            self.sheets =
                DirectionCache::new(&self.window, polar.nrows() - 1, self.bins, particles.len());
        }
        self.see(polar, map, particles);
        let mut before: Option<&Comparison> = None;
        for &(_, _, place) in &self.order {
            let sight = &self.sights[place];
            let crop = self.crops.get(sight.crop);
            let followed = before.filter(|before| {
                before.crop == sight.crop && self.sheets.is_change(&before.outline, &sight.outline)
            });
            information[sight.particle] = match followed {
                Some(before) => {
                    self.sheets.for_each_change(
                        &self.window,
                        &before.outline,
                        &sight.outline,
                        |start, old, new| {
                            self.tool.change(old, new, &crop.bins[start..]);
                        },
                    );
                    self.tool.value(crop.marginal)
                }
                None => {
                    self.sheets
                        .draw(&self.window, &sight.outline, &mut self.echo);
                    self.tool.information(&self.echo, &crop.bins, crop.marginal)
                }
            };
            before = Some(sight);
        }
    }

    /// Finds what each particle is to be compared with, and the order in which that is done.
    fn see(&mut self, polar: ArrayView2<'_, f32>, map: &MapImage, particles: &[Pose]) {
        self.sheets.clear();
        self.crops.clear();
        self.sights.clear();
        for (particle, pose) in particles.iter().enumerate() {
            let crop = self.crop_around(map, pose);
            self.sights.push(Comparison {
                particle,
                crop,
                heading_rad: wrap_angle(pose.heading_rad),
                outline: ImageLayout::default(),
            });
        }
        self.sights
            .sort_unstable_by(|a, b| a.heading_rad.total_cmp(&b.heading_rad));
        for place in 0..self.sights.len() {
            let (before, rest) = self.sights.split_at_mut(place);
            let before = before.last().map(|before| &before.outline);
            let sight = &mut rest[0];
            sight.outline = self
                .sheets
                .outline(&self.window, polar, sight.heading_rad, before);
        }
        // Images with the same maximum share their bins; before the same part of the map and from nearly the same heading, most pixels. Largest echoes
        // are no negative numbers: they compare as their bits do. Places are in the order of headings.
        self.order.clear();
        let sights = self.sights.iter().enumerate();
        self.order.extend(
            sights.map(|(place, sight)| (sight.outline.largest.to_bits(), sight.crop, place)),
        );
        self.order.sort_unstable();
    }

    /// [`Self::information`] without bearings: the echo image is the same for every particle, and so is the information in a cell.
    fn blind_information(
        &mut self,
        polar: ArrayView2<'_, f32>,
        map: &MapImage,
        particles: &[Pose],
        information: &mut [f64],
    ) {
        self.window.draw(polar, 0.0, &mut self.image);
        quantize(&self.image, self.bins, &mut self.echo);
        self.crops.clear();
        for (pose, out) in particles.iter().zip(information) {
            let crop = self.crop_around(map, pose);
            let crop = self.crops.get(crop);
            *out = match crop.information {
                Some(known) => known,
                None => self.tool.information(&self.echo, &crop.bins, crop.marginal),
            };
            crop.information = Some(*out);
        }
    }

    /// Number of the part of the map that a pose sees.
    fn crop_around(&mut self, map: &MapImage, pose: &Pose) -> usize {
        let centre = map.cell_of(&pose.carried(self.sensor_offset_m));
        self.crops.around(map, &self.window, &self.tool, centre)
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
            let mut matcher = ParticleLikelihood::new(&Parameters {
                filter: FilterParameters {
                    method,
                    ..parameters.filter
                },
                ..parameters.clone()
            });
            matcher.information(polar, &map, filter.particles(), &mut fast);
            for (pose, fast) in filter.particles().iter().zip(fast) {
                let mut image = vec![0.0; window.len()];
                map.crop(method, &window, map.cell_of(pose), &mut image);
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
