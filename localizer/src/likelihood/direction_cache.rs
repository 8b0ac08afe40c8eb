//! Quantized echo images of one block under many headings.
//!
//! Under similar headings a pixel looks into the same few directions. The echoes of each direction are therefore laid out over
//! the window's pixels, a sheet per direction, piece by piece as headings ask for them; an image is then put together from a few dozen
//! contiguous arcs. The same holds for the bins, as long as the images' maxima are equal: ask for images in the order of their maxima.
//!
//! From one heading to another close by, only those pixels change over which the borders between directions move. The maxima of sorted
//! headings are followed from one to the next, and so may be whatever the images are used for.

use std::f64::consts::PI;
use std::ops::Range;

use ndarray::ArrayView2;

use crate::image::echo_image::ImageWindow;
use crate::likelihood::mutual_information::{largest_of, quantize_by};
use crate::pose::wrap_angle;

/// Pixels of a piece.
const PIECE: usize = 32;
/// The largest echo of a piece that is not laid out.
const NOT_YET: f32 = -1.0;

/// Echoes of all directions over the pixels of a window, in its order, and the images that are put together from them.
pub(crate) struct DirectionCache {
    directions: usize,
    pieces: Strips,
    /// Borders of all images, see [`crate::image::bearing_index::BearingIndex::borders`].
    borders: Vec<u32>,
}

/// What a heading's image is put together from.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct ImageLayout {
    /// Largest echo of the image.
    pub(crate) largest: f32,
    /// A pixel that has it.
    brightest: usize,
    heading_rad: f64,
    borders: Range<usize>,
}

impl DirectionCache {
    /// For so many directions above 0, bins, and images of one block.
    pub(crate) fn new(window: &ImageWindow, directions: usize, bins: usize, images: usize) -> Self {
        Self {
            directions,
            pieces: Strips::new(window.lit(), directions, bins),
            borders: Vec::with_capacity(images * 2 * directions),
        }
    }

    /// Directions above 0 that they were made for.
    pub(crate) fn directions(&self) -> usize {
        self.directions
    }

    /// Forgets the block.
    pub(crate) fn clear(&mut self) {
        self.pieces.clear();
        self.borders.clear();
    }

    /// Looks for what the image of a heading is put together from. `polar` is `[direction, delay]`, the same until [`Self::clear`];
    /// `before` is an earlier outline, best that of a heading close by.
    pub(crate) fn outline(
        &mut self,
        window: &ImageWindow,
        polar: ArrayView2<'_, f32>,
        heading_rad: f64,
        before: Option<&ImageLayout>,
    ) -> ImageLayout {
        let first = self.borders.len();
        self.borders.resize(first + 2 * self.directions, 0);
        window
            .bearings()
            .borders(self.directions, heading_rad, &mut self.borders[first..]);
        let mut outline = ImageLayout {
            largest: 0.0,
            brightest: 0,
            heading_rad,
            borders: first..self.borders.len(),
        };
        let followed = before
            .filter(|before| self.is_close(before, &outline))
            .and_then(|before| self.follow(window, polar, before, &outline));
        (outline.largest, outline.brightest) =
            followed.unwrap_or_else(|| self.search(window, polar, &outline));
        outline
    }

    /// Largest echo and its pixel, from those of an outline close by; nothing if a smaller echo might now be the largest.
    fn follow(
        &mut self,
        window: &ImageWindow,
        polar: ArrayView2<'_, f32>,
        before: &ImageLayout,
        outline: &ImageLayout,
    ) -> Option<(f32, usize)> {
        let (mut largest, mut brightest) = (before.largest, before.brightest);
        let mut lost = false;
        window.bearings().for_each_change(
            &self.borders[before.borders.clone()],
            &self.borders[outline.borders.clone()],
            |_, direction, pixels| {
                lost |= pixels.contains(&before.brightest);
                for piece in pieces_of(&pixels) {
                    self.pieces.lay_out(window, polar, direction, piece);
                }
                let echoes = &self.pieces.echoes(direction)[pixels.clone()];
                for (pixel, &echo) in pixels.zip(echoes) {
                    if echo > largest {
                        (largest, brightest) = (echo, pixel);
                    }
                }
            },
        );
        (!lost || brightest != before.brightest).then_some((largest, brightest))
    }

    /// Largest echo and its pixel, from all arcs.
    fn search(
        &mut self,
        window: &ImageWindow,
        polar: ArrayView2<'_, f32>,
        outline: &ImageLayout,
    ) -> (f32, usize) {
        let (mut largest, mut brightest) = (0.0, 0);
        let borders = &self.borders[outline.borders.clone()];
        window.bearings().for_each_arc(borders, |direction, arc| {
            for piece in pieces_of(&arc) {
                // Few pieces have what it takes to raise the maximum.
                if self.pieces.lay_out(window, polar, direction, piece) <= largest {
                    continue;
                }
                let part = arc.start.max(piece * PIECE)..arc.end.min((piece + 1) * PIECE);
                let echoes = &self.pieces.echoes(direction)[part.clone()];
                for (pixel, &echo) in part.zip(echoes) {
                    if echo > largest {
                        (largest, brightest) = (echo, pixel);
                    }
                }
            }
        });
        (largest, brightest)
    }

    /// Writes the bins of an image, eq. (14), in the order of the window; pixels without an echo are zero.
    pub(crate) fn draw(&mut self, window: &ImageWindow, outline: &ImageLayout, image: &mut [u8]) {
        if outline.largest <= 0.0 {
            return image.fill(0);
        }
        let borders = &self.borders[outline.borders.clone()];
        window.bearings().for_each_arc(borders, |direction, arc| {
            self.pieces.quantize(direction, &arc, outline.largest);
            image[arc.clone()].copy_from_slice(&self.pieces.bins(direction)[arc]);
        });
        image[window.lit()..].fill(0);
    }

    /// True if [`Self::for_each_change`] can tell how the images of two outlines differ.
    pub(crate) fn is_change(&self, before: &ImageLayout, outline: &ImageLayout) -> bool {
        before.largest == outline.largest && self.is_close(before, outline)
    }

    /// Calls `told` with all stretches of pixels that see another direction in one image than in another: the first pixel, their bins there and
    /// here. `before` was drawn, or followed, before any image with another maximum; [`Self::is_change`] holds.
    pub(crate) fn for_each_change(
        &mut self,
        window: &ImageWindow,
        before: &ImageLayout,
        outline: &ImageLayout,
        mut told: impl FnMut(usize, &[u8], &[u8]),
    ) {
        if outline.largest <= 0.0 {
            return;
        }
        window.bearings().for_each_change(
            &self.borders[before.borders.clone()],
            &self.borders[outline.borders.clone()],
            |old, new, pixels| {
                self.pieces.quantize(new, &pixels, outline.largest);
                let [old, new] = [old, new].map(|direction| self.pieces.bins(direction));
                told(pixels.start, &old[pixels.clone()], &new[pixels]);
            },
        );
    }

    /// True if the borders of two outlines are those before and after a small turn.
    fn is_close(&self, before: &ImageLayout, outline: &ImageLayout) -> bool {
        let turned = wrap_angle(outline.heading_rad - before.heading_rad).abs();
        turned < 0.49 * PI / self.directions as f64
    }
}

/// Numbers of the pieces that hold some pixels.
fn pieces_of(pixels: &Range<usize>) -> Range<usize> {
    pixels.start / PIECE..pixels.end.div_ceil(PIECE)
}

/// Echoes and their bins, sheet after sheet, each of whole pieces.
struct Strips {
    bins: usize,
    /// Strips of a sheet.
    per_sheet: usize,
    echoes: Vec<f32>,
    /// Largest echo of each piece; negative until it is laid out.
    largest: Vec<f32>,
    /// Bins of `echoes`.
    quantized: Vec<u8>,
    /// Maximum by which a piece of `quantized` was made; zero for none.
    maxima: Vec<f32>,
}

impl Strips {
    /// Of sheets for directions 0 to `directions`.
    fn new(pixels: usize, directions: usize, bins: usize) -> Self {
        let per_sheet = pixels.div_ceil(PIECE);
        let count = (directions + 1) * per_sheet;
        Self {
            bins,
            per_sheet,
            echoes: vec![0.0; count * PIECE],
            largest: vec![NOT_YET; count],
            quantized: vec![0; count * PIECE],
            maxima: vec![0.0; count],
        }
    }

    fn clear(&mut self) {
        self.largest.fill(NOT_YET);
        self.maxima.fill(0.0);
    }

    /// Echoes of a direction over the pixels, as far as they are laid out.
    fn echoes(&self, direction: usize) -> &[f32] {
        &self.echoes[direction * self.per_sheet * PIECE..][..self.per_sheet * PIECE]
    }

    /// Bins of a direction over the pixels, as far as they are quantized.
    fn bins(&self, direction: usize) -> &[u8] {
        &self.quantized[direction * self.per_sheet * PIECE..][..self.per_sheet * PIECE]
    }

    /// Lays a piece of a sheet out, if it is not yet, and returns its largest echo.
    fn lay_out(
        &mut self,
        window: &ImageWindow,
        polar: ArrayView2<'_, f32>,
        direction: usize,
        piece: usize,
    ) -> f32 {
        let place = direction * self.per_sheet + piece;
        if self.largest[place] < 0.0 {
            let echoes = &mut self.echoes[place * PIECE..][..PIECE];
            let row = polar.row(direction);
            window.look_up(row, piece * PIECE, echoes);
            self.largest[place] = largest_of(echoes);
        }
        self.largest[place]
    }

    /// Makes the bins of some pixels of a direction, all laid out, for images with the maximum `largest`.
    fn quantize(&mut self, direction: usize, pixels: &Range<usize>, largest: f32) {
        let sheet = direction * self.per_sheet;
        for piece in pieces_of(pixels) {
            let place = sheet + piece;
            if self.maxima[place] != largest {
                self.maxima[place] = largest;
                let pixels = place * PIECE..(place + 1) * PIECE;
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
    use crate::likelihood::mutual_information::quantize;
    use crate::parameters::{MeasurementParameters, Parameters};
    use ndarray::Array2;
    use proptest::prelude::*;

    proptest! {
            #![proptest_config(ProptestConfig::with_cases(64))]
            #[test]
            fn images_are_those_drawn_one_by_one(
                start in -10.0..10.0,
                turns in prop::collection::vec(-0.1..0.1, 1..24),
                half in 1_usize..30,
                directions in 1_usize..40,
                power in 0_i32..6,
            ) {
                let parameters = Parameters { measurement: MeasurementParameters { max_range_m: 2.5,
    directions,
    ..MeasurementParameters::default() },
    ..Parameters::default() };
                let window = ImageWindow::new(&parameters, half);
                let headings: Vec<f64> = turns
                    .iter()
                    .scan(start, |heading: &mut f64, turn| {
                        *heading += turn;
                        Some(*heading)
                    })
                    .collect();
                let mut sheets = DirectionCache::new(&window, directions, 127, headings.len());
                let mut image = vec![0.0; window.len()];
                let (mut expected, mut drawn) = (vec![0; window.len()], vec![9; window.len()]);
                for block in 0..2 {
                    let polar = Array2::from_shape_fn((directions + 1, parameters.delays()), |(n, k)| {
                        (((n * 7 + k * 13 + block) % 101) as f32).powi(power) - 1.0
                    });
                    sheets.clear();
                    let mut outlines: Vec<ImageLayout> = Vec::new();
                    for &heading in &headings {
                        outlines.push(sheets.outline(&window, polar.view(), heading, outlines.last()));
                    }
                    let mut before: Option<ImageLayout> = None;
                    for (&heading, outline) in headings.iter().zip(outlines) {
                        window.draw(polar.view(), heading, &mut image);
                        quantize(&image, 127, &mut expected);
                        prop_assert_eq!(outline.largest, largest_of(&image));
                        if let Some(before) = before.filter(|before| sheets.is_change(before, &outline)) {
                            let mut followed = drawn.clone();
                            sheets.for_each_change(&window, &before, &outline, |start, old, new| {
                                let part = &mut followed[start..start + old.len()];
                                assert_eq!(part, old);
                                part.copy_from_slice(new);
                            });
                            prop_assert_eq!(&followed, &expected);
                        }
                        sheets.draw(&window, &outline, &mut drawn);
                        prop_assert_eq!(&drawn, &expected);
                        before = Some(outline);
                    }
                }
            }
        }
}
