//! Quantized echo images of one block under many headings.
//!
//! Under similar headings a pixel looks into the same few directions. The echoes of each direction are therefore laid out over
//! the window's pixels, a sheet per direction, piece by piece as headings ask for them; an image is then put together from a few dozen
//! contiguous runs. The same holds for the bins, as long as the images' maxima are equal: ask for images in the order of their maxima. Two such
//! images differ where their runs differ.

use std::ops::Range;

use ndarray::ArrayView2;

use crate::echo_image::{Window, most_runs};
use crate::mutual_information::{largest_of, quantize_by};

/// Pixels of a piece.
const PIECE: usize = 64;
/// The largest echo of a piece that is not laid out.
const NOT_YET: f32 = -1.0;

/// Echoes of all directions over the pixels of a window, in its order.
pub(crate) struct Sheets {
    directions: usize,
    bins: usize,
    /// Pieces of a sheet.
    pieces: usize,
    /// Echoes, sheet after sheet, each of whole pieces.
    echoes: Vec<f32>,
    /// Largest echo of each piece; negative until it is laid out.
    brightest: Vec<f32>,
    /// Bins of `echoes`.
    quantized: Vec<u8>,
    /// Maximum by which a piece of `quantized` was made; zero for none.
    maxima: Vec<f32>,
    /// Runs of all images: direction, first pixel and the one after the last.
    runs: Vec<[u32; 3]>,
}

/// What a heading's image is put together from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Outline {
    /// Largest echo of the image.
    pub(crate) largest: f32,
    /// Its runs.
    runs: Range<usize>,
}

impl Sheets {
    /// For so many directions above 0, bins, and images of one block.
    pub(crate) fn new(window: &Window, directions: usize, bins: usize, images: usize) -> Self {
        let pieces = window.lit().div_ceil(PIECE);
        let count = (directions + 1) * pieces;
        Self {
            directions,
            bins,
            pieces,
            echoes: vec![0.0; count * PIECE],
            brightest: vec![NOT_YET; count],
            quantized: vec![0; count * PIECE],
            maxima: vec![0.0; count],
            runs: Vec::with_capacity(images * most_runs(directions)),
        }
    }

    /// Directions above 0 that they were made for.
    pub(crate) fn directions(&self) -> usize {
        self.directions
    }

    /// Forgets the block.
    pub(crate) fn clear(&mut self) {
        self.brightest.fill(NOT_YET);
        self.maxima.fill(0.0);
        self.runs.clear();
    }

    /// Looks for what the image of a heading is put together from. `polar` is `[direction, delay]`, the same until [`Self::clear`].
    pub(crate) fn outline(
        &mut self,
        window: &Window,
        polar: ArrayView2<'_, f32>,
        heading_rad: f64,
    ) -> Outline {
        let first = self.runs.len();
        let mut largest = 0.0;
        window.for_each_run(self.directions, heading_rad, |direction, run| {
            let sheet = direction * self.pieces;
            for piece in run.start / PIECE..run.end.div_ceil(PIECE) {
                let from = piece * PIECE;
                let echoes = &mut self.echoes[sheet * PIECE + from..][..PIECE];
                let brightest = &mut self.brightest[sheet + piece];
                if *brightest < 0.0 {
                    let row = polar.row(direction);
                    for (echo, &delay) in echoes.iter_mut().zip(&window.delays()[from..]) {
                        *echo = row.get(delay as usize).copied().unwrap_or(0.0);
                    }
                    *brightest = largest_of(echoes);
                }
                // Few pieces have what it takes to raise the maximum.
                if *brightest > largest {
                    let part = run.start.max(from) - from..run.end.min(from + PIECE) - from;
                    largest = largest_of(&echoes[part]).max(largest);
                }
            }
            self.runs
                .push([direction as u32, run.start as u32, run.end as u32]);
        });
        Outline {
            largest,
            runs: first..self.runs.len(),
        }
    }

    /// Writes the bins of an image, eq. (14), in the order of the window; pixels without an echo are zero.
    pub(crate) fn draw(&mut self, outline: &Outline, image: &mut [u8]) {
        if outline.largest <= 0.0 {
            return image.fill(0);
        }
        let mut drawn = 0;
        for run in outline.runs.clone() {
            let [direction, start, end] = self.run(run);
            self.quantize(direction, start..end, outline.largest);
            image[start..end].copy_from_slice(&self.sheet(direction)[start..end]);
            drawn = end;
        }
        image[drawn..].fill(0);
    }

    /// Calls `told` with all stretches of pixels that see another direction in one image than in another: the first pixel, their bins there and
    /// here. `before` was drawn, or followed, with the same maximum.
    pub(crate) fn for_each_change(
        &mut self,
        before: &Outline,
        outline: &Outline,
        mut told: impl FnMut(usize, &[u8], &[u8]),
    ) {
        if outline.largest <= 0.0 {
            return;
        }
        let (mut there, mut here) = (before.runs.start, outline.runs.start);
        let mut start = 0;
        // The runs of each image follow one another and end with the same pixel.
        while there < before.runs.end && here < outline.runs.end {
            let ([old, _, old_end], [new, _, new_end]) = (self.run(there), self.run(here));
            let end = old_end.min(new_end);
            if old != new && start < end {
                self.quantize(new, start..end, outline.largest);
                let (old, new) = (self.sheet(old), self.sheet(new));
                told(start, &old[start..end], &new[start..end]);
            }
            start = end;
            there += usize::from(old_end == end);
            here += usize::from(new_end == end);
        }
    }

    /// A run: direction, first pixel and the one after the last.
    fn run(&self, run: usize) -> [usize; 3] {
        self.runs[run].map(|number| number as usize)
    }

    /// Bins of a direction over the pixels.
    fn sheet(&self, direction: usize) -> &[u8] {
        &self.quantized[direction * self.pieces * PIECE..][..self.pieces * PIECE]
    }

    /// Makes the bins of some pixels of a direction for images with the maximum `largest`.
    fn quantize(&mut self, direction: usize, pixels: Range<usize>, largest: f32) {
        let sheet = direction * self.pieces;
        for piece in sheet + pixels.start / PIECE..sheet + pixels.end.div_ceil(PIECE) {
            if self.maxima[piece] != largest {
                self.maxima[piece] = largest;
                let pixels = piece * PIECE..(piece + 1) * PIECE;
                quantize_by(
                    largest,
                    &self.echoes[pixels.clone()],
                    self.bins,
                    &mut self.quantized[pixels],
                );
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mutual_information::quantize;
    use crate::parameters::Parameters;
    use ndarray::Array2;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn images_are_those_drawn_one_by_one(
            headings in prop::collection::vec(-10.0..10.0, 1..12),
            half in 1_usize..30,
            directions in 1_usize..40,
            power in 0_i32..6,
        ) {
            let parameters = Parameters { max_range_m: 2.5, directions, ..Parameters::default() };
            let window = Window::new(&parameters, half);
            let mut sheets = Sheets::new(&window, directions, 127, headings.len());
            let mut image = vec![0.0; window.len()];
            let (mut expected, mut drawn) = (vec![0; window.len()], vec![9; window.len()]);
            for block in 0..2 {
                let polar = Array2::from_shape_fn((directions + 1, parameters.delays()), |(n, k)| {
                    (((n * 7 + k * 13 + block) % 101) as f32).powi(power) - 1.0
                });
                sheets.clear();
                let outlines: Vec<Outline> = headings
                    .iter()
                    .map(|&heading| sheets.outline(&window, polar.view(), heading))
                    .collect();
                let mut before: Option<Outline> = None;
                for (&heading, outline) in headings.iter().zip(outlines) {
                    window.draw(polar.view(), heading, &mut image);
                    quantize(&image, 127, &mut expected);
                    if let Some(before) = before.filter(|before| before.largest == outline.largest) {
                        let mut followed = drawn.clone();
                        sheets.for_each_change(&before, &outline, |start, old, new| {
                            let part = &mut followed[start..start + old.len()];
                            assert_eq!(part, old);
                            part.copy_from_slice(new);
                        });
                        prop_assert_eq!(&followed, &expected);
                    }
                    sheets.draw(&outline, &mut drawn);
                    prop_assert_eq!(&drawn, &expected);
                    before = Some(outline);
                }
            }
        }
    }
}
