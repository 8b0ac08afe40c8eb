//! Discrete dispersion relation: how fast a plane wave travels on the grid.

use super::Polynomial;

impl Polynomial {
    /// Wave number (in 1/cells) that the grid gives a plane wave of angular frequency `omega_dt` (radians per step) at
    /// `angle_rad` from the x axis; `None` above the cut-off of that direction.
    fn wave_number(&self, omega_dt: f64, angle_rad: f64) -> Option<f64> {
        let target = 4.0 * (0.5 * omega_dt).sin().powi(2);
        let (sin, cos) = angle_rad.sin_cos();
        let symbol = |k: f64| {
            let a = 4.0 * (0.5 * k * cos).sin().powi(2);
            let b = 4.0 * (0.5 * k * sin).sin().powi(2);
            self.symbol(a, b)
        };
        let edge = std::f64::consts::PI / cos.abs().max(sin.abs());
        if symbol(edge) < target {
            return None;
        }
        let (mut low, mut high) = (0.0, edge);
        for _ in 0..100 {
            let mid = 0.5 * (low + high);
            if symbol(mid) < target {
                low = mid
            } else {
                high = mid
            }
        }
        Some(0.5 * (low + high))
    }

    /// Phase velocity over the speed of sound of a plane wave with `omega_dt` radians per step at `angle_rad` from the x
    /// axis; `None` above the cut-off frequency of that direction.
    pub fn phase_velocity(&self, omega_dt: f64, angle_rad: f64) -> Option<f64> {
        self.wave_number(omega_dt, angle_rad)
            .map(|k| omega_dt / (k * self.courant))
    }

    /// Group velocity (along the wave number) over the speed of sound; arguments as in [`Polynomial::phase_velocity`].
    pub fn group_velocity(&self, omega_dt: f64, angle_rad: f64) -> Option<f64> {
        let step = 1e-5 * omega_dt;
        let above = self.wave_number(omega_dt + step, angle_rad)?;
        let below = self.wave_number(omega_dt - step, angle_rad)?;
        Some(2.0 * step / ((above - below) * self.courant))
    }
}

#[cfg(test)]
mod tests {
    use crate::scheme::Scheme;

    /// The figures quoted in ARCHITECTURE.md: errors in per cent at 10 kHz on the papers' grid, axis and diagonal.
    #[test]
    fn errors_at_the_carrier_on_the_papers_grid() {
        let courant = 340.0 / 120_000.0 / 0.005;
        let omega_dt = std::f64::consts::TAU * 1e4 / 120_000.0;
        let diagonal = std::f64::consts::FRAC_PI_4;
        for (scheme, angle, phase, group) in [
            (Scheme::Slf, 0.0, -2.60, -7.9),
            (Scheme::Slf, diagonal, -0.66, -2.0),
            (Scheme::M13, 0.0, -0.25, -1.2),
            (Scheme::M13, diagonal, -0.03, -0.15),
            (Scheme::D25, 0.0, 0.03, 0.05),
            (Scheme::D25, diagonal, 0.03, 0.05),
        ] {
            let grid = scheme.polynomial(courant);
            let vp = 100.0 * (grid.phase_velocity(omega_dt, angle).unwrap() - 1.0);
            let vg = 100.0 * (grid.group_velocity(omega_dt, angle).unwrap() - 1.0);
            println!("{scheme} {angle} {vp} {vg}");
            assert!(
                (vp - phase).abs() < 0.01 + 0.02 * phase.abs(),
                "{scheme} phase {vp} {phase}"
            );
            assert!((vg - group).abs() < 0.06, "{scheme} group {vg} {group}");
        }
    }
}
