//! Map patches: parts of the map around the particles, quantized, eqs. (13) and (14).
//!
//! Particles in the same cell share a patch; it is cut out and quantized once a step.

use crate::image::echo_image::ImageWindow;
use crate::image::map_image::MapImage;
use crate::likelihood::mutual_information::{MutualInformation, largest_of, quantize, quantize_by};
use crate::parameters::Method;

/// The patches of one step.
pub(crate) struct MapPatches {
    method: Method,
    bins: usize,
    /// The first `used` are those of this step; the others are spare buffers.
    patches: Vec<MapPatch>,
    used: usize,
    /// Bins of a patch that lies within the map, row by row.
    square: Vec<u8>,
    /// A patch that does not, before it is quantized.
    image: Vec<f32>,
}

/// A quantized patch and, in the range-only method, its mutual information with the echo image.
pub(crate) struct MapPatch {
    centre: [i64; 2],
    /// Bins in the order of the window.
    pub(crate) bins: Vec<u8>,
    /// See [`MutualInformation::marginal`].
    pub(crate) marginal: i64,
    pub(crate) information: Option<f64>,
}

impl MapPatch {
    /// An unused patch.
    fn new(pixels: usize) -> Self {
        Self {
            centre: [0; 2],
            bins: vec![0; pixels],
            marginal: 0,
            information: None,
        }
    }
}

impl MapPatches {
    /// Patches of a window with bins 0 to `bins`. Nothing is allocated later as long as a step uses at most
    /// `capacity` cells.
    pub(crate) fn new(method: Method, window: &ImageWindow, bins: usize, capacity: usize) -> Self {
        Self {
            method,
            bins,
            patches: (0..capacity).map(|_| MapPatch::new(window.len())).collect(),
            used: 0,
            square: vec![0; window.len()],
            image: vec![0.0; window.len()],
        }
    }

    /// Starts a new step.
    pub(crate) fn clear(&mut self) {
        self.used = 0;
    }

    /// A patch by the number from [`Self::around`].
    pub(crate) fn get(&mut self, number: usize) -> &mut MapPatch {
        &mut self.patches[number]
    }

    /// Number of the patch around a world cell. The map must be the same until [`Self::clear`].
    pub(crate) fn around(
        &mut self,
        map: &MapImage,
        window: &ImageWindow,
        mutual_information: &MutualInformation,
        centre: [i64; 2],
    ) -> usize {
        let known = &self.patches[..self.used];
        if let Some(number) = known.iter().position(|patch| patch.centre == centre) {
            return number;
        }
        let number = self.used;
        self.used += 1;
        if number == self.patches.len() {
            // More cells than the capacity.
            self.patches.push(MapPatch::new(window.len()));
        }
        self.cut(map, window, centre, number);
        let patch = &mut self.patches[number];
        patch.centre = centre;
        patch.information = None;
        patch.marginal = mutual_information.marginal(&patch.bins);
        number
    }

    /// Writes the bins around a world cell.
    fn cut(&mut self, map: &MapImage, window: &ImageWindow, centre: [i64; 2], number: usize) {
        let bins = &mut self.patches[number].bins;
        let Some(rows) = map.rows_around(self.method, window.half_cells(), centre) else {
            map.patch(self.method, window, centre, &mut self.image);
            return quantize(&self.image, self.bins, bins);
        };
        // Rows are quantized contiguously, many cells at once; only the bytes are permuted into the order of the
        // window.
        let largest = rows.clone().map(largest_of).fold(0.0, f32::max);
        if largest <= 0.0 {
            return bins.fill(0);
        }
        let width = 2 * window.half_cells() + 1;
        for (row, quantized) in rows.zip(self.square.chunks_exact_mut(width)) {
            quantize_by(largest, row, self.bins, quantized);
        }
        for (bin, &index) in bins.iter_mut().zip(window.square_indices()) {
            *bin = self.square[index as usize];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{MeasurementParameters, Parameters};
    use ndarray::Array2;
    use proptest::prelude::*;

    proptest! {
            #![proptest_config(ProptestConfig::with_cases(64))]
            #[test]
            fn patches_are_the_quantized_map(
                half in 1_usize..12,
                centres in prop::collection::vec((-25_i64..25, -25_i64..25), 1..12),
                power in 0_i32..5,
            ) {
                let parameters = Parameters { measurement: MeasurementParameters { max_range_m: 2.0,
    ..MeasurementParameters::default() },
    ..Parameters::default() };
                let map = MapImage {
                    origin_cell: [-18, -20],
                    cell_m: parameters.measurement.cell_m,
                    intensity: Array2::from_shape_fn((45, 41), |(y, x)| {
                    (((x * 5 + y * y) % 37) as f32).powi(power) - 1.0
                }),
                    toa_only: Array2::zeros((45, 41)),
                    parameters: parameters.clone(),
                };
                let window = ImageWindow::new(&parameters, half);
                let mutual_information = MutualInformation::new(127, window.len());
                let (mut image, mut expected) = (vec![0.0; window.len()], vec![0; window.len()]);
                for method in [Method::Doppler, Method::ToaOnly] {
                    // Fewer than there may be cells.
                    let mut patches = MapPatches::new(method, &window, 127, 3);
                    let numbers: Vec<usize> = centres
                        .iter()
                        .map(|&(x, y)| patches.around(&map, &window, &mutual_information, [x, y]))
                        .collect();
                    for (&(x, y), number) in centres.iter().zip(numbers) {
                        map.patch(method, &window, [x, y], &mut image);
                        quantize(&image, 127, &mut expected);
                        let patch = patches.get(number);
                        prop_assert_eq!(&patch.bins, &expected);
                        prop_assert_eq!(patch.marginal, mutual_information.marginal(&expected));
                    }
                }
            }
        }
}
