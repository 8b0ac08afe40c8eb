//! A line source in free field, at rest and moving, with a microphone at rest and moving; and reciprocity.
//!
//! Layout: 2.2 m x 2 m with a layer on all sides; burst with a Gaussian envelope; source and microphone about 0.75 m
//! apart, off the cells' centres and anywhere in the domain. Fast motion (a tenth of the speed of sound) makes every
//! Mach number's power count.
//! Formula: retarded integral, [`crate::exact::monopole`]; `p(a -> b) = p(b -> a)`.
//! Bias: dispersion. In phase it grows with frequency cubed (slf) or faster (m13), so the waveform is compared at 4 kHz
//! and 2 kHz (slf); d25 spreads its error of 0.05 % over the whole band, which is 2 % of the waveform at 4 kHz.
//! Tolerance: 0.4 % of the waveform and 0.02 dB (m13), 2 % and 0.06 dB (slf), 2.5 % and 0.02 dB (d25). A wrong power of
//! the Doppler factor would be 5 % and 0.4 dB. Reciprocity: 1e-4 of the strongest line at 3 to 13 kHz.

use super::measurement::{Depth, Measurement, named, schemes};
use super::rig::{Path, Rig, decibels, difference, norm};
use super::setting::Setting;
use crate::exact::monopole::burst_on_path;
use fdtd::Error;
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;

/// Scheme, frequency in hertz on the papers' grid, tolerance of the waveform, of the level in dB.
pub const CASES: [(Scheme, f64, f64, f64); 3] = [
    (Scheme::M13, 4e3, 0.004, 0.02),
    (Scheme::Slf, 2e3, 0.02, 0.06),
    (Scheme::D25, 4e3, 0.025, 0.02),
];

/// Paths of a source and a microphone.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// The moving parts.
    pub name: &'static str,
    /// Source in metres at a time in seconds, on the papers' grid.
    pub source: fn(f64) -> [f64; 2],
    /// Microphone.
    pub receiver: fn(f64) -> [f64; 2],
}

/// The motions that are measured.
pub const MOTIONS: [Motion; 4] = [
    Motion {
        name: "at rest",
        source: |_| [0.9012, 0.8021],
        receiver: |_| [1.51, 1.213],
    },
    Motion {
        name: "source at 33 m/s",
        source: |t_s| [0.9012 + 30.0 * t_s, 0.8021 + 13.0 * t_s],
        receiver: |_| [1.51, 1.213],
    },
    Motion {
        name: "microphone at 29 m/s",
        source: |_| [0.9012, 0.8021],
        receiver: |t_s| [1.51 - 17.0 * t_s, 1.213 + 23.0 * t_s],
    },
    Motion {
        name: "source circling at 24 m/s, microphone at 15 m/s",
        source: |t_s| {
            let (sin, cos) = (300.0 * t_s).sin_cos();
            [0.85 + 0.08 * cos, 0.8 + 0.08 * sin]
        },
        receiver: |t_s| [1.51 - 9.0 * t_s, 1.213 - 12.0 * t_s],
    },
];

/// Error of the waveform (root mean square, relative) and of the level in dB of a burst whose spectrum has the standard
/// deviation `spread_hz`; frequencies, paths and number of steps are those of the papers' grid.
///
/// # Errors
/// When the field becomes non-finite.
pub fn error(
    setting: &Setting,
    scheme: Scheme,
    frequency_hz: f64,
    spread_hz: f64,
    source: Path<'_>,
    receiver: Path<'_>,
    steps: usize,
) -> Result<[f64; 2], Error> {
    let conditions = &setting.conditions;
    let burst = conditions.burst(frequency_hz, spread_hz);
    let strength = |t_s: f64| burst.value(t_s);
    let away_m = setting.between([[-0.45, 0.3], [-0.45, 0.35]]);
    let shifted = |path: Path<'_>, t_s: f64| {
        let point_m = conditions.point(path(t_s / conditions.s(1.0)));
        [0, 1].map(|axis| point_m[axis] + away_m[axis])
    };
    let (source, receiver) = (|t_s| shifted(source, t_s), |t_s| shifted(receiver, t_s));
    let steps = conditions.steps(steps);
    let rig = Rig::open(setting, scheme, 440, 400);
    let recorded = rig.run(&source, &receiver, &strength, steps)?;
    let monopole = burst_on_path(conditions.medium, burst, &strength, &source);
    let expected = rig.exact(&monopole, &receiver, steps);
    Ok([
        norm(&difference(&recorded, &expected)) / norm(&expected),
        decibels(norm(&recorded) / norm(&expected)),
    ])
}

/// The law's measurements.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let motions = match depth {
        Depth::Quick => &MOTIONS[..3],
        Depth::Full => &MOTIONS[..],
    };
    let mut found = Vec::new();
    for motion in motions {
        for (scheme, frequency_hz, tolerance, tolerance_db) in CASES {
            let case = format!("{scheme}, {}, {} kHz", motion.name, frequency_hz / 1e3);
            let setting = Setting::drawn("free field", &case);
            let [waveform, level_db] = error(
                &setting,
                scheme,
                frequency_hz,
                500.0,
                &motion.source,
                &motion.receiver,
                900,
            )?;
            let case = named(&case, &setting);
            found.extend(Measurement::waveform_and_level(
                &case,
                [waveform, level_db],
                [tolerance, tolerance_db],
            ));
        }
    }
    Ok(found)
}

/// Largest difference of the lines at 3 to 13 kHz when source and microphone change places between slanted and bent
/// walls, over the strongest line.
///
/// # Errors
/// When the field becomes non-finite.
pub fn exchange(setting: &Setting, scheme: Scheme, spread: Spread) -> Result<f64, Error> {
    let conditions = &setting.conditions;
    let mut rig = Rig::open(setting, scheme, 240, 240).with_walls(|ix, iy| {
        let slanted = (ix as f64 - 0.3 * iy as f64 - 80.0).abs() < 3.0 && (40..180).contains(&iy);
        let hook = ((190..194).contains(&iy) && (60..200).contains(&ix))
            || ((150..154).contains(&ix) && (150..194).contains(&iy));
        slanted || hook
    });
    rig.spread = spread;
    let burst = conditions.burst(8e3, 2500.0);
    let strength = |t_s: f64| burst.value(t_s);
    let steps = conditions.steps(2000);
    let [first_m, second_m] = [
        setting.between([[0.3, 0.42], [0.35, 0.65]]),
        setting.between([[0.85, 1.0], [0.8, 0.6]]),
    ];
    let (here, there) = (|_: f64| first_m, |_: f64| second_m);
    let forth = rig.run(&here, &there, &strength, steps)?;
    let back = rig.run(&there, &here, &strength, steps)?;
    let strongest_of = |signal: &[f64]| {
        [3e3, 5e3, 7e3, 9e3, 11e3, 13e3]
            .map(|f| rig.line(signal, conditions.hz(f)).norm())
            .into_iter()
            .fold(0.0, f64::max)
    };
    Ok(strongest_of(&difference(&forth, &back)) / strongest_of(&forth))
}

/// Measurements of reciprocity.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure_reciprocity(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let spreads = match depth {
        Depth::Quick => &[Spread::Kaiser8][..],
        Depth::Full => &Spread::ALL[..],
    };
    let mut found = Vec::new();
    for scheme in schemes() {
        for &spread in spreads {
            let case = format!("{scheme}, {spread}");
            let setting = Setting::drawn("reciprocity", &case);
            let error = exchange(&setting, scheme, spread)?;
            let case = named(&case, &setting);
            found.push(Measurement::below(
                case,
                "difference, relative",
                error,
                1e-4,
            ));
        }
    }
    Ok(found)
}
