//! Echo images: the echoes of one block laid out around the robot, eqs. (4)-(6) and (14)-(16).
//!
//! A pixel's delay does not depend on the pose, and its bearing depends on it through the heading alone. Pixels are
//! therefore sorted by their world angle: under any heading, those of one direction are a few ranges in that order.

use ndarray::{Array2, ArrayView1, ArrayView2};

use crate::image::bearing_index::{BearingIndex, from_minus_pi};
use crate::parameters::Parameters;

/// The pixels of a square window around the robot. Images are slices with one value per pixel, in the order of
/// [`Self::offsets`].
///
/// ```
/// use localizer::Parameters;
/// use localizer::image::ImageWindow;
/// use ndarray::Array2;
///
/// // An echo from 1 m straight ahead of a robot with heading 0.
/// let parameters = Parameters::default();
/// let mut polar = Array2::zeros((parameters.measurement.directions + 1, parameters.delays()));
/// polar[[0, parameters.signal.delay_of_range(1.0)]] = 5.0;
/// let window = ImageWindow::new(&parameters, 12);
/// let mut image = vec![0.0; window.len()];
/// window.draw(polar.view(), 0.0, &mut image);
/// assert_eq!(window.to_array(&image)[[12, 22]], 5.0);
/// ```
#[derive(Debug, Clone)]
pub struct ImageWindow {
    half_cells: usize,
    /// Pixels with an echo, sorted by angle.
    bearings: BearingIndex,
    /// Their delays in samples, eq. (5).
    delays: Vec<u32>,
    /// Offsets `[mx, my]` of all pixels in cells: first those with an echo, then those too near or too far for one.
    offsets: Vec<[i32; 2]>,
    /// Indices of all pixels in the square array, row by row.
    square_indices: Vec<u32>,
}

impl ImageWindow {
    /// A window of `2 half_cells + 1` pixels a side. Pixels nearer than `min_range_m` or beyond `max_range_m` have no
    /// echo.
    pub fn new(parameters: &Parameters, half_cells: usize) -> Self {
        let half = half_cells as i32;
        let (mut visible, mut hidden) = (Vec::new(), Vec::new());
        for my in -half..=half {
            for mx in -half..=half {
                let (x_m, y_m) = (
                    f64::from(mx) * parameters.measurement.cell_m,
                    f64::from(my) * parameters.measurement.cell_m,
                );
                let range_m = x_m.hypot(y_m);
                let delay = parameters.signal.delay_of_range(range_m);
                if range_m < parameters.measurement.min_range_m || delay >= parameters.delays() {
                    hidden.push([mx, my]);
                } else {
                    visible.push((from_minus_pi(y_m.atan2(x_m)), delay as u32, [mx, my]));
                }
            }
        }
        visible.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let offsets: Vec<[i32; 2]> = visible.iter().map(|pixel| pixel.2).chain(hidden).collect();
        Self {
            half_cells,
            bearings: BearingIndex::new(visible.iter().map(|pixel| pixel.0).collect()),
            delays: visible.iter().map(|pixel| pixel.1).collect(),
            square_indices: offsets
                .iter()
                .map(|[mx, my]| ((my + half) * (2 * half + 1) + mx + half) as u32)
                .collect(),
            offsets,
        }
    }

    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.offsets.len()
    }

    /// True for a window without pixels; no window is empty.
    pub fn is_empty(&self) -> bool {
        self.offsets.is_empty()
    }

    /// Half width N_W in cells.
    pub fn half_cells(&self) -> usize {
        self.half_cells
    }

    /// Offsets `[mx, my]` from the robot's cell, in the order of the images.
    pub fn offsets(&self) -> &[[i32; 2]] {
        &self.offsets
    }

    /// Draws the echo image of one block for a heading, eqs. (4)-(6). `polar` is H as `[direction, delay in
    /// samples]`, or one row that stands for all directions.
    ///
    /// `image` has [`Self::len`] elements in the order of [`Self::offsets`]; pixels without an echo are zero.
    pub fn draw(&self, polar: ArrayView2<'_, f32>, heading_rad: f64, image: &mut [f32]) {
        let visible = self.bearings.len();
        image[visible..].fill(0.0);
        let Some(directions) = polar.nrows().checked_sub(1) else {
            return image.fill(0.0);
        };
        if directions == 0 {
            return self.look_up(polar.row(0), 0, &mut image[..visible]);
        }
        let mut borders = vec![0; 2 * directions];
        self.bearings.borders(directions, heading_rad, &mut borders);
        self.bearings.for_each_arc(&borders, |direction, arc| {
            self.look_up(polar.row(direction), arc.start, &mut image[arc]);
        });
    }

    /// Number of pixels with an echo; they come first.
    pub(crate) fn visible(&self) -> usize {
        self.bearings.len()
    }

    /// Indices of all pixels in the square array, row by row.
    pub(crate) fn square_indices(&self) -> &[u32] {
        &self.square_indices
    }

    /// The pixels with an echo, sorted by angle.
    pub(crate) fn bearings(&self) -> &BearingIndex {
        &self.bearings
    }

    /// Writes the echoes of the pixels from `first` on, as many as `pixels` has, in a direction whose echoes by delay
    /// are `row`.
    pub(crate) fn look_up(&self, row: ArrayView1<'_, f32>, first: usize, pixels: &mut [f32]) {
        let pixels = pixels.iter_mut().zip(&self.delays[first..]);
        if let Some(row) = row.as_slice() {
            for (pixel, &delay) in pixels {
                *pixel = row.get(delay as usize).copied().unwrap_or(0.0);
            }
        } else {
            for (pixel, &delay) in pixels {
                *pixel = row.get(delay as usize).copied().unwrap_or(0.0);
            }
        }
    }

    /// An image as an array `[my + N_W, mx + N_W]`.
    pub fn to_array(&self, image: &[f32]) -> Array2<f32> {
        let width = 2 * self.half_cells + 1;
        let mut array = Array2::zeros((width, width));
        for (&index, &value) in self.square_indices.iter().zip(image) {
            let index = index as usize;
            array[[index / width, index % width]] = value;
        }
        array
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::MeasurementParameters;
    use proptest::prelude::*;

    fn polar(directions: usize, delays: usize) -> Array2<f32> {
        Array2::from_shape_fn((directions + 1, delays), |(n, k)| (n * 10_000 + k) as f32)
    }

    proptest! {
            #![proptest_config(ProptestConfig::with_cases(64))]
            #[test]
            fn drawing_agrees_with_the_printed_equations(
            heading in -10.0..10.0,
            half in 1_usize..30,
            directions in 1_usize..40,
        ) {
                let parameters = Parameters { measurement: MeasurementParameters { max_range_m: 2.5,
    directions,
    ..MeasurementParameters::default() },
    ..Parameters::default() };
                let window = ImageWindow::new(&parameters, half);
                let polar = polar(directions, parameters.delays());
                let mut image = vec![9.0; window.len()];
                window.draw(polar.view(), heading, &mut image);
                let plain = crate::reference::echo_image(&parameters, polar.view(), heading, half);
                prop_assert_eq!(window.to_array(&image), plain);
            }
        }

    #[test]
    fn one_row_stands_for_all_directions() {
        let parameters = Parameters::default();
        let window = ImageWindow::new(&parameters, 10);
        let mut image = vec![0.0; window.len()];
        window.draw(polar(0, parameters.delays()).view(), 1.0, &mut image);
        let array = window.to_array(&image);
        assert_eq!(array[[10, 15]], array[[15, 10]]);
        assert_eq!(
            array[[10, 15]],
            parameters.signal.delay_of_range(0.5) as f32
        );
        assert_eq!(array[[10, 10]], 0.0);
        assert_eq!(array[[10, 12]], 0.0);
    }

    #[test]
    fn left_and_right_of_the_heading_look_the_same() {
        let parameters = Parameters::default();
        let window = ImageWindow::new(&parameters, 20);
        let mut image = vec![0.0; window.len()];
        window.draw(polar(29, parameters.delays()).view(), 0.0, &mut image);
        let array = window.to_array(&image);
        for my in 0..=20 {
            assert_eq!(array.row(20 + my), array.row(20 - my));
        }
    }
}
