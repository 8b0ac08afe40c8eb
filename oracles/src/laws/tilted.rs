//! Echoes of walls that lie across the grid: place, level, and scatter between echoes.
//!
//! Layout, echo: a rigid wall of 1.6 m, tilted against the grid by 3, 10, 12 and 30 degrees and moved through the cells
//! in three steps; source and microphone 0.42 m and 0.38 m in front of its middle on one line across it. A run without
//! the wall is subtracted; the diffraction at the ends of the wall arrives 2.9 ms after the echo, when the burst of
//! 10 kHz is over.
//! Formula: the image source lies 0.8 m from the microphone in the direction across the wall, whatever its tilt.
//! Bias: dispersion over these 0.8 m, which is not the wall's. The reference is therefore the field itself: an open
//! grid with the microphone 0.8 m from the source in that direction.
//! Tolerance: 0.3 dB and 2 us at each place of the wall; 0.5 dB at 12 degrees, where the remaining error repeats every
//! 80 mm along the wall (tan 12 degrees is nearly 3/14), leaves as an order of that grating and beats with the echo.
//! The staircase is shown beside.
//!
//! Layout, scatter: a wall of 2.4 m tilted by 12 degrees, source and microphone in one point 0.45 m in front of it.
//! Formula: a plane returns one echo, from the foot of the perpendicular; between it and the diffraction at the ends
//! (4.8 ms later) there is silence. Stairs repeat every 24 mm along such a wall and return 10 kHz from where it is met
//! at 45 degrees, 1.1 ms after the echo.
//! Bias: none; the line source's tail is far below the band.
//! Tolerance: the signal from 0.75 ms to 3.75 ms after the echo is at least 20 dB weaker than with stairs.

use super::conditions::Conditions;
use super::measurement::{Depth, Measurement, larger, named};
use super::rig::{Rig, decibels, difference, norm};
use super::setting::Setting;
use fdtd::Error;
use fdtd::scheme::Scheme;
use fdtd::walls::{Wall, WallModel};
use std::f64::consts::TAU;

/// Frequency of the bursts in hertz, on the papers' grid.
const FREQUENCY_HZ: f64 = 10e3;

/// Tilts in degrees, and the largest errors of the echo of cut cells: level in dB and delay in s.
pub const TILTS: [(f64, [f64; 2]); 4] = [
    (3.0, [0.3, 2e-6]),
    (10.0, [0.3, 2e-6]),
    (12.0, [0.5, 2e-6]),
    (30.0, [0.3, 2e-6]),
];

/// Schemes that the tolerances apply to; slf is shown.
pub const SCHEMES: [Scheme; 3] = [Scheme::M13, Scheme::O13, Scheme::D25];

/// A wall with its face across a line.
pub(super) struct Tilted {
    /// Unit vector from the front of the wall into it.
    pub(super) normal: [f64; 2],
    /// Middle of the face in metres.
    foot_m: [f64; 2],
    pub(super) wall: Wall,
}

impl Tilted {
    /// A wall of `length_m` whose face is tilted against the x axis and has its middle at `foot_m`.
    pub(super) fn new(
        conditions: &Conditions,
        tilt_deg: f64,
        foot_m: [f64; 2],
        length_m: f64,
    ) -> Self {
        let (sin, cos) = tilt_deg.to_radians().sin_cos();
        let thickness_m = 4.0 * conditions.dx_m;
        let end = |side: f64| {
            let along = side * 0.5 * length_m;
            [
                foot_m[0] + along * cos - 0.5 * thickness_m * sin,
                foot_m[1] + along * sin + 0.5 * thickness_m * cos,
            ]
        };
        Self {
            normal: [-sin, cos],
            foot_m,
            wall: Wall {
                points_m: vec![end(-1.0), end(1.0)],
                thickness_m,
                impedance: None,
            },
        }
    }

    /// The point at a distance in metres behind the middle of the face.
    pub(super) fn behind(&self, distance_m: f64) -> [f64; 2] {
        [0, 1].map(|axis| self.foot_m[axis] + distance_m * self.normal[axis])
    }
}

/// Error of an echo: level in dB and delay in s on the papers' grid. The wall is moved into its normal by `shift`
/// cells.
///
/// # Errors
/// When the field becomes non-finite.
pub fn echo(
    setting: &Setting,
    scheme: Scheme,
    model: WallModel,
    tilt_deg: f64,
    shift: f64,
) -> Result<[f64; 2], Error> {
    let conditions = &setting.conditions;
    let open = Rig::open(setting, scheme, 400, 340);
    let wall = |foot_m| Tilted::new(conditions, tilt_deg, foot_m, conditions.m(1.6));
    let tilted = wall(wall(conditions.point([1.0; 2])).behind(shift * conditions.dx_m));
    let walls = std::slice::from_ref(&tilted.wall);
    let walled = open.clone().with_model(model, walls);
    let burst = conditions.burst(FREQUENCY_HZ, 1000.0);
    let way_s = conditions.m(0.8) / conditions.medium.c_mps;
    let steps = ((way_s + 2.0 * burst.centre_s) / conditions.dt_s) as usize;
    let behind = |distance_m: f64| tilted.behind(conditions.m(distance_m));
    let hear = |rig: &Rig, microphone_m: [f64; 2]| {
        let source_m = behind(-0.42);
        let strength = |t_s: f64| burst.value(t_s);
        rig.run(&|_| source_m, &|_| microphone_m, &strength, steps)
    };
    let front = behind(-0.38);
    let echo = difference(&hear(&walled, front)?, &hear(&open, front)?);
    let expected = hear(&open, behind(0.38))?;
    let frequency_hz = burst.frequency_hz;
    let ratio = open.line(&echo, frequency_hz) / open.line(&expected, frequency_hz);
    Ok([decibels(ratio.norm()), -ratio.arg() / (TAU * FREQUENCY_HZ)])
}

/// Setting of the echo of a wall, the same for all models of the wall.
pub fn setting(scheme: Scheme, tilt_deg: f64) -> Setting {
    Setting::drawn("tilted wall", &format!("{scheme}, {tilt_deg} degrees"))
}

/// Setting of the scatter.
pub fn scatter_setting(scheme: Scheme) -> Setting {
    Setting::drawn("scatter of a tilted wall", scheme.name())
}

/// The largest errors of level in dB and delay in s over three places of the wall in the cells, with their signs.
///
/// # Errors
/// When the field becomes non-finite.
pub fn largest(
    setting: &Setting,
    scheme: Scheme,
    model: WallModel,
    tilt_deg: f64,
) -> Result<[f64; 2], Error> {
    let mut most = [0.0_f64; 2];
    for shift in [0.0, 0.37, 0.71] {
        let error = echo(setting, scheme, model, tilt_deg, shift)?;
        most = [0, 1].map(|i| larger(most[i], error[i]));
    }
    Ok(most)
}

/// Scatter of a wall at 12 degrees after its echo, over the echo, in dB.
///
/// # Errors
/// When the field becomes non-finite.
pub fn scatter(setting: &Setting, scheme: Scheme, model: WallModel) -> Result<f64, Error> {
    let conditions = &setting.conditions;
    let open = Rig::open(setting, scheme, 540, 300);
    let foot_m = conditions.point([1.3, 0.9]);
    let tilted = Tilted::new(conditions, 12.0, foot_m, conditions.m(2.4));
    let walls = std::slice::from_ref(&tilted.wall);
    let walled = open.clone().with_model(model, walls);
    let burst = conditions.burst(FREQUENCY_HZ, 1000.0);
    let pair_m = tilted.behind(conditions.m(-0.45));
    let arrival_s = conditions.m(0.9) / conditions.medium.c_mps + burst.centre_s;
    let index = |t_s: f64| (t_s / conditions.dt_s) as usize;
    let steps = index(arrival_s + conditions.s(3.75e-3));
    let hear = |rig: &Rig| rig.run(&|_| pair_m, &|_| pair_m, &|t_s| burst.value(t_s), steps);
    let echo = difference(&hear(&walled)?, &hear(&open)?);
    let (before, after) = echo.split_at(index(arrival_s + conditions.s(0.75e-3)));
    Ok(decibels(norm(after) / norm(before)))
}

/// Measurements of the echo and of the scatter.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let schemes = match depth {
        Depth::Quick => &SCHEMES[1..2],
        Depth::Full => &Scheme::ALL[..],
    };
    let mut found = Vec::new();
    for &scheme in schemes {
        for (tilt_deg, allowed) in TILTS {
            for model in WallModel::ALL {
                let held = model == WallModel::CutCells && SCHEMES.contains(&scheme);
                let setting = setting(scheme, tilt_deg);
                let error = largest(&setting, scheme, model, tilt_deg)?;
                let mut push = |quantity, error, allowed| {
                    let case = format!("{scheme}, {model}, {tilt_deg} degrees");
                    let case = named(&case, &setting);
                    found.push(Measurement::held(held, case, quantity, error, allowed));
                };
                push("level, dB", error[0], allowed[0]);
                push("delay, us", 1e6 * error[1], 1e6 * allowed[1]);
            }
        }
        let setting = scatter_setting(scheme);
        let [cut, stairs] = WallModel::ALL.map(|model| scatter(&setting, scheme, model));
        let (cut, stairs) = (cut?, stairs?);
        let quantity = "scattered back beside the echo, dB";
        let case = |model| named(&format!("{scheme}, {model}, 12 degrees"), &setting);
        found.push(Measurement::shown(case("staircase"), quantity, stairs));
        found.push(Measurement::below(
            case("cut_cells"),
            quantity,
            cut,
            stairs - 20.0,
        ));
    }
    Ok(found)
}
