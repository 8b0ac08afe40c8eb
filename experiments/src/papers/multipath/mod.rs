//! Position from multipath arrival times by planes and a Kalman filter (Tsuchiya et al., 2021), in a room and on the
//! session's scene.

mod paths;
mod scene;

use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::{Context, Result};
use localizer::filter::motion_model::dead_reckon;
use localizer::multipath::arrivals;
use localizer::multipath::ekf::follow;
use localizer::multipath::prediction::{Model, Predictor};
use localizer::{Recording, Trajectory};
use rayon::prelude::*;

use self::paths::{COLUMNS, Errors, accuracy, errors, write_path};
use crate::data::table::{Table, cell};
use crate::metrics::{mean, rounded};
use crate::papers::PaperSession;
use crate::recordings::multipath_room::{CEILING_M, CORNERS_M, HEIGHTS_M, Site};
use crate::run::interrupt;
use crate::summary::{FollowedPath, Multipath, MultipathGate, Summary};
use crate::trials::arrivals::{GATE_M, PICKING, noise};

/// Trials: seeds of noise and slip.
const TRIALS: u64 = 10;
/// Methods in the data files.
const METHODS: [(&str, Option<Model>); 4] = [
    ("single", Some(Model::Single)),
    ("planar", Some(Model::Planar)),
    ("spatial", Some(Model::Spatial)),
    ("odometry", None),
];

/// Round trips at which peaks are picked: beyond the direct wave and the floor's echo, up to the longest double echoes,
/// metres.
const ROUND_TRIP_M: [f64; 2] = [1.2, 9.0];

/// Gates tried; the widest lets nearly every peak pass, as eq. (4) without a gate does.
const GATES_M: [f64; 8] = [0.1, 0.15, 0.2, GATE_M, 0.3, 0.4, 0.6, 1.0];

/// Writes the room's plan and the true path.
fn write_room(session: &PaperSession, recording: &Recording) -> Result<()> {
    let mut room = Table::new(["x_m", "y_m", "ceiling_m"]);
    for [x, y] in CORNERS_M {
        room.push([x, y, CEILING_M].map(|value| cell(value, 3)));
    }
    room.write(&session.data("multipath_room.csv"))?;
    let mut drive = Table::new(["t_s", "x_m", "y_m"]);
    if let Some(truth) = &recording.truth {
        for (t_s, pose) in truth.t_s.iter().zip(&truth.poses).step_by(10) {
            drive.push([cell(*t_s, 2), cell(pose.x_m, 4), cell(pose.y_m, 4)]);
        }
    }
    drive.write(&session.data("multipath_drive.csv"))
}

/// Results of one trial.
struct Trial {
    /// Method, gate in metres and mean error in metres.
    gates: Vec<(&'static str, f64, f64)>,
    /// Path and errors of each method at the usual gate.
    followed: Vec<(&'static str, Trajectory, Errors)>,
}

/// One trial of all methods.
fn run_trial(site: &Site, recording: &Recording) -> Result<Trial> {
    let c_mps = site.parameters.signal.speed_of_sound_mps;
    let blocks = arrivals::measure(recording, &site.parameters, &PICKING, ROUND_TRIP_M)?;
    let start = recording.start_pose();
    let (mut gates, mut followed) = (Vec::new(), Vec::new());
    for (method, model) in METHODS {
        let trajectory = match model {
            Some(model) => {
                let predictor = Predictor::new(&site.planes, model, HEIGHTS_M, c_mps);
                let mut usual = None;
                for gate_m in GATES_M {
                    let path = follow(&blocks, &predictor, noise(c_mps, gate_m), start);
                    gates.push((method, gate_m, mean(&errors(&path, recording)?.position_m)));
                    if gate_m == GATE_M {
                        usual = Some(path);
                    }
                }
                usual.context("the usual gate is not among those tried")?
            }
            None => dead_reckon(recording, &site.parameters, start),
        };
        let found = errors(&trajectory, recording)?;
        followed.push((method, trajectory, found));
    }
    Ok(Trial { gates, followed })
}

/// Runs the study.
pub(crate) fn run(session: &PaperSession, summary: &mut Summary) -> Result<()> {
    let site = Site::simulate(&session.cache)?;
    let mut paths = Table::new(COLUMNS);
    let mut gates = Table::new(["method", "gate_m", "trial", "mae_m"]);
    let mut followed: [Vec<Errors>; 4] = Default::default();
    let task = session.board.task("multipath", TRIALS);
    let done = AtomicU64::new(0);
    // Trials run in parallel; tables keep their order.
    let trials = (0..TRIALS).into_par_iter().map(|trial| {
        interrupt::check()?;
        let recording = site.recording(trial);
        if trial == 0 {
            write_room(session, &recording)?;
        }
        let found = run_trial(&site, &recording)?;
        task.set(done.fetch_add(1, Ordering::Relaxed) + 1);
        Ok(found)
    });
    let trials: Vec<Trial> = trials.collect::<Result<_>>()?;
    for (trial, found) in (0..).zip(trials) {
        for (method, gate_m, error_m) in found.gates {
            gates.push([
                method.to_string(),
                cell(gate_m, 2),
                trial.to_string(),
                cell(error_m, 4),
            ]);
        }
        for ((method, trajectory, errors), list) in found.followed.into_iter().zip(&mut followed) {
            write_path(&mut paths, method, trial, &trajectory, &errors);
            list.push(errors);
        }
    }
    paths.write(&session.data("multipath.csv"))?;
    gates.write(&session.data("multipath_gates.csv"))?;
    let [single, planar, spatial, odometry] = followed.map(|trials| FollowedPath {
        final_m: rounded(mean(
            &trials
                .iter()
                .filter_map(|errors| errors.position_m.last().copied())
                .collect::<Vec<f64>>(),
        )),
        accuracy: accuracy(&trials),
    });
    summary.multipath = Some(Multipath {
        single,
        planar,
        spatial,
        odometry,
        gates: by_gate(&gates)?,
        scene: scene::run(session)?,
    });
    Ok(())
}

/// Mean errors over the trials at each gate.
fn by_gate(gates: &Table) -> Result<Vec<MultipathGate>> {
    let at = |method: &str, gate_m: f64| -> Result<f64> {
        let rows = gates
            .only("method", method)?
            .only("gate_m", &cell(gate_m, 2))?;
        Ok(rounded(mean(&rows.numbers("mae_m")?)))
    };
    GATES_M
        .iter()
        .map(|&gate_m| {
            Ok(MultipathGate {
                gate_m,
                single_m: at("single", gate_m)?,
                planar_m: at("planar", gate_m)?,
                spatial_m: at("spatial", gate_m)?,
            })
        })
        .collect()
}
