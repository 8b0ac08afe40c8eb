//! Arrival times at the given walls of a scene: model (b) of Tsuchiya et al. (2021).

use anyhow::{Context, Result};
use fdtd::scene::Scene;
use localizer::multipath::arrivals;
use localizer::multipath::ekf::{Noise, follow};
use localizer::multipath::peaks::Picking;
use localizer::multipath::planes::Plane;
use localizer::multipath::prediction::{Model, Predictor};
use localizer::parameters::MeasurementParameters;
use localizer::{Parameters, Recording, Trajectory};
use oracles::rays::Reflectors;

/// Longest round trip at which peaks are picked, metres; the papers' scene has its longest single and corner echoes
/// there.
const FARTHEST_M: f64 = 8.0;
/// Peaks: four times the noise, one chip apart.
pub const PICKING: Picking = Picking {
    threshold: 4.0,
    separation: 4,
    most: 16,
};
/// Gate of the association where it is not varied: largest difference of round trips, metres.
pub const GATE_M: f64 = 0.25;

/// Noise that the filter expects, the same for all models, at a speed of sound in m/s and a gate in metres.
pub fn noise(c_mps: f64, gate_m: f64) -> Noise {
    Noise {
        v_mps: 0.05,
        omega_radps: 0.1,
        time_s: 0.03 / c_mps,
        gate_s: gate_m / c_mps,
    }
}

/// The drive of a recording by the arrival times of single and double reflections at the walls of its scene, the start
/// first.
///
/// # Errors
/// When the recording cannot be measured or a wall has no length.
pub fn follow_scene(
    scene: &Scene,
    recording: &Recording,
    parameters: &Parameters,
) -> Result<Trajectory> {
    let c_mps = parameters.signal.speed_of_sound_mps;
    let parameters = Parameters {
        measurement: MeasurementParameters {
            periods: 2,
            // The noise level is estimated from all delays of a period.
            max_range_m: 0.48 * c_mps * parameters.period_s(),
            ..parameters.measurement
        },
        ..parameters.clone()
    };
    let nearest_m = 2.0 * parameters.measurement.min_range_m;
    let blocks = arrivals::measure(recording, &parameters, &PICKING, [nearest_m, FARTHEST_M])?;
    // In the plane all heights are equal.
    let predictor = Predictor::new(&planes(scene)?, Model::Planar, [0.0; 2], c_mps);
    let start = recording.start_pose();
    Ok(follow(&blocks, &predictor, noise(c_mps, GATE_M), start))
}

/// The faces of the scene's walls as finite planes that reflect to their front.
fn planes(scene: &Scene) -> Result<Vec<Plane>> {
    Reflectors::of(&scene.walls)
        .faces()
        .iter()
        .map(|face| {
            let end = [0, 1].map(|i| face.start_m[i] + face.length_m * face.along[i]);
            let left = face.along[0] * face.normal[1] - face.along[1] * face.normal[0];
            let ends = if left > 0.0 {
                [face.start_m, end]
            } else {
                [end, face.start_m]
            };
            Plane::wall(ends).context("scene: walls: one has no length")
        })
        .collect()
}
