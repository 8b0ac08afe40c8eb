//! Echoes of the paper-size scene beside its image sources, where no edge diffracts.
//!
//! Layout: `scenes/four_walls.json` with its own scheme and spreading; the robot at rest at places of its mapping drive; one burst of 8 kHz with
//! a standard deviation of 2 kHz; walls as cut cells, whatever the scene says. The same without walls is subtracted: what is left are echoes. Once with
//! all walls, once with only the pair that runs along the grid.
//! Formula: every visible ray of first and second order ([`crate::rays`]) is a line source at its image, `(omega rho Q / 4) H0^(2)(k r)` in frequency,
//! which each leg delays by the scheme's own dispersion relation along its direction (o13 is faster than c by up to 0.4 %, tens of
//! microseconds on eight metres: shown as the delay of the envelope on c, and taken out of the comparison).
//! Only echoes that arrive 0.3 m of path apart from all others are compared: rays up to fourth order, with a slack of 0.4 m at the ends of faces,
//! and the sound scattered by the walls' ends straight back or by way of one wall; where that is not apart, an edge diffracts. Level and delay are fitted over 5 to 11 kHz, where the burst is above a third of
//! its peak, the delay by the phase.
//! Bias: dispersion bends the wave fronts, so that their curvature and with it the level changes by direction, 0.1 dB at 10 kHz; the window's
//! flanks; what ends of walls scatter twice.
//! Tolerance: 0.15 dB and 0.5 us; half a cell of error in a wall's place would be 15 us. Walls made of whole cells fail: slanted ones of slope 1 to 2
//! give single echoes 4 to 7 us late.

use super::rig::{DT_S, decibels, difference, echoes, norm};
use super::{Depth, Measurement};
use crate::Error;
use crate::exact::burst::Burst;
use crate::exact::hankel::hankel0;
use crate::motion::{DrivePath, MotionState};
use crate::rays::{RayKind, RayPath, Reflectors, TraceOptions, trace};
use crate::scene::Scene;
use crate::scheme::Polynomial;
use crate::simulation::SOURCE_STRENGTH_M2PS;
use crate::walls::WallModel;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;
use std::path::Path;

/// The scene.
const SCENE: &str = include_str!("../../../scenes/four_walls.json");
const DURATION_S: f64 = 0.031;
/// Least difference of path between a compared echo and all others, in metres.
const APART_M: f64 = 0.3;
/// Longest path compared, in metres.
const LONGEST_M: f64 = 9.0;
/// Frequencies of the fit: first, last and step, in hertz.
const FIT_HZ: [f64; 3] = [5e3, 11e3, 125.0];

/// One echo, field and image.
#[derive(Debug, Clone, PartialEq)]
pub struct Echo {
    /// What the ray met.
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

/// A place of the robot: what is heard there, and the echoes that can be compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Where, in metres.
    pub place_m: [f64; 2],
    /// Whether all walls of the scene stand; otherwise only those along the grid.
    pub whole: bool,
    /// Echoes in the field at the field's rate in Pa, entry `n` at time `n dt`.
    pub heard: Vec<f64>,
    /// Echoes by image sources up to second order at the same times, at the speed of sound.
    pub images: Vec<f64>,
    /// The echoes that stand alone.
    pub echoes: Vec<Echo>,
}

/// What the loudspeaker sends, of peak 1.
pub fn burst() -> Burst {
    Burst::from_zero(8e3, 2e3)
}

fn rays(
    reflectors: &Reflectors,
    place_m: [f64; 2],
    max_order: usize,
    slack_m: f64,
) -> Vec<RayPath> {
    let options = TraceOptions { max_order, slack_m };
    let mut rays = trace(reflectors, place_m, place_m, &options);
    rays.retain(|ray| ray.order() > 0);
    rays
}

/// Rays of first and second order that no other arrival comes near.
fn alone(reflectors: &Reflectors, place_m: [f64; 2]) -> Vec<RayPath> {
    let mut others: Vec<f64> = rays(reflectors, place_m, 4, 0.4)
        .iter()
        .map(|ray| ray.length_m)
        .collect();
    let single = rays(reflectors, place_m, 1, 0.4);
    for segment in reflectors.segments() {
        for [x, y] in segment.ends_m {
            let away_m = |[u, v]: [f64; 2]| (x - u).hypot(y - v);
            others.push(2.0 * away_m(place_m));
            others.extend(
                single
                    .iter()
                    .map(|ray| away_m(place_m) + away_m(ray.image_m)),
            );
        }
    }
    let mut found: Vec<RayPath> = Vec::new();
    for ray in rays(reflectors, place_m, 2, 0.0) {
        // A pair in one point hears both orders of a double echo at once; they are one echo, see `orders`.
        let known = |other: &RayPath| (other.length_m - ray.length_m).abs() < 1e-6;
        if !found.iter().any(known) {
            found.push(ray);
        }
    }
    found.retain(|ray| {
        // An end of the corner's walls is its apex, where the corner's own echo comes from.
        let same = |length_m: f64| (length_m - ray.length_m).abs() < 1e-6;
        let apex = |length_m: f64| ray.is_corner() && (length_m - ray.length_m).abs() < 0.06;
        let near = |length_m: f64| (length_m - ray.length_m).abs() < APART_M;
        (0.5..LONGEST_M).contains(&ray.length_m)
            && others
                .iter()
                .all(|&other| same(other) || apex(other) || !near(other))
    });
    found
}

/// How many orders of its walls a ray stands for: a double echo between two walls is heard both ways round, a corner's only once.
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
    ray: &RayPath,
    frequency_hz: f64,
    grid: Option<&Polynomial>,
) -> Complex<f64> {
    let omega = TAU * frequency_hz;
    let (c_mps, rho_kgpm3) = (scene.medium.c_mps, scene.medium.rho_kgpm3);
    let strength = burst().spectrum(omega) * SOURCE_STRENGTH_M2PS;
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
fn fit_hz() -> impl Iterator<Item = f64> {
    let [first, last, step] = FIT_HZ;
    (0..=((last - first) / step) as usize).map(move |k| first + step * k as f64)
}

/// A frequency in hertz, and what was found and expected there.
type Pair = (f64, Complex<f64>, Complex<f64>);

/// Weighted phase of `found` over `expected` as level ratio and delay in s: the delay of the phase, or with `envelope` that of its slope.
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

/// One echo of the field held against its image.
fn echo(scene: &Scene, reflectors: &Reflectors, ray: &RayPath, heard: &[f64]) -> Echo {
    let arrival_s = ray.length_m / scene.medium.c_mps + burst().centre_s;
    // Half of the distance to the next arrival on either side, with soft flanks; dispersion delays by less than 0.2 ms.
    let reach_s = APART_M / scene.medium.c_mps;
    let grid = scene.scheme.polynomial(scene.grid.courant(&scene.medium));
    let image = |on_grid: bool, f: f64| {
        image_spectrum(scene, ray, f, on_grid.then_some(&grid)) * orders(ray)
    };
    let by_grid: Vec<Pair> = fit_hz()
        .map(|f| (f, image(true, f), image(false, f)))
        .collect();
    let [_, grid_late_s] = compare(&by_grid, true);
    let window = |t_s: f64| {
        let depth = ((t_s - arrival_s - grid_late_s).abs() / reach_s - 0.6) / 0.4;
        0.5 + 0.5 * (0.5 * TAU * depth.clamp(0.0, 1.0)).cos()
    };
    let spectrum = |frequency_hz: f64| -> Complex<f64> {
        let terms = heard.iter().enumerate().map(|(n, &p)| {
            let t_s = n as f64 * DT_S;
            let weight = window(t_s);
            if weight == 0.0 {
                Complex::ZERO
            } else {
                Complex::from_polar(weight * p * DT_S, -TAU * frequency_hz * t_s)
            }
        });
        terms.sum()
    };
    let found: Vec<Complex<f64>> = fit_hz().map(spectrum).collect();
    let pairs = |on_grid: bool| -> Vec<Pair> {
        fit_hz()
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
fn images(scene: &Scene, reflectors: &Reflectors, place_m: [f64; 2], count: usize) -> Vec<f64> {
    let mut sum = vec![0.0; count];
    for ray in rays(reflectors, place_m, 2, 0.0) {
        // A Fourier integral over the burst's band, 0.5 to 15.5 kHz.
        let lines: Vec<(f64, Complex<f64>)> = (0..=300)
            .map(|k| 500.0 + 50.0 * f64::from(k))
            .map(|f| (f, image_spectrum(scene, &ray, f, None) * 100.0))
            .collect();
        let arrival_s = ray.length_m / scene.medium.c_mps + burst().centre_s;
        for (n, value) in sum.iter_mut().enumerate() {
            let t_s = n as f64 * DT_S;
            if (t_s - arrival_s).abs() < 2e-3 {
                *value += lines
                    .iter()
                    .map(|&(f, line)| (line * Complex::from_polar(1.0, TAU * f * t_s)).re)
                    .sum::<f64>();
            }
        }
    }
    sum
}

/// Hears the echoes at a place of the scene.
///
/// # Errors
/// When the field becomes non-finite.
fn place(scene: &Scene, whole: bool, place_m: [f64; 2]) -> Result<Place, Error> {
    let rest = MotionState {
        x_m: place_m[0],
        y_m: place_m[1],
        heading_rad: 0.0,
        v_mps: 0.0,
        omega_radps: 0.0,
    };
    let mut scene = scene.clone();
    let path = DrivePath::uniform(rest, DURATION_S)?;
    scene.paths.insert("rest".to_string(), path);
    let waveform = burst().every(2.0 * DURATION_S, [0.0, 18e3], 1.0 / DT_S);
    let heard = echoes(&scene, "rest", &waveform, |simulation| {
        simulation.received()
    })?;
    let reflectors = Reflectors::of(&scene.walls);
    let echoes = alone(&reflectors, place_m)
        .iter()
        .map(|ray| echo(&scene, &reflectors, ray, &heard))
        .collect();
    Ok(Place {
        place_m,
        whole,
        images: images(&scene, &reflectors, place_m, heard.len()),
        heard,
        echoes,
    })
}

/// Hears the echoes at the places, every second of the mapping drive, where most echoes stand alone: in the whole scene, and with only
/// those walls that run along the grid.
///
/// # Errors
/// When the field becomes non-finite.
pub fn places(depth: Depth) -> Result<Vec<Place>, Error> {
    let mut whole = Scene::from_json(SCENE, Path::new("scenes/four_walls.json"))?;
    whole.wall_model = WallModel::CutCells;
    let mut along = whole.clone();
    along.walls.retain(|wall| {
        let mut segments = wall.segments_m();
        segments.all(|[from, to]| from[0] == to[0] || from[1] == to[1])
    });
    let count = match depth {
        Depth::Quick => 1,
        Depth::Full => 3,
    };
    let mut found = Vec::new();
    for (scene, is_whole) in [(along, false), (whole, true)] {
        for place_m in best_places(&scene, count)? {
            found.push(place(&scene, is_whole, place_m)?);
        }
    }
    Ok(found)
}

/// The places with most echoes, at least half a metre apart.
fn best_places(scene: &Scene, count: usize) -> Result<Vec<[f64; 2]>, Error> {
    let reflectors = Reflectors::of(&scene.walls);
    let path = scene.path("mapping")?;
    let mut candidates: Vec<(usize, [f64; 2])> = (0..path.duration_s() as usize)
        .map(|second| path.point_at(second as f64, [0.0, 0.0]))
        .map(|place_m| (alone(&reflectors, place_m).len(), place_m))
        .collect();
    candidates.sort_by_key(|&(count, _)| std::cmp::Reverse(count));
    let mut chosen: Vec<[f64; 2]> = Vec::new();
    for (_, place_m) in candidates {
        let far = |other: &[f64; 2]| norm(&difference(other, &place_m)) > 0.5;
        if chosen.len() < count && chosen.iter().all(far) {
            chosen.push(place_m);
        }
    }
    Ok(chosen)
}

/// The law's measurements.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let mut found = Vec::new();
    for place in places(depth)? {
        for echo in &place.echoes {
            let walls: Vec<String> = echo.walls.iter().map(usize::to_string).collect();
            let case = format!(
                "{}, at {:.2} {:.2}, {} echo, wall {}{}, {:.2} m",
                if place.whole {
                    "all walls"
                } else {
                    "walls 0 1 alone"
                },
                place.place_m[0],
                place.place_m[1],
                echo.kind.name(),
                walls.join(" "),
                if echo.along_grid { "" } else { " (slanted)" },
                echo.length_m,
            );
            let (level, delay) = ("level, dB", "delay, us");
            let late_us = 1e6 * echo.late_s;
            found.extend([
                Measurement::within(case.clone(), level, echo.louder_db, 0.15),
                Measurement::within(case.clone(), delay, late_us, 0.5),
            ]);
            let quantity = "delay of the envelope on c, us";
            found.push(Measurement::shown(case, quantity, 1e6 * echo.late_on_c_s));
        }
    }
    Ok(found)
}
