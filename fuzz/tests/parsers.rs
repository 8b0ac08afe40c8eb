//! Every parser against mutated files: none panics, takes more than a second, or more than 1 GiB of memory.
//!
//! Plain `cargo test` runs each target for two seconds on the files of `corpus/` and mutations of them. `make fuzz`
//! runs as many inputs as one likes; the variables of `bolero` (`BOLERO_RANDOM_ITERATIONS`,
//! `BOLERO_RANDOM_TEST_TIME_MS`, `BOLERO_RANDOM_SEED`) and its other engines work too. Under `--cfg fuzzing` the
//! field's kernels are left out, which take most of the time to compile.

#[path = "../../experiments/src/bag/written.rs"]
mod written;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use bolero::check;
use experiments::bag::{self, Topics, cdr};
use experiments::check::gate::Baseline;
use experiments::data::cache::unsealed;
use experiments::data::manifest::Manifest;
use experiments::data::table::Table;
use experiments::data::{estimate, json};
use experiments::figures::drawing::png;
use experiments::live::{lines, pcm};
use experiments::recordings::robot::Robot;
use experiments::run::preset::Preset;
use experiments::summary::Summary;
use experiments::trials::TrialResult;
use fdtd::motion::DrivePath;
use fdtd::scene::Scene;
use fdtd::simulation::{Flow, Simulation, SimulationOptions};
use fuzz::{Plan, mutated};
use localizer::io::map_folder::parse_npy;
use localizer::io::{odometry_csv, wav};
use localizer::landmarks::LandmarkMap;
use localizer::recording::RecordingMeta;
use localizer::{MapImage, Parameters, Trajectory};

/// Longest time for one input.
const LONGEST: Duration = Duration::from_secs(1);
/// Memory that one input may take, bytes.
const MOST_BYTES: u64 = 1 << 30;

/// Cells of a field from which its check takes long, and of the largest that a machine can hold.
const MOST_CELLS: u64 = 10_000_000;
const EVERY_CELL: u64 = 1 << 40;

/// Processor time of this thread: others may keep the machine busy.
#[cfg(unix)]
fn processor_time() -> Duration {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(now.tv_sec as u64, now.tv_nsec as u32)
}

#[cfg(not(unix))]
fn processor_time() -> Duration {
    static START: std::sync::LazyLock<std::time::Instant> =
        std::sync::LazyLock::new(std::time::Instant::now);
    START.elapsed()
}

/// The seeds of a target: the files of its folder in `corpus`.
fn corpus(name: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(name);
    let mut files: Vec<PathBuf> = std::fs::read_dir(&folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    assert!(!files.is_empty(), "{name} has no corpus");
    files
        .iter()
        .map(|file| std::fs::read(file).unwrap())
        .collect()
}

/// Limits the address space to what is taken now and the memory of one input. An allocation beyond it ends the test.
#[cfg(target_os = "linux")]
fn limit_memory() {
    use rustix::process::{Resource, Rlimit, setrlimit};
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    let pages: u64 = pages.split(' ').next().unwrap().parse().unwrap();
    // Other targets run beside this one, and their threads have stacks.
    let taken = pages * 4096 + (1 << 29);
    let limit = Some(taken + MOST_BYTES);
    setrlimit(
        Resource::As,
        Rlimit {
            current: limit,
            maximum: limit,
        },
    )
    .ok();
}

#[cfg(not(target_os = "linux"))]
fn limit_memory() {
    let _ = MOST_BYTES;
}

/// Runs a parser on the seeds and on mutations of them.
fn fuzz(name: &str, seeds: Vec<Vec<u8>>, parse: impl Fn(&[u8]) + std::panic::RefUnwindSafe) {
    static LIMIT: std::sync::Once = std::sync::Once::new();
    LIMIT.call_once(limit_memory);
    for seed in &seeds {
        parse(seed);
    }
    let (inputs, longest_us) = (AtomicU64::new(0), AtomicU64::new(0));
    let one = |plan: &Plan| {
        let bytes = mutated(&seeds, plan);
        let started = processor_time();
        parse(&bytes);
        let taken = processor_time().saturating_sub(started);
        assert!(
            taken < LONGEST,
            "{name}: {taken:?} for {}",
            String::from_utf8_lossy(&bytes)
        );
        inputs.fetch_add(1, Ordering::Relaxed);
        longest_us.fetch_max(taken.as_micros() as u64, Ordering::Relaxed);
    };
    let target = check!().with_type::<Plan>().with_max_len(512);
    if std::env::var_os("BOLERO_RANDOM_ITERATIONS").is_some() {
        let hours = Duration::from_secs(24 * 3600);
        target.with_test_time(hours).for_each(one);
    } else {
        let target = target.with_iterations(usize::MAX);
        target.with_test_time(Duration::from_secs(2)).for_each(one);
    }
    let (inputs, longest_us) = (inputs.into_inner(), longest_us.into_inner());
    println!(
        "{name}: {inputs} inputs, the longest {:.1} ms",
        longest_us as f64 * 1e-3
    );
    note(name, inputs, longest_us);
}

/// Adds a line to the list of what was tried, where one is kept: see `echolot robustness`.
fn note(name: &str, inputs: u64, longest_us: u64) {
    let Some(list) = std::env::var_os("ECHOLOT_TRIED") else {
        return;
    };
    let line = serde_json::json!({
        "kind": "mutated files",
        "what": name,
        "count": inputs,
        "result": format!("no panic; the longest took {:.1} ms", longest_us as f64 * 1e-3),
    });
    let mut file = std::fs::OpenOptions::new()
        .append(true)
        .create(true)
        .open(list)
        .unwrap();
    std::io::Write::write_all(&mut file, format!("{line}\n").as_bytes()).unwrap();
}

/// Runs a parser of text; what is no text is for the reader of files to refuse.
fn fuzz_text(name: &str, parse: impl Fn(&str) + std::panic::RefUnwindSafe) {
    fuzz(name, corpus(name), |bytes| {
        parse(&String::from_utf8_lossy(bytes))
    });
}

/// An error is one line, and not a page of the file.
fn line<T, E: std::fmt::Display>(result: Result<T, E>) -> Option<T> {
    result
        .map_err(|error| {
            let text = format!("{error:#}");
            assert!(!text.contains('\n') && text.len() < 2000, "{text}");
        })
        .ok()
}

#[test]
fn scene() {
    fuzz_text("scene", |text| {
        // Poses of a file beside the scene are another target's.
        let text = text.replace("\"file\"", "\"none\"");
        // A field that fills the machine's memory is allowed, and its check looks at every cell of it.
        let scene: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
        let cells = |axis: &str| scene["grid"][axis].as_u64().unwrap_or_default();
        if (MOST_CELLS..=EVERY_CELL).contains(&cells("nx").saturating_mul(cells("ny"))) {
            return;
        }
        line(Scene::from_json(&text, Path::new("scene.json")));
    });
}

#[test]
fn path() {
    for (name, is_csv) in [("path_csv", true), ("tum", false)] {
        fuzz_text(name, |text| {
            drop(line(DrivePath::from_text(text, is_csv, "path")))
        });
    }
}

#[test]
fn checkpoint() {
    let text = r#"{ "name": "open air", "grid": { "nx": 72, "ny": 72, "dx_m": 0.005, "dt_s": 8e-6 },
        "paths": { "p": { "start": { "x_m": 0.18, "y_m": 0.18, "heading_rad": 0.0 },
            "legs": [{ "duration_s": 0.01, "v_mps": 0.0, "omega_radps": 0.0 }] } } }"#;
    let scene = Scene::from_json(text, Path::new("open.json")).unwrap();
    let options = SimulationOptions {
        threads: 1,
        ..SimulationOptions::default()
    };
    let wave = scene.source_waveform().unwrap();
    let new = || Simulation::new(&scene, "p", &wave, &options).unwrap();
    let mut simulation = new();
    simulation.run(&mut |_, _| Flow::Stop).unwrap();
    let mut bytes = Vec::new();
    simulation.write_checkpoint(&mut bytes).unwrap();
    let mut other = new();
    other.read_checkpoint(&bytes, Path::new("c")).unwrap();
    assert_eq!(other.step(), simulation.step());
    let target = std::sync::Mutex::new(other);
    fuzz("checkpoint", vec![bytes], move |bytes| {
        let mut simulation = target.lock().unwrap();
        line(simulation.read_checkpoint(bytes, Path::new("c")));
    });
}

#[test]
fn recording_json() {
    fuzz_text("recording", |text| {
        if let Ok(meta) = localizer::io::json::parse::<RecordingMeta>(text)
            && line(meta.check("recording.json")).is_some()
        {
            let period = meta.signal_parameters().samples_per_period();
            assert!(period > 0 && period < 1 << 25);
            line(Parameters::default().for_recording(&meta).check());
        }
    });
}

#[test]
fn parameters() {
    fuzz_text("parameters", |text| {
        if let Ok(parameters) = localizer::io::json::parse::<Parameters>(text)
            && line(parameters.check()).is_some()
        {
            assert!(parameters.delays() > 0 && parameters.window_cells() > 0);
        }
    });
}

#[test]
fn sound() {
    fuzz("wav", corpus("wav"), |bytes| {
        for rate_hz in [40_000.0, 50_000.0] {
            if let Some(samples) = line(wav::parse(bytes.to_vec(), rate_hz, "a.wav")) {
                assert!(samples.iter().all(|sample| sample.is_finite()));
            }
        }
    });
}

/// What `track` reads on standard input: the header of a WAV stream, and samples of every format.
#[test]
fn stream_of_sound() {
    let mut seeds = corpus("wav");
    // As a pipe's writer begins: it knows no length.
    for seed in seeds.clone() {
        let mut endless = seed;
        endless[4..8].fill(0xff);
        seeds.push(endless);
    }
    fuzz("stream of sound", seeds, |bytes| {
        let mut rest = bytes;
        if let Some(layout) = line(pcm::header(&mut rest, None)) {
            assert!(layout.samples(rest).len() <= rest.len());
        }
        for format in [
            pcm::Format::F32,
            pcm::Format::F64,
            pcm::Format::U8,
            pcm::Format::S24,
        ] {
            let layout = pcm::Layout {
                format,
                rate_hz: 48_000.0,
                channels: 2,
                channel: None,
            };
            assert!(layout.samples(bytes).len().is_multiple_of(2));
        }
    });
}

/// What `track` reads of the wheels.
#[test]
fn stream_of_odometry() {
    fuzz("stream of odometry", corpus("odometry"), |bytes| {
        for text in String::from_utf8_lossy(bytes).lines() {
            match lines::parse(text) {
                Some(lines::Line::Sample(sample)) => assert!(sample.t_s.is_finite()),
                Some(lines::Line::Bad(problem)) => {
                    assert!(!problem.contains('\n') && problem.len() < 400, "{problem}");
                }
                None => {}
            }
        }
    });
}

/// A small bag of every type: single records, so that messages are reached, or in chunks.
fn small_bag(in_chunks: bool) -> Vec<u8> {
    let topics = [
        ("/odom", "nav_msgs/msg/Odometry"),
        ("/tracker", "geometry_msgs/msg/PoseStamped"),
        ("/tf", "geometry_msgs/msg/TransformStamped"),
        ("/mic", "audio_common_msgs/msg/AudioData"),
    ];
    let messages = (0..3_u32).flat_map(|k| {
        let time = (1_716_249_600, k * 100_000_000);
        let pose = [0.1 * f64::from(k), 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let log_ns = 1_716_249_600_000_000_000 + u64::from(k);
        [
            (0, log_ns, written::odometry(time, &pose, 0.3, 0.01)),
            (1, log_ns, written::pose(time, &pose)),
            (2, log_ns, written::transform(time, &pose)),
            (3, log_ns, written::audio(&[k as u8; 64])),
        ]
    });
    written::bag(&topics, messages, in_chunks)
}

#[test]
fn bag() {
    let seeds = vec![small_bag(false), small_bag(true)];
    let topics = [Some("/tracker".to_string()), Some("/tf".to_string())].map(|truth| Topics {
        truth,
        ..Topics::default()
    });
    fuzz("bag", seeds, |bytes| {
        for wanted in &topics {
            if let Some(read) = line(bag::read(bytes, Path::new("a.mcap"), wanted)) {
                line(odometry_csv::parse(&read.odometry, "odometry"));
                read.truth
                    .map(|text| line(Trajectory::from_tum(&text, "truth")));
            }
        }
    });
}

#[test]
fn messages() {
    let pose = [0.1, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let seeds = vec![
        written::odometry((5, 7), &pose, 0.3, 0.01),
        written::pose((5, 7), &pose),
        written::transform((5, 7), &pose),
        written::audio(&[1, 2, 3]),
    ];
    fuzz("messages of a bag", seeds, |bytes| {
        for placed in [
            cdr::odometry(bytes).map(|(placed, _)| placed),
            cdr::pose(bytes),
            cdr::transform(bytes),
        ] {
            assert!(placed.is_none_or(|placed| placed.place_m.iter().all(|x| x.is_finite())));
        }
        assert!(cdr::audio(bytes).is_none_or(|sound| sound.len() < bytes.len()));
    });
}

#[test]
fn odometry() {
    fuzz_text("odometry", |text| {
        drop(line(odometry_csv::parse(text, "odometry.csv")))
    });
}

#[test]
fn trajectory() {
    fuzz_text("tum", |text| {
        if let Some(trajectory) = line(Trajectory::from_tum(text, "truth.tum")) {
            assert!(trajectory.t_s.is_sorted_by(|a, b| a < b));
            trajectory.jumps(1.0);
            trajectory.covered_pose_at(0.0);
        }
        estimate::is_ours(text.as_bytes());
    });
}

#[test]
fn map() {
    let map = MapImage {
        origin_cell: [-3, 5],
        cell_m: 0.1,
        intensity: ndarray::Array2::from_elem((4, 6), 1.0),
        toa_only: ndarray::Array2::from_elem((4, 6), 0.5),
        parameters: Parameters::default(),
    };
    let folder = tempfile::tempdir().unwrap();
    map.write(folder.path()).unwrap();
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let (intensity, toa) = (bytes("map.npy"), bytes("map_toa.npy"));
    let seeds = vec![bytes("map.json")];
    fuzz("map", seeds, |header| {
        let header = String::from_utf8_lossy(header);
        line(MapImage::from_bytes(
            &header,
            [&intensity, &toa],
            Path::new("map"),
        ));
    });
    fuzz(
        "npy",
        vec![bytes("map.npy"), bytes("map_toa.npy")],
        |bytes| {
            line(parse_npy(bytes, Path::new("map.npy")));
        },
    );
}

#[test]
fn landmarks() {
    fuzz_text("landmarks", |text| {
        drop(line(LandmarkMap::from_json(text, "landmarks.json")))
    });
}

#[test]
fn robot() {
    fuzz_text("robot", |text| {
        line(Robot::parse(text, Path::new("robot.json")));
    });
}

#[test]
fn baseline() {
    fuzz_text("baseline", |text| {
        if let Some(baseline) = line(Baseline::parse(text, Path::new("b.json"), Preset::Quick)) {
            assert!(!baseline.measures.is_empty());
        }
    });
}

#[test]
fn summary() {
    fuzz_text("summary", |text| {
        drop(line(json::parse::<Summary>(text, Path::new("s.json"))))
    });
}

#[test]
fn cache_entry() {
    let result = r#"{"t_s":[0.1],"x_m":[1.0],"y_m":[2.0],"heading_rad":[0.1],"error_m":[0.01],
        "heading_error_rad":[0.0]}"#;
    let value: serde_json::Value = serde_json::from_str(result).unwrap();
    let sealed = experiments::data::cache::sealed(&value)
        .unwrap()
        .into_bytes();
    assert!(unsealed::<TrialResult>(&sealed).is_some());
    fuzz("cache", vec![sealed], |bytes| {
        drop(unsealed::<TrialResult>(bytes))
    });
}

#[test]
fn manifest() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("map.npy"), "x").unwrap();
    let seed = serde_json::to_vec(&Manifest::of(folder.path()).unwrap()).unwrap();
    fuzz("manifest", vec![seed], |bytes| {
        let _ = serde_json::from_slice::<Manifest>(bytes);
    });
}

#[test]
fn table() {
    fuzz_text("table", |text| {
        if let Some(table) = line(Table::parse(text, "data.csv")) {
            line(table.numbers("snr_db"));
        }
    });
}

#[test]
fn picture() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.png");
    png::write_png(&file, 4, 3, &[7; 36]).unwrap();
    let seed = std::fs::read(&file).unwrap();
    assert!(png::is_ours(&seed));
    fuzz("png", vec![seed], |bytes| {
        png::is_ours(bytes);
    });
}
