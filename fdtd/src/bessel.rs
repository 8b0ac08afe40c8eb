//! Modified Bessel function of the first kind, for Kaiser windows.

/// `I_0(x)`, by its power series up to terms below rounding. For moderate arguments: the number of terms grows with
/// `x`.
pub fn i0(x: f64) -> f64 {
    let quarter = 0.25 * x * x;
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= quarter / (k * k);
        sum += term;
        k += 1.0;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::i0;

    /// Values of Abramowitz and Stegun, table 9.8.
    #[test]
    fn values_are_those_of_the_table() {
        assert_eq!(i0(0.0), 1.0);
        for (x, expected) in [
            (1.0, 1.266_065_877_752_008_4),
            (5.0, 27.239_871_823_604_442),
        ] {
            assert!((i0(x) / expected - 1.0).abs() < 1e-14, "{x}: {}", i0(x));
        }
    }
}
