//! Small tools of the search: complex linear equations, and least squares by the method of Levenberg and Marquardt.

use super::super::linear::solve;
use rustfft::num_complex::Complex;

/// Solutions of equations, each a row with its right sides at the end: for each unknown its value for each right side.
pub(super) fn solve_complex(mut rows: Vec<Vec<Complex<f64>>>) -> Vec<Vec<Complex<f64>>> {
    let n = rows.len();
    for column in 0..n {
        let best = (column..n).max_by(|&a, &b| {
            let size = |row: usize| rows[row][column].norm_sqr();
            size(a).total_cmp(&size(b))
        });
        rows.swap(column, best.unwrap_or(column));
        let (upper, lower) = rows.split_at_mut(column + 1);
        let pivot = &upper[column];
        for row in lower {
            let factor = row[column] / pivot[column];
            if factor.norm_sqr() > 0.0 {
                for (value, from) in row[column..].iter_mut().zip(&pivot[column..]) {
                    *value -= factor * from;
                }
            }
        }
    }
    for column in (0..n).rev() {
        let (upper, lower) = rows.split_at_mut(column + 1);
        let row = &mut upper[column];
        let pivot = row[column];
        for (other, solved) in (column + 1..n).zip(&*lower) {
            let factor = row[other];
            for (value, solved) in row[n..].iter_mut().zip(&solved[n..]) {
                *value -= factor * solved;
            }
        }
        for value in &mut row[n..] {
            *value /= pivot;
        }
    }
    rows.into_iter().map(|row| row[n..].to_vec()).collect()
}

/// A minimum of the sum of squares of `residuals` near `x`, with derivatives by differences; ends after `rounds`, or when nothing is gained any more.
pub(super) fn least_squares(
    mut x: Vec<f64>,
    rounds: usize,
    residuals: impl Fn(&[f64]) -> Vec<f64>,
) -> Vec<f64> {
    /// Step of the differences.
    const STEP: f64 = 1e-6;
    let sum = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
    let mut values = residuals(&x);
    let mut best = sum(&values);
    let mut damping = 1e-2;
    for _ in 0..rounds {
        let columns: Vec<Vec<f64>> = (0..x.len())
            .map(|index| {
                let mut moved = x.clone();
                moved[index] += STEP;
                let there = residuals(&moved).into_iter().zip(&values);
                there.map(|(there, here)| (there - here) / STEP).collect()
            })
            .collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let normal: Vec<Vec<f64>> = columns
            .iter()
            .map(|column| {
                let row = columns.iter().map(|other| dot(column, other));
                row.chain([-dot(column, &values)]).collect()
            })
            .collect();
        let before = best;
        while damping < 1e6 {
            let mut damped = normal.clone();
            for (index, row) in damped.iter_mut().enumerate() {
                row[index] *= 1.0 + damping;
            }
            let step = solve(damped);
            let next: Vec<f64> = x.iter().zip(&step).map(|(x, step)| x + step).collect();
            let there = residuals(&next);
            let found = sum(&there);
            if found < best {
                (x, values, best) = (next, there, found);
                damping *= 0.2;
                break;
            }
            damping *= 4.0;
        }
        if best > 0.999 * before {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_hold() {
        let number = |i: usize, j: usize| {
            let seed = (i * 7 + j * 3) as f64;
            Complex::new(seed.sin(), (seed * 1.7).cos())
        };
        let rows: Vec<Vec<_>> = (0..6)
            .map(|i| (0..8).map(|j| number(i, j)).collect())
            .collect();
        let solved = solve_complex(rows.clone());
        for row in rows {
            for side in 0..2 {
                let sum: Complex<f64> = (0..6).map(|j| row[j] * solved[j][side]).sum();
                assert!((sum - row[6 + side]).norm() < 1e-12, "{sum}");
            }
        }
    }

    #[test]
    fn a_curved_valley_is_followed_to_its_lowest_point() {
        let valley = |x: &[f64]| vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]];
        let found = least_squares(vec![-1.2, 1.0], 100, valley);
        assert!(
            (found[0] - 1.0).abs() < 1e-4 && (found[1] - 1.0).abs() < 1e-4,
            "{found:?}"
        );
    }
}
