//! Every number that a figure, the README or a check rests on: `results/<name>/summary.json`.

mod multipath;
mod studies;
mod table;

pub use self::multipath::{FollowedPath, Multipath, MultipathGate, MultipathScene};
pub use self::studies::{
    AxisErrors, DualCircle, Engine, FilterTime, Methods, NoiseCell, PeriodsCell, Reflections,
    ResolutionCell, SchemeAccuracy, Schemes, Site, StepTime, Summary, WindowCell,
};
pub use self::table::{rows, table};
