//! `echolot map`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::ValueEnum;
use localizer::image::map_builder::MapBuilder;
use localizer::parameters::SignalParameters;
use localizer::quality::CodeMeter;
use localizer::{EchoSequence, Parameters, Pose, echo, landmarks};

use super::alignment::AlignmentArguments;
use super::arguments::{ForceArgument, ParameterArguments, files_of_recording};
use super::output::print_json;
use super::trust::{self, Cover, Warnings};
use crate::data::manifest;
use crate::data::place::Place;
use crate::metrics::rounded;
use crate::run::interrupt;
use crate::run::progress::Board;

/// Names of the files of a map of landmarks.
pub(super) const LANDMARK_FILES: &[&str] = &[
    "landmarks.json",
    "landmarks.geojson",
    "landmarks.pgm",
    "landmarks.yaml",
];

/// Kind of map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodArgument {
    /// Echo images added up on a grid (the papers' map).
    Images,
    /// Walls and corners learnt from the peaks of the echoes.
    Landmarks,
}

/// Arguments of `map`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot map recordings/mapping -o maps/room\n  \
    echolot map recordings/mapping --method landmarks -o maps/room\n\n\
    A recording is a folder with signal.wav, odometry.csv, recording.json and, for a map, truth.tum."
)]
pub(crate) struct Arguments {
    /// Recording folders with true poses.
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// Folder of the map.
    #[arg(short, long, value_name = "MAP")]
    output: PathBuf,
    /// What the map is made of.
    #[arg(long, value_enum, default_value_t = MethodArgument::Images)]
    method: MethodArgument,
    /// Periods M in a block; 2 for landmarks, else 6 unless given.
    #[arg(long, value_name = "M")]
    periods: Option<usize>,
    #[command(flatten)]
    parameters: ParameterArguments,
    #[command(flatten)]
    alignment: AlignmentArguments,
    #[command(flatten)]
    force: ForceArgument,
}

impl MethodArgument {
    /// Names of the files of such a map.
    fn files(self) -> &'static [&'static str] {
        match self {
            Self::Images => &["map.json", "map.npy", "map_toa.npy", "map.pgm", "map.yaml"],
            Self::Landmarks => LANDMARK_FILES,
        }
    }
}

impl Arguments {
    /// Checks the place of the map.
    fn check_output(&self) -> Result<()> {
        let recordings = self.recordings.iter();
        let mut inputs: Vec<PathBuf> = recordings
            .flat_map(|folder| files_of_recording(folder))
            .collect();
        inputs.extend(self.parameters.parameters.clone());
        inputs.extend(self.alignment.files());
        let place = Place {
            inputs,
            // Some 20 m square in cells of 0.1 m, in two layers.
            bytes: 1 << 20,
            ..Place::of(&self.output, self.force.force)
        };
        place.files_in_folder(self.method.files())
    }

    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        self.check_output()?;
        let mut parameters = self.parameters.read()?;
        let usual = match (self.method, &self.parameters.parameters) {
            (MethodArgument::Landmarks, None) => landmarks::PERIODS,
            _ => parameters.measurement.periods,
        };
        parameters.measurement.periods = self.periods.unwrap_or(usual);
        let board = Board::new();
        let task = board.task("map", self.recordings.len() as u64);
        let mut drives: Vec<(EchoSequence, Vec<Pose>)> = Vec::new();
        let mut images: Option<(MapBuilder, Parameters)> = None;
        let (mut warnings, mut codes, mut blocks) = (Warnings::default(), Vec::new(), Vec::new());
        for (index, folder) in self.recordings.iter().enumerate() {
            interrupt::check()?;
            let source = self.alignment.open(folder)?;
            let Some(truth) = &source.truth else {
                bail!(
                    "{}: truth.tum: is missing; a map needs the true poses of its drive",
                    folder.display()
                );
            };
            source.check_signal()?;
            warnings.extend(trust::changed(folder));
            let own = parameters.for_recording(&source.meta);
            warnings.extend(trust::ignored(self.parameters.parameters.as_deref(), &own));
            let code = if self.method == MethodArgument::Landmarks {
                let (truth, meta) = (truth.clone(), source.meta.clone());
                let sequence = echo::measure(&source.load()?, &own)?;
                let code = CodeMeter::of(&sequence);
                let code = trust::check_echoes(&meta, &code, folder, &mut warnings)?;
                drives.push(trust::covered(sequence, &truth, folder, &mut warnings)?);
                code
            } else {
                if images.is_none() {
                    images = Some((MapBuilder::new(&own)?, own.clone()));
                }
                let Some((map, first)) = &mut images else {
                    continue;
                };
                check_alike(&first.signal, &own.signal, folder)?;
                let mut code = CodeMeter::new(&own);
                let speeds = source.odometry.iter().map(|sample| sample.v_mps);
                let mut cover = Cover::new(truth, speeds, folder, &mut warnings)?;
                source.measure_each(&own, &mut |block, _| {
                    code.add(block);
                    if let Some(pose) = cover.pose_at(block.t_s) {
                        map.add(block, &pose)?;
                    }
                    Ok(true)
                })?;
                let code = trust::check_echoes(&source.meta, &code, folder, &mut warnings)?;
                blocks.push(cover.finish(folder, &mut warnings)?);
                code
            };
            codes.push(code.map(rounded));
            task.set(index as u64 + 1);
        }
        task.finish();
        let warnings = warnings.tell();
        let Some((map, _)) = images else {
            return super::landmarks::map(&drives, &self.output, json);
        };
        let map = map.finish()?;
        manifest::put_into(&self.output, |folder| Ok(map.write(folder)?))?;
        let (rows, columns) = map.intensity.dim();
        if json {
            return print_json(&serde_json::json!({
                "map": self.output,
                "rows": rows,
                "columns": columns,
                "cell_m": map.cell_m,
                "origin_m": map.origin_m(),
                "blocks": blocks,
                "code_found": codes,
                "warnings": warnings,
            }));
        }
        eprintln!(
            "wrote {} ({columns} x {rows} cells of {} m)",
            self.output.display(),
            map.cell_m
        );
        Ok(())
    }
}

/// Refuses drives with other codes or sensors in one map.
fn check_alike(first: &SignalParameters, own: &SignalParameters, folder: &Path) -> Result<()> {
    if first == own {
        return Ok(());
    }
    bail!(
        "{}: was recorded with another code, speed of sound, rate or sensor than the first recording; make a map of \
         recordings of one kind",
        folder.display()
    );
}
