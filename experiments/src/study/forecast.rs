//! How long the trials of a study will take and what memory they need: by those that ran before with the same cache.

use std::collections::BTreeMap;
use std::fmt::Write;

use anyhow::Result;
use serde::{Deserialize, Serialize};

use super::Study;
use super::plan::{Batch, Plan};
use crate::run::progress::duration;
use crate::session::Workspace;

/// Kind of the entries in the cache.
const KIND: &str = "speeds";
/// Weight of the newest batch beside all before.
const NEWEST: f64 = 0.5;

/// Seconds that a trial of a method takes for a second of its drive, the measurement of echoes that trials share
/// included.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Speed {
    seconds_per_second: f64,
}

impl Plan {
    /// Notes how long so many trials of a batch took. It serves forecasts: failing to write it is no error.
    pub(super) fn note_speed(
        &self,
        study: &Study,
        batch: &Batch,
        (trials, seconds): (usize, f64),
        workspace: &Workspace,
    ) {
        let Some(&first) = batch.members.first().filter(|_| trials > 0) else {
            return;
        };
        let driven_s = trials as f64 * self.drive_s(first);
        let name = self.method(study, first);
        let newest = seconds / driven_s.max(1e-3);
        let before: Option<Speed> = workspace.cache.get(KIND, name);
        let seconds_per_second = before.map_or(newest, |before| {
            NEWEST * newest + (1.0 - NEWEST) * before.seconds_per_second
        });
        let _ = workspace
            .cache
            .put(KIND, name, &Speed { seconds_per_second });
    }

    /// Time and memory of the trials that are missing, for people; nothing when none is.
    ///
    /// # Errors
    /// None but those of writing to a string.
    pub(super) fn trials_text(&self, study: &Study, workspace: &Workspace) -> Result<String> {
        let mut driven: BTreeMap<&'static str, f64> = BTreeMap::new();
        let mut most_bytes = 0.0_f64;
        for (index, planned) in self.trials.iter().enumerate() {
            if !workspace.cache.has("trials", &planned.key) {
                let drive_s = self.drive_s(index);
                *driven.entry(self.method(study, index)).or_default() += drive_s;
                let parameters = &planned.trial.parameters;
                let directions = parameters.measurement.directions as f64 + 2.0;
                let block = directions * parameters.delays() as f64 * size_of::<f32>() as f64;
                most_bytes = most_bytes.max(block * drive_s / parameters.period_s());
            }
        }
        let mut text = String::new();
        if driven.is_empty() {
            return Ok(text);
        }
        let (mut seconds, mut unknown) = (0.0, Vec::new());
        for (name, driven_s) in &driven {
            match workspace.cache.get::<Speed>(KIND, name) {
                Some(speed) => seconds += driven_s * speed.seconds_per_second,
                None => unknown.push(*name),
            }
        }
        write!(text, "trials: ")?;
        if unknown.len() < driven.len() {
            write!(text, "about {} by those that ran before", duration(seconds))?;
        }
        if !unknown.is_empty() {
            let separator = if unknown.len() < driven.len() {
                "; "
            } else {
                ""
            };
            let names = unknown.join(", ");
            write!(
                text,
                "{separator}how long {names} take is known once one has run"
            )?;
        }
        writeln!(
            text,
            "; the echoes of a drive take at most {:.0} MiB",
            most_bytes / (1024.0 * 1024.0)
        )?;
        Ok(text)
    }

    /// Length of a trial's drive in seconds.
    fn drive_s(&self, trial: usize) -> f64 {
        let scene = &self.setups[self.trials[trial].session].scene;
        scene
            .path("localization")
            .map_or(0.0, |path| path.duration_s())
    }

    /// Name of a trial's method.
    fn method(&self, study: &Study, trial: usize) -> &'static str {
        study.methods()[self.trials[trial].method].name()
    }
}
