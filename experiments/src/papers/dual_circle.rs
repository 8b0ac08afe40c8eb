//! Four receivers around a square, a 40 kHz transmitter at nine points (Hsu et al., Sens. Mater. 2021, Tables 1 and 2).

use anyhow::{Context, Result};
use localizer::beacons::Beacons;

use super::PaperSession;
use crate::data::table::{Table, cell};
use crate::metrics::{mean, rounded};
use crate::recordings::ultrasound::{Link, Ranging};
use crate::summary::{AxisErrors, DualCircle, Summary};

/// Corners of the 4 m square. The paper draws its receivers as a figure only; corners fit its farthest distance, 4.24
/// m.
const RECEIVERS_M: [[f64; 2]; 4] = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
/// Repetitions of each point.
const TRIALS: u64 = 20;
/// Standard deviation of a range for the covariance, metres: the timer's tick and the threshold's dependence on level.
const SIGMA_M: f64 = 0.01;

/// Measured coordinates of Table 1 (dual circle), centimetres, points 1 to 9. All within 6 cm.
const TABLE_1_CM: [[f64; 2]; 9] = [
    [104.0, 99.0],
    [200.0, 101.0],
    [302.0, 105.0],
    [104.0, 198.0],
    [204.0, 197.0],
    [300.5, 198.5],
    [104.5, 295.0],
    [202.5, 294.0],
    [301.0, 295.5],
];
/// Measured coordinates of Table 2 (triangulation), centimetres. Point 6 is off by 7 cm: the 6 cm hold for Table 1
/// alone.
const TABLE_2_CM: [[f64; 2]; 9] = [
    [101.0, 99.0],
    [196.0, 101.0],
    [295.0, 103.0],
    [100.0, 198.0],
    [198.0, 197.0],
    [293.0, 198.0],
    [101.0, 296.0],
    [198.0, 294.0],
    [296.0, 294.0],
];

/// True coordinates of point `index`, metres.
fn truth_m(index: usize) -> [f64; 2] {
    [1.0 + (index % 3) as f64, 1.0 + (index / 3) as f64]
}

/// Columns of both data files, before those of the covariance.
const COLUMNS: [&str; 7] = [
    "method", "trial", "point", "x_true_m", "y_true_m", "x_m", "y_m",
];

fn row(method: &str, trial: u64, index: usize, found: [f64; 2]) -> Vec<String> {
    let truth = truth_m(index);
    let mut cells = vec![
        method.to_string(),
        trial.to_string(),
        (index + 1).to_string(),
    ];
    cells.extend([truth[0], truth[1], found[0], found[1]].map(|value| cell(value, 5)));
    cells
}

/// The published tables.
fn published() -> Table {
    let mut table = Table::new(COLUMNS);
    for (method, points) in [("dual-circle", TABLE_1_CM), ("triangulation", TABLE_2_CM)] {
        for (index, point) in points.iter().enumerate() {
            table.push(row(method, 0, index, point.map(|value| 0.01 * value)));
        }
    }
    table
}

/// Errors per axis of a method in a table.
fn errors(table: &Table, method: &str) -> Result<AxisErrors> {
    let rows = table.only("method", method)?;
    let axis = |found: &str, truth: &str| -> Result<Vec<f64>> {
        let pairs = rows.numbers(found)?.into_iter().zip(rows.numbers(truth)?);
        Ok(pairs.map(|(found, truth)| (found - truth).abs()).collect())
    };
    let (x, y) = (axis("x_m", "x_true_m")?, axis("y_m", "y_true_m")?);
    let worst = x.iter().chain(&y).copied().fold(0.0, f64::max);
    Ok(AxisErrors {
        mae_x_m: rounded(mean(&x)),
        mae_y_m: rounded(mean(&y)),
        worst_m: rounded(worst),
    })
}

/// Simulated ranges at all points, solved by the three methods.
fn measured() -> Result<Table> {
    let beacons = Beacons::new(&RECEIVERS_M)?;
    let ranging = Ranging::new(Link::default());
    let mut table = Table::new(COLUMNS.into_iter().chain(["sigma_x_m", "sigma_y_m"]));
    for trial in 0..TRIALS {
        for index in 0..9 {
            let [x, y] = truth_m(index);
            let ranges = RECEIVERS_M
                .iter()
                .enumerate()
                .map(|(poll, receiver)| {
                    let distance_m = (x - receiver[0]).hypot(y - receiver[1]);
                    ranging
                        .range_m(distance_m, &format!("point {}", index + 1), trial, poll)
                        .with_context(|| format!("receiver {poll} hears no pulse"))
                })
                .collect::<Result<Vec<f64>>>()?;
            // The paper's eqs. (1)-(5) take the receivers 1 and 2; the others decide between the two points.
            let circles = beacons.dual_circle(&ranges, [0, 1])?;
            table.push(row("dual-circle", trial, index, circles));
            let triangles = beacons.triangulate(&ranges)?;
            table.push(row("triangulation", trial, index, triangles));
            let fix = beacons.least_squares(&ranges, SIGMA_M)?;
            let mut cells = row("least-squares", trial, index, fix.position_m);
            cells.extend([0, 1].map(|axis| cell(fix.covariance_m2[axis][axis].sqrt(), 5)));
            table.push(cells);
        }
    }
    Ok(table)
}

/// Runs the study.
pub(super) fn run(session: &PaperSession, summary: &mut Summary) -> Result<()> {
    let path = session.data("dual_circle_published.csv");
    published().write(&path)?;
    let published = Table::read(&path)?;
    let measured = measured()?;
    measured.write(&session.data("dual_circle.csv"))?;
    summary.dual_circle = Some(DualCircle {
        published_dual_circle: errors(&published, "dual-circle")?,
        published_triangulation: errors(&published, "triangulation")?,
        dual_circle: errors(&measured, "dual-circle")?,
        triangulation: errors(&measured, "triangulation")?,
        least_squares: errors(&measured, "least-squares")?,
    });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper prints (2.5, 3.22) cm and (2.89, 3.11) cm.
    #[test]
    fn the_published_means_follow_from_the_published_tables() {
        let table = published();
        let near = |a: f64, b: f64| (a - b).abs() < 5e-5;
        let first = errors(&table, "dual-circle").unwrap();
        assert!(near(first.mae_x_m, 0.025) && near(first.mae_y_m, 0.0322));
        assert!(near(first.worst_m, 0.06));
        let second = errors(&table, "triangulation").unwrap();
        assert!(near(second.mae_x_m, 0.0289) && near(second.mae_y_m, 0.0311));
        assert!(near(second.worst_m, 0.07));
    }
}
