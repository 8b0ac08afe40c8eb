//! Memory of what reads recordings does not grow with the drive.
//!
//! Domain: circles in the room of the tests for 20 s and 100 s, by image sources; the largest resident size as Linux
//! counts it. Tolerance: 12 MiB more for the longer one, which is twice what its poses take; its echoes alone are 250
//! MiB. An hour's drive: docs/findings/long-drives.md.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};

use crate::room::{ROOM, expect};

/// Largest resident size of a command in MiB, looked at until it ends.
fn peak_mib(at: &Path, arguments: &[&str], input: Option<&str>) -> f64 {
    let input = input.map_or(Stdio::null(), |file| {
        std::fs::File::open(at.join(file)).unwrap().into()
    });
    let mut child = Command::new(env!("CARGO_BIN_EXE_echolot"))
        .current_dir(at)
        .args(arguments)
        .stdin(input)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut peak_kib = 0.0_f64;
    loop {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = line.and_then(|line| line.split_whitespace().next()?.parse().ok());
        peak_kib = peak_kib.max(kib.unwrap_or(0.0));
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{arguments:?}");
            return peak_kib / 1024.0;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_drive() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mut scene: Value = serde_json::from_str(ROOM).unwrap();
    let start = scene["paths"]["mapping"]["start"].clone();
    for (name, seconds) in [("short", 20), ("long", 100)] {
        scene["paths"][name] = json!({
            "start": start, "legs": [{"duration_s": seconds, "v_mps": 0.3, "omega_radps": 0.85}],
        });
    }
    std::fs::write(at.join("room.json"), scene.to_string()).unwrap();
    for name in ["short", "long"] {
        let simulate = ["simulate", "room.json", "--path", name, "-o", name];
        expect(at, &[&simulate[..], &["--engine", "image-source"]].concat());
    }
    expect(at, &["map", "short", "-o", "map"]);
    expect(
        at,
        &[
            "map",
            "short",
            "--method",
            "landmarks",
            "-o",
            "map",
            "--force",
        ],
    );
    let known = [
        "--late",
        "0",
        "--drift",
        "0",
        "--odometry-clock",
        "0",
        "--start",
        "1.6,1.25,90",
    ];
    for (method, window) in [("doppler", "1.5"), ("landmarks", "1.5")] {
        let of = |drive: &str| {
            let odometry = format!("{drive}/odometry.csv");
            let sound = format!("{drive}/signal.wav");
            let common = ["--method", method, "--force", "-o"];
            let map = ["map", drive];
            let among = ["localize", drive, "--map", "map"];
            let window = ["--window", window];
            let window = if method == "doppler" {
                &window[..]
            } else {
                &[]
            };
            let track = [
                "track",
                "--map",
                "map",
                "--method",
                method,
                "--odometry",
                &odometry,
            ];
            let mapping = if method == "doppler" {
                "images"
            } else {
                method
            };
            let mapped = ["--method", mapping, "--force", "-o", "other"];
            [
                peak_mib(at, &[&map[..], &mapped].concat(), None),
                peak_mib(
                    at,
                    &[&among[..], &common, &["e.tum"], window].concat(),
                    None,
                ),
                peak_mib(at, &[&track[..], &known, window].concat(), Some(&sound)),
            ]
        };
        let (short, long) = (of("short"), of("long"));
        for ((what, short), long) in ["map", "localize", "track"].iter().zip(short).zip(long) {
            assert!(
                short > 4.0,
                "{what} {method}: {short} MiB: ended before it was looked at"
            );
            assert!(
                long < short + 12.0,
                "{what} {method}: {short} MiB, {long} MiB"
            );
        }
    }
}
