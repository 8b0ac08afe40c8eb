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

    /// Phase velocity over the speed of sound of a plane wave with `omega_dt` radians per step at `angle_rad` from the
    /// x axis; `None` above the cut-off frequency of that direction.
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

    /// The figures quoted in docs/theory/schemes.md: errors in per cent at 10 kHz on the papers' grid, axis and
    /// diagonal.
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
            (Scheme::D25, 0.0, -0.037, 0.11),
            (Scheme::D25, diagonal, -0.042, -0.09),
            (Scheme::Iwb, 0.0, -2.60, -7.9),
            (Scheme::Iwb, diagonal, -3.55, -10.6),
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

    /// Where an echo appears is the group velocity's matter: its largest error over all directions, in per cent, up to
    /// each frequency on the papers' grid.
    #[test]
    fn the_optimised_13_points_keep_the_group_velocity_to_13_khz() {
        let courant = 340.0 / 120_000.0 / 0.005;
        let largest = |scheme: Scheme, edge_hz: f64| {
            let grid = scheme.polynomial(courant);
            let mut most = 0.0_f64;
            for part in 1..=26 {
                let omega_dt = std::f64::consts::TAU * edge_hz / 120_000.0 * f64::from(part) / 26.0;
                for degrees in [0.0_f64, 10.0, 22.5, 35.0, 45.0] {
                    let velocity = grid.group_velocity(omega_dt, degrees.to_radians()).unwrap();
                    most = most.max(100.0 * (velocity - 1.0).abs());
                }
            }
            most
        };
        for edge_hz in [10e3, 13e3, 14e3, 15e3] {
            println!(
                "{edge_hz} Hz: m13 {:.2}, o13 {:.2}, d25 {:.2} %",
                largest(Scheme::M13, edge_hz),
                largest(Scheme::O13, edge_hz),
                largest(Scheme::D25, edge_hz)
            );
        }
        assert!(largest(Scheme::O13, 13e3) < 0.8);
        assert!(largest(Scheme::M13, 13e3) > 3.0);
    }
}
