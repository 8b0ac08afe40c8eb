//! Receivers at known positions.

use crate::error::Error;

/// Share of the greatest squared distance below which a triangle of receivers counts as a line.
const FLAT: f64 = 1e-6;

/// Receivers at known positions, at least three of them and not all in line.
///
/// ```
/// use localizer::beacons::Beacons;
///
/// let beacons = Beacons::new(&[[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]])?;
/// let ranges_m = [5.0, 3.0, 4.0];
/// let fix = beacons.least_squares(&ranges_m, 0.01)?;
/// assert!((fix.position_m[0] - 4.0).abs() < 1e-6 && (fix.position_m[1] - 3.0).abs() < 1e-6);
/// # Ok::<(), localizer::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Beacons {
    pub(super) positions_m: Vec<[f64; 2]>,
}

impl Beacons {
    /// Checks the receivers' positions `[x, y]` in metres.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a position that is not finite; [`Error::Degenerate`] for fewer than three receivers,
    /// two at one place, or all in line.
    pub fn new(positions_m: &[[f64; 2]]) -> Result<Self, Error> {
        for (index, position) in positions_m.iter().enumerate() {
            if !position.iter().all(|value| value.is_finite()) {
                return Err(Error::invalid(
                    "receivers",
                    index,
                    format!("{position:?} is not finite"),
                    "give its position in metres",
                ));
            }
        }
        if positions_m.len() < 3 {
            return Err(Error::degenerate(
                "fewer than three receivers leave two solutions",
            ));
        }
        let mut span = 0.0_f64;
        let mut area = 0.0_f64;
        for (i, a) in positions_m.iter().enumerate() {
            for (j, b) in positions_m.iter().enumerate().skip(i + 1) {
                let side = minus(*b, *a);
                if side[0].hypot(side[1]) < 1e-9 {
                    return Err(Error::degenerate(format!(
                        "receivers {i} and {j} are at the same place"
                    )));
                }
                span = span.max(dot(side, side));
                for c in &positions_m[j + 1..] {
                    area = area.max(cross(side, minus(*c, *a)).abs());
                }
            }
        }
        if area <= FLAT * span {
            return Err(Error::degenerate(
                "the receivers are in line: both sides of it look the same",
            ));
        }
        Ok(Self {
            positions_m: positions_m.to_vec(),
        })
    }

    /// Positions `[x, y]` in metres.
    pub fn positions_m(&self) -> &[[f64; 2]] {
        &self.positions_m
    }

    /// Refuses ranges that are too few, too many, negative or not finite.
    pub(super) fn check(&self, ranges_m: &[f64]) -> Result<(), Error> {
        if ranges_m.len() != self.positions_m.len() {
            return Err(Error::invalid(
                "ranges",
                "length",
                ranges_m.len(),
                format!("give {}, one per receiver", self.positions_m.len()),
            ));
        }
        match ranges_m
            .iter()
            .position(|range| !range.is_finite() || *range < 0.0)
        {
            None => Ok(()),
            Some(index) => Err(Error::invalid(
                "ranges",
                index,
                ranges_m[index],
                "give a distance in metres, 0 or more",
            )),
        }
    }

    /// Sum of the squared differences between `ranges_m` and the distances from `point`, square metres.
    pub(super) fn misfit(&self, ranges_m: &[f64], point: [f64; 2]) -> f64 {
        self.positions_m
            .iter()
            .zip(ranges_m)
            .map(|(receiver, range)| {
                let side = minus(point, *receiver);
                (range - side[0].hypot(side[1])).powi(2)
            })
            .sum()
    }

    /// The candidate that fits all ranges best: resolves the ambiguity of two circles.
    pub(super) fn best(
        &self,
        ranges_m: &[f64],
        candidates: impl IntoIterator<Item = [f64; 2]>,
    ) -> Option<[f64; 2]> {
        candidates.into_iter().min_by(|a, b| {
            self.misfit(ranges_m, *a)
                .total_cmp(&self.misfit(ranges_m, *b))
        })
    }
}

pub(super) fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
