//! `track` with what a robot gives: odometry by UDP, odometry that comes late, another waveform than a code.

use std::io::{BufRead, BufReader, Write};
use std::net::UdpSocket;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use localizer::io::wav;
use localizer::random;
use localizer::signal::waveform::transmit_period;
use localizer::{Parameters, Recording};
use rand::RngExt;
use serde_json::Value;

use crate::code::with_period;
use crate::robot::track;
use crate::room::{drives_and_map, expect};

/// Options of `track` for the room's drive, whose clocks are known.
const KNOWN: [&str; 14] = [
    "--map",
    "map",
    "--window",
    "1.5",
    "--start",
    "0.85,0.9,11.459",
    "--late",
    "0",
    "--drift",
    "0",
    "--odometry-clock",
    "0",
    "--output",
    "tum",
];

fn log(at: &Path) -> String {
    std::fs::read_to_string(at.join("drive/odometry.csv")).unwrap()
}

fn sound(at: &Path) -> Vec<u8> {
    std::fs::read(at.join("drive/signal.wav")).unwrap()
}

#[test]
fn odometry_by_udp_gives_the_poses_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    drives_and_map(at);
    let by_file = track(
        at,
        &sound(at),
        &[&KNOWN[..], &["--odometry", "drive/odometry.csv"]].concat(),
    );
    let port = UdpSocket::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    let text = log(at);
    let sender = std::thread::spawn(move || {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.connect(port).unwrap();
        // Until somebody listens, each datagram is answered by an error that the next one reports.
        let mut heard = 0;
        while heard < 3 {
            heard = match socket.send(b"# hello") {
                Ok(_) => heard + 1,
                Err(_) => 0,
            };
            std::thread::sleep(Duration::from_millis(20));
        }
        let lines: Vec<&str> = text.lines().collect();
        for some in lines.chunks(20) {
            socket.send(some.join("\n").as_bytes()).unwrap();
            std::thread::sleep(Duration::from_millis(5));
        }
    });
    let source = format!("udp:{}", port.port());
    let patient = ["--odometry", &source, "--patience", "5"];
    let by_udp = track(at, &sound(at), &[&KNOWN[..], &patient].concat());
    sender.join().unwrap();
    let told = String::from_utf8_lossy(&by_udp.stderr);
    assert!(by_udp.status.success(), "{told}");
    assert!(by_file.stdout.iter().filter(|byte| **byte == b'\n').count() > 50);
    assert!(by_udp.stdout == by_file.stdout, "{told}");
}

/// Wheels whose lines stop after 3 s and go on when the sound is at 6 s: told, survived, and told again.
#[cfg(unix)]
#[test]
fn late_odometry_is_told_and_survived() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    drives_and_map(at);
    let made = Command::new("mkfifo").arg(at.join("wheels")).status();
    assert!(made.unwrap().success());
    let mut arguments = KNOWN.to_vec();
    arguments[13] = "json";
    let mut child = Command::new(env!("CARGO_BIN_EXE_echolot"))
        .current_dir(at)
        .arg("track")
        .args(arguments)
        .args(["--odometry", "wheels", "--patience", "0.2"])
        .stdin(Stdio::piped())
        .stdout(std::fs::File::create(at.join("poses.jsonl")).unwrap())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let text = log(at);
    let time = |line: &str| -> f64 { line.split(',').next().unwrap().parse().unwrap_or(-1.0) };
    let (early, late): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| time(line) < 3.0);
    let bytes = sound(at);
    // The header, and six seconds of 32-bit floats.
    let cut = 6 * 40_000 * 4;
    let (first, second) = (bytes[..cut].to_vec(), bytes[cut..].to_vec());
    let writer = std::thread::spawn(move || {
        input.write_all(&first).unwrap();
        input
    });
    // Somebody reads it from when the sound's header is known.
    let mut wheels = std::fs::OpenOptions::new()
        .write(true)
        .open(at.join("wheels"))
        .unwrap();
    writeln!(wheels, "{}", early.join("\n")).unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines();
    let is_late = said.find(|line| line.as_ref().unwrap().contains("is late since"));
    let is_late = is_late.unwrap().unwrap();
    assert!(is_late.contains("its last speed goes on"), "{is_late}");
    std::thread::sleep(Duration::from_millis(700));
    writeln!(wheels, "{}", late.join("\n")).unwrap();
    drop(wheels);
    // What was missing comes before the sound that needs it.
    std::thread::sleep(Duration::from_millis(300));
    let mut input = writer.join().unwrap();
    input.write_all(&second).unwrap();
    drop(input);
    let rest: Vec<String> = said.map(|line| line.unwrap()).collect();
    assert!(
        rest.iter().any(|line| line.contains("is there again")),
        "{rest:?}"
    );
    assert!(child.wait().unwrap().success(), "{rest:?}");
    let poses = std::fs::read_to_string(at.join("poses.jsonl")).unwrap();
    let poses: Vec<Value> = poses
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let late = poses
        .iter()
        .filter(|pose| pose["odometry"] == "late")
        .count();
    assert!(
        late > 5 && late < poses.len() - 20,
        "{late} of {}",
        poses.len()
    );
    assert_eq!(poses[0]["odometry"], "ok");
    assert_eq!(poses.last().unwrap()["odometry"], "ok");
}

/// A period over time.
type Waveform<'a> = dyn Fn(f64) -> f64 + 'a;

/// Writes the room's recordings with another waveform, given over time, or as they are, into folders that begin with a
/// name, with `transmitted.wav` in place of the code's numbers.
fn record(at: &Path, name: &str, waveform: Option<&Waveform<'_>>) {
    for drive in ["mapping", "drive"] {
        let recording = Recording::read(&at.join(drive)).unwrap();
        let (other, period) = match waveform {
            Some(waveform) => with_period(&recording, waveform),
            None => {
                let parameters = Parameters::default().for_recording(&recording.meta);
                let period = transmit_period(&parameters.signal);
                (recording, period)
            }
        };
        let own = at.join(format!("{name}_{drive}"));
        other.write(&own).unwrap();
        let period: Vec<f32> = period.iter().map(|&sample| sample as f32).collect();
        wav::write(&own.join("transmitted.wav"), &period, 40_000.0).unwrap();
        let path = own.join("recording.json");
        let mut meta: Value =
            serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        for field in ["code_length", "chip_rate_hz", "carrier_hz"] {
            meta.as_object_mut().unwrap().remove(field);
        }
        std::fs::write(&path, meta.to_string()).unwrap();
    }
}

/// The code as a period of samples gives what its numbers give. So does, but for some centimetres, a chirp, whose delay
/// and Doppler shift are hard to tell apart, and a random code, which has sidelobes.
#[test]
fn any_periodic_waveform_maps_and_localizes() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    drives_and_map(at);
    let period_s = 0.1023;
    // From 4 to 16 kHz in a period, whole oscillations.
    let [low, high] = [4000.0, 16_000.0].map(|hz: f64| (hz * period_s).round() / period_s);
    let chirp = |t_s: f64| {
        let turns = low * t_s + 0.5 * (high - low) * t_s * t_s / period_s;
        0.7 * (std::f64::consts::TAU * turns).sin()
    };
    let mut draw = random::stream(random::trial_seed("live", "", 0), "chips");
    let chips: Vec<f64> = (0..1023)
        .map(|_| if draw.random::<bool>() { 1.0 } else { -1.0 })
        .collect();
    let chips = |t_s: f64| {
        let carrier = (std::f64::consts::TAU * 10_000.0 * t_s).sin();
        chips[((1e4 * t_s) as usize).min(1022)] * carrier
    };
    let mae_m = |drive: &str, map: &str| -> f64 {
        let localize = ["localize", drive, "--map", map, "--window", "1.5"];
        let report = expect(at, &[&localize[..], &["-o", "e.tum", "--json"]].concat());
        let report: Value = serde_json::from_str(&report).unwrap();
        assert_eq!(report["code_found"], 1.0, "{report}");
        report["mae_m"].as_f64().unwrap()
    };
    let code_m = mae_m("drive", "map");
    let waveforms: [(&str, Option<&Waveform<'_>>, f64); 3] = [
        ("same", None, 1e-3),
        ("chirp", Some(&chirp), 0.05),
        ("chips", Some(&chips), 0.05),
    ];
    for (name, waveform, more_m) in waveforms {
        record(at, name, waveform);
        let [mapping, drive, map] = ["mapping", "drive", "map"].map(|of| format!("{name}_{of}"));
        expect(at, &["map", &mapping, "-o", &map]);
        let other_m = mae_m(&drive, &map);
        println!("code {code_m} m, {name} {other_m} m");
        assert!(
            other_m < code_m + more_m,
            "code {code_m} m, {name} {other_m} m"
        );
        // Live, the waveform is given.
        let [sound, period, log] = ["signal.wav", "transmitted.wav", "odometry.csv"]
            .map(|file| at.join(&drive).join(file).display().to_string());
        let given = ["--transmitted", &period, "--odometry", &log, "--map", &map];
        let poses = track(
            at,
            &std::fs::read(sound).unwrap(),
            &[&given[..], &KNOWN[2..]].concat(),
        );
        let told = String::from_utf8_lossy(&poses.stderr);
        assert!(poses.status.success(), "{told}");
        let lines = poses.stdout.iter().filter(|byte| **byte == b'\n').count();
        assert!(lines > 50, "{told}");
    }
}

/// A build without sound devices says how to get one that has them.
#[cfg(not(feature = "audio"))]
#[test]
fn a_build_without_sound_devices_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "track",
        "--map",
        "map",
        "--audio",
        "--odometry",
        "fd:0",
        "--start",
        "0,0,0",
    ];
    let said = crate::room::refuse(folder.path(), &arguments);
    assert!(
        said.contains("--audio") && said.contains("--features"),
        "{said}"
    );
}
