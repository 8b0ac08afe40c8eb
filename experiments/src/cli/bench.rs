//! `echolot bench`.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use fdtd::field::probe;

use super::print_json;
use crate::bench::{SMALLEST, measure};
use crate::{atomic, progress::Board};

/// Sides of the squares measured when no size is given.
const SIDES: [usize; 6] = [256, 512, 1000, 2000, 4000, 8000];

/// More threads than any grid has strips for.
const MOST_THREADS: usize = 1024;

/// Arguments of `bench`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  echolot bench --cells 1000x1000 --threads 2")]
pub(crate) struct Arguments {
    /// One grid instead of squares from 256 to 8000 cells.
    #[arg(long, value_name = "NXxNY")]
    cells: Option<String>,
    /// Steps per row [default: about 1 s].
    #[arg(long, value_name = "N")]
    steps: Option<usize>,
    /// Threads of the fast engine [default: rows for 1 and for all cores].
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
}

/// Bytes that a run on this grid needs: two fields of the engine, mask and walls; none on overflow.
fn needed_bytes(nx: usize, ny: usize) -> Option<usize> {
    nx.checked_mul(ny)?.checked_mul(12)
}

/// Memory that is free, in bytes; unlimited where the system does not tell.
fn available_bytes() -> usize {
    let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    text.lines()
        .find_map(|line| {
            line.strip_prefix("MemAvailable:")?
                .trim()
                .strip_suffix(" kB")?
                .parse::<usize>()
                .ok()
        })
        .map_or(usize::MAX, |kib| kib.saturating_mul(1024))
}

/// Reads `NXxNY`.
fn parse(text: &str) -> Result<(usize, usize)> {
    let sides = text
        .split_once('x')
        .and_then(|(x, y)| Some((x.parse().ok()?, y.parse().ok()?)));
    let (nx, ny): (usize, usize) =
        sides.with_context(|| format!("--cells {text}: should read NXxNY, as 1000x1000"))?;
    ensure!(
        nx >= SMALLEST && ny >= SMALLEST,
        "--cells {text}: the layers need at least {SMALLEST} cells a side"
    );
    ensure!(
        needed_bytes(nx, ny).is_some_and(|bytes| bytes <= available_bytes()),
        "--cells {text}: does not fit into the memory"
    );
    Ok((nx, ny))
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        for (flag, value) in [("--steps", self.steps), ("--threads", self.threads)] {
            if value == Some(0) {
                bail!("{flag} 0: should be at least 1");
            }
        }
        if let Some(threads) = self.threads.filter(|&threads| threads > MOST_THREADS) {
            bail!("--threads {threads}: should be at most {MOST_THREADS}");
        }
        let fma = probe::fma_gflops();
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let mut threads = self.threads.map_or_else(|| vec![1, cores], |n| vec![n]);
        threads.dedup();
        let sizes = match &self.cells {
            Some(text) => vec![parse(text)?],
            None => SIDES.map(|side| (side, side)).to_vec(),
        };
        let board = Board::new();
        let task = board.task("bench", sizes.len() as u64);
        let mut rows = Vec::new();
        for (done, &(nx, ny)) in sizes.iter().enumerate() {
            if needed_bytes(nx, ny).is_none_or(|bytes| bytes > available_bytes()) {
                board.say(format!("{nx}x{ny}: left out, does not fit into the memory"));
                continue;
            }
            rows.extend(measure(nx, ny, self.steps, &threads, fma, |row| {
                if !json {
                    board.say(format!(
                        "{:9} {} {nx}x{ny} {} thread(s): {:.2} Gcell/s, {:.2} x reference per thread, {:.0} % of the FMA peak",
                        row.engine, row.scheme, row.threads, row.gcells_per_s, row.ratio_per_thread, 100.0 * row.peak_fraction
                    ));
                }
            })?);
            task.set(done as u64 + 1);
        }
        task.finish();
        if json {
            return print_json(&rows);
        }
        let memory = probe::load_gbps(256 << 20, 1 << 30);
        let first_level = probe::load_gbps(16 << 10, 1 << 33);
        eprintln!(
            "one thread: {fma:.0} Gflop/s (AVX2 FMA), {first_level:.0} GB/s (L1 loads), {memory:.1} GB/s (memory)"
        );
        let data = serde_json::json!({
            "rows": rows, "fma_gflops": fma, "l1_load_gbps": first_level, "memory_gbps": memory,
        });
        atomic::write(
            Path::new("results/bench/bench.json"),
            &serde_json::to_vec_pretty(&data)?,
        )
    }
}
