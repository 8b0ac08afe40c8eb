//! The dual-circle method: a transmitter lies where the circles around two receivers meet.

use super::receivers::Beacons;
use crate::error::Error;

/// The two points at distance `range_a_m` from `a` and `range_b_m` from `b`, eqs. (1)-(17) of Hsu et al. (2021)
/// derived anew.
///
/// Subtracting the circles leaves the line Y = M X + K, eqs. (8)-(11). Put into eq. (7) it gives (X - X3)^2 + (M X +
/// K - Y3)^2 = R3^2; eq. (12) is misprinted with Y3^2 inside the bracket, while eqs. (14)-(16) follow from the right
/// form. Eq. (5) is printed with Y on both sides: solved for Y it reads Y = Y1 +- sqrt(R1^2 - (X - X1)^2). That is
/// eqs. (10)-(17) with the axes exchanged and M = 0, so one derivation serves: the axes are exchanged whenever the
/// receivers differ more in X than in Y, which also keeps |M| <= 1. Coordinates are taken from `b` (X3 = Y3 = 0): no
/// squares of large coordinates cancel.
///
/// # Errors
/// [`Error::Invalid`] for input that is not finite or a negative range; [`Error::Degenerate`] when the receivers are
/// at one place or the circles do not meet.
pub fn intersections(
    a: [f64; 2],
    range_a_m: f64,
    b: [f64; 2],
    range_b_m: f64,
) -> Result<[[f64; 2]; 2], Error> {
    let all = [a[0], a[1], b[0], b[1], range_a_m, range_b_m];
    if !all.iter().all(|value| value.is_finite()) || range_a_m < 0.0 || range_b_m < 0.0 {
        return Err(Error::invalid(
            "circles",
            "centre or radius",
            format!("{all:?}"),
            "give finite metres and radii of 0 or more",
        ));
    }
    let exchanged = (b[0] - a[0]).abs() > (b[1] - a[1]).abs();
    let axes = if exchanged { [1, 0] } else { [0, 1] };
    let [x2, y2] = axes.map(|axis| a[axis] - b[axis]);
    if y2.abs() < 1e-9 {
        return Err(Error::degenerate("two receivers are at the same place"));
    }
    // Eqs. (10) and (11) with X3 = Y3 = 0.
    let slope = x2 / -y2;
    let offset = (range_a_m.powi(2) - range_b_m.powi(2) - x2.powi(2) - y2.powi(2)) / (-2.0 * y2);
    // Eqs. (14)-(16), half of B.
    let square = 1.0 + slope.powi(2);
    let half = slope * offset;
    let constant = offset.powi(2) - range_b_m.powi(2);
    let mut discriminant = half.powi(2) - square * constant;
    // Circles that touch may miss each other by rounding.
    let scale = x2.hypot(y2).max(range_a_m).max(range_b_m).powi(2);
    if discriminant.abs() < 1e-13 * scale {
        discriminant = 0.0;
    }
    if discriminant < 0.0 {
        return Err(Error::degenerate(format!(
            "the circles of {range_a_m} m around {a:?} and {range_b_m} m around {b:?} do not meet"
        )));
    }
    let root = discriminant.sqrt();
    Ok([-root, root].map(|root| {
        let x = (root - half) / square;
        let y = slope * x + offset;
        if exchanged {
            [b[0] + y, b[1] + x]
        } else {
            [b[0] + x, b[1] + y]
        }
    }))
}

impl Beacons {
    /// Position from the circles around the receivers of `pair`; of the two points the one that fits all ranges best.
    ///
    /// # Errors
    /// As [`intersections`], and [`Error::Invalid`] when there is no such receiver.
    pub fn dual_circle(&self, ranges_m: &[f64], pair: [usize; 2]) -> Result<[f64; 2], Error> {
        self.check(ranges_m)?;
        if let Some(index) = pair.iter().find(|index| **index >= ranges_m.len()) {
            return Err(Error::invalid(
                "pair",
                index,
                "there is no such receiver",
                format!("choose below {}", ranges_m.len()),
            ));
        }
        let [a, b] = pair;
        let points = intersections(
            self.positions_m[a],
            ranges_m[a],
            self.positions_m[b],
            ranges_m[b],
        )?;
        Ok(self.best(ranges_m, points).unwrap_or(points[0]))
    }

    /// Of the dual-circle positions of all pairs (six for four receivers) the one that fits all ranges best.
    ///
    /// # Errors
    /// [`Error::Degenerate`] when no two circles meet.
    pub fn dual_circle_of_all_pairs(&self, ranges_m: &[f64]) -> Result<[f64; 2], Error> {
        self.check(ranges_m)?;
        let count = ranges_m.len();
        let points = (0..count)
            .flat_map(|a| (a + 1..count).map(move |b| [a, b]))
            .filter_map(|pair| self.dual_circle(ranges_m, pair).ok());
        self.best(ranges_m, points)
            .ok_or_else(|| Error::degenerate("no two circles meet"))
    }
}
