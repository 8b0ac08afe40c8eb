//! `echolot map`.

use std::path::PathBuf;

use anyhow::Result;
use clap::ValueEnum;
use localizer::landmarks;

use super::alignment::AlignmentArguments;
use super::arguments::{ForceArgument, ParameterArguments, files_of_recording};
use super::output::print_json;
use crate::data::manifest;
use crate::data::place::Place;
use crate::drive::Drive;
use crate::mapping::{Map, MapKind, Mapping};
use crate::metrics::rounded;
use crate::run::interrupt;
use crate::run::progress::Board;
use crate::trust::{self, Warnings};

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
    fn kind(self) -> MapKind {
        match self {
            Self::Images => MapKind::Images,
            Self::Landmarks => MapKind::Landmarks,
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
        place.files_in_folder(self.method.kind().files())
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
        let mut mapping = Mapping::new(self.method.kind(), parameters);
        let mut warnings = Warnings::default();
        for (index, folder) in self.recordings.iter().enumerate() {
            interrupt::check()?;
            let source = self.alignment.open(folder)?;
            warnings.extend(trust::changed(folder));
            let own = mapping.parameters().for_recording(&source.meta);
            warnings.extend(trust::ignored(self.parameters.parameters.as_deref(), &own));
            mapping.add(&Drive::of_folder(&source, folder), &mut warnings)?;
            task.set(index as u64 + 1);
        }
        task.finish();
        let warnings = warnings.tell();
        let (map, report) = mapping.finish()?;
        let map = match map {
            Map::Images(map) => map,
            Map::Landmarks(map) => return super::landmarks::write_map(&map, &self.output, json),
        };
        manifest::put_into(&self.output, |folder| Ok(map.write(folder)?))?;
        let (rows, columns) = map.intensity.dim();
        if json {
            return print_json(&serde_json::json!({
                "map": self.output,
                "rows": rows,
                "columns": columns,
                "cell_m": map.cell_m,
                "origin_m": map.origin_m(),
                "blocks": report.blocks,
                "code_found": report.codes.iter().map(|code| code.map(rounded)).collect::<Vec<_>>(),
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
