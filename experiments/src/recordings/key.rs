//! The cache key of a recording: a hash of all that determines its samples.

use anyhow::Result;
use fdtd::scene::Scene;
use fdtd::walls::Impedance;

use super::spec::{Engine, IMAGE_ORDER, RecordingSpec};
use crate::data::cache::Key;

/// Spacing in seconds at which a drive path enters a key.
const PATH_STEP_S: f64 = 0.01;

/// Key of the recording `spec` of `scene`. `fingerprint` stands for the engine's code (see
/// [`super::fingerprint::engine_fingerprint`]). Names and descriptions do not enter, nor the spelling of a path, only
/// its course.
///
/// # Errors
/// When the scene has no such path.
pub fn recording_key(scene: &Scene, spec: &RecordingSpec, fingerprint: &str) -> Result<String> {
    let path = scene.path(&spec.path)?;
    let mut key = Key::new("recording");
    key.text("engine print", fingerprint);
    key.value("engine", &spec.engine)?;
    key.value("free field", &spec.free_field)?;
    if spec.whole_domain {
        key.value("whole domain", &spec.whole_domain)?;
    }
    if spec.engine == Engine::ImageSource && spec.image_order != usize::from(IMAGE_ORDER) {
        key.value("image order", &spec.image_order)?;
    }
    if spec.stamped {
        key.value("stamped", &spec.stamped)?;
    }
    key.numbers("odometry bias", &[spec.odometry_bias_radps]);
    key.numbers(
        "medium and grid",
        &[
            scene.medium.c_mps,
            scene.medium.rho_kgpm3,
            scene.grid.nx as f64,
            scene.grid.ny as f64,
            scene.grid.dx_m,
            scene.grid.dt_s,
            scene.layer_cells as f64,
            scene.sample_rate_hz,
        ],
    );
    key.numbers("loudspeaker", &scene.robot.loudspeaker_offset_m);
    key.numbers("microphone", &scene.robot.microphone_offset_m);
    let waveform = &scene.waveform;
    key.numbers(
        "code",
        &[
            f64::from(waveform.code_length),
            waveform.chip_rate_hz,
            waveform.carrier_hz,
        ],
    );
    key.numbers("band", &waveform.band_hz);
    if spec.engine == Engine::Fdtd {
        key.value("scheme", &spec.scheme.unwrap_or(scene.scheme))?;
        key.value("spread", &spec.spread.unwrap_or(scene.spread))?;
    }
    if !spec.free_field {
        if spec.engine == Engine::Fdtd {
            key.value("wall model", &spec.wall_model.unwrap_or(scene.wall_model))?;
        }
        for wall in &scene.walls {
            let corners: Vec<f64> = wall.points_m.iter().flatten().copied().collect();
            key.numbers("wall", &corners);
            key.numbers("thickness", &[wall.thickness_m]);
            let rigid = || vec![f64::INFINITY];
            let impedance = wall.impedance.as_ref();
            key.numbers(
                "impedance",
                &impedance.map_or_else(rigid, Impedance::numbers),
            );
        }
    }
    let steps = (path.duration_s() / PATH_STEP_S).floor() as usize;
    let course: Vec<f64> = (0..=steps)
        .flat_map(|step| {
            let state = path.state_at(step as f64 * PATH_STEP_S);
            [state.x_m, state.y_m, state.heading_rad]
        })
        .collect();
    key.numbers("duration", &[path.duration_s()]);
    key.numbers("course", &course);
    Ok(key.finish())
}
