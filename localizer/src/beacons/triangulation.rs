//! Triangulation: bearings from the sides of triangles, crossed.

use super::receivers::{Beacons, cross, minus};
use crate::error::Error;

impl Beacons {
    /// Position where two bearings cross: at the first receiver against the baseline to the second, and at the second
    /// against the baseline to the third. The law of cosines gives each bearing from two ranges up to its sign; the
    /// signs are those whose crossing fits all ranges best. Hsu et al. (2021) list results of triangulation (Table 2)
    /// but not its equations: this is our reading. (Two bearings on one baseline would repeat the dual-circle
    /// method.)
    ///
    /// # Errors
    /// [`Error::Invalid`] for bad ranges; [`Error::Degenerate`] when a triangle does not close or the bearings do not
    /// cross.
    pub fn triangulate(&self, ranges_m: &[f64]) -> Result<[f64; 2], Error> {
        self.check(ranges_m)?;
        let (first, second) = (
            self.bearings(ranges_m, 0, 1)?,
            self.bearings(ranges_m, 1, 2)?,
        );
        let base = minus(self.positions_m[1], self.positions_m[0]);
        let crossings = first.iter().flat_map(|u| {
            second.iter().filter_map(move |v| {
                let sine = cross(*u, *v);
                let along = cross(base, *v) / sine;
                (sine.abs() > 1e-9).then(|| {
                    let [x, y] = self.positions_m[0];
                    [x + along * u[0], y + along * u[1]]
                })
            })
        });
        self.best(ranges_m, crossings)
            .ok_or_else(|| Error::degenerate("the bearings do not cross"))
    }

    /// Unit vectors from receiver `at` to the transmitter, on both sides of the baseline to receiver `to`.
    fn bearings(&self, ranges_m: &[f64], at: usize, to: usize) -> Result<[[f64; 2]; 2], Error> {
        let base = minus(self.positions_m[to], self.positions_m[at]);
        let length = base[0].hypot(base[1]);
        let cosine = (ranges_m[at].powi(2) + length.powi(2) - ranges_m[to].powi(2))
            / (2.0 * length * ranges_m[at]);
        if !cosine.is_finite() || cosine.abs() > 1.0 + 1e-12 {
            return Err(Error::degenerate(format!(
                "the triangle over receivers {at} and {to} does not close"
            )));
        }
        let cosine = cosine.clamp(-1.0, 1.0);
        let sine = (1.0 - cosine.powi(2)).sqrt();
        let [x, y] = base.map(|side| side / length);
        Ok([sine, -sine].map(|sine| [cosine * x - sine * y, cosine * y + sine * x]))
    }
}
