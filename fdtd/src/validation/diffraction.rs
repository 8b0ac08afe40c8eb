//! Diffraction at the edge of a rigid half plane.
//!
//! Layout: 1.6 m x 1.5 m; a wall of one cell through the layer on the right ends in the middle; a burst of 2 kHz from one side, heard
//! on the other in deep shadow, behind the edge, and on the source's side beyond the edge.
//! Formula: Sommerfeld's half plane in time, [`crate::exact::half_plane`], along the wall's middle line up to its end.
//! Bias: the wall is 5 mm thick, a thirtieth of the wavelength.
//! Tolerance: 6 % of the waveform, 0.4 dB. Without diffraction the shadow would be silent.

use super::rig::{AIR, DX_M, Rig, decibels, difference, norm, time_s};
use super::{Depth, Measurement, schemes};
use crate::Error;
use crate::exact::burst::Burst;
use crate::exact::half_plane::HalfPlane;
use crate::scheme::Scheme;

/// Cell of the wall's end.
const EDGE: [usize; 2] = [150, 150];
/// Source from the edge in metres.
const SOURCE_M: [f64; 2] = [0.2, 0.35];

/// Microphones: name and place from the edge in metres.
pub const PLACES: [(&str, [f64; 2]); 3] = [
    ("deep shadow", [0.22, -0.2]),
    ("behind the edge", [-0.05, -0.35]),
    ("in the light", [-0.3, 0.1]),
];

/// Error of the waveform (relative) and of the level in dB at a place from the edge.
///
/// # Errors
/// When the field becomes non-finite.
pub fn half_plane(scheme: Scheme, place_m: [f64; 2]) -> Result<[f64; 2], Error> {
    let burst = Burst::from_zero(2e3, 500.0);
    let strength = |t_s: f64| burst.value(t_s);
    let edge_m = [EDGE[0] as f64 * DX_M, (EDGE[1] as f64 + 0.5) * DX_M];
    let from_edge = |[x, y]: [f64; 2]| [edge_m[0] + x, edge_m[1] + y];
    let rig = Rig::open(scheme, 320, 300).with_walls(|ix, iy| iy == EDGE[1] && ix >= EDGE[0]);
    let steps = 1000;
    let heard = rig.run(
        &|_| from_edge(SOURCE_M),
        &|_| from_edge(place_m),
        &strength,
        steps,
    )?;
    let exact = HalfPlane {
        medium: AIR,
        burst,
        source_m: SOURCE_M,
    };
    let expected: Vec<f64> = (0..steps)
        .map(|n| exact.pressure(place_m, time_s(n)))
        .collect();
    Ok([
        norm(&difference(&heard, &expected)) / norm(&expected),
        decibels(norm(&heard) / norm(&expected)),
    ])
}

/// The law's measurements.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure(_: Depth) -> Result<Vec<Measurement>, Error> {
    let mut found = Vec::new();
    for scheme in schemes() {
        for (name, place_m) in PLACES {
            let [waveform, level_db] = half_plane(scheme, place_m)?;
            let case = format!("{scheme}, {name}");
            found.push(Measurement::below(
                case.clone(),
                "waveform, relative",
                waveform,
                0.06,
            ));
            found.push(Measurement::within(case, "level, dB", level_db, 0.4));
        }
    }
    Ok(found)
}
