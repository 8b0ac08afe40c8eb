//! No command replaces what it did not write, its inputs, or what is no regular file; an output's place is checked
//! before anything is computed.

use std::path::Path;

use crate::room::{
    ROOM, SIMULATE, drives, drives_and_map, echolot, expect, note, quick_scene, refuse, scene_file,
};

/// Runs `echolot`, which may succeed or not, and tells what it said.
fn said(at: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = echolot(at, arguments);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), text)
}

#[test]
fn a_recording_written_by_hand_stays() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    expect(at, &[&SIMULATE[..], &["mine"]].concat());
    // The program's own is replaced, and changed by hand it is not its own any more.
    expect(at, &[&SIMULATE[..], &["mine"]].concat());
    let changes: [(&str, &dyn Fn()); 3] = [
        ("truth.tum", &|| {
            let file = at.join("mine/truth.tum");
            let text = std::fs::read_to_string(&file).unwrap();
            std::fs::write(&file, format!("# tracked again\n{text}")).unwrap();
        }),
        ("notes.txt", &|| {
            std::fs::write(at.join("mine/notes.txt"), "x").unwrap()
        }),
        ("odometry.csv", &|| {
            std::fs::remove_file(at.join("mine/manifest.json")).unwrap()
        }),
    ];
    for (name, change) in changes {
        change();
        let before = std::fs::read(at.join("mine").join(name)).unwrap();
        let complaint = refuse(at, &[&SIMULATE[..], &["mine"]].concat());
        assert!(
            complaint.contains("mine") && complaint.contains("--force"),
            "{complaint}"
        );
        assert_eq!(std::fs::read(at.join("mine").join(name)).unwrap(), before);
        expect(at, &[&SIMULATE[..], &["mine", "--force"]].concat());
        expect(at, &[&SIMULATE[..], &["mine"]].concat());
    }
    // A scene inside of the folder is an input, which no force replaces.
    std::fs::copy(at.join("room.json"), at.join("mine/room.json")).unwrap();
    let mut inside = SIMULATE.to_vec();
    inside[1] = "mine/room.json";
    let complaint = refuse(at, &[&inside[..], &["mine", "--force"]].concat());
    assert!(complaint.contains("mine/room.json"), "{complaint}");
    note(
        "output on a foreign file",
        "recordings",
        4,
        "refused, the file stays",
    );
}

#[test]
fn inputs_are_never_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    drives_and_map(at);
    let localize = |output: &'static str| {
        [
            "localize",
            "drive",
            "--map",
            "map",
            "--particles",
            "5",
            "--force",
            "-o",
            output,
        ]
    };
    std::fs::hard_link(at.join("map/map.npy"), at.join("linked.tum")).unwrap();
    for output in [
        "drive/truth.tum",
        "map/map.json",
        "drive/../drive/direct.wav",
        "linked.tum",
    ] {
        let kept = std::fs::read(at.join(output)).ok();
        let complaint = refuse(at, &localize(output));
        assert!(complaint.contains("is read by this command"), "{complaint}");
        assert_eq!(std::fs::read(at.join(output)).ok(), kept);
    }
    let complaint = refuse(
        at,
        &["scene", "draw", "room.json", "-o", "room.json", "--force"],
    );
    assert!(complaint.contains("is read by this command"), "{complaint}");
    assert_eq!(std::fs::read_to_string(at.join("room.json")).unwrap(), ROOM);
    // What another command wrote needs force, what this one wrote does not.
    let plain = |output: &'static str| {
        [
            "localize",
            "drive",
            "--map",
            "map",
            "--particles",
            "5",
            "-o",
            output,
        ]
    };
    std::fs::write(at.join("thesis.tum"), "0 0 0 0 0 0 0 1\n").unwrap();
    for output in ["thesis.tum", "map/map.pgm"] {
        assert!(refuse(at, &plain(output)).contains("--force"));
    }
    for _ in 0..2 {
        expect(at, &plain("new/folder/drive.tum"));
    }
    note(
        "output on an input",
        "localize, scene draw",
        5,
        "refused, the file stays",
    );
}

#[test]
fn a_map_made_by_another_program_stays() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    drives(at);
    std::fs::create_dir(at.join("lab")).unwrap();
    for name in ["map.yaml", "map.pgm"] {
        std::fs::write(at.join("lab").join(name), "by hand").unwrap();
    }
    let complaint = refuse(at, &["map", "mapping", "-o", "lab"]);
    assert!(complaint.contains("map.pgm"), "{complaint}");
    expect(at, &["map", "mapping", "-o", "lab", "--force"]);
    expect(at, &["map", "mapping", "-o", "lab"]);
    // An occupancy picture that somebody has cleaned is not this program's any more.
    std::fs::write(at.join("lab/map.pgm"), "cleaned").unwrap();
    assert!(refuse(at, &["map", "mapping", "-o", "lab"]).contains("map.pgm"));
    // Other files of the folder are left alone.
    std::fs::write(at.join("lab/notes.txt"), "mine").unwrap();
    expect(at, &["map", "mapping", "-o", "lab", "--force"]);
    assert_eq!(std::fs::read(at.join("lab/notes.txt")).unwrap(), b"mine");
    note(
        "output on a foreign file",
        "maps",
        2,
        "refused, the file stays",
    );
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_never_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    drives_and_map(at);
    let made = std::process::Command::new("mkfifo")
        .arg(at.join("pipe"))
        .status();
    assert!(made.unwrap().success());
    std::os::unix::fs::symlink(at.join("mapping/odometry.csv"), at.join("link")).unwrap();
    std::os::unix::fs::symlink("/dev/null", at.join("null")).unwrap();
    std::os::unix::fs::symlink(at.join("map"), at.join("way")).unwrap();
    let kind = |name: &str| {
        std::fs::symlink_metadata(at.join(name))
            .unwrap()
            .file_type()
    };
    for name in ["pipe", "link", "null", "way", "map"] {
        let before = kind(name);
        for command in [
            vec!["localize", "drive", "--map", "map", "-o", name, "--force"],
            vec!["scene", "draw", "room.json", "-o", name, "--force"],
            vec![
                "scene", "random", "--kind", "room", "--seed", "1", "-o", name, "--force",
            ],
            vec!["reference", "-o", name, "--force"],
        ] {
            let complaint = refuse(at, &command);
            assert!(
                complaint.contains(name) && complaint.contains("stays as it is"),
                "{complaint}"
            );
        }
        if name != "map" {
            let complaint = refuse(at, &[&SIMULATE[..], &[name, "--force"]].concat());
            assert!(complaint.contains("stays as it is"), "{complaint}");
        }
        assert_eq!(kind(name), before);
    }
    note(
        "output on what is no regular file",
        "pipe, links, device, folder",
        24,
        "refused, it stays",
    );
}

#[test]
fn a_place_that_cannot_be_written_is_found_before_computing() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    std::fs::write(at.join("file"), "x").unwrap();
    let complaint = refuse(
        at,
        &[
            "simulate",
            "room.json",
            "--path",
            "mapping",
            "-o",
            "file/recording",
        ],
    );
    assert!(complaint.contains("file/recording"), "{complaint}");
    expect(at, &[&SIMULATE[..], &["new/folders/recording"]].concat());
    let every = ["--snapshots", "pictures", "--every", "50"];
    let complaint = refuse(
        at,
        &[
            &["simulate", "room.json", "--path", "short", "-o", "r"][..],
            &every,
        ]
        .concat(),
    );
    assert!(
        complaint.contains("--every: 50 s is longer than the drive"),
        "{complaint}"
    );
    assert!(!at.join("r").exists() && !at.join("pictures").exists());
    std::fs::write(at.join("r.checkpoint"), "what I checked").unwrap();
    let complaint = refuse(at, &["simulate", "room.json", "--path", "short", "-o", "r"]);
    assert!(complaint.contains("r.checkpoint"), "{complaint}");
    note(
        "unwritable output",
        "simulate",
        3,
        "refused before computing",
    );
}

/// The place turns out to be taken while the field is simulated.
#[test]
fn an_output_that_cannot_be_written_at_the_end_leaves_the_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    let simulate = ["simulate", "room.json", "--path", "short", "-o", "late"];
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_echolot"))
        .current_dir(at)
        .args(simulate)
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut stderr = std::io::BufReader::new(child.stderr.take().unwrap());
    let mut text = String::new();
    // It tells its plan when the place is checked.
    std::io::BufRead::read_line(&mut stderr, &mut text).unwrap();
    std::fs::write(at.join("late"), "in the way").unwrap();
    std::io::Read::read_to_string(&mut stderr, &mut text).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(2), "{text}");
    assert!(text.contains("--resume"), "{text}");
    assert_eq!(std::fs::read(at.join("late")).unwrap(), b"in the way");
    std::fs::remove_file(at.join("late")).unwrap();
    expect(at, &[&simulate[..], &["--resume"]].concat());
    let whole = ["simulate", "room.json", "--path", "short", "-o", "whole"];
    expect(at, &whole);
    let signal = |of: &str| std::fs::read(at.join(of).join("signal.wav")).unwrap();
    assert_eq!(signal("late"), signal("whole"));
    assert!(!at.join("late.checkpoint").exists());
    note(
        "unwritable output",
        "simulate, at its end",
        1,
        "the checkpoint is left",
    );
}

#[test]
fn what_a_killed_program_left_does_not_outlive_the_next_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    drives_and_map(at);
    // The name of a temporary file of this machine, whose process has ended.
    let own = localizer::io::temporary::name_beside(&at.join("x"));
    let own = own.file_name().unwrap().to_string_lossy().into_owned();
    let left = own.replace(
        &format!("-{}-", std::process::id()),
        &format!("-{}-", i32::MAX),
    );
    for place in ["", "map"] {
        std::fs::write(at.join(place).join(&left), "half").unwrap();
    }
    expect(at, &["map", "mapping", "-o", "map"]);
    assert!(!at.join(&left).exists() && !at.join("map").join(&left).exists());
    std::fs::write(at.join(&left), "half").unwrap();
    expect(
        at,
        &[
            "localize",
            "drive",
            "--map",
            "map",
            "--particles",
            "5",
            "-o",
            "e.tum",
        ],
    );
    assert!(!at.join(&left).exists());
}

#[test]
fn a_damaged_entry_of_the_cache_is_made_anew_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    quick_scene(at);
    let run = |results: &'static str| {
        let quick = [
            "run",
            "quick.json",
            "--only",
            "odometry-drift",
            "--cache",
            "cache",
            "--no-figures",
        ];
        let how = ["--engine", "image-source", "--results", results];
        let (code, text) = said(at, &[&quick[..], &how].concat());
        assert_eq!(code, Some(0), "{text}");
        text
    };
    let drift = |results: &str| {
        let file = at.join(results).join("quick/summary.json");
        let summary: serde_json::Value =
            serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
        summary["odometry_drift"].clone()
    };
    assert!(!run("first").contains("damaged"));
    assert!(!run("first").contains("damaged"));
    let entries = |kind: &str| -> Vec<std::path::PathBuf> {
        let folder = std::fs::read_dir(at.join("cache").join(kind)).unwrap();
        folder.map(|entry| entry.unwrap().path()).collect()
    };
    // A number of a trial, and one sample of every recording.
    let trial = &entries("trials")[0];
    let text = std::fs::read_to_string(trial).unwrap();
    let place = text.find("\"error_m\":[0.").unwrap() + "\"error_m\":[0.".len();
    let other = if text.as_bytes()[place] == b'9' {
        "8"
    } else {
        "9"
    };
    std::fs::write(
        trial,
        format!("{}{other}{}", &text[..place], &text[place + 1..]),
    )
    .unwrap();
    assert!(run("second").contains("trials"), "a trial is made anew");
    for recording in entries("recordings") {
        let wav = recording.join("signal.wav");
        let mut bytes = std::fs::read(&wav).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle..middle + 400].fill(0);
        std::fs::write(&wav, bytes).unwrap();
    }
    for trial in entries("trials") {
        std::fs::remove_file(trial).unwrap();
    }
    let text = run("third");
    assert_eq!(
        text.matches("is damaged and made anew").count(),
        2,
        "{text}"
    );
    assert_eq!(drift("first"), drift("second"));
    assert_eq!(drift("first"), drift("third"));
    note(
        "damaged cache",
        "a trial, two recordings",
        3,
        "made anew and told",
    );
}

#[test]
fn a_baseline_of_nothing_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    quick_scene(at);
    std::fs::create_dir_all(at.join("results/quick")).unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let summary = root.join("results/quick/summary.json");
    std::fs::copy(&summary, at.join("results/quick/summary.json")).unwrap();
    let good = std::fs::read_to_string(root.join("experiments/baselines/quick.json")).unwrap();
    let check = |text: &str| {
        std::fs::write(at.join("b.json"), text).unwrap();
        said(at, &["check", "quick.json", "--baseline", "b.json"])
    };
    assert_eq!(check(&good).0, Some(0));
    for (text, word) in [
        (
            r#"{"name": "quick", "commit": "x", "measures": []}"#.to_string(),
            "measures",
        ),
        (good.replace("\"quick\"", "\"paper\""), "name"),
        (
            good.replacen("\"mae_m\": 0", "\"mae_m\": 1e9", 1),
            "measures[0]",
        ),
        (
            good.replacen("\"mae_m\": 0", "\"mae_m\": -7", 1),
            "measures[0]",
        ),
        (
            good.replacen("\"mae_m\": 0.", "\"mae_m\": \"x\", \"y\": 0.", 1),
            "measures[0].mae_m",
        ),
        ("[]".into(), "the file"),
        (String::new(), "the file"),
    ] {
        let (code, complaint) = check(&text);
        assert_eq!(code, Some(2), "{complaint}");
        assert!(
            complaint.contains("b.json") && complaint.contains(word),
            "{complaint}"
        );
    }
    // Blessing never takes the place of another file.
    std::fs::write(at.join("notes.json"), "{}").unwrap();
    let bless = ["check", "quick.json", "--bless", "--baseline"];
    for baseline in ["notes.json", "results/quick/summary.json"] {
        refuse(at, &[&bless[..], &[baseline]].concat());
    }
    let (code, text) = said(at, &[&bless[..], &["new.json"]].concat());
    assert_eq!(code, Some(0), "{text}");
    note(
        "wrong input",
        "baseline",
        9,
        "one line with file and field, exit 2",
    );
}
