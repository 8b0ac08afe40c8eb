//! Messages of an MCAP file, one after the other; a file that is cut off ends where it ends.

use std::collections::BTreeMap;
use std::io::Read;

use anyhow::{Context, Result, bail};
use mcap::records::op;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

/// Longest record, in bytes, and how many times as long as its file it may be: chunks are compressed.
const LONGEST: usize = 1 << 28;
const LONGER_THAN_FILE: usize = 64;

/// Longest name of a topic or type, in bytes.
const LONGEST_NAME: usize = 250;

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

/// Topics with their types, as far as a file of a length in bytes goes.
pub(super) fn topics((file, length): (&mut dyn Read, usize)) -> Result<BTreeMap<String, String>> {
    let mut channels = Channels::default();
    walk((file, length), &mut channels, &mut |_| Ok(()))?;
    Ok(channels.channels.into_values().collect())
}

/// Hands on every message. What was wrong with a file that is cut off comes back.
pub(super) fn each_message(
    file: (&mut dyn Read, usize),
    each: &mut dyn FnMut(&Message<'_>) -> Result<()>,
) -> Result<Option<String>> {
    walk(file, &mut Channels::default(), each)
}

fn walk(
    (file, length): (&mut dyn Read, usize),
    channels: &mut Channels,
    each: &mut dyn FnMut(&Message<'_>) -> Result<()>,
) -> Result<Option<String>> {
    let longest = LONGEST.min(length.saturating_mul(LONGER_THAN_FILE));
    let options = LinearReaderOptions::default().with_record_length_limit(longest);
    let mut reader = LinearReader::new_with_options(options);
    let mut records = 0_u64;
    while let Some(event) = reader.next_event() {
        let record = match event {
            Ok(LinearReadEvent::ReadRequest(count)) => {
                let read = file.read(reader.insert(count))?;
                reader.notify_read(read);
                continue;
            }
            Ok(LinearReadEvent::Record { data, opcode }) => {
                Record::parse(opcode, data).ok_or_else(|| "a record is damaged".to_string())
            }
            Err(error) => Err(error.to_string()),
        };
        let record = match record {
            Ok(record) => record,
            Err(problem) if records == 0 => bail!("is no MCAP bag: {problem}"),
            Err(problem) => return Ok(Some(problem)),
        };
        records += 1;
        match record {
            Record::Schema { id, name } => {
                channels.schemas.insert(id, name.to_owned());
            }
            Record::Channel { id, schema, topic } => {
                let schema = channels.schemas.get(&schema).cloned().unwrap_or_default();
                channels.channels.insert(id, (topic.to_owned(), schema));
            }
            Record::Message {
                channel,
                log_ns,
                data,
            } => {
                let (topic, schema) = channels
                    .channels
                    .get(&channel)
                    .context("a message has no channel")?;
                each(&Message {
                    topic,
                    schema,
                    log_s: 1e-9 * log_ns as f64,
                    data,
                })?;
            }
            Record::Other => {}
        }
    }
    Ok(None)
}

/// What is needed of a record. The crate's own parser asks for as much memory as a damaged length says.
enum Record<'a> {
    Schema {
        id: u16,
        name: &'a str,
    },
    Channel {
        id: u16,
        schema: u16,
        topic: &'a str,
    },
    Message {
        channel: u16,
        log_ns: u64,
        data: &'a [u8],
    },
    Other,
}

impl<'a> Record<'a> {
    /// Reads a record; none for one that is cut off.
    fn parse(opcode: u8, data: &'a [u8]) -> Option<Self> {
        let mut rest = data;
        match opcode {
            op::SCHEMA => Some(Self::Schema {
                id: u16::from_le_bytes(take(&mut rest)?),
                name: text(&mut rest)?,
            }),
            op::CHANNEL => Some(Self::Channel {
                id: u16::from_le_bytes(take(&mut rest)?),
                schema: u16::from_le_bytes(take(&mut rest)?),
                topic: text(&mut rest)?,
            }),
            op::MESSAGE => {
                let channel = u16::from_le_bytes(take(&mut rest)?);
                let _number: [u8; 4] = take(&mut rest)?;
                let log_ns = u64::from_le_bytes(take(&mut rest)?);
                let _published: [u8; 8] = take(&mut rest)?;
                Some(Self::Message {
                    channel,
                    log_ns,
                    data: rest,
                })
            }
            _ => Some(Self::Other),
        }
    }
}

fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (first, after) = rest.split_first_chunk()?;
    *rest = after;
    Some(*first)
}

/// A name with its length before it.
fn text<'a>(rest: &mut &'a [u8]) -> Option<&'a str> {
    let length = u32::from_le_bytes(take(rest)?) as usize;
    let (first, after) = rest.split_at_checked(length)?;
    *rest = after;
    let name = std::str::from_utf8(first).ok()?;
    let is_name = name.len() <= LONGEST_NAME && !name.chars().any(char::is_control);
    is_name.then_some(name)
}
