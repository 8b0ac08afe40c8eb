//! The studies. Each takes recordings from the laboratory, writes data files, and fills its part of the summary.

mod angular_resolution;
mod dual_circle;
mod engine;
mod layout;
mod multipath;
mod odometry_drift;
mod periods;
mod reflections;
mod schemes;
mod site;
mod snr;
mod step_time;
mod window_size;

use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use localizer::parameters::FilterParameters;
use localizer::{Method, Parameters};

use crate::check::aligned;
use crate::interrupt;
use crate::laboratory::Laboratory;
use crate::metrics::Accuracy;
use crate::preset::Preset;
use crate::provenance::{Provenance, peak_memory_mib};
use crate::simulate::{Take, simulation_seconds};
use crate::summary::Summary;
use crate::trials::Trial;

/// A study.
pub struct Study {
    /// Name on the command line.
    pub name: &'static str,
    /// What it finds, in one line.
    pub about: &'static str,
    /// Its figures.
    pub figures: &'static str,
    /// Presets that run it unless told otherwise.
    pub presets: &'static [Preset],
    /// The recordings it needs.
    takes: fn(&Laboratory) -> Vec<Take>,
    /// Writes its data files and fills its part of the summary.
    run: fn(&Laboratory, &mut Summary) -> Result<()>,
}

const BOTH: &[Preset] = &[Preset::Paper, Preset::Quick];
const PAPER: &[Preset] = &[Preset::Paper];

/// All studies in the order in which they run.
pub const STUDIES: &[Study] = &[
    Study {
        name: "layout",
        about: "walls, drives, speeds and the map image",
        figures: "fig04, fig05",
        presets: BOTH,
        takes: |lab| lab.takes(None),
        run: layout::run,
    },
    Study {
        name: "odometry-drift",
        about: "position error of Doppler, ToA only and odometry with a turn rate that is 0.01 rad/s too high",
        figures: "fig06",
        presets: BOTH,
        takes: |lab| lab.takes(None),
        run: odometry_drift::run,
    },
    Study {
        name: "window-size",
        about: "position error over the half-width of the matched window",
        figures: "fig07",
        presets: BOTH,
        takes: |lab| lab.takes(None),
        run: window_size::run,
    },
    Study {
        name: "reflections",
        about: "reflected intensity over time beside the distances of ray theory",
        figures: "fig08",
        presets: BOTH,
        takes: |lab| lab.takes(None),
        run: reflections::run,
    },
    Study {
        name: "periods",
        about: "position error and paths for several numbers M of periods in a block",
        figures: "fig_periods",
        presets: BOTH,
        takes: |lab| lab.takes(None),
        run: periods::run,
    },
    Study {
        name: "angular-resolution",
        about: "width of one exact echo over the direction for M = 1 to 8, beside theory",
        figures: "fig_angular_resolution",
        presets: BOTH,
        takes: |_| Vec::new(),
        run: angular_resolution::run,
    },
    Study {
        name: "snr",
        about: "position error over the signal-to-noise ratio, eqs. (19)-(21)",
        figures: "fig09",
        presets: PAPER,
        takes: snr::takes,
        run: snr::run,
    },
    Study {
        name: "schemes",
        about: "position error when the field is computed with the standard leapfrog scheme",
        figures: "-",
        presets: PAPER,
        takes: schemes::takes,
        run: schemes::run,
    },
    Study {
        name: "step-time",
        about: "compute time of one step, Doppler bank and filter",
        figures: "fig17",
        presets: BOTH,
        takes: |lab| lab.takes(None),
        run: step_time::run,
    },
    Study {
        name: "dual-circle",
        about: "position from 40 kHz ranges to four receivers beside the tables of Hsu et al. (2021)",
        figures: "fig_dual_circle",
        presets: BOTH,
        takes: |_| Vec::new(),
        run: dual_circle::run,
    },
    Study {
        name: "multipath",
        about: "position from multipath arrival times by planes and a Kalman filter (2021), in a room and on the scene",
        figures: "fig_multipath_paths, fig_multipath_errors, fig_multipath_scene",
        presets: BOTH,
        takes: |lab| lab.takes(None),
        run: multipath::run,
    },
    Study {
        name: "site",
        about: "the experimental site in simulation: slip, noise, a microphone beside the loudspeaker",
        figures: "site/fig11-fig16",
        presets: PAPER,
        // It has a laboratory of its own; `run` asks it what that misses.
        takes: |_| Vec::new(),
        run: site::run,
    },
    Study {
        name: "engine",
        about: "speed of the field computation on the scene",
        figures: "-",
        presets: BOTH,
        takes: |_| Vec::new(),
        run: engine::run,
    },
];

/// Looking up recordings in the cache takes less than this.
const CACHED: Duration = Duration::from_secs(2);

/// Runs studies: first all simulations they need, then one after the other; the summary is written after each.
///
/// # Errors
/// The first failure; what was finished before is on disk, and the same command goes on from there.
pub fn run(lab: &Laboratory, studies: &[&Study]) -> Result<Summary> {
    let path = lab.results().join("summary.json");
    let mut summary = if path.exists() {
        // Stages of earlier runs stay: a run of one study does not forget the others.
        let mut summary = Summary::read(&path)?;
        let earlier = summary.provenance;
        summary.provenance = Provenance {
            seconds: earlier.seconds,
            simulation_seconds: earlier.simulation_seconds,
            peak_memory_mib: earlier.peak_memory_mib,
            ..Provenance::here()
        };
        summary
    } else {
        Summary::new(lab.preset)
    };
    let started = Instant::now();
    let takes: Vec<Take> = studies
        .iter()
        .flat_map(|study| (study.takes)(lab))
        .collect();
    let mut missing = lab.missing(&takes)?;
    if studies.iter().any(|study| study.name == "site") {
        // One queue for both scenes: no lane waits for the other's last simulation between them.
        missing.extend(site::missing(lab)?);
    }
    lab.simulate(&missing)?;
    note_simulations(lab, &takes, &mut summary)?;
    // A run that finds all recordings in the cache does not forget what simulating them took.
    let known = summary.provenance.seconds.contains_key("simulations");
    if !known || started.elapsed() > CACHED {
        stage(&mut summary, "simulations", started);
    }
    for study in studies {
        interrupt::check()?;
        let started = Instant::now();
        (study.run)(lab, &mut summary).with_context(|| format!("study {}", study.name))?;
        stage(&mut summary, study.name, started);
        let provenance = &mut summary.provenance;
        provenance.peak_memory_mib = provenance.peak_memory_mib.max(peak_memory_mib());
        summary.write(&path)?;
        lab.board.say(format!(
            "study {} done in {}",
            study.name,
            crate::progress::duration(started.elapsed().as_secs_f64())
        ));
    }
    Ok(summary)
}

/// Notes how long a stage took.
fn stage(summary: &mut Summary, name: &str, started: Instant) {
    let seconds = (started.elapsed().as_secs_f64() * 10.0).round() / 10.0;
    summary.provenance.seconds.insert(name.to_string(), seconds);
}

/// Notes how long each recording took when it was simulated.
fn note_simulations(lab: &Laboratory, takes: &[Take], summary: &mut Summary) -> Result<()> {
    for take in takes {
        let recording = lab.recording(take, false)?;
        let seconds = simulation_seconds(&recording);
        summary
            .provenance
            .simulation_seconds
            .insert(lab.label(take), seconds);
    }
    Ok(())
}

/// Trials `0..count` of the Doppler method with the scene's scheme and these parameters.
fn doppler_trials(parameters: &Parameters, count: usize) -> Vec<Trial> {
    trials_of(parameters, Method::Doppler, count)
}

/// Trials `0..count` of a method with the scene's scheme.
fn trials_of(parameters: &Parameters, method: Method, count: usize) -> Vec<Trial> {
    (0..count as u64)
        .map(|trial| Trial {
            scheme: None,
            parameters: Parameters {
                filter: FilterParameters {
                    method,
                    ..parameters.filter
                },
                ..parameters.clone()
            },
            trial,
            noise: None,
        })
        .collect()
}

/// Name of a method in data files.
fn method_name(method: Method) -> &'static str {
    match method {
        Method::Doppler => "doppler",
        Method::ToaOnly => "toa-only",
        Method::Odometry => "odometry",
    }
}

/// The accuracies of a summary as a table.
pub fn table(summary: &Summary) -> String {
    let mut rows = vec![
        [
            "study",
            "cell",
            "MAE [m]",
            "95 % interval [m]",
            "90 % below [m]",
            "trials",
        ]
        .map(String::from)
        .to_vec(),
    ];
    let mut add = |study: &str, cell: String, accuracy: &Accuracy| {
        let [low, high] = accuracy.interval_m;
        rows.push(vec![
            study.to_string(),
            cell,
            format!("{:.4}", accuracy.mae_m),
            format!("{low:.4} to {high:.4}"),
            format!("{:.4}", accuracy.p90_m),
            accuracy.trials.to_string(),
        ]);
    };
    if let Some(methods) = &summary.odometry_drift {
        add("odometry-drift", "Doppler".into(), &methods.doppler);
        add("odometry-drift", "ToA only".into(), &methods.toa_only);
        add("odometry-drift", "odometry".into(), &methods.odometry);
    }
    for cell in &summary.window_size {
        add(
            "window-size",
            format!("{} m", cell.half_width_m),
            &cell.accuracy,
        );
    }
    for cell in &summary.periods {
        add("periods", format!("M = {}", cell.m), &cell.accuracy);
    }
    for cell in &summary.snr {
        add("snr", format!("{} dB", cell.snr_db), &cell.accuracy);
    }
    if let Some(site) = &summary.site {
        let methods = &site.odometry_drift;
        add("site", "Doppler".into(), &methods.doppler);
        add("site", "ToA only".into(), &methods.toa_only);
        add("site", "odometry".into(), &methods.odometry);
        for cell in &site.window_size {
            add("site", format!("{} m", cell.half_width_m), &cell.accuracy);
        }
        for cell in &site.snr {
            add("site", format!("{} dB", cell.snr_db), &cell.accuracy);
        }
    }
    if let Some(schemes) = &summary.schemes {
        add("schemes", "slf, Doppler".into(), &schemes.slf.doppler);
        add("schemes", "slf, ToA only".into(), &schemes.slf.toa_only);
    }
    for (cell, accuracy) in summary.multipath.iter().flat_map(multipath::rows) {
        add("multipath", cell.into(), accuracy);
    }
    let mut text = aligned(&rows);
    if let Some(time) = &summary.step_time_ms {
        text.push_str(&format!(
            "step time: Doppler bank {:.2} ms, filter {:.2} ms\n",
            time.doppler_bank, time.filter
        ));
    }
    if let Some(engine) = &summary.engine {
        text.push_str(&format!(
            "engine: {} {:.2} Gcell/s, slf {:.2} Gcell/s, {} threads\n",
            engine.scheme, engine.gcells_per_s, engine.slf_gcells_per_s, engine.threads
        ));
    }
    text
}
