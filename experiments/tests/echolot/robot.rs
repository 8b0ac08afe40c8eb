//! A robot's recording as a sound card gives it: with no number typed but the code's, it is as good as a clean one.
//!
//! Domain: the site's drives by image sources of fourth order; 48 kHz, two channels, 150 ms late, 20 ppm off, 16 bits,
//! noise of -40 dB, wheels and truth on clocks of their own. Tolerance: a tenth of the error, over eight seeds of the
//! filter, whose own scatter of a single seed is more than that.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::{Value, json};

use crate::room::{echolot, expect, refuse};

/// Drives of the site through the robot, clean and through a sound card.
fn record(at: &Path, path: &str) {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut robot: Value =
        serde_json::from_str(&std::fs::read_to_string(own.join("robots/site.json")).unwrap())
            .unwrap();
    std::fs::write(at.join("clean.json"), robot.to_string()).unwrap();
    robot["sound_card"] = json!({
        "sample_rate_hz": 48_000, "bits": 16, "channels": 2, "channel": 2, "late_s": 0.15, "drift_ppm": 20.0
    });
    std::fs::write(at.join("card.json"), robot.to_string()).unwrap();
    let scene = own.join("../scenes/site.json").display().to_string();
    for robot in ["clean", "card"] {
        let (file, output) = (format!("{robot}.json"), format!("{robot}/{path}"));
        let arguments = [
            "simulate",
            &scene,
            "--path",
            path,
            "--engine",
            "image-source",
        ];
        let more = ["--image-order", "4", "--robot", &file, "-o", &output];
        expect(at, &[&arguments[..], &more].concat());
    }
}

fn mae_m(at: &Path, robot: &str, seed: u32) -> f64 {
    let (drive, map, seed) = (
        format!("{robot}/localization"),
        format!("map_{robot}"),
        seed.to_string(),
    );
    let arguments = [
        "localize", &drive, "--map", &map, "--window", "3", "--seed", &seed,
    ];
    let report = expect(at, &[&arguments[..], &["-o", "x.tum", "--json"]].concat());
    serde_json::from_str::<Value>(&report).unwrap()["mae_m"]
        .as_f64()
        .unwrap()
}

/// `echolot track` with a file on standard input.
pub(crate) fn track(at: &Path, sound: &[u8], arguments: &[&str]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_echolot"))
        .current_dir(at)
        .arg("track")
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let sound = sound.to_vec();
    let writer = std::thread::spawn(move || {
        // A program that ends early closes the pipe.
        let _ = input.write_all(&sound);
    });
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    output
}

#[test]
fn a_sound_cards_recording_is_as_good_as_a_clean_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for path in ["mapping", "localization"] {
        record(at, path);
    }
    for robot in ["clean", "card"] {
        let (mapping, map) = (format!("{robot}/mapping"), format!("map_{robot}"));
        expect(at, &["map", &mapping, "-o", &map]);
    }
    let mean = |robot| (0..8).map(|seed| mae_m(at, robot, seed)).sum::<f64>() / 8.0;
    let (clean, card) = (mean("clean"), mean("card"));
    assert!(card < 1.1 * clean, "{card} m, clean {clean} m");
    let lines = expect(
        at,
        &[
            "record",
            "check",
            "card/localization",
            "--figure",
            "check.png",
        ],
    );
    assert!(lines.lines().all(|line| line.starts_with("ok")), "{lines}");
    assert!(at.join("check.png").exists());

    // Live: the bytes of localize, whatever the sound's pieces, and what they cannot have is told.
    std::fs::remove_file(at.join("card/localization/truth.tum")).unwrap();
    let start = "0.84,0.87,-5.7296";
    let common = ["--map", "map_card", "--window", "3", "--start", start];
    let offline = ["localize", "card/localization", "-o", "offline.tum"];
    expect(at, &[&offline[..], &common].concat());
    let offline = std::fs::read_to_string(at.join("offline.tum")).unwrap();
    // Its first line is the file's mark.
    let (_, offline) = offline.split_once('\n').unwrap();
    let sound = std::fs::read(at.join("card/localization/signal.wav")).unwrap();
    let wheels = ["--odometry", "card/localization/odometry.csv"];
    let tum = ["--output", "tum"];
    let live = track(at, &sound, &[&common[..], &wheels, &tum].concat());
    let told = String::from_utf8_lossy(&live.stderr).to_string();
    assert!(String::from_utf8(live.stdout).unwrap() == offline, "{told}");
    assert!(
        told.contains("channel 2") && told.contains("150.0"),
        "{told}"
    );
    let raw = [
        "--format",
        "s16",
        "--channels",
        "2",
        "--odometry-clock",
        "731.1",
    ];
    // A gap of 10 ms after 20 s.
    let mut cut = sound[44..].to_vec();
    cut.drain(4 * 960_000..4 * 960_480);
    let live = track(at, &cut, &[&common[..], &wheels, &raw].concat());
    let told = String::from_utf8_lossy(&live.stderr).to_string();
    assert!(
        live.status.success() && told.contains("samples are missing"),
        "{told}"
    );
    let poses: Vec<Value> = String::from_utf8(live.stdout)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let gaps = poses.iter().filter(|pose| pose["status"] == "gap").count();
    assert!(
        poses.len() > 380 && (2..=6).contains(&gaps),
        "{} {gaps}",
        poses.len()
    );
    let last: Vec<f64> = offline
        .lines()
        .last()
        .unwrap()
        .split(' ')
        .map(|x| x.parse().unwrap())
        .collect();
    let pose = poses.last().unwrap();
    let apart =
        (pose["x_m"].as_f64().unwrap() - last[1]).hypot(pose["y_m"].as_f64().unwrap() - last[2]);
    assert!(apart < 0.25, "{apart} m");
    // Wheels that end early are told, and survived.
    let log = std::fs::read_to_string(at.join("card/localization/odometry.csv")).unwrap();
    let half: Vec<&str> = log.lines().take(1000).collect();
    std::fs::write(at.join("half.csv"), half.join("\n")).unwrap();
    let live = track(
        at,
        &sound,
        &[
            &common[..],
            &["--odometry", "half.csv"],
            &["--odometry-clock", "731.1"],
        ]
        .concat(),
    );
    let told = String::from_utf8_lossy(&live.stderr).to_string();
    assert!(
        live.status.success() && told.contains("has ended"),
        "{told}"
    );
}

#[test]
fn track_refuses_what_it_cannot_use() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let complaint = |sound: &[u8], arguments: &[&str]| {
        let output = track(at, sound, arguments);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{text}");
        text
    };
    let common = [
        "--map",
        "none",
        "--odometry",
        "none.csv",
        "--start",
        "0,0,0",
    ];
    assert!(complaint(b"", &common).contains("WAV header"));
    assert!(complaint(b"RIFFxxxxWAVE", &common).contains("WAV header"));
    let raw = [&common[..], &["--format", "s16"]].concat();
    assert!(complaint(b"", &raw).contains("none"));
    let channel = [&raw[..], &["--channel", "2"]].concat();
    assert!(complaint(b"", &channel).contains("--channel"));
    let patience = [&raw[..], &["--patience", "nan"]].concat();
    assert!(complaint(b"", &patience).contains("--patience"));
}

#[test]
fn the_sound_to_play_is_whole_periods_of_the_code() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    expect(
        at,
        &[
            "transmit",
            "-o",
            "tx.wav",
            "--seconds",
            "3",
            "--level",
            "-3",
        ],
    );
    let tx: Value =
        serde_json::from_str(&std::fs::read_to_string(at.join("tx.json")).unwrap()).unwrap();
    // Five periods of 4910.4 samples are a whole number of them.
    assert_eq!(tx["periods"], 30);
    let samples = localizer::io::wav::read(&at.join("tx.wav"), 48_000.0).unwrap();
    assert_eq!(samples.len(), 30 * 24_552 / 5);
    let peak = samples
        .iter()
        .fold(0.0_f32, |peak, sample| peak.max(sample.abs()));
    assert!((20.0 * peak.log10() + 3.0).abs() < 0.01, "{peak}");
    assert!((0..24_552).all(|k| (samples[k] - samples[k + 24_552]).abs() < 1e-6));
    // What is played is what is found: a folder with the sound, a log and the description alone.
    let folder = at.join("bench");
    std::fs::create_dir(&folder).unwrap();
    std::fs::copy(at.join("tx.wav"), folder.join("signal.wav")).unwrap();
    std::fs::copy(at.join("tx.json"), folder.join("transmitted.json")).unwrap();
    std::fs::write(
        folder.join("odometry.csv"),
        "t_s,v_mps,omega_radps\n0,0,0\n1,0,0\n2,0,0\n2.9,0,0\n",
    )
    .unwrap();
    let output = echolot(at, &["record", "check", "bench"]);
    let lines = String::from_utf8(output.stdout).unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(
        lines.contains("code") && lines.contains("+0.0"),
        "{lines} {told}"
    );
    // It replaces its own, and nothing else.
    let again = ["transmit", "-o", "tx.wav", "--seconds", "1"];
    expect(at, &again);
    let mut wav = std::fs::read(at.join("tx.wav")).unwrap();
    *wav.last_mut().unwrap() ^= 1;
    std::fs::write(at.join("tx.wav"), wav).unwrap();
    assert!(refuse(at, &again).contains("--force"));
    expect(at, &[&again[..], &["--force"]].concat());
    std::fs::write(at.join("tx.json"), "{\"mine\": 1}").unwrap();
    assert!(refuse(at, &again).contains("--force"));
    for (arguments, word) in [
        (["--code", "1000"], "--code"),
        (["--carrier", "23000"], "--carrier"),
        (["--carrier", "nan"], "--carrier"),
        (["--seconds", "1e9"], "--seconds"),
        (["--level", "3"], "--level"),
        (["--bits", "8"], "--bits"),
    ] {
        let all = [&["transmit", "-o", "a.wav"][..], &arguments].concat();
        assert!(refuse(at, &all).contains(word));
    }
    assert!(!at.join("a.wav").exists());
}
