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

    /// Mass of air in cell widths that a load on the cells next to a wall has before it, so that it acts as if it were in the wall: half a
    /// cell, and what the evanescent waves of a wide stencil take of the load's flow.
    ///
    /// The response of such a cell to a flow is `(1/pi) int_0^pi 2 cos^2(k/2) / (symbol - 4 sin^2(omega dt/2)) dk`. For the
    /// 5-point symbol its part without loss is one half; what another symbol adds is the same integral over the difference,
    /// which has no pole, at low frequency and normal incidence.
    pub fn surface_mass(&self) -> f64 {
        const PARTS: usize = 1000;
        let part = |i: usize| {
            let half_k = 0.5 * std::f64::consts::PI * (i as f64 + 0.5) / PARTS as f64;
            let p = 4.0 * half_k.sin().powi(2);
            2.0 * half_k.cos().powi(2) * (1.0 / p - self.linear / self.symbol(p, 0.0))
        };
        0.5 + (0..PARTS).map(part).sum::<f64>() / PARTS as f64
    }

    /// Bounds of the spectrum of minus the operator, whatever the rigid walls: `None` when it might make energy, otherwise the
    /// largest eigenvalue it can have. A leapfrog step is stable up to 4.
    ///
    /// With `P = -A`, `Q = -B` between 0 and 4, which need not commute at walls, minus the operator is
    /// `linear (P + Q) - square (P^2 + Q^2) - mixed (PQ + QP)/2 + cube (P^3 + Q^3) + cross (PQP + QPQ)`. Each term is bounded by
    /// itself: `P^2 <= 4 P`, `P^3 <= 16 P`, `0 <= PQP <= 16 P`, and `-min(2, (P^2 + Q^2)/2) <= (PQ + QP)/2 <= 16` (the 2 because the
    /// anticommutator of two operators between 0 and 1 is at least -1/4).
    pub fn largest_eigenvalue(&self) -> Option<f64> {
        let part = |value: f64| (value.max(0.0), (-value).max(0.0));
        let (convex, concave) = (part(-self.square), part(-self.mixed));
        let (cube, cross) = (part(self.cube), part(self.cross));
        // What the terms that may be negative take away from each unit of P + Q.
        let taken = 4.0 * convex.1 + 2.0 * (concave.0 + concave.1) + 16.0 * cube.1 + 16.0 * cross.1;
        let largest = 8.0 * self.linear
            + 32.0 * convex.0
            + 16.0 * concave.0
            + 2.0 * concave.1
            + 128.0 * (cube.0 + cross.0);
        (taken <= self.linear).then_some(largest)
    }
}
