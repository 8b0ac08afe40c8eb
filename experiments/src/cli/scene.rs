//! `echolot scene`.

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::{Subcommand, ValueEnum};
use fdtd::scene::{LayoutKind, Scene, random};

use super::arguments::ForceArgument;
use super::output::{print, print_json};
use crate::data::atomic;
use crate::data::place::Place;
use crate::figures::drawing::png;
use crate::figures::field;
use crate::figures::scene::draw;
use crate::recordings::{impulse_snapshot, preflight};

/// Arguments of `scene`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot scene check scenes/four_walls.json\n  echolot scene draw \
    scenes/four_walls.json -o scene.png"
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Check a scene file and print its contents.
    #[command(after_help = "Example:\n  echolot scene check scenes/quick.json --json")]
    Check {
        /// The scene file.
        file: PathBuf,
    },
    /// Draw walls, drive paths and absorbing layer, or the sound of a click among the walls.
    #[command(
        after_help = "Example:\n  echolot scene draw scenes/quick.json -o quick.png\n  \
        echolot scene draw scenes/four_walls.json --click localization --after 0.008 -o field.png"
    )]
    Draw {
        /// The scene file.
        file: PathBuf,
        /// The picture (PNG).
        #[arg(short, long, value_name = "PNG")]
        output: PathBuf,
        /// Draw the sound field after a click at the start of this drive path instead.
        #[arg(long, value_name = "NAME", requires = "after")]
        click: Option<String>,
        /// Time since the click, seconds.
        #[arg(long, value_name = "SECONDS", requires = "click")]
        after: Option<f64>,
        #[command(flatten)]
        force: ForceArgument,
    },
    /// Draw walls, air and two drives of 40 s at random, and write them as a scene file.
    #[command(
        after_help = "Example:\n  echolot scene random --kind room --seed 7 -o room_7.json\n\n\
        Equal kinds and seeds give equal files. Drives are called mapping and localization."
    )]
    Random {
        /// Arrangement of the walls.
        #[arg(long, value_enum)]
        kind: Kind,
        /// Seed of the layout and its drives.
        #[arg(long, value_name = "N")]
        seed: u64,
        /// The scene file.
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
        #[command(flatten)]
        force: ForceArgument,
    },
    /// Print the JSON schema of scene files.
    #[command(after_help = "Example:\n  echolot scene schema > scenes/scene.schema.json")]
    Schema,
}

/// Arrangement of the walls of a random layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Three to five single walls.
    Open,
    /// A rectangular room in any orientation, with gaps.
    Room,
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        match self.command {
            Command::Check { file } => {
                let scene = Scene::load(&file)?;
                preflight::check_scene(&scene, &file.display().to_string())?;
                check(&scene, json)
            }
            Command::Draw {
                file,
                output,
                click,
                after,
                force,
            } => {
                let place = Place {
                    inputs: vec![file.clone()],
                    ..Place::of(&output, force.force)
                };
                let scene = Scene::load(&file)?;
                place.file(png::is_ours)?;
                match click.zip(after) {
                    Some((_, after_s)) if !(after_s > 0.0 && after_s <= 1.0) => {
                        bail!("--after: {after_s} is out of range; give more than 0 to 1 s")
                    }
                    Some((path, after_s)) => {
                        let frame = impulse_snapshot::frame(&scene, &path, after_s)?;
                        field::draw(&scene, &path, after_s, frame, &output)?;
                    }
                    None => draw(&scene, &output)?,
                }
                eprintln!("wrote {}", output.display());
                Ok(())
            }
            Command::Random {
                kind,
                seed,
                output,
                force,
            } => {
                Place::of(&output, force.force).file(is_random)?;
                let kind = match kind {
                    Kind::Open => LayoutKind::Open,
                    Kind::Room => LayoutKind::Room,
                };
                let text = serde_json::to_string_pretty(&random::layout(kind, seed))?;
                atomic::write(&output, text.as_bytes())?;
                eprintln!("wrote {}", output.display());
                Ok(())
            }
            Command::Schema => print_json(&Scene::json_schema()),
        }
    }
}

/// Whether a scene file is what `scene random` writes.
fn is_random(bytes: &[u8]) -> bool {
    let scene: serde_json::Value = serde_json::from_slice(bytes).unwrap_or_default();
    let drawn = || {
        let words = scene["description"].as_str()?;
        let (kind, seed) = words
            .split_once("kind ")?
            .1
            .trim_end_matches('.')
            .split_once(", seed ")?;
        let kinds = [LayoutKind::Open, LayoutKind::Room];
        let kind = kinds.into_iter().find(|known| known.name() == kind)?;
        Some(random::layout(kind, seed.parse().ok()?))
    };
    drawn() == Some(scene.clone())
}

/// Prints the contents of a scene.
fn check(scene: &Scene, json: bool) -> Result<()> {
    let [width_m, height_m] = scene.grid.size_m();
    let courant = scene.grid.courant(&scene.medium);
    let upper_hz = scene.waveform.band_hz[1];
    let cells_per_wavelength = scene.medium.c_mps / upper_hz / scene.grid.dx_m;
    if json {
        let paths: serde_json::Map<String, serde_json::Value> = scene
            .paths
            .iter()
            .map(|(name, path)| {
                (
                    name.clone(),
                    serde_json::json!({"duration_s": path.duration_s()}),
                )
            })
            .collect();
        return print_json(&serde_json::json!({
            "name": scene.name,
            "cells": scene.grid.cells(),
            "size_m": [width_m, height_m],
            "scheme": scene.scheme,
            "spread": scene.spread,
            "courant": courant,
            "cells_per_wavelength": cells_per_wavelength,
            "walls": scene.walls.len(),
            "paths": paths,
        }));
    }
    let mut text = format!(
        "{}: ok\n  grid      {} x {} cells, {width_m} m x {height_m} m, Courant number {courant:.4}\n",
        scene.name, scene.grid.nx, scene.grid.ny
    );
    text += &format!(
        "  scheme    {}, {cells_per_wavelength:.2} cells per wavelength at {upper_hz} Hz\n  walls     {}\n",
        scene.scheme.name(),
        scene.walls.len()
    );
    for (name, path) in &scene.paths {
        text += &format!("  path      {name}, {:.1} s\n", path.duration_s());
    }
    print(&text)
}
