//! `echolot slam`.

use std::path::PathBuf;

use anyhow::{Result, bail};
use fdtd::scene::Scene;
use localizer::Trajectory;
use localizer::io::recording_source::{ReadOptions, RecordingSource};
use localizer::landmarks::{self, Status};

use super::arguments::{ForceArgument, ParameterArguments, files_of_recording};
use super::estimates::{self, Clock};
use super::landmarks::{scored, share, statuses, trajectory, write};
use super::output::{print, print_json};
use super::shown::{self, ShownArguments};
use crate::data::layout::Layout;
use crate::data::place::Place;
use crate::data::{estimate, manifest};
use crate::drive::Drive;
use crate::figures;
use crate::figures::landmarks::{ESTIMATE, NamedPath, TRUTH, WHEELS};
use crate::figures::localization::{Background, Localization};
use crate::localization;
use crate::mapping::MapKind;
use crate::metrics::rounded;
use crate::run::progress::Board;
use crate::trust::Warnings;

/// Arguments of `slam`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot slam recordings/drive -o drive.tum --map-out maps/room --figure map.png\n  \
    echolot localize recordings/other --map maps/room --method landmarks -o other.tum\n\n\
    The map's frame is that of the start: the truth at time 0, the start of recording.json, or the origin. Truth \
    serves nothing else but the error that is printed. A table with covariance and status is written beside \
    EST.tum; blocks that are not to be trusted are lost there."
)]
pub(crate) struct Arguments {
    /// Recording folder.
    recording: PathBuf,
    /// Estimated trajectory (TUM).
    #[arg(short, long, value_name = "EST.tum")]
    output: PathBuf,
    /// Folder for the map of landmarks.
    #[arg(long, value_name = "MAP")]
    map_out: Option<PathBuf>,
    /// Picture of the map and the paths (PNG).
    #[arg(long, value_name = "FILE.png")]
    figure: Option<PathBuf>,
    /// Page with a replay: the map as it grows, the robot, its echoes, error over time (HTML).
    #[arg(long, value_name = "HTML")]
    report: Option<PathBuf>,
    /// Scene file whose walls the picture shows beside those that were found.
    #[arg(long, value_name = "SCENE", requires = "figure")]
    scene: Option<PathBuf>,
    /// Periods M in a block; 2 unless given.
    #[arg(long, value_name = "M")]
    periods: Option<usize>,
    #[command(flatten)]
    parameters: ParameterArguments,
    #[command(flatten)]
    force: ForceArgument,
}

impl Arguments {
    /// Checks the places of trajectory, table and map.
    fn check_output(&self) -> Result<()> {
        let mut inputs = files_of_recording(&self.recording);
        inputs.extend(self.parameters.parameters.clone());
        let place = |path: PathBuf| Place {
            inputs: inputs.clone(),
            ..Place::of(path, self.force.force)
        };
        let table = self.output.with_extension("csv");
        if table == self.output {
            bail!(
                "{}: is the name of the table beside the trajectory; give one that ends in .tum",
                table.display()
            );
        }
        place(self.output.clone()).file(estimate::is_ours)?;
        place(table.clone()).file(estimates::is_table)?;
        self.shown().check(&|path| {
            let mut place = place(path.to_path_buf());
            place.inputs.extend(self.scene.clone());
            place.inputs.extend([self.output.clone(), table.clone()]);
            place
        })?;
        match &self.map_out {
            Some(folder) => place(folder.clone()).files_in_folder(MapKind::Landmarks.files()),
            None => Ok(()),
        }
    }

    /// Picture and page.
    fn shown(&self) -> ShownArguments {
        ShownArguments {
            figure: self.figure.clone(),
            report: self.report.clone(),
        }
    }

    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        self.check_output()?;
        let source = RecordingSource::open(&self.recording, &ReadOptions::default())?;
        for line in source.alignment.told() {
            eprintln!("{}: {line}", self.recording.display());
        }
        let reading_s = Clock::usual(&source).reading_s(&source);
        let layout = match &self.scene {
            Some(file) => Some(Layout::of(&Scene::load(file)?)),
            None => None,
        };
        let mut parameters = self.parameters.read()?;
        let usual = match &self.parameters.parameters {
            None => landmarks::PERIODS,
            Some(_) => parameters.measurement.periods,
        };
        parameters.measurement.periods = self.periods.unwrap_or(usual);
        let parameters = parameters.for_recording(&source.meta);
        let start = source.start_pose();
        let mut warnings = Warnings::default();
        let task = Board::new().task("slam", 1);
        let mut frames = self.shown().frames(&parameters, source.duration_s());
        let drive = localization::without_map(
            &Drive::of_folder(&source, &self.recording),
            &parameters,
            start,
            &mut warnings,
            &mut |[done, all], block, estimator| {
                task.set_length(all);
                task.set(done);
                if let Some(frames) = &mut frames {
                    frames.add(block, &[]);
                    if let Some(map) = estimator.map() {
                        frames.know(block.t_s, map);
                    }
                }
                Ok(())
            },
        )?;
        task.finish();
        let Some(map) = &drive.map else {
            bail!(
                "{}: no landmark was found in it; record longer, drive along curves, and check that the echoes are in \
                the recording",
                self.recording.display()
            );
        };
        let trajectory = trajectory(&drive.estimates);
        let table = write(&self.output, &drive.estimates, reading_s)?;
        if let Some(folder) = &self.map_out {
            manifest::put_into(folder, |new| Ok(map.write(new)?))?;
        }
        let lost = share(&drive.estimates, Status::Lost);
        let walls = (map.landmarks.iter())
            .filter(|landmark| landmark.ends_m().is_some())
            .count();
        let (scored, latest) = scored(source.truth.as_ref(), &drive.estimates);
        let wheels = shown::wheels(&source, &parameters, start);
        if let Some(picture) = &self.figure {
            let title = match &scored.scores {
                Some(scores) => format!("Mean error {:.4} m, without map and truth", scores.mae_m),
                None => format!("{walls} walls and {} points", map.landmarks.len() - walls),
            };
            let paths = paths(source.truth.as_ref(), &wheels, &trajectory);
            figures::landmarks::draw(map, layout.as_ref(), &paths, &title, picture)?;
        }
        scored.warn(&mut warnings);
        if lost > 0.0 {
            warnings.add(
                "from some block on the echoes do not fit the wheels; those poses are the wheels'",
            );
        }
        let told = format!(
            "{walls} walls and {} points explain {:.0} % of all peaks; lost {:.0} % of the drive\n",
            map.landmarks.len() - walls,
            100.0 * map.explained,
            100.0 * lost
        );
        let fit: Vec<f64> = drive.estimates.iter().map(|e| e.fit).collect();
        let shown = Localization {
            map: Background::Landmarks(map),
            path: &trajectory,
            truth: source.truth.as_ref(),
            wheels: &wheels,
            fit: &fit,
            fit_label: ["share", "(c) expected echoes that were found"],
        };
        let name = self.recording.display().to_string();
        let words = shown::words(
            [
                &name,
                "without a map (SLAM); the path as it was known at the end",
            ],
            &scored,
            &told,
            &warnings,
            statuses(&drive.estimates),
        );
        self.shown().write_page(&shown, frames, words)?;
        if json {
            let [turn_rate, speed] = drive.wheel_errors;
            let report = serde_json::json!({
                "estimate": self.output,
                "table": table,
                "map": self.map_out,
                "figure": self.figure,
                "poses": drive.estimates.len(),
                "landmarks": map.landmarks.len(),
                "walls": walls,
                "explained": rounded(map.explained),
                "latest_mae_m": latest.map(|scores| scores.mae_m),
                "warnings": warnings.tell(),
                "status": {"sure": rounded(share(&drive.estimates, Status::Sure)), "lost": rounded(lost)},
                "turn_rate_error_radps": rounded(turn_rate),
                "speed_error": rounded(speed),
            });
            return print_json(&scored.put_into(report));
        }
        eprintln!(
            "wrote {} and {} ({} poses)",
            self.output.display(),
            table.display(),
            drive.estimates.len()
        );
        for written in [&self.map_out, &self.figure].into_iter().flatten() {
            eprintln!("wrote {}", written.display());
        }
        print(&told)?;
        scored.tell()?;
        warnings.tell();
        Ok(())
    }
}

/// Truth where there is one, wheels and estimate.
fn paths(
    truth: Option<&Trajectory>,
    wheels: &Trajectory,
    estimate: &Trajectory,
) -> Vec<NamedPath<'static>> {
    let truth = truth.map(|truth| ("truth", truth, TRUTH));
    truth
        .into_iter()
        .chain([
            ("wheels alone", wheels, WHEELS),
            ("estimate", estimate, ESTIMATE),
        ])
        .map(|(name, trajectory, stroke)| NamedPath {
            name,
            places_m: (trajectory.poses.iter())
                .map(|pose| [pose.x_m, pose.y_m])
                .collect(),
            stroke,
        })
        .collect()
}
