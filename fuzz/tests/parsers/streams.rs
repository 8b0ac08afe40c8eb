//! What comes as a stream or in a bag.

use std::path::Path;

use experiments::bag::{self, Topics, cdr, folder};
use experiments::live::{lines, pcm};
use localizer::Trajectory;
use localizer::io::odometry_csv;

use crate::harness::{corpus, fuzz, line};
use crate::written;

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

/// Tables of poses of a folder that is imported.
#[test]
fn table_of_poses() {
    let seeds = [
        "t,x,y,yaw_deg,note\n0,1,2,30,\"a, b\"\n1.5,1.25,2,31,\n2,1.5,2,32,\n",
        "Time;X;Y;qx;qy;qz;qw\n0;1;2;0;0;0.6;0.8\n0.1;1;2;0;0;0.6;0.8\n",
        "timestamp,vx,x,y,yaw_deg,yaw_rate_deg\n0,0.2,1,2,30,-5\n1,,,,,\n2,0.25,1.25,2,31,4\n",
    ];
    let seeds = seeds.map(|seed| seed.as_bytes().to_vec()).to_vec();
    fuzz("table of poses", seeds, |bytes| {
        let text = String::from_utf8_lossy(bytes);
        if let Some(table) = line(folder::parse(&text, "poses.csv", 1.0)) {
            let path = &table.path;
            assert!(path.t_s.is_sorted_by(|a, b| a < b));
            let length_s = path.t_s[path.t_s.len() - 1] - path.t_s[0];
            if length_s < 1e3 {
                line(odometry_csv::parse(&table.odometry(), "odometry"));
            }
            let warnings = table.warnings();
            assert!(
                warnings
                    .iter()
                    .all(|own| own.lines().count() == 1 && own.len() < 500)
            );
        }
    });
}
