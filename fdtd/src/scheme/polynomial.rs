//! A scheme at one Courant number, before rounding: a polynomial in the two second differences.

/// Coefficients of the polynomial in the second differences `A` and `B` (see [`super`]) that one step adds to
/// `2 p^n - p^{n-1}`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Polynomial {
    /// Courant number that the coefficients belong to.
    pub courant: f64,
    /// Coefficient of `A + B`: the Courant number squared.
    pub linear: f64,
    /// Coefficient of `A^2 + B^2`.
    pub square: f64,
    /// Coefficient of `(AB + BA)/2`.
    pub mixed: f64,
    /// Coefficient of `A^3 + B^3`.
    pub cube: f64,
    /// Coefficient of `ABA + BAB`.
    pub cross: f64,
}

impl Polynomial {
    /// Symbol of minus the scaled Laplacian, `4 sin^2(omega dt / 2)` of a plane wave with `a = 4 sin^2(kx dx / 2)` and
    /// `b = 4 sin^2(ky dx / 2)`.
    pub fn symbol(&self, a: f64, b: f64) -> f64 {
        self.linear * (a + b) - self.square * (a * a + b * b) - self.mixed * a * b
            + self.cube * (a * a * a + b * b * b)
            + self.cross * a * b * (a + b)
    }

    /// Derivatives of the symbol by `a` and `b`.
    pub fn symbol_slopes(&self, a: f64, b: f64) -> [f64; 2] {
        [[a, b], [b, a]].map(|[own, other]| {
            self.linear - 2.0 * self.square * own - self.mixed * other
                + 3.0 * self.cube * own * own
                + self.cross * (2.0 * own * other + other * other)
        })
    }
}
