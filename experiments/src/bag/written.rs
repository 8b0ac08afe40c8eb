//! Bags and messages written for tests.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::Arc;

/// Writes values as a little-endian message.
#[derive(Default)]
pub(crate) struct Writer(Vec<u8>);

impl Writer {
    pub(crate) fn bytes<const N: usize>(mut self, bytes: [u8; N]) -> Self {
        self.0.resize(self.0.len().next_multiple_of(N), 0);
        self.0.extend(bytes);
        self
    }

    pub(crate) fn sequence(self, bytes: &[u8]) -> Self {
        let mut own = self.bytes((bytes.len() as u32).to_le_bytes());
        own.0.extend(bytes);
        own
    }

    pub(crate) fn header(self, seconds: i32, nanoseconds: u32) -> Self {
        let own = self
            .bytes(seconds.to_le_bytes())
            .bytes(nanoseconds.to_le_bytes());
        own.sequence(b"map\0")
    }

    pub(crate) fn numbers(self, numbers: &[f64]) -> Self {
        numbers
            .iter()
            .fold(self, |own, number| own.bytes(number.to_le_bytes()))
    }

    pub(crate) fn message(self) -> Vec<u8> {
        [vec![0, 1, 0, 0], self.0].concat()
    }
}

/// nav_msgs/Odometry of a pose `[x, y, z, qx, qy, qz, qw]` and speeds.
pub(crate) fn odometry(time: (i32, u32), pose: &[f64; 7], v_mps: f64, omega_radps: f64) -> Vec<u8> {
    Writer::default()
        .header(time.0, time.1)
        .sequence(b"base\0")
        .numbers(pose)
        .numbers(&[0.0; 36])
        .numbers(&[v_mps, 0.0, 0.0, 0.0, 0.0, omega_radps])
        .numbers(&[0.0; 36])
        .message()
}

/// geometry_msgs/PoseStamped.
pub(crate) fn pose((seconds, nanoseconds): (i32, u32), pose: &[f64; 7]) -> Vec<u8> {
    let writer = Writer::default().header(seconds, nanoseconds);
    writer.numbers(pose).message()
}

/// geometry_msgs/TransformStamped.
pub(crate) fn transform((seconds, nanoseconds): (i32, u32), pose: &[f64; 7]) -> Vec<u8> {
    let writer = Writer::default().header(seconds, nanoseconds);
    writer.sequence(b"robot\0").numbers(pose).message()
}

/// audio_common_msgs/AudioData.
pub(crate) fn audio(samples: &[u8]) -> Vec<u8> {
    Writer::default().sequence(samples).message()
}

/// An MCAP file: topics with their types, and messages of a topic's number, a time in nanoseconds, and bytes.
pub(crate) fn bag(
    topics: &[(&str, &str)],
    messages: impl IntoIterator<Item = (usize, u64, Vec<u8>)>,
    in_chunks: bool,
) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new()
        .use_chunks(in_chunks)
        .compression(None);
    let mut writer = options.create(&mut bytes).unwrap();
    let channels: Vec<Arc<mcap::Channel<'_>>> = (1..)
        .zip(topics)
        .map(|(id, (topic, schema))| {
            Arc::new(mcap::Channel {
                id,
                topic: (*topic).to_owned(),
                schema: Some(Arc::new(mcap::Schema {
                    id,
                    name: (*schema).to_owned(),
                    encoding: "ros2msg".to_owned(),
                    data: Cow::Borrowed(b""),
                })),
                message_encoding: "cdr".to_owned(),
                metadata: BTreeMap::new(),
            })
        })
        .collect();
    for (sequence, (topic, log_time, data)) in (0..).zip(messages) {
        writer
            .write(&mcap::Message {
                channel: channels[topic].clone(),
                sequence,
                log_time,
                publish_time: log_time,
                data: Cow::Owned(data),
            })
            .unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}
