//! Plane waves on the grid before axis-parallel walls: the response to a surface there, see [`super::axis_kernel`].

use super::band::COSINES;
use crate::scheme::Polynomial;
use rustfft::num_complex::Complex;

/// Weights and mass of a surface before an axis-parallel wall, or a nearly parallel one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AxisWeights {
    /// Weights of the cell that the wall cuts and of the two before it; they sum to one.
    pub(super) weights: [f64; 3],
    /// Weight of each of the two cells beside the first one along the wall, which the first one loses.
    pub(super) along: f64,
    /// Mass of air before the surface in cell widths.
    pub(super) mass: f64,
}

/// A plane wave before an axis-parallel wall on the grid.
pub(super) struct IncidentWave {
    /// Factor `chi s cos(angle)/c` with which y and X are compared with 1 and 0.
    scale: f64,
    /// `4 sin^2(ky dx/2)`.
    across: f64,
    /// `(S - s^2)^-1` of the three cells before the wall.
    response: [[Complex<f64>; 3]; 3],
}

impl IncidentWave {
    /// Waves at the quarters of a band up to the wave number `edge` (radians per cell) and all angles of [`COSINES`],
    /// before a wall that leaves the part `open` of the first cell.
    pub(super) fn all(polynomial: &Polynomial, open: f64, edge: f64) -> Vec<Self> {
        let quarters = (1..=4).map(|i| edge * f64::from(i) / 4.0);
        quarters
            .flat_map(|k| COSINES.map(|cos| Self::new(polynomial, open, k, cos)))
            .collect()
    }

    /// A wave of the wave number k in radians per cell and the cosine of the angle of incidence.
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

    /// `[1 - y, X]` for a velocity without its factor c, see [`super::axis_kernel`].
    pub(super) fn off(&self, courant: f64, axis: &AxisWeights) -> [f64; 2] {
        let mut e = axis.weights;
        e[0] -= axis.along * self.across;
        let mut g = Complex::new(0.0, 0.0);
        for (row, left) in self.response.iter().zip(e) {
            for (value, right) in row.iter().zip(e) {
                g += value * left * right;
            }
        }
        let reactance = self.scale * (g.re + axis.mass / (courant * courant));
        [1.0 + self.scale * g.im, reactance]
    }
}

/// Zeros of a polynomial of degree one to three, given by its coefficients from the constant on: first the real one
/// near `guess`, then the others, which may be complex.
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

/// `(P - pole)^-1` for the first three cells of a half-line of which the wall leaves the part `open` of the first cell.
/// Solutions are outgoing where the pole is that of a `wave`, and decaying elsewhere.
fn chain(open: f64, pole: Complex<f64>, wave: bool) -> [[Complex<f64>; 3]; 3] {
    // Face weight of the cut cell, see [`crate::walls::cut`].
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
