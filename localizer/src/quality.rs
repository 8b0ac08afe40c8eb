//! How far the estimates of a drive can be trusted: whether the code is in the signal at all, and how much better the
//! echoes of each block fit the map at the estimated pose than around it.
//!
//! * **Contrast** of a block: the largest echo over the median of its direction, where that is largest. Noise alone has
//!   the contrast of the largest of so many Rayleigh numbers over their median, whatever its level
//!   ([`noise_contrast`]), and so has what the code makes of another one: all delays of a direction get a like part of
//!   its sound. Directions do not, for a sound that does not move lies in the middle one, so that the median of all
//!   says nothing.
//! * **Fit** of an estimate: the correlation r of its echo image with the map's patch, less the mean of those at poses
//!   displaced by half a metre and a metre to all sides, in standard deviations of these. An estimate that the map says
//!   nothing about has a fit near 0.

use std::f64::consts::TAU;

use ndarray::ArrayView2;

use crate::echo::echo_blocks::{EchoBlock, EchoSequence};
use crate::error::Error;
use crate::filter::tracker::Estimate;
use crate::image::echo_image::ImageWindow;
use crate::image::map_image::MapImage;
use crate::parameters::{Method, Parameters};
use crate::pose::Pose;

/// The code is in a block whose contrast is this many times that of noise.
const CODE_FOUND: f64 = 1.5;
/// Distances of the poses of comparison in metres, and how many there are at each.
const AROUND_M: [f64; 2] = [0.5, 1.0];
const BEARINGS: usize = 8;
/// Estimates before and after one whose fits count for its status: about a second together.
const NEIGHBOURS: usize = 5;
/// Mean fit from which an estimate is sure.
const SURE: f64 = 1.5;
/// Most pixels to a side of the compared images.
const MOST_HALF_CELLS: usize = 40;

/// How far one estimate can be trusted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Standard deviations by which its echoes fit better than around it, see [the module](self).
    pub fit: f64,
    /// Whether fits are high there and in its neighbourhood.
    pub sure: bool,
}

/// Refuses a signal without any sound: silent, or constant, as a dead microphone records.
///
/// # Errors
/// [`Error::Invalid`] that names `origin` and the file.
pub fn check_signal(signal: &[f32], origin: &str) -> Result<(), Error> {
    let first = signal.first().copied().unwrap_or_default();
    if signal.iter().any(|&sample| sample != first) {
        return Ok(());
    }
    let problem = format!("all samples are {first}: the microphone was dead");
    let remedy = "check its plug and its gain, and record again";
    Err(Error::invalid(origin, "signal.wav", problem, remedy))
}

/// Contrast of a block of noise: of `count` Rayleigh numbers, each the largest of `pooled`.
fn noise_contrast(count: f64, pooled: f64) -> f64 {
    let largest = (2.0 * (count * pooled).max(2.0).ln()).sqrt();
    let median = (-2.0 * (1.0 - 0.5_f64.powf(1.0 / pooled)).ln()).sqrt();
    largest / median
}

/// Contrast of the echoes `[direction, delay]` from a delay on; 0 of silence.
fn contrast(echoes: ArrayView2<'_, f32>, first: usize) -> f64 {
    let mut values = Vec::with_capacity(echoes.ncols());
    let rows = echoes.rows().into_iter().map(|row| {
        values.clear();
        values.extend(row.into_iter().skip(first).copied());
        let largest = values.iter().copied().fold(0.0, f32::max);
        let middle = values.len() / 2;
        if values.is_empty() {
            return 0.0;
        }
        let (_, &mut median, _) = values.select_nth_unstable_by(middle, f32::total_cmp);
        match median > 0.0 {
            true => f64::from(largest / median),
            false => 0.0,
        }
    });
    rows.fold(0.0, f64::max)
}

/// Counts the blocks of a drive in which the code is, one after the other.
#[derive(Debug, Clone)]
pub struct CodeMeter {
    /// First delay that counts, and delays over which the largest counts.
    nearest: usize,
    pooled: usize,
    moving: usize,
    with_code: usize,
}

impl CodeMeter {
    /// A meter of no block.
    pub fn new(parameters: &Parameters) -> Self {
        let delay = |range_m| parameters.signal.delay_of_range(range_m);
        Self {
            nearest: delay(parameters.measurement.min_range_m),
            pooled: 1 + 2 * delay(parameters.measurement.range_pool_m),
            moving: 0,
            with_code: 0,
        }
    }

    /// A meter of a whole drive.
    pub fn of(echoes: &EchoSequence) -> Self {
        let mut meter = Self::new(&echoes.parameters);
        echoes.blocks.iter().for_each(|block| meter.add(block));
        meter
    }

    /// Adds a block.
    pub fn add(&mut self, block: &EchoBlock) {
        if block.stationary {
            return;
        }
        let cells = block.intensity.len() as f64;
        let noise = noise_contrast(cells / self.pooled as f64, self.pooled as f64);
        self.moving += 1;
        if contrast(block.intensity.view(), self.nearest) > CODE_FOUND * noise {
            self.with_code += 1;
        }
    }

    /// Share of the moving blocks in which the code is; `None` when the robot never moves. White noise, another code,
    /// length or carrier give next to 0, echoes of a tenth of the noise's power next to 1.
    pub fn share(&self) -> Option<f64> {
        (self.moving > 0).then(|| self.with_code as f64 / self.moving as f64)
    }
}

/// Compares the echoes of a drive with the map at the estimates, one block after the other.
pub struct FitMeter<'a> {
    map: &'a MapImage,
    comparison: Comparison,
    /// Where the robot rests there is no fit of its own.
    own: Vec<Option<f64>>,
}

impl<'a> FitMeter<'a> {
    /// A meter of no estimate.
    pub fn new(parameters: &Parameters, map: &'a MapImage) -> Self {
        let method = match parameters.filter.method {
            Method::ToaOnly => Method::ToaOnly,
            Method::Doppler | Method::Odometry => Method::Doppler,
        };
        Self {
            map,
            comparison: Comparison::new(parameters, method),
            own: Vec::new(),
        }
    }

    /// Adds a block and its estimate.
    pub fn add(&mut self, block: &EchoBlock, estimate: &Estimate) {
        let fit = |comparison: &mut Comparison| comparison.fit(block, self.map, &estimate.pose);
        self.own
            .push((!block.stationary).then(|| fit(&mut self.comparison)));
    }

    /// Fit and status of every estimate.
    pub fn finish(self) -> Vec<Fit> {
        let own = self.own;
        (0..own.len())
            .map(|index| {
                let near =
                    index.saturating_sub(NEIGHBOURS)..(index + NEIGHBOURS + 1).min(own.len());
                let fits: Vec<f64> = own[near].iter().flatten().copied().collect();
                let mean = fits.iter().sum::<f64>() / fits.len().max(1) as f64;
                Fit {
                    fit: own[index].unwrap_or_default(),
                    sure: mean >= SURE,
                }
            })
            .collect()
    }
}

/// Buffers for comparing echo images with the map.
struct Comparison {
    window: ImageWindow,
    method: Method,
    sensor_offset_m: [f64; 2],
    image: Vec<f32>,
    patch: Vec<f32>,
}

impl Comparison {
    fn new(parameters: &Parameters, method: Method) -> Self {
        let half = parameters.window_cells().min(MOST_HALF_CELLS);
        let window = ImageWindow::new(parameters, half);
        Self {
            image: vec![0.0; window.len()],
            patch: vec![0.0; window.len()],
            sensor_offset_m: parameters.signal.sensor_offset_m,
            window,
            method,
        }
    }

    fn fit(&mut self, block: &EchoBlock, map: &MapImage, pose: &Pose) -> f64 {
        let sensor = pose.carried(self.sensor_offset_m);
        let polar = block.polar(self.method);
        self.window.draw(polar, sensor.heading_rad, &mut self.image);
        let here = self.correlation(map, &sensor);
        let around: Vec<f64> = AROUND_M
            .iter()
            .flat_map(|distance_m| (0..BEARINGS).map(move |bearing| (distance_m, bearing)))
            .map(|(distance_m, bearing)| {
                let (sine, cosine) = (TAU * bearing as f64 / BEARINGS as f64).sin_cos();
                let displaced = Pose {
                    x_m: sensor.x_m + distance_m * cosine,
                    y_m: sensor.y_m + distance_m * sine,
                    ..sensor
                };
                self.correlation(map, &displaced)
            })
            .collect();
        let count = around.len() as f64;
        let mean = around.iter().sum::<f64>() / count;
        let variance = around.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / count;
        match variance > 0.0 {
            true => (here - mean) / variance.sqrt(),
            false => 0.0,
        }
    }

    /// Correlation of the image with the map's patch at a pose; 0 where one of them is constant.
    fn correlation(&mut self, map: &MapImage, pose: &Pose) -> f64 {
        let cell = map.cell_of(pose);
        map.patch(self.method, &self.window, cell, &mut self.patch);
        let count = self.image.len() as f64;
        let mean = |image: &[f32]| image.iter().copied().map(f64::from).sum::<f64>() / count;
        let (mean_image, mean_patch) = (mean(&self.image), mean(&self.patch));
        let (mut product, mut image, mut patch) = (0.0, 0.0, 0.0);
        for (&a, &b) in self.image.iter().zip(&self.patch) {
            let (a, b) = (f64::from(a) - mean_image, f64::from(b) - mean_patch);
            product += a * b;
            image += a * a;
            patch += b * b;
        }
        let scale = (image * patch).sqrt();
        if scale > 0.0 { product / scale } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::image::map_builder;
    use crate::recording::Recording;
    use crate::{echo, offline};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    fn example(name: &str) -> Recording {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/site_robot");
        Recording::read(&folder.join(name)).unwrap()
    }

    fn measured(recording: &Recording) -> EchoSequence {
        let mut parameters = Parameters::default();
        parameters.filter.window_half_width_m = 3.0;
        echo::measure(recording, &parameters.for_recording(&recording.meta)).unwrap()
    }

    fn map() -> MapImage {
        let mapping = example("mapping");
        let echoes = measured(&mapping);
        let poses = echoes.poses(mapping.truth.as_ref().unwrap());
        map_builder::build(&[(&echoes, &poses)]).unwrap()
    }

    fn code_share(echoes: &EchoSequence) -> f64 {
        CodeMeter::of(echoes).share().unwrap()
    }

    /// Share of sure estimates and their median fit.
    fn trust(recording: &Recording, map: &MapImage, start: Pose) -> (f64, f64) {
        let echoes = measured(recording);
        let estimates = offline::localize(&echoes, map, &echoes.parameters, start, 0).unwrap();
        let mut meter = FitMeter::new(&echoes.parameters, map);
        for (block, estimate) in echoes.blocks.iter().zip(&estimates) {
            meter.add(block, estimate);
        }
        let fits = meter.finish();
        let sure = fits.iter().filter(|fit| fit.sure).count() as f64 / fits.len() as f64;
        let mut sorted: Vec<f64> = fits.iter().map(|fit| fit.fit).collect();
        sorted.sort_by(f64::total_cmp);
        (sure, sorted[sorted.len() / 2])
    }

    #[test]
    fn the_code_is_found_where_it_is() {
        let good = example("drive");
        assert_eq!(code_share(&measured(&good)), 1.0);
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut noise = good.clone();
        for sample in &mut noise.signal {
            *sample = random.sample::<f32, _>(StandardNormal);
        }
        assert_eq!(code_share(&measured(&noise)), 0.0);
        let mut backwards = good.clone();
        backwards.signal.reverse();
        assert!(code_share(&measured(&backwards)) < 0.05, "another code");
        let mut longer = good.clone();
        longer.meta.code_length = 2047;
        longer.meta.chip_rate_hz *= 2047.0 / 2046.0;
        assert!(
            code_share(&measured(&longer)) < 0.05,
            "a code of 2047 chips"
        );
        let mut carrier = good.clone();
        carrier.meta.carrier_hz = 9000.0;
        assert!(code_share(&measured(&carrier)) < 0.05, "another carrier");
        for value in [0.0, 0.25] {
            let mut dead = good.clone();
            dead.signal.fill(value);
            assert_eq!(code_share(&measured(&dead)), 0.0);
            let message = check_signal(&dead.signal, "drive").unwrap_err().to_string();
            assert!(
                message.contains("signal.wav") && message.contains("dead"),
                "{message}"
            );
        }
        check_signal(&good.signal, "drive").unwrap();
    }

    #[test]
    fn pooled_noise_has_less_contrast() {
        // Table: 30 directions of 2001 delays, and the largest of 9 each.
        assert!((noise_contrast(60_030.0, 1.0) - 3.99).abs() < 0.01);
        assert!((noise_contrast(60_030.0 / 9.0, 9.0) - 2.06).abs() < 0.02);
    }

    #[test]
    fn estimates_at_wrong_poses_are_not_sure() {
        let (map, good) = (map(), example("drive"));
        let start = good.start_pose();
        let (sure, fit) = trust(&good, &map, start);
        assert!(sure > 0.75 && fit > 2.5, "{sure} {fit}");
        let beside = Pose {
            x_m: start.x_m + 0.5,
            ..start
        };
        let (sure, fit) = trust(&good, &map, beside);
        assert!(sure < 0.2 && fit < 1.0, "{sure} {fit}");
        let mut turning = good.clone();
        for sample in &mut turning.odometry {
            sample.omega_radps += 0.5;
        }
        assert!(trust(&turning, &map, start).0 < 0.5);
        let mut far = good.clone();
        far.meta.microphone_offset_m = [3.0, 0.0];
        assert!(trust(&far, &map, start).0 < 0.2);
    }
}
