//! What is said of a drive, a map and their parameters: how far results can be trusted.

use std::path::Path;

use anyhow::{Result, bail};
use localizer::quality::CodeMeter;
use localizer::recording::RecordingMeta;
use localizer::{Parameters, Pose, Trajectory};

use crate::data::manifest::Manifest;

/// Share of the blocks with the code below which a recording holds no echoes.
const NO_ECHOES: f64 = 0.3;
/// Share of the blocks with the code below which a recording is doubtful.
const FEW_ECHOES: f64 = 0.9;
/// Least share of the blocks, and least number, that the truth of a mapping drive has to cover.
const LEAST_COVERED: f64 = 0.2;
const LEAST_BLOCKS: usize = 10;
/// Largest share of the truth's poses that may jump.
const MOST_JUMPS: f64 = 0.2;
/// Relative difference of two speeds of sound that is worth a word: half a degree.
const SAME_AIR: f64 = 1e-3;

/// Warnings of a command, told together at its end.
#[derive(Debug, Default)]
pub struct Warnings(Vec<String>);

impl Warnings {
    /// Adds one.
    pub fn add(&mut self, warning: impl Into<String>) {
        self.0.push(warning.into());
    }

    /// Adds several.
    pub fn extend(&mut self, warnings: impl IntoIterator<Item = String>) {
        self.0.extend(warnings);
    }

    /// The warnings in their order, to look at.
    pub fn so_far(&self) -> &[String] {
        &self.0
    }

    /// The warnings in their order.
    pub fn lines(self) -> Vec<String> {
        self.0
    }

    /// The warnings in their order, each printed on standard error.
    pub fn tell(self) -> Vec<String> {
        for warning in &self.0 {
            eprintln!("warning: {warning}");
        }
        self.0
    }
}

/// Words on files of an input folder that this program wrote and that are other ones now: edited, or damaged.
pub fn changed(folder: &Path) -> Vec<String> {
    let manifest = Manifest::read(folder).unwrap_or_default();
    let names = manifest.changed(folder).into_iter();
    names
        .map(|name| {
            format!(
                "{}: is not as this program wrote it: edited, or damaged",
                folder.join(name).display()
            )
        })
        .collect()
}

/// Share of a recording's blocks in which its code is; `None` when the robot never moves.
///
/// # Errors
/// When there is next to none: a dead microphone, noise, another code.
pub fn check_echoes(
    meta: &RecordingMeta,
    code: &CodeMeter,
    folder: &Path,
    warnings: &mut Warnings,
) -> Result<Option<f64>> {
    let folder = folder.display();
    let Some(share) = code.share() else {
        warnings.add(format!(
            "{folder}: the robot rests all the time; poses follow from odometry alone"
        ));
        return Ok(None);
    };
    let what = match &meta.transmitted {
        Some(_) => "the waveform of transmitted.wav".to_string(),
        None => format!(
            "the code of recording.json ({} chips at {} Hz on {} Hz)",
            meta.code_length, meta.chip_rate_hz, meta.carrier_hz
        ),
    };
    let code = format!("{what} is in {:.0} % of the blocks", 100.0 * share);
    if share < NO_ECHOES {
        bail!(
            "{folder}: signal.wav: {code}: it holds no echoes; check waveform, rates and microphone, or record again"
        );
    }
    if share < FEW_ECHOES {
        warnings.add(format!("{folder}: signal.wav: {code}"));
    }
    Ok(Some(share))
}

/// The true poses of a mapping drive, where they can be relied on.
pub struct Cover<'a> {
    truth: &'a Trajectory,
    /// Poses before which the truth jumps.
    jumps: Vec<usize>,
    all: usize,
    covered: usize,
    /// Times of the first and the last block.
    ends_s: Option<[f64; 2]>,
}

impl<'a> Cover<'a> {
    /// Looks for jumps of the truth, faster than the wheels' speeds allow.
    ///
    /// # Errors
    /// When most of the truth jumps.
    pub fn new(
        truth: &'a Trajectory,
        speeds_mps: impl Iterator<Item = f64>,
        folder: &Path,
        warnings: &mut Warnings,
    ) -> Result<Self> {
        let folder = folder.display();
        // Twice the fastest that the wheels report, and what a hand that moves the robot adds.
        let fastest_mps = 2.0 * speeds_mps.map(f64::abs).fold(0.0, f64::max) + 0.5;
        let jumps = truth.jumps(fastest_mps);
        let first = jumps.first().map(|&index| {
            let way_m = truth.poses[index].distance_m(&truth.poses[index + 1]);
            let length_s = truth.t_s[index + 1] - truth.t_s[index];
            format!(
                "{way_m:.2} m in {length_s:.3} s after {:.3} s",
                truth.t_s[index]
            )
        });
        if let Some(first) = first {
            let count = jumps.len();
            if count as f64 > MOST_JUMPS * truth.len() as f64 {
                bail!(
                    "{folder}: truth.tum: {count} of {} poses jump, the first by {first}; give metres and seconds",
                    truth.len()
                );
            }
            warnings.add(format!(
                "{folder}: truth.tum: has outliers: {count} jumps, the first by {first}; blocks beside them are left \
                 out"
            ));
        }
        Ok(Self {
            truth,
            jumps,
            all: 0,
            covered: 0,
            ends_s: None,
        })
    }

    /// The pose of the next block, if the truth covers it.
    pub fn pose_at(&mut self, t_s: f64) -> Option<Pose> {
        self.all += 1;
        self.ends_s = Some([self.ends_s.map_or(t_s, |[first_s, _]| first_s), t_s]);
        // An outlier is a jump there and a jump back: the pose between them is in neither interval alone.
        let near = |index: &usize| {
            let (from, to) = (
                index.saturating_sub(1),
                (index + 2).min(self.truth.len() - 1),
            );
            (self.truth.t_s[from]..=self.truth.t_s[to]).contains(&t_s)
        };
        if self.jumps.iter().any(near) {
            return None;
        }
        let pose = self.truth.covered_pose_at(t_s)?;
        self.covered += 1;
        Some(pose)
    }

    /// The number of blocks that have a pose.
    ///
    /// # Errors
    /// When little is covered.
    pub fn finish(self, folder: &Path, warnings: &mut Warnings) -> Result<usize> {
        let folder = folder.display();
        let [first_s, last_s] = self.ends_s.unwrap_or_default();
        let percent = 100.0 * self.covered as f64 / self.all.max(1) as f64;
        if percent < 100.0 * LEAST_COVERED || self.covered < LEAST_BLOCKS.min(self.all) {
            let (from, to) = match (self.truth.t_s.first(), self.truth.t_s.last()) {
                (Some(&from), Some(&to)) => (from, to),
                _ => (0.0, 0.0),
            };
            bail!(
                "{folder}: truth.tum: covers {percent:.0} % of the drive: it has {from:.3} s to {to:.3} s of the \
                 signal's clock, the blocks {first_s:.3} s to {last_s:.3} s; correct truth_clock_s in recording.json, \
                 or track the whole drive"
            );
        }
        if self.covered < self.all {
            warnings.add(format!(
                "{folder}: truth.tum: covers {percent:.0} % of the drive; the other blocks are left out"
            ));
        }
        Ok(self.covered)
    }
}

/// Words on values of a parameter file that `recording.json` replaces.
pub fn ignored(file: Option<&Path>, recording: &Parameters) -> Vec<String> {
    let Some(file) = file else {
        return Vec::new();
    };
    let given = std::fs::read_to_string(file).unwrap_or_default();
    let given: serde_json::Value = serde_json::from_str(&given).unwrap_or_default();
    let used = serde_json::to_value(recording).unwrap_or_default();
    let of_signal = [
        "sample_rate_hz",
        "code_length",
        "chip_rate_hz",
        "carrier_hz",
        "speed_of_sound_mps",
        "sensor_offset_m",
        "sensor_baseline_m",
    ];
    of_signal
        .iter()
        .filter(|field| !given[**field].is_null())
        .filter(|field| !is_same(&given[**field], &used[**field]))
        .map(|field| {
            format!(
                "{}: {field}: {} is ignored, for recording.json gives it{}",
                file.display(),
                given[*field],
                match &used[*field] {
                    serde_json::Value::Null => String::new(),
                    used => format!(" as {used}"),
                }
            )
        })
        .collect()
}

/// Words on where a drive's recording and parameters differ from those that the map was made with.
pub fn contradictions(map: &Parameters, drive: &Parameters) -> Vec<String> {
    let mut words = Vec::new();
    let (a, b) = (map.signal, drive.signal);
    for (field, ours, theirs) in [
        ("code_length", b.code_length as f64, a.code_length as f64),
        ("chip_rate_hz", b.chip_rate_hz, a.chip_rate_hz),
        ("carrier_hz", b.carrier_hz, a.carrier_hz),
    ] {
        if ours != theirs {
            words.push(format!(
                "{field}: the drive has {ours}, the map was made with {theirs}"
            ));
        }
    }
    let (ours, theirs) = (b.speed_of_sound_mps, a.speed_of_sound_mps);
    if (ours / theirs - 1.0).abs() > SAME_AIR {
        words.push(format!(
            "speed_of_sound_mps: the drive has {ours} m/s, the map was made with {theirs} m/s; right if the air was \
            warmer or colder"
        ));
    }
    let [ours, theirs] = [drive, map].map(|parameters| {
        let mut value = serde_json::to_value(parameters).unwrap_or_default();
        value
            .as_object_mut()
            .map(std::mem::take)
            .unwrap_or_default()
    });
    let of_measurement = [
        "directions",
        "time_reference",
        "direct_wave",
        "min_range_m",
        "max_range_m",
        "range_pool_m",
        "toa_image",
        "sensor_offset_m",
    ];
    words.extend(
        of_measurement
            .iter()
            .filter(|field| !is_same(&ours[**field], &theirs[**field]))
            .map(|field| {
                let (ours, theirs) = (&ours[*field], &theirs[*field]);
                format!("{field}: the drive has {ours}, the map was made with {theirs}")
            }),
    );
    words
}

/// Whether two JSON values are the same, numbers by their value.
fn is_same(one: &serde_json::Value, other: &serde_json::Value) -> bool {
    match (
        one.as_f64(),
        other.as_f64(),
        one.as_array(),
        other.as_array(),
    ) {
        (Some(one), Some(other), ..) => one == other,
        (.., Some(one), Some(other)) => {
            one.len() == other.len()
                && one
                    .iter()
                    .zip(other)
                    .all(|(one, other)| is_same(one, other))
        }
        _ => one == other,
    }
}
