//! Messages of an MCAP file, one after the other; a file that is cut off ends where it ends.

use std::collections::BTreeMap;
use std::io::Read;

use anyhow::{Context, Result, bail};
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

/// Longest record, in bytes.
const LONGEST: usize = 1 << 28;

/// A message with its topic and type.
pub(super) struct Message<'a> {
    pub(super) topic: &'a str,
    pub(super) schema: &'a str,
    pub(super) log_s: f64,
    pub(super) data: &'a [u8],
}

/// What is known of the file's channels.
#[derive(Default)]
struct Channels {
    schemas: BTreeMap<u16, String>,
    /// Topic and type.
    channels: BTreeMap<u16, (String, String)>,
}

/// Topics with their types, as far as the file goes.
pub(super) fn topics(file: &mut dyn Read) -> Result<BTreeMap<String, String>> {
    let mut channels = Channels::default();
    walk(file, &mut channels, &mut |_| Ok(()))?;
    Ok(channels.channels.into_values().collect())
}

/// Hands on every message. What was wrong with a file that is cut off comes back.
pub(super) fn each_message(
    file: &mut dyn Read,
    each: &mut dyn FnMut(&Message<'_>) -> Result<()>,
) -> Result<Option<String>> {
    walk(file, &mut Channels::default(), each)
}

fn walk(
    file: &mut dyn Read,
    channels: &mut Channels,
    each: &mut dyn FnMut(&Message<'_>) -> Result<()>,
) -> Result<Option<String>> {
    let options = LinearReaderOptions::default().with_record_length_limit(LONGEST);
    let mut reader = LinearReader::new_with_options(options);
    let mut records = 0_u64;
    while let Some(event) = reader.next_event() {
        let record = match event {
            Ok(LinearReadEvent::ReadRequest(count)) => {
                let read = file.read(reader.insert(count))?;
                reader.notify_read(read);
                continue;
            }
            Ok(LinearReadEvent::Record { data, opcode }) => mcap::parse_record(opcode, data),
            Err(error) => Err(error),
        };
        let record = match record {
            Ok(record) => record,
            Err(error) if records == 0 => bail!("is no MCAP bag: {error}"),
            Err(error) => return Ok(Some(error.to_string())),
        };
        records += 1;
        match record {
            Record::Schema { header, .. } => {
                channels.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let schema = channels
                    .schemas
                    .get(&channel.schema_id)
                    .cloned()
                    .unwrap_or_default();
                channels
                    .channels
                    .insert(channel.id, (channel.topic, schema));
            }
            Record::Message { header, data } => {
                let (topic, schema) = channels
                    .channels
                    .get(&header.channel_id)
                    .context("a message has no channel")?;
                each(&Message {
                    topic,
                    schema,
                    log_s: 1e-9 * header.log_time as f64,
                    data: &data,
                })?;
            }
            _ => {}
        }
    }
    Ok(None)
}
