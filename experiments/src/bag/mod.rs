//! ROS 2 bags (MCAP), and folders of a WAV and a table of poses, as recordings.

pub mod cdr;
pub mod folder;
mod messages;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use self::messages::{Message, each_message, topics};

/// Types of topics by what they are taken for.
const ODOMETRY: &[&str] = &["nav_msgs/msg/Odometry"];
const TRUTH: &[&str] = &[
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/TransformStamped",
];
const AUDIO: &[&str] = &["audio_common_msgs/msg/AudioData"];

/// Topics by name; the only one of a type unless given.
#[derive(Debug, Clone, Default)]
pub struct Topics {
    /// Wheel odometry, nav_msgs/Odometry.
    pub odometry: Option<String>,
    /// True poses, PoseStamped, TransformStamped or Odometry.
    pub truth: Option<String>,
    /// Sound, audio_common_msgs/AudioData.
    pub audio: Option<String>,
}

/// What a bag holds, in the form of a recording's files.
#[derive(Debug, Clone, Default)]
pub struct Imported {
    /// `odometry.csv`.
    pub odometry: String,
    /// `truth.tum`.
    pub truth: Option<String>,
    /// Bytes of the sound, as they are in the messages.
    pub audio: Vec<u8>,
    /// Time of the first message of sound in the bag, in seconds.
    pub audio_s: f64,
    /// What is to be told.
    pub warnings: Vec<String>,
}

/// The MCAP file of a bag: itself, or the one in its folder.
fn file_of(bag: &Path) -> Result<PathBuf> {
    let with_end = |end: &str| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(bag).into_iter().flatten().flatten();
        let paths = entries.map(|entry| entry.path());
        paths
            .filter(|path| path.extension().is_some_and(|own| own == end))
            .collect()
    };
    let sqlite = "is a bag of sqlite3; convert it: `rosbags-convert --src BAG --dst NEW --dst-storage mcap`, or \
        `ros2 bag convert`";
    if bag.is_dir() {
        let mut files = with_end("mcap");
        files.sort();
        return match files.as_slice() {
            [file] => Ok(file.clone()),
            [] if !with_end("db3").is_empty() => bail!("{}: {sqlite}", bag.display()),
            [] => bail!("{}: has no .mcap file; give a bag", bag.display()),
            _ => bail!(
                "{}: has several .mcap files; give one of them",
                bag.display()
            ),
        };
    }
    if bag.extension().is_some_and(|end| end == "db3") {
        bail!("{}: {sqlite}", bag.display());
    }
    Ok(bag.to_owned())
}

/// The topic of a kind: the given one, or the only one of the types.
fn chosen(
    all: &BTreeMap<String, String>,
    given: Option<&String>,
    types: &[&str],
    option: &str,
) -> Result<Option<String>> {
    let list = |topics: Vec<&String>| {
        topics
            .iter()
            .map(|topic| topic.as_str())
            .collect::<Vec<_>>()
            .join(", ")
    };
    if let Some(topic) = given {
        let Some(own) = all.get(topic) else {
            bail!(
                "{option}: {topic}: is not in the bag; it has {}",
                list(all.keys().collect())
            );
        };
        let may_be = types.contains(&own.as_str())
            || (option == "--truth" && ODOMETRY.contains(&own.as_str()));
        if !may_be {
            bail!(
                "{option}: {topic}: is {own}; give one of {}",
                types.join(", ")
            );
        }
        return Ok(Some(topic.clone()));
    }
    let found: Vec<&String> = all
        .iter()
        .filter(|(_, own)| types.contains(&own.as_str()))
        .map(|(topic, _)| topic)
        .collect();
    match found.as_slice() {
        [] => Ok(None),
        [one] => Ok(Some((*one).clone())),
        _ => bail!("{option}: the bag has {}; choose one", list(found)),
    }
}

/// Reads a bag.
///
/// # Errors
/// When it is no MCAP file, topics are missing or ambiguous, or a message does not fit its type. A bag that is cut off
/// gives what it has, with a warning.
pub fn import(bag: &Path, wanted: &Topics) -> Result<Imported> {
    let file = file_of(bag)?;
    let open = || {
        let opened = File::open(&file)?;
        let length = usize::try_from(opened.metadata()?.len()).unwrap_or(usize::MAX);
        Ok((Box::new(opened) as Box<dyn Read>, length))
    };
    from(&open, &file, wanted)
}

/// Reads the bytes of an MCAP file, which errors call `file`.
///
/// # Errors
/// As [`import`].
pub fn read(bytes: &[u8], file: &Path, wanted: &Topics) -> Result<Imported> {
    from(&|| Ok((Box::new(bytes), bytes.len())), file, wanted)
}

/// Bytes, and how many they are.
type Opened<'a> = (Box<dyn Read + 'a>, usize);

/// Reads a file, whose length comes along, twice: which topics it has, then their messages.
fn from<'a>(
    open: &dyn Fn() -> Result<Opened<'a>>,
    file: &Path,
    wanted: &Topics,
) -> Result<Imported> {
    let of_file = || file.display().to_string();
    let all = open()
        .and_then(|(mut bytes, length)| topics((&mut bytes, length)))
        .with_context(of_file)?;
    let odometry = chosen(&all, wanted.odometry.as_ref(), ODOMETRY, "--odometry")?;
    let truth = chosen(&all, wanted.truth.as_ref(), TRUTH, "--truth")?;
    let audio = chosen(&all, wanted.audio.as_ref(), AUDIO, "--audio")?;
    for (topic, types, option) in [
        (&odometry, ODOMETRY, "--odometry"),
        (&audio, AUDIO, "--audio"),
    ] {
        if topic.is_none() {
            let names: Vec<String> = all
                .iter()
                .map(|(topic, own)| format!("{topic} ({own})"))
                .collect();
            bail!(
                "{}: {option}: has no topic of {}; it has {}",
                file.display(),
                types.join(", "),
                names.join(", ")
            );
        }
    }
    let mut imported = Imported {
        odometry: "t_s,v_mps,omega_radps\n".to_owned(),
        ..Imported::default()
    };
    let mut poses = String::new();
    let (mut last, mut last_pose, mut old) = (f64::NEG_INFINITY, f64::NEG_INFINITY, 0);
    let (mut bytes, length) = open().with_context(of_file)?;
    let cut = each_message((&mut bytes, length), &mut |message: &Message<'_>| {
        let bad = || {
            format!(
                "{}: a message at {:.3} s does not fit its type",
                message.topic, message.log_s
            )
        };
        let stamp = |stamp_s: f64| {
            if stamp_s == 0.0 {
                message.log_s
            } else {
                stamp_s
            }
        };
        let own = Some(message.topic);
        if own == odometry.as_deref() {
            let (placed, speeds) = cdr::odometry(message.data).with_context(bad)?;
            let t_s = stamp(placed.stamp_s);
            if t_s > last {
                last = t_s;
                let _ = writeln!(
                    imported.odometry,
                    "{t_s:.9},{},{}",
                    speeds.v_mps, speeds.omega_radps
                );
            } else {
                old += 1;
            }
        }
        if own == truth.as_deref() {
            let placed = match message.schema {
                "geometry_msgs/msg/PoseStamped" => cdr::pose(message.data),
                "geometry_msgs/msg/TransformStamped" => cdr::transform(message.data),
                _ => cdr::odometry(message.data).map(|(placed, _)| placed),
            }
            .with_context(bad)?;
            let t_s = stamp(placed.stamp_s);
            let ([x, y, z], [qx, qy, qz, qw]) = (placed.place_m, placed.quaternion);
            if t_s > last_pose {
                last_pose = t_s;
                let _ = writeln!(
                    poses,
                    "{t_s:.9} {x:.9} {y:.9} {z:.9} {qx:.12} {qy:.12} {qz:.12} {qw:.12}"
                );
            } else {
                old += 1;
            }
        }
        if own == audio.as_deref() {
            if imported.audio.is_empty() {
                imported.audio_s = message.log_s;
            }
            imported
                .audio
                .extend_from_slice(cdr::audio(message.data).with_context(bad)?);
        }
        Ok(())
    })
    .with_context(of_file)?;
    if let Some(problem) = cut {
        imported.warnings.push(format!(
            "the bag is cut off ({problem}): this is what it has"
        ));
    }
    if old > 0 {
        imported.warnings.push(format!(
            "{old} messages were not newer than the one before, and are left out"
        ));
    }
    imported.truth = (!poses.is_empty()).then_some(poses);
    Ok(imported)
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod written;
