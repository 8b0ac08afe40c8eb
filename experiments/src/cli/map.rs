//! `echolot map`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::ValueEnum;
use localizer::echo::block_stream::EachBlock;
use localizer::image::map_builder::MapBuilder;
use localizer::parameters::SignalParameters;
use localizer::{EchoSequence, Parameters, Pose, Trajectory, echo, landmarks};

use super::alignment::AlignmentArguments;
use super::arguments::ParameterArguments;
use super::output::print_json;
use crate::run::interrupt;
use crate::run::progress::Board;

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
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
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
        for (index, folder) in self.recordings.iter().enumerate() {
            interrupt::check()?;
            let source = self.alignment.open(folder)?;
            let Some(truth) = &source.truth else {
                bail!(
                    "{}: truth.tum: is missing; a map needs the true poses of its drive",
                    folder.display()
                );
            };
            let own = parameters.for_recording(&source.meta);
            if self.method == MethodArgument::Landmarks {
                let truth = truth.clone();
                let sequence = echo::measure(&source.load()?, &own)?;
                let poses = sequence.poses(&truth);
                drives.push((sequence, poses));
            } else {
                let (map, first) =
                    images.get_or_insert_with(|| (MapBuilder::new(&own), own.clone()));
                check_alike(&first.signal, &own.signal, folder)?;
                add(map, truth, &|each| source.measure_each(&own, each))?;
            }
            task.set(index as u64 + 1);
        }
        let Some((map, _)) = images else {
            return super::landmarks::map(&drives, &self.output, json);
        };
        let map = map.finish()?;
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

/// Hands blocks to a map with their true poses.
type MeasureEach<'a> = dyn Fn(&mut EachBlock<'_>) -> Result<(), localizer::Error> + 'a;

/// Adds the blocks of a drive to a map.
fn add(map: &mut MapBuilder, truth: &Trajectory, measure: &MeasureEach<'_>) -> Result<()> {
    measure(&mut |block, _| {
        let pose = truth.pose_at(block.t_s).unwrap_or_default();
        map.add(block, &pose)?;
        Ok(true)
    })?;
    Ok(())
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
