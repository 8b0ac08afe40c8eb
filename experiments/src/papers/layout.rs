//! Walls, drives, speeds and the map image (Figs. 4 and 5).

use anyhow::Result;
use fdtd::scene::Scene;
use localizer::recording::Recording;

use super::PaperSession;
use crate::data::atomic;
use crate::data::layout::Layout;
use crate::data::table::{Table, cell};

/// Truth and odometry of a recording, one row every tenth of a second, in `drive`.
fn add_drive(drive: &mut Table, scene: &Scene, name: &str, recording: &Recording) -> Result<()> {
    let path = scene.path(name)?;
    for sample in recording.odometry.iter().step_by(5) {
        let state = path.state_at(sample.t_s);
        drive.push([
            name.to_string(),
            cell(sample.t_s, 3),
            cell(state.x_m, 4),
            cell(state.y_m, 4),
            cell(state.heading_rad, 4),
            cell(state.v_mps, 4),
            cell(state.omega_radps, 4),
            cell(sample.v_mps, 4),
            cell(sample.omega_radps, 4),
        ]);
    }
    Ok(())
}

/// Runs the study.
pub(super) fn run(session: &PaperSession) -> Result<()> {
    Layout::of(&session.scene).write(&session.data("layout.json"))?;
    let mut drive = Table::new([
        "path",
        "t_s",
        "x_m",
        "y_m",
        "heading_rad",
        "v_mps",
        "omega_radps",
        "v_odometry_mps",
        "omega_odometry_radps",
    ]);
    for name in ["mapping", "localization"] {
        let recording = session
            .recordings
            .read(&session.recordings.spec(name, None), false)?;
        add_drive(&mut drive, &session.scene, name, &recording)?;
    }
    drive.write(&session.data("drive.csv"))?;
    let map = session.measurements.map(None, &session.parameters)?;
    for (name, layer) in [("map.npy", &map.intensity), ("map_toa.npy", &map.toa_only)] {
        atomic::write_with(&session.data(name), |file| {
            Ok(ndarray_npy::write_npy(file, layer)?)
        })?;
    }
    let place = serde_json::json!({"origin_m": map.origin_m(), "cell_m": map.cell_m});
    atomic::write(&session.data("map.json"), format!("{place:#}\n").as_bytes())
}
