//! `import` from end to end: the example's files as a bag are the example again.

#[path = "../../src/bag/written.rs"]
mod written;

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::room::{expect, refuse};

fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/site_robot")
}

/// Rows of numbers of a text, without its header.
fn rows(path: &Path, separator: char) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    let numbers = |line: &str| line.split(separator).map(|x| x.parse().ok()).collect();
    text.lines().filter_map(numbers).collect()
}

/// Seconds and nanoseconds.
fn stamp(t_s: f64) -> (i32, u32) {
    (t_s as i32, (t_s.fract() * 1e9) as u32)
}

/// The drive of the example as a bag, its truth by messages of a type.
fn bag(truth: &str) -> Vec<u8> {
    let drive = example().join("drive");
    let topics = [
        ("/odom", "nav_msgs/msg/Odometry"),
        ("/tracker", truth),
        ("/mic", "audio_common_msgs/msg/AudioData"),
    ];
    let ns = |t_s: f64| 1_716_249_600_000_000_000 + (1e9 * t_s) as u64;
    let odometry = rows(&drive.join("odometry.csv"), ',')
        .into_iter()
        .map(|row| {
            let pose = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
            let message = written::odometry(stamp(row[0]), &pose, row[1], row[2]);
            (0, ns(row[0] - 731.0), message)
        });
    let poses = rows(&drive.join("truth.tum"), ' ').into_iter().map(|row| {
        let pose: [f64; 7] = row[1..].try_into().unwrap();
        let message = match truth {
            "geometry_msgs/msg/PoseStamped" => written::pose(stamp(row[0]), &pose),
            _ => written::transform(stamp(row[0]), &pose),
        };
        (1, (1e9 * row[0]) as u64, message)
    });
    let sound = std::fs::read(drive.join("signal.wav")).unwrap()[44..].to_vec();
    let pieces: Vec<_> = (sound.chunks(4096).enumerate())
        .map(|(k, piece)| (2, ns(0.021 * k as f64), written::audio(piece)))
        .collect();
    written::bag(&topics, odometry.chain(poses).chain(pieces), true)
}

#[test]
fn a_bag_of_the_example_localizes_as_the_example() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    expect(at, &["transmit", "-o", "tx.wav", "--seconds", "1"]);
    let mapping = example().join("mapping").display().to_string();
    expect(at, &["map", &mapping, "-o", "map"]);
    let mae_m = |drive: &str| -> f64 {
        let localize = ["localize", drive, "--map", "map", "--window", "3"];
        let report = expect(at, &[&localize[..], &["-o", "e.tum", "--json"]].concat());
        let report: Value = serde_json::from_str(&report).unwrap();
        assert_eq!(report["coverage"], 1.0, "{report}");
        report["mae_m"].as_f64().unwrap()
    };
    let original = mae_m(&example().join("drive").display().to_string());
    for (number, truth) in [
        "geometry_msgs/msg/PoseStamped",
        "geometry_msgs/msg/TransformStamped",
    ]
    .into_iter()
    .enumerate()
    {
        let (file, output) = (format!("{number}.mcap"), format!("drive_{number}"));
        std::fs::write(at.join(&file), bag(truth)).unwrap();
        let import = ["import", &file, "-o", &output, "--transmitted", "tx.json"];
        let sound = [
            "--rate",
            "48000",
            "--channels",
            "2",
            "--speed-of-sound",
            "340",
        ];
        let report = expect(at, &[&import[..], &sound, &["--json"]].concat());
        let report: Value = serde_json::from_str(&report).unwrap();
        assert_eq!(
            (&report["odometry"], &report["warnings"]),
            (&json!(721), &json!([]))
        );
        let path = at.join(&output).join("recording.json");
        let mut meta: Value =
            serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let original_meta =
            std::fs::read_to_string(example().join("drive/recording.json")).unwrap();
        let original_meta: Value = serde_json::from_str(&original_meta).unwrap();
        meta["microphone_offset_m"] = original_meta["microphone_offset_m"].clone();
        std::fs::write(&path, meta.to_string()).unwrap();
        let imported = mae_m(&output);
        assert!(
            (imported - original).abs() < 5e-4,
            "{imported} m, {original} m"
        );
        // Edited by hand, it is not the program's own any more.
        assert!(refuse(at, &[&import[..], &sound].concat()).contains("--force"));
    }
}

/// Folders as audioROS and trajectoRIR have them: sound and poses in subfolders, times in milliseconds, rows of other
/// sensors between.
#[test]
fn folders_of_sound_and_poses_are_imported() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let drive = example().join("drive");
    let truth = localizer::Trajectory::read_tum(&drive.join("truth.tum")).unwrap();
    expect(at, &["transmit", "-o", "tx.wav", "--seconds", "1"]);
    let mapping = example().join("mapping").display().to_string();
    expect(at, &["map", &mapping, "-o", "map"]);
    let first_s = truth.t_s[0];
    for (name, sound, table) in [
        ("audioROS", "export/drive.wav", "csv_files/drive.csv"),
        (
            "trajectoRIR",
            "audio/MOV/PS/SL1/MC3/V1/M1.wav",
            "meta/cart_pose.csv",
        ),
    ] {
        let own = at.join(name);
        for file in [sound, table] {
            std::fs::create_dir_all(own.join(file).parent().unwrap()).unwrap();
        }
        std::fs::copy(drive.join("signal.wav"), own.join(sound)).unwrap();
        let mut text = match name {
            // As its csv_writer sorts the fields of its messages.
            "audioROS" => "audio_timestamp,frequencies,index,mic_positions,n_frequencies,n_mics,signals_imag_vect,\
                signals_real_vect,timestamp,topic,vx,vy,x,y,yaw_deg,yaw_rate_deg,z\n"
                .to_string(),
            _ => "Time;X;Y;Theta\n".to_string(),
        };
        for (k, (t_s, pose)) in truth.t_s.iter().zip(&truth.poses).enumerate() {
            let t_s = t_s - first_s;
            text += &match name {
                "audioROS" => format!(
                    ",,{k},,,,,,{},geometry/pose_raw,,,{},{},{},,0.4\n9,\"[ 187\n  406]\",{k},[0.054 -0.054],2,1,\
                    \"[1\n2]\",\"[3\n4]\",{},audio/signals_f,,,,,,,\n",
                    1e3 * t_s,
                    pose.x_m,
                    pose.y_m,
                    pose.heading_rad.to_degrees(),
                    1e3 * t_s + 1.0,
                ),
                _ => format!("{t_s};{};{};{}\n", pose.x_m, pose.y_m, pose.heading_rad),
            };
        }
        std::fs::write(own.join(table), text).unwrap();
        let mut import = vec![
            "import",
            name,
            "-o",
            "imported",
            "--force",
            "--transmitted",
            "tx.json",
        ];
        if name == "audioROS" {
            import.extend(["--time-unit", "ms"]);
        }
        let report: Value =
            serde_json::from_str(&expect(at, &[&import[..], &["--json"]].concat())).unwrap();
        assert_eq!(report["poses"], truth.len());
        assert!(
            report["warnings"].to_string().contains("made of the poses"),
            "{report}"
        );
        let path = at.join("imported/recording.json");
        let mut meta: Value =
            serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        meta["microphone_offset_m"] = json!([0.1, 0.0]);
        meta["speed_of_sound_mps"] = json!(340.0);
        std::fs::write(&path, meta.to_string()).unwrap();
        let localize = [
            "localize", "imported", "--map", "map", "--window", "3", "-o", "e.tum",
        ];
        let report: Value =
            serde_json::from_str(&expect(at, &[&localize[..], &["--json"]].concat())).unwrap();
        assert!(report["mae_m"].as_f64().unwrap() < 0.03, "{name}: {report}");
        // Two sounds: one has to be named.
        std::fs::copy(own.join(sound), own.join("other.wav")).unwrap();
        assert!(refuse(at, &import).contains("--sound"));
        expect(
            at,
            &[&import[..], &["--sound", sound, "--poses", table]].concat(),
        );
    }
    std::fs::write(
        at.join("audioROS/steps.csv"),
        "timestamp,dx,dy,yaw_deg\n1,0,4,-6\n",
    )
    .unwrap();
    let steps = [
        "import",
        "audioROS",
        "-o",
        "s",
        "--sound",
        "other.wav",
        "--poses",
        "steps.csv",
    ];
    assert!(refuse(at, &steps).contains("column of x"));
}
