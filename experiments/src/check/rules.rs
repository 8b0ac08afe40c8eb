//! Rules for the claims that are more than one number against a bound, by the claim's id in `experiments/targets.json`.
//!
//! A rule reads the summary as JSON, so that a study whose part is missing gives no finding instead of an error.

use serde_json::Value;

use super::targets::Target;

/// Result of a claim in a summary.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Finding {
    /// Our number as text.
    pub(super) ours: String,
    /// Its 95 % interval, where it has one.
    pub(super) interval: Option<[f64; 2]>,
    /// Number of trials behind it, where there are several.
    pub(super) trials: Option<usize>,
    /// Whether the claim holds.
    pub(super) holds: bool,
}

/// The finding for a claim; `None` when a study it needs has not been run.
pub(super) type Rule = fn(&Value, &Target) -> Option<Finding>;

/// All rules.
pub(super) const RULES: &[(&str, Rule)] = &[
    ("sim-odometry-drifts", |summary, target| {
        ratio(
            summary,
            "odometry_drift.odometry",
            "odometry_drift.doppler",
            target,
        )
    }),
    ("sim-toa-worse", |summary, _| {
        toa_worse(at(summary, "odometry_drift")?)
    }),
    ("sim-best-window", |summary, target| {
        best_window(at(summary, "window_size")?, target)
    }),
    ("sim-window-explained", |summary, target| {
        explained(
            at(summary, "window_size")?,
            at(summary, "reflections")?,
            target,
        )
    }),
    ("site-window-explained", |summary, target| {
        explained(
            at(summary, "site.window_size")?,
            at(summary, "site.reflections")?,
            target,
        )
    }),
    ("sim-snr-3db", |summary, target| {
        above_3_db(at(summary, "snr")?, target)
    }),
    ("sim-snr-low", |summary, target| {
        low_snr(at(summary, "snr")?, target)
    }),
    ("site-odometry-drifts", |summary, target| {
        let [odometry, doppler] = [
            "site.odometry_drift.odometry",
            "site.odometry_drift.doppler",
        ];
        ratio(summary, odometry, doppler, target)
    }),
    ("site-toa-worse", |summary, _| {
        toa_worse(at(summary, "site.odometry_drift")?)
    }),
    ("site-best-window", |summary, target| {
        best_window(at(summary, "site.window_size")?, target)
    }),
    ("site-snr-3db", |summary, target| {
        above_3_db(at(summary, "site.snr")?, target)
    }),
    ("site-snr-low", |summary, target| {
        low_snr(at(summary, "site.snr")?, target)
    }),
    ("step-time-real-time", |summary, target| {
        let time = at(summary, "step_time_ms")?;
        let (bank, filter) = (time["doppler_bank"].as_f64()?, time["filter"].as_f64()?);
        let ours = format!("{bank:.1} ms + {filter:.1} ms");
        Some(plain(ours, bank + filter <= target.value?))
    }),
    ("periods-m2-deviates", |summary, target| {
        let (two, six) = (periods(summary, 2)?, periods(summary, 6)?);
        let [low, high] = interval(two)?;
        Some(Finding {
            ours: format!("{:.3} m, M = 6 {:.3} m", mae(two)?, mae(six)?),
            interval: Some([low, high]),
            trials: trials(two),
            holds: low >= target.value? * mae(six)?,
        })
    }),
    ("periods-m4-close", |summary, target| {
        let (four, six) = (periods(summary, 4)?, periods(summary, 6)?);
        Some(Finding {
            ours: format!("{:.3} m, M = 6 {:.3} m", mae(four)?, mae(six)?),
            interval: interval(four),
            trials: trials(four),
            holds: mae(four)? <= target.value? * mae(six)?,
        })
    }),
    ("periods-m6-close", |summary, target| {
        let odometry = at(summary, "odometry_drift.odometry")?;
        let six = periods(summary, 6)?;
        Some(Finding {
            ours: format!("{:.3} m, odometry {:.3} m", mae(six)?, mae(odometry)?),
            interval: interval(six),
            trials: trials(six),
            holds: mae(odometry)? >= target.value? * mae(six)?,
        })
    }),
    ("angular-resolution", |summary, target| {
        let cells = at(summary, "angular_resolution")?.as_array()?;
        let ratios: Vec<f64> = cells
            .iter()
            .map(|cell| Some(cell["half_power_width"].as_f64()? / cell["theory"].as_f64()?))
            .collect::<Option<_>>()?;
        let low = ratios.iter().copied().reduce(f64::min)?;
        let high = ratios.iter().copied().reduce(f64::max)?;
        let far = (low - target.value?)
            .abs()
            .max((high - target.value?).abs());
        let ours = format!(
            "{low:.3} to {high:.3} times theory, {} values of M",
            ratios.len()
        );
        Some(plain(ours, far <= target.tolerance))
    }),
    ("multipath-order", |summary, _| {
        let found = at(summary, "multipath")?;
        let [a, b, c] = [
            mae(&found["single"])?,
            mae(&found["planar"])?,
            mae(&found["spatial"])?,
        ];
        let ours = format!("{c:.3}, {b:.3} and {a:.3} m for (c), (b) and (a)");
        Some(plain(ours, c < b && b < a))
    }),
    ("multipath-a-lost", |summary, target| {
        let found = at(summary, "multipath")?;
        let (a, c) = (
            found["single"]["final_m"].as_f64()?,
            found["spatial"]["final_m"].as_f64()?,
        );
        // With a narrow gate no model loses the path: the verdict depends on it, so it is shown too.
        let narrow = found["gates"]
            .as_array()?
            .iter()
            .filter_map(|gate| Some((gate["gate_m"].as_f64()?, gate["single_m"].as_f64()?)))
            .reduce(|a, b| if b.0 < a.0 { b } else { a })
            .map_or(String::new(), |(gate_m, error_m)| {
                format!("; (a) with a gate of {gate_m} m: MAE {error_m:.3} m")
            });
        let ours = format!("{a:.3} m at the end, (c) {c:.3} m{narrow}");
        Some(plain(ours, a > target.value? && c < target.value?))
    }),
    ("dual-circle-published", |summary, target| {
        let printed = [
            ("published_dual_circle", [0.025, 0.0322]),
            ("published_triangulation", [0.0289, 0.0311]),
        ];
        let mut worst: f64 = 0.0;
        for (table, means_m) in printed {
            let found = axes(at(summary, &format!("dual_circle.{table}"))?)?;
            worst = worst
                .max((found[0] - means_m[0]).abs())
                .max((found[1] - means_m[1]).abs());
        }
        Some(plain(
            format!("{:.3} mm off at most", 1e3 * worst),
            worst <= target.value?,
        ))
    }),
    ("dual-circle-mae", |summary, _| {
        at_most(summary, "dual_circle", "published_dual_circle")
    }),
    ("triangulation-mae", |summary, _| {
        at_most(summary, "triangulation", "published_triangulation")
    }),
    ("least-squares-mae", |summary, _| {
        at_most(summary, "least_squares", "dual_circle")
    }),
    ("dual-circle-worst", |summary, target| {
        let found = at(summary, "dual_circle")?;
        let worst = ["dual_circle", "triangulation", "least_squares"]
            .iter()
            .map(|method| found[method]["worst_m"].as_f64())
            .collect::<Option<Vec<_>>>()?
            .into_iter()
            .fold(0.0, f64::max);
        Some(plain(
            format!("{:.1} cm at most", 100.0 * worst),
            worst <= target.value?,
        ))
    }),
];

/// The part of a summary at keys joined by dots, unless it is missing or null.
pub(super) fn at<'a>(summary: &'a Value, path: &str) -> Option<&'a Value> {
    path.split('.')
        .try_fold(summary, |value, key| value.get(key))
        .filter(|value| !value.is_null())
}

/// The 95 % interval of an accuracy.
pub(super) fn interval(accuracy: &Value) -> Option<[f64; 2]> {
    let ends = accuracy["interval_m"].as_array()?;
    Some([ends.first()?.as_f64()?, ends.get(1)?.as_f64()?])
}

/// A finding without interval.
fn plain(ours: String, holds: bool) -> Finding {
    Finding {
        ours,
        interval: None,
        trials: None,
        holds,
    }
}

/// Mean absolute error of an accuracy, metres.
fn mae(accuracy: &Value) -> Option<f64> {
    accuracy["mae_m"].as_f64()
}

/// Trials of an accuracy.
fn trials(accuracy: &Value) -> Option<usize> {
    accuracy["trials"].as_u64().map(|count| count as usize)
}

/// Accuracy with M periods.
fn periods(summary: &Value, m: u64) -> Option<&Value> {
    let cells = at(summary, "periods")?.as_array()?;
    cells.iter().find(|cell| cell["m"].as_u64() == Some(m))
}

/// One error is at least the value times another.
fn ratio(summary: &Value, large: &str, small: &str, target: &Target) -> Option<Finding> {
    let (large, small) = (mae(at(summary, large)?)?, mae(at(summary, small)?)?);
    let ours = format!("{large:.3} m, {:.1} times", large / small);
    Some(plain(ours, large >= target.value? * small))
}

/// ToA-only errors lie above those of Doppler in their mean and at the 90 % quantile.
fn toa_worse(methods: &Value) -> Option<Finding> {
    let (doppler, toa_only) = (&methods["doppler"], &methods["toa_only"]);
    let worse = |field: &str| Some(toa_only[field].as_f64()? > doppler[field].as_f64()?);
    Some(Finding {
        ours: format!("{:.3} m, Doppler {:.3} m", mae(toa_only)?, mae(doppler)?),
        interval: interval(toa_only),
        trials: trials(toa_only),
        holds: worse("mae_m")? && worse("p90_m")?,
    })
}

/// The cell of the least error, and the half-widths whose errors its interval holds.
fn best_windows(cells: &Value) -> Option<(&Value, Vec<f64>)> {
    let cells = cells.as_array()?;
    let error = |cell: &Value| mae(cell).unwrap_or(f64::INFINITY);
    let best = cells.iter().min_by(|a, b| error(a).total_cmp(&error(b)))?;
    let [_, end] = interval(best)?;
    let good = cells
        .iter()
        .filter(|cell| error(cell) <= end.max(error(best)))
        .filter_map(|cell| cell["half_width_m"].as_f64())
        .collect();
    Some((best, good))
}

/// The best half-width and those as good, as text.
fn windows(best: &Value, good: &[f64]) -> Option<String> {
    let low = good.iter().copied().reduce(f64::min)?;
    let high = good.iter().copied().reduce(f64::max)?;
    let range = match low < high {
        true => format!("; as good from {low:.1} to {high:.1} m"),
        false => String::new(),
    };
    let half_width_m = best["half_width_m"].as_f64()?;
    Some(format!("{half_width_m:.1} m ({:.3} m{range})", mae(best)?))
}

/// A half-width as good as the best lies near the value.
fn best_window(cells: &Value, target: &Target) -> Option<Finding> {
    let (best, good) = best_windows(cells)?;
    let value = target.value?;
    Some(Finding {
        ours: windows(best, &good)?,
        interval: interval(best),
        trials: trials(best),
        holds: good
            .iter()
            .any(|width| (width - value).abs() <= target.tolerance),
    })
}

/// Half of the longest usable round trip is a half-width as good as the best.
fn explained(cells: &Value, reflections: &Value, target: &Target) -> Option<Finding> {
    let (best, good) = best_windows(cells)?;
    let half_m = 0.5 * reflections["farthest_usable_m"].as_f64()?;
    Some(Finding {
        ours: format!("half is {half_m:.1} m, best {}", windows(best, &good)?),
        interval: None,
        trials: trials(best),
        holds: good
            .iter()
            .any(|width| (width - half_m).abs() <= target.tolerance),
    })
}

/// The greatest error at 3 dB and more is at most the value.
fn above_3_db(cells: &Value, target: &Target) -> Option<Finding> {
    let worst = cells
        .as_array()?
        .iter()
        .filter(|cell| cell["snr_db"].as_f64().is_some_and(|snr_db| snr_db >= 3.0))
        .filter(|cell| mae(cell).is_some())
        .max_by(|a, b| mae(a).unwrap_or(0.0).total_cmp(&mae(b).unwrap_or(0.0)))?;
    Some(Finding {
        ours: format!("{:.3} m at most", mae(worst)?),
        interval: interval(worst),
        trials: trials(worst),
        holds: mae(worst)? <= target.value?,
    })
}

/// At the lowest ratio even the lower end of the interval is the value times the error at the highest ratio.
fn low_snr(cells: &Value, target: &Target) -> Option<Finding> {
    let cells = cells.as_array().filter(|cells| cells.len() > 1)?;
    let snr_db = |cell: &&Value| cell["snr_db"].as_f64().unwrap_or(0.0);
    let low = cells
        .iter()
        .min_by(|a, b| snr_db(a).total_cmp(&snr_db(b)))?;
    let high = cells
        .iter()
        .max_by(|a, b| snr_db(a).total_cmp(&snr_db(b)))?;
    Some(Finding {
        ours: format!(
            "{:.3} m at {} dB, {:.3} m at {} dB",
            mae(low)?,
            snr_db(&low),
            mae(high)?,
            snr_db(&high)
        ),
        interval: interval(low),
        trials: trials(low),
        holds: interval(low)?[0] >= target.value? * mae(high)?,
    })
}

/// Mean absolute errors per axis, metres.
fn axes(errors: &Value) -> Option<[f64; 2]> {
    Some([errors["mae_x_m"].as_f64()?, errors["mae_y_m"].as_f64()?])
}

/// A method's errors on both axes are at most the published ones.
fn at_most(summary: &Value, method: &str, published: &str) -> Option<Finding> {
    let found = at(summary, "dual_circle")?;
    let (ours, limit) = (axes(&found[method])?, axes(&found[published])?);
    let text = format!("({:.2}, {:.2}) cm", 100.0 * ours[0], 100.0 * ours[1]);
    Some(plain(text, ours[0] <= limit[0] && ours[1] <= limit[1]))
}
