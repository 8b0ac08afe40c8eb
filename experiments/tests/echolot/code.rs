//! The code is found where it is, and nowhere else: in scenes, codes and rates that are drawn.
//!
//! Domain: layouts of `scene random` by image sources of second order, codes of 511 to 2047 chips at 5 to 12 kHz. Right
//! recordings have the code in 95 % of their blocks or more; with noise of ten times the echoes' power, of which some
//! parts of a drive have far less than others, in more than those that are refused; noise, other codes, lengths and
//! carriers in at most 10 %.

use std::path::Path;
use std::sync::Arc;

use localizer::io::wav;
use localizer::quality::CodeMeter;
use localizer::random;
use localizer::signal::waveform::transmit_period;
use localizer::{Parameters, Recording, echo};
use rand::RngExt;
use rand_distr::StandardNormal;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use serde_json::Value;

use crate::room::{echolot, expect, note};

/// Periods of a drive that are looked at.
const PERIODS: usize = 100;

/// A drive of a layout with a code of its own.
fn drive(at: &Path, number: u64) -> Recording {
    let mut draw = random::stream(random::trial_seed("code", "", number), "scene");
    let kind = ["open", "room"][draw.random_range(0..2)];
    let seed = draw.random_range(1..1000_u32).to_string();
    let random = [
        "scene", "random", "--kind", kind, "--seed", &seed, "--force",
    ];
    expect(at, &[&random[..], &["-o", "scene.json"]].concat());
    let text = std::fs::read_to_string(at.join("scene.json")).unwrap();
    let mut scene: Value = serde_json::from_str(&text).unwrap();
    let code = [511_u32, 1023, 2047][draw.random_range(0..3)];
    // A period is a whole number of samples at both rates.
    let (chips, rate) = [
        (10_000, 40_000),
        (5000, 40_000),
        (8000, 48_000),
        (12_000, 48_000),
    ][draw.random_range(0..4)];
    scene["waveform"]["code_length"] = code.into();
    scene["waveform"]["chip_rate_hz"] = chips.into();
    scene["sample_rate_hz"] = rate.into();
    std::fs::write(at.join("scene.json"), scene.to_string()).unwrap();
    let simulate = [
        "simulate",
        "scene.json",
        "--path",
        "localization",
        "--force",
    ];
    let more = ["--engine", "image-source", "--with-direct", "-o", "drive"];
    expect(at, &[&simulate[..], &more].concat());
    let mut drive = Recording::read_aligned(&at.join("drive")).unwrap();
    let period = Parameters::default().for_recording(&drive.meta);
    let length = PERIODS * period.samples_per_period();
    drive.signal.truncate(length);
    drive.direct.as_mut().unwrap().truncate(length);
    println!("{number}: {kind} {seed}, {code} chips at {chips} Hz, {rate} Hz");
    drive
}

/// Share of the blocks with the code; none where the parameters do not allow the recording.
fn share(drive: &Recording) -> Option<f64> {
    let mut parameters = Parameters::default().for_recording(&drive.meta);
    let longest = parameters.samples_per_period() as f64 - 1.0;
    let longest_m = parameters.signal.range_of_delay_m(longest);
    let measurement = &mut parameters.measurement;
    measurement.max_range_m = measurement.max_range_m.min(longest_m);
    let echoes = echo::measure(drive, &parameters).ok()?;
    CodeMeter::of(&echoes).share()
}

/// The spectrum of a period.
fn spectrum(period: &[f64], transform: &Arc<dyn Fft<f64>>) -> Vec<Complex<f64>> {
    let mut spectrum: Vec<Complex<f64>> = period.iter().map(|&x| Complex::new(x, 0.0)).collect();
    transform.process(&mut spectrum);
    spectrum
}

/// The same drive with another code of the same length.
fn recoded(drive: &Recording, number: u64) -> Recording {
    let mut draw = random::stream(random::trial_seed("code", "", number), "chips");
    let chips: Vec<f64> = (0..drive.meta.code_length)
        .map(|_| if draw.random::<bool>() { 1.0 } else { -1.0 })
        .collect();
    with_period(drive, &|t_s| {
        let chip = (t_s * drive.meta.chip_rate_hz) as usize;
        let turn = std::f64::consts::TAU * drive.meta.carrier_hz * t_s;
        chips[chip.min(chips.len() - 1)] * turn.sin()
    })
    .0
}

/// The same drive with another period of the same length, given over time, and that period: what the echoes make of one
/// they make of the other.
pub(crate) fn with_period(
    drive: &Recording,
    waveform: &dyn Fn(f64) -> f64,
) -> (Recording, Vec<f64>) {
    let parameters = Parameters::default().for_recording(&drive.meta);
    let own = transmit_period(&parameters.signal);
    let other: Vec<f64> = (0..own.len())
        .map(|k| waveform(k as f64 / drive.meta.sample_rate_hz))
        .collect();
    let mut planner = FftPlanner::new();
    let forward = planner.plan_fft_forward(own.len());
    let inverse = planner.plan_fft_inverse(own.len());
    let (from, to) = (spectrum(&own, &forward), spectrum(&other, &forward));
    let mean = from.iter().map(Complex::norm_sqr).sum::<f64>() / from.len() as f64;
    let mut changed = drive.clone();
    for period in changed.signal.chunks_exact_mut(own.len()) {
        let samples: Vec<f64> = period.iter().map(|&x| f64::from(x)).collect();
        let mut lines = spectrum(&samples, &forward);
        for ((line, from), to) in lines.iter_mut().zip(&from).zip(&to) {
            *line *= to * from.conj() / (from.norm_sqr() + 0.01 * mean) / samples.len() as f64;
        }
        inverse.process(&mut lines);
        for (sample, line) in period.iter_mut().zip(&lines) {
            *sample = line.re as f32;
        }
    }
    (changed, other)
}

/// Adds white noise of a level below the echoes, in decibels.
fn noisy(drive: &Recording, snr_db: f64, number: u64) -> Recording {
    let mut noisy = drive.clone();
    let noise = experiments::recordings::noise::Noise {
        snr_db,
        trial: number,
    };
    noise.add_to(&mut noisy.signal, drive.direct.as_ref().unwrap());
    noisy
}

#[test]
fn the_code_is_found_in_its_own_recordings_alone() {
    let folder = tempfile::tempdir().unwrap();
    let scenes: u64 = match std::env::var_os("ECHOLOT_MOMENTS") {
        Some(_) => 20,
        None => 3,
    };
    let (mut right, mut wrong) = (0, 0);
    for number in 0..scenes {
        let good = drive(folder.path(), number);
        for (name, drive, least) in [
            ("as it is", good.clone(), 0.95),
            ("at 0 dB", noisy(&good, 0.0, number), 0.5),
            ("at -10 dB", noisy(&good, -10.0, number), 0.3),
        ] {
            let found = share(&drive).unwrap();
            println!("{number} {name}: {found:.3}");
            assert!(found >= least, "{number} {name}: {found}");
            right += 1;
        }
        let changed = |change: &dyn Fn(&mut Recording)| {
            let mut drive = good.clone();
            change(&mut drive);
            drive
        };
        let mut random = random::stream(random::trial_seed("code", "", number), "noise");
        let mut noise = good.clone();
        noise.signal.fill_with(|| random.sample(StandardNormal));
        let length = good.meta.code_length as f64;
        for (name, drive) in [
            ("noise", noise),
            ("reversed", changed(&|drive| drive.signal.reverse())),
            ("another code", recoded(&good, number)),
            (
                "a longer code",
                changed(&|drive| {
                    drive.meta.code_length = 2 * drive.meta.code_length + 1;
                }),
            ),
            (
                "a longer code in step",
                changed(&|drive| {
                    drive.meta.code_length = 2 * drive.meta.code_length + 1;
                    drive.meta.chip_rate_hz *= (2.0 * length + 1.0) / (2.0 * length);
                }),
            ),
            (
                "a shorter code",
                changed(&|drive| drive.meta.code_length /= 2),
            ),
            (
                "another carrier",
                changed(&|drive| drive.meta.carrier_hz *= 0.9),
            ),
        ] {
            // Some are refused for their numbers alone.
            let Some(found) = share(&drive) else {
                continue;
            };
            println!("{number} {name}: {found:.3}");
            assert!(found <= 0.1, "{number} {name}: {found}");
            wrong += 1;
        }
    }
    note("right recording, down to -10 dB", "code", right, "found");
    note(
        "recording of something else",
        "code",
        wrong,
        "found in 10 % of the blocks or less",
    );
}

/// The example, late and drifting, with its sound changed: what is aligned to nothing is refused too.
#[test]
fn a_sound_cards_recording_of_something_else_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/site_robot/drive");
    let whole = std::fs::read(example.join("signal.wav")).unwrap();
    let (head, sound) = whole.split_at(44);
    let frames: Vec<[u8; 4]> = sound
        .chunks_exact(4)
        .map(|x| x.try_into().unwrap())
        .collect();
    let write = |name: &str, frames: &[[u8; 4]], from: &str, to: &str| {
        let own = at.join(name);
        std::fs::create_dir(&own).unwrap();
        for file in ["odometry.csv", "truth.tum"] {
            std::fs::copy(example.join(file), own.join(file)).unwrap();
        }
        let text = std::fs::read_to_string(example.join("recording.json")).unwrap();
        assert!(text.contains(from), "{text}");
        std::fs::write(own.join("recording.json"), text.replacen(from, to, 1)).unwrap();
        std::fs::write(own.join("signal.wav"), [head, &frames.concat()].concat()).unwrap();
    };
    let mut random = random::stream(random::trial_seed("code", "", 0), "card");
    let mut noise = |scale: f64| -> i32 {
        let value: f64 = random.sample(StandardNormal);
        (scale * value) as i32
    };
    let with_noise = |frame: &[u8; 4], noise: i32| {
        let left = i32::from(i16::from_le_bytes([frame[0], frame[1]])) / 2;
        let left = (left + noise).clamp(-32_768, 32_767) as i16;
        [left.to_le_bytes(), [0; 2]].concat().try_into().unwrap()
    };
    let reversed: Vec<[u8; 4]> = frames.iter().rev().copied().collect();
    let loud: Vec<[u8; 4]> = frames
        .iter()
        .map(|frame| with_noise(frame, noise(2500.0)))
        .collect();
    let hiss: Vec<[u8; 4]> = frames
        .iter()
        .map(|_| with_noise(&[0; 4], noise(6000.0)))
        .collect();
    let length = "\"code_length\": 1023";
    write("right", &frames, length, length);
    write("loud", &loud, length, length);
    write("reversed", &reversed, length, length);
    write("hiss", &hiss, length, length);
    for (name, code) in [("shorter", "511"), ("longer", "2047")] {
        write(name, &frames, length, &format!("\"code_length\": {code}"));
    }
    write(
        "carrier",
        &frames,
        "\"carrier_hz\": 10000",
        "\"carrier_hz\": 8800",
    );
    assert_eq!(
        wav::WavStream::open(&at.join("loud/signal.wav"))
            .unwrap()
            .channels(),
        2
    );
    for name in ["right", "loud"] {
        expect(at, &["map", name, "-o", name_of_map(name)]);
    }
    for name in ["reversed", "hiss", "shorter", "longer", "carrier"] {
        let output = echolot(at, &["map", name, "-o", "none"]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        let error = said.lines().last().unwrap();
        println!("{error}");
        assert!(error.contains(name) && error.contains("error: "), "{said}");
        assert!(!at.join("none").exists());
    }
    note(
        "recording of something else",
        "map of a sound card's",
        5,
        "refused",
    );
}

/// The folder of a drive's map.
fn name_of_map(drive: &str) -> &'static str {
    if drive == "right" {
        "map-right"
    } else {
        "map-loud"
    }
}
