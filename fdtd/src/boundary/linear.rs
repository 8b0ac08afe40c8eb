//! Linear equations: a dense solver, and conjugate gradients for symmetric positive forms.

/// Solution of equations, each a row of coefficients with the right-hand side at the end, by Gaussian elimination
/// with row pivots.
pub(super) fn solve(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let n = rows.len();
    for column in 0..n {
        let best =
            (column..n).max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs()));
        rows.swap(column, best.unwrap_or(column));
        let (upper, lower) = rows.split_at_mut(column + 1);
        let pivot = &upper[column];
        for row in lower {
            let factor = row[column] / pivot[column];
            for (value, from) in row[column..].iter_mut().zip(&pivot[column..]) {
                *value -= factor * from;
            }
        }
    }
    let mut found = vec![0.0; n];
    for column in (0..n).rev() {
        let known: f64 = (column + 1..n).map(|i| rows[column][i] * found[i]).sum();
        found[column] = (rows[column][n] - known) / rows[column][column];
    }
    found
}

/// Solution u of `form(u) = load` by conjugate gradients from zero, preconditioned with the form's diagonal `own` (0
/// where there is no air). Ends after `rounds`, or at a residual of zero; for a singular form the result is one of
/// its solutions.
pub(super) fn conjugate_gradients(
    form: impl Fn(&[f64]) -> Vec<f64>,
    own: &[f64],
    load: &[f64],
    rounds: usize,
) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let over = |values: &[f64]| -> Vec<f64> {
        let parts = values.iter().zip(own);
        parts
            .map(|(value, own)| if *own > 0.0 { value / own } else { 0.0 })
            .collect()
    };
    let add = |to: &mut [f64], factor: f64, from: &[f64]| {
        for (to, from) in to.iter_mut().zip(from) {
            *to += factor * from;
        }
    };
    let mut found = vec![0.0; load.len()];
    let mut rest = load.to_vec();
    let mut way = over(&rest);
    let mut size = dot(&rest, &way);
    for _ in 0..rounds {
        let along = form(&way);
        let curvature = dot(&way, &along);
        if curvature <= 0.0 || size < 1e-24 {
            break;
        }
        add(&mut found, size / curvature, &way);
        add(&mut rest, -size / curvature, &along);
        let mut turned = over(&rest);
        let next = dot(&rest, &turned);
        add(&mut turned, next / size, &way);
        (way, size) = (turned, next);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_give_the_same() {
        // A chain of springs held at its ends.
        let n = 9;
        let weight = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 2.0 + 0.3 * i as f64,
            1 => -1.0,
            _ => 0.0,
        };
        let load: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let row = |i: usize| -> Vec<f64> { (0..n).map(|j| weight(i, j)).collect() };
        let full = (0..n).map(|i| [row(i), vec![load[i]]].concat()).collect();
        let form = |u: &[f64]| -> Vec<f64> {
            let product = |i: usize| row(i).iter().zip(u).map(|(a, b)| a * b).sum();
            (0..n).map(product).collect()
        };
        let own: Vec<f64> = (0..n).map(|i| weight(i, i)).collect();
        let found = conjugate_gradients(form, &own, &load, n);
        for (a, b) in found.iter().zip(solve(full)) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }
}
