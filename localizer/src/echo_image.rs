//! Echo images: the echoes of one block laid out around the robot, eqs. (4)-(6) and (14)-(16).
//!
//! A pixel's delay does not depend on the pose and its bearing only through the heading. The pixels are therefore kept
//! sorted by their world angle: under any heading those of one direction are a few runs of neighbours in that order, and
//! drawing an image is a walk over the runs.

use std::f64::consts::PI;
use std::ops::Range;

use ndarray::{Array2, ArrayView2};

use crate::parameters::Parameters;
use crate::pose::wrap_angle;

/// Direction index of an absolute angle from the heading in 0..=pi, eqs. (6) and (16).
fn direction_index(difference_rad: f64, directions: usize) -> usize {
    (directions as f64 / PI * wrap_angle(difference_rad).abs() + 0.5) as usize
}

/// Parts of the turn whose place in the order of angles is on file.
const SECTORS: usize = 4096;

/// The pixels of a square window around the robot, in the order in which images are kept.
#[derive(Debug, Clone)]
pub struct Window {
    half_cells: usize,
    /// Pixels with an echo, sorted by angle: world angle in (-pi, pi].
    angles_rad: Vec<f64>,
    /// For each of [`SECTORS`] equal parts of the turn, the first pixel with an angle in it or after it.
    sectors: Vec<u32>,
    /// Their delays in samples, eq. (5).
    delays: Vec<u32>,
    /// Offsets `[mx, my]` of all pixels: first those with an echo, then those too near or too far.
    offsets: Vec<[i32; 2]>,
}

impl Window {
    /// A window of `2 half_cells + 1` pixels a side; pixels nearer than `min_range_m` or beyond `max_range_m` are zero.
    pub fn new(parameters: &Parameters, half_cells: usize) -> Self {
        let half = half_cells as i32;
        let (mut near, mut blind) = (Vec::new(), Vec::new());
        for my in -half..=half {
            for mx in -half..=half {
                let (x_m, y_m) = (
                    f64::from(mx) * parameters.cell_m,
                    f64::from(my) * parameters.cell_m,
                );
                let range_m = x_m.hypot(y_m);
                let delay = parameters.delay_of_range(range_m);
                if range_m < parameters.min_range_m || delay >= parameters.delays() {
                    blind.push([mx, my]);
                } else {
                    near.push((y_m.atan2(x_m), delay as u32, [mx, my]));
                }
            }
        }
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let angles_rad: Vec<f64> = near.iter().map(|pixel| pixel.0).collect();
        let sectors = (0..SECTORS).map(|sector| {
            let start_rad = 2.0 * PI * sector as f64 / SECTORS as f64 - PI;
            angles_rad.partition_point(|&angle| angle < start_rad) as u32
        });
        Self {
            half_cells,
            sectors: sectors.collect(),
            angles_rad,
            delays: near.iter().map(|pixel| pixel.1).collect(),
            offsets: near.iter().map(|pixel| pixel.2).chain(blind).collect(),
        }
    }

    /// Pixels of an image.
    pub fn len(&self) -> usize {
        self.offsets.len()
    }

    /// True for a window without pixels, which there is not.
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

    /// Draws the echo image of one block for a heading; `polar` is `[direction, delay]`, or one row for all directions.
    ///
    /// `image` has [`Self::len`] elements in the order of [`Self::offsets`].
    pub fn draw(&self, polar: ArrayView2<'_, f32>, heading_rad: f64, image: &mut [f32]) {
        let lit = self.angles_rad.len();
        image[lit..].fill(0.0);
        let Some(directions) = polar.nrows().checked_sub(1) else {
            return image.fill(0.0);
        };
        if directions == 0 {
            return self.copy_run(&polar, 0, 0, lit, image);
        }
        self.for_each_run(directions, heading_rad, |direction, run| {
            self.copy_run(&polar, direction, run.start, run.end, image);
        });
    }

    /// Pixels with an echo; they come first in the order of the images.
    pub(crate) fn lit(&self) -> usize {
        self.angles_rad.len()
    }

    /// Delays of the pixels with an echo, in samples.
    pub(crate) fn delays(&self) -> &[u32] {
        &self.delays
    }

    /// Calls `told` with the direction's index for all runs of neighbouring pixels that see one direction under a heading. The
    /// runs follow one another and cover all pixels with an echo; there are at most [`most_runs`] of them.
    pub(crate) fn for_each_run(
        &self,
        directions: usize,
        heading_rad: f64,
        mut told: impl FnMut(usize, Range<usize>),
    ) {
        let lit = self.lit();
        let heading_rad = wrap_angle(heading_rad);
        let width_rad = PI / directions as f64;
        // Ahead and astern the bearing turns around; between these cuts it is monotone, so a direction is one run.
        let cut = |angle_rad: f64| self.angles_rad.partition_point(|&angle| angle < angle_rad);
        let opposite = cut(wrap_angle(heading_rad + PI));
        let ahead = cut(heading_rad);
        let mut start = 0;
        let index =
            |pixel: usize| direction_index(self.angles_rad[pixel] - heading_rad, directions);
        for segment in [opposite.min(ahead), opposite.max(ahead), lit] {
            // Direction of the next run and the angle at which it should end: guessed from the run before, so that a processor
            // need not wait for one run before it begins the next.
            let mut guess = (usize::MAX, 0.0);
            while start < segment {
                let direction = index(start);
                let turned_rad = wrap_angle(self.angles_rad[start] - heading_rad);
                let rises = turned_rad >= 0.0;
                if guess.0 != direction {
                    let left_rad = if rises {
                        (direction as f64 + 0.5) * width_rad - turned_rad
                    } else {
                        -turned_rad - (direction as f64 - 0.5) * width_rad
                    };
                    guess = (direction, self.angles_rad[start] + left_rad);
                }
                // Rounding may put the end some pixels beside.
                let mut end = self.place_of(guess.1).clamp(start + 1, segment);
                while end < segment && index(end) == direction {
                    end += 1;
                }
                while end > start + 1 && index(end - 1) != direction {
                    end -= 1;
                }
                told(direction, start..end);
                start = end;
                let next = if rises {
                    direction + 1
                } else {
                    direction.wrapping_sub(1)
                };
                guess = (next, guess.1 + width_rad);
            }
        }
    }

    /// About where an angle has its place in the order; angles beyond the turn have theirs at its ends.
    fn place_of(&self, angle_rad: f64) -> usize {
        let sector = ((angle_rad + PI) * (SECTORS as f64 / (2.0 * PI))) as usize;
        self.sectors
            .get(sector)
            .map_or(self.lit(), |&place| place as usize)
    }

    fn copy_run(
        &self,
        polar: &ArrayView2<'_, f32>,
        direction: usize,
        start: usize,
        end: usize,
        image: &mut [f32],
    ) {
        let row = polar.row(direction);
        let delays = &self.delays[start..end];
        if let Some(row) = row.as_slice() {
            for (pixel, &delay) in image[start..end].iter_mut().zip(delays) {
                *pixel = row.get(delay as usize).copied().unwrap_or(0.0);
            }
        } else {
            for (pixel, &delay) in image[start..end].iter_mut().zip(delays) {
                *pixel = row.get(delay as usize).copied().unwrap_or(0.0);
            }
        }
    }

    /// An image in the order of the window as an array `[my + N_W, mx + N_W]`.
    pub fn to_array(&self, image: &[f32]) -> Array2<f32> {
        let width = 2 * self.half_cells + 1;
        let half = self.half_cells as i32;
        let mut array = Array2::zeros((width, width));
        for (&[mx, my], &value) in self.offsets.iter().zip(image) {
            array[[(my + half) as usize, (mx + half) as usize]] = value;
        }
        array
    }
}

/// Most runs that [`Window::for_each_run`] finds: every direction to the left and to the right, and the turn's two ends.
pub(crate) fn most_runs(directions: usize) -> usize {
    2 * directions + 6
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn polar(directions: usize, delays: usize) -> Array2<f32> {
        Array2::from_shape_fn((directions + 1, delays), |(n, k)| (n * 10_000 + k) as f32)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn drawing_agrees_with_the_printed_equations(heading in -10.0..10.0, half in 1_usize..30, directions in 1_usize..40) {
            let parameters = Parameters { max_range_m: 2.5, directions, ..Parameters::default() };
            let window = Window::new(&parameters, half);
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
        let window = Window::new(&parameters, 10);
        let mut image = vec![0.0; window.len()];
        window.draw(polar(0, parameters.delays()).view(), 1.0, &mut image);
        let array = window.to_array(&image);
        assert_eq!(array[[10, 15]], array[[15, 10]]);
        assert_eq!(array[[10, 15]], parameters.delay_of_range(0.5) as f32);
        assert_eq!(array[[10, 10]], 0.0);
        assert_eq!(array[[10, 12]], 0.0);
    }

    #[test]
    fn left_and_right_of_the_heading_look_the_same() {
        let parameters = Parameters::default();
        let window = Window::new(&parameters, 20);
        let mut image = vec![0.0; window.len()];
        window.draw(polar(29, parameters.delays()).view(), 0.0, &mut image);
        let array = window.to_array(&image);
        for my in 0..=20 {
            assert_eq!(array.row(20 + my), array.row(20 - my));
        }
    }
}
