//! `echolot map`.

use std::path::PathBuf;

use anyhow::{Result, bail};
use localizer::image::map_image;
use localizer::{EchoSequence, Pose, Recording, echo};

use super::arguments::ParameterArguments;
use super::output::print_json;
use crate::run::interrupt;
use crate::run::progress::Board;

/// Arguments of `map`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot map recordings/mapping -o maps/room\n\n\
    A recording is a folder with signal.wav, odometry.csv, recording.json and, for a map, truth.tum."
)]
pub(crate) struct Arguments {
    /// Recording folders with true poses.
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// Folder of the map.
    #[arg(short, long, value_name = "MAP")]
    output: PathBuf,
    /// Periods M in a block.
    #[arg(long, value_name = "M")]
    periods: Option<usize>,
    #[command(flatten)]
    parameters: ParameterArguments,
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let mut parameters = self.parameters.read()?;
        parameters.measurement.periods = self.periods.unwrap_or(parameters.measurement.periods);
        let board = Board::new();
        let task = board.task("map", self.recordings.len() as u64);
        let mut drives: Vec<(EchoSequence, Vec<Pose>)> = Vec::new();
        for (index, folder) in self.recordings.iter().enumerate() {
            interrupt::check()?;
            let recording = Recording::read(folder)?;
            let Some(truth) = &recording.truth else {
                bail!(
                    "{}: truth.tum: is missing; a map needs the true poses of its drive",
                    folder.display()
                );
            };
            let sequence = echo::measure(&recording, &parameters.for_recording(&recording.meta))?;
            let poses = sequence.poses(truth);
            drives.push((sequence, poses));
            task.set(index as u64 + 1);
        }
        let parts: Vec<(&EchoSequence, &[Pose])> = drives
            .iter()
            .map(|(sequence, poses)| (sequence, poses.as_slice()))
            .collect();
        let map = map_image::build(&parts)?;
        map.write(&self.output)?;
        let (rows, columns) = map.intensity.dim();
        if json {
            return print_json(&serde_json::json!({
                "map": self.output,
                "rows": rows,
                "columns": columns,
                "cell_m": map.cell_m,
                "origin_m": map.origin_m(),
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
