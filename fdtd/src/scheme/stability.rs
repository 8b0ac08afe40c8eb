//! Stability of the leapfrog step: bounds of the operator's spectrum between walls of any shape.

use super::polynomial::Polynomial;

/// Margin below the bound of 4, so that rounding the coefficients does not matter.
const ROUNDING: f64 = 1e-3;
/// Least margin for a wall of an impedance: with less, its surface gets more mass than the air before it has.
const LEAST_SPARE: f64 = 1.0;

impl Polynomial {
    /// Bounds of the spectrum of minus the operator, whatever the rigid walls: `None` when it might make energy,
    /// otherwise the largest eigenvalue it can have. A leapfrog step is stable up to 4.
    ///
    /// With `P = -A`, `Q = -B` between 0 and 4, which need not commute at walls, minus the operator is
    /// `linear (P + Q) - square (P^2 + Q^2) - mixed (PQ + QP)/2 + cube (P^3 + Q^3) + cross (PQP + QPQ)`. Each term is
    /// bounded by itself: `P^2 <= 4 P`, `P^3 <= 16 P`, `0 <= PQP <= 16 P`, and
    /// `-min(2, (P^2 + Q^2)/2) <= (PQ + QP)/2 <= 16` (the 2 because the anticommutator of two operators between 0 and 1
    /// is at least -1/4).
    pub fn largest_eigenvalue(&self) -> Option<f64> {
        let part = |value: f64| (value.max(0.0), (-value).max(0.0));
        let (convex, concave) = (part(-self.square), part(-self.mixed));
        let (cube, cross) = (part(self.cube), part(self.cross));
        // Share of each unit of P + Q that the terms that may be negative take away.
        let taken = 4.0 * convex.1 + 2.0 * (concave.0 + concave.1) + 16.0 * cube.1 + 16.0 * cross.1;
        let largest = 8.0 * self.linear
            + 32.0 * convex.0
            + 16.0 * concave.0
            + 2.0 * concave.1
            + 128.0 * (cube.0 + cross.0);
        (taken <= self.linear).then_some(largest)
    }

    /// Bound of the largest eigenvalue of minus the operator, whatever the rigid walls: sharper than
    /// [`Self::largest_eigenvalue`] where the coefficients have the signs that all schemes have. `None` when the
    /// operator might make energy.
    pub fn bound(&self) -> Option<f64> {
        self.bounds().map(|[largest, _]| largest)
    }

    /// [`Self::bound`], and how much smaller the operator is on smooth fields, see [`Self::slack`].
    ///
    /// From `P^2 <= 4 P`, `P^3 <= 16 P` and `(P - 4) Q (P - 4) >= 0` minus the operator is at most
    /// `l (P + Q) - m (PQ + QP)/2` with `l = linear - 4 square + 16 cube - 16 cross` and `m = mixed - 16 cross`. That
    /// is linear in P and in Q, so its largest eigenvalue is largest where both are 4 times projections; two
    /// projections fall apart into planes in which they meet at an angle of cosine C, where the eigenvalues are
    /// `4 l (1 + C) - 8 m C (1 + C)`: at most `8 l - 16 m`, the symbol of the checkerboard, when `6 m <= l`, and
    /// otherwise `(l + 2 m)^2 / (2 m)`, at a C below 1.
    fn bounds(&self) -> Option<[f64; 2]> {
        let plain = self.largest_eigenvalue()?;
        let signs =
            self.square <= 0.0 && self.mixed >= 0.0 && self.cube >= 0.0 && self.cross <= 0.0;
        let sum = self.linear - 4.0 * self.square + 16.0 * self.cube - 16.0 * self.cross;
        let product = self.mixed - 16.0 * self.cross;
        Some(match signs {
            true if 6.0 * product <= sum => [8.0 * sum - 16.0 * product, sum - 6.0 * product],
            true => [(sum + 2.0 * product).powi(2) / (2.0 * product), 0.0],
            false => [plain, 0.0],
        })
    }

    /// Whether the leapfrog step is stable between rigid walls of any shape, with a margin for the rounding of the
    /// coefficients.
    pub fn is_stable(&self) -> bool {
        self.bound()
            .is_some_and(|largest| largest <= 4.0 - ROUNDING)
    }

    /// 4 plus the operator, over `linear`, whatever the walls: the first number `spare` times the identity, and the
    /// second, `smooth`, times `8 - P - Q`. The leapfrog step stays stable while a positive form of at most that comes
    /// on top.
    ///
    /// The argument of the sharper bound with `6 m` for `l` says that minus the operator and `(l - 6 m) (8 - P - Q)`
    /// together stay within `8 l - 16 m`: only the checkerboard, where P + Q is 8, comes near to it, and smooth fields
    /// leave much more.
    pub fn slack(&self) -> [f64; 2] {
        let [largest, smooth] = self.bounds().unwrap_or([4.0, 0.0]);
        [(4.0 - ROUNDING - largest).max(0.0), smooth].map(|part| part / self.linear)
    }

    /// The first number of [`Self::slack`]: the spring that may be added to minus the operator in every cell, whatever
    /// the field.
    pub fn spare(&self) -> f64 {
        self.slack()[0]
    }

    /// Whether [`Self::spare`] is enough for walls of an impedance; a scene that has some must have a step that small.
    pub fn allows_impedance(&self) -> bool {
        self.spare() >= LEAST_SPARE
    }
}
