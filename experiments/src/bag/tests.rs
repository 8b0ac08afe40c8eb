//! Bags that are written here, whole and cut off.

use super::written::{self, bag};
use super::*;

/// A bag of ten seconds: odometry and poses at 10 Hz, sound in pieces.
fn drive(truth: &str) -> Vec<u8> {
    let topics = [
        ("/odom", "nav_msgs/msg/Odometry"),
        ("/tracker", truth),
        ("/mic", "audio_common_msgs/msg/AudioData"),
    ];
    let messages = (0..100_i32).flat_map(|k| {
        let (seconds, nanoseconds) = (1_716_249_600 + k / 10, (k % 10) as u32 * 100_000_000);
        let time = (seconds, nanoseconds);
        let pose = [0.03 * f64::from(k), 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let sound: Vec<u8> = (0..960)
            .flat_map(|n: i32| ((k * 7 + n) as i16).to_le_bytes())
            .collect();
        let tracker = match truth {
            "geometry_msgs/msg/TransformStamped" => written::transform(time, &pose),
            _ => written::pose(time, &pose),
        };
        let log_ns = seconds as u64 * 1_000_000_000 + u64::from(nanoseconds);
        [
            (0, log_ns, written::odometry(time, &pose, 0.3, 0.01)),
            (1, log_ns, tracker),
            (2, log_ns, written::audio(&sound)),
        ]
    });
    bag(&topics, messages, true)
}

#[test]
fn a_bag_gives_logs_on_their_clocks_and_its_sound() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    std::fs::write(&path, drive("geometry_msgs/msg/PoseStamped")).unwrap();
    let whole = import(&path, &Topics::default()).unwrap();
    assert!(whole.warnings.is_empty(), "{:?}", whole.warnings);
    assert_eq!(
        whole.odometry.lines().nth(1),
        Some("1716249600.000000000,0.3,0.01")
    );
    assert_eq!(whole.odometry.lines().count(), 101);
    assert_eq!(
        whole.truth.as_ref().map(|text| text.lines().count()),
        Some(100)
    );
    assert_eq!(whole.audio.len(), 100 * 960 * 2);
    // The folder of a bag, too.
    assert_eq!(
        import(folder.path(), &Topics::default()).unwrap().odometry,
        whole.odometry
    );
    // Transforms of the robot are poses too.
    let transforms = drive("geometry_msgs/msg/TransformStamped");
    let by_transforms = read(&transforms, Path::new("t.mcap"), &Topics::default()).unwrap();
    assert_eq!(by_transforms.truth, whole.truth);
    // Cut off anywhere, it gives a beginning of that, or says what it is.
    let bytes = std::fs::read(&path).unwrap();
    for part in 1..20 {
        std::fs::write(&path, &bytes[..bytes.len() * part / 20]).unwrap();
        match import(&path, &Topics::default()) {
            Ok(cut) => {
                assert!(
                    whole.audio.starts_with(&cut.audio)
                        && whole.odometry.starts_with(&cut.odometry)
                );
                assert!(
                    cut.warnings
                        .iter()
                        .any(|warning| warning.contains("cut off")),
                    "{part}"
                );
            }
            Err(error) => assert!(format!("{error:#}").contains("drive.mcap"), "{error:#}"),
        }
    }
}

#[test]
fn other_bags_and_topics_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    let message = |path: &Path, topics: &Topics| format!("{:#}", import(path, topics).unwrap_err());
    std::fs::write(&path, b"nothing of the kind, and long enough").unwrap();
    assert!(message(&path, &Topics::default()).contains("no MCAP bag"));
    std::fs::write(&path, drive("geometry_msgs/msg/PoseStamped")).unwrap();
    let topics = Topics {
        truth: Some("/mocap".to_owned()),
        ..Topics::default()
    };
    assert!(message(&path, &topics).contains("/tracker"));
    let topics = Topics {
        audio: Some("/odom".to_owned()),
        ..Topics::default()
    };
    assert!(message(&path, &topics).contains("nav_msgs/msg/Odometry"));
    let sqlite = folder.path().join("old.db3");
    std::fs::write(&sqlite, b"SQLite format 3").unwrap();
    assert!(message(&sqlite, &Topics::default()).contains("rosbags-convert"));
}
