//! A robot drives in front of a right-angled corner: the whole chain of a recording against image sources.
//!
//! Layout: 1.8 m x 1.8 m, two walls through the layers that close any quarter of the plane, the robot 0.4 to 0.9 m from
//! them; loudspeaker and microphone 8 cm apart on a robot that drives a curve at 0.4 m/s; noise of 1.5 to 5 kHz for
//! 0.15 s at 40 kHz. The free-field run of the same drive is subtracted.
//! Formula: two single echoes and the corner's, [`crate::image_source`], at retarded times of the moving images.
//! Bias: dispersion over 1 to 3 m; the two terms of the Hankel series leave 1e-3 of the nearest echo at 1.5 kHz.
//! Tolerance: 1 % of the echoes (root mean square), 0.02 dB with m13; 5 % and 0.03 dB with d25, whose error of phase is
//! spread over the whole band. An echo left out, or one of half the strength, would be 20 % or more.

use super::measurement::{Depth, Measurement, named};
use super::rig::{decibels, difference, echoes, norm};
use super::setting::Setting;
use crate::image_source::{DrivingPair, ImageSourceOptions, synthesize};
use fdtd::Error;
use fdtd::grid::Grid;
use fdtd::motion::{DrivePath, MotionState};
use fdtd::scene::{Robot, Scene, WaveformSpec};
use fdtd::scheme::Scheme;
use fdtd::simulation::Simulation;
use fdtd::spread::Spread;
use fdtd::walls::{Wall, WallModel};
use fdtd::waveform::PeriodicWaveform;
use std::collections::BTreeMap;

/// Sampling rate on the papers' grid.
const RATE_HZ: f64 = 40e3;

/// Ends of the signal's band in hertz on the papers' grid.
const BAND_HZ: [f64; 2] = [1.5e3, 5e3];

/// The corner and the drive in front of it.
///
/// # Errors
/// None: the drive is valid.
pub fn scene(setting: &Setting, scheme: Scheme) -> Result<Scene, Error> {
    let Setting {
        conditions, turn, ..
    } = *setting;
    let size = setting.more_cells.map(|more| 360 + more);
    let size_m = size.map(|cells| cells as f64 * conditions.dx_m);
    let [x_m, y_m] = setting.between([[0.45, 0.79], [0.6, 0.9]]);
    let start = MotionState {
        x_m,
        y_m,
        heading_rad: 0.4,
        v_mps: conditions.mps(0.4),
        omega_radps: conditions.hz(1.5),
    };
    let start = turn.pose(size_m, &start);
    let offset_m = |offset_m: [f64; 2]| turn.offset(conditions.point(offset_m));
    // Faces at x = 1.3 m and y = 1.4 m, on the cells' borders.
    let points_m = [[1.31, -0.2], [1.31, 1.41], [-0.2, 1.41]];
    let points_m = points_m.map(|point| turn.point(size_m, conditions.point(point)));
    let [nx, ny] = turn.size(size);
    let papers = WaveformSpec::default();
    Ok(Scene {
        name: "a right-angled corner".into(),
        description: String::new(),
        medium: conditions.medium,
        air: None,
        grid: Grid {
            nx,
            ny,
            dx_m: conditions.dx_m,
            dt_s: conditions.dt_s,
        },
        layer_cells: 20,
        scheme,
        spread: Spread::Kaiser12,
        walls: vec![Wall {
            points_m: points_m.to_vec(),
            thickness_m: conditions.m(0.02),
            impedance: None,
        }],
        wall_model: WallModel::default(),
        waveform: WaveformSpec {
            chip_rate_hz: conditions.hz(papers.chip_rate_hz),
            carrier_hz: conditions.hz(papers.carrier_hz),
            band_hz: papers.band_hz.map(|hz| conditions.hz(hz)),
            ..papers
        },
        sample_rate_hz: conditions.hz(RATE_HZ),
        robot: Robot {
            loudspeaker_offset_m: offset_m([0.05, 0.01]),
            microphone_offset_m: offset_m([-0.03, 0.0]),
        },
        paths: BTreeMap::from([(
            "drive".into(),
            DrivePath::uniform(start, conditions.s(0.15))?,
        )]),
    })
}

/// Errors of the recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerError {
    /// Waveform of all echoes, relative.
    pub waveform: f64,
    /// Their level, dB.
    pub level_db: f64,
    /// Waveform against the single echoes alone, relative: the share of the corner's echo.
    pub without_corner: f64,
}

/// Records the drive and compares it with its images.
///
/// # Errors
/// When the field becomes non-finite.
pub fn corner(setting: &Setting, scheme: Scheme) -> Result<CornerError, Error> {
    let conditions = &setting.conditions;
    let scene = scene(setting, scheme)?;
    // Odd about time 0, where it starts: the field then begins without a jump.
    let chip = |k: u64| {
        if (k * k * 31 + k * 7) % 1009 < 504 {
            1.0
        } else {
            -1.0
        }
    };
    let chips: Vec<f64> = (0..1001)
        .map(|k| chip(k) - chip((1001 - k) % 1001))
        .collect();
    let (rate_hz, band_hz) = (scene.sample_rate_hz, BAND_HZ.map(|hz| conditions.hz(hz)));
    let field_rate_hz = 1.0 / conditions.dt_s;
    let waveform = PeriodicWaveform::with_band(&chips, 1001.0 / rate_hz, band_hz, field_rate_hz);
    let echoes = echoes(&scene, "drive", &waveform, Simulation::signal)?;
    let drive = DrivingPair {
        path: scene.path("drive")?,
        loudspeaker_offset_m: scene.robot.loudspeaker_offset_m,
        microphone_offset_m: scene.robot.microphone_offset_m,
    };
    let images = |max_order| -> Vec<f64> {
        let options = ImageSourceOptions {
            max_order,
            ..ImageSourceOptions::default()
        };
        let signal = synthesize(
            &scene.walls,
            &drive,
            &waveform,
            &conditions.medium,
            rate_hz,
            &options,
        );
        signal.into_iter().map(f64::from).collect()
    };
    let expected = images(2);
    // The field starts abruptly, the images softly: both have forgotten it by then.
    let from = (0.03 * RATE_HZ) as usize;
    let off = |expected: &[f64]| {
        norm(&difference(&echoes[from..], &expected[from..])) / norm(&expected[from..])
    };
    Ok(CornerError {
        waveform: off(&expected),
        level_db: decibels(norm(&echoes[from..]) / norm(&expected[from..])),
        without_corner: off(&images(1)),
    })
}

/// Schemes, and their tolerances of waveform and level in dB.
pub const CASES: [(Scheme, [f64; 2]); 2] =
    [(Scheme::M13, [0.01, 0.02]), (Scheme::D25, [0.05, 0.03])];

/// The law's measurements.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let cases = match depth {
        Depth::Quick => &CASES[..1],
        Depth::Full => &CASES[..],
    };
    let mut found = Vec::new();
    for &(scheme, allowed) in cases {
        let case = format!("{scheme}, drive at 0.4 m/s, 1.5 to 5 kHz");
        let setting = Setting::drawn("corner", &case);
        let error = corner(&setting, scheme)?;
        let case = named(&case, &setting);
        let measured = [error.waveform, error.level_db];
        found.extend(Measurement::waveform_and_level(&case, measured, allowed));
        let quantity = "waveform without the corner's echo";
        found.push(Measurement::shown(case, quantity, error.without_corner));
    }
    Ok(found)
}
