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

/// Parts of the turn whose place in the order of angles is on file.
const SECTORS: usize = 4096;

/// Pixels that a search along the order of angles looks at together.
const AT_ONCE: usize = 4;

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
        let per_rad = directions as f64 / PI;
        let heading_rad = wrap_angle(heading_rad);
        let cut = |angle_rad: f64| self.place_of(angle_rad, |pixel_rad| pixel_rad < angle_rad);
        let (ahead, opposite) = (cut(heading_rad), cut(wrap_angle(heading_rad + PI)));
        // Ahead and astern the bearing turns around; between these cuts it is monotone, so a direction is one run. Each stretch has its end,
        // its side (left is positive) and the turns by which its bearings differ from angle less heading.
        let stretches = if heading_rad > 0.0 {
            [(opposite, 1.0, 1.0), (ahead, -1.0, 0.0), (lit, 1.0, 0.0)]
        } else {
            [(ahead, -1.0, 0.0), (opposite, 1.0, 0.0), (lit, -1.0, -1.0)]
        };
        let mut start = 0;
        for (stretch, side, turns) in stretches {
            let added_rad = 2.0 * PI * turns;
            // The direction's number before its fraction is cut off, eqs. (6) and (16).
            let place =
                |angle_rad: f64| per_rad * (side * (angle_rad - heading_rad + added_rad)) + 0.5;
            let angle_of = |place: f64| heading_rad - added_rad + side * (place - 0.5) / per_rad;
            if start >= stretch {
                continue;
            }
            let mut direction = place(self.angles_rad[start]) as usize;
            while start < stretch {
                let end = match (side > 0.0, direction) {
                    (true, last) if last >= directions => stretch,
                    (true, _) => {
                        let limit = (direction + 1) as f64;
                        self.place_of(angle_of(limit), |angle| place(angle) < limit)
                    }
                    (false, 0) => stretch,
                    (false, _) => {
                        let limit = direction as f64;
                        self.place_of(angle_of(limit), |angle| place(angle) >= limit)
                    }
                };
                let end = end.clamp(start, stretch);
                if end > start {
                    told(direction, start..end);
                }
                start = end;
                direction = if side > 0.0 {
                    direction + 1
                } else {
                    direction.saturating_sub(1)
                };
            }
        }
    }

    /// Number of pixels for whose angles `before` holds: the first ones in the order, up to about `guess_rad`.
    fn place_of(&self, guess_rad: f64, before: impl Fn(f64) -> bool) -> usize {
        let angles = self.angles_rad.as_slice();
        let sector = ((guess_rad + PI) * (SECTORS as f64 / (2.0 * PI))) as usize;
        let mut place = self
            .sectors
            .get(sector)
            .map_or(angles.len(), |&place| place as usize);
        // Rounding may have put it behind.
        while place > 0 && !before(angles[place - 1]) {
            place -= 1;
        }
        // A sector holds about one pixel: counting some more at once leaves no branch that would be guessed wrong.
        while let Some(next) = angles.get(place..place + AT_ONCE) {
            let count: usize = next.iter().map(|&angle| usize::from(before(angle))).sum();
            place += count;
            if count < AT_ONCE {
                return place;
            }
        }
        while angles.get(place).is_some_and(|&angle| before(angle)) {
            place += 1;
        }
        place
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
