//! A few linear equations.

/// Solution of equations, each a row with its right side at the end, by elimination with pivots by row.
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
