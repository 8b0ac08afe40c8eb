//! The cells of a study: every combination of what varies, and what is drawn in each.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use serde_json::Value;

use super::file::{MethodName, SceneChoice, Settings, StudyFile, Values};
use super::settings::{Source, check_name, random_source};
use crate::run::project;

/// Most cells, and most trials in all: more are a mistake.
const MOST_CELLS: usize = 100_000;
pub(super) const MOST_TRIALS: usize = 10_000_000;
/// Most seeds of one kind, and most layouts drawn at random.
pub(crate) const MOST_SEEDS: usize = 1_000_000;
const MOST_LAYOUTS: u64 = 100_000;

/// A combination of what varies.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// What tells it from the others: names that vary, with their values as text.
    pub labels: Vec<(String, String)>,
    /// Its values.
    pub settings: Settings,
    /// Its scenes: one file, or layouts drawn at random.
    pub(super) sources: Arc<[Source]>,
}

/// The numbers of what is drawn in a trial: layout, slip, noise, filter.
pub type Draw = [u64; 4];

/// Names of what is drawn, in the order of [`Draw`], outer first.
pub const DRAWN: [&str; 4] = ["layout", "slip", "noise", "filter"];

/// A value as text in labels and tables.
pub(super) fn label(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Null => "none".to_string(),
        other => other.to_string(),
    }
}

impl Cell {
    /// The labels as one text, `periods = 2, scheme = slf`; `all` for the only cell of a study.
    pub fn name(&self) -> String {
        let parts: Vec<String> = self
            .labels
            .iter()
            .map(|(name, value)| format!("{} = {value}", short(name)))
            .collect();
        match parts.is_empty() {
            true => "all".to_string(),
            false => parts.join(", "),
        }
    }

    /// Whether the cell has these values.
    pub fn has(&self, wanted: &Settings) -> bool {
        wanted.iter().all(|(name, value)| {
            self.labels
                .iter()
                .any(|(known, text)| known == name && *text == label(value))
        })
    }
}

/// The last part of a dotted name.
pub fn short(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

/// The units that names end in.
const UNITS: [(&str, &str); 10] = [
    ("_radpm", "rad/m"),
    ("_radps", "rad/s"),
    ("_mps", "m/s"),
    ("_pasm", "Pa s/m"),
    ("_rad", "rad"),
    ("_hz", "Hz"),
    ("_db", "dB"),
    ("_c", "\u{b0}C"),
    ("_m", "m"),
    ("_s", "s"),
];

/// The last part of a dotted name in words, and its unit.
pub fn words(name: &str) -> (String, &'static str) {
    let last = short(name);
    for (ending, unit) in UNITS {
        if let Some(words) = last.strip_suffix(ending) {
            return (words.replace('_', " "), unit);
        }
    }
    (last.replace('_', " "), "")
}

/// A name and a value in words: `window half width 2 m`; scenes and alternatives by their names alone.
pub fn in_words(name: &str, value: &str) -> String {
    if ["scene", "alternative"].contains(&name) {
        return value.to_string();
    }
    let (words, unit) = words(name);
    match unit.is_empty() || value == "none" {
        true => format!("{words} {value}"),
        false => format!("{words} {value} {unit}"),
    }
}

/// Names and values in words, behind each other.
pub fn all_in_words<'a>(labels: impl IntoIterator<Item = (&'a String, &'a String)>) -> String {
    let parts = labels
        .into_iter()
        .map(|(name, value)| in_words(name, value));
    parts.collect::<Vec<_>>().join(", ")
}

impl Values {
    /// The values one by one.
    fn list(&self) -> Result<Vec<Value>> {
        match self {
            Self::List(list) if list.is_empty() => {
                bail!("has no values; give some or leave it out")
            }
            Self::List(list) => Ok(list.clone()),
            Self::Range(range) => {
                let steps = (range.to - range.from) / range.step;
                if !(range.step > 0.0 && steps >= 0.0 && steps <= MOST_CELLS as f64) {
                    bail!(
                        "from {} to {} by {} is no range; give a step above 0 and an end behind the start",
                        range.from,
                        range.to,
                        range.step
                    );
                }
                // The end is met in spite of rounding.
                let count = (steps + 1e-9).floor() as usize;
                (0..=count)
                    .map(|k| {
                        let value = range.from + k as f64 * range.step;
                        let value = (value * 1e9).round() / 1e9;
                        Ok(match value.fract() == 0.0 && value.abs() < 1e15 {
                            true => Value::from(value as i64),
                            false => Value::from(value),
                        })
                    })
                    .collect()
            }
        }
    }
}

/// A file that a study names: as seen from the study's folder, else the working folder, else the project; in the
/// study's folder where there is none.
pub(crate) fn find(file: &Path, folder: &Path) -> PathBuf {
    let beside = folder.join(file);
    let elsewhere = project::file(file);
    match !beside.exists() && elsewhere.exists() {
        true => elsewhere,
        false => beside,
    }
}

/// The cells of a study whose file lies in `folder`.
///
/// # Errors
/// One line that names the field: unknown or repeated names, lists of different lengths that vary together, no values,
/// too many cells.
pub(super) fn cells(study: &StudyFile, folder: &Path) -> Result<Vec<Cell>> {
    let has_robot = study.robot.is_some();
    let mut taken: Vec<&str> = Vec::new();
    for name in study.set.keys() {
        check_name(name, has_robot).with_context(|| format!("set.{name}"))?;
        taken.push(name);
    }
    for (number, choice) in study.methods.iter().enumerate() {
        for name in choice.settings().into_iter().flat_map(Settings::keys) {
            check_name(name, has_robot).with_context(|| format!("methods[{number}].set.{name}"))?;
        }
    }
    let mut cells = scene_cells(study, folder)?;
    if !study.alternatives.is_empty() {
        let mut names: Vec<&str> = Vec::new();
        for (number, alternative) in study.alternatives.iter().enumerate() {
            for name in alternative.set.keys() {
                check_name(name, has_robot)
                    .with_context(|| format!("alternatives[{number}].set.{name}"))?;
            }
            if names.contains(&alternative.name.as_str()) {
                bail!(
                    "alternatives[{number}].name: {} is there twice; rename one",
                    alternative.name
                );
            }
            names.push(&alternative.name);
        }
        cells = product(&cells, study.alternatives.len(), |cell, index| {
            let alternative = &study.alternatives[index];
            cell.labels
                .push(("alternative".to_string(), alternative.name.clone()));
            cell.settings.extend(alternative.set.clone());
        })?;
    }
    for (number, entry) in study.vary.iter().enumerate() {
        let field = format!("vary[{number}]");
        let mut columns: Vec<(&String, Vec<Value>)> = Vec::new();
        for (name, values) in entry {
            let field = || format!("{field}.{name}");
            check_name(name, has_robot).with_context(field)?;
            let in_method = study
                .methods
                .iter()
                .any(|choice| choice.settings().is_some_and(|set| set.contains_key(name)));
            if taken.contains(&name.as_str()) || in_method {
                bail!(
                    "{}: has a value elsewhere in the study too; keep one of them",
                    field()
                );
            }
            taken.push(name);
            columns.push((name, values.list().with_context(field)?));
        }
        let Some(count) = columns.first().map(|(_, values)| values.len()) else {
            bail!("{field}: is empty; name what varies or leave it out");
        };
        if let Some((name, values)) = columns.iter().find(|(_, values)| values.len() != count) {
            bail!(
                "{field}.{name}: has {} values beside {count}; names in one entry vary together, put it into an entry \
                of its own or give as many",
                values.len()
            );
        }
        cells = product(&cells, count, |cell, index| {
            for (name, values) in &columns {
                cell.labels.push(((*name).clone(), label(&values[index])));
                cell.settings.insert((*name).clone(), values[index].clone());
            }
        })?;
    }
    Ok(cells)
}

/// A cell for every scene file and every kind of random layouts, with the values of the whole study.
fn scene_cells(study: &StudyFile, folder: &Path) -> Result<Vec<Cell>> {
    let mut cells: Vec<Cell> = Vec::new();
    for (number, choice) in study.scenes.iter().enumerate() {
        let (name, sources) = match choice {
            SceneChoice::File(file) => {
                let name = file.file_stem().unwrap_or_default().to_string_lossy();
                (name.into_owned(), vec![Source::File(find(file, folder))])
            }
            SceneChoice::Random(layouts) => {
                let [first, last] = layouts.seeds;
                if !(first..first.saturating_add(MOST_LAYOUTS)).contains(&last) {
                    bail!(
                        "scenes[{number}].seeds: {first} to {last} is no range; give first and last seed"
                    );
                }
                let source = |seed| random_source(layouts.random, seed);
                let kind = format!(
                    "random {}",
                    fdtd::scene::LayoutKind::from(layouts.random).name()
                );
                (kind, (first..=last).map(source).collect())
            }
        };
        if cells.iter().any(|cell| cell.labels[0].1 == name) {
            bail!("scenes[{number}]: {name} is there twice; leave one out");
        }
        cells.push(Cell {
            labels: vec![("scene".to_string(), name)],
            settings: study.set.clone(),
            sources: sources.into(),
        });
    }
    match cells.as_mut_slice() {
        [] => bail!("scenes: there are none; name a scene file or random layouts"),
        // The only scene tells no cell from another.
        [only] => only.labels.clear(),
        _ => {}
    }
    Ok(cells)
}

/// Every cell with every one of `count` additions.
fn product(cells: &[Cell], count: usize, add: impl Fn(&mut Cell, usize)) -> Result<Vec<Cell>> {
    if cells.len().saturating_mul(count) > MOST_CELLS {
        bail!("vary: makes more than {MOST_CELLS} cells; vary less at once");
    }
    let with = |cell: &Cell, index: usize| {
        let mut cell = cell.clone();
        add(&mut cell, index);
        cell
    };
    Ok(cells
        .iter()
        .flat_map(|cell| (0..count).map(move |index| (cell, index)))
        .map(|(cell, index)| with(cell, index))
        .collect())
}

/// How often each of [`DRAWN`] is drawn for a method in a cell: what it does not depend on only once.
pub(super) fn draws(
    study: &StudyFile,
    cell: &Cell,
    method: MethodName,
    has_noise: bool,
) -> [usize; 4] {
    let seeds = study.seeds;
    let by_sound = method != MethodName::Odometry;
    let by_particles = matches!(method, MethodName::Doppler | MethodName::ToaOnly);
    [
        cell.sources.len(),
        if study.robot.is_some() { seeds.slip } else { 1 },
        if has_noise && by_sound {
            seeds.noise
        } else {
            1
        },
        if by_particles { seeds.filter } else { 1 },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_words_with_units() {
        assert_eq!(
            in_words("localizer.window_half_width_m", "2"),
            "window half width 2 m"
        );
        assert_eq!(in_words("noise.snr_db", "none"), "snr none");
        assert_eq!(in_words("robot.turn_noise.sigma", "0.1"), "sigma 0.1");
        assert_eq!(in_words("scene", "random open"), "random open");
        assert_eq!(words("robot.drift_radpm"), ("drift".to_string(), "rad/m"));
    }
}
