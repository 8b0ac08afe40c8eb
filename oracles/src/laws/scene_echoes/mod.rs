//! Echoes of the paper-size scene beside its image sources, where no edge diffracts.
//!
//! Layout: `scenes/four_walls.json` with its own cells, scheme and spreading, at each place in another medium and at
//! another Courant number; the robot at rest at places of its area, those of a raster where most echoes can be
//! compared; one burst of 8 kHz with a standard deviation of 2 kHz; walls as cut cells, whatever the scene says. The
//! same without walls is subtracted: the rest are echoes. Once with all walls, once with only the pair that runs along
//! the grid.
//! Formula: every visible ray of first and second order ([`crate::rays`]) is a line source at its image,
//! `(omega rho Q / 4) H0^(2)(k r)` in frequency, which each leg delays by the scheme's own dispersion relation along
//! its direction (o13 is faster than c by up to 0.4 %, tens of microseconds on eight metres: shown as the delay of the
//! envelope on c, and taken out of the comparison). Only echoes into which neither an edge diffracts nor another echo
//! falls are compared: 0.3 m of path apart from all other rays up to fourth order and from all ways by one end of a
//! wall with up to three reflections before and behind it, both also when they miss a wall or the way past one by up to
//! 0.4 m (`alone.rs`). Level and delay are fitted over 5 to 11 kHz, where the burst is above a third of its peak, the
//! delay by the phase.
//! Bias: dispersion bends the wave fronts, so that their curvature and with it the level changes by direction, 0.1 dB
//! at 10 kHz; the window's flanks; sound that two ends of walls scatter one after the other.
//! Tolerance: 0.15 dB and 0.5 us; half a cell of error in a wall's place would be 15 us. Walls made of whole cells
//! fail: slanted ones of slope 1 to 2 give single echoes 4 to 7 us late.

mod alone;
mod image;

use std::collections::HashMap;
use std::path::Path;

use self::alone::alone;
pub use self::image::{Echo, burst};
use self::image::{echo, images};
use super::conditions::Conditions;
use super::measurement::{Depth, Measurement};
use super::rig::{difference, echoes, norm};
use super::setting::Setting;
use crate::rays::{RayPath, Reflectors};
use fdtd::Error;
use fdtd::motion::{DrivePath, MotionState};
use fdtd::scene::Scene;
use fdtd::walls::{Wall, WallModel};

/// Walls, grid and emitter of `scenes/four_walls.json`; a test holds them equal.
const SCENE: &str = r#"{
    "name": "four walls",
    "medium": { "c_mps": 340.0, "rho_kgpm3": 1.293 },
    "grid": { "nx": 1000, "ny": 1000, "dx_m": 0.005, "dt_s": 8.333333333333334e-06 },
    "layer_cells": 20,
    "scheme": "o13",
    "spread": "kaiser12",
    "wall_model": "staircase",
    "walls": [
        { "points_m": [[0.49, 0.5], [2.63, 0.5]], "thickness_m": 0.02 },
        { "points_m": [[0.5, 0.49], [0.5, 2.74]], "thickness_m": 0.02 },
        { "points_m": [[1.172, 3.787], [3.312, 4.5]], "thickness_m": 0.02 },
        { "points_m": [[3.611, 1.773], [4.233, 3.638]], "thickness_m": 0.02 }
    ],
    "waveform": { "code_length": 1023, "chip_rate_hz": 10000.0, "carrier_hz": 10000.0, "band_hz": [0.0, 14000.0] },
    "sample_rate_hz": 40000.0
}"#;
/// Duration on the papers' grid.
const DURATION_S: f64 = 0.031;

/// A place of the robot: the signal there, and the echoes that can be compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Where, in metres.
    pub place_m: [f64; 2],
    /// Medium and grid.
    pub conditions: Conditions,
    /// Whether all walls of the scene stand; otherwise only those along the grid.
    pub whole: bool,
    /// Echoes in the field at the field's rate in Pa, entry `n` at time `n dt`.
    pub recorded: Vec<f64>,
    /// Echoes by image sources up to second order at the same times, at the speed of sound.
    pub images: Vec<f64>,
    /// The echoes that stand alone.
    pub echoes: Vec<Echo>,
}

/// Measures the echoes at a place of the scene.
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
    let drawn = Setting::drawn("scene echoes", &format!("{whole} {place_m:?}")).conditions;
    let (medium, dx_m) = (drawn.medium, scene.grid.dx_m);
    let conditions = Conditions {
        medium,
        dx_m,
        dt_s: drawn.courant() * dx_m / medium.c_mps,
    };
    scene.medium = medium;
    scene.grid.dt_s = conditions.dt_s;
    let duration_s = conditions.s(DURATION_S);
    let path = DrivePath::uniform(rest, duration_s)?;
    scene.paths.insert("rest".to_string(), path);
    let band_hz = [0.0, conditions.hz(18e3)];
    let waveform = burst(&conditions).every(2.0 * duration_s, band_hz, 1.0 / conditions.dt_s);
    let recorded = echoes(&scene, "rest", &waveform, |simulation| {
        simulation.received()
    })?;
    let reflectors = Reflectors::of(&scene.walls);
    let echoes = alone(&reflectors, place_m)
        .iter()
        .map(|ray| echo(&scene, &conditions, &reflectors, ray, &recorded))
        .collect();
    Ok(Place {
        place_m,
        conditions,
        whole,
        images: images(&scene, &conditions, &reflectors, place_m, recorded.len()),
        recorded,
        echoes,
    })
}

/// Measures the echoes at places of the robot's area: with only those walls that run along the grid, and in the whole
/// scene.
///
/// # Errors
/// When the field becomes non-finite.
pub fn places(depth: Depth) -> Result<Vec<Place>, Error> {
    let mut whole = Scene::from_json(SCENE, Path::new("four walls"))?;
    whole.wall_model = WallModel::CutCells;
    let mut along = whole.clone();
    along.walls.retain(|wall| {
        let mut segments = wall.segments_m();
        segments.all(|[from, to]| from[0] == to[0] || from[1] == to[1])
    });
    let counts = match depth {
        Depth::Quick => [1, 1],
        Depth::Full => [2, 4],
    };
    let mut compared = HashMap::new();
    let mut found = Vec::new();
    for ((scene, is_whole), count) in [(along, false), (whole, true)].into_iter().zip(counts) {
        for place_m in choose(candidates(&scene.walls), count, &mut compared) {
            found.push(place(&scene, is_whole, place_m)?);
        }
        // In the whole scene first the echoes that the pair along the grid lacks, then all.
        compared.values_mut().for_each(|times| *times = 1);
    }
    Ok(found)
}

/// A place, and the walls of each echo that stands alone there.
type Candidate = ([f64; 2], Vec<Vec<usize>>);

/// Places every 5 cm where the scene's drives are.
fn candidates(walls: &[Wall]) -> Vec<Candidate> {
    let reflectors = Reflectors::of(walls);
    let walls = |ray: &RayPath| {
        let mut walls: Vec<usize> = ray.walls.iter().map(|&(wall, _)| wall).collect();
        walls.sort_unstable();
        walls
    };
    let raster = (22..=70).flat_map(|iy| (22..=64).map(move |ix| [ix, iy]));
    raster
        .map(|at| at.map(|index| f64::from(index) / 20.0))
        .map(|place_m| {
            let echoes = alone(&reflectors, place_m);
            (place_m, echoes.iter().map(walls).collect())
        })
        .collect()
}

/// Places at least half a metre apart, each the one with the most echoes that were compared least: an echo of walls
/// that `compared` holds n times counts for `4^-n`.
fn choose(
    mut candidates: Vec<Candidate>,
    count: usize,
    compared: &mut HashMap<Vec<usize>, i32>,
) -> Vec<[f64; 2]> {
    let mut chosen = Vec::new();
    while chosen.len() < count {
        let worth = |(_, echoes): &Candidate| -> f64 {
            let times = |walls| compared.get(walls).copied().unwrap_or(0);
            echoes.iter().map(|walls| 0.25_f64.powi(times(walls))).sum()
        };
        // The first of equals.
        let best = (candidates.iter().rev()).max_by(|a, b| worth(a).total_cmp(&worth(b)));
        let Some((place_m, echoes)) = best.cloned() else {
            break;
        };
        for walls in echoes {
            *compared.entry(walls).or_insert(0) += 1;
        }
        candidates.retain(|(other, _)| norm(&difference(other, &place_m)) > 0.5);
        chosen.push(place_m);
    }
    chosen
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
                "{}, at {:.2} {:.2}, {} echo, wall {}{}, {:.2} m, {} m/s",
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
                place.conditions.medium.c_mps,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scene_is_that_of_the_scene_file() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/four_walls.json");
        let mut shipped = Scene::load(&file).unwrap();
        shipped.description.clear();
        shipped.paths.clear();
        let own = Scene::from_json(SCENE, Path::new("four walls")).unwrap();
        assert_eq!(format!("{own:?}"), format!("{shipped:?}"));
    }
}
