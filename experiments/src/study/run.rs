//! Running a study: simulations, trials, results.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use anyhow::Result;

use super::claims::Trials;
use super::plan::Plan;
use super::scores::{self, Row};
use super::summary::{CellScores, StudySummary, markdown};
use super::{Study, maps, tasks};
use crate::data::atomic;
use crate::data::frames::FRAMES;
use crate::data::layout::Layout;
use crate::data::table::{Table, cell};
use crate::metrics::quantile_of_sorted;
use crate::run::provenance::{Provenance, SIMULATIONS, peak_memory_mib};
use crate::session::{Session, Workspace};
use crate::trials::{self, Approach, TrialResult};

/// Steps of a distribution of errors.
const QUANTILES: usize = 200;

/// Does the tasks of a study that are left and writes data and summary into `results`. What is in the cache is not
/// computed again: interrupted, the same call goes on, and several calls at once share the work.
///
/// # Errors
/// The first failure of a simulation, trial or file, or an interruption by the user.
pub fn run(
    study: &Study,
    plan: &Plan,
    workspace: &Workspace,
    results: &Path,
) -> Result<StudySummary> {
    let mut seconds = BTreeMap::new();
    let mut stage = |name: &str, started: Instant| {
        let rounded = (started.elapsed().as_secs_f64() * 10.0).round() / 10.0;
        seconds.insert(name.to_string(), rounded);
    };
    let started = Instant::now();
    tasks::simulate(plan, workspace)?;
    stage(SIMULATIONS, started);
    let started = Instant::now();
    tasks::run_trials(study, plan, workspace)?;
    stage("trials", started);
    gather(study, plan, workspace, results, seconds)
}

/// Writes data and summary of a study whose tasks are all done into `results`; `seconds` are the durations of stages
/// before.
///
/// # Errors
/// When a task is not done, or a file cannot be written.
pub fn gather(
    study: &Study,
    plan: &Plan,
    workspace: &Workspace,
    results: &Path,
    seconds: BTreeMap<String, f64>,
) -> Result<StudySummary> {
    let found = tasks::results(study, plan, workspace)?;
    let provenance = Provenance {
        seconds,
        peak_memory_mib: peak_memory_mib(),
        ..Provenance::here()
    };
    let methods = study.methods();
    let rows: Vec<Row> = plan
        .trials
        .iter()
        .zip(&found)
        .map(|(planned, result)| Row::of(planned.cell, planned.method, planned.draw, result))
        .collect();
    let data = results.join("data");
    scores::write(&data.join("trials.csv"), &rows, &study.cells, &methods)?;
    write_distributions(study, plan, &found, &data)?;
    write_paths(study, plan, &found, &data)?;
    maps::write(study, plan, workspace, &data)?;
    write_frames(study, plan, workspace, &data)?;
    let trials = Trials {
        cells: &study.cells,
        methods: &methods,
        rows: rows.iter().collect(),
    };
    let claims = study.file.claims.iter().map(|claim| claim.judge(&trials));
    let summary = StudySummary {
        study: study.file.clone(),
        provenance,
        cells: CellScores::all(study, &rows),
        claims: claims.collect(),
    };
    summary.write(&results.join("summary.json"))?;
    atomic::write(&results.join("report.md"), markdown(&summary).as_bytes())?;
    Ok(summary)
}

/// Writes the distribution of the errors of each cell and method, over all its trials and times.
fn write_distributions(
    study: &Study,
    plan: &Plan,
    found: &[TrialResult],
    data: &Path,
) -> Result<()> {
    let mut errors: BTreeMap<(usize, usize), Vec<f64>> = BTreeMap::new();
    for (planned, result) in plan.trials.iter().zip(found) {
        errors
            .entry((planned.cell, planned.method))
            .or_default()
            .extend(&result.error_m);
    }
    let methods = study.methods();
    let mut table = Table::new(["cell", "method", "share", "error_m"]);
    for ((number, method), mut errors) in errors {
        errors.sort_by(f64::total_cmp);
        for step in 0..=QUANTILES {
            let share = step as f64 / QUANTILES as f64;
            if errors.is_empty() {
                continue;
            }
            table.push([
                study.cells[number].name(),
                methods[method].name().to_string(),
                cell(share, 4),
                cell(quantile_of_sorted(&errors, share), 5),
            ]);
        }
    }
    table.write(&data.join("distribution.csv"))
}

/// Writes what the first trial of a method heard and believed in the first cell whose paths are drawn: of several
/// methods the first one that listens, landmarks before images.
fn write_frames(study: &Study, plan: &Plan, workspace: &Workspace, data: &Path) -> Result<()> {
    let file = data.join(FRAMES);
    let Some(index) = study.shown_cell() else {
        return Ok(());
    };
    let order = [Approach::Landmarks, Approach::Slam, Approach::Images];
    let rank = |approach: Approach| order.iter().position(|own| *own == approach);
    let mut listening: Vec<_> = (plan.trials.iter())
        .filter(|planned| planned.cell == index && rank(planned.trial.approach).is_some())
        .collect();
    listening.sort_by_key(|planned| (rank(planned.trial.approach), planned.method));
    listening.dedup_by_key(|planned| planned.method);
    for planned in listening {
        let session = Session::new(plan.setups[planned.session].clone(), workspace)?;
        let name = study.methods()[planned.method].name();
        // A trial that failed, or whose recording is no longer there, shows nothing.
        if let Ok(Some(frames)) = trials::watch(&session, &planned.trial, name) {
            return frames.write(&file);
        }
    }
    if file.exists() {
        std::fs::remove_file(&file)?;
    }
    Ok(())
}

/// Writes walls, truth and estimates of the first trial of each method in the cells whose paths are drawn; of cells
/// that are not in the plan nothing.
fn write_paths(study: &Study, plan: &Plan, found: &[TrialResult], data: &Path) -> Result<()> {
    for (number, index) in study.drawn_cells().into_iter().enumerate() {
        let header = ["method", "t_s", "x_m", "y_m", "heading_rad", "error_m"];
        let mut table = Table::new(header);
        let mut add = |method: &str, t_s: f64, [x_m, y_m, heading_rad, error_m]: [f64; 4]| {
            let places = [x_m, y_m, heading_rad, error_m].map(|value| cell(value, 4));
            table.push([method.to_string(), cell(t_s, 3)].into_iter().chain(places));
        };
        let mut drawn = Vec::new();
        for (planned, result) in plan.trials.iter().zip(found) {
            if planned.cell != index || drawn.contains(&planned.method) {
                continue;
            }
            if drawn.is_empty() {
                let scene = &plan.setups[planned.session].scene;
                Layout::of(scene).write(&data.join(format!("layout_{number}.json")))?;
                let path = scene.path("localization")?;
                let steps = (path.duration_s() * 10.0) as usize;
                for step in 0..=steps {
                    let t_s = 0.1 * step as f64;
                    let state = path.state_at(t_s);
                    add("truth", t_s, [state.x_m, state.y_m, state.heading_rad, 0.0]);
                }
            }
            drawn.push(planned.method);
            let name = study.methods()[planned.method].name();
            for (k, &t_s) in result.t_s.iter().enumerate() {
                let place = [result.x_m[k], result.y_m[k], result.heading_rad[k]];
                let [x_m, y_m, heading_rad] = place;
                add(name, t_s, [x_m, y_m, heading_rad, result.error_m[k]]);
            }
        }
        let file = data.join(format!("paths_{number}.csv"));
        if !drawn.is_empty() {
            table.write(&file)?;
        } else if file.exists() {
            // Of another run, in which the cell was one of those that were chosen.
            std::fs::remove_file(&file)?;
        }
    }
    Ok(())
}
