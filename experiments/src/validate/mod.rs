//! The field against laws of physics: measures them, and writes table and data.

mod data;
mod resume;
mod row;
mod table;

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use anyhow::Result;
use oracles::laws::{Depth, Law, Measurement};
use rayon::prelude::*;

use crate::data::atomic;
use crate::data::table::markdown;
use crate::run::interrupt;
use crate::run::progress::{Board, duration};
use crate::run::provenance::Provenance;

pub use self::resume::Resume;
pub use self::row::Row;
pub use self::table::{laws, table};

/// Measures laws, except those that have been measured with the present sources. Several run in parallel; the order of
/// the rows does not depend on it. Ctrl-C ends the program at once.
///
/// # Errors
/// When a field becomes non-finite, or a file of measurements cannot be written.
pub fn run(laws: &[Law], depth: Depth, resume: Option<&Resume>, anew: bool) -> Result<Vec<Row>> {
    let _at_once = interrupt::at_once();
    let board = Board::new();
    let all: u64 = laws.iter().map(|law| effort(law, depth)).sum();
    let task = board.task("validate", all);
    let known: Vec<_> = (laws.iter())
        .map(|law| resume?.read(law.name).filter(|_| !anew))
        .collect();
    let of_known = laws.iter().zip(&known).filter(|(_, known)| known.is_some());
    let done = AtomicU64::new(of_known.map(|(law, _)| effort(law, depth)).sum());
    task.set(done.load(Ordering::Relaxed));
    if resume.is_some() {
        let (measured, of) = (known.iter().flatten().count(), laws.len());
        board.say(format!(
            "{measured} of {of} laws are measured with the present sources; interrupt at any time, the same command \
            goes on"
        ));
    }
    let measure = |law: &Law| -> Result<Vec<Measurement>> {
        let started = Instant::now();
        let measurements = (law.measure)(depth)?;
        if let Some(resume) = resume {
            resume.write(law.name, &measurements)?;
        }
        let taken = duration(started.elapsed().as_secs_f64());
        board.say(format!("measured {} in {taken}", law.name));
        let effort = effort(law, depth);
        task.set(effort + done.fetch_add(effort, Ordering::Relaxed));
        Ok(measurements)
    };
    let found: Vec<Result<Vec<Row>>> = (laws.par_iter())
        .zip(known)
        .map(|(law, known)| {
            let measurements = known.map_or_else(|| measure(law), Ok)?;
            let rows = measurements.into_iter().map(|measurement| Row {
                law: law.name,
                passed: measurement.passed(),
                measurement,
            });
            Ok(rows.collect())
        })
        .collect();
    task.finish();
    let mut rows = Vec::new();
    for part in found {
        rows.extend(part?);
    }
    Ok(rows)
}

/// Effort of a law relative to the others, for the progress bar.
fn effort(law: &Law, depth: Depth) -> u64 {
    u64::from(law.effort[usize::from(depth == Depth::Full)])
}

/// Writes `validation.json`, `table.md`, `laws.md` and the data of the figures into `folder`.
///
/// # Errors
/// When a file cannot be written.
pub fn write(rows: &[Row], depth: Depth, folder: &Path) -> Result<()> {
    let full = depth == Depth::Full;
    let json = serde_json::json!({
        "full": full, "provenance": Provenance::here(), "measurements": rows,
    });
    atomic::write(
        &folder.join("validation.json"),
        &serde_json::to_vec_pretty(&json)?,
    )?;
    let text = markdown(&table::cells(rows));
    atomic::write(&folder.join("table.md"), text.as_bytes())?;
    atomic::write(&folder.join("laws.md"), laws(rows).as_bytes())?;
    let folder = folder.join("data");
    data::scene_echoes(depth, &folder)?;
    data::curves().write(&folder.join("dispersion.csv"))?;
    data::measured()?.write(&folder.join("velocity.csv"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_that_are_measured_are_not_measured_again() {
        let results = tempfile::tempdir().unwrap();
        let resume = Resume::below(results.path(), Depth::Quick);
        let number = |x: f64| vec![Measurement::below("case".to_string(), "level, dB", x, 1.0)];
        let law = |name, measure| Law {
            name,
            effort: [1, 1],
            measure,
        };
        let laws = [
            law("known", |_| unreachable!("it is kept")),
            law("new", |_| {
                Ok(vec![Measurement::below(
                    "case".to_string(),
                    "level, dB",
                    2.0,
                    1.0,
                )])
            }),
        ];
        resume.write("known", &number(0.5)).unwrap();
        let rows = run(&laws, Depth::Quick, Some(&resume), false).unwrap();
        let said: Vec<_> = (rows.iter())
            .map(|row| (row.law, row.measurement.measured, row.passed))
            .collect();
        assert_eq!(said, [("known", 0.5, true), ("new", 2.0, false)]);
        assert_eq!(resume.read("new"), Some(number(2.0)));
        resume.write("new", &number(0.1)).unwrap();
        let anew = run(&laws[1..], Depth::Quick, Some(&resume), true).unwrap();
        assert_eq!(anew[0].measurement.measured, 2.0);
    }
}
