//! Spreading of a moving source onto the grid and interpolation at a moving receiver (the direct method).

use crate::bessel::i0;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Widest kernel, in cells.
pub const TAPS: usize = 12;

/// A sinc with a Kaiser window.
struct KaiserSinc {
    /// Cells to each side.
    reach: usize,
    /// Cut-off of the sinc as a fraction of half a cycle per cell.
    cutoff: f64,
    /// Shape parameter of the window.
    beta: f64,
}

/// Passes every wave that the grid holds.
const KAISER8: KaiserSinc = KaiserSinc {
    reach: 4,
    cutoff: 1.0,
    beta: 6.31,
};

/// Passes the band and stops the grid's shortest waves.
///
/// A coincident microphone receives the loudspeaker's near field, which reaches up to the shortest waves. A kernel that
/// passes them aliases there, and the direct wave changes with the place in the cell: by -24 dB with [`KAISER8`], which
/// is almost the power of the echoes and moves at the robot's pace, through the band of their Doppler shifts. Found by
/// a search over cut-off and shape for the least change of gain and near field over a cell below 15 kHz on the papers'
/// grid: 0.004 dB and -58 dB.
const KAISER12: KaiserSinc = KaiserSinc {
    reach: 6,
    cutoff: 0.84,
    beta: 6.2,
};

/// Standard deviation of the Gaussian in cells: the narrowest whose alias is 60 dB weaker than the wave up to 15 kHz on
/// the papers' grid. With `k` the wave's number in radians per cell, it passes `exp(-sigma^2 k^2 / 2)` of the wave and
/// `exp(-sigma^2 (2 pi - k)^2 / 2)` of the alias, which for `k = 1.386` differ by 61 dB.
const GAUSSIAN_SIGMA_CELLS: f64 = 0.8;

/// Cells to each side that the Gaussian fills: at five standard deviations it has fallen to 4e-6.
const GAUSSIAN_REACH: usize = 4;

/// How a point between cell centres is spread or interpolated, the same along x and y.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Spread {
    /// Linear along each axis, 2 x 2 cells: the papers' direct method.
    Bilinear,
    /// Gaussian with a standard deviation of 0.8 cells, 8 x 8 cells (Tsuchiya, Teshima and Hiryu 2022 drive a moving
    /// source so): the same in every place of a cell and in every direction, but a low-pass, -2.4 dB at 10 kHz on a 5
    /// mm grid for each of source and receiver.
    Gaussian,
    /// Kaiser-windowed sinc, 8 x 8 cells: gain ripple about 0.01 dB at 10 kHz on a 5 mm grid.
    Kaiser8,
    /// Kaiser-windowed sinc that stops the grid's shortest waves, 12 x 12 cells: gain ripple below 0.004 dB up to 15
    /// kHz on a 5 mm grid, and a direct wave that does not flicker when loudspeaker and microphone coincide.
    Kaiser12,
}

/// Separable weights of a point on the grid: cell `(x0 + i, y0 + j)` has weight `wx[i] * wy[j]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stencil {
    /// First column.
    pub x0: usize,
    /// First row.
    pub y0: usize,
    /// Weights along x; they sum to one.
    pub wx: [f32; TAPS],
    /// Weights along y; they sum to one.
    pub wy: [f32; TAPS],
}

impl Spread {
    /// All kernels.
    pub const ALL: [Self; 4] = [
        Self::Bilinear,
        Self::Gaussian,
        Self::Kaiser8,
        Self::Kaiser12,
    ];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bilinear => "bilinear",
            Self::Gaussian => "gaussian",
            Self::Kaiser8 => "kaiser8",
            Self::Kaiser12 => "kaiser12",
        }
    }

    /// How far from the point, in cells along an axis, a cell can get weight.
    pub fn reach_cells(self) -> usize {
        match self {
            Self::Bilinear => 1,
            Self::Gaussian => GAUSSIAN_REACH,
            Self::Kaiser8 => KAISER8.reach,
            Self::Kaiser12 => KAISER12.reach,
        }
    }

    /// Weights of a point given in cells (cell centres at whole numbers, see [`crate::grid::Grid::to_cells`]).
    ///
    /// # Panics
    /// When a coordinate is below 5 or not finite: scenes keep paths clear of the domain's edge.
    ///
    /// ```
    /// use fdtd::spread::Spread;
    ///
    /// let stencil = Spread::Bilinear.stencil([20.25, 30.5]);
    /// let cells = |weights: [f32; 12]| weights.into_iter().filter(|&weight| weight != 0.0).collect::<Vec<_>>();
    /// assert_eq!(cells(stencil.wx), [0.75, 0.25]);
    /// assert_eq!(cells(stencil.wy), [0.5, 0.5]);
    /// ```
    pub fn stencil(self, point_cells: [f64; 2]) -> Stencil {
        let [x, y] = point_cells;
        assert!(
            x >= (TAPS / 2 - 1) as f64 && y >= (TAPS / 2 - 1) as f64,
            "point ({x}, {y}) too near the domain's edge"
        );
        let (x0, wx) = self.taps(x);
        let (y0, wy) = self.taps(y);
        Stencil { x0, y0, wx, wy }
    }

    /// First cell and weights along one axis.
    fn taps(self, x: f64) -> (usize, [f32; TAPS]) {
        let floor = x.floor();
        let first = floor as usize - (TAPS / 2 - 1);
        let fraction = x - floor;
        let mut weights = [0.0; TAPS];
        match self {
            Self::Bilinear => {
                weights[TAPS / 2 - 1] = 1.0 - fraction;
                weights[TAPS / 2] = fraction;
            }
            Self::Gaussian => fill(&mut weights, fraction, gaussian),
            Self::Kaiser8 => fill(&mut weights, fraction, |d| KAISER8.at(d)),
            Self::Kaiser12 => fill(&mut weights, fraction, |d| KAISER12.at(d)),
        }
        (first, weights.map(|weight| weight as f32))
    }
}

impl KaiserSinc {
    /// Value at `d` cells from the point, not normalised.
    fn at(&self, d: f64) -> f64 {
        sinc(self.cutoff * d) * kaiser(self.beta, d / self.reach as f64)
    }
}

/// Gaussian at `d` cells from the point, cut off at its reach, not normalised.
fn gaussian(d: f64) -> f64 {
    if d.abs() >= GAUSSIAN_REACH as f64 {
        return 0.0;
    }
    (-0.5 * (d / GAUSSIAN_SIGMA_CELLS).powi(2)).exp()
}

/// Weights of a point `fraction` cells beyond cell `TAPS / 2 - 1` from a kernel over distance in cells; they sum to
/// one.
fn fill(weights: &mut [f64; TAPS], fraction: f64, kernel: impl Fn(f64) -> f64) {
    for (i, weight) in weights.iter_mut().enumerate() {
        *weight = kernel(i as f64 - (TAPS / 2 - 1) as f64 - fraction);
    }
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
}

impl std::fmt::Display for Spread {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

impl std::str::FromStr for Spread {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|spread| spread.name() == text)
            .ok_or_else(|| {
                format!(
                    "unknown spreading kernel '{text}'; accepted are bilinear, gaussian, kaiser8 and kaiser12"
                )
            })
    }
}

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-9 {
        return 1.0;
    }
    let px = std::f64::consts::PI * x;
    px.sin() / px
}

/// Kaiser window of shape `beta` at `u`, zero outside of -1..1, not normalised.
fn kaiser(beta: f64, u: f64) -> f64 {
    if u.abs() >= 1.0 {
        return 0.0;
    }
    i0(beta * (1.0 - u * u).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gain in decibels of a kernel for a wave along one axis at some places in a cell, 5 mm cells.
    fn gains(spread: Spread, frequency_hz: f64) -> Vec<f64> {
        let k = std::f64::consts::TAU * frequency_hz / 340.0 * 0.005;
        (0..=20)
            .map(|place| {
                let fraction = f64::from(place) / 20.0;
                let (first, weights) = spread.taps(20.0 + fraction);
                let (mut re, mut im) = (0.0, 0.0);
                for (i, &w) in weights.iter().enumerate() {
                    let phase = k * ((first + i) as f64 - 20.0 - fraction);
                    re += f64::from(w) * phase.cos();
                    im += f64::from(w) * phase.sin();
                }
                20.0 * re.hypot(im).log10()
            })
            .collect()
    }

    #[test]
    fn ripple_over_the_cell_is_what_the_documents_say() {
        let ripple = |spread, frequency_hz| {
            let gains = gains(spread, frequency_hz);
            gains.iter().fold(f64::MIN, |a, &b| a.max(b))
                - gains.iter().fold(f64::MAX, |a, &b| a.min(b))
        };
        let bilinear = ripple(Spread::Bilinear, 1e4);
        assert!((bilinear - 0.96).abs() < 0.03, "{bilinear}");
        assert!(ripple(Spread::Kaiser8, 1e4) < 0.012);
        // The Gaussian is a low-pass whose gain has a formula.
        for frequency_hz in [2e3, 1e4, 1.5e4] {
            let k = std::f64::consts::TAU * frequency_hz / 340.0 * 0.005;
            let expected = -20.0 * 0.32 * k * k * std::f64::consts::LOG10_E;
            for gain in gains(Spread::Gaussian, frequency_hz) {
                assert!((gain - expected).abs() < 0.01, "{gain}, {expected} dB");
            }
        }
        assert!((gains(Spread::Gaussian, 1e4)[0] + 2.4).abs() < 0.05);
        for frequency_hz in [2e3, 5e3, 1e4, 1.5e4] {
            let ripple = ripple(Spread::Kaiser12, frequency_hz);
            assert!(ripple < 0.004, "{frequency_hz} Hz: {ripple} dB");
            let gains = gains(Spread::Kaiser12, frequency_hz);
            assert!(gains.iter().all(|gain| gain.abs() < 0.006), "{gains:?}");
        }
    }

    #[test]
    fn weights_sum_to_one_and_keep_to_their_reach() {
        for spread in Spread::ALL {
            let stencil = spread.stencil([10.3, 12.9]);
            assert!((stencil.wx.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            assert_eq!((stencil.x0, stencil.y0), (5, 7));
            let reach = spread.reach_cells() as f64;
            for (i, &w) in stencil.wx.iter().enumerate() {
                let away = (stencil.x0 + i) as f64 - 10.3;
                assert!(w == 0.0 || away.abs() < reach, "{spread}, {away}");
            }
        }
    }
}
