//! `track --audio` on sound devices that ALSA makes of files: the poses of the same samples on standard input.
//!
//! Only built with the feature `audio`: `make audio-test`. ALSA's devices of files give their samples as fast as they
//! are taken; real devices do so in real time.

use std::path::Path;
use std::process::{Command, Output};

use localizer::io::wav::WavStream;

use crate::robot::track;
use crate::room::expect;

/// Where ALSA's own configuration is, which ours includes.
const ALSA: &str = "/usr/share/alsa/alsa.conf";

/// A microphone that gives the samples of a file and a loudspeaker that gives them to nobody.
fn devices(at: &Path, samples: &[f32]) {
    let raw: Vec<u8> = samples.iter().flat_map(|own| own.to_le_bytes()).collect();
    std::fs::write(at.join("heard.raw"), raw).unwrap();
    let heard = at.join("heard.raw").display().to_string();
    let text = format!(
        "<{ALSA}>\n\
        pcm.laboratory {{ type file slave.pcm {{ type null }} file /dev/null infile \"{heard}\" format raw }}\n\
        pcm.nothing {{ type null }}\n"
    );
    std::fs::write(at.join("asound.conf"), text).unwrap();
}

fn live(at: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_echolot"))
        .current_dir(at)
        .env("ALSA_CONFIG_PATH", at.join("asound.conf"))
        .args(["track", "--audio"])
        .args(arguments)
        .output()
        .unwrap()
}

#[test]
fn a_sound_devices_poses_are_those_of_its_samples() {
    if !Path::new(ALSA).exists() {
        eprintln!("skipped: {ALSA} is not there");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/site_robot");
    let file = |name: &str| example.join(name).display().to_string();
    expect(at, &["map", &file("mapping"), "-o", "map"]);
    let drive = example.join("drive/signal.wav");
    let channels = WavStream::open(&drive).unwrap().channels();
    let samples: Vec<Vec<f32>> = (1..=channels)
        .map(|channel| {
            let (mut own, mut sound) = (Vec::new(), WavStream::open(&drive).unwrap());
            while sound.read(1 << 16, channel, &mut own).unwrap() > 0 {}
            own
        })
        .collect();
    let frames: Vec<f32> = (0..samples[0].len())
        .flat_map(|k| samples.iter().map(move |own| own[k]))
        .collect();
    devices(at, &frames);
    let odometry = file("drive/odometry.csv");
    let common = [
        "--map",
        "map",
        "--odometry",
        &odometry,
        "--odometry-clock",
        "731.25",
        "--start",
        "0.84,0.87,-5.7296",
        "--output",
        "tum",
    ];
    let bytes = std::fs::read(&drive).unwrap();
    let piped = track(at, &bytes, &common);
    assert!(piped.status.success());
    let (channels, seconds) = (channels.to_string(), "14.2");
    let device = [
        "--microphone",
        "laboratory",
        "--loudspeaker",
        "nothing",
        "--channels",
        &channels,
        "--seconds",
        seconds,
    ];
    let heard = live(at, &[&common[..], &device].concat());
    let said = String::from_utf8_lossy(&heard.stderr);
    assert!(heard.status.success(), "{said}");
    assert!(!said.contains("lost"), "{said}");
    // The device stops somewhat before the file ends; poses up to there are the same.
    let (heard, piped) = (heard.stdout, piped.stdout);
    assert!(heard.len() > piped.len() * 9 / 10, "{said}");
    let shared = heard.len() - 200;
    assert_eq!(heard[..shared], piped[..shared]);

    let refused = |arguments: &[&str]| {
        let output = live(at, &[&common[..], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    for (arguments, word) in [
        (
            &["--microphone", "nonesuch", "--loudspeaker", "nothing"][..],
            "--microphone: `nonesuch`",
        ),
        (
            &["--microphone", "nothing", "--loudspeaker", "nonesuch"],
            "--loudspeaker: `nonesuch`",
        ),
        (&["--rate", "48000.5"], "--rate"),
        (&["--rate", "44101"], "--rate"),
        (&["--seconds", "0"], "--seconds"),
        (&["--level", "3"], "--level"),
        (&["--channels", "0"], "--channels"),
        (&["--format", "s16"], "--format"),
    ] {
        let said = refused(arguments);
        assert!(said.contains(word), "{arguments:?}: {said}");
    }
}
