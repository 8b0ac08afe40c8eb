//! Data of the figures: dispersion of the schemes, and the scene's echoes beside its image sources.

use std::f64::consts::TAU;
use std::path::Path;

use anyhow::Result;
use fdtd::scheme::Scheme;
use oracles::laws::conditions::Conditions;
use oracles::laws::setting::Setting;
use oracles::laws::{Depth, dispersion, scene_echoes};

use crate::data::table::{Table, cell};

/// Directions of the curves of the dispersion relation, degrees.
const ANGLES_DEG: [f64; 3] = [0.0, 22.5, 45.0];

/// Columns of velocities, by the relation and measured.
const COLUMNS: [&str; 5] = [
    "scheme",
    "angle_deg",
    "frequency_hz",
    "phase_error",
    "group_error",
];

/// Curves of the dispersion relation on the papers' grid.
pub(super) fn curves() -> Table {
    let mut table = Table::new(COLUMNS);
    let papers = Conditions::PAPERS;
    for scheme in Scheme::ALL {
        let grid = scheme.polynomial(papers.courant());
        for angle_deg in ANGLES_DEG {
            for step in 1..=76 {
                let frequency_hz = 250.0 * f64::from(step);
                let (omega_dt, angle_rad) =
                    (TAU * frequency_hz * papers.dt_s, angle_deg.to_radians());
                let velocities = grid
                    .phase_velocity(omega_dt, angle_rad)
                    .zip(grid.group_velocity(omega_dt, angle_rad));
                if let Some((phase, group)) = velocities {
                    table.push([
                        scheme.to_string(),
                        angle_deg.to_string(),
                        cell(frequency_hz, 0),
                        cell(phase - 1.0, 7),
                        cell(group - 1.0, 7),
                    ]);
                }
            }
        }
    }
    table
}

/// Phase and group velocities measured on the field, on the papers' grid as the curves.
pub(super) fn measured() -> Result<Table> {
    let mut table = Table::new(COLUMNS);
    for velocity in dispersion::all(|_, _| Setting::PAPERS)? {
        table.push([
            velocity.scheme.to_string(),
            cell(velocity.angle_rad.to_degrees(), 1),
            cell(velocity.frequency_hz, 0),
            cell(velocity.phase.off(), 7),
            cell(velocity.group.off(), 7),
        ]);
    }
    Ok(table)
}

/// Echoes of the scene, field and images: the signals at a place of the whole scene, and the errors of every echo that
/// is separate from the others.
pub(super) fn scene_echoes(depth: Depth, data: &Path) -> Result<()> {
    let places = scene_echoes::places(depth)?;
    let mut signal = Table::new(["t_ms", "field_pa", "images_pa"]);
    if let Some(place) = places.iter().find(|place| place.whole) {
        // At half of the field's rate, from the burst's peak on.
        let conditions = &place.conditions;
        let peak_s = scene_echoes::burst(conditions).centre_s;
        let since_s = |n: usize| n as f64 * conditions.dt_s - peak_s;
        for n in (0..place.recorded.len())
            .step_by(2)
            .filter(|&n| since_s(n) >= 0.0)
        {
            signal.push([
                cell(1e3 * since_s(n), 4),
                format!("{:.4e}", place.recorded[n]),
                format!("{:.4e}", place.images[n]),
            ]);
        }
    }
    signal.write(&data.join("scene_signal.csv"))?;
    let header = [
        "x_m",
        "y_m",
        "scene",
        "kind",
        "walls",
        "length_m",
        "louder_db",
        "late_us",
        "late_on_c_us",
    ];
    let mut table = Table::new(header);
    for place in &places {
        for echo in &place.echoes {
            table.push([
                cell(place.place_m[0], 4),
                cell(place.place_m[1], 4),
                if place.whole {
                    "all walls"
                } else {
                    "pair along the grid"
                }
                .to_string(),
                echo.kind.name().to_string(),
                if echo.along_grid {
                    "along the grid"
                } else {
                    "slanted"
                }
                .to_string(),
                cell(echo.length_m, 4),
                cell(echo.louder_db, 3),
                cell(1e6 * echo.late_s, 2),
                cell(1e6 * echo.late_on_c_s, 1),
            ]);
        }
    }
    table.write(&data.join("scene_echoes.csv"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curves_hold_every_scheme() {
        let table = curves();
        assert_eq!(
            table.distinct("scheme").unwrap(),
            ["slf", "m13", "o13", "d25", "iwb"]
        );
    }
}
