//! Parts of the map around the particles, quantized, eqs. (13) and (14).
//!
//! Particles in the same cell see the same part of the map; it is cut out and quantized once a step.

use crate::image::echo_image::ImageWindow;
use crate::image::map_image::MapImage;
use crate::likelihood::mutual_information::{MutualInformation, largest_of, quantize, quantize_by};
use crate::parameters::Method;

/// The parts of the map that one step asks for.
pub(crate) struct MapPatches {
    method: Method,
    bins: usize,
    /// Those of this step come first; the others are room for more.
    crops: Vec<MapPatch>,
    used: usize,
    /// Bins of a part that lies within the map, row by row.
    square: Vec<u8>,
    /// A part that does not, before it is quantized.
    image: Vec<f32>,
}

/// A quantized part of the map and, without bearings, its mutual information with the echo image.
pub(crate) struct MapPatch {
    centre: [i64; 2],
    /// Bins in the order of the window.
    pub(crate) bins: Vec<u8>,
    /// See [`MutualInformation::marginal`].
    pub(crate) marginal: i64,
    pub(crate) information: Option<f64>,
}

impl MapPatch {
    /// A crop of nothing yet.
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
    /// For a window and so many bins; nothing is allocated later as long as a step asks for `most` cells at most.
    pub(crate) fn new(method: Method, window: &ImageWindow, bins: usize, most: usize) -> Self {
        Self {
            method,
            bins,
            crops: (0..most).map(|_| MapPatch::new(window.len())).collect(),
            used: 0,
            square: vec![0; window.len()],
            image: vec![0.0; window.len()],
        }
    }

    /// Forgets the map.
    pub(crate) fn clear(&mut self) {
        self.used = 0;
    }

    /// A crop by its number.
    pub(crate) fn get(&mut self, number: usize) -> &mut MapPatch {
        &mut self.crops[number]
    }

    /// Number of the crop around a world cell. The map is the same until [`Self::clear`].
    pub(crate) fn around(
        &mut self,
        map: &MapImage,
        window: &ImageWindow,
        tool: &MutualInformation,
        centre: [i64; 2],
    ) -> usize {
        let known = &self.crops[..self.used];
        if let Some(number) = known.iter().position(|crop| crop.centre == centre) {
            return number;
        }
        let number = self.used;
        self.used += 1;
        if number == self.crops.len() {
            // More particles than the parameters said.
            self.crops.push(MapPatch::new(window.len()));
        }
        self.cut(map, window, centre, number);
        let crop = &mut self.crops[number];
        crop.centre = centre;
        crop.information = None;
        crop.marginal = tool.marginal(&crop.bins);
        number
    }

    /// Writes the bins around a world cell.
    fn cut(&mut self, map: &MapImage, window: &ImageWindow, centre: [i64; 2], number: usize) {
        let bins = &mut self.crops[number].bins;
        let Some(rows) = map.rows_around(self.method, window.half_cells(), centre) else {
            map.crop(self.method, window, centre, &mut self.image);
            return quantize(&self.image, self.bins, bins);
        };
        // Rows are quantized as they lie, many cells at once, and only bytes are put into the window's order.
        let largest = rows.clone().map(largest_of).fold(0.0, f32::max);
        if largest <= 0.0 {
            return bins.fill(0);
        }
        let width = 2 * window.half_cells() + 1;
        for (row, quantized) in rows.zip(self.square.chunks_exact_mut(width)) {
            quantize_by(largest, row, self.bins, quantized);
        }
        for (bin, &place) in bins.iter_mut().zip(window.places()) {
            *bin = self.square[place as usize];
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
            fn crops_are_the_quantized_windows(
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
                    intensity: Array2::from_shape_fn((45, 41), |(y, x)| (((x * 5 + y * y) % 37) as f32).powi(power) - 1.0),
                    toa_only: Array2::zeros((45, 41)),
                    parameters: parameters.clone(),
                };
                let window = ImageWindow::new(&parameters, half);
                let tool = MutualInformation::new(127, window.len());
                let (mut image, mut expected) = (vec![0.0; window.len()], vec![0; window.len()]);
                for method in [Method::Doppler, Method::ToaOnly] {
                    // Fewer than there may be cells.
                    let mut crops = MapPatches::new(method, &window, 127, 3);
                    let numbers: Vec<usize> = centres
                        .iter()
                        .map(|&(x, y)| crops.around(&map, &window, &tool, [x, y]))
                        .collect();
                    for (&(x, y), number) in centres.iter().zip(numbers) {
                        map.crop(method, &window, [x, y], &mut image);
                        quantize(&image, 127, &mut expected);
                        let crop = crops.get(number);
                        prop_assert_eq!(&crop.bins, &expected);
                        prop_assert_eq!(crop.marginal, tool.marginal(&expected));
                    }
                }
            }
        }
}
