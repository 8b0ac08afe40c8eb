//! Every input ends in a line: bad numbers are refused before anything is allocated, by file and field, and what
//! `scene check` accepts `simulate` accepts.

use std::path::Path;

use crate::room::{ROOM, SIMULATE, drives_and_map, echolot, expect, note, refuse, scene_file};

/// Replaces a text in a file for the time of a call.
fn with<T>(file: &Path, from: &str, to: &str, call: impl FnOnce() -> T) -> T {
    let text = std::fs::read_to_string(file).unwrap();
    assert!(text.contains(from), "{from} in {text}");
    std::fs::write(file, text.replacen(from, to, 1)).unwrap();
    let result = call();
    std::fs::write(file, text).unwrap();
    result
}

const LOCALIZE: [&str; 8] = [
    "localize",
    "drive",
    "--map",
    "map",
    "--particles",
    "5",
    "-o",
    "e.tum",
];

#[test]
fn numbers_of_a_recording_are_checked_before_anything_is_allocated() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    drives_and_map(at);
    let meta = at.join("drive/recording.json");
    let rate = "\"chip_rate_hz\": 10000.0";
    for (from, to, field) in [
        (rate, "\"chip_rate_hz\": 1e-300", "chip_rate_hz"),
        (rate, "\"chip_rate_hz\": 1", "chip_rate_hz"),
        (rate, "\"chip_rate_hz\": 100", "periods"),
        (rate, "\"chip_rate_hz\": \"fast\"", "chip_rate_hz"),
        (
            "\"sample_rate_hz\": 40000.0",
            "\"sample_rate_hz\": 1e300",
            "sample_rate_hz",
        ),
        (
            "\"sample_rate_hz\": 40000.0",
            "\"sample_rate_hz\": 40002",
            "sample_rate_hz",
        ),
        (
            "\"speed_of_sound_mps\": 340.0",
            "\"speed_of_sound_mps\": 34340",
            "speed_of_sound_mps",
        ),
        (
            "\"speed_of_sound_mps\": 340.0",
            "\"speed_of_sound_mps\": 0.34",
            "speed_of_sound_mps",
        ),
        (
            "\"code_length\": 1023",
            "\"code_length\": 1024",
            "code_length",
        ),
        (
            "\"code_length\": 1023",
            "\"code_length\": -1",
            "code_length",
        ),
        (
            "\"carrier_hz\": 10000.0",
            "\"carrier_hz\": 1e-300",
            "carrier_hz",
        ),
        (
            "\"start\": {",
            "\"microphone_offset_m\": [100, 0], \"start\": {",
            "microphone_offset_m[0]",
        ),
        (
            "\"truth_clock_s\": 0.0",
            "\"truth_clock_s\": 1.7e18",
            "truth_clock_s",
        ),
        ("\"start\": {", "\"start\": {\"z_m\": 1, ", "start"),
    ] {
        let complaint = with(&meta, from, to, || refuse(at, &LOCALIZE));
        let named = complaint.contains("recording.json") || complaint.contains("signal.wav");
        assert!(named && complaint.contains(field), "{to}: {complaint}");
    }
    // Degrees a second, and metres a minute.
    let odometry = at.join("drive/odometry.csv");
    for column in [1, 2] {
        let text = std::fs::read_to_string(&odometry).unwrap();
        let lines = text.lines().enumerate().map(|(number, line)| {
            let mut parts: Vec<String> = line.split(',').map(str::to_string).collect();
            if number > 0 {
                let value: f64 = parts[column].parse().unwrap();
                parts[column] = (value * if column == 2 { 57.3 } else { 600.0 }).to_string();
            }
            parts.join(",")
        });
        std::fs::write(&odometry, lines.collect::<Vec<_>>().join("\n")).unwrap();
        let complaint = refuse(at, &LOCALIZE);
        assert!(complaint.contains("odometry.csv sample"), "{complaint}");
        std::fs::write(&odometry, text).unwrap();
    }
    expect(at, &LOCALIZE);
    note(
        "wrong input",
        "recording.json, odometry.csv",
        16,
        "one line with file and field, exit 2",
    );
}

/// An array in place of an object would be one whose fields all keep their defaults.
#[test]
fn an_array_is_never_taken_for_an_object() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    drives_and_map(at);
    expect(
        at,
        &["map", "mapping", "--method", "landmarks", "-o", "marks"],
    );
    std::fs::copy(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/site.json"),
        at.join("robot.json"),
    )
    .unwrap();
    std::fs::write(at.join("p.json"), "{}").unwrap();
    expect(at, &["transmit", "-o", "tx.wav", "--seconds", "1"]);
    let with_parameters = [&LOCALIZE[..], &["--parameters", "p.json"]].concat();
    let with_transmitted = [&LOCALIZE[..], &["--transmitted", "tx.json"]].concat();
    let among_landmarks = [
        "localize",
        "drive",
        "--map",
        "marks",
        "--method",
        "landmarks",
        "-o",
        "l.tum",
    ];
    let by_robot = [&SIMULATE[..], &["robots", "--robot", "robot.json"]].concat();
    let mut count = 0;
    for (file, command) in [
        ("drive/recording.json", LOCALIZE.to_vec()),
        ("map/map.json", LOCALIZE.to_vec()),
        ("p.json", with_parameters),
        ("tx.json", with_transmitted),
        ("marks/landmarks.json", among_landmarks.to_vec()),
        ("robot.json", by_robot),
        ("room.json", vec!["scene", "check", "room.json"]),
    ] {
        let path = at.join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        for other in ["[]", "null", "7", "\"x\"", "[1023, 1e4]"] {
            std::fs::write(&path, other).unwrap();
            let complaint = refuse(at, &command);
            assert!(complaint.contains(file), "{file} {other}: {complaint}");
            count += 1;
        }
        std::fs::write(&path, text).unwrap();
    }
    for (file, from, to, field) in [
        (
            "drive/recording.json",
            "\"start\": {",
            "\"start\": [1, 2, 3], \"provenance\": {",
            "start",
        ),
        (
            "robot.json",
            "\"speed_noise\": {",
            "\"speed_noise\": [0.1, 1.0], \"x\": {",
            "speed_noise",
        ),
        (
            "room.json",
            "\"name\": \"room\",",
            "\"name\": \"room\", \"waveform\": [],",
            "waveform",
        ),
        (
            "room.json",
            "\"name\": \"room\",",
            "\"name\": \"room\", \"medium\": [],",
            "medium",
        ),
    ] {
        let command = match file {
            "drive/recording.json" => LOCALIZE.to_vec(),
            "robot.json" => [&SIMULATE[..], &["robots", "--robot", "robot.json"]].concat(),
            _ => vec!["scene", "check", "room.json"],
        };
        let complaint = with(&at.join(file), from, to, || refuse(at, &command));
        assert!(
            complaint.contains(file) && complaint.contains(field),
            "{complaint}"
        );
        count += 1;
    }
    expect(at, &LOCALIZE);
    note(
        "wrong input",
        "arrays, numbers and texts for objects in JSON",
        count,
        "one line with file and field, exit 2",
    );
}

#[test]
fn numbers_of_the_command_line_and_of_parameters_have_bounds() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    drives_and_map(at);
    for command in [
        [&SIMULATE[..], &["new", "--threads", "100000"]].concat(),
        vec!["run", "layout", "--threads", "100000"],
        vec!["bench", "--threads", "100000"],
    ] {
        let output = echolot(at, &command);
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{complaint}");
        assert!(
            complaint.contains("--threads") && complaint.contains("1024"),
            "{complaint}"
        );
    }
    let particles = [
        "localize",
        "drive",
        "--map",
        "map",
        "-o",
        "e.tum",
        "--particles",
    ];
    for (count, word) in [("1000000000", "10 million"), ("10000000", "GB of memory")] {
        // The second fits into no machine's memory with windows of 4 m.
        let complaint = refuse(at, &[&particles[..], &[count]].concat());
        assert!(
            complaint.contains("particles") && complaint.contains(word),
            "{complaint}"
        );
    }
    for (text, field) in [
        ("{\"cell_m\": 1e-300}", "cell_m"),
        ("{\"cell_m\": \"wide\"}", "cell_m"),
        ("{\"max_range_m\": 1e300}", "max_range_m"),
        ("{\"min_range_m\": 20}", "min_range_m"),
        ("{\"directions\": 100000}", "directions"),
        ("{\"sigma_v_mps\": -1}", "sigma_v_mps"),
        ("{\"sensor_offset_m\": [0, \"left\"]}", "sensor_offset_m[1]"),
    ] {
        std::fs::write(at.join("p.json"), text).unwrap();
        let complaint = refuse(
            at,
            &["map", "mapping", "-o", "new", "--parameters", "p.json"],
        );
        let named = complaint.contains("p.json") || complaint.contains("parameters");
        assert!(named && complaint.contains(field), "{text}: {complaint}");
    }
    note(
        "wrong input",
        "command line, parameters",
        12,
        "one line with file and field, exit 2",
    );
}

/// Under 4 GB a million particles do not fit, and the program says so instead of dying.
#[cfg(target_os = "linux")]
#[test]
fn what_does_not_fit_into_limited_memory_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    drives_and_map(at);
    let limited = format!(
        "ulimit -v 4000000; exec {} localize drive --map map -o e.tum --particles 1000000",
        env!("CARGO_BIN_EXE_echolot")
    );
    let output = std::process::Command::new("sh")
        .current_dir(at)
        .args(["-c", &limited])
        .output()
        .unwrap();
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{complaint}");
    assert!(
        complaint.contains("particles") && complaint.contains("GB"),
        "{complaint}"
    );
    note(
        "wrong input",
        "a million particles under 4 GB",
        1,
        "one line with file and field, exit 2",
    );
}

#[test]
fn numbers_of_a_robot_have_bounds() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    let site = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/site.json");
    std::fs::copy(site, at.join("robot.json")).unwrap();
    let simulate = [&SIMULATE[..], &["drive", "--robot", "robot.json"]].concat();
    for (from, to, field) in [
        (
            "\"tracking_rate_hz\": 120.0",
            "\"tracking_rate_hz\": 1e300",
            "tracking_rate_hz",
        ),
        (
            "\"odometry_rate_hz\": 50.0",
            "\"odometry_rate_hz\": 1e9",
            "odometry_rate_hz",
        ),
        (
            "\"odometry_rate_hz\": 50.0",
            "\"odometry_rate_hz\": \"50\"",
            "odometry_rate_hz",
        ),
        (
            "\"odometry_rate_hz\": 50.0",
            "\"odometry_rate_hz\": 1e-9",
            "odometry_rate_hz",
        ),
        ("\"sigma\": 0.01", "\"sigma\": 1e200", "speed_noise.sigma"),
        (
            "\"drift_radpm\": 0.035",
            "\"drift_radpm\": 1e5",
            "drift_radpm",
        ),
    ] {
        let complaint = with(&at.join("robot.json"), from, to, || refuse(at, &simulate));
        assert!(
            complaint.contains("robot.json") && complaint.contains(field),
            "{complaint}"
        );
    }
    expect(at, &simulate);
    note(
        "wrong input",
        "robot file",
        6,
        "one line with file and field, exit 2",
    );
}

#[test]
fn simulate_accepts_what_the_check_accepts_and_refuses_what_it_refuses() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let both = |text: &str| -> [(Option<i32>, String); 2] {
        std::fs::write(at.join("room.json"), text).unwrap();
        [
            vec!["scene", "check", "room.json"],
            [&SIMULATE[..], &["out"]].concat(),
        ]
        .map(|command| {
            let output = echolot(at, &command);
            let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
            (output.status.code(), complaint)
        })
    };
    let waveform = |fields: &str| {
        ROOM.replace(
            "\"name\": \"room\",",
            &format!("\"name\": \"room\", \"waveform\": {{{fields}}},"),
        )
    };
    for chips in ["3", "127", "255", "262143"] {
        let [check, simulate] = both(&waveform(&format!("\"code_length\": {chips}")));
        assert_eq!(
            (check.0, simulate.0),
            (Some(0), Some(0)),
            "{chips}: {}",
            simulate.1
        );
        let signal = localizer::Recording::read(&at.join("out")).unwrap().signal;
        assert!(
            signal.iter().any(|sample| sample.abs() > 0.0),
            "{chips} chips are heard"
        );
    }
    for (fields, field) in [
        ("\"code_length\": 524287", "waveform.code_length"),
        ("\"code_length\": 1000", "waveform.code_length"),
        ("\"carrier_hz\": 0", "waveform.carrier_hz"),
        ("\"carrier_hz\": 1e-300", "waveform.carrier_hz"),
        ("\"carrier_hz\": 17000", "waveform.carrier_hz"),
        ("\"chip_rate_hz\": 1e-300", "waveform.chip_rate_hz"),
    ] {
        for (code, complaint) in both(&waveform(fields)) {
            assert_eq!(code, Some(2), "{fields}: {complaint}");
            assert!(
                complaint.contains("room.json") && complaint.contains(field),
                "{complaint}"
            );
            assert!(!complaint.contains("max_range"), "{complaint}");
        }
    }
    note(
        "wrong input",
        "scenes, checked and simulated",
        10,
        "the same answer of both",
    );
}

#[test]
fn walls_drawn_twice_sound_as_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let wall = "{\"points_m\": [[2.15, 0.6], [2.2, 2.0]], \"thickness_m\": 0.02}";
    let folded = "{\"points_m\": [[2.15, 0.6], [2.2, 2.0], [2.15, 0.6]], \"thickness_m\": 0.02}";
    assert!(ROOM.contains(wall));
    let signals = [
        wall.to_string(),
        format!("{wall}, {wall}"),
        folded.to_string(),
    ]
    .map(|walls| {
        std::fs::write(at.join("room.json"), ROOM.replace(wall, &walls)).unwrap();
        expect(at, &[&SIMULATE[..], &["out"]].concat());
        localizer::Recording::read(&at.join("out")).unwrap().signal
    });
    assert_eq!(signals[0], signals[1]);
    assert_eq!(signals[0], signals[2]);
    note(
        "wrong input",
        "walls drawn twice or folded back",
        2,
        "the sound of one",
    );
}
