//! Least squares over the ranges of all receivers, with covariance.

use super::receivers::{Beacons, minus};
use crate::error::Error;

/// Steps after which the search gives up.
const STEPS: usize = 100;

/// A position with its covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// Position `[x, y]`, metres.
    pub position_m: [f64; 2],
    /// Covariance `[[xx, xy], [xy, yy]]`, square metres.
    pub covariance_m2: [[f64; 2]; 2],
    /// Root mean square of the ranges' residuals, metres.
    pub residual_m: f64,
}

impl Beacons {
    /// The position with the least sum of squared range residuals, by Gauss-Newton steps (halved where they
    /// overshoot) from the best dual-circle position of all pairs. The covariance is `sigma_m`^2 (J^T J)^-1 with the
    /// unit vectors from the receivers as rows of J, for ranges with independent errors of standard deviation
    /// `sigma_m`.
    ///
    /// # Errors
    /// [`Error::Invalid`] for bad ranges or a bad `sigma_m`; [`Error::Degenerate`] when no circles meet, the
    /// transmitter sees all receivers in line, or the search does not settle.
    pub fn least_squares(&self, ranges_m: &[f64], sigma_m: f64) -> Result<Fix, Error> {
        if !sigma_m.is_finite() || sigma_m <= 0.0 {
            return Err(Error::invalid(
                "ranges",
                "sigma_m",
                sigma_m,
                "give metres above 0",
            ));
        }
        let mut point = self.dual_circle_of_all_pairs(ranges_m)?;
        for _ in 0..STEPS {
            let (inverse, gradient) = self.normal_equations(ranges_m, point)?;
            let step =
                [0, 1].map(|row| inverse[row][0] * gradient[0] + inverse[row][1] * gradient[1]);
            let misfit = self.misfit(ranges_m, point);
            let next = (0..30)
                .map(|halvings| 0.5_f64.powi(halvings))
                .map(|share| [point[0] + share * step[0], point[1] + share * step[1]])
                .find(|next| self.misfit(ranges_m, *next) < misfit);
            let settled = step[0].hypot(step[1]) < 1e-9;
            match next {
                Some(next) if !settled => point = next,
                _ => {
                    return Ok(Fix {
                        position_m: point,
                        covariance_m2: inverse.map(|row| row.map(|value| sigma_m.powi(2) * value)),
                        residual_m: (misfit / ranges_m.len() as f64).sqrt(),
                    });
                }
            }
        }
        Err(Error::degenerate("least squares do not settle"))
    }

    /// (J^T J)^-1 and J^T r at `point`.
    fn normal_equations(
        &self,
        ranges_m: &[f64],
        point: [f64; 2],
    ) -> Result<([[f64; 2]; 2], [f64; 2]), Error> {
        let (mut xx, mut xy, mut yy, mut gradient) = (0.0, 0.0, 0.0, [0.0; 2]);
        for (receiver, range) in self.positions_m.iter().zip(ranges_m) {
            let side = minus(point, *receiver);
            let distance = side[0].hypot(side[1]);
            // At a receiver its own circle has no direction; the others decide.
            let [x, y] = side.map(|value| value / distance.max(1e-12));
            xx += x * x;
            xy += x * y;
            yy += y * y;
            gradient[0] += x * (range - distance);
            gradient[1] += y * (range - distance);
        }
        let determinant = xx * yy - xy * xy;
        if determinant < 1e-9 {
            return Err(Error::degenerate(
                "all receivers are in line with the transmitter",
            ));
        }
        let inverse = [
            [yy / determinant, -xy / determinant],
            [-xy / determinant, xx / determinant],
        ];
        Ok((inverse, gradient))
    }
}
