//! Echoes of rigid walls: one wall's image source, and the time scale of two reflections between parallel walls.
//!
//! Layout, one wall: 2 m x 2 m, a wall over the whole height through the layers; source and microphone 0.6 m and 0.45 m
//! in front of it, side by side or 0.7 m apart along it, anywhere along it. A run without the wall is subtracted.
//! Formula: the image source of equal sign behind the wall's face, which lies on the cells' border;
//! [`crate::exact::monopole`].
//! Bias: as in free field over the echo's way.
//! Tolerance: 1.2 % of the waveform, 0.02 dB, 0.3 us at 4 kHz (m13); 6 %, 0.06 dB, 4 us at 2 kHz (slf); 4 %, 0.02 dB,
//! 1.5 us at 4 kHz (d25). Half a cell of error in the wall's place would be 15 us, a pressure-release wall would turn
//! the sign.
//!
//! Layout, two walls: 1 m between two parallel walls, a pair in one point anywhere along them that drives from one to
//! the other at 0.4 m/s; a burst of 10 kHz. Both walls minus each of them plus none leaves echoes of two and more
//! reflections; the window holds the twofold echo alone.
//! Formula: its images are 2 m ahead and behind and move with the pair: time scale 1, whatever the speed.
//! Bias: the two images arrive 14 us apart, which bends the phase of a short burst, and dispersion shifts the burst in
//! the windows: the images' exact signal goes through the same windows, and both are compared with the same pair at
//! rest.
//! Tolerance: 2e-5 (d25), 1e-4 (m13, whose group velocity is 1.2 % low at 10 kHz). One reflection alone has 1 +-
//! 2.4e-3.

use super::measurement::{Depth, Measurement, named};
use super::rig::{Rig, decibels, difference, norm};
use super::setting::Setting;
use crate::exact::monopole::burst_on_path;
use fdtd::Error;
use fdtd::scheme::Scheme;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Scheme, frequency in hertz on the papers' grid, tolerances of waveform, level in dB and delay in s.
pub const CASES: [(Scheme, f64, [f64; 3]); 3] = [
    (Scheme::M13, 4e3, [0.012, 0.02, 0.3e-6]),
    (Scheme::Slf, 2e3, [0.06, 0.06, 4e-6]),
    (Scheme::D25, 4e3, [0.04, 0.02, 1.5e-6]),
];

/// Error of the echo's waveform (relative), level in dB and delay in s on the papers' grid, as are frequency and
/// distance.
///
/// # Errors
/// When the field becomes non-finite.
pub fn image(
    setting: &Setting,
    scheme: Scheme,
    frequency_hz: f64,
    apart_m: f64,
) -> Result<[f64; 3], Error> {
    let conditions = &setting.conditions;
    let open = Rig::open(setting, scheme, 400, 400);
    let walled = open.clone().with_walls(|ix, _| (300..304).contains(&ix));
    let burst = conditions.burst(frequency_hz, 500.0);
    let strength = |t_s: f64| burst.value(t_s);
    let wall_m = 300.0 * conditions.dx_m;
    let [away_m, near_m, apart_m] = [0.6, 0.45, apart_m].map(|x| conditions.m(x));
    let [_, along_m] = setting.between([[0.0, 0.0], [0.3, 0.95]]);
    let source = |_: f64| [wall_m - away_m, along_m];
    let image = |_: f64| [wall_m + away_m, along_m];
    let receiver = |_: f64| [wall_m - near_m, along_m + apart_m];
    let steps = conditions.steps(1100);
    let hear = |rig: &Rig| rig.run(&source, &receiver, &strength, steps);
    let echo = difference(&hear(&walled)?, &hear(&open)?);
    let monopole = burst_on_path(conditions.medium, burst, &strength, &image);
    let expected = open.exact(&monopole, &receiver, steps);
    let frequency_hz = burst.frequency_hz;
    let ratio = open.line(&echo, frequency_hz) / open.line(&expected, frequency_hz);
    Ok([
        norm(&difference(&echo, &expected)) / norm(&expected),
        decibels(norm(&echo) / norm(&expected)),
        -ratio.arg() / (TAU * frequency_hz) / conditions.s(1.0),
    ])
}

/// Measurements of the image source.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure_image(_: Depth) -> Result<Vec<Measurement>, Error> {
    let mut found = Vec::new();
    for (scheme, frequency_hz, [waveform, level_db, late_s]) in CASES {
        for apart_m in [0.0, 0.7] {
            let case = format!("{scheme}, {apart_m} m apart, {} kHz", frequency_hz / 1e3);
            let setting = Setting::drawn("echo", &case);
            let error = image(&setting, scheme, frequency_hz, apart_m)?;
            let case = named(&case, &setting);
            found.extend(Measurement::waveform_and_level(
                &case,
                [error[0], error[1]],
                [waveform, level_db],
            ));
            found.push(Measurement::within(
                case,
                "delay, us",
                1e6 * error[2],
                1e6 * late_s,
            ));
        }
    }
    Ok(found)
}

/// Schemes between parallel walls, and their tolerance of the time scale.
pub const PARALLEL: [(Scheme, f64); 2] = [(Scheme::M13, 1e-4), (Scheme::D25, 2e-5)];

/// Time scale of the twofold echo between parallel walls, minus 1.
///
/// # Errors
/// When the field becomes non-finite.
pub fn parallel_walls(setting: &Setting, scheme: Scheme) -> Result<f64, Error> {
    const SPEED_MPS: f64 = 0.4;
    const FREQUENCY_HZ: f64 = 10e3;
    const GAP_CELLS: usize = 200;
    let (first, last) = (40, 40 + GAP_CELLS);
    let conditions = &setting.conditions;
    let open = Rig::open(setting, scheme, last + 40, 320);
    let with = |low: bool, high: bool| {
        open.clone().with_walls(|ix, _| {
            (low && (first - 4..first).contains(&ix)) || (high && (last..last + 4).contains(&ix))
        })
    };
    let gap_m = GAP_CELLS as f64 * conditions.dx_m;
    let [_, along_m] = setting.between([[0.0, 0.0], [0.5, 1.1]]);
    let start_m = [first as f64 * conditions.dx_m + conditions.m(0.4), along_m];
    let burst = conditions.burst(FREQUENCY_HZ, 500.0);
    let strength = |t_s: f64| burst.value(t_s);
    let arrival_s = 2.0 * gap_m / conditions.medium.c_mps + burst.centre_s;
    // Half a window before and after the arrival; threefold echoes come 2.3 ms later, 7 standard deviations of the
    // burst.
    let window = (conditions.s(0.8e-3) / conditions.dt_s) as usize;
    let middle = (arrival_s / conditions.dt_s) as usize;
    let steps = middle + window + 1;
    let echo = |speed_mps: f64| -> Result<Vec<f64>, Error> {
        let pair = |t_s: f64| [start_m[0] + speed_mps * t_s, start_m[1]];
        let hear = |low, high| with(low, high).run(&pair, &pair, &strength, steps);
        let ends = difference(&hear(true, true)?, &hear(true, false)?);
        Ok(difference(
            &ends,
            &difference(&hear(false, true)?, &hear(false, false)?),
        ))
    };
    let omega = TAU * burst.frequency_hz;
    let turn = |signal: &[f64]| {
        let phasor = |from: usize| -> Complex<f64> {
            let piece = signal[from..from + window].iter().enumerate();
            piece
                .map(|(n, &p)| Complex::from_polar(p, -omega * open.time_s(from + n)))
                .sum()
        };
        phasor(middle) * phasor(middle - window).conj()
    };
    let images = |speed_mps: f64| {
        let pair = |t_s: f64| [start_m[0] + speed_mps * t_s, start_m[1]];
        let mut sum = vec![0.0; steps];
        for side in [-1.0, 1.0] {
            let image = move |t_s: f64| {
                let [x, y] = pair(t_s);
                [x + side * 2.0 * gap_m, y]
            };
            let source = burst_on_path(conditions.medium, burst, &strength, &image);
            let parts = open.exact(&source, &pair, steps);
            sum.iter_mut().zip(parts).for_each(|(sum, p)| *sum += p);
        }
        sum
    };
    let speed_mps = conditions.mps(SPEED_MPS);
    let recorded = turn(&echo(speed_mps)?) * turn(&echo(0.0)?).conj();
    let expected = turn(&images(speed_mps)) * turn(&images(0.0)).conj();
    let turned_rad = (recorded * expected.conj()).arg();
    Ok(turned_rad / (omega * window as f64 * conditions.dt_s))
}

/// Measurements of the parallel walls.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure_parallel(_: Depth) -> Result<Vec<Measurement>, Error> {
    PARALLEL
        .into_iter()
        .map(|(scheme, tolerance)| {
            let case = format!("{scheme}, 0.4 m/s");
            let setting = Setting::drawn("parallel walls", &case);
            let off = parallel_walls(&setting, scheme)?;
            let case = named(&case, &setting);
            Ok(Measurement::within(case, "time scale - 1", off, tolerance))
        })
        .collect()
}
