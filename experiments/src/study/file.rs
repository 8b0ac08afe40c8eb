//! A study as its file has it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use fdtd::scene::LayoutKind;
use schemars::JsonSchema;
use serde::de::{DeserializeOwned, Error};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use super::claims::Claim;
use super::scores::Measure;

/// Values by dotted name: `scene.*` and `robot.*` as in their files, `localizer.*` as in parameter files,
/// `drive.mapping` and `drive.localization` (names of the scene's paths), `field.engine`, `field.image_order`,
/// `noise.snr_db`, `noise.mapping`, `robot.odometry_bias_radps`.
pub type Settings = BTreeMap<String, Value>;

/// A study: what is simulated, what varies, by which methods, and what is claimed of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// Place of the schema, for editors.
    #[serde(default, rename = "$schema", skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// Name of the study and of its folder of results: letters, digits, `-` and `_`.
    pub name: String,
    /// What the study asks, in a sentence.
    pub about: String,
    /// Scene files (as seen from the study's file, the working folder or the project), or layouts drawn at random.
    pub scenes: Vec<SceneChoice>,
    /// Robot file; without one wheels and microphone are ideal but for a steady error of the turn rate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<PathBuf>,
    /// Values other than the defaults in every cell.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub set: Settings,
    /// Named sets of values, one cell each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<Alternative>,
    /// What varies. Names in one entry vary together, entries vary against each other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub vary: Vec<BTreeMap<String, Values>>,
    /// Methods that find the poses.
    pub methods: Vec<MethodChoice>,
    /// How often what is random is drawn in every cell.
    #[serde(default)]
    pub seeds: Seeds,
    /// Figures; a curve over what varies, bars and distributions when left out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<FigureChoice>,
    /// What the study is to show.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub claims: Vec<Claim>,
    /// File of errors that `echolot check` holds the results against.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<PathBuf>,
}

/// A scene file, or layouts drawn at random.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum SceneChoice {
    /// A scene file with the drives `mapping` and `localization`, or others that `drive.*` names.
    File(PathBuf),
    /// Layouts of `echolot scene random`; they count as draws of one cell.
    Random(RandomLayouts),
}

/// Layouts drawn at random.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomLayouts {
    /// Arrangement of the walls.
    pub random: RandomKind,
    /// First and last seed.
    pub seeds: [u64; 2],
}

/// Arrangement of the walls of a random layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RandomKind {
    /// Three to five single walls.
    Open,
    /// A rectangular room with gaps.
    Room,
}

impl From<RandomKind> for LayoutKind {
    fn from(kind: RandomKind) -> Self {
        match kind {
            RandomKind::Open => Self::Open,
            RandomKind::Room => Self::Room,
        }
    }
}

/// A named set of values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Alternative {
    /// Name of the cell.
    pub name: String,
    /// Its values.
    pub set: Settings,
}

/// The values of a name that varies.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Values {
    /// One by one.
    List(Vec<Value>),
    /// Evenly spaced.
    Range(Range),
}

/// Numbers from one to another, both included.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// The first.
    pub from: f64,
    /// The last.
    pub to: f64,
    /// Distance between two; above 0.
    pub step: f64,
}

/// A method by its name, or with values of its own.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum MethodChoice {
    /// A method with the study's values.
    Named(MethodName),
    /// A method with values of its own.
    Set(MethodWithSettings),
}

/// A method with values of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MethodWithSettings {
    /// The method.
    pub method: MethodName,
    /// Values that only this method has.
    pub set: Settings,
}

/// A method that finds poses.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum MethodName {
    /// Echo images in range and bearing.
    Doppler,
    /// Echo images in range only.
    ToaOnly,
    /// Wheels alone.
    Odometry,
    /// Arrival times at the scene's given walls.
    Multipath,
    /// Landmarks learnt from the mapping drive; M = 2 unless set.
    Landmarks,
    /// Drive and landmarks together, without map or truth; M = 2 unless set.
    Slam,
}

impl MethodName {
    /// Whether it follows a map of echoes, or makes one.
    pub(super) fn has_map(self) -> bool {
        !matches!(self, Self::Odometry | Self::Multipath)
    }

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Doppler => "doppler",
            Self::ToaOnly => "toa-only",
            Self::Odometry => "odometry",
            Self::Multipath => "multipath",
            Self::Landmarks => "landmarks",
            Self::Slam => "slam",
        }
    }
}

impl MethodChoice {
    /// The method.
    pub fn method(&self) -> MethodName {
        match self {
            Self::Named(method) => *method,
            Self::Set(choice) => choice.method,
        }
    }

    /// Its own values.
    pub fn settings(&self) -> Option<&Settings> {
        match self {
            Self::Named(_) => None,
            Self::Set(choice) => Some(&choice.set),
        }
    }
}

/// How often what is random is drawn in every cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Seeds {
    /// Slip and noise of the robot's instruments; the robot file's seed and those after it.
    pub slip: usize,
    /// Noise of `noise.snr_db`.
    pub noise: usize,
    /// Particle filter.
    pub filter: usize,
}

impl Default for Seeds {
    fn default() -> Self {
        Self {
            slip: 1,
            noise: 1,
            filter: 1,
        }
    }
}

/// A figure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum FigureChoice {
    /// A measure over a name that varies, a line for every method and every other cell.
    Curve {
        /// The name.
        over: String,
        /// The measure; the mean distance unless given.
        #[serde(default)]
        measure: Measure,
    },
    /// A measure of every cell and method, with intervals.
    Bars {
        /// The measure; the mean distance unless given.
        #[serde(default)]
        measure: Measure,
    },
    /// Share of the errors below a distance, a line for every method and cell.
    Cdf {},
    /// The paths of the first trial of a cell over the walls; of the first cell unless given.
    Paths {
        /// Values of the cell.
        #[serde(default, rename = "where")]
        cell: Settings,
    },
    /// The maps of the first trial of a cell over the true walls: the echo image and the landmarks, as methods have
    /// them; of the first cell unless given.
    Map {
        /// Values of the cell.
        #[serde(default, rename = "where")]
        cell: Settings,
    },
    /// Measures of every cell and method with their intervals.
    Table {
        /// The measures, a column each.
        measures: Vec<Measure>,
    },
}

/// A value that is a text, or an object of another type: errors name the object's field.
fn text_or<'de, D, T, O>(
    deserializer: D,
    of_text: impl FnOnce(Value) -> Result<T, serde_json::Error>,
    of_object: impl FnOnce(O) -> T,
) -> Result<T, D::Error>
where
    D: Deserializer<'de>,
    O: DeserializeOwned,
{
    match Value::deserialize(deserializer)? {
        text @ Value::String(_) => of_text(text),
        other => serde_json::from_value(other).map(of_object),
    }
    .map_err(D::Error::custom)
}

impl<'de> Deserialize<'de> for SceneChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let file = |text| serde_json::from_value(text).map(Self::File);
        text_or(deserializer, file, Self::Random)
    }
}

impl<'de> Deserialize<'de> for MethodChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let named = |text| serde_json::from_value(text).map(Self::Named);
        text_or(deserializer, named, Self::Set)
    }
}

impl<'de> Deserialize<'de> for Values {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Value::deserialize(deserializer)? {
            Value::Array(list) => Ok(Self::List(list)),
            other => Range::deserialize(other)
                .map(Self::Range)
                .map_err(D::Error::custom),
        }
    }
}
