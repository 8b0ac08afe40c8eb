//! Whether a scene's drive can become a recording: the one check of `scene check` and `simulate`, before any sound is
//! computed.

use anyhow::{Result, anyhow, bail};
use fdtd::scene::Scene;
use localizer::memory::limit_bytes;

use super::recording::recording;
use super::robot::Robot;
use super::spec::{Engine, RecordingSpec};

/// Refuses a scene whose waveform, air or robot no recording can have, and whose drives no robot can drive.
///
/// # Errors
/// One line that names `origin` and the field of the scene.
pub fn check_scene(scene: &Scene, origin: &str) -> Result<()> {
    scene.check(origin)?;
    for path in scene.paths.keys() {
        check(scene, origin, &RecordingSpec::of(path, Engine::Fdtd), None)?;
    }
    Ok(())
}

/// Refuses a drive that cannot become a recording, with the instruments of `robot` if there is one.
///
/// # Errors
/// As [`check_scene`].
pub fn check(
    scene: &Scene,
    origin: &str,
    spec: &RecordingSpec,
    robot: Option<&Robot>,
) -> Result<()> {
    let path = scene.path(&spec.path)?;
    let samples = path.duration_s() * scene.sample_rate_hz;
    // The signal as it is received and as it is written.
    let needed = 16.0 * samples;
    if needed > limit_bytes() as f64 {
        bail!(
            "{origin}: paths.{}: {samples:.0} samples would take {:.1} GB of memory; drive for a shorter time or \
            sample more slowly",
            spec.path,
            needed * 1e-9
        );
    }
    let mut recording = recording(scene, spec, vec![0.0; samples as usize], 0.0)?;
    recording
        .meta
        .check(origin)
        .map_err(|error| in_terms_of_scene(scene, &error))?;
    let apart = scene.robot.loudspeaker_offset_m != scene.robot.microphone_offset_m;
    if spec.engine == Engine::ImageSource
        && !apart
        && robot.is_some_and(|robot| robot.sound_card.is_some())
    {
        bail!(
            "{origin}: robot.microphone_offset_m: is the place of the loudspeaker, where image sources have no direct \
            wave, and nothing else tells how late a sound card is; set it apart, or simulate the field (--engine fdtd)"
        );
    }
    if let Some(robot) = robot {
        robot.apply(&mut recording, path, &spec.path);
    }
    Ok(recording.check(&format!("{origin}: paths.{}", spec.path))?)
}

/// A complaint about a recording's field as one about the scene's.
fn in_terms_of_scene(scene: &Scene, error: &localizer::Error) -> anyhow::Error {
    let localizer::Error::Invalid {
        origin,
        field,
        problem,
        remedy,
    } = error
    else {
        return anyhow!("{error}");
    };
    let field = match field.as_str() {
        "code_length" | "chip_rate_hz" | "carrier_hz" => format!("waveform.{field}"),
        "speed_of_sound_mps" if scene.air.is_some() => "medium.temperature_degc".to_string(),
        "speed_of_sound_mps" => "medium.c_mps".to_string(),
        place if place.contains("offset_m") => format!("robot.{place}"),
        place if place.starts_with("start") => format!("paths: {place}"),
        other => other.to_string(),
    };
    anyhow!("{origin}: {field}: {problem}; {remedy}")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const SCENE: &str = r#"{
        "name": "hall", "grid": {"nx": 400, "ny": 400, "dx_m": 0.005, "dt_s": 8e-6},
        "medium": {"c_mps": 340}, "sample_rate_hz": 40000,
        "waveform": {"code_length": 1023, "chip_rate_hz": 10000, "carrier_hz": 10000, "band_hz": [0, 19000]},
        "robot": {"microphone_offset_m": [0.0, 0.0]},
        "paths": {"drive": {"start": {"x_m": 1.0, "y_m": 1.0, "heading_rad": 0.0, "omega_radps": 0.1},
            "legs": [{"duration_s": 0.5, "v_mps": 0.1, "omega_radps": 0.1}]}}}"#;

    #[test]
    fn what_the_check_says_is_what_simulating_needs() {
        let said = |from: &str, to: &str| -> String {
            assert!(SCENE.contains(from), "{from}");
            let text = SCENE.replacen(from, to, 1);
            let scene = Scene::from_json(&text, Path::new("hall.json"));
            let checked = scene
                .map_err(anyhow::Error::from)
                .and_then(|scene| check_scene(&scene, "hall.json"));
            checked.map_or_else(|error| format!("{error:#}"), |()| "ok".into())
        };
        assert_eq!(said("hall", "hall"), "ok");
        // Codes too short for the localizer's usual range are codes all the same.
        for chips in ["3", "127", "255", "262143"] {
            assert_eq!(
                said(
                    "\"code_length\": 1023",
                    &format!("\"code_length\": {chips}")
                ),
                "ok"
            );
        }
        for (from, to, field) in [
            (
                "\"code_length\": 1023",
                "\"code_length\": 524287",
                "waveform.code_length",
            ),
            (
                "\"carrier_hz\": 10000",
                "\"carrier_hz\": 0",
                "waveform.carrier_hz",
            ),
            (
                "\"carrier_hz\": 10000",
                "\"carrier_hz\": 1e-300",
                "waveform.carrier_hz",
            ),
            (
                "\"carrier_hz\": 10000",
                "\"carrier_hz\": 18000",
                "waveform.carrier_hz",
            ),
            ("\"c_mps\": 340", "\"c_mps\": 425", "medium.c_mps"),
            ("40000,", "40002,", "sample_rate_hz"),
            ("[0.0, 0.0]", "[100.0, 0.0]", "the microphone at"),
            (
                "\"heading_rad\": 0.0, \"omega_radps\": 0.1",
                "\"heading_rad\": 0.0, \"omega_radps\": 12",
                "paths.drive",
            ),
        ] {
            let said = said(from, to);
            assert!(
                said.contains(field) && said.contains("hall.json"),
                "{to}: {said}"
            );
            assert!(!said.contains("max_range"), "{said}");
        }
    }

    #[test]
    fn a_sound_card_needs_a_direct_wave() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/site_robot/robot.json");
        let card = Robot::read(&file).unwrap();
        let clean = Robot {
            sound_card: None,
            ..card.clone()
        };
        let apart = SCENE.replace("[0.0, 0.0]", "[0.1, 0.0]");
        for (text, engine, robot, refused) in [
            (SCENE, Engine::ImageSource, &card, true),
            (SCENE, Engine::ImageSource, &clean, false),
            (SCENE, Engine::Fdtd, &card, false),
            (&apart, Engine::ImageSource, &card, false),
        ] {
            let scene = Scene::from_json(text, Path::new("hall.json")).unwrap();
            let spec = RecordingSpec::of("drive", engine);
            let said = check(&scene, "hall.json", &spec, Some(robot));
            match said {
                Ok(()) => assert!(!refused, "{engine:?}"),
                Err(error) => {
                    let text = format!("{error:#}");
                    assert!(refused, "{text}");
                    assert!(text.contains("robot.microphone_offset_m"), "{text}");
                }
            }
        }
    }
}
