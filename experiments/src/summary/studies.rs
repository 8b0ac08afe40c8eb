//! The summary and its parts by study.

use std::path::Path;

use anyhow::Result;
use serde::{Deserialize, Serialize};

use super::multipath::Multipath;
use crate::data::{atomic, json};
use crate::metrics::Accuracy;
use crate::papers::PapersFile;
use crate::run::provenance::Provenance;

/// The summary of the papers' studies of a file; a part that no study has filled yet is absent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Summary {
    /// Name of the studies.
    #[serde(alias = "preset")]
    pub name: String,
    /// The file; absent in summaries of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub study: Option<PapersFile>,
    /// Provenance.
    pub provenance: Provenance,
    /// Correction of the drift of wheel odometry (Fig. 6).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub odometry_drift: Option<Methods>,
    /// Accuracy over the half-width of the matched window (Fig. 7).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub window_size: Vec<WindowCell>,
    /// Accuracy over the signal-to-noise ratio (Fig. 9).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub snr: Vec<NoiseCell>,
    /// Accuracy over the number of periods in a block (2023 abstract).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub periods: Vec<PeriodsCell>,
    /// Width of one echo over the direction by the number of periods (2023 abstract).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub angular_resolution: Vec<ResolutionCell>,
    /// Distances of the echoes by ray theory and by measurement (Fig. 8).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reflections: Option<Reflections>,
    /// The field's scheme and speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub engine: Option<Engine>,
    /// Accuracy with other schemes of the field.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub schemes: Option<Schemes>,
    /// Compute time of one step (Fig. 17).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_time_ms: Option<StepTime>,
    /// Ranges to four receivers (Hsu et al., 2021).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dual_circle: Option<DualCircle>,
    /// Positions from multipath arrival times (Tsuchiya et al., 2021).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub multipath: Option<Multipath>,
    /// The experimental site in simulation (Figs. 11 to 16).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub site: Option<Site>,
}

/// The studies of the experimental site (2024 paper, section IV) on `scenes/site.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Site {
    /// Correction of the slip of the wheels (Fig. 13).
    pub odometry_drift: Methods,
    /// Accuracy over the half-width of the matched window (Fig. 14).
    pub window_size: Vec<WindowCell>,
    /// Distances of the echoes (Fig. 15).
    pub reflections: Reflections,
    /// Accuracy over the signal-to-noise ratio (Fig. 16).
    pub snr: Vec<NoiseCell>,
}

/// Angular resolution with one number of periods.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResolutionCell {
    /// Periods M in a block.
    pub m: usize,
    /// Half-power width of one exact echo over cos(theta).
    pub half_power_width: f64,
    /// The same for the carrier alone: 0.886 c / (2 f_c M T v).
    pub theory: f64,
}

/// Errors of positions from the ranges to four receivers (Hsu et al., 2021).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DualCircle {
    /// Recomputed from Table 1.
    pub published_dual_circle: AxisErrors,
    /// Recomputed from Table 2.
    pub published_triangulation: AxisErrors,
    /// Ours, circles around the receivers 1 and 2.
    pub dual_circle: AxisErrors,
    /// Ours, bearings at the receivers 1 and 2.
    pub triangulation: AxisErrors,
    /// Ours, all receivers.
    pub least_squares: AxisErrors,
}

/// Absolute errors of positions per axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisErrors {
    /// Mean along x, metres.
    pub mae_x_m: f64,
    /// Mean along y, metres.
    pub mae_y_m: f64,
    /// Greatest along either axis, metres.
    pub worst_m: f64,
}

/// Accuracy of the three methods on the same drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Methods {
    /// Echoes in range and bearing.
    pub doppler: Accuracy,
    /// Echoes in range only.
    pub toa_only: Accuracy,
    /// Wheel odometry alone.
    pub odometry: Accuracy,
}

/// Accuracy at one half-width of the window.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WindowCell {
    /// Half-width N_W dx_m, metres.
    pub half_width_m: f64,
    /// Accuracy of the Doppler method.
    #[serde(flatten)]
    pub accuracy: Accuracy,
}

/// Accuracy at one signal-to-noise ratio.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NoiseCell {
    /// Ratio of the power of the reflected signal to the power of the noise, decibels.
    pub snr_db: f64,
    /// Accuracy of the Doppler method.
    #[serde(flatten)]
    pub accuracy: Accuracy,
}

/// Accuracy with one number of periods.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PeriodsCell {
    /// Periods M in a block.
    pub m: usize,
    /// Accuracy of the Doppler method.
    #[serde(flatten)]
    pub accuracy: Accuracy,
}

/// Echo distances.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reflections {
    /// Greatest round-trip distance of single and corner reflections during the drive by ray theory, metres.
    pub farthest_usable_m: f64,
    /// Mean level of the measured intensity at ray distances of single and corner reflections over its mean elsewhere,
    /// decibels.
    pub ray_contrast_db: f64,
}

/// Speed of the field computation on this scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Engine {
    /// Scheme of the scene.
    pub scheme: String,
    /// Updated cells per second with all threads, 10^9.
    pub gcells_per_s: f64,
    /// The same with the standard leapfrog scheme.
    pub slf_gcells_per_s: f64,
    /// Threads used.
    pub threads: usize,
    /// Memory of the simulation, bytes.
    pub memory_bytes: u64,
}

/// Accuracy by scheme of the field; the scene's own scheme is `odometry_drift`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Schemes {
    /// Standard leapfrog.
    pub slf: SchemeAccuracy,
}

/// Accuracy of the filter methods with one scheme.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SchemeAccuracy {
    /// Echoes in range and bearing.
    pub doppler: Accuracy,
    /// Echoes in range only.
    pub toa_only: Accuracy,
}

/// Median compute times of one step on one thread, milliseconds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepTime {
    /// Doppler bank of one block, eqs. (1)-(3).
    pub doppler_bank: f64,
    /// Particle filter at the default window, eqs. (8)-(18).
    pub filter: f64,
    /// Particle filter by half-width of the window.
    pub filter_by_window: Vec<FilterTime>,
}

/// Compute time of the filter at one half-width of the window.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilterTime {
    /// Half-width N_W dx_m, metres.
    pub half_width_m: f64,
    /// Median, milliseconds.
    pub median_ms: f64,
}

impl Summary {
    /// A summary without studies.
    pub fn new(file: &PapersFile) -> Self {
        Self {
            study: Some(file.clone()),
            ..Self::named(&file.name)
        }
    }

    /// A summary without studies and file.
    pub fn named(name: &str) -> Self {
        Self {
            name: name.to_string(),
            study: None,
            provenance: Provenance::here(),
            odometry_drift: None,
            window_size: Vec::new(),
            snr: Vec::new(),
            periods: Vec::new(),
            angular_resolution: Vec::new(),
            reflections: None,
            engine: None,
            schemes: None,
            step_time_ms: None,
            dual_circle: None,
            multipath: None,
            site: None,
        }
    }

    /// Reads a summary.
    ///
    /// # Errors
    /// When the file cannot be read or is no summary.
    pub fn read(path: &Path) -> Result<Self> {
        json::read(path)
    }

    /// Writes the summary, indented.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        atomic::write(path, text.as_bytes())
    }
}
