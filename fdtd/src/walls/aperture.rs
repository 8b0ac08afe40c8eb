//! Which cells before a wall of an impedance take part in its reaction, and how much: walls along the axes, and nearly so.
//!
//! A surface samples the pressure with weights e of three cells along the grid's axis that is nearest to its normal, and of the cells beside one of
//! them along the wall, and takes its flow from the same cells with the same weights: that keeps it passive (see [`super::surface`]). A plane wave in front of
//! an axis-parallel wall meets, on the grid, a reflection factor of
//!
//! `R = (z c - y + i X)/(z c + y + i X)`, `y = -chi s Im g`, `X = s m/chi + chi s Re g`, `g = e' (S - s^2)^-1 e`,
//!
//! with `z = Z/(rho c)`, `s = 2 sin(omega dt/2)`, `c = cos(omega dt/2)`, the Courant number chi, the scheme's operator S of the half-line with its rigid
//! cut cell, waves going out, and the mass m before the surface in cell widths. `y = c/cos(angle)`, `X = 0` would be exact. One cell
//! alone has its pressure half a cell from a wall on a cell border, where the wave is `cos(k dx/2)` of what it is at the wall; and the
//! velocity, a mean of two half steps, is too small by c. Both grow with frequency squared, and are what is made up for here: the weights
//! extrapolate to the wall, and a part `along` of the second difference along the wall follows the c of waves that run along it.
//! Weights and mass are those with the least errors of the reflection factor (their eighth powers summed) over frequency, angle and impedance, found by
//! a search without chance, once for each Courant number and for sixteen places of the wall in a cell.

use crate::scheme::Polynomial;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Weights of a surface by the place of the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Aperture {
    /// Weights of the cell that the wall cuts and of the two behind it; they sum to one.
    pub(super) weights: [f64; 3],
    /// Weight of the cells beside the first one along the wall; it loses as much for each.
    pub(super) along: f64,
    /// Mass of air before the surface in cell widths.
    pub(super) mass: f64,
}

/// Places of the wall in a cell for which weights are worked out.
const PLACES: usize = 16;

/// Wave number in radians per cell up to which the wide schemes are fitted: 11 kHz on the papers' grid. The 5-point scheme, whose own error of
/// the group velocity is eight percent at 10 kHz, is fitted to half of it.
pub(super) const BAND_EDGE: f64 = TAU * 11e3 / 340.0 * 0.005;

/// Cosines of the angles of incidence: 0, 30, 60 and 75 degrees.
pub(super) const COSINES: [f64; 4] = [1.0, 0.866, 0.5, 0.259];

/// Impedances over that of air, times the cosine, at which the reflection factor is held against the exact one.
const RATIOS: [f64; 11] = [0.02, 0.05, 0.1, 0.2, 0.35, 0.6, 1.0, 1.6, 3.0, 6.0, 20.0];

/// Weights for all places of the wall, for one scheme at one Courant number.
#[derive(Debug, Clone)]
pub(super) struct Apertures {
    /// From the wall on the cell's far border (the whole cell is open) to that on the near one, in sixteenths.
    table: Vec<Aperture>,
    /// Whether the third cell and those along the wall are left out, which the rows of a 5-point stencil do not reach.
    narrow: bool,
}

impl Apertures {
    /// Works them out.
    pub(super) fn new(polynomial: &Polynomial) -> Self {
        let narrow = polynomial.square == 0.0;
        let free = [true, !narrow, !narrow, true];
        let edge = BAND_EDGE * if narrow { 0.5 } else { 1.0 };
        let spare = polynomial.spare();
        let mut x = [0.0, 0.0, 0.0, 0.45];
        let table = (0..PLACES).map(|step| {
            let open = 1.0 - step as f64 / PLACES as f64;
            let places = Place::all(polynomial, open, edge);
            let given = [spare * open, spare, spare];
            x = search(x, free, |x| loss(&places, polynomial.courant, given, x));
            Aperture {
                weights: taps(x),
                along: x[2],
                mass: x[3].max(least_mass(given, x)),
            }
        });
        let mut table: Vec<Aperture> = table.collect();
        // A wall that leaves nothing of the cell lies on the border of the next.
        let [first, second, third] = table[0].weights;
        table.push(Aperture {
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

    /// The weights where the wall leaves the part `open` of the first cell and its normal has the cosine `slope` to the axis.
    ///
    /// Over all places the table is a kernel: the weight of a cell by its distance from the wall. Before a slanted wall the cells of a row are
    /// closer together in this distance. The kernel gives their weights, times what keeps sum and second moment; and the mass changes by what lies between
    /// the flows at these distances, `sum e_i e_j max(d_i, d_j)`.
    pub(super) fn at(&self, open: f64, slope: f64) -> Aperture {
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
            // Two cells: no more than their sum can be kept.
            let part = (1.0 - kernel[0] - kernel[1]) / (open + 1.0);
            let weights = [kernel[0] + part * open, kernel[1] + part, 0.0];
            return Aperture {
                weights,
                along: 0.0,
                mass: upright.mass + between(weights, distances) - between(upright.weights, places),
            };
        }
        // The least change that brings sum and second moment to those of the upright wall.
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
        // The cells of a row lie beside each other along a slanted wall too.
        let [first, second] = [1, 2].map(|power| moment(weights, [0.0, 1.0, 2.0], power));
        let wide = 0.5 * (1.0 - slope * slope) * (second - first * first);
        Aperture {
            weights,
            along: (upright.along - wide).max(0.0),
            mass: upright.mass + between(weights, distances) - between(upright.weights, places),
        }
    }

    /// Weight of a cell whose middle is so many cell widths from the wall.
    fn kernel(&self, distance: f64) -> f64 {
        let cell = (distance + 0.5).ceil() - 1.0;
        if (0.0..3.0).contains(&cell) {
            self.entry(distance + 0.5 - cell).weights[cell as usize]
        } else {
            0.0
        }
    }

    /// The weights where the wall leaves the part `open` of the first cell, between two of the table.
    fn entry(&self, open: f64) -> Aperture {
        let last = self.table.len() - 1;
        let place = ((1.0 - open) * PLACES as f64).clamp(0.0, last as f64);
        let low = (place as usize).min(last - 1);
        let part = place - low as f64;
        let [one, other] = [self.table[low], self.table[low + 1]];
        let mix = |a: f64, b: f64| a + part * (b - a);
        Aperture {
            weights: std::array::from_fn(|i| mix(one.weights[i], other.weights[i])),
            along: mix(one.along, other.along),
            mass: mix(one.mass, other.mass),
        }
    }
}

/// Weights of the three cells by the search's variables: what the first has over one, the third, along the wall, and the mass.
fn taps(x: [f64; 4]) -> [f64; 3] {
    [1.0 + x[0], -x[0] - x[1], x[1]]
}

/// A plane wave before an axis-parallel wall on the grid.
struct Place {
    /// By what y and X are compared with 1 and 0: `chi s cos(angle)/c`.
    scale: f64,
    /// `4 sin^2(ky dx/2)`.
    across: f64,
    /// `(S - s^2)^-1` of the three cells before the wall.
    response: [[Complex<f64>; 3]; 3],
}

impl Place {
    fn all(polynomial: &Polynomial, open: f64, edge: f64) -> Vec<Self> {
        let quarters = (1..=4).map(|i| edge * f64::from(i) / 4.0);
        quarters
            .flat_map(|k| COSINES.map(|cos| Self::new(polynomial, open, k, cos)))
            .collect()
    }

    fn new(polynomial: &Polynomial, open: f64, k: f64, cos: f64) -> Self {
        let half = 0.5 * polynomial.courant * k;
        let sine = 2.0 * half.sin();
        let across = 4.0 * (0.5 * k * (1.0 - cos * cos).sqrt()).sin().powi(2);
        // Minus the operator less s^2 as a polynomial in the second difference towards the wall.
        let p = polynomial;
        let free = p.symbol(0.0, across) - sine * sine;
        let coefficients = [
            free,
            p.linear - p.mixed * across + p.cross * across * across,
            p.cross * across - p.square,
            p.cube,
        ];
        let mut response = [[Complex::new(0.0, 0.0); 3]; 3];
        let guess = 4.0 * (0.5 * k * cos).sin().powi(2);
        let poles = poles(coefficients, guess);
        for (i, &pole) in poles.iter().enumerate() {
            let others = poles.iter().enumerate().filter(|&(j, _)| j != i);
            let apart: Complex<f64> = others.map(|(_, &other)| pole - other).product();
            let lead = coefficients[poles.len()];
            let part = chain(open, pole, i == 0);
            for (row, from) in response.iter_mut().zip(part) {
                for (value, from) in row.iter_mut().zip(from) {
                    *value += from / (apart * lead);
                }
            }
        }
        Self {
            scale: polynomial.courant * sine * cos / half.cos(),
            across,
            response,
        }
    }
}

/// Zeros of a polynomial of degree one to three: first the one near `guess`, then the others, which may be complex.
fn poles([c0, c1, c2, c3]: [f64; 4], guess: f64) -> Vec<Complex<f64>> {
    let mut first = guess;
    for _ in 0..30 {
        let value = c0 + first * (c1 + first * (c2 + first * c3));
        first -= value / (c1 + first * (2.0 * c2 + first * 3.0 * c3));
    }
    let mut found = vec![Complex::new(first, 0.0)];
    let (b1, b0) = (c2 + first * c3, c1 + first * (c2 + first * c3));
    if c3 != 0.0 {
        let root = Complex::new(b1 * b1 - 4.0 * c3 * b0, 0.0).sqrt();
        found.extend([-b1 + root, -b1 - root].map(|twice| twice / (2.0 * c3)));
    } else if b1 != 0.0 {
        found.push(Complex::new(-b0 / b1, 0.0));
    }
    found
}

/// `(P - pole)^-1` of the first three cells of a half-line of which the wall leaves `open` of the first cell; waves go out where the pole is
/// that of a wave, and die out elsewhere.
fn chain(open: f64, pole: Complex<f64>, wave: bool) -> [[Complex<f64>; 3]; 3] {
    // The cut cell's share, as in [`super::cut`].
    let face = (4.0 * open / (1.0 + 2.0 * open)).min(1.0);
    let middle = 0.5 * (2.0 - pole);
    let root = (middle * middle - 1.0).sqrt();
    let [one, other] = [middle + root, middle - root];
    let first = if wave {
        one.im < 0.0
    } else {
        one.norm() < other.norm()
    };
    let ratio = if first { one } else { other };
    let unit = Complex::new(1.0, 0.0);
    let out = [unit + (1.0 - pole - ratio) / face, unit, ratio];
    let second = unit - pole * open / face;
    let back = [
        unit,
        second,
        second + face * (second - unit) - pole * second,
    ];
    let jump = face * (out[0] - out[1]) - pole * open * out[0];
    std::array::from_fn(|i| std::array::from_fn(|j| back[i.min(j)] * out[i.max(j)] / jump))
}

/// The least mass that keeps the surface passive, from what the cells have to spare.
fn least_mass(given: [f64; 3], x: [f64; 4]) -> f64 {
    let [first, second, third] = taps(x);
    let first = (first - 2.0 * x[2]).abs() + 2.0 * x[2].abs();
    first * first / given[0] + second * second / given[1] + third * third / given[2]
}

/// Sum of the eighth powers of the errors of the reflection factor: nearly their largest, but smooth. `given` is what the cells have to spare.
fn loss(places: &[Place], courant: f64, given: [f64; 3], x: [f64; 4]) -> f64 {
    let weights = taps(x);
    let mass = x[3].max(least_mass(given, x));
    let mut sum = 0.0;
    for place in places {
        let mut e = weights;
        e[0] -= x[2] * place.across;
        let mut g = Complex::new(0.0, 0.0);
        for (row, left) in place.response.iter().zip(e) {
            for (value, right) in row.iter().zip(e) {
                g += value * left * right;
            }
        }
        let off = 1.0 + place.scale * g.im;
        let reactance = place.scale * (g.re + mass / (courant * courant));
        for q in RATIOS {
            let below = ((q + 1.0 - off).powi(2) + reactance.powi(2)) * (q + 1.0).powi(2);
            sum += (4.0 * ((q * off).powi(2) + reactance.powi(2)) / below).powi(4);
        }
    }
    sum
}

/// Minimum of a function of the coordinates that are `free`, along each and each two of them, in steps that are halved when none leads down.
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
                    // For a coordinate by itself the last two are the first two again.
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
