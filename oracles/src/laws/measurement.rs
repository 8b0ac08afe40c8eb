//! A measured number and the range that a law leaves it.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::setting::Setting;
use fdtd::scheme::Scheme;

/// Extent of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// Every law, few cases.
    Quick,
    /// All cases.
    Full,
}

/// A number and the range that a law leaves it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// The case, e.g. `d25, 60 degrees`.
    pub case: String,
    /// The quantity, with its unit.
    pub quantity: Cow<'static, str>,
    /// The number.
    pub measured: f64,
    /// Smallest value allowed; absent for none.
    pub least: Option<f64>,
    /// Largest value allowed; absent for none.
    pub most: Option<f64>,
    /// Whether this number is shown for comparison only.
    pub informative: bool,
}

impl Measurement {
    /// A number that may be off zero by `tolerance` to both sides.
    pub fn within(case: String, quantity: &'static str, measured: f64, tolerance: f64) -> Self {
        Self {
            least: Some(-tolerance),
            ..Self::below(case, quantity, measured, tolerance)
        }
    }

    /// [`Self::within`] for a number held to the law, [`Self::shown`] for one beside it.
    pub fn held(
        held: bool,
        case: String,
        quantity: &'static str,
        measured: f64,
        tolerance: f64,
    ) -> Self {
        if held {
            Self::within(case, quantity, measured, tolerance)
        } else {
            Self::shown(case, quantity, measured)
        }
    }

    /// A number that may be at most `most`.
    pub fn below(case: String, quantity: &'static str, measured: f64, most: f64) -> Self {
        Self {
            case,
            quantity: Cow::Borrowed(quantity),
            measured,
            least: None,
            most: Some(most),
            informative: false,
        }
    }

    /// The relative error of a waveform and that of its level in dB, with their tolerances.
    pub fn waveform_and_level(case: &str, measured: [f64; 2], allowed: [f64; 2]) -> [Self; 2] {
        let ([waveform, level_db], [most, most_db]) = (measured, allowed);
        [
            Self::below(case.to_string(), "waveform, relative", waveform, most),
            Self::within(case.to_string(), "level, dB", level_db, most_db),
        ]
    }

    /// A number shown beside the others, whatever it is.
    pub fn shown(case: String, quantity: &'static str, measured: f64) -> Self {
        Self {
            most: None,
            informative: true,
            ..Self::below(case, quantity, measured, 0.0)
        }
    }

    /// Whether the number is in its range; never for NaN.
    pub fn passed(&self) -> bool {
        !self.measured.is_nan()
            && self.least.is_none_or(|least| self.measured >= least)
            && self.most.is_none_or(|most| self.measured <= most)
    }
}

/// The schemes that a law goes through.
pub(super) fn schemes() -> impl Iterator<Item = Scheme> {
    Scheme::ALL.into_iter()
}

/// The name of a case with its setting.
pub(super) fn named(case: &str, setting: &Setting) -> String {
    format!("{case}, {setting}")
}

/// Of two errors the larger, with its sign; the first of equal ones.
pub(super) fn larger(one: f64, other: f64) -> f64 {
    if other.abs() > one.abs() { other } else { one }
}
