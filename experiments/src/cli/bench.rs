//! `echolot bench`.

use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};

use super::arguments::{ForceArgument, threads};
use super::output::print_json;
use crate::bench::engines::{Row, measure};
use crate::bench::{SMALLEST, localizer, peaks, subnormal};
use crate::data::atomic;
use crate::data::peaks::Peaks;
use crate::data::place::Place;
use crate::figures;
use crate::run::progress::Board;

/// Sides of the squares measured when no size is given.
const SIDES: [usize; 6] = [256, 512, 1000, 2000, 4000, 8000];

/// Default grid of the comparison between a starting field and a field of normal numbers.
const SUBNORMAL: (usize, usize) = (1000, 1000);

/// Arguments of `bench`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot bench --cells 1000x1000 --threads 2\n\n\
    Without --json it also times the start of a field and the localizer's steps, and writes bench.json, \
    localizer.json and roofline.png: \
    the whole table into results/bench, one grid only where --output says."
)]
pub(crate) struct Arguments {
    /// One grid instead of squares from 256 to 8000 cells.
    #[arg(long, value_name = "NXxNY")]
    cells: Option<String>,
    /// Steps per row [default: about 1 s].
    #[arg(long, value_name = "N")]
    steps: Option<usize>,
    /// Folder of the results [default: results/bench for the whole table, none for one grid].
    #[arg(short, long, value_name = "DIR", conflicts_with = "json")]
    output: Option<PathBuf>,
    /// Threads of the fast engine [default: rows for 1 and for all cores].
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<usize>,
    #[command(flatten)]
    force: ForceArgument,
}

/// Bytes that a run on this grid needs: two fields of the engine, mask and walls; none on overflow.
fn needed_bytes(nx: usize, ny: usize) -> Option<usize> {
    nx.checked_mul(ny)?.checked_mul(12)
}

/// Free memory in bytes; unlimited where the system does not report it.
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

/// A row of the table.
fn line(row: &Row) -> String {
    format!(
        "{:9} {} {}x{} {} thread(s): {:.2} Gcell/s, {:.2} x reference per thread, {:.0} % of the peak ({} flop \
        and {} byte a cell)",
        row.engine,
        row.scheme,
        row.nx,
        row.ny,
        row.threads,
        row.gcells_per_s,
        row.ratio_per_thread,
        100.0 * row.peak_fraction,
        row.flops_per_cell,
        row.bytes_per_cell
    )
}

impl Arguments {
    /// Folder of the results.
    fn folder(&self) -> Option<PathBuf> {
        let whole = self.cells.is_none().then(|| PathBuf::from("results/bench"));
        self.output.clone().or(whole)
    }

    /// Checks the places of the results.
    fn check_output(&self) -> Result<()> {
        let Some(folder) = self.folder() else {
            return Ok(());
        };
        let holds = |bytes: &[u8], field: &str| {
            let value: serde_json::Value = serde_json::from_slice(bytes).unwrap_or_default();
            !value[field].is_null() || !value[0][field].is_null()
        };
        let check = |name: &str, is_ours: &dyn Fn(&[u8]) -> bool| {
            Place::of(folder.join(name), self.force.force).file(is_ours)
        };
        check("bench.json", &|bytes| holds(bytes, "rows"))?;
        check("localizer.json", &|bytes| holds(bytes, "stage"))?;
        // Drawn from the first.
        check("roofline.png", &|_| folder.join("bench.json").exists())
    }

    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        for (flag, value) in [("--steps", self.steps), ("--threads", self.threads)] {
            if value == Some(0) {
                bail!("{flag} 0: should be at least 1");
            }
        }
        self.check_output()?;
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let mut threads = self.threads.map_or_else(|| vec![1, cores], |n| vec![n]);
        threads.dedup();
        let sizes = match &self.cells {
            Some(text) => vec![parse(text)?],
            None => SIDES.map(|side| (side, side)).to_vec(),
        };
        let board = Board::new();
        // The plain engine always has one thread.
        let mut counts = vec![1];
        counts.extend(threads.iter().filter(|&&count| count > 1));
        let peaks: Vec<Peaks> = counts.into_iter().map(peaks::measure).collect();
        let task = board.task("bench", sizes.len() as u64);
        let mut rows = Vec::new();
        for (done, &(nx, ny)) in sizes.iter().enumerate() {
            if needed_bytes(nx, ny).is_none_or(|bytes| bytes > available_bytes()) {
                board.say(format!("{nx}x{ny}: left out, does not fit into the memory"));
                continue;
            }
            rows.extend(measure(nx, ny, self.steps, &threads, &peaks, |row| {
                if !json {
                    board.say(line(row));
                }
            })?);
            task.set(done as u64 + 1);
        }
        task.finish();
        if json {
            return print_json(&rows);
        }
        for peak in &peaks {
            board.say(format!(
                "{} thread(s): {:.0} Gflop/s (fused multiply-adds), {:.0} GB/s (first-level cache), {:.1} GB/s \
                (memory)",
                peak.threads, peak.fma_gflops, peak.l1_load_gbps, peak.memory_gbps
            ));
        }
        let (nx, ny) = self.cells.as_deref().map_or(Ok(SUBNORMAL), parse)?;
        let subnormal = subnormal::measure(nx, ny, self.steps)?;
        for row in &subnormal {
            board.say(format!(
                "{} {nx}x{ny}, first {} steps from silence: {:.2} times the time of a field in full swing \
                ({:.2} and {:.2} Gcell/s); without flushing {:.2} times",
                row.scheme,
                row.steps,
                row.time_ratio,
                row.start_gcells_per_s,
                row.normal_gcells_per_s,
                row.loud_time_ratio
            ));
        }
        let steps = localizer::measure()?;
        for row in &steps {
            board.say(format!(
                "{:12} 1 thread: {:.2} ms running; on the wall median {:.2} ms, 95 % below {:.2} ms; limit {} \
                ms, paper {} ms",
                row.stage, row.running_ms, row.median_ms, row.p95_ms, row.limit_ms, row.paper_ms
            ));
        }
        let Some(folder) = self.folder().filter(|_| !json) else {
            return Ok(());
        };
        let data = serde_json::json!({ "rows": rows, "peaks": peaks, "subnormal": subnormal });
        atomic::write(
            &folder.join("bench.json"),
            &serde_json::to_vec_pretty(&data)?,
        )?;
        atomic::write(
            &folder.join("localizer.json"),
            &serde_json::to_vec_pretty(&steps)?,
        )?;
        if let Some(picture) = figures::draw_bench(&folder)? {
            eprintln!("{}", picture.display());
        }
        Ok(())
    }
}
