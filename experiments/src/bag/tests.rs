//! Bags that are written here, whole and cut off.

use std::borrow::Cow;
use std::collections::BTreeMap as Map;
use std::sync::Arc;

use super::cdr::tests::Writer;
use super::*;

/// A bag of ten seconds: odometry and poses at 10 Hz, sound in pieces.
fn bag(path: &Path) {
    let mut writer = mcap::Writer::new(std::fs::File::create(path).unwrap()).unwrap();
    let channel = |id: u16, topic: &str, schema: &str| {
        let schema = Arc::new(mcap::Schema {
            id,
            name: schema.to_owned(),
            encoding: "ros2msg".to_owned(),
            data: Cow::Borrowed(b""),
        });
        Arc::new(mcap::Channel {
            id,
            topic: topic.to_owned(),
            schema: Some(schema),
            message_encoding: "cdr".to_owned(),
            metadata: Map::new(),
        })
    };
    let channels = [
        channel(1, "/odom", "nav_msgs/msg/Odometry"),
        channel(2, "/tracker", "geometry_msgs/msg/PoseStamped"),
        channel(3, "/mic", "audio_common_msgs/msg/AudioData"),
    ];
    for k in 0..100_i32 {
        let (seconds, nanoseconds) = (1_716_249_600 + k / 10, (k % 10) as u32 * 100_000_000);
        let pose = [0.03 * f64::from(k), 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let odometry = Writer::default()
            .header(seconds, nanoseconds)
            .sequence(b"base\0")
            .numbers(&pose)
            .numbers(&[0.0; 36])
            .numbers(&[0.3, 0.0, 0.0, 0.0, 0.0, 0.01])
            .numbers(&[0.0; 36])
            .message();
        let tracker = Writer::default()
            .header(seconds, nanoseconds)
            .numbers(&pose)
            .message();
        let sound: Vec<u8> = (0..960)
            .flat_map(|n: i32| ((k * 7 + n) as i16).to_le_bytes())
            .collect();
        let mic = Writer::default().sequence(&sound).message();
        for (channel, data) in channels.iter().zip([odometry, tracker, mic]) {
            let log_time = (i64::from(seconds) * 1_000_000_000) as u64 + u64::from(nanoseconds);
            writer
                .write(&mcap::Message {
                    channel: channel.clone(),
                    sequence: k as u32,
                    log_time,
                    publish_time: log_time,
                    data: Cow::Owned(data),
                })
                .unwrap();
        }
    }
    writer.finish().unwrap();
}

#[test]
fn a_bag_gives_logs_on_their_clocks_and_its_sound() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    bag(&path);
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
    bag(&path);
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
