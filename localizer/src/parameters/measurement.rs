//! Parameters of the measurement: echoes and maps follow from these and from those of the signal.

use super::choices::{DirectWave, TimeReference, ToaImage};

/// Blocks, directions, ranges, cells, and the removal of the direct wave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasurementParameters {
    /// Periods M in one block.
    pub periods: usize,
    /// N_theta of eq. (3): there are N_theta + 1 directions, pi n / N_theta.
    pub directions: usize,
    /// Cell width of map and echo image, dx_m = dy_m, in metres.
    pub cell_m: f64,
    /// The instant of a block to which its pose refers.
    pub time_reference: TimeReference,
    /// How the direct wave is removed.
    pub direct_wave: DirectWave,
    /// Time constant of the running mean in seconds.
    pub direct_wave_time_s: f64,
    /// Pixels nearer than this are zero, in metres.
    pub min_range_m: f64,
    /// Echoes are measured up to this range, in metres.
    pub max_range_m: f64,
    /// H at a delay is the largest envelope within this range to both sides, in metres. The envelope's peak is far
    /// narrower than a cell, so that eq. (5), which reads one sample per pixel, misses most of it; 0 is eq. (5) as
    /// printed.
    pub range_pool_m: f64,
    /// A block with a smaller mean speed, in m/s, has no bearings: it moves the particles but does not weigh them.
    pub min_speed_mps: f64,
    /// The intensity that stands for all directions in the range-only method.
    pub toa_image: ToaImage,
}

impl Default for MeasurementParameters {
    fn default() -> Self {
        Self {
            periods: 6,
            directions: 29,
            cell_m: 0.1,
            time_reference: TimeReference::default(),
            direct_wave: DirectWave::default(),
            direct_wave_time_s: 10.0,
            min_range_m: 0.25,
            max_range_m: 8.5,
            range_pool_m: 0.0,
            min_speed_mps: 0.02,
            toa_image: ToaImage::default(),
        }
    }
}

impl MeasurementParameters {
    /// Periods between the start of a block and the instant to which its pose refers.
    pub fn reference_periods(&self) -> f64 {
        match self.time_reference {
            TimeReference::Centre => 0.5 * self.periods as f64,
            TimeReference::Start => 0.0,
        }
    }

    /// Whether echoes measured with these parameters are those of `wanted`. Cell width and nearest range
    /// belong to images alone, and a shorter range is a part of the measured one.
    pub fn provides(&self, wanted: &Self) -> bool {
        // All fields by name: a new one does not compile until it is decided here.
        let Self {
            periods,
            directions,
            cell_m: _,
            time_reference,
            direct_wave,
            direct_wave_time_s,
            min_range_m: _,
            max_range_m,
            range_pool_m,
            min_speed_mps,
            toa_image,
        } = *wanted;
        let asked = Self {
            periods,
            directions,
            cell_m: self.cell_m,
            time_reference,
            direct_wave,
            direct_wave_time_s,
            min_range_m: self.min_range_m,
            max_range_m: max_range_m.max(self.max_range_m),
            range_pool_m,
            min_speed_mps,
            toa_image,
        };
        asked == *self
    }
}
