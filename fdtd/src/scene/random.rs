//! Layouts and drives drawn at random: the ensemble on which methods are compared.

use std::f64::consts::{PI, TAU};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use crate::motion::{DriveLimits, DrivePath, MotionState, VelocityCommand};

/// Arrangement of the walls of a random layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LayoutKind {
    /// Three to five single walls around the robot's area, in no particular order.
    Open,
    /// A rectangular room in any orientation, some of whose sides have a gap.
    Room,
}

impl LayoutKind {
    /// The name as a user writes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Room => "room",
        }
    }
}

/// Side of the square domain in metres, as in the papers.
const SIDE_M: f64 = 5.0;
/// Distance in metres that walls keep from the domain's edges: absorbing layer and stencil.
const EDGE_M: f64 = 0.3;
/// Distance in metres that the robot keeps from middle lines of walls.
const CLEARANCE_M: f64 = 0.31;
/// Distance in metres from the middle, around which walls stand, that the robot stays within.
const DRIVE_RADIUS_M: f64 = 1.5;
/// Least distance in metres between single walls, and angle between the directions in which they stand.
const APART_M: f64 = 0.25;
const APART_RAD: f64 = 0.6;
/// Shortest piece of a wall in metres.
const LEAST_WALL_M: f64 = 0.3;
/// Ways that an exploring robot chooses from.
const WAYS: usize = 12;
/// Length of every drive in seconds.
const DURATION_S: f64 = 40.0;
/// Time in seconds between two looks at whether a drive keeps clear.
const LOOK_S: f64 = 0.05;

type Point = [f64; 2];

/// A scene of the papers' grid and waveform with walls, air and two drives of 40 s (`mapping` and `localization`)
/// drawn at random, as the JSON of a scene file.
///
/// Nothing about the sound of the layout is looked at: walls stand apart, inside the domain, and drives keep 0.3 m
/// away from them, on their inner side. The mapping drive explores the air. Equal kinds and seeds give equal
/// scenes.
///
/// ```
/// use fdtd::scene::{LayoutKind, Scene, random};
///
/// let file = random::layout(LayoutKind::Open, 7);
/// let scene = Scene::from_json(&file.to_string(), "random".as_ref())?;
/// assert_eq!(scene.paths["mapping"].duration_s(), 40.0);
/// # Ok::<(), fdtd::Error>(())
/// ```
pub fn layout(kind: LayoutKind, seed: u64) -> Value {
    let mut random = stream(seed, kind.name(), "layout");
    loop {
        let layout = match kind {
            LayoutKind::Open => open(&mut random),
            LayoutKind::Room => room(&mut random),
        };
        let drives = ["mapping", "localization"].map(|name| {
            let mut random = stream(seed, kind.name(), name);
            drive(&layout, name == "mapping", &mut random).map(|drive| (name, drive))
        });
        // A layout without room for a drive is drawn anew, whatever else it is.
        let [Some(mapping), Some(localization)] = drives else {
            continue;
        };
        let temperature_degc = f64::from(random.random_range(10..=60)) / 2.0;
        return scene_file(
            kind,
            seed,
            temperature_degc,
            &layout.walls,
            [mapping, localization],
        );
    }
}

/// A stream of its own for every kind, seed and purpose.
fn stream(seed: u64, kind: &str, purpose: &str) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let name = kind.bytes().chain([0xff]).chain(purpose.bytes());
    random.set_stream(name.fold(0, |hash: u64, byte| {
        hash.wrapping_mul(257) + u64::from(byte)
    }));
    random
}

/// Walls and the area in which the robot may drive: on the inner side of all of `sides`.
struct Layout {
    walls: Vec<[Point; 2]>,
    sides: Vec<Side>,
}

/// A line, by its outward normal and its distance from the middle of the domain along it.
#[derive(Clone, Copy)]
struct Side {
    normal: Point,
    distance_m: f64,
}

impl Side {
    fn new(normal_rad: f64, distance_m: f64) -> Self {
        Self {
            normal: [normal_rad.cos(), normal_rad.sin()],
            distance_m,
        }
    }

    /// How far inside a point lies, in metres.
    fn depth_m(&self, point: Point) -> f64 {
        let out: f64 = (0..2)
            .map(|axis| self.normal[axis] * (point[axis] - 0.5 * SIDE_M))
            .sum();
        self.distance_m - out
    }
}

/// Whether a point lies inside the domain, `margin_m` from its edges.
fn inside(point: Point, margin_m: f64) -> bool {
    point
        .iter()
        .all(|&x| (margin_m..=SIDE_M - margin_m).contains(&x))
}

/// Walls in directions at least [`APART_RAD`] from each other, slanted, of any length and shifted along themselves.
fn open(random: &mut ChaCha8Rng) -> Layout {
    let count = random.random_range(3..=5);
    let mut bearings: Vec<f64> = Vec::new();
    let mut layout = Layout {
        walls: Vec::new(),
        sides: Vec::new(),
    };
    while layout.walls.len() < count {
        let bearing_rad = TAU * random.random::<f64>();
        let normal_rad = bearing_rad + random.random_range(-0.3..0.3);
        let distance_m = random.random_range(1.2..2.0);
        let half_m = 0.5 * random.random_range(0.9..2.4);
        let shift_m = random.random_range(-0.4..0.4);
        let end = |way_m: f64| {
            [
                0.5 * SIDE_M + distance_m * normal_rad.cos() - way_m * normal_rad.sin(),
                0.5 * SIDE_M + distance_m * normal_rad.sin() + way_m * normal_rad.cos(),
            ]
        };
        let wall = [end(shift_m - half_m), end(shift_m + half_m)].map(rounded);
        let apart = bearings
            .iter()
            .all(|other: &f64| (other - bearing_rad).cos() < APART_RAD.cos())
            && layout
                .walls
                .iter()
                .all(|&other| distance_of_walls_m(other, wall) >= APART_M);
        if apart && wall.iter().all(|&point| inside(point, EDGE_M)) {
            bearings.push(bearing_rad);
            layout.walls.push(wall);
            layout.sides.push(Side::new(normal_rad, distance_m));
        } else if random.random_bool(0.02) {
            // No place may be left for another wall.
            bearings.clear();
            layout.walls.clear();
            layout.sides.clear();
        }
    }
    layout
}

/// A rectangle, three quarters of whose sides have a gap.
fn room(random: &mut ChaCha8Rng) -> Layout {
    loop {
        let turn_rad = 0.5 * PI * random.random::<f64>();
        let sides: [Side; 4] = std::array::from_fn(|side| {
            Side::new(
                turn_rad + 0.5 * PI * side as f64,
                random.random_range(1.1..2.0),
            )
        });
        // A corner lies on two neighbouring sides.
        let corner = |side: usize| {
            let (one, other) = (sides[side % 4], sides[(side + 1) % 4]);
            [0, 1].map(|axis| {
                0.5 * SIDE_M
                    + one.distance_m * one.normal[axis]
                    + other.distance_m * other.normal[axis]
            })
        };
        if !(0..4).all(|side| inside(corner(side), EDGE_M)) {
            continue;
        }
        let mut walls = Vec::new();
        for side in 0..4 {
            let (from, to) = (corner(side), corner(side + 1));
            let length_m = (to[0] - from[0]).hypot(to[1] - from[1]);
            let at = |way_m: f64| {
                rounded([0, 1].map(|axis| from[axis] + way_m / length_m * (to[axis] - from[axis])))
            };
            if random.random_bool(0.25) {
                walls.push([at(0.0), at(length_m)]);
                continue;
            }
            let gap_m = random.random_range(0.4..1.2);
            let start_m = random.random_range(0.0..length_m - gap_m);
            for [from_m, to_m] in [[0.0, start_m], [start_m + gap_m, length_m]] {
                if to_m - from_m >= LEAST_WALL_M {
                    walls.push([at(from_m), at(to_m)]);
                }
            }
        }
        return Layout {
            walls,
            sides: sides.to_vec(),
        };
    }
}

/// A drive from rest that keeps clear of all walls, as start and legs of a scene file.
///
/// A robot that `explores` takes, of several ways it could go on, the one that leads farthest from where it was; any
/// other the first.
fn drive(layout: &Layout, explores: bool, random: &mut ChaCha8Rng) -> Option<Value> {
    let clear = |point: Point| {
        (point[0] - 0.5 * SIDE_M).hypot(point[1] - 0.5 * SIDE_M) <= DRIVE_RADIUS_M
            && layout
                .sides
                .iter()
                .all(|side| side.depth_m(point) >= CLEARANCE_M)
            && layout
                .walls
                .iter()
                .all(|&wall| distance_m(wall, point) >= CLEARANCE_M)
    };
    for _ in 0..200 {
        let start = MotionState {
            x_m: rounding(SIDE_M * random.random::<f64>()),
            y_m: rounding(SIDE_M * random.random::<f64>()),
            heading_rad: rounding(random.random_range(-PI..PI)),
            v_mps: 0.0,
            omega_radps: 0.0,
        };
        if !clear([start.x_m, start.y_m]) {
            continue;
        }
        let mut driven: Vec<Driven> = Vec::new();
        for _ in 0..1000 {
            let left_s =
                rounding(DURATION_S - driven.iter().map(|part| part.leg.duration_s).sum::<f64>());
            if left_s <= 1e-9 {
                let legs: Vec<VelocityCommand> = driven.iter().map(|part| part.leg).collect();
                return Some(drive_file(&start, &legs));
            }
            let now = driven.last().map_or(start, |part| part.end);
            let mut best: Option<(f64, Driven)> = None;
            for _ in 0..WAYS {
                let part = Driven::new(now, leg(left_s, random))?;
                if !part.places.iter().all(|&point| clear(point)) {
                    continue;
                }
                let gain_m = part.distance_m(&driven);
                if best.as_ref().is_none_or(|(most_m, _)| gain_m > *most_m) {
                    best = Some((gain_m, part));
                }
                if !explores {
                    break;
                }
            }
            if let Some((_, part)) = best {
                driven.push(part);
            } else if random.random_bool(0.3) {
                // Out of a dead end by forgetting the last leg.
                driven.pop();
            }
        }
    }
    None
}

/// A leg that was driven.
struct Driven {
    leg: VelocityCommand,
    end: MotionState,
    places: Vec<Point>,
}

impl Driven {
    /// A leg from a state on; none when it is no drive.
    fn new(from: MotionState, leg: VelocityCommand) -> Option<Self> {
        let path = DrivePath::from_commands(from, &[leg], DriveLimits::default()).ok()?;
        let looks = (leg.duration_s / LOOK_S).ceil() as usize;
        let at = |look| path.point_at(leg.duration_s * look as f64 / looks as f64, [0.0; 2]);
        Some(Self {
            leg,
            end: path.state_at(leg.duration_s),
            places: (0..=looks).map(at).collect(),
        })
    }

    /// Mean distance in metres of its places from all legs before but the last; a metre at most for each.
    fn distance_m(&self, driven: &[Self]) -> f64 {
        let before = &driven[..driven.len().saturating_sub(1)];
        let nearest = |point: &Point| {
            let places = before.iter().flat_map(|part| &part.places);
            places
                .map(|other| (other[0] - point[0]).hypot(other[1] - point[1]))
                .fold(1.0, f64::min)
        };
        self.places.iter().map(nearest).sum::<f64>() / self.places.len() as f64
    }
}

/// A leg at random, no longer than `left_s`.
fn leg(left_s: f64, random: &mut ChaCha8Rng) -> VelocityCommand {
    let duration_s = f64::from(random.random_range(10..=45)) / 10.0;
    let turns = random.random_bool(0.7);
    VelocityCommand {
        duration_s: rounding(duration_s.min(left_s)),
        v_mps: rounding(random.random_range(0.2..0.4)),
        omega_radps: if turns {
            rounding(random.random_range(-0.9..0.9))
        } else {
            0.0
        },
    }
}

fn drive_file(start: &MotionState, legs: &[VelocityCommand]) -> Value {
    let legs: Vec<Value> = legs
        .iter()
        .map(|leg| json!({"duration_s": leg.duration_s, "v_mps": leg.v_mps, "omega_radps": leg.omega_radps}))
        .collect();
    json!({
        "start": {"x_m": start.x_m, "y_m": start.y_m, "heading_rad": start.heading_rad},
        "legs": legs,
    })
}

fn scene_file(
    kind: LayoutKind,
    seed: u64,
    temperature_degc: f64,
    walls: &[[Point; 2]],
    drives: [(&str, Value); 2],
) -> Value {
    let walls: Vec<Value> = walls
        .iter()
        .map(|wall| json!({"points_m": wall, "thickness_m": 0.02}))
        .collect();
    let paths: serde_json::Map<String, Value> = drives
        .into_iter()
        .map(|(name, drive)| (name.to_string(), drive))
        .collect();
    json!({
        "name": format!("{} {seed}", kind.name()),
        "description": format!("A layout drawn at random: kind {}, seed {seed}.", kind.name()),
        "medium": {"temperature_degc": temperature_degc, "relative_humidity_percent": 50.0},
        "grid": {"nx": 1000, "ny": 1000, "dx_m": 0.005, "dt_s": 1.0 / 120_000.0},
        "layer_cells": 20,
        "scheme": "o13",
        "spread": "kaiser12",
        "wall_model": "staircase",
        "walls": walls,
        "waveform": {"code_length": 1023, "chip_rate_hz": 1e4, "carrier_hz": 1e4, "band_hz": [0.0, 14e3]},
        "sample_rate_hz": 4e4,
        "paths": paths,
    })
}

/// To the tenth of a millimetre (or milliradian): numbers that one can read in a file.
fn rounding(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

fn rounded(point: Point) -> Point {
    point.map(rounding)
}

/// Distance in metres of a point from a wall's middle line.
fn distance_m([a, b]: [Point; 2], point: Point) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let to = [point[0] - a[0], point[1] - a[1]];
    let share = (to[0] * along[0] + to[1] * along[1]) / (along[0].powi(2) + along[1].powi(2));
    let share = share.clamp(0.0, 1.0);
    (to[0] - share * along[0]).hypot(to[1] - share * along[1])
}

/// Distance in metres of two walls' middle lines; zero where they cross.
fn distance_of_walls_m(one: [Point; 2], other: [Point; 2]) -> f64 {
    let side = |[a, b]: [Point; 2], p: Point| {
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    };
    let parts = |wall: [Point; 2], [a, b]: [Point; 2]| side(wall, a) * side(wall, b) < 0.0;
    if parts(one, other) && parts(other, one) {
        return 0.0;
    }
    let ends = |wall: [Point; 2], [a, b]: [Point; 2]| distance_m(wall, a).min(distance_m(wall, b));
    ends(one, other).min(ends(other, one))
}
