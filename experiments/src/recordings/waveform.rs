//! The waveform of a scene and the localizer's parameters that go with it.

use anyhow::Result;
use fdtd::scene::Scene;
use fdtd::waveform::PeriodicWaveform;
use localizer::Parameters;
use localizer::parameters::SignalParameters;

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

/// The scene's waveform, [`Scene::source_waveform`].
///
/// # Errors
/// When the localizer refuses the scene's signal: nobody could use the recording.
pub fn source_waveform(scene: &Scene) -> Result<PeriodicWaveform> {
    let parameters = parameters_of(scene, &Parameters::default());
    parameters
        .signal
        .check(&format!("scene '{}'", scene.name), false)?;
    Ok(scene.source_waveform()?)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use localizer::signal::waveform::transmit_period;

    use super::*;

    #[test]
    fn the_loudspeaker_emits_what_the_localizer_expects() {
        let text = r#"{ "name": "open air", "grid": { "nx": 300, "ny": 200, "dx_m": 0.005, "dt_s": 8e-6 } }"#;
        let mut scene = Scene::from_json(text, Path::new("open.json")).unwrap();
        let bits = |samples: &[f64]| {
            samples
                .iter()
                .map(|sample| sample.to_bits())
                .collect::<Vec<_>>()
        };
        for order in 2..=18 {
            for (chip_rate_hz, carrier_hz, sample_rate_hz) in [
                (10e3, 10e3, 40e3),
                (10e3, 10e3, 50e3),
                (8e3, 12e3, 48e3),
                (12e3, 10e3, 40e3),
                (5e3, 2.5e3, 20e3),
                (4.41e3, 7.35e3, 44.1e3),
                (20e3, 40e3, 160e3),
            ] {
                scene.sample_rate_hz = sample_rate_hz;
                scene.waveform.code_length = (1 << order) - 1;
                scene.waveform.chip_rate_hz = chip_rate_hz;
                scene.waveform.carrier_hz = carrier_hz;
                let signal = parameters_of(&scene, &Parameters::default()).signal;
                let ours = scene.waveform.one_period(sample_rate_hz);
                let case =
                    format!("order {order}, {chip_rate_hz} {carrier_hz} {sample_rate_hz} Hz");
                assert_eq!(ours.len(), signal.samples_per_period(), "{case}");
                assert_eq!(bits(&ours), bits(&transmit_period(&signal)), "{case}");
                if order < 12 {
                    let band_hz = scene.waveform.band_hz;
                    let rate_hz = 1.0 / scene.grid.dt_s;
                    let expected =
                        PeriodicWaveform::with_band(&ours, signal.period_s(), band_hz, rate_hz);
                    let waveform = scene.source_waveform().unwrap();
                    assert_eq!(
                        waveform.period_s().to_bits(),
                        expected.period_s().to_bits(),
                        "{case}"
                    );
                    assert_eq!(
                        bits(waveform.one_period()),
                        bits(expected.one_period()),
                        "{case}"
                    );
                }
            }
        }
    }
}
