//! Weights before walls along the axes, and nearly so: the axis kernel.
//!
//! A surface samples the pressure with weights e of three cells along the grid axis nearest to its normal, and of the
//! cells beside one of them along the wall. It takes its flow from the same cells with the same weights, which keeps
//! it passive (see [`super::design`]). A plane wave before an axis-parallel wall meets, on the grid, the reflection
//! factor
//!
//! `R = (z c - y + i X)/(z c + y + i X)`, `y = -chi s Im g`, `X = s m/chi + chi s Re g`, `g = e' (S - s^2)^-1 e`,
//!
//! with `z = Z/(rho c)`, `s = 2 sin(omega dt/2)`, `c = cos(omega dt/2)`, the Courant number chi, the scheme's
//! operator S of the half-line with its rigid cut cell and outgoing waves, and the mass m before the surface in cell
//! widths. Exact would be `y = c/cos(angle)`, `X = 0`. Two errors grow with frequency squared: a single cell has its
//! pressure half a cell from a wall on a cell border, where the wave is `cos(k dx/2)` of its value at the wall, and
//! the velocity, a mean of two half steps, is too small by c. The weights compensate both: they extrapolate to the
//! wall, and a part `along` of the second difference along the wall follows the factor c of waves that run along it.
//! Weights and mass minimise the sum of the eighth powers of the errors of the reflection factor over frequency,
//! angle and impedance, by a deterministic search, for each Courant number and for sixteen places of the wall in a
//! cell.

use super::band::BAND_EDGE;
use super::half_line::{AxisWeights, IncidentWave};
use crate::scheme::Polynomial;

/// Number of places of the wall in a cell for which weights are tabulated.
const PLACES: usize = 16;

/// Impedances over that of air, times the cosine, for which the error of the reflection factor is minimised.
const RATIOS: [f64; 11] = [0.02, 0.05, 0.1, 0.2, 0.35, 0.6, 1.0, 1.6, 3.0, 6.0, 20.0];

/// Weights for all places of the wall, for one scheme at one Courant number.
#[derive(Debug, Clone)]
pub(super) struct AxisKernel {
    /// From the wall on the cell's far border (the whole cell is open) to the wall on its near border, in sixteenths.
    table: Vec<AxisWeights>,
    /// Whether the third cell and those along the wall are left out, beyond the rows that a 5-point stencil reaches.
    narrow: bool,
}

impl AxisKernel {
    /// Searches for the weights of all places of the wall.
    pub(super) fn new(polynomial: &Polynomial) -> Self {
        let narrow = polynomial.square == 0.0;
        let free = [true, !narrow, !narrow, true];
        let edge = BAND_EDGE * if narrow { 0.5 } else { 1.0 };
        let spare = polynomial.spare();
        let mut x = [0.0, 0.0, 0.0, 0.45];
        let table = (0..PLACES).map(|step| {
            let open = 1.0 - step as f64 / PLACES as f64;
            let waves = IncidentWave::all(polynomial, open, edge);
            let given = [spare * open, spare, spare];
            x = search(x, free, |x| loss(&waves, polynomial.courant, given, x));
            weights_of(given, x)
        });
        let mut table: Vec<AxisWeights> = table.collect();
        // A wall that leaves nothing of the cell lies on the border of the next one.
        let [first, second, third] = table[0].weights;
        table.push(AxisWeights {
            weights: if narrow {
                [0.0, 1.0, 0.0]
            } else {
                [0.0, first, second + third]
            },
            along: 0.0,
            mass: table[0].mass,
        });
        Self { table, narrow }
    }

    /// The weights where the wall leaves the part `open` of the first cell and its normal has the cosine `slope` to
    /// the axis.
    ///
    /// Over all places the table is a kernel: the weight of a cell by its distance from the wall. Before a slanted
    /// wall the distances of the cells of a row differ by less. The kernel gives their weights, with a correction
    /// that preserves sum and second moment; the mass changes by that of the air between the flows at these
    /// distances, `sum e_i e_j max(d_i, d_j)`.
    pub(super) fn at(&self, open: f64, slope: f64) -> AxisWeights {
        let upright = self.entry(open);
        let distances = [0.0, 1.0, 2.0].map(|i| (open - 0.5 + i) * slope);
        let kernel = distances.map(|d| slope * self.kernel(d));
        let moment = |weights: [f64; 3], distances: [f64; 3], power: i32| -> f64 {
            let terms = weights.iter().zip(distances);
            terms.map(|(weight, d)| weight * d.powi(power)).sum()
        };
        let between = |weights: [f64; 3], distances: [f64; 3]| -> f64 {
            let pairs = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
            pairs
                .map(|(i, j)| weights[i] * weights[j] * distances[i].max(distances[j]))
                .sum()
        };
        let places = [0.0, 1.0, 2.0].map(|i| open - 0.5 + i);
        if self.narrow {
            // With two cells only the sum can be preserved.
            let part = (1.0 - kernel[0] - kernel[1]) / (open + 1.0);
            let weights = [kernel[0] + part * open, kernel[1] + part, 0.0];
            return AxisWeights {
                weights,
                along: 0.0,
                mass: upright.mass + between(weights, distances) - between(upright.weights, places),
            };
        }
        // The least change that gives the sum and second moment of the upright wall.
        let squares = distances.map(|d| d * d);
        let want = [
            1.0 - kernel.iter().sum::<f64>(),
            moment(upright.weights, places, 2) - moment(kernel, distances, 2),
        ];
        let give = [open, 1.0, 0.5];
        let [m0, m2, m4] = [0, 2, 4].map(|power| moment(give, distances, power));
        let det = m0 * m4 - m2 * m2;
        let (a, b) = (
            (m4 * want[0] - m2 * want[1]) / det,
            (m0 * want[1] - m2 * want[0]) / det,
        );
        let weights: [f64; 3] = std::array::from_fn(|i| kernel[i] + give[i] * (a + b * squares[i]));
        // The cells of a row are also spread along a slanted wall.
        let [first, second] = [1, 2].map(|power| moment(weights, [0.0, 1.0, 2.0], power));
        let wide = 0.5 * (1.0 - slope * slope) * (second - first * first);
        AxisWeights {
            weights,
            along: (upright.along - wide).max(0.0),
            mass: upright.mass + between(weights, distances) - between(upright.weights, places),
        }
    }

    /// Weight of a cell by the distance of its centre from the wall in cell widths.
    fn kernel(&self, distance: f64) -> f64 {
        let cell = (distance + 0.5).ceil() - 1.0;
        if (0.0..3.0).contains(&cell) {
            self.entry(distance + 0.5 - cell).weights[cell as usize]
        } else {
            0.0
        }
    }

    /// The weights where an upright wall leaves the part `open` of the first cell, interpolated in the table.
    fn entry(&self, open: f64) -> AxisWeights {
        let last = self.table.len() - 1;
        let place = ((1.0 - open) * PLACES as f64).clamp(0.0, last as f64);
        let low = (place as usize).min(last - 1);
        let part = place - low as f64;
        let [one, other] = [self.table[low], self.table[low + 1]];
        let mix = |a: f64, b: f64| a + part * (b - a);
        AxisWeights {
            weights: std::array::from_fn(|i| mix(one.weights[i], other.weights[i])),
            along: mix(one.along, other.along),
            mass: mix(one.mass, other.mass),
        }
    }
}

/// Weights by the variables of the search: excess of the first weight over one, third weight, weight along the wall,
/// and mass, at least that of passivity.
fn weights_of(given: [f64; 3], x: [f64; 4]) -> AxisWeights {
    AxisWeights {
        weights: taps(x),
        along: x[2],
        mass: x[3].max(least_mass(given, x)),
    }
}

/// Weights of the three cells by the variables of the search.
fn taps(x: [f64; 4]) -> [f64; 3] {
    [1.0 + x[0], -x[0] - x[1], x[1]]
}

/// The least mass with which the surface is passive, for the spare of the three cells ([`Polynomial::spare`] times
/// area).
fn least_mass(given: [f64; 3], x: [f64; 4]) -> f64 {
    let [first, second, third] = taps(x);
    let first = (first - 2.0 * x[2]).abs() + 2.0 * x[2].abs();
    first * first / given[0] + second * second / given[1] + third * third / given[2]
}

/// Sum of the eighth powers of the errors of the reflection factor, a smooth substitute of their maximum. `given` is
/// the spare of the three cells.
fn loss(waves: &[IncidentWave], courant: f64, given: [f64; 3], x: [f64; 4]) -> f64 {
    let weights = weights_of(given, x);
    let mut sum = 0.0;
    for wave in waves {
        let [off, reactance] = wave.off(courant, &weights);
        for q in RATIOS {
            let below = ((q + 1.0 - off).powi(2) + reactance.powi(2)) * (q + 1.0).powi(2);
            sum += (4.0 * ((q * off).powi(2) + reactance.powi(2)) / below).powi(4);
        }
    }
    sum
}

/// Minimum of a function of the coordinates that are `free`, by steps along each and each pair of them, halved when
/// none decreases the function.
fn search(mut x: [f64; 4], free: [bool; 4], loss: impl Fn([f64; 4]) -> f64) -> [f64; 4] {
    let mut best = loss(x);
    let mut step = 1.0 / 32.0;
    while step > 1e-4 {
        let mut moved = false;
        for (i, j) in (0..4).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            if !(free[i] && free[j]) {
                continue;
            }
            for [one, other] in [[step, step], [-step, -step], [step, -step], [-step, step]] {
                loop {
                    let mut next = x;
                    next[j] += other;
                    // For i = j the last two steps repeat the first two.
                    next[i] = x[i] + one;
                    let found = loss(next);
                    if found >= best {
                        break;
                    }
                    (x, best, moved) = (next, found, true);
                }
            }
        }
        if !moved {
            step *= 0.5;
        }
    }
    x
}
