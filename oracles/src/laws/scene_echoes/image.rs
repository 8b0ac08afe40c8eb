//! An echo of the field compared with its image source.

use std::f64::consts::TAU;

use rustfft::num_complex::Complex;

use super::super::conditions::Conditions;
use super::super::rig::decibels;
use super::alone::{APART_M, rays};
use crate::exact::burst::Burst;
use crate::exact::hankel::hankel0;
use crate::rays::{RayKind, RayPath, Reflectors};
use fdtd::scene::Scene;
use fdtd::scheme::Polynomial;
use fdtd::simulation::SOURCE_STRENGTH_M2PS;

/// Frequencies of the fit: first, last and step, in hertz on the papers' grid.
const FIT_HZ: [f64; 3] = [5e3, 11e3, 125.0];

/// One echo, field and image.
#[derive(Debug, Clone, PartialEq)]
pub struct Echo {
    /// Kind of the ray.
    pub kind: RayKind,
    /// Numbers of the walls that it met.
    pub walls: Vec<usize>,
    /// Whether all of them run along the grid.
    pub along_grid: bool,
    /// Length of the ray in metres.
    pub length_m: f64,
    /// Arrival of the burst's peak by the image at the speed of sound, in seconds.
    pub arrival_s: f64,
    /// Level of the image's echo relative to 1 Pa of peak spectrum, dB; for figures.
    pub level_db: f64,
    /// Field's level over the image's, dB.
    pub louder_db: f64,
    /// Field's delay minus the image's with the grid's dispersion, in seconds.
    pub late_s: f64,
    /// Field's delay of the envelope minus the image's at the speed of sound, in seconds.
    pub late_on_c_s: f64,
}

/// The loudspeaker's signal, of peak 1.
pub fn burst(conditions: &Conditions) -> Burst {
    conditions.burst(8e3, 2e3)
}

/// How many orders of its walls a ray stands for: a double echo between two walls arrives both ways round, a corner's
/// only once.
fn orders(ray: &RayPath) -> f64 {
    if ray.kind == RayKind::Double {
        2.0
    } else {
        1.0
    }
}

/// Spectrum of an image's echo at a frequency, with the dispersion of `grid` if there is one.
fn image_spectrum(
    scene: &Scene,
    conditions: &Conditions,
    ray: &RayPath,
    frequency_hz: f64,
    grid: Option<&Polynomial>,
) -> Complex<f64> {
    let omega = TAU * frequency_hz;
    let (c_mps, rho_kgpm3) = (scene.medium.c_mps, scene.medium.rho_kgpm3);
    let strength = burst(conditions).spectrum(omega) * SOURCE_STRENGTH_M2PS;
    let wave = hankel0(omega * ray.length_m / c_mps) * (0.25 * omega * rho_kgpm3);
    let late_rad: f64 = ray
        .points_m
        .windows(2)
        .map(|leg| {
            let [x, y] = [leg[1][0] - leg[0][0], leg[1][1] - leg[0][1]];
            let velocity =
                grid.and_then(|grid| grid.phase_velocity(omega * scene.grid.dt_s, y.atan2(x)));
            omega / c_mps * x.hypot(y) * (velocity.map_or(1.0, |velocity| 1.0 / velocity) - 1.0)
        })
        .sum();
    strength * wave * Complex::from_polar(1.0, -late_rad)
}

/// Frequencies of the fit in hertz.
fn fit_hz(conditions: &Conditions) -> impl Iterator<Item = f64> {
    let [first, last, step] = FIT_HZ.map(|hz| conditions.hz(hz));
    (0..=((last - first) / step).round() as usize).map(move |k| first + step * k as f64)
}

/// A frequency in hertz, and the spectra of field and image there.
type Pair = (f64, Complex<f64>, Complex<f64>);

/// Weighted phase of `found` over `expected` as level ratio and delay in s: the delay of the phase, or with `envelope`
/// that of its slope.
fn compare(pairs: &[Pair], envelope: bool) -> [f64; 2] {
    let found: f64 = pairs.iter().map(|pair| pair.1.norm_sqr()).sum();
    let expected: f64 = pairs.iter().map(|pair| pair.2.norm_sqr()).sum();
    let level = (found / expected).sqrt();
    let mut turned = Vec::with_capacity(pairs.len());
    let mut before = Complex::new(1.0, 0.0);
    let mut phase = 0.0;
    for &(frequency_hz, found, expected) in pairs {
        let ratio = found * expected.conj();
        phase += (ratio * before.conj()).arg();
        before = ratio;
        turned.push((TAU * frequency_hz, phase, expected.norm_sqr()));
    }
    let sum = |term: &dyn Fn(f64, f64) -> f64| {
        turned
            .iter()
            .map(|&(w, p, weight)| weight * term(w, p))
            .sum::<f64>()
    };
    let [middle, mean] = if envelope {
        let all = sum(&|_, _| 1.0);
        [sum(&|w, _| w) / all, sum(&|_, p| p) / all]
    } else {
        [0.0, 0.0]
    };
    let late_s = -sum(&|w, p| (w - middle) * (p - mean)) / sum(&|w, _| (w - middle).powi(2));
    [level, late_s]
}

/// One echo of the field compared with its image.
pub(super) fn echo(
    scene: &Scene,
    conditions: &Conditions,
    reflectors: &Reflectors,
    ray: &RayPath,
    recorded: &[f64],
) -> Echo {
    let dt_s = conditions.dt_s;
    let arrival_s = ray.length_m / scene.medium.c_mps + burst(conditions).centre_s;
    // Half of the distance to the next arrival on either side, with soft flanks; dispersion delays by less than 0.2 ms.
    let reach_s = APART_M / scene.medium.c_mps;
    let grid = scene.scheme.polynomial(scene.grid.courant(&scene.medium));
    let image = |on_grid: bool, f: f64| {
        image_spectrum(scene, conditions, ray, f, on_grid.then_some(&grid)) * orders(ray)
    };
    let by_grid: Vec<Pair> = fit_hz(conditions)
        .map(|f| (f, image(true, f), image(false, f)))
        .collect();
    let [_, grid_late_s] = compare(&by_grid, true);
    let window = |t_s: f64| {
        let depth = ((t_s - arrival_s - grid_late_s).abs() / reach_s - 0.6) / 0.4;
        0.5 + 0.5 * (0.5 * TAU * depth.clamp(0.0, 1.0)).cos()
    };
    let spectrum = |frequency_hz: f64| -> Complex<f64> {
        let terms = recorded.iter().enumerate().map(|(n, &p)| {
            let t_s = n as f64 * dt_s;
            let weight = window(t_s);
            if weight == 0.0 {
                Complex::ZERO
            } else {
                Complex::from_polar(weight * p * dt_s, -TAU * frequency_hz * t_s)
            }
        });
        terms.sum()
    };
    let found: Vec<Complex<f64>> = fit_hz(conditions).map(spectrum).collect();
    let pairs = |on_grid: bool| -> Vec<Pair> {
        fit_hz(conditions)
            .zip(&found)
            .map(|(f, &found)| (f, found, image(on_grid, f)))
            .collect()
    };
    let on_grid = pairs(true);
    let [level, late_s] = compare(&on_grid, false);
    let [_, late_on_c_s] = compare(&pairs(false), true);
    let peak = on_grid
        .iter()
        .fold(0.0_f64, |most, pair| most.max(pair.2.norm()));
    let along = |&(wall, piece): &(usize, usize)| {
        reflectors.segments().iter().any(|segment| {
            let [[ax, ay], [bx, by]] = segment.ends_m;
            (segment.wall, segment.piece) == (wall, piece) && (ax == bx || ay == by)
        })
    };
    Echo {
        kind: ray.kind,
        walls: ray.walls.iter().map(|&(wall, _)| wall).collect(),
        along_grid: ray.walls.iter().all(along),
        length_m: ray.length_m,
        arrival_s,
        level_db: decibels(peak),
        louder_db: decibels(level),
        late_s,
        late_on_c_s,
    }
}

/// The sound of all images up to second order in time, at the speed of sound.
pub(super) fn images(
    scene: &Scene,
    conditions: &Conditions,
    reflectors: &Reflectors,
    place_m: [f64; 2],
    count: usize,
) -> Vec<f64> {
    let mut sum = vec![0.0; count];
    for ray in rays(reflectors, place_m) {
        // A Fourier integral over the burst's band, 0.5 to 15.5 kHz.
        let step = 2.0 * conditions.hz(50.0);
        let lines: Vec<(f64, Complex<f64>)> = (0..=300)
            .map(|k| conditions.hz(500.0 + 50.0 * f64::from(k)))
            .map(|f| (f, image_spectrum(scene, conditions, &ray, f, None) * step))
            .collect();
        let arrival_s = ray.length_m / scene.medium.c_mps + burst(conditions).centre_s;
        for (n, value) in sum.iter_mut().enumerate() {
            let t_s = n as f64 * conditions.dt_s;
            if (t_s - arrival_s).abs() < conditions.s(2e-3) {
                *value += lines
                    .iter()
                    .map(|&(f, line)| (line * Complex::from_polar(1.0, TAU * f * t_s)).re)
                    .sum::<f64>();
            }
        }
    }
    sum
}
