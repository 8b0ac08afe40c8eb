//! `echolot map`.

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::ValueEnum;
use localizer::image::map_image;
use localizer::{EchoSequence, Pose, Recording, echo, landmarks};

use super::arguments::{ForceArgument, ParameterArguments, files_of_recording};
use super::output::print_json;
use super::trust::{self, Warnings};
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
        let (mut warnings, mut codes) = (Warnings::default(), Vec::new());
        for (index, folder) in self.recordings.iter().enumerate() {
            interrupt::check()?;
            let recording = Recording::read(folder)?;
            warnings.extend(trust::changed(folder));
            let Some(truth) = &recording.truth else {
                bail!(
                    "{}: truth.tum: is missing; a map needs the true poses of its drive",
                    folder.display()
                );
            };
            let wanted = parameters.for_recording(&recording.meta);
            warnings.extend(trust::ignored(
                self.parameters.parameters.as_deref(),
                &wanted,
            ));
            let sequence = echo::measure(&recording, &wanted)?;
            let code = trust::check_echoes(&recording, &sequence, folder, &mut warnings)?;
            codes.push(code.map(rounded));
            drives.push(trust::covered(sequence, truth, folder, &mut warnings)?);
            task.set(index as u64 + 1);
        }
        task.finish();
        let warnings = warnings.tell();
        if self.method == MethodArgument::Landmarks {
            return super::landmarks::map(&drives, &self.output, json);
        }
        let parts: Vec<(&EchoSequence, &[Pose])> = drives
            .iter()
            .map(|(sequence, poses)| (sequence, poses.as_slice()))
            .collect();
        let map = map_image::build(&parts)?;
        manifest::put_into(&self.output, |folder| Ok(map.write(folder)?))?;
        let (rows, columns) = map.intensity.dim();
        if json {
            return print_json(&serde_json::json!({
                "map": self.output,
                "rows": rows,
                "columns": columns,
                "cell_m": map.cell_m,
                "origin_m": map.origin_m(),
                "blocks": drives.iter().map(|(sequence, _)| sequence.blocks.len()).collect::<Vec<_>>(),
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
