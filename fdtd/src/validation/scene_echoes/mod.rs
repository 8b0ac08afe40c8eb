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

mod alone;
mod image;

use std::path::Path;

use self::alone::alone;
use self::image::{echo, images};
use super::rig::{DT_S, difference, echoes, norm};
use super::{Depth, Measurement};
use crate::Error;
use crate::exact::burst::Burst;
use crate::motion::{DrivePath, MotionState};
use crate::rays::{RayKind, Reflectors};
use crate::scene::Scene;
use crate::walls::WallModel;

/// The scene.
const SCENE: &str = include_str!("../../../../scenes/four_walls.json");
const DURATION_S: f64 = 0.031;

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
