//! Lines on the logs of a recording.

use localizer::align::motion_of;
use localizer::io::recording_source::RecordingSource;
use localizer::odometry::OdometrySample;

use super::Inspection;

/// Blocks slower than this have no bearings, in m/s.
const SLOW_MPS: f64 = 0.02;

/// Adds the lines.
pub(super) fn look(inspection: &mut Inspection, source: &RecordingSource) {
    let length_s = source.duration_s();
    let wheels = &source.odometry;
    let times = || wheels.iter().map(|sample| sample.t_s);
    let (first, last) = (
        times().next().unwrap_or(0.0),
        times().next_back().unwrap_or(0.0),
    );
    let gap = wheels
        .windows(2)
        .map(|pair| pair[1].t_s - pair[0].t_s)
        .fold(0.0, f64::max);
    let rate_hz = (wheels.len() as f64 - 1.0) / (last - first).max(1e-9);
    let found = format!(
        "{first:.2} s to {last:.2} s of {length_s:.2} s, {rate_hz:.0} lines a second, longest gap {gap:.2} s"
    );
    let remedy = match (gap, rate_hz) {
        (gap, _) if gap > 0.3 => Some("log the wheels without pauses"),
        (_, rate_hz) if rate_hz < 8.0 => {
            Some("log the wheels at 10 Hz or more: turns are lost in between")
        }
        _ => None,
    };
    inspection.mind("wheels", found, remedy);
    let (way_m, turn_rad) = way(wheels, length_s);
    let speeds = wheels.iter().map(|sample| sample.v_mps.abs());
    let fastest = speeds.clone().fold(0.0, f64::max);
    let slow = speeds.filter(|v_mps| *v_mps < SLOW_MPS).count() as f64 / wheels.len().max(1) as f64;
    let found = format!(
        "{way_m:.2} m in {length_s:.1} s, at most {fastest:.2} m/s, {:.0} degrees of turns, {:.0} % at rest",
        turn_rad.to_degrees(),
        100.0 * slow
    );
    let remedy = match (fastest, slow) {
        (fastest, _) if fastest < SLOW_MPS => Some("drive: a robot at rest has no bearings"),
        (fastest, _) if fastest > 3.0 => Some("speeds are metres a second: check the unit"),
        (_, slow) if slow > 0.5 => Some("drive more: blocks at rest only move the particles"),
        _ => None,
    };
    inspection.mind("drive", found, remedy);
    inspection.wheels = wheels.clone();
    let Some(truth) = &source.truth else {
        inspection.ok(
            "truth",
            "none: enough for localize and track, not for map".to_owned(),
        );
        return;
    };
    let (first, last) = (truth.t_s[0], truth.t_s[truth.len() - 1]);
    let gap = truth
        .t_s
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .fold(0.0, f64::max);
    let found = format!(
        "{first:.2} s to {last:.2} s of {length_s:.2} s, {} poses, longest gap {gap:.2} s",
        truth.len()
    );
    let remedy = match (first, last, gap) {
        (first, last, _) if first > 1.0 || last < length_s - 1.0 => {
            Some("it does not cover the sound: poses beyond its ends are those at its ends")
        }
        (_, _, gap) if gap > 0.5 => Some("poses in a gap are those of a straight line"),
        _ => None,
    };
    inspection.mind("truth", found, remedy);
    let motion = motion_of(truth, 0.1);
    let (truth_m, truth_rad) = way(&motion, length_s);
    let scale = 100.0 * (way_m / truth_m.max(1e-6) - 1.0);
    let turn = (turn_rad - truth_rad).to_degrees();
    let found = format!("{scale:+.1} % of the way and {turn:+.1} degrees against the truth");
    let remedy = match scale.abs() > 5.0 || turn.abs() > 30.0 + 5.0 * truth_m {
        true => Some("calibrate the wheels' radius and distance, and check the signs"),
        false => None,
    };
    inspection.mind("wheels' error", found, remedy);
    inspection.truth = motion;
}

/// Way and turn from time 0 to the end, without signs of the speed.
fn way(samples: &[OdometrySample], length_s: f64) -> (f64, f64) {
    let inside = |t_s: f64| t_s.clamp(0.0, length_s);
    samples.windows(2).fold((0.0, 0.0), |(way, turn), pair| {
        let step_s = inside(pair[1].t_s) - inside(pair[0].t_s);
        let mean = |of: fn(&OdometrySample) -> f64| 0.5 * (of(&pair[0]) + of(&pair[1]));
        (
            way + step_s * mean(|sample| sample.v_mps.abs()),
            turn + step_s * mean(|sample| sample.omega_radps),
        )
    })
}
