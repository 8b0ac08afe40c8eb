//! The maps of the cells that a `map` figure names.

use std::path::Path;

use anyhow::Result;

use super::Study;
use super::plan::{Plan, PlannedTrial};
use crate::data::layout::Layout;
use crate::data::map_place::MapPlace;
use crate::data::{atomic, manifest};
use crate::session::{Session, Workspace};
use crate::trials::{self, Surroundings};

/// How the names of all files here begin.
const PREFIX: &str = "map_";

/// Writes layout and maps of the first trial of each method in the cells whose maps are drawn; of methods with the same
/// kind of map the first one's.
///
/// # Errors
/// When a recording is missing or cannot be used, or a file cannot be written.
pub(super) fn write(study: &Study, plan: &Plan, workspace: &Workspace, data: &Path) -> Result<()> {
    // A study that has changed leaves no map of before.
    for entry in std::fs::read_dir(data)?.flatten() {
        if entry.file_name().to_string_lossy().starts_with(PREFIX) {
            match entry.file_type()?.is_dir() {
                true => std::fs::remove_dir_all(entry.path())?,
                false => std::fs::remove_file(entry.path())?,
            }
        }
    }
    for (number, cell) in study.mapped_cells().into_iter().enumerate() {
        let file = |ending: &str| data.join(format!("{PREFIX}{number}{ending}"));
        let mut is_there = [false; 2];
        for method in 0..study.methods().len() {
            let is_own = |planned: &&PlannedTrial| (planned.cell, planned.method) == (cell, method);
            let Some(planned) = plan.trials.iter().find(is_own) else {
                continue;
            };
            let session = Session::new(plan.setups[planned.session].clone(), workspace)?;
            Layout::of(&session.scene).write(&file("_layout.json"))?;
            match trials::surroundings(&session, &planned.trial)? {
                Some(Surroundings::Image(map)) if !is_there[0] => {
                    is_there[0] = true;
                    atomic::write_with(&file(".npy"), |file| {
                        Ok(ndarray_npy::write_npy(file, &map.intensity)?)
                    })?;
                    let place = MapPlace {
                        origin_m: map.origin_m(),
                        cell_m: map.cell_m,
                    };
                    let text = serde_json::to_string_pretty(&place)? + "\n";
                    atomic::write(&file(".json"), text.as_bytes())?;
                }
                Some(Surroundings::Landmarks(map)) if !is_there[1] => {
                    is_there[1] = true;
                    manifest::put_into(&file("_landmarks"), |new| Ok(map.write(new)?))?;
                }
                _ => {}
            }
        }
    }
    Ok(())
}
