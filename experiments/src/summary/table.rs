//! The accuracies of a summary as text.

use super::multipath::Multipath;
use super::studies::Summary;
use crate::data::table::aligned;
use crate::metrics::Accuracy;

/// The accuracies of a summary as rows of a table, its header first.
pub fn rows(summary: &Summary) -> Vec<Vec<String>> {
    let mut rows = vec![
        [
            "study",
            "cell",
            "MAE [m]",
            "95 % interval [m]",
            "90 % below [m]",
            "trials",
        ]
        .map(String::from)
        .to_vec(),
    ];
    let mut add = |study: &str, cell: String, accuracy: &Accuracy| {
        let [low, high] = accuracy.interval_m;
        rows.push(vec![
            study.to_string(),
            cell,
            format!("{:.4}", accuracy.mae_m),
            format!("{low:.4} to {high:.4}"),
            format!("{:.4}", accuracy.p90_m),
            accuracy.trials.to_string(),
        ]);
    };
    if let Some(methods) = &summary.odometry_drift {
        add("odometry-drift", "Doppler".into(), &methods.doppler);
        add("odometry-drift", "ToA only".into(), &methods.toa_only);
        add("odometry-drift", "odometry".into(), &methods.odometry);
    }
    for cell in &summary.window_size {
        add(
            "window-size",
            format!("{} m", cell.half_width_m),
            &cell.accuracy,
        );
    }
    for cell in &summary.periods {
        add("periods", format!("M = {}", cell.m), &cell.accuracy);
    }
    for cell in &summary.snr {
        add("snr", format!("{} dB", cell.snr_db), &cell.accuracy);
    }
    if let Some(site) = &summary.site {
        let methods = &site.odometry_drift;
        add("site", "Doppler".into(), &methods.doppler);
        add("site", "ToA only".into(), &methods.toa_only);
        add("site", "odometry".into(), &methods.odometry);
        for cell in &site.window_size {
            add("site", format!("{} m", cell.half_width_m), &cell.accuracy);
        }
        for cell in &site.snr {
            add("site", format!("{} dB", cell.snr_db), &cell.accuracy);
        }
    }
    if let Some(schemes) = &summary.schemes {
        add("schemes", "slf, Doppler".into(), &schemes.slf.doppler);
        add("schemes", "slf, ToA only".into(), &schemes.slf.toa_only);
    }
    for (cell, accuracy) in summary.multipath.iter().flat_map(multipath_rows) {
        add("multipath", cell.into(), accuracy);
    }
    rows
}

/// The accuracies of a summary as a table.
pub fn table(summary: &Summary) -> String {
    let mut text = aligned(&rows(summary));
    if let Some(time) = &summary.step_time_ms {
        text.push_str(&format!(
            "step time: Doppler bank {:.2} ms, filter {:.2} ms\n",
            time.doppler_bank, time.filter
        ));
    }
    if let Some(engine) = &summary.engine {
        text.push_str(&format!(
            "engine: {} {:.2} Gcell/s, slf {:.2} Gcell/s, {} threads\n",
            engine.scheme, engine.gcells_per_s, engine.slf_gcells_per_s, engine.threads
        ));
    }
    text
}

/// Rows of the table of accuracies: cell and accuracy.
fn multipath_rows(found: &Multipath) -> [(&'static str, &Accuracy); 7] {
    [
        ("(a) single", &found.single.accuracy),
        ("(b) double, in the plane", &found.planar.accuracy),
        ("(c) with ceiling and floor", &found.spatial.accuracy),
        ("odometry", &found.odometry.accuracy),
        ("scene: (b)", &found.scene.planar),
        ("scene: Doppler", &found.scene.doppler),
        ("scene: odometry", &found.scene.odometry),
    ]
}
