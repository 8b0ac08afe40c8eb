//! Doppler factors of echoes: received over sent frequency for a loudspeaker and microphone at one point that moves
//! uniformly.
//!
//! `mach` is speed over the speed of sound, `theta_rad` the angle from the heading to the perpendicular of the wall (or
//! to the apex of the corner). Eq. (3) of the 2024 paper is [`plane_wall`] to first order in `mach`.

/// Echo of a plane wall: `(e + M cos theta) / (e - M cos theta)` with `e = sqrt(1 - M^2 sin^2 theta)`.
///
/// The image moves towards the wall from behind as the pair does from the front; the `e` comes from the sound's way not
/// being the perpendicular while the pair moves along the wall.
///
/// ```
/// use oracles::exact::time_scale::plane_wall;
///
/// let mach = 0.3 / 340.0;
/// assert!((plane_wall(mach, 0.0) - (1.0 + mach) / (1.0 - mach)).abs() < 1e-15);
/// assert!((plane_wall(mach, 0.5) - (1.0 + 2.0 * mach * 0.5_f64.cos())).abs() < 2e-6);
/// ```
pub fn plane_wall(mach: f64, theta_rad: f64) -> f64 {
    let (sine, cosine) = theta_rad.sin_cos();
    let effective = (1.0 - (mach * sine).powi(2)).sqrt();
    (effective + mach * cosine) / (effective - mach * cosine)
}

/// Echo of a right-angled corner: `(1 + M cos theta) / (1 - M cos theta)`, with `theta_rad` the angle from the heading
/// to where the echo comes from, which is the apex seen from halfway between the places of emission and reception.
///
/// Eq. (3) of the 2024 paper inverts this factor for every echo; for a plane wall it differs in the third order of
/// `mach`.
pub fn corner(mach: f64, theta_rad: f64) -> f64 {
    (1.0 + mach * theta_rad.cos()) / (1.0 - mach * theta_rad.cos())
}

/// Two reflections between parallel walls: the image moves with the pair, so nothing changes.
pub fn parallel_walls() -> f64 {
    1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::monopole::Monopole;
    use fdtd::grid::Medium;

    const C_MPS: f64 = 350.0;
    const V_MPS: f64 = 17.0;
    const HEADING_RAD: f64 = 0.7;

    fn pair(t_s: f64) -> [f64; 2] {
        [
            0.4 + V_MPS * HEADING_RAD.cos() * t_s,
            -0.2 + V_MPS * HEADING_RAD.sin() * t_s,
        ]
    }

    /// Sending time and its rate for an image of the pair, from the retarded times themselves.
    fn sent(image_at: &dyn Fn(f64) -> [f64; 2], t_s: f64) -> (f64, f64) {
        let medium = Medium {
            c_mps: C_MPS,
            rho_kgpm3: 1.2,
        };
        let source = Monopole {
            medium,
            strength_at: &|_| 0.0,
            support_s: [0.0; 2],
            finest_s: 1.0,
            position_at: image_at,
        };
        let at = |t_s: f64| source.sent_at_s(pair(t_s), t_s);
        let step_s = 1e-3;
        let rise = |steps: f64| at(t_s + steps * step_s) - at(t_s - steps * step_s);
        (at(t_s), (8.0 * rise(1.0) - rise(2.0)) / (12.0 * step_s))
    }

    #[test]
    fn a_plane_wall_scales_time_exactly() {
        let wall_x_m = 3.0;
        let (_, rate) = sent(&|t_s| [2.0 * wall_x_m - pair(t_s)[0], pair(t_s)[1]], 0.01);
        assert!((rate - plane_wall(V_MPS / C_MPS, HEADING_RAD)).abs() < 1e-10);
        assert!((rate - corner(V_MPS / C_MPS, HEADING_RAD)).abs() > 1e-5);
    }

    #[test]
    fn a_corner_scales_time_by_the_angle_of_arrival() {
        let apex = [3.0, 1.0];
        let image = |t_s: f64| [2.0 * apex[0] - pair(t_s)[0], 2.0 * apex[1] - pair(t_s)[1]];
        let (sent_s, rate) = sent(&image, 0.01);
        let (here, there) = (pair(0.01), image(sent_s));
        let theta = (there[1] - here[1]).atan2(there[0] - here[0]) - HEADING_RAD;
        assert!((rate - corner(V_MPS / C_MPS, theta)).abs() < 1e-9);
    }

    #[test]
    fn parallel_walls_leave_time_alone() {
        let (_, rate) = sent(&|t_s| [pair(t_s)[0] + 6.0, pair(t_s)[1]], 0.01);
        assert!((rate - parallel_walls()).abs() < 1e-10);
    }
}
