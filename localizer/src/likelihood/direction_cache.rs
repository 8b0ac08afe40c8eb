//! Direction cache: quantized echo images of one block under many headings.
//!
//! Under similar headings a pixel looks into the same few directions. The echoes of each direction are therefore laid
//! out once over the pixels of the window, in strips on demand, and an image is composed of contiguous arcs of them.
//! The same holds for bins as long as the maxima of images are equal: request images in the order of their maxima.
//!
//! Between two close headings only the pixels differ over which borders between directions move. Maxima of sorted
//! headings are updated from one to the next, and so can be quantities derived from images.

use std::f64::consts::PI;
use std::ops::Range;

use ndarray::ArrayView2;

use crate::image::echo_image::ImageWindow;
use crate::likelihood::mutual_information::{largest_of, quantize_by};
use crate::pose::wrap_angle;

/// Pixels of a strip: neighbours in the order of the window.
const STRIP: usize = 32;
/// Marks a strip that is not laid out, in place of its largest echo.
const EMPTY: f32 = -1.0;

/// Echoes of all directions over the pixels of a window, and the borders of the images composed of them.
pub(crate) struct DirectionCache {
    directions: usize,
    strips: Strips,
    /// Borders of all images, see [`crate::image::bearing_index::BearingIndex::borders`].
    borders: Vec<u32>,
}

/// The composition of the image of one heading.
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
    /// A cache for directions 0 to `directions`, bins 0 to `bins`, and `images` images of one block.
    pub(crate) fn new(window: &ImageWindow, directions: usize, bins: usize, images: usize) -> Self {
        Self {
            directions,
            strips: Strips::new(window.visible(), directions, bins),
            borders: Vec::with_capacity(images * 2 * directions),
        }
    }

    /// Index of the last direction.
    pub(crate) fn directions(&self) -> usize {
        self.directions
    }

    /// Starts a new block.
    pub(crate) fn clear(&mut self) {
        self.strips.clear();
        self.borders.clear();
    }

    /// The layout of the image of a heading. `polar` is `[direction, delay]`, the same until [`Self::clear`];
    /// `before` is an earlier layout, preferably of a close heading.
    pub(crate) fn layout(
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
        let mut layout = ImageLayout {
            largest: 0.0,
            brightest: 0,
            heading_rad,
            borders: first..self.borders.len(),
        };
        let followed = before
            .filter(|before| self.is_close(before, &layout))
            .and_then(|before| self.follow(window, polar, before, &layout));
        (layout.largest, layout.brightest) =
            followed.unwrap_or_else(|| self.search(window, polar, &layout));
        layout
    }

    /// Largest echo and its pixel, updated from a layout of a close heading; `None` if the previous maximum may be
    /// gone.
    fn follow(
        &mut self,
        window: &ImageWindow,
        polar: ArrayView2<'_, f32>,
        before: &ImageLayout,
        layout: &ImageLayout,
    ) -> Option<(f32, usize)> {
        let (mut largest, mut brightest) = (before.largest, before.brightest);
        let mut lost = false;
        window.bearings().for_each_change(
            &self.borders[before.borders.clone()],
            &self.borders[layout.borders.clone()],
            |_, direction, pixels| {
                lost |= pixels.contains(&before.brightest);
                for strip in strips_of(&pixels) {
                    self.strips.fill(window, polar, direction, strip);
                }
                let echoes = &self.strips.echoes(direction)[pixels.clone()];
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
        layout: &ImageLayout,
    ) -> (f32, usize) {
        let (mut largest, mut brightest) = (0.0, 0);
        let borders = &self.borders[layout.borders.clone()];
        window.bearings().for_each_arc(borders, |direction, arc| {
            for strip in strips_of(&arc) {
                // Few strips can raise the maximum.
                if self.strips.fill(window, polar, direction, strip) <= largest {
                    continue;
                }
                let part = arc.start.max(strip * STRIP)..arc.end.min((strip + 1) * STRIP);
                let echoes = &self.strips.echoes(direction)[part.clone()];
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
    pub(crate) fn draw(&mut self, window: &ImageWindow, layout: &ImageLayout, image: &mut [u8]) {
        if layout.largest <= 0.0 {
            return image.fill(0);
        }
        let borders = &self.borders[layout.borders.clone()];
        window.bearings().for_each_arc(borders, |direction, arc| {
            self.strips.quantize(direction, &arc, layout.largest);
            image[arc.clone()].copy_from_slice(&self.strips.bins(direction)[arc]);
        });
        image[window.visible()..].fill(0);
    }

    /// True if [`Self::for_each_change`] applies to two layouts.
    pub(crate) fn is_change(&self, before: &ImageLayout, layout: &ImageLayout) -> bool {
        before.largest == layout.largest && self.is_close(before, layout)
    }

    /// Calls `visit` for all ranges of pixels whose direction differs between two images: first pixel, bins before,
    /// bins after. `before` was drawn or visited before any image with another maximum, and [`Self::is_change`]
    /// holds.
    pub(crate) fn for_each_change(
        &mut self,
        window: &ImageWindow,
        before: &ImageLayout,
        layout: &ImageLayout,
        mut visit: impl FnMut(usize, &[u8], &[u8]),
    ) {
        if layout.largest <= 0.0 {
            return;
        }
        window.bearings().for_each_change(
            &self.borders[before.borders.clone()],
            &self.borders[layout.borders.clone()],
            |old, new, pixels| {
                self.strips.quantize(new, &pixels, layout.largest);
                let [old, new] = [old, new].map(|direction| self.strips.bins(direction));
                visit(pixels.start, &old[pixels.clone()], &new[pixels]);
            },
        );
    }

    /// True if two headings differ by less than half a direction step.
    fn is_close(&self, before: &ImageLayout, layout: &ImageLayout) -> bool {
        let turned = wrap_angle(layout.heading_rad - before.heading_rad).abs();
        turned < 0.49 * PI / self.directions as f64
    }
}

/// Indices of the strips that contain some pixels.
fn strips_of(pixels: &Range<usize>) -> Range<usize> {
    pixels.start / STRIP..pixels.end.div_ceil(STRIP)
}

/// Echoes and their bins, one row of strips per direction.
struct Strips {
    bins: usize,
    /// Strips per direction.
    per_direction: usize,
    echoes: Vec<f32>,
    /// Largest echo of each strip; negative until it is laid out.
    largest: Vec<f32>,
    /// Bins of `echoes`.
    quantized: Vec<u8>,
    /// Maximum by which each strip of `quantized` was made; zero for none.
    maxima: Vec<f32>,
}

impl Strips {
    /// Strips for directions 0 to `directions`.
    fn new(pixels: usize, directions: usize, bins: usize) -> Self {
        let per_direction = pixels.div_ceil(STRIP);
        let count = (directions + 1) * per_direction;
        Self {
            bins,
            per_direction,
            echoes: vec![0.0; count * STRIP],
            largest: vec![EMPTY; count],
            quantized: vec![0; count * STRIP],
            maxima: vec![0.0; count],
        }
    }

    fn clear(&mut self) {
        self.largest.fill(EMPTY);
        self.maxima.fill(0.0);
    }

    /// Echoes of a direction over the pixels, as far as they are laid out.
    fn echoes(&self, direction: usize) -> &[f32] {
        &self.echoes[direction * self.per_direction * STRIP..][..self.per_direction * STRIP]
    }

    /// Bins of a direction over the pixels, as far as they are quantized.
    fn bins(&self, direction: usize) -> &[u8] {
        &self.quantized[direction * self.per_direction * STRIP..][..self.per_direction * STRIP]
    }

    /// Lays out a strip of a direction unless it is already, and returns its largest echo.
    fn fill(
        &mut self,
        window: &ImageWindow,
        polar: ArrayView2<'_, f32>,
        direction: usize,
        strip: usize,
    ) -> f32 {
        let index = direction * self.per_direction + strip;
        if self.largest[index] < 0.0 {
            let echoes = &mut self.echoes[index * STRIP..][..STRIP];
            let row = polar.row(direction);
            window.look_up(row, strip * STRIP, echoes);
            self.largest[index] = largest_of(echoes);
        }
        self.largest[index]
    }

    /// Quantizes some pixels of a direction, all laid out, for images with the maximum `largest`.
    fn quantize(&mut self, direction: usize, pixels: &Range<usize>, largest: f32) {
        let first = direction * self.per_direction;
        for strip in strips_of(pixels) {
            let index = first + strip;
            if self.maxima[index] != largest {
                self.maxima[index] = largest;
                let pixels = index * STRIP..(index + 1) * STRIP;
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
                let mut cache = DirectionCache::new(&window, directions, 127, headings.len());
                let mut image = vec![0.0; window.len()];
                let (mut expected, mut drawn) = (vec![0; window.len()], vec![9; window.len()]);
                for block in 0..2 {
                    let polar = Array2::from_shape_fn((directions + 1, parameters.delays()), |(n, k)| {
                        (((n * 7 + k * 13 + block) % 101) as f32).powi(power) - 1.0
                    });
                    cache.clear();
                    let mut layouts: Vec<ImageLayout> = Vec::new();
                    for &heading in &headings {
                        layouts.push(cache.layout(&window, polar.view(), heading, layouts.last()));
                    }
                    let mut before: Option<ImageLayout> = None;
                    for (&heading, layout) in headings.iter().zip(layouts) {
                        window.draw(polar.view(), heading, &mut image);
                        quantize(&image, 127, &mut expected);
                        prop_assert_eq!(layout.largest, largest_of(&image));
                        if let Some(before) = before.filter(|before| cache.is_change(before, &layout)) {
                            let mut followed = drawn.clone();
                            cache.for_each_change(&window, &before, &layout, |start, old, new| {
                                let part = &mut followed[start..start + old.len()];
                                assert_eq!(part, old);
                                part.copy_from_slice(new);
                            });
                            prop_assert_eq!(&followed, &expected);
                        }
                        cache.draw(&window, &layout, &mut drawn);
                        prop_assert_eq!(&drawn, &expected);
                        before = Some(layout);
                    }
                }
            }
        }
}
