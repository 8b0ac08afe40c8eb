//! The waveform of a scene: the localizer's transmitted M-sequence at the scene's code, rates and band.

use anyhow::{Context, Result};
use fdtd::scene::Scene;
use fdtd::waveform::PeriodicWaveform;
use localizer::Parameters;
use localizer::parameters::SignalParameters;
use localizer::signal::waveform::transmit_period;

/// Parameters of the localizer with the waveform, sample rate, speed of sound and sensor offset of a scene; the others
/// are those of `base`.
pub fn parameters_of(scene: &Scene, base: &Parameters) -> Parameters {
    Parameters {
        signal: SignalParameters {
            sample_rate_hz: scene.sample_rate_hz,
            code_length: scene.waveform.code_length as usize,
            chip_rate_hz: scene.waveform.chip_rate_hz,
            carrier_hz: scene.waveform.carrier_hz,
            speed_of_sound_mps: scene.medium.c_mps,
            sensor_offset_m: [0, 1].map(|axis| {
                0.5 * (scene.robot.loudspeaker_offset_m[axis]
                    + scene.robot.microphone_offset_m[axis])
            }),
            sensor_baseline_m: [0, 1].map(|axis| {
                scene.robot.microphone_offset_m[axis] - scene.robot.loudspeaker_offset_m[axis]
            }),
        },
        ..base.clone()
    }
}

/// Source strength over time, relative to [`fdtd::simulation::SOURCE_STRENGTH_M2PS`]: the transmitted M-sequence signal
/// within the scene's band, at the time step of the field.
///
/// # Errors
/// When the localizer refuses the scene's waveform.
pub fn source_waveform(scene: &Scene) -> Result<PeriodicWaveform> {
    let parameters = parameters_of(scene, &Parameters::default());
    parameters.check().context("waveform of the scene")?;
    let samples = transmit_period(&parameters.signal);
    Ok(PeriodicWaveform::with_band(
        &samples,
        parameters.period_s(),
        scene.waveform.band_hz,
        1.0 / scene.grid.dt_s,
    ))
}
