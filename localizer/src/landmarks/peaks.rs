//! Peaks of H(delay, direction): one echo each, between the samples in delay and between the directions.

use std::f64::consts::PI;

use ndarray::ArrayView2;

use crate::parameters::Parameters;

/// One echo of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Half the length of the echo's path in metres, at the instant of the block.
    pub range_m: f64,
    /// Cosine of the angle between the heading and the echo's direction.
    pub cosine: f64,
    /// Value of H: 1 for an echo of the amplitude that was sent.
    pub amplitude: f64,
}

/// Peaks of one block, at most this many.
pub const MOST_PEAKS: usize = 14;
/// Least height of a peak over the block's median.
const LEAST_STRENGTH: f32 = 4.0;
/// A peak is the largest of H within so many directions and samples to both sides.
const REACH: [usize; 2] = [2, 4];
/// Least part of the strongest peaks lately: what is weaker is no echo but what correlation and direct wave leave.
const LEAST_PART: f32 = 0.06;
/// Blocks over which the strongest peak is remembered.
const MEMORY_BLOCKS: f32 = 100.0;
/// Every so many-th value is looked at for the median.
const MEDIAN_STRIDE: usize = 7;
/// Part of a peak's height below which another one at the same delay is its side lobe in direction.
const SIDE_LOBE: f32 = 0.3;
/// Distance in cosine, in widths c/(2 f_c M T v) of the Doppler resolution, of the values a parabola goes through.
const NODE_WIDTHS: f64 = 0.35;

/// A plan to find the peaks of blocks measured with one set of parameters, and its buffers.
#[derive(Debug, Clone)]
pub struct PeakFinder {
    cosines: Vec<f64>,
    metres_per_sample: f64,
    first_delay: usize,
    /// Width of the Doppler resolution in cosine at 1 m/s.
    width_mps: f64,
    /// Height of the strongest peaks lately.
    strongest: f32,
    sorted: Vec<f32>,
    candidates: Vec<(f32, usize, usize)>,
}

impl PeakFinder {
    /// A plan; `parameters` must pass [`Parameters::check`].
    pub fn new(parameters: &Parameters) -> Self {
        let directions = parameters.measurement.directions;
        let block_s = parameters.measurement.periods as f64 * parameters.period_s();
        let signal = &parameters.signal;
        Self {
            cosines: (0..=directions)
                .map(|n| (PI * n as f64 / directions as f64).cos())
                .collect(),
            metres_per_sample: signal.range_of_delay_m(1.0),
            first_delay: signal.delay_of_range(parameters.measurement.min_range_m),
            width_mps: signal.speed_of_sound_mps / (2.0 * signal.carrier_hz * block_s),
            strongest: 0.0,
            sorted: Vec::with_capacity((directions + 1) * parameters.delays() / MEDIAN_STRIDE + 1),
            candidates: Vec::with_capacity(1024),
        }
    }

    /// The peaks of H, `[direction, delay]` as measured by the bank at the speed `v_mps`, strongest first.
    ///
    /// Blocks of a drive must be given in their order: how weak an echo may be follows from the strongest ones lately.
    pub fn find(&mut self, intensity: ArrayView2<'_, f32>, v_mps: f64, peaks: &mut Vec<Peak>) {
        peaks.clear();
        let Some(values) = intensity.as_slice() else {
            return;
        };
        self.sorted.clear();
        self.sorted.extend(values.iter().step_by(MEDIAN_STRIDE));
        if self.sorted.is_empty() {
            return;
        }
        let middle = self.sorted.len() / 2;
        let (_, &mut median, _) = self.sorted.select_nth_unstable_by(middle, f32::total_cmp);
        if !(median > 0.0) {
            return;
        }
        self.candidates.clear();
        let (rows, delays) = intensity.dim();
        let end = delays.saturating_sub(REACH[1]);
        for row in 0..rows {
            let line = &values[row * delays..(row + 1) * delays];
            for delay in self.first_delay.max(REACH[1])..end {
                let value = line[delay];
                if value < LEAST_STRENGTH * median
                    || value < line[delay - 1]
                    || value <= line[delay + 1]
                {
                    continue;
                }
                let low = row.saturating_sub(REACH[0]);
                let high = (row + REACH[0]).min(rows - 1);
                let largest = (low..=high).all(|other| {
                    let from = other * delays + delay - REACH[1];
                    let around = &values[from..=from + 2 * REACH[1]];
                    around.iter().all(|&neighbour| neighbour <= value)
                });
                if largest && self.candidates.len() < self.candidates.capacity() {
                    self.candidates.push((value, row, delay));
                }
            }
        }
        self.candidates
            .sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        let first = self.candidates.first().map_or(0.0, |candidate| candidate.0);
        self.strongest = first.max(self.strongest * (1.0 - 1.0 / MEMORY_BLOCKS));
        for index in 0..self.candidates.len() {
            if peaks.len() == MOST_PEAKS {
                break;
            }
            let (value, row, delay) = self.candidates[index];
            if value < LEAST_PART * self.strongest {
                break;
            }
            let in_side_lobe = self.candidates[..index]
                .iter()
                .any(|&(stronger, _, other)| {
                    other.abs_diff(delay) <= REACH[1] && value < SIDE_LOBE * stronger
                });
            if in_side_lobe {
                continue;
            }
            let line = row * delays + delay;
            let shift = vertex([values[line - 1], value, values[line + 1]].map(f64::from));
            peaks.push(Peak {
                range_m: self.metres_per_sample * (delay as f64 + shift),
                cosine: self.cosine(intensity, row, delay, v_mps),
                amplitude: f64::from(value),
            });
        }
    }

    /// Cosine of a peak: vertex of the parabola through H at three directions that the resolution tells apart.
    fn cosine(&self, intensity: ArrayView2<'_, f32>, row: usize, delay: usize, v_mps: f64) -> f64 {
        let apart = NODE_WIDTHS * self.width_mps / v_mps.abs().max(1e-6);
        let last = self.cosines.len() - 1;
        let here = self.cosines[row];
        let before = (0..row)
            .rev()
            .find(|&n| self.cosines[n] >= here + apart)
            .unwrap_or(0);
        let after = (row + 1..=last)
            .find(|&n| self.cosines[n] <= here - apart)
            .unwrap_or(last);
        let nodes = if before == row {
            let far = (after + 1..=last).find(|&n| self.cosines[n] <= self.cosines[after] - apart);
            [row, after, far.unwrap_or(last)]
        } else if after == row {
            let far = (0..before)
                .rev()
                .find(|&n| self.cosines[n] >= self.cosines[before] + apart);
            [far.unwrap_or(0), before, row]
        } else {
            [before, row, after]
        };
        let [a, b, c] = nodes.map(|n| (self.cosines[n], f64::from(intensity[[n, delay]])));
        parabola_top([a, b, c])
            .map_or(here, |top| {
                top.clamp(here - 2.0 * apart, here + 2.0 * apart)
            })
            .clamp(-1.0, 1.0)
    }
}

/// Place of the top of the parabola through three values at -1, 0 and 1, of which the middle one is the largest.
fn vertex([before, here, after]: [f64; 3]) -> f64 {
    let curvature = before - 2.0 * here + after;
    if curvature < 0.0 {
        (0.5 * (before - after) / curvature).clamp(-0.5, 0.5)
    } else {
        0.0
    }
}

/// Place of the top of the parabola through three points; none where it has no top.
fn parabola_top([a, b, c]: [(f64, f64); 3]) -> Option<f64> {
    let slope = |p: (f64, f64), q: (f64, f64)| (q.1 - p.1) / (q.0 - p.0);
    let (ab, bc) = (slope(a, b), slope(b, c));
    let curvature = (bc - ab) / (c.0 - a.0);
    (curvature < 0.0).then(|| 0.5 * (a.0 + b.0 - ab / curvature))
}
