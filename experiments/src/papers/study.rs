//! The papers' studies by name, each with the values that it tries.

use std::path::PathBuf;

use anyhow::Result;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    PaperSession, angular_resolution, dual_circle, engine, layout, multipath, odometry_drift,
    periods, reflections, schemes, site, snr, step_time, window_size,
};
use crate::recordings::spec::RecordingSpec;
use crate::study::file::Settings;
use crate::summary::Summary;

/// A study of a paper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "study", rename_all = "kebab-case", deny_unknown_fields)]
pub enum PaperStudy {
    /// Walls, drives, speeds and the map image (fig04, fig05).
    Layout {},
    /// Position error of Doppler, ToA only and odometry with a turn rate that is too high (fig06).
    OdometryDrift {},
    /// Position error over the half-width of the matched window (fig07).
    WindowSize {
        /// Half-widths N_W dx_m, metres.
        half_widths_m: Vec<f64>,
    },
    /// Reflected intensity over time beside the distances of ray theory (fig08).
    Reflections {},
    /// Position error and paths for several numbers of periods in a block (fig_periods).
    Periods {
        /// Numbers M of periods.
        periods: Vec<usize>,
    },
    /// Width of one exact echo over the direction for M = 1 to 8, beside theory (fig_angular_resolution).
    AngularResolution {},
    /// Position error over the ratio of signal to noise, eqs. (19)-(21) (fig09).
    Snr {
        /// Ratios, decibels.
        snr_db: Vec<f64>,
    },
    /// Position error when the field is computed with the standard leapfrog scheme.
    Schemes {},
    /// Compute time of one step, Doppler bank and filter (fig17).
    StepTime {
        /// Half-widths of the filter's window, metres.
        half_widths_m: Vec<f64>,
        /// Blocks that are timed.
        blocks: usize,
    },
    /// Position from 40 kHz ranges to four receivers beside the tables of Hsu et al. (2021) (fig_dual_circle).
    DualCircle {},
    /// Position from multipath arrival times by planes and a Kalman filter (2021), in a room and on the scene
    /// (fig_multipath_*).
    Multipath {},
    /// The experimental site in simulation, with a robot of its own (site/fig11 to fig16).
    Site(SiteStudy),
    /// Speed of the field computation on the scene.
    Engine {},
}

/// The experimental site (2024 paper, section IV): another scene and robot, and the values that its studies try.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SiteStudy {
    /// Scene file.
    pub scene: PathBuf,
    /// Robot file.
    pub robot: PathBuf,
    /// Values other than the file's.
    #[serde(default, skip_serializing_if = "Settings::is_empty")]
    pub set: Settings,
    /// Half-widths N_W dx_m, metres.
    pub half_widths_m: Vec<f64>,
    /// Ratios of signal to noise, decibels.
    pub snr_db: Vec<f64>,
}

/// What a study finds.
pub struct About {
    /// Its name in files.
    pub name: &'static str,
    /// Its figures.
    pub figures: &'static str,
    /// Its result, in one line.
    pub about: &'static str,
}

/// All studies.
pub const STUDIES: &[About] = &[
    About {
        name: "layout",
        figures: "fig04, fig05",
        about: "walls, drives, speeds and the map image",
    },
    About {
        name: "odometry-drift",
        figures: "fig06",
        about: "position error of Doppler, ToA only and odometry with a turn rate that is 0.01 rad/s too high",
    },
    About {
        name: "window-size",
        figures: "fig07",
        about: "position error over the half-width of the matched window",
    },
    About {
        name: "reflections",
        figures: "fig08",
        about: "reflected intensity over time beside the distances of ray theory",
    },
    About {
        name: "periods",
        figures: "fig_periods",
        about: "position error and paths for several numbers M of periods in a block",
    },
    About {
        name: "angular-resolution",
        figures: "fig_angular_resolution",
        about: "width of one exact echo over the direction for M = 1 to 8, beside theory",
    },
    About {
        name: "snr",
        figures: "fig09",
        about: "position error over the signal-to-noise ratio, eqs. (19)-(21)",
    },
    About {
        name: "schemes",
        figures: "-",
        about: "position error when the field is computed with the standard leapfrog scheme",
    },
    About {
        name: "step-time",
        figures: "fig17",
        about: "compute time of one step, Doppler bank and filter",
    },
    About {
        name: "dual-circle",
        figures: "fig_dual_circle",
        about: "position from 40 kHz ranges to four receivers beside the tables of Hsu et al. (2021)",
    },
    About {
        name: "multipath",
        figures: "fig_multipath_paths, fig_multipath_errors, fig_multipath_scene",
        about: "position from multipath arrival times by planes and a Kalman filter (2021), in a room and on the scene",
    },
    About {
        name: "site",
        figures: "site/fig11-fig16",
        about: "the experimental site in simulation: slip, noise, a microphone beside the loudspeaker",
    },
    About {
        name: "engine",
        figures: "-",
        about: "speed of the field computation on the scene",
    },
];

impl PaperStudy {
    /// Its name in files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Layout {} => "layout",
            Self::OdometryDrift {} => "odometry-drift",
            Self::WindowSize { .. } => "window-size",
            Self::Reflections {} => "reflections",
            Self::Periods { .. } => "periods",
            Self::AngularResolution {} => "angular-resolution",
            Self::Snr { .. } => "snr",
            Self::Schemes {} => "schemes",
            Self::StepTime { .. } => "step-time",
            Self::DualCircle {} => "dual-circle",
            Self::Multipath {} => "multipath",
            Self::Site(_) => "site",
            Self::Engine {} => "engine",
        }
    }

    /// The recordings of the session's scene that it needs; the site has a session of its own.
    pub(super) fn specs(&self, session: &PaperSession) -> Vec<RecordingSpec> {
        match self {
            Self::AngularResolution {} | Self::DualCircle {} | Self::Engine {} | Self::Site(_) => {
                Vec::new()
            }
            Self::Snr { .. } => snr::specs(session),
            Self::Schemes {} => schemes::specs(session),
            _ => session.recordings.localization_specs(None),
        }
    }

    /// Writes its data files and fills its part of the summary.
    ///
    /// # Errors
    /// When the study fails or is interrupted.
    pub(super) fn run(&self, session: &PaperSession, summary: &mut Summary) -> Result<()> {
        match self {
            Self::Layout {} => layout::run(session),
            Self::OdometryDrift {} => odometry_drift::run(session, summary),
            Self::WindowSize { half_widths_m } => window_size::run(session, half_widths_m, summary),
            Self::Reflections {} => reflections::run(session, summary),
            Self::Periods { periods } => periods::run(session, periods, summary),
            Self::AngularResolution {} => angular_resolution::run(session, summary),
            Self::Snr { snr_db } => snr::run(session, snr_db, summary),
            Self::Schemes {} => schemes::run(session, summary),
            Self::StepTime {
                half_widths_m,
                blocks,
            } => step_time::run(session, half_widths_m, *blocks, summary),
            Self::DualCircle {} => dual_circle::run(session, summary),
            Self::Multipath {} => multipath::run(session, summary),
            Self::Site(site) => site::run(session, site, summary),
            Self::Engine {} => engine::run(session, summary),
        }
    }
}
