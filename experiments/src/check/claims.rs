//! The papers' claims, each with our number and a verdict.

use serde::Serialize;

use crate::metrics::Accuracy;
use crate::summary::{AxisErrors, Summary};

/// A claim of the papers and what we find.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Claim {
    /// What is claimed.
    pub claim: String,
    /// The paper's number.
    pub paper: String,
    /// Our number with its interval.
    pub ours: String,
    /// Whether it holds here.
    pub reproduced: bool,
}

/// Mean and interval in metres.
pub(super) fn metres(accuracy: &Accuracy) -> String {
    let [low, high] = accuracy.interval_m;
    format!("{:.3} m [{low:.3}, {high:.3}]", accuracy.mae_m)
}

/// The claims that a study of `summary` speaks to; a claim whose study is missing counts as not reproduced.
pub fn claims(summary: &Summary) -> Vec<Claim> {
    let mut list = Vec::new();
    let mut add = |claim: &str, paper: &str, finding: Option<(String, bool)>| {
        let (ours, reproduced) = finding.unwrap_or(("study not run".to_string(), false));
        list.push(Claim {
            claim: claim.to_string(),
            paper: paper.to_string(),
            ours,
            reproduced,
        });
    };
    let drift = summary.odometry_drift.as_ref();
    add(
        "Doppler localization, MAE at M = 6 and a 4 m window",
        "0.042 m",
        drift.map(|methods| (metres(&methods.doppler), methods.doppler.mae_m <= 0.042)),
    );
    add(
        "wheel odometry alone is far worse (here: 5 times at least)",
        "large error",
        drift.map(|methods| {
            let ratio = methods.odometry.mae_m / methods.doppler.mae_m;
            (
                format!("{:.3} m, {ratio:.1} times", methods.odometry.mae_m),
                ratio >= 5.0,
            )
        }),
    );
    add(
        "ToA only is worse than Doppler",
        "CDF to the right",
        drift.map(|methods| {
            let worse = methods.toa_only.mae_m > methods.doppler.mae_m
                && methods.toa_only.p90_m > methods.doppler.p90_m;
            (metres(&methods.toa_only), worse)
        }),
    );
    let best = summary
        .window_size
        .iter()
        .min_by(|a, b| a.accuracy.mae_m.total_cmp(&b.accuracy.mae_m));
    add(
        "the window has a best half-width, in 3-5 m",
        "4-5 m (simulation), 3-5 m (experiment)",
        best.map(|cell| {
            let inside = (3.0..=5.0).contains(&cell.half_width_m);
            (
                format!("{:.1} m ({:.3} m)", cell.half_width_m, cell.accuracy.mae_m),
                inside,
            )
        }),
    );
    add(
        "MAE at SNR of 3 dB and more",
        "below 0.05 m",
        summary
            .snr
            .iter()
            .filter(|cell| cell.snr_db >= 3.0)
            .map(|cell| cell.accuracy.mae_m)
            .reduce(f64::max)
            .map(|worst| (format!("{worst:.3} m at most"), worst <= 0.05)),
    );
    let by_noise = |pick: fn(f64, f64) -> bool| {
        summary
            .snr
            .iter()
            .reduce(|a, b| if pick(b.snr_db, a.snr_db) { b } else { a })
            .filter(|_| summary.snr.len() > 1)
    };
    add(
        "the error grows when the SNR falls",
        "much larger at low SNR",
        by_noise(|a, b| a < b)
            .zip(by_noise(|a, b| a > b))
            .map(|(low, high)| {
                let ours = format!(
                    "{:.3} m at {} dB, {:.3} m at {} dB",
                    low.accuracy.mae_m, low.snr_db, high.accuracy.mae_m, high.snr_db
                );
                (ours, low.accuracy.interval_m[0] > 1.5 * high.accuracy.mae_m)
            }),
    );
    let with_periods = |m: usize| summary.periods.iter().find(|cell| cell.m == m);
    let (two, four, six) = (with_periods(2), with_periods(4), with_periods(6));
    add(
        "M = 2 deviates clearly, M = 4 and 6 stay close",
        "paths of the 2023 abstract",
        two.zip(four).zip(six).map(|((two, four), six)| {
            let ours = format!(
                "{:.3}, {:.3} and {:.3} m for M = 2, 4 and 6",
                two.accuracy.mae_m, four.accuracy.mae_m, six.accuracy.mae_m
            );
            let close = four.accuracy.mae_m.max(six.accuracy.mae_m);
            (ours, two.accuracy.interval_m[0] > 1.25 * close)
        }),
    );
    add(
        "single and corner echoes reach a round trip of about 8 m",
        "8 m",
        summary.reflections.as_ref().map(|found| {
            let near = (found.farthest_usable_m - 8.0).abs() <= 1.0;
            (format!("{:.1} m", found.farthest_usable_m), near)
        }),
    );
    add(
        "one step fits into the step time of 102.3 ms",
        "32 ms + 57 ms",
        summary.step_time_ms.as_ref().map(|time| {
            let ours = format!("{:.1} ms + {:.1} ms", time.doppler_bank, time.filter);
            (ours, time.doppler_bank + time.filter < 102.3)
        }),
    );
    let points = summary.dual_circle.as_ref();
    let centimetres = |errors: &AxisErrors| {
        format!(
            "({:.2}, {:.2}) cm",
            100.0 * errors.mae_x_m,
            100.0 * errors.mae_y_m
        )
    };
    let at_most = |ours: &AxisErrors, published: &AxisErrors| {
        let below = ours.mae_x_m <= published.mae_x_m && ours.mae_y_m <= published.mae_y_m;
        (centimetres(ours), below)
    };
    add(
        "dual circle, mean absolute error in x and y (Hsu et al., 2021)",
        "(2.5, 3.22) cm",
        points.map(|found| at_most(&found.dual_circle, &found.published_dual_circle)),
    );
    add(
        "triangulation, mean absolute error in x and y",
        "(2.89, 3.11) cm",
        points.map(|found| at_most(&found.triangulation, &found.published_triangulation)),
    );
    add(
        "least squares over four receivers, no worse than the published dual circle",
        "(2.5, 3.22) cm",
        points.map(|found| at_most(&found.least_squares, &found.published_dual_circle)),
    );
    add(
        "all errors of the three methods within 6 cm",
        "6 cm (dual circle)",
        points.map(|found| {
            let worst = [
                &found.dual_circle,
                &found.triangulation,
                &found.least_squares,
            ]
            .map(|errors| errors.worst_m)
            .into_iter()
            .fold(0.0, f64::max);
            (format!("{:.1} cm at most", 100.0 * worst), worst <= 0.06)
        }),
    );
    list.extend(super::claims_multipath::claims(summary));
    list
}

/// The claims as a table.
pub fn table(claims: &[Claim]) -> String {
    let mut rows = vec![
        ["claim", "paper", "ours", "verdict"]
            .map(String::from)
            .to_vec(),
    ];
    rows.extend(claims.iter().map(|claim| {
        let verdict = if claim.reproduced {
            "reproduced"
        } else {
            "NOT reproduced"
        };
        vec![
            claim.claim.clone(),
            claim.paper.clone(),
            claim.ours.clone(),
            verdict.to_string(),
        ]
    }));
    super::aligned(&rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preset::Preset;
    use crate::summary::{Methods, WindowCell};

    fn accuracy(mae_m: f64) -> Accuracy {
        Accuracy::over(&[(&[mae_m], &[0.0])])
    }

    #[test]
    fn an_empty_summary_reproduces_nothing() {
        let claims = claims(&Summary::new(Preset::Paper));
        assert!(claims.len() >= 9);
        assert!(claims.iter().all(|claim| !claim.reproduced));
    }

    #[test]
    fn verdicts_follow_the_numbers() {
        let mut summary = Summary::new(Preset::Paper);
        summary.odometry_drift = Some(Methods {
            doppler: accuracy(0.03),
            toa_only: accuracy(0.05),
            odometry: accuracy(0.1),
        });
        summary.window_size = [1.0, 4.0, 6.0]
            .map(|half_width_m| WindowCell {
                half_width_m,
                accuracy: accuracy(0.03 + 0.01 * (half_width_m - 4.0_f64).abs()),
            })
            .to_vec();
        let found: Vec<bool> = claims(&summary)
            .iter()
            .map(|claim| claim.reproduced)
            .collect();
        assert_eq!(found[..4], [true, false, true, true]);
    }
}
